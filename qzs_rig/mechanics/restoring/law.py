"""What a restoring law is: formulas that serve scalars, arrays and compiled code alike."""

from __future__ import annotations

import math
import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import cache
from operator import itemgetter
from typing import Any

import numpy as np

from qzs_rig.mechanics.compiling import kept
from qzs_rig.parameters import Parameter
from qzs_rig.samples import Array
from qzs_rig.units import DOFS


def root(x: Any) -> Any:
    """Square root of a float, or of each of (n,)."""
    return math.sqrt(x) if isinstance(x, float) else np.sqrt(x)


class Design(tuple[Any, ...]):
    """The numbers that fix a restoring law: six of the platform, then those of the law's own
    `parameters`.

    A = k2/k1, k3 = k3/k1, L1 = L1/L20 < 1, L0 = L0/L20 are the stiffness and length ratios of the
    paper's section 3, from which a = sqrt(1 - L1²) and b = k3 L1 follow. Each is a number, or an
    array (n,) for n designs.
    """

    NAMES = ('A', 'k3', 'L1', 'L0', 'a', 'b')
    A, k3, L1, L0, a, b = (property(itemgetter(n)) for n in range(6))

    @classmethod
    def of(cls, A: float, k3: float, L1: float, L0: float, *own: float) -> Design:
        """The design of four ratios and the law's own numbers."""
        return cls((A, k3, L1, L0, root(1.0 - L1 * L1), k3 * L1, *own))

    @property
    def ratios(self) -> tuple[Any, ...]:
        """(A, k3, L1, L0, a, b), whatever the law."""
        return self[: len(self.NAMES)]

    @property
    def own(self) -> tuple[Any, ...]:
        """The numbers that only one law knows."""
        return self[len(self.NAMES) :]

    @property
    def named(self) -> dict[str, Any]:
        """`ratios` by their names."""
        return dict(zip(self.NAMES, self, strict=False))

    def replace(self, **ratios: float) -> Design:
        """This design with other A, k3, L1 or L0; a and b follow."""
        four = {name: self.named[name] for name in self.NAMES[:4]} | ratios
        return Design.of(*four.values(), *self.own)


PAPER_DESIGN = Design.of(A=1.1, k3=0.1, L1=math.sqrt(3.0) / 2.0, L0=0.1)
"""The paper's choice after Figure 9 (A = 1.1, k3 = 0.1, L1 = sqrt(3)/2, L0 = 0.1)."""

Root = Callable[[Any], Any]
Formula = Callable[[Any, Any], Any]
"""Net nondimensional force (or torque) of (numbers, w) at the relative motion w of one degree of
freedom; the payload's weight is balanced, so a law that is QZS vanishes at w = 0. Translations are
in units of L20 and, as in the paper, positive downward for `vertical`; rotations are in rad."""
Taylor = tuple[tuple[Any, Any, Any], ...]
ANYWHERE = (math.inf,) * 4

MANY = 200_000
"""Values from which compiled threads are worth waking."""
BLOCK = 65_536
"""Rows a task: few enough to share out evenly, many enough that handing out costs nothing."""


@dataclass(frozen=True)
class RestoringLaw:
    """One family of force and torque laws, in the order of DOFS.

    `taylor(design)` gives (c1, c2, c3) of c1 w + c2 w² + c3 w³ for each degree of freedom. Without
    `forces` these cubics are the law. `forces` are functions of a reciprocal square root, of which
    compiled code has a fast one, that return the force of (design, w); `slopes` are the
    derivatives for numpy. The law holds for |w| < `domain`. `weighted`: the source's vertical law
    carries the payload, F(0) = b; here it is taken off. `odd` names the degrees of freedom in
    which it pulls back alike on both sides.

    `parameters`, floats with a default named `platform.…`, are numbers of the law's own: they
    follow the six of Design in `design`. `couples` are what only the motion of six coupled degrees
    of freedom reads, of which the formulas are the projection; without, each moves by itself.
    """

    name: str
    source: str
    taylor: Callable[[Design], Taylor]
    forces: tuple[Callable[[Root], Formula], ...] | None = None
    slopes: tuple[Formula, ...] | None = None
    domain: tuple[float, ...] = ANYWHERE
    weighted: bool = True
    odd: tuple[str, ...] = ()
    parameters: tuple[Parameter, ...] = ()
    couples: tuple[Parameter, ...] = ()

    @property
    def count(self) -> int:
        """How many numbers the force of a degree of freedom takes."""
        return 3 if self.forces is None else len(Design.NAMES) + len(self.parameters)

    def numbers(self, design: Design, dof: int) -> tuple[Any, ...]:
        """What the force of a degree of freedom takes: a cubic's three coefficients, or the
        numbers of the design, whose law may be another."""
        return self.taylor(design)[dof] if self.forces is None else tuple(design[: self.count])

    def compilable(self, dof: int, rsqrt: Root) -> Formula:
        """The force of (numbers, w) in plain arithmetic around a reciprocal square root."""
        return cubic_force if self.forces is None else self.forces[dof](rsqrt)

    def along(self, dof: int, sqrt: Root = np.sqrt) -> Formula:
        """The force of (design, w) along a degree of freedom by a square root: numpy's for arrays,
        math's for numbers, cmath's for complex ones."""
        force = self.compilable(dof, lambda q: 1.0 / sqrt(q))
        return lambda design, w: force(self.numbers(design, dof), w)

    def stiffness_along(self, dof: int) -> Formula:
        """The slope of the force, of (design, w), along a degree of freedom, by numpy."""
        slope = cubic_stiffness if self.slopes is None else self.slopes[dof]
        return lambda design, w: slope(self.numbers(design, dof), w)

    def force(self, design: Design, w: Array) -> Array:
        """Force at w (..., 4) -> (..., 4), nondimensional, net of the static load.

        Many points are shared out to compiled threads where numba is installed, the same bits.
        """
        if w.size >= MANY and w.dtype == np.float64:
            try:
                return _in_threads(self, design, w)
            except ImportError:
                pass
        return np.stack([self.along(n)(design, w[..., n]) for n in range(len(DOFS))], axis=-1)

    def stiffness(self, design: Design, w: Array) -> Array:
        """Slope of `force` at w (..., 4) -> (..., 4)."""
        columns = [self.stiffness_along(n)(design, w[..., n]) for n in range(len(DOFS))]
        return np.stack(np.broadcast_arrays(*columns), axis=-1)

    def cubic(self, design: Design, rest: float = 0.0) -> tuple[tuple[float, float], ...]:
        """(c1, c3) of the odd part c1 w + c3 w³, which single-term theory uses, the vertical one
        about w = `rest`."""
        vertical, *others = ((c1, c3) for c1, _, c3 in self.taylor(design))
        if rest:
            # Cauchy's integral, exact to rounding: the laws are analytic within a of the real axis
            turn = 0.2 * design.a * np.exp(2j * np.pi * np.arange(64) / 64)
            force = self.along(0)(design, rest + turn)
            c1, c3 = (float(np.mean(force / turn**order).real) for order in (1, 3))
            vertical = (c1, c3)
        return vertical, *others

    def static_load(self, design: Design) -> tuple[float, ...]:
        """What the source's law is at w = 0, balanced by the payload's weight: b or nothing."""
        return (design.b if self.weighted else 0.0, 0.0, 0.0, 0.0)


