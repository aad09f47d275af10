"""What a few jump frequencies fix of a platform: too few to fit it, enough to tie it down.

A sweep jumps where the branch it follows folds back. Fold frequencies move with a parameter by
dΩ/dp = -ψᵀ ∂R/∂p / ψᵀ ∂R/∂Ω, ψ the left null vector of the balance there. The singular vectors of
these slopes, in units of the frequencies' resolution, are the combinations that the jumps fix.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from qzs_rig import scenario
from qzs_rig.errors import InputError
from qzs_rig.identification.intervals import Direction, directions
from qzs_rig.identification.unknowns import Unknowns, unknowns
from qzs_rig.parameters import RunSpec
from qzs_rig.samples import Array
from qzs_rig.theory.balance.frequency_response import frequency_response
from qzs_rig.theory.balance.harmonic_balance import HarmonicBalance, transmissibility
from qzs_rig.theory.oscillator import Oscillator

SHIFT = 1e-6
"""Of Ω and x, for the slope of g by differences: it only has to make Newton converge."""
HARMONICS = 9
"""Of the folds: good to 1e-4 here, where the frequencies are known to a twentieth."""
REACH = 2.5
"""Folds are looked for from so far below the jumps of a degree of freedom to so far above."""
STEPS = 200
STRIDE = 0.1
"""Largest relative change of a parameter in one step: folds come and go."""
KNOWN = 0.1
"""Relative standard deviation up to which a combination counts as fixed."""


@dataclass(frozen=True)
class Jump:
    """A measured jump; `resolution_hz` is the spacing of the readings it lies between."""

    dof: str
    kind: str
    frequency_hz: float
    resolution_hz: float

    @property
    def std(self) -> float:
        """Of a frequency that may lie anywhere between two readings."""
        return self.resolution_hz / 12**0.5


PAPER = (
    Jump('vertical', 'jump_down', 2.22, 0.32),
    Jump('vertical', 'jump_up', 1.90, 0.32),
    Jump('horizontal', 'jump_down', 4.43, 0.32),
    Jump('horizontal', 'jump_up', 4.12, 0.32),
)
"""Section 5.2 of the paper: forward and reverse, each also the isolation onset there."""


PAPER_UNKNOWNS = (
    'platform.C.vertical',
    'platform.C.horizontal',
    'platform.k1',
    'platform.A',
    'platform.k3_hat',
    'platform.L1_hat',
)


@dataclass(frozen=True)
class Fold:
    """Coefficients x (2H + 1,) of a motion at a fold, at `omega`."""

    omega: float
    x: Array


@dataclass(frozen=True)
class Fixed:
    """The platform nearest to the start whose jumps come closest to the measured ones, and what
    the jumps fix of it, best first. `predicted_hz` is NaN where the model has no such jump; `std`
    (p,) is the relative standard deviation of each parameter."""

    unknowns: Unknowns
    values: Array
    jumps: tuple[Jump, ...]
    predicted_hz: Array
    T: Array
    directions: tuple[Direction, ...]
    std: Array

    @property
    def determined(self) -> list[str]:
        """Names of the parameters that the jumps fix to KNOWN whatever the others are."""
        pairs = zip(self.unknowns.names, self.std.tolist(), strict=True)
        return [name for name, std in pairs if std <= KNOWN]

    @property
    def fixed(self) -> tuple[Direction, ...]:
        """The combinations known to KNOWN."""
        return tuple(d for d in self.directions if d.std <= KNOWN)


@dataclass(frozen=True)
class _Seen:
    predicted: Array
    T: Array
    slopes: Array
    folds: list[Fold | None]


def paper_spec(words: Mapping[str, Any]) -> RunSpec:
    """The paper's test, 0.1 m in both translations, with `words` on top."""
    base = {
        'excitation.quantity': 'displacement',
        'excitation.amplitude.vertical': 0.1,
        'excitation.amplitude.horizontal': 0.1,
    }
    return scenario.of(base).override(dict(words))


