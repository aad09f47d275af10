"""What people watch while a run is on: the newest points, and the curve so far."""

from __future__ import annotations

import cmath
import math
import time
from collections.abc import Sequence

from qzs_rig import wire
from qzs_rig.analysis import AnalyzerStage
from qzs_rig.estimation.estimate import Estimate
from qzs_rig.ros.node import RigNode

ESTIMATE_S = 0.2
"""Least time between two `analyzer/estimate`."""


class Live:
    """Publishes `analyzer/<dof>/...` and `analyzer/estimate` for one analyzer node."""

    def __init__(self, node: RigNode, dofs: Sequence[str]) -> None:
        self._node = node
        self._estimate = node.publisher(wire.ESTIMATE)
        self._values = {
            dof: [
                node.publisher(wire.live_topic(dof, name))
                for name in ('frequency_hz', 'transmissibility', 'phase_deg')
            ]
            for dof in dofs
        }
        self._published_at = 0.0
        self.frequency_hz: dict[str, float] = {}
        """Newest frequency of each degree of freedom that has a point."""

    def forget(self) -> None:
        """A new run begins."""
        self.frequency_hz.clear()

    def show(self, stage: AnalyzerStage) -> None:
        """Publish what is new in `stage`; the whole curve only if somebody listens."""
        for dof, publishers in self._values.items():
            point = stage.latest(dof)
            if point is None or self.frequency_hz.get(dof) == point[0]:
                continue
            frequency_hz, ratio = point
            self.frequency_hz[dof] = frequency_hz
            values = (frequency_hz, abs(ratio), math.degrees(cmath.phase(ratio)))
            for publisher, value in zip(publishers, values, strict=True):
                publisher.publish(wire.encode_float(value))
        watched = not self._node.unmatched([f'a subscriber of {wire.ESTIMATE.name}'])
        if watched and time.monotonic() - self._published_at > ESTIMATE_S:
            self._published_at = time.monotonic()
            self.conclude(stage.preview())

    def conclude(self, estimate: Estimate) -> None:
        """Publish an estimate; the last one stays for late listeners."""
        self._estimate.publish(wire.encode_json(estimate.to_document()))
