"""Identification as a whole: fit, check the harmonics, weigh other solutions, draw the limits."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from qzs_rig.errors import InputError
from qzs_rig.identification.fit import DataSet, Fit
from qzs_rig.identification.intervals import LEVEL, Covariance, Interval, covariance, intervals
from qzs_rig.identification.minima import HARMONICS, cost, fits, idle
from qzs_rig.identification.point_response import Response, followed, iso_limit
from qzs_rig.identification.points import Points
from qzs_rig.identification.unknowns import TRIM, unknowns
from qzs_rig.parameters import RunSpec
from qzs_rig.samples import Array

WIDE = 4.0
"""Half an interval over the standard error that a parameter is still worth (see Unknowns.scale)."""
MOST_HARMONICS = 31
TRUNCATION = 0.3
"""Of the noise: what leaving out higher harmonics may change at any point."""
RULED_OUT = 0.99
"""Confidence with which another solution must be worse: stricter than the intervals, since their
own 5 % come on top."""
FEW = 0.8
"""Share of the points that must count, below which the user is warned."""


@dataclass(frozen=True)
class Advice:
    """`action` is add, remove, leave or unknown; `grams` what brings the plate back, with its
    95 % interval `low` to `high`, all positive when added."""

    action: str
    grams: float
    low: float
    high: float
    text: str


@dataclass(frozen=True)
class Identified:
    """The best fit, how well it is known, and what else would fit about as well."""

    fit: Fit
    known: Covariance
    intervals: tuple[Interval, ...]
    others: tuple[Fit, ...]
    harmonics: int
    cautions: tuple[str, ...]

    @property
    def spec(self) -> RunSpec:
        """The run with the fitted values."""
        return self.fit.unknowns.applied(self.fit.values)

    @property
    def reduced_chi_square(self) -> float | None:
        """Of standard deviations that came with the measurement; None where the fit found them."""
        fit = self.fit
        return float(fit.residual @ fit.residual) / fit.freedom if fit.weighted else None

    @property
    def advice(self) -> Advice | None:
        """About the payload, where its trim was fitted."""
        names = self.fit.unknowns.names
        if TRIM not in names:
            return None
        k = names.index(TRIM)
        return advice(float(self.fit.values[k]), self.intervals[k])


def identify(spec: RunSpec, parts: Sequence[Points], names: Sequence[str]) -> Identified:
    """Fit the parameters `names` of `spec` to the measured `parts`, one a degree of freedom.

    Raises InputError where the points cannot tell: too few, or a parameter that moves none.
    """
    wanted = unknowns(spec, names, [points.dof for points in parts])
    for name in idle(wanted, parts):
        dofs = ', '.join(points.dof for points in parts)
        raise InputError(
            f'{name} moves none of the measured points ({dofs}); leave it out of --fit'
        )
    harmonics = HARMONICS
    found = fits(wanted, parts, harmonics)
    while harmonics < MOST_HARMONICS and _truncated(found[0], harmonics):
        harmonics = 2 * harmonics + 1
        found = fits(replace(wanted, start=found[0].values), parts, harmonics)
    best = found[0]
    if best.freedom < 1:
        raise InputError(
            f'{len(best.residual)} usable readings cannot fix {len(names)} parameters; '
            'fit fewer, or measure more points'
        )
    known = covariance(best)
    ruled_out = _chi_square(RULED_OUT, 1)
    rivals = tuple(o for o in found[1:] if cost(o, best) - cost(best, best) < ruled_out)
    limits = _hull(intervals(best, known), rivals, best.unknowns.scale)
    return Identified(
        best, known, limits, rivals, harmonics, _cautions(best, known, rivals, limits)
    )


def _truncated(fit: Fit, harmonics: int) -> bool:
    """Whether twice the harmonics would move a point by more than its noise allows."""
    for item, response in zip(fit.sets, fit.responses, strict=True):
        x = np.zeros((len(item.points), 4 * harmonics + 3))
        x[:, : response.x.shape[1]] = response.x
        finer = followed(response.plant, item.points.frequency_hz, x)
        coarse, fine = (item.residuals(r.ratio)[0] for r in (response, finer))
        counted = item.counted & np.tile(finer.good & response.good, 2)
        if np.any(np.abs(fine - coarse)[counted] > TRUNCATION):
            return True
    return False


def _hull(
    limits: tuple[Interval, ...], rivals: tuple[Fit, ...], scale: Array
) -> tuple[Interval, ...]:
    """The intervals, stretched over what other solutions need; one of more than WIDE `scale`s to
    either side determines nothing."""
    stretched = list(limits)
    for other in rivals:
        for k, own in enumerate(intervals(other, covariance(other))):
            low, high = min(stretched[k].low, own.low), max(stretched[k].high, own.high)
            stretched[k] = replace(stretched[k], low=low, high=high, method='all solutions')
    return tuple(
        replace(own, determined=own.determined and own.high - own.low <= 2.0 * WIDE * worth)
        for own, worth in zip(stretched, scale.tolist(), strict=True)
    )


def _cautions(
    fit: Fit, known: Covariance, rivals: tuple[Fit, ...], limits: tuple[Interval, ...]
) -> tuple[str, ...]:
    said = []
    names = fit.unknowns.names
    vague = [name for name, limit in zip(names, limits, strict=True) if not limit.determined]
    if vague:
        said.append(
            f'the points do not determine {", ".join(vague)}; see what combinations they fix'
        )
    if rivals:
        each = '; '.join(_values(one) for one in (fit, *rivals))
        said.append(
            f'{len(rivals) + 1} solutions fit alike: {each}. The intervals span them all; phases, '
            'or points nearer to the jumps, would tell them apart'
        )
    if known.excess > _chi_square(LEVEL, fit.freedom) / fit.freedom:
        said.append(
            f'the fit misses by {known.excess**0.5:.2f} times the standard deviations given; '
            'the intervals are widened by that. The law may not be the right one'
        )
    bound = fit.unknowns.at_bound(fit.values)
    if bound:
        said.append(f'{", ".join(bound)} ended at a bound; its interval is one-sided')
    pairs = zip(fit.sets, fit.responses, strict=True)
    return tuple(said + [text for pair in pairs for text in _points_said(*pair)])


def _values(fit: Fit) -> str:
    pairs = zip(fit.unknowns.names, fit.values.tolist(), strict=True)
    return ', '.join(f'{name} = {value:.4g}' for name, value in pairs)


def _points_said(item: DataSet, response: Response) -> list[str]:
    """About the points of one degree of freedom."""
    said, dof, n = [], item.points.dof, len(item.points)
    used = int(np.count_nonzero(item.use))
    if used < FEW * n:
        said.append(
            f'only {used} of {n} points of {dof} lie on a branch; check excitation.amplitude, '
            'excitation.quantity and platform.law'
        )
    if not item.points.phased.any():
        said.append(
            f'{dof} was measured without phase: where branches or wells of like T lie side by side '
            'a point may count for the wrong one, and the intervals come out too narrow'
        )
    if item.points.chirp.any():
        fastest = float(np.max(np.abs(item.points.chirp)))
        there = response.plant
        limit = iso_limit(2.0 * there.zeta * there.hertz)
        largest = 100 * float(np.max(np.abs(item.lag[item.use] - 1.0), initial=0.0))
        said.append(
            f'{dof} was swept at up to {fastest:.2g} Hz/s (ISO 7626-2 allows {limit:.2g}); a lag '
            f'of up to {largest:.2g} % was taken off to first order. A stepped sine needs none'
        )
    return said


def advice(trim_kg: float, interval: Interval) -> Advice:
    """For a plate that carries `trim_kg` more than the springs balance."""
    grams, low, high = (-1e3 * kg for kg in (trim_kg, interval.high, interval.low))
    if not interval.determined:
        action = 'unknown'
        text = (
            'these curves do not tell the payload trim from the other fitted parameters; fit '
            'fewer of them, or measure the phase and more points near the jumps'
        )
    elif low <= 0.0 <= high:
        action = 'leave'
        text = (
            'leave the payload: it is balanced as far as the curves tell '
            f'(95 %: {low:.4g} to {high:.4g} g to add)'
        )
    else:
        action = 'add' if grams > 0 else 'remove'
        least, most = sorted((abs(low), abs(high)))
        text = f'{action} {abs(grams):.4g} g (95 %: {least:.4g} to {most:.4g} g)'
    return Advice(action, grams, low, high, text)


def _chi_square(probability: float, freedom: int) -> float:
    from scipy.special import chdtri

    return float(chdtri(freedom, 1.0 - probability))
