"""The frequency response of an oscillator: every branch with its stability, every event.

Branches are followed from motions that `search` finds at both ends of the range and between;
symmetry-broken ones from where they part.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from qzs_rig.errors import InputError
from qzs_rig.samples import Array
from qzs_rig.theory.balance import search
from qzs_rig.theory.balance.basis import harmonics_of
from qzs_rig.theory.balance.bifurcations import (
    Located,
    Stretch,
    crossing,
    falls,
    folds,
    locate,
    locate_once,
    losing,
    topping,
)
from qzs_rig.theory.balance.branch import BranchPath, Family
from qzs_rig.theory.balance.continuation import Ending
from qzs_rig.theory.balance.newton import one_thread
from qzs_rig.theory.oscillator import Oscillator

Progress = Callable[[float, str], None]
"""Called with the share of the work that is done, and what is under way."""


@dataclass(frozen=True)
class Branch:
    """Steady motions along a continuous path; `omega` (n,) may fold back. Where another parameter
    was followed, `value` (n,) is that one's and `omega` everywhere the same.

    `T` = |u/v| and `phase_deg` of u against v in (-180, 180], `amplitude` of w: of fundamentals.
    `coefficients` (n, 2H + 1) of w as in HarmonicBalance, of which `harmonics` (n,) were needed.
    `multipliers` (n, m): Floquet's. `symmetric`: all motions mirror themselves every half period.
    `ends`: why it ends at its first and its last point. `defect`: the most that any motion
    leaves unbalanced in twice the harmonics, over the drive; a large one marks an artefact of too
    few harmonics.
    """

    value: Array
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
    """`kind` 'fold', 'period_doubling' or 'symmetry_breaking' (of a coupled platform also
    'neimark_sacker') on branch number `branch`, where the followed parameter has `value`;
    `uncertainty` is the relative change of that by the last harmonics added."""

    value: float
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
    check(oscillator, low, high)
    tell = progress or (lambda share, text: None)
    span = search.Range(oscillator, low, high, harmonics, tolerance)
    return read_off(oscillator, low, high, search.paths(span, isolas, tell), tell)


@one_thread
def least_branch(
    oscillator: Oscillator, low: float, high: float, direction: str, harmonics: int | None = None
) -> FrequencyResponse:
    """Only the branch of the smallest motion at the high end of [low, high], or with `direction`
    'up' at the low one: where a sweep down or up begins. Raises as `frequency_response`."""
    check(oscillator, low, high)
    span = search.Range(oscillator, low, high, harmonics)
    paths = search.least_path(span, high if direction == 'down' else low)
    return read_off(oscillator, low, high, paths, lambda share, text: None)


def check(oscillator: Oscillator, low: float, high: float) -> None:
    """Raise InputError for a range or an amplitude that has no transmissibility."""
    if not 0.0 < low < high < np.inf:
        raise InputError(f'omega {low:g}:{high:g}: give a range that rises from above 0')
    if not oscillator.amplitude > 0.0:
        raise InputError('amplitude is 0: transmissibility needs a base that moves; give a small '
                         'one, 1e-6, for the linear limit')  # fmt: skip


def read_off(
    oscillator: Oscillator, low: float, high: float, paths: search.Found, tell: Progress
) -> FrequencyResponse:
    """Stability, events and onsets of paths over frequency, each with its equations."""
    branches, events, onset = [], [], []
    for number, (path, family) in enumerate(paths):
        tell(0.8 + 0.2 * number / len(paths), 'stability and events')
        branch, own = branch_of(path, family, number)
        branches.append(branch)
        events += own
        onset += [
            at.value
            for k in falls(branch.omega, branch.T, branch.stable).tolist()
            if (at := locate(Stretch.of(path, family, k), crossing)) is not None
        ]
    early = {str(end) for branch in branches for end in branch.ends if end.early}
    tell(1.0, 'done')
    return FrequencyResponse(
        oscillator,
        low,
        high,
        tuple(branches),
        tuple(events),
        tuple(sorted(onset)),
        '; '.join(sorted(early)) or (None if branches else 'no steady motion was found'),
        _peak(paths, branches, events),
    )


def branch_of(path: BranchPath, family: Family, number: int) -> tuple[Branch, list[Event]]:
    """What the motions of a path do, and its events, in their order; it is branch `number`."""
    balance = family(harmonics_of(path.coefficients))
    stability = balance.stability(path.value, path.coefficients)
    w = balance.relative(path.value, path.coefficients)
    ratio = 1.0 + (w[:, 1] - 1j * w[:, 2]) / balance.base(path.value)
    phase = np.degrees(np.angle(ratio))
    found = [(k, 'fold', at) for k, at in folds(path, family)]
    for k in stability.changes.tolist():
        stretch = Stretch.of(path, family, k)
        at = locate(stretch, losing) if balance.by_determinant else locate_once(stretch, losing)
        if at is not None:
            found.append((k, at.balance.kind(at.point), at))
    branch = Branch(
        value=path.value,
        omega=balance.frequency(path.value),
        T=np.abs(ratio),
        amplitude=np.hypot(w[:, 1], w[:, 2]),
        phase_deg=np.where(phase > -180.0, phase, 180.0),
        stable=stability.stable,
        coefficients=w,
        harmonics=path.harmonics,
        multipliers=stability.multipliers,
        symmetric=balance.odd,
        ends=path.ends,
        defect=balance.defect(path.value, path.coefficients),
    )
    found.sort(key=lambda event: event[0])
    return branch, [_event(at, kind, number) for _, kind, at in found]


def _event(at: Located, kind: str, number: int) -> Event:
    value = np.array([at.value])
    w = at.balance.relative(value, at.coefficients[None])[0]
    ratio = at.balance.along(at.point)[0]
    return Event(
        value=at.value,
        omega=float(at.balance.frequency(value)[0]),
        T=abs(ratio),
        kind=kind,
        amplitude=float(np.hypot(w[1], w[2])),
        phase_deg=float(np.degrees(np.angle(ratio))),
        branch=number,
        uncertainty=at.uncertainty,
        coefficients=w,
    )


def peak_among(branches: Sequence[Branch]) -> tuple[float, float] | None:
    """(Ω, T) of the stable point of largest T."""
    at = _highest(branches)
    return at and (float(branches[at[0]].omega[at[1]]), float(branches[at[0]].T[at[1]]))


def _highest(branches: Sequence[Branch]) -> tuple[int, int] | None:
    """Number of a branch and place on it."""
    found = [
        (float(b.T[k]), number, int(k))
        for number, b in enumerate(branches)
        for k in np.flatnonzero(b.stable)
    ]
    return max(found)[1:] if found else None


def _peak(
    paths: search.Found, branches: Sequence[Branch], events: Sequence[Event]
) -> tuple[float, float] | None:
    """About the highest point: where T stands still between stable points, or its branch folds."""
    at = _highest(branches)
    if at is None:
        return None
    number, k = at
    branch = branches[number]

    def candidates() -> Iterator[tuple[float, float]]:
        yield float(branch.omega[k]), float(branch.T[k])
        for place in range(max(k - 1, 0), min(k + 1, len(branch.omega) - 1)):
            if branch.stable[place] and branch.stable[place + 1]:
                top = locate_once(Stretch.of(*paths[number], place), topping)
                if top is not None:
                    yield top.value, abs(top.balance.along(top.point)[0])
            reach = abs(branch.omega[place + 1] - branch.omega[place])
            for event in events:
                near = abs(event.omega - branch.omega[k]) <= reach
                if (event.kind, event.branch) == ('fold', number) and near:
                    yield event.omega, event.T

    return max(candidates(), key=lambda each: each[1])
