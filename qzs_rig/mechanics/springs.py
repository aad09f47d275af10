"""Springs of the platform: leaf (Eqs 1-3), inclined suspension (4), helical (33), their strength.

SI throughout. Strength: Wahl's factor, EN 13906-1 for helical springs, EN 10270-1 for their wire.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

STEEL_E = 2.0e11
"""Young's modulus of the leaf, Pa."""
STEEL_G = 79.38e9
"""Shear modulus of Table 3, Pa (79 380 N/mm²)."""
STEEL_DENSITY = 7850.0
"""kg/m³."""
ALLOWED = {'compression': 0.56, 'tension': 0.45}
"""Shear stress over tensile strength: EN 13906-1 (at solid length) and EN 13906-2."""
ENDS = {'fixed': 0.5, 'hinged': 1.0, 'free': 2.0}
"""Seating coefficient of EN 13906-1; the platform's hooks and spherical hinges are `hinged`."""


@dataclass(frozen=True)
class Leaf:
    """A cantilever of width b, thickness h and length l."""

    b: float
    h: float
    length: float
    E: float = STEEL_E

    @property
    def J(self) -> float:
        """(1): second moment of area b h³/12, m⁴."""
        return self.b * self.h**3 / 12.0

    def rotation(self, force: float) -> float:
        """(2): rotation of the loaded end, rad: 6 F l²/(E b h³)."""
        return 6.0 * force * self.length**2 / (self.E * self.b * self.h**3)

    def force(self, rotation: float) -> float:
        """(3): force that rotates the end, N: E b h³ alpha/(6 l²)."""
        return self.E * self.b * self.h**3 * rotation / (6.0 * self.length**2)

    @property
    def stiffness(self) -> float:
        """k3 as the paper means it below (7), N/m: force (3) at rotation 1 over length."""
        return self.force(1.0) / self.length

    def bending_stress(self, force: float) -> float:
        """At the clamped end, Pa: 6 F l/(b h²)."""
        return 6.0 * force * self.length / (self.b * self.h**2)

    @classmethod
    def of_stiffness(cls, k3: float, b: float, length: float, E: float = STEEL_E) -> Leaf:
        """The thickness that gives k3."""
        return cls(b, (6.0 * k3 * length**3 / (E * b)) ** (1.0 / 3.0), length, E)


@dataclass(frozen=True)
class Suspension:
    """(4): a spring of rate k and free length L0, inclined by alpha0 in the initial state."""

    k: float
    L0: float
    alpha0: float

    def length(self, x: float) -> float:
        """Length when the plate has come down by x; its foot does not move."""
        return math.hypot(self.L0 * math.sin(self.alpha0) - x, self.L0 * math.cos(self.alpha0))

    def force(self, x: float) -> float:
        """Along the spring, compression positive: k (L0 - L1)."""
        return self.k * (self.L0 - self.length(x))


@dataclass(frozen=True)
class Helical:
    """Wire diameter d, mean coil diameter D, n active coils; `kind` compression or tension."""

    d: float
    D: float
    n: float
    kind: str = 'compression'
    G: float = STEEL_G

    @property
    def rate(self) -> float:
        """(33): G d⁴/(8 n D³), N/m."""
        return self.G * self.d**4 / (8.0 * self.n * self.D**3)

    @property
    def index(self) -> float:
        """D/d; coilers make 4 to 16."""
        return self.D / self.d

    @property
    def wahl(self) -> float:
        """Wahl's factor for curvature and direct shear: (4w - 1)/(4w - 4) + 0.615/w."""
        w = self.index
        return (4.0 * w - 1.0) / (4.0 * w - 4.0) + 0.615 / w

    def shear_stress(self, force: float) -> float:
        """Largest in the wire, Pa: Wahl's factor times 8 F D/(pi d³)."""
        return self.wahl * 8.0 * force * self.D / (math.pi * self.d**3)

    @property
    def allowable(self) -> float:
        """Shear stress allowed for SH wire of this diameter, Pa."""
        return ALLOWED[self.kind] * tensile_strength(self.d)

    @property
    def outside(self) -> float:
        """Outside diameter, m."""
        return self.D + self.d

    @property
    def coils(self) -> float:
        """All coils: two more than active ones where ends are closed and ground."""
        return self.n + 2.0 if self.kind == 'compression' else self.n

    @property
    def solid_length(self) -> float:
        """Coil on coil, m; the body of a tension spring that is not loaded."""
        return (self.coils if self.kind == 'compression' else self.n + 1.0) * self.d

    @property
    def least_gap(self) -> float:
        """Sum of gaps that must stay at full load, EN 13906-1: n (0.0015 D²/d + 0.1 d), mm."""
        D, d = 1e3 * self.D, 1e3 * self.d
        return 1e-3 * self.n * (0.0015 * D * D / d + 0.1 * d)

    @property
    def mass(self) -> float:
        """Of the wire in the coils, kg."""
        return STEEL_DENSITY * math.pi * self.d**2 / 4.0 * math.pi * self.D * self.coils

    def buckling_deflection(self, free_length: float, ends: str, E: float = 2.06e11) -> float:
        """Compression at which the spring bows out, EN 13906-1, m; infinite where it never does."""
        if self.kind != 'compression':
            return math.inf
        ratio = self.G / E
        slender = math.pi * self.D / (ENDS[ends] * free_length)
        inside = 1.0 - (1.0 - ratio) / (0.5 + ratio) * slender**2
        if inside <= 0.0:
            return math.inf
        return free_length * 0.5 / (1.0 - ratio) * (1.0 - math.sqrt(inside))


CENTRAL = Helical(d=0.010, D=0.060, n=23, kind='tension')
"""Table 3."""
SUSPENSION = Helical(d=0.008, D=0.035, n=42)
"""Table 3."""
PAPER_LEAF = Leaf(b=0.080, h=0.002, length=0.6)
"""Table 3, as long as the suspension spring (7)."""


def tensile_strength(d: float) -> float:
    """Least Rm of EN 10270-1 SH spring wire of diameter d (m), Pa: 2220 - 820 lg d/mm."""
    return 1e6 * (2220.0 - 820.0 * math.log10(1e3 * d))
