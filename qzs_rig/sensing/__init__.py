"""Sensors on both plates. A new sensor is one file and one line in SENSORS."""

from __future__ import annotations

from typing import Protocol

from qzs_rig.parameters import Parameter, RunSpec
from qzs_rig.samples import Array
from qzs_rig.sensing import noisy


class Sensor(Protocol):
    """Turns ideal readings into real ones, sample by sample, whatever the chunk size."""

    clipped: int

    def __init__(self, spec: RunSpec, step_ns: int, seed: tuple[int, ...]) -> None: ...

    def read(self, ideal: Array) -> Array: ...


class Ideal:
    """A sensor without faults: readings pass untouched."""

    def __init__(self, spec: RunSpec, step_ns: int, seed: tuple[int, ...]) -> None:
        self.clipped = 0

    def read(self, ideal: Array) -> Array:
        """The same (n, 6)."""
        return ideal


SENSORS: dict[str, type[Sensor]] = {'ideal': Ideal, 'noisy': noisy.Noisy}

PARAMETERS = (
    Parameter('sensor.kind', str, 'ideal', '', 'sensor on both plates', choices=tuple(SENSORS)),
    *noisy.PARAMETERS,
)
