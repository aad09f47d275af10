"""The analyzer node: estimates transmissibility from two Imu topics and records the run."""

from __future__ import annotations

import cmath
import json
import math
import time
from collections.abc import Sequence

from rclpy.context import Context
from std_srvs.srv import Trigger

from qzs_rig import wire
from qzs_rig.errors import InputError
from qzs_rig.estimation.channels import dofs_of
from qzs_rig.estimation.estimate import Estimate
from qzs_rig.parameters import Parameter
from qzs_rig.prediction import labels
from qzs_rig.prediction.curve import Prediction, from_document
from qzs_rig.ros.endpoints import Message
from qzs_rig.ros.follower import Follower
from qzs_rig.ros.node import RigNode
from qzs_rig.ros.process import leave, run
from qzs_rig.ros.states import FollowerState
from qzs_rig.run.session import DriverSession, Session, driver_sheet
from qzs_rig.run.sheet import RunSheet, SheetState
from qzs_rig.run.stages import AnalyzerStage

ESTIMATE_S = 0.2
"""Least time between two `analyzer/estimate`."""


class Live:
    """Publishes `analyzer/<dof>/...`, `analyzer/estimate` and `analyzer/match` for a node."""

    def __init__(self, node: RigNode, dofs: Sequence[str]) -> None:
        self._node = node
        names = ('frequency_hz', 'transmissibility', 'phase_deg')
        self._topics = {dof: [wire.live_topic(dof, name) for name in names] for dof in dofs}
        for topic in (
            wire.ESTIMATE,
            *(t for group in self._topics.values() for t in group),
            wire.MATCH,
        ):
            node.publisher(topic)
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
        for dof, topics in self._topics.items():
            point = stage.latest(dof)
            if point is None or self.frequency_hz.get(dof) == point[0]:
                continue
            frequency_hz, ratio = point
            self.frequency_hz[dof] = frequency_hz
            values = (frequency_hz, abs(ratio), math.degrees(cmath.phase(ratio)))
            for topic, value in zip(topics, values, strict=True):
                self._node.publish(topic, wire.encode_float(value))
        ears = [f'a subscriber of {topic.name}' for topic in (wire.ESTIMATE, wire.MATCH)]
        watched = len(self._node.unmatched(ears)) < len(ears)
        if watched and time.monotonic() - self._published_at > ESTIMATE_S:
            self._published_at = time.monotonic()
            self.conclude(stage.preview())

    def conclude(self, estimate: Estimate) -> None:
        """Publish an estimate, and where theory has its points; the last ones stay for late
        listeners."""
        self._node.publish(wire.ESTIMATE, wire.encode_json(estimate.to_document()))
        found = labels.label_all(estimate, self._predictions)
        self._node.publish(wire.MATCH, wire.encode_json(labels.to_document(self._run_id, found)))


