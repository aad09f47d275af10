"""The result of every estimator: transmissibility curves with the events read off them."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from qzs_rig.errors import InputError
from qzs_rig.files import finite_or_none
from qzs_rig.samples import Array

SCHEMA = 'qzs_rig/estimate/1'
DIRECTIONS = ('forward', 'reverse', 'none')
EVENT_KINDS = ('onset', 'peak', 'jump_up', 'jump_down')


@dataclass(frozen=True)
class Curve:
    """Transmissibility of one degree of freedom in one sweep direction, in order of time.

    All arrays are (n,). `magnitude` is |top| / |base| of the named `quantity` (`fundamental`),
    `phase_deg` the phase of top against base in (-180, 180], `thd` the root sum square of the
    top's harmonics 2 and up over its fundamental (NaN where the sample rate shows none).
    `uncertainty` is the standard uncertainty of the magnitude (estimation.uncertainty); left out,
    it is NaN: nobody stated one.
    """

    dof: str
    direction: str
    estimator: str
    quantity: str
    frequency_hz: Array
    magnitude: Array
    phase_deg: Array
    thd: Array
    uncertainty: Array = field(default_factory=lambda: np.empty(0))

    def __post_init__(self) -> None:
        if len(self.uncertainty) != len(self.frequency_hz):
            object.__setattr__(self, 'uncertainty', np.full(len(self.frequency_hz), np.nan))


@dataclass(frozen=True)
class Event:
    """A frequency read off a curve. `resolution_hz` is the spacing of the points it lies between;
    `magnitude` the transmissibility there."""

    dof: str
    direction: str
    kind: str
    frequency_hz: float
    magnitude: float
    resolution_hz: float


@dataclass(frozen=True)
class Estimate:
    """Curves and events of one run; `quality` says what the estimator saw (counts, reasons)."""

    curves: tuple[Curve, ...] = ()
    events: tuple[Event, ...] = ()
    quality: dict[str, Any] = field(default_factory=dict)

    def to_document(self) -> dict[str, Any]:
        """A JSON-ready document; floats survive the round trip bit by bit, NaN becomes null."""
        return {
            'schema': SCHEMA,
            'curves': [
                {
                    'dof': curve.dof,
                    'direction': curve.direction,
                    'estimator': curve.estimator,
                    'quantity': curve.quantity,
                    'frequency_hz': finite_or_none(curve.frequency_hz),
                    'magnitude': finite_or_none(curve.magnitude),
                    'phase_deg': finite_or_none(curve.phase_deg),
                    'thd': finite_or_none(curve.thd),
                    'uncertainty': finite_or_none(curve.uncertainty),
                }
                for curve in self.curves
            ],
            'events': [vars(event).copy() for event in self.events],
            'quality': self.quality,
        }

    def to_json(self) -> str:
        """`to_document` as text, the content of `estimate.json`."""
        return json.dumps(self.to_document(), allow_nan=False)


def from_document(document: Any) -> Estimate:
    """The Estimate in a parsed JSON document; raises InputError naming what is wrong with it."""
    if not isinstance(document, dict) or document.get('schema') != SCHEMA:
        found = document.get('schema') if isinstance(document, dict) else type(document).__name__
        raise InputError(f'not an estimate: schema is {found!r}, expected {SCHEMA!r}')
    try:
        curves = tuple(
            Curve(
                dof=str(item['dof']),
                direction=str(item['direction']),
                estimator=str(item['estimator']),
                quantity=str(item['quantity']),
                frequency_hz=_array(item['frequency_hz']),
                magnitude=_array(item['magnitude']),
                phase_deg=_array(item['phase_deg']),
                thd=_array(item['thd']),
                # files of earlier versions state none
                uncertainty=_array(item.get('uncertainty', [])),
            )
            for item in document['curves']
        )
        events = tuple(Event(**item) for item in document['events'])
    except (KeyError, TypeError, ValueError) as error:
        raise InputError(f'damaged estimate: {error!r}; analyze the bag again') from error
    return Estimate(curves, events, dict(document.get('quality', {})))


def from_json(text: str) -> Estimate:
    """The Estimate in the text of an `estimate.json`."""
    try:
        return from_document(json.loads(text))
    except json.JSONDecodeError as error:
        raise InputError(f'not an estimate: {error}') from error


def _array(values: list[float | None]) -> Array:
    return np.array([math.nan if value is None else value for value in values], dtype=np.float64)