def cubic_force(coefficients: Any, w: Any) -> Any:
    """c1 w + c2 w² + c3 w³; one formula, and one kernel, for all cubic laws."""
    c1, c2, c3 = coefficients
    return (c1 + (c2 + c3 * w) * w) * w


def cubic_stiffness(coefficients: Any, w: Any) -> Any:
    """Slope of `cubic_force`."""
    c1, c2, c3 = coefficients
    return c1 + (2.0 * c2 + 3.0 * c3 * w) * w


def rsqrt(q: Any) -> Any:
    """1/sqrt(q) of a number, the same bits in the interpreter and compiled."""
    return 1.0 / math.sqrt(q)


def fast_rsqrt(q: Any) -> Any:
    """1/sqrt(q) to 2e-14 for 1e-37 < q < 1e37: single precision and one Newton step.

    Only compiled code gains: processors estimate the single root without dividing.
    """
    r = np.float64(np.float32(1.0) / np.sqrt(np.float32(q)))
    return r * (1.5 - (0.5 * q) * (r * r))


@cache
def teach_numba() -> None:
    """Let numba compile both roots where a law calls them; ImportError where it is missing."""
    from numba.extending import register_jitable

    register_jitable(error_model='numpy')(rsqrt)
    register_jitable(error_model='numpy', fastmath={'contract', 'arcp', 'afn'})(fast_rsqrt)


@cache
def compiled(law: RestoringLaw) -> tuple[Any, ...]:
    """The four forces of (numbers, w) compiled by numba (no fast-math); ImportError where it is
    missing."""
    teach_numba()
    as_machine_code = kept(formula_type(law.count), error_model='numpy')
    return tuple(as_machine_code(law.compilable(dof, rsqrt)) for dof in range(len(DOFS)))


def formula_type(count: int) -> Any:
    """numba's type of a compiled force: `count` numbers and w to a number."""
    from numba import float64, types

    # numba's own types carry no annotations
    pack: Any = types.UniTuple
    return float64(pack(float64, count), float64)


def _in_threads(law: RestoringLaw, design: Design, w: Array) -> Array:
    forces, kernel = compiled(law), _kernel(law.count)
    rows, out = w.reshape(-1, len(DOFS)), np.empty((w.size // len(DOFS), len(DOFS)))

    def block(first: int) -> None:
        some = slice(first, first + BLOCK)
        for dof, force in enumerate(forces):
            kernel(force, law.numbers(design, dof), rows[some, dof], out[some, dof])

    with ThreadPoolExecutor(os.cpu_count()) as pool:
        list(pool.map(block, range(0, len(rows), BLOCK)))
    return out.reshape(w.shape)


@cache
def _kernel(count: int) -> Any:
    """A column of w through a function pointer, so that one compiled loop serves every law."""
    from numba import float64, types, void

    pack: Any = types.UniTuple
    column = float64[:]
    signature = void(types.FunctionType(formula_type(count)), pack(float64, count), column, column)
    return kept(signature)(_fill)


def _fill(force: Any, numbers: Any, w: Any, out: Any) -> None:
    for k in range(len(w)):
        out[k] = force(numbers, w[k])
