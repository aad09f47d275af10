"""What people watch while a run is on: the newest points, and the curve so far."""

from __future__ import annotations

import cmath
import math
import time
from collections.abc import Sequence

from qzs_rig import wire
from qzs_rig.estimation.estimate import Estimate
from qzs_rig.prediction import labels
from qzs_rig.prediction.curve import Prediction
from qzs_rig.ros.node import RigNode
from qzs_rig.run.analysis import AnalyzerStage

ESTIMATE_S = 0.2
"""Least time between two `analyzer/estimate`."""


class Live:
    """Publishes `analyzer/<dof>/...`, `analyzer/estimate` and `analyzer/match` for a node."""

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
        self._match = node.publisher(wire.MATCH)
        self._published_at = 0.0
        self._run_id = ''
        self._predictions: Sequence[Prediction] = ()
        self.frequency_hz: dict[str, float] = {}
        """Newest frequency of each degree of freedom that has a point."""

    def begin(self, run_id: str, predictions: Sequence[Prediction]) -> None:
        """A new run begins, of which theory says `predictions`."""
        self._run_id, self._predictions = run_id, predictions
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
        ears = [f'a subscriber of {topic.name}' for topic in (wire.ESTIMATE, wire.MATCH)]
        watched = len(self._node.unmatched(ears)) < len(ears)
        if watched and time.monotonic() - self._published_at > ESTIMATE_S:
            self._published_at = time.monotonic()
            self.conclude(stage.preview())

    def conclude(self, estimate: Estimate) -> None:
        """Publish an estimate, and where theory has its points; the last ones stay for late
        listeners."""
        self._estimate.publish(wire.encode_json(estimate.to_document()))
        found = labels.label_all(estimate, self._predictions)
        self._match.publish(wire.encode_json(labels.to_document(self._run_id, found)))