def fixed_by(spec: RunSpec, jumps: Sequence[Jump], names: Sequence[str]) -> Fixed:
    """What `jumps` fix of the parameters `names`.

    Gauss-Newton by the smallest relative change of the parameters in each of its short steps:
    scipy.optimize.least_squares leaps to where folds have vanished, and comes to a platform
    farther away (4.3 against 4.1 for the paper's jumps). Raises InputError where the start has
    none of the jumps: there is nothing to differentiate.
    """
    wanted = unknowns(spec, names, [jump.dof for jump in jumps])
    values = wanted.start
    here = _seen(wanted, values, jumps, _first(wanted, jumps))
    if here is None or np.isnan(here.predicted).all():
        raise InputError(
            'the platform jumps nowhere in the band; less damping or more excitation folds its '
            'curve: start nearer with --set'
        )
    shrink = 1.0
    for _ in range(STEPS):
        r, slopes = _scaled(here, wanted, jumps)
        if np.max(np.abs(r)) < 1e-3 or shrink < 1e-3:
            break
        step = np.linalg.lstsq(slopes, r, rcond=1e-3)[0]
        step *= shrink * min(1.0, STRIDE / max(float(np.max(np.abs(step))), 1e-12))
        trial = wanted.bounded(values + step * wanted.reference)
        there = _seen(wanted, trial, jumps, here.folds)
        if there is None or np.linalg.norm(_scaled(there, wanted, jumps)[0]) >= np.linalg.norm(r):
            shrink *= 0.5
            continue
        values, here, shrink = trial, there, min(1.0, 2 * shrink)
    _, slopes = _scaled(here, wanted, jumps)
    _, S, Vt = np.linalg.svd(slopes * (wanted.scale / wanted.reference), full_matrices=True)
    S = np.concatenate([S, np.zeros(len(values) - len(S))])[: len(values)]
    S = np.maximum(S, 1e-12 * max(float(S[0]), 1e-300))
    std = np.linalg.norm(Vt / S[:, None], axis=0) * wanted.scale / wanted.reference
    ways = directions(wanted, S, Vt)
    return Fixed(wanted, values, tuple(jumps), here.predicted, here.T, ways, std)


