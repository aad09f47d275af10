"""What a campaign computes at each point."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from qzs_rig.campaign.part import Part
from qzs_rig.campaign.points import Points
from qzs_rig.parameters import Parameter, RunSpec


@dataclass(frozen=True)
class Output:
    """A column of the result."""

    name: str
    unit: str
    text: str


@dataclass(frozen=True)
class Task:
    """`evaluate(points, options)` gives the `outputs` of a chunk, wherever and in whatever order
    chunks are computed: it depends on the points alone.

    `inputs` are what a point has beside the parameters of a run; of each group in `needed` one
    has to be fixed or varied. `chunk` points take about a second or less; a kernel moves `block`
    of them together.
    """

    name: str
    text: str
    inputs: tuple[Parameter, ...]
    needed: tuple[tuple[str, ...], ...]
    options: tuple[Parameter, ...]
    outputs: tuple[Output, ...]
    chunk: int
    evaluate: Callable[[Points, RunSpec], Part]
    block: int = 1

    @property
    def columns(self) -> tuple[str, ...]:
        """Names of the outputs."""
        return tuple(output.name for output in self.outputs)
