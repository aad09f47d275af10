"""What theory says of a run, before it begins: every branch, in the rig's units."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from qzs_rig.excitation.sweep import band
from qzs_rig.mechanics.platform import coupled
from qzs_rig.parameters import RunSpec
from qzs_rig.prediction import curve
from qzs_rig.prediction.curve import Branch, Prediction
from qzs_rig.samples import Array
from qzs_rig.theory.balance.bifurcations import turns
from qzs_rig.theory.balance.frequency_response import Branch as SteadyBranch
from qzs_rig.theory.balance.frequency_response import Event, FrequencyResponse, frequency_response
from qzs_rig.theory.balance.single_term_response import single_term_response
from qzs_rig.theory.oscillator import Oscillator
from qzs_rig.units import DOFS

FINER = 12
"""Points drawn for one that was computed: a continued path is smooth in its length."""
MARGIN = 1.02
"""Theory goes a little beyond the band of the run."""
MOMENTS = 256
"""Times a period at which the stroke is looked for; it is missed by less than 1e-4 of itself."""


def predict(spec: RunSpec) -> tuple[Prediction, ...]:
    """One prediction for each driven degree of freedom of the run `spec`, in their order.

    By harmonic balance of the restoring law; where that finds nothing, by one harmonic of its
    cubic part, and `method` says so. A coupled platform is predicted by its four projections.
    """
    driven = [dof for dof in DOFS if spec.number(f'excitation.amplitude.{dof}')]
    return tuple(_predict(spec, Oscillator.driven(spec, dof), *range_hz(spec)) for dof in driven)


def range_hz(spec: RunSpec) -> tuple[float, float]:
    """Lowest and highest frequency to predict: a little beyond the band of the run, an octave
    around a dwell."""
    if spec.text('excitation.kind') == 'sine':
        f = spec.number('excitation.frequency')
        low, high = 0.5 * f, 2.0 * f
    else:
        low, high = band(spec)
    return low / MARGIN, high * MARGIN


def _predict(spec: RunSpec, own: Oscillator, low_hz: float, high_hz: float) -> Prediction:
    found = by_harmonic_balance(own, low_hz, high_hz)
    if not found.branches:
        found = by_single_term(own, low_hz, high_hz)
    return replace(found, label=f'{found.label}, uncoupled') if coupled(spec) else found


def by_harmonic_balance(own: Oscillator, low_hz: float, high_hz: float) -> Prediction:
    """The branches of `own` that reach an end of the range, none where nothing was found."""
    # a run waits for this, and isolated branches can take minutes to look for
    found = frequency_response(own, own.omega(low_hz), own.omega(high_hz), isolas=False)
    branches = [
        piece
        for number, branch in enumerate(found.branches)
        for piece in _pieces(_path(branch, _folds(found, number), own.rest), own)
    ]
    return _prediction(
        found, branches, low_hz, high_hz, 'theory, harmonic balance', 'harmonic_balance'
    )


def by_single_term(own: Oscillator, low_hz: float, high_hz: float) -> Prediction:
    """The motions of `own` in one harmonic of the cubic part of its law."""
    found = single_term_response(own, own.omega(low_hz), own.omega(high_hz))
    branches = [
        Branch('', b.omega * own.hertz, b.T, b.phase_deg, b.amplitude * own.length, b.stable)
        for b in found.branches
    ]
    return _prediction(found, branches, low_hz, high_hz, 'theory, one harmonic', 'single_term')


def _prediction(
    found: FrequencyResponse,
    branches: list[Branch],
    low_hz: float,
    high_hz: float,
    label: str,
    method: str,
) -> Prediction:
    own, known = found.oscillator, curve.named(branches)
    onset_hz = tuple(omega * own.hertz for omega in found.onset_omega)
    return Prediction(own.dof, label, method, known, curve.folds(known, low_hz, high_hz), onset_hz)


@dataclass(frozen=True)
class _Path:
    """Columns (n,) in the order of the path: ln Ω, u/v of the fundamentals, stroke; `folds` are
    places among them."""

    log_omega: Array
    ratio: NDArray[np.complex128]
    stroke: Array
    stable: NDArray[np.bool_]
    folds: tuple[int, ...]


def _folds(found: FrequencyResponse, number: int) -> list[Event]:
    return [event for event in found.folds if event.branch == number]


def _path(branch: SteadyBranch, folds: list[Event], rest: float) -> _Path:
    """The branch with its folds put in where the frequency turns."""
    omega, stable = branch.omega, branch.stable
    columns = [omega, branch.T, np.radians(branch.phase_deg)]
    columns.append(_stroke(branch.coefficients, rest))
    turning = turns(omega).tolist()
    if len(turning) != len(folds):  # one could not be located: the turning point stands for it
        return _as_path(columns, stable, turning)
    places = [k if abs(omega[k - 1] - fold.omega) < abs(omega[k + 1] - fold.omega) else k + 1
              for k, fold in zip(turning, folds, strict=True)]  # fmt: skip
    for column, values in zip(
        range(4),
        (
            [fold.omega for fold in folds],
            [fold.T for fold in folds],
            [np.radians(fold.phase_deg) for fold in folds],
            [float(_stroke(fold.coefficients[None], rest)[0]) for fold in folds],
        ),
        strict=True,
    ):
        columns[column] = np.insert(columns[column], places, values)
    stable = np.insert(stable, places, False)
    return _as_path(columns, stable, [place + k for k, place in enumerate(places)])


def _as_path(columns: list[Array], stable: NDArray[np.bool_], folds: list[int]) -> _Path:
    omega, T, phase, stroke = columns
    return _Path(np.log(omega), T * np.exp(1j * phase), stroke, stable, tuple(folds))


def _stroke(coefficients: Array, rest: float) -> Array:
    """Largest |ŵ - rest| of a period, (n,), from (n, 2H + 1)."""
    orders = np.arange(1, (coefficients.shape[1] + 1) // 2)
    angle = 2 * np.pi * np.outer(orders, np.arange(MOMENTS)) / MOMENTS
    wave = coefficients[:, 1::2] @ np.cos(angle) + coefficients[:, 2::2] @ np.sin(angle)
    return np.asarray(np.abs(wave + coefficients[:, :1] - rest).max(axis=1))


def _pieces(path: _Path, own: Oscillator) -> list[Branch]:
    """The path cut at its folds, made finer by a spline along its length."""
    last = len(path.stroke) - 1
    along = np.concatenate([[0.0], np.cumsum(_lengths(path))])
    return [
        _piece(path, along, first, end, own)
        for first, end in pairwise([0, *path.folds, last])
        if abs(path.log_omega[end] - path.log_omega[first]) > curve.EDGE
    ]


def _lengths(path: _Path) -> Array:
    steps = [np.diff(path.log_omega), np.abs(np.diff(np.log(path.ratio)))]
    return np.asarray(np.maximum(np.hypot(*steps), 1e-12))


def _piece(path: _Path, along: Array, first: int, end: int, own: Oscillator) -> Branch:
    log_omega, real, imag, stroke = _spline(along, path)(_finer(along[first : end + 1])).T
    f = np.exp(log_omega)
    edge = np.exp(path.log_omega[[first, end]])
    f = np.clip(f, edge.min(), edge.max())  # a spline may swing beyond the fold it ends in
    f = np.maximum.accumulate(f if edge[1] > edge[0] else f[::-1])
    way = slice(None, None, 1 if edge[1] > edge[0] else -1)
    ratio = (real + 1j * imag)[way]
    phase = np.degrees(np.angle(ratio))
    steady = path.stable[first : end + 1].copy()
    # a fold is as stable as what it ends
    steady[0] = steady[1] if first in path.folds else steady[0]
    steady[-1] = steady[-2] if end in path.folds else steady[-1]
    both = np.repeat(steady[:-1] & steady[1:], FINER)
    stable = np.append(both, steady[-1]) & np.insert(both, 0, steady[0])
    return Branch(
        '',
        f * own.hertz,
        np.abs(ratio),
        np.where(phase > -180.0, phase, 180.0),
        own.length * stroke[way],
        stable[way],
    )


def _spline(along: Array, path: _Path) -> Callable[[Array], Array]:
    """ln Ω, both parts of the ratio and the stroke (m, 4) at places (m,) along the path."""
    from scipy.interpolate import CubicSpline

    columns = np.stack([path.log_omega, path.ratio.real, path.ratio.imag, path.stroke], axis=1)
    spline: Callable[[Array], Array] = CubicSpline(along, columns)
    return spline


def _finer(along: Array) -> Array:
    inner = along[:-1, None] + np.diff(along)[:, None] * np.arange(FINER) / FINER
    return np.append(inner.ravel(), along[-1])
