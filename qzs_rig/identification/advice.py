"""What to do about the payload: how much to add or remove to rest at the working point again."""

from __future__ import annotations

from dataclasses import dataclass

from qzs_rig.identification.intervals import Interval


@dataclass(frozen=True)
class Advice:
    """`action` is add, remove, leave or unknown; `grams` what brings the plate back, with its
    95 % interval `low` to `high`, all positive when added."""

    action: str
    grams: float
    low: float
    high: float
    text: str


def advice(trim_kg: float, interval: Interval) -> Advice:
    """For a plate that carries `trim_kg` more than the springs balance."""
    grams, low, high = -1e3 * trim_kg, -1e3 * interval.high, -1e3 * interval.low
    if not interval.determined:
        return Advice(
            'unknown',
            grams,
            low,
            high,
            'these curves do not tell the payload trim from the other fitted parameters; fit '
            'fewer of them, or measure the phase and more points near the jumps',
        )
    if low <= 0.0 <= high:
        return Advice(
            'leave',
            grams,
            low,
            high,
            f'leave the payload: it is balanced as far as the curves tell '
            f'(95 %: {_span(low, high)} g to add)',
        )
    action = 'add' if grams > 0 else 'remove'
    span = _span(low, high) if grams > 0 else _span(-high, -low)
    return Advice(action, grams, low, high, f'{action} {abs(grams):.4g} g (95 %: {span} g)')


def _span(low: float, high: float) -> str:
    return f'{low:.4g} to {high:.4g}'
