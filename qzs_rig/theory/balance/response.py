"""The frequency response of an oscillator: every branch with its stability, every event.

Branches are followed from motions that `seeds` finds at both ends of the range and between;
symmetry-broken ones from where they part.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from qzs_rig.errors import InputError
from qzs_rig.samples import Array
from qzs_rig.theory.balance import search
from qzs_rig.theory.balance.basis import harmonics_of, resized
from qzs_rig.theory.balance.branch import BranchPath
from qzs_rig.theory.balance.continuation import Ending
from qzs_rig.theory.balance.events import (
    Located,
    Stretch,
    Zero,
    crossing,
    doubling,
    falls,
    folds,
    locate,
    locate_once,
    topping,
    turning,
)
from qzs_rig.theory.balance.harmonic_balance import (
    BalanceEquations,
    HarmonicBalance,
    transmissibility,
)
from qzs_rig.theory.balance.one_thread import one_thread
from qzs_rig.theory.balance.stability import Floquet, floquet
from qzs_rig.theory.oscillator import Oscillator

Progress = Callable[[float, str], None]
"""Called with the share of the work that is done, and what is under way."""


@dataclass(frozen=True)
class Branch:
    """Steady motions along a continuous path; `omega` (n,) may fold back.

    `T` = |u/v| and `phase_deg` of u against v in (-180, 180], `amplitude` of w: of fundamentals.
    `coefficients` (n, 2H + 1) as in HarmonicBalance, of which `harmonics` (n,) were needed.
    `multipliers` (n, 2): Floquet's. `symmetric`: all motions mirror themselves every half period.
    `ends`: why it ends at its first and its last point. `defect`: the most that any motion
    leaves unbalanced in twice the harmonics, over the drive; a large one marks an artefact of too
    few harmonics.
    """

    omega: Array
    T: Array
    amplitude: Array
    phase_deg: Array
    stable: NDArray[np.bool_]
    coefficients: Array
    harmonics: NDArray[np.int64]
    multipliers: NDArray[np.complex128]
    symmetric: bool
    ends: tuple[Ending, Ending]
    defect: float = 0.0


@dataclass(frozen=True)
class Event:
    """`kind` 'fold', 'period_doubling' or 'symmetry_breaking' on branch number `branch`;
    `uncertainty` is the relative change of omega by the last harmonics added."""

    omega: float
    T: float
    kind: str
    amplitude: float
    phase_deg: float
    branch: int
    uncertainty: float
    coefficients: Array


@dataclass(frozen=True)
class FrequencyResponse:
    """All branches found within [low, high], events by branch, `onset_omega` ascending: where T of
    stable motion falls below 1 as frequency rises. `reason` says where a branch ended early.
    `peak` is (Ω, T) of the largest T on a stable branch, None where nothing is stable."""

    oscillator: Oscillator
    low: float
    high: float
    branches: tuple[Branch, ...]
    events: tuple[Event, ...]
    onset_omega: tuple[float, ...]
    reason: str | None
    peak: tuple[float, float] | None = None

    @property
    def folds(self) -> tuple[Event, ...]:
        """Events of kind 'fold'."""
        return tuple(event for event in self.events if event.kind == 'fold')

    @property
    def harmonics(self) -> int:
        """The most that any motion needed."""
        return max((int(branch.harmonics.max()) for branch in self.branches), default=0)


def highest(branches: Sequence[Branch]) -> tuple[int, int] | None:
    """Number of a branch and place on it: the point of largest T that is stable."""
    found = [
        (float(b.T[k]), number, int(k))
        for number, b in enumerate(branches)
        for k in np.flatnonzero(b.stable)
    ]
    return max(found)[1:] if found else None


def peak_among(branches: Sequence[Branch]) -> tuple[float, float] | None:
    """(Ω, T) of the highest stable point."""
    at = highest(branches)
    return at and (float(branches[at[0]].omega[at[1]]), float(branches[at[0]].T[at[1]]))


@one_thread
def frequency_response(
    oscillator: Oscillator,
    low: float,
    high: float,
    *,
    harmonics: int | None = None,
    tolerance: float = 1e-10,
    isolas: bool = True,
    progress: Progress | None = None,
) -> FrequencyResponse:
    """Every branch over Ω in [low, high].

    `harmonics` None takes as many as each motion needs; `isolas` looks for isolated branches too
    (the same seeds every time). Raises InputError for a range or an amplitude that has no
    transmissibility. A branch that ends early keeps its points and says why.
    """
    _check(oscillator, low, high)
    tell = progress or (lambda share, text: None)
    span = search.Range(oscillator, low, high, harmonics, tolerance)
    found = _read_off(span, search.paths(span, isolas, tell), tell)
    tell(1.0, 'done')
    return found


@one_thread
def least_branch(
    oscillator: Oscillator, low: float, high: float, direction: str, harmonics: int | None = None
) -> FrequencyResponse:
    """Only the branch of the smallest motion at the high end of [low, high], or with `direction`
    'up' at the low one: where a sweep down or up begins. Raises as `frequency_response`."""
    _check(oscillator, low, high)
    span = search.Range(oscillator, low, high, harmonics)
    path = search.least_path(span, high if direction == 'down' else low)
    return _read_off(span, [] if path is None else [path], lambda share, text: None)


def _check(oscillator: Oscillator, low: float, high: float) -> None:
    if not 0.0 < low < high < np.inf:
        raise InputError(f'omega {low:g}:{high:g}: give a range that rises from above 0')
    if not oscillator.amplitude > 0.0:
        raise InputError('amplitude is 0: transmissibility needs a base that moves; give a small '
                         'one, 1e-6, for the linear limit')  # fmt: skip


def _read_off(span: search.Range, paths: search.Found, tell: Progress) -> FrequencyResponse:
    """Stability, events and onsets of the paths of a range."""
    oscillator = span.oscillator
    tell(0.8, 'events')
    floquets = [floquet(oscillator, path.omega, path.coefficients, odd) for path, odd in paths]
    branches = tuple(
        _branch(oscillator, *path, own) for path, own in zip(paths, floquets, strict=True)
    )
    events = tuple(
        event
        for k, (branch, own) in enumerate(zip(branches, floquets, strict=True))
        for event in _events(oscillator, k, branch, own)
    )
    onset = sorted(w for branch in branches for w in _onsets(oscillator, branch))
    early = {str(end) for b in branches for end in b.ends if end.early}
    return FrequencyResponse(
        oscillator,
        span.low,
        span.high,
        branches,
        events,
        tuple(onset),
        '; '.join(sorted(early)) or (None if branches else 'no steady motion was found'),
        _peak(oscillator, branches, events),
    )


def _peak(
    oscillator: Oscillator, branches: Sequence[Branch], events: Sequence[Event]
) -> tuple[float, float] | None:
    """About the highest point: where T stands still between stable points, or its branch folds."""
    at = highest(branches)
    if at is None:
        return None
    number, k = at
    branch, found = branches[number], [peak_among(branches)]
    for place in range(max(k - 1, 0), min(k + 1, len(branch.omega) - 1)):
        reach = abs(branch.omega[place + 1] - branch.omega[place])
        if branch.stable[place] and branch.stable[place + 1]:
            stretch = _stretch(oscillator, branch, place)
            top = locate_once(stretch, topping, stretch.harmonics)
            if top is not None:
                event = _event(oscillator, 'peak', number, top)
                found.append((event.omega, event.T))
        found += [
            (event.omega, event.T)
            for event in events
            if (event.kind, event.branch) == ('fold', number)
            and abs(event.omega - branch.omega[k]) <= reach
        ]
    return max((each for each in found if each), key=lambda each: each[1])


def _branch(oscillator: Oscillator, path: BranchPath, odd: bool, floquets: Floquet) -> Branch:
    ratio = transmissibility(oscillator, path.omega, path.coefficients)
    phase = np.degrees(np.angle(ratio))
    return Branch(
        omega=path.omega,
        T=np.abs(ratio),
        amplitude=np.hypot(path.coefficients[:, 1], path.coefficients[:, 2]),
        phase_deg=np.where(phase > -180.0, phase, 180.0),
        stable=floquets.stable,
        coefficients=path.coefficients,
        harmonics=path.harmonics,
        multipliers=floquets.multipliers,
        symmetric=odd,
        ends=path.ends,
        defect=_defect(oscillator, path),
    )


def _defect(oscillator: Oscillator, path: BranchPath) -> float:
    harmonics = 2 * harmonics_of(path.coefficients)
    left = HarmonicBalance(oscillator, harmonics).residual(
        resized(path.coefficients, harmonics), path.omega
    )
    return float((np.linalg.norm(left, axis=1) / oscillator.drive(path.omega)).max())


def _events(oscillator: Oscillator, number: int, branch: Branch, floquets: Floquet) -> list[Event]:
    found: list[tuple[int, Event]] = []
    for place, at in folds(branch.omega, lambda k: _at(oscillator, branch, k, turning)):
        found.append((place, _event(oscillator, 'fold', number, at)))
    kind = 'symmetry_breaking' if branch.symmetric else 'period_doubling'
    other = floquets.other
    for k in np.flatnonzero((other[:-1] > 0) != (other[1:] > 0)):
        located = _at(oscillator, branch, int(k), doubling)
        if located is not None:
            found.append((int(k), _event(oscillator, kind, number, located)))
    return [event for _, event in sorted(found, key=lambda pair: pair[0])]


def _onsets(oscillator: Oscillator, branch: Branch) -> list[float]:
    places = falls(branch.omega, branch.T, branch.stable)
    located = (_at(oscillator, branch, int(k), crossing) for k in places)
    return [place.omega for place in located if place is not None]


def _at(oscillator: Oscillator, branch: Branch, k: int, zero: Zero) -> Located | None:
    return locate(_stretch(oscillator, branch, k), zero)


def _stretch(oscillator: Oscillator, branch: Branch, k: int) -> Stretch:
    pair = slice(k, k + 2)
    unknowns = partial(BalanceEquations, oscillator, odd=branch.symmetric)
    harmonics = int(branch.harmonics[pair].max())
    return Stretch(unknowns, branch.omega[pair], branch.coefficients[pair], harmonics)


def _event(oscillator: Oscillator, kind: str, number: int, located: Located) -> Event:
    x = located.coefficients
    ratio = transmissibility(oscillator, np.array([located.omega]), x[None])[0]
    return Event(
        located.omega,
        float(abs(ratio)),
        kind,
        float(np.hypot(x[1], x[2])),
        float(np.degrees(np.angle(ratio))),
        number,
        located.uncertainty,
        x,
    )