def fold_near(there: Oscillator, guess: Fold) -> Fold | None:
    """The fold that Newton finds from `guess`; None where it finds none near by.

    At a fold R(x, Ω) = 0 has a singular slope J = ∂R/∂x. Bordered by two fixed vectors,
    [J b; cᵀ 0] [v; g] = [0; 1], the number g vanishes there and J may be singular (Griewank and
    Reddien 1984; Kuznetsov, Elements of Applied Bifurcation Theory, section 10.2).
    """
    from scipy.optimize import root

    n, balance = len(guess.x), HarmonicBalance(there, len(guess.x) // 2)
    U, _, Vt = np.linalg.svd(balance.jacobian(guess.x, guess.omega))

    def unbalanced(ys: Array) -> Array:
        """R, then g, at each of ys (m, n + 1)."""
        x, omega = ys[:, :n], ys[:, n]
        bordered = np.zeros((len(ys), n + 1, n + 1))
        bordered[:, :n, :n] = balance.jacobian(x, omega)
        bordered[:, :n, n], bordered[:, n, :n] = U[:, -1], Vt[-1]
        unit = np.broadcast_to(np.eye(n + 1)[:, n:], (len(ys), n + 1, 1))
        g = np.linalg.solve(bordered, unit)[:, n]
        return np.hstack([balance.residual(x, omega), g])

    def slope(y: Array) -> Array:
        moved = unbalanced(np.vstack([y, y + SHIFT * np.eye(n + 1)]))
        return np.asarray((moved[1:] - moved[0]).T / SHIFT)

    # slopes anew at each step: those that Broyden keeps, as the default does, lose the fold
    found = root(
        lambda y: unbalanced(y[None])[0],
        np.append(guess.x, guess.omega),
        jac=slope,
        method='lm',
        tol=1e-12,
    )
    omega = float(found.x[n])
    if not (found.success and abs(omega / guess.omega - 1.0) < 0.5):
        return None
    return Fold(omega, found.x[:n])


def left_null(there: Oscillator, fold: Fold) -> Array:
    """The vector ψ (2H + 1,) with ψᵀ J = 0 at `fold`."""
    balance = HarmonicBalance(there, len(fold.x) // 2)
    return np.asarray(np.linalg.svd(balance.jacobian(fold.x, fold.omega))[0][:, -1])


def _scaled(seen: _Seen, wanted: Unknowns, jumps: Sequence[Jump]) -> tuple[Array, Array]:
    """Measured minus predicted over its deviation, and slopes by relative change; missing jumps
    say nothing."""
    std = np.array([jump.std for jump in jumps])
    measured = np.array([jump.frequency_hz for jump in jumps])
    r = np.nan_to_num((measured - seen.predicted) / std)
    return r, seen.slopes * wanted.reference / std[:, None]


def _first(wanted: Unknowns, jumps: Sequence[Jump]) -> list[Fold | None]:
    """The folds of the start that the jumps fall off, None where its curve does not fold."""
    folds: dict[str, list[Fold]] = {}
    for dof in dict.fromkeys(jump.dof for jump in jumps):
        there = Oscillator.driven(wanted.spec, dof)
        hz = np.array([jump.frequency_hz for jump in jumps if jump.dof == dof])
        low, high = there.omega(np.array([hz.min() / REACH, hz.max() * REACH])).tolist()
        answer = frequency_response(there, low, high, isolas=False)
        found = [
            Fold(event.omega, event.coefficients[: 2 * HARMONICS + 1]) for event in answer.folds
        ]
        folds[dof] = sorted(found, key=lambda fold: fold.omega)
    # of a hardening branch the upper end ends the upper branch, the lower end the lower one
    return [
        (
            folds[jump.dof][-1 if jump.kind == 'jump_down' else 0]
            if len(folds[jump.dof]) > 1
            else None
        )
        for jump in jumps
    ]


def _seen(
    wanted: Unknowns, values: Array, jumps: Sequence[Jump], near: Sequence[Fold | None]
) -> _Seen | None:
    """The jumps at `values`, from the folds `near` by; None where one of them is gone."""
    spec, folds = wanted.applied(values), []
    predicted, T = np.full(len(jumps), np.nan), np.full(len(jumps), np.nan)
    slopes = np.zeros((len(jumps), len(values)))
    for k, (jump, guess) in enumerate(zip(jumps, near, strict=True)):
        there = Oscillator.driven(spec, jump.dof)
        fold = fold_near(there, guess) if guess else None
        if guess and fold is None:
            return None
        folds.append(fold)
        if fold is not None:
            predicted[k] = fold.omega * there.hertz
            omega = np.array([fold.omega])
            T[k] = abs(transmissibility(there, omega, fold.x[None])[0])
            slopes[k] = _slopes(wanted, values, jump.dof, there, fold)
    return _Seen(predicted, T, slopes, folds)


def _slopes(wanted: Unknowns, values: Array, dof: str, there: Oscillator, fold: Fold) -> Array:
    """d(fold frequency in Hz)/dp (p,)."""
    x, hz = fold.x, fold.omega * there.hertz
    left = left_null(there, fold)

    def unbalanced(spec: RunSpec, frequency: float) -> float:
        other = Oscillator.driven(spec, dof)
        omega = float(other.omega(np.array(frequency)))
        return float(left @ HarmonicBalance(other, len(x) // 2).residual(x, omega))

    here, d = wanted.applied(values), 1e-5 * hz
    by_hz = (unbalanced(here, hz + d) - unbalanced(here, hz - d)) / (2 * d)
    return -wanted.slopes(lambda spec: unbalanced(spec, hz), values) / by_hz