class Analyzer(Follower):
    """Gathers messages of both sensors for a Session: one for each run, or a driver's."""

    role = 'analyzer'
    sections = ('analyzer',)
    own = (
        Parameter('folder', str, '', '', 'folder of the run; empty: runs/<time>_<scenario>_<id>'),
        Parameter('progress', bool, False, '', 'print progress on stdout, one JSON line a time'),
    )

    def __init__(self, context: Context | None = None) -> None:
        super().__init__(context)
        self._names = ('', '')
        self._from_driver = False
        self._raw: tuple[list[bytes], list[bytes]] = ([], [])
        self._session: Session | None = None
        self._live: Live | None = None
        self._theory: tuple[str, tuple[Prediction, ...]] = ('', ())
        self._printed_at = 0.0

    def open(self) -> None:
        super().open()
        base, top = (self.spec.text(f'analyzer.{plate}.topic') for plate in ('base', 'top'))
        self._names = base, top
        self._from_driver = self.spec.text('analyzer.source') == 'driver'
        self._session = None
        self._forget()
        best_effort = self.spec.text('analyzer.qos') == 'sensor_data'
        for name, take in ((base, self._raw[0].append), (top, self._take_top)):
            imu = wire.BASE_IMU._replace(name=name)
            self.subscribe(imu, take, best_effort=best_effort, bare=True)
        self._live = Live(self, dofs_of(self.spec))
        self.create_service(Trigger, '~/save', self._save)
        if self._from_driver:
            self.message = f'waiting for {" and ".join(self._names)}'
        else:
            self.subscribe(wire.BASE_MOTION, self._take_motion)
            self.subscribe(wire.THEORY, self._take_theory)

    @property
    def live(self) -> Live:
        """What people watch; there once the node is configured."""
        assert self._live is not None
        return self._live

    def endpoints(self, sheet: RunSheet) -> list[str]:
        motion = ['a publisher of base/motion'] if 'platform' in sheet.peers else []
        return [*motion, *(f'a publisher of {name}' for name in self._names)]

    # --- messages

    def _take_theory(self, raw: bytes) -> None:
        try:
            told = wire.decode_json(raw, wire.THEORY.name)
            self._theory = str(told.get('run_id')), from_document(told)
        except InputError as error:  # a run needs no theory
            self.get_logger().warning(f'{wire.THEORY.name}: {error}')

    def _take_motion(self, raw: bytes) -> None:
        if self.busy and self._session:
            self._session.motion(raw)

    def _take_top(self, raw: bytes) -> None:
        top = self._raw[1]
        top.append(raw)
        if len(top) >= (self._session.batch if self._session else 1):
            self.attempt(self._process)

    def _process(self) -> None:
        if self.busy:
            self._push()
        elif self._from_driver and all(self._raw) and self.exit_code is None:
            self._begin_driver()
            self._push()
        else:  # nobody's samples, or one sensor alone: keep the newest
            for raw in self._raw:
                del raw[:-1000]

    def _push(self) -> None:
        session = self._session
        assert session is not None
        base, top = (list(raw) for raw in self._raw)
        self._forget()
        session.push(base, top)
        self.live.show(session.stage)
        self.index = session.index
        if session.sheet.mode == 'lockstep' or session.sheet.samples == self.index:
            self.say()

    def _forget(self) -> None:
        for raw in self._raw:
            raw.clear()

    # --- a run

    def armed(self, sheet: RunSheet) -> None:
        self._forget()
        run_id, predictions = self._theory
        known = predictions if run_id == sheet.run_id else ()
        self._session = Session(self.spec, sheet, self._names, known)
        self.live.begin(sheet.run_id, known)

    def _begin_driver(self) -> None:
        self.sheet = driver_sheet(self._raw[0][0], self.spec.sections(*self.sections))
        self._session = DriverSession(self.spec, self.sheet, self._names)
        self.live.begin(self.sheet.run_id, ())
        self.busy = True
        self._enter(FollowerState.RUNNING, 'analyzing')
        self.get_logger().info(f'analyzing {" and ".join(self._names)} into {self._session.folder}')

    def _end_driver(self) -> bool:
        """End the driver's session, if one is on; whether it was."""
        on = self.busy and self._from_driver
        if on and self.sheet:
            self._end(self.sheet.replace(state=SheetState.FINISHED))
        return on

    def tick(self) -> None:
        super().tick()
        if any(self._raw):
            self._process()
        if self._session and self.busy:
            self._session.tick()
            silence = self.spec.number('analyzer.silence')
            if silence and time.monotonic() - self._session.last_at > silence:
                self._end_driver()
        if self.spec.flag('progress') and time.monotonic() - self._printed_at > 0.1:
            self._print_progress()

    def conclude(self, sheet: RunSheet) -> None:
        if self._session:
            self._push()  # what is still in the lists belongs to this run
            self.live.conclude(self._session.conclude(sheet))
            self.get_logger().info(f'kept {self._session.folder}')

    def close(self) -> None:
        if self._session:
            self._session.close()

    # --- operators, and what people watch

    def operator_stop(self, why: str) -> None:
        self._end_driver()
        super().operator_stop(why)

    def _save(self, request: Message, response: Message) -> Message:
        response.success = self.busy and self._from_driver
        if response.success and self._session:
            response.message = f'kept {self._session.folder}'
            self.attempt(self._end_driver)
        elif self._from_driver:
            response.message = 'nothing to save'
        else:
            response.message = 'a run saves itself when it ends; see ~/abort'
        return self.answer(response)

    def _print_progress(self) -> None:
        self._printed_at = time.monotonic()
        samples = self.sheet.samples if self.sheet else 0
        line: dict[str, object] = {'state': self.state.value, 'message': self.message}
        line |= {'done': self.index, 'of': samples}
        for dof, hz in self.live.frequency_hz.items():
            line[f'{dof}_hz'] = hz
        print(json.dumps(line), flush=True)

    def details(self) -> dict[str, str]:
        return self._session.details() if self._session else {}


def main() -> None:
    """`ros2 run qzs_rig analyzer`."""
    leave(run(Analyzer))


if __name__ == '__main__':
    main()
