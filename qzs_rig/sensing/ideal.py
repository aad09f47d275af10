"""A sensor without faults."""

from __future__ import annotations

from qzs_rig.parameters import Parameter, RunSpec
from qzs_rig.samples import Array

PARAMETERS: tuple[Parameter, ...] = ()


class Ideal:
    """Readings pass untouched."""

    def __init__(self, spec: RunSpec, step_ns: int, seed: tuple[int, ...]) -> None:
        self.clipped = 0

    def read(self, ideal: Array) -> Array:
        """The same (n, 6)."""
        return ideal
