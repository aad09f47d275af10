"""The analyzer node: estimates transmissibility from two Imu topics and records the run."""

from __future__ import annotations

import json
import time
import uuid
from pathlib import Path
from typing import Any

from std_srvs.srv import Trigger

from qzs_rig import files, wire
from qzs_rig.errors import InputError
from qzs_rig.estimation.channels import dofs_of
from qzs_rig.parameters import Parameter
from qzs_rig.prediction.curve import Prediction, from_document
from qzs_rig.ros import qos
from qzs_rig.ros.follower import Follower
from qzs_rig.ros.leaving import leave
from qzs_rig.ros.live import Live
from qzs_rig.ros.spinning import run
from qzs_rig.run import runfolder
from qzs_rig.run.analysis import AnalyzerStage
from qzs_rig.run.recording import Recording
from qzs_rig.run.sheet import RunSheet
from qzs_rig.samples import NS
from qzs_rig.wire import ImuBatch

BATCH_S = 0.02
"""Rig time that is estimated in one go in real time."""


class Analyzer(Follower):
    """A shell over AnalyzerStage and Recording."""

    role = 'analyzer'
    sections = ('analyzer',)
    own = (
        Parameter('folder', str, '', '', 'folder of the run; empty: runs/<time>_<scenario>_<id>'),
        Parameter('progress', bool, False, '', 'print progress on stdout, one JSON line a time'),
    )

    def open(self) -> None:
        super().open()
        self._names = tuple(self.spec.text(f'analyzer.{p}.topic') for p in ('base', 'top'))
        self._raw: tuple[list[bytes], list[bytes]] = ([], [])
        self._batch = 1
        self._stage: AnalyzerStage | None = None
        self._recording: Recording | None = None
        self._peer_values: dict[str, str] = {}
        self._theory: tuple[str, tuple[Prediction, ...]] = ('', ())
        profile = qos.driver(self.spec.text('analyzer.qos'))
        base, top = (wire.Topic(name, wire.BASE_IMU.type, 4000) for name in self._names)
        self.subscribe(base, self._raw[0].append, profile, bare=True)
        self.subscribe(top, self._take_top, profile, bare=True)
        self._live = Live(self, dofs_of(self.spec))
        self.create_service(Trigger, '~/save', self._save)
        if self.spec.text('analyzer.source') == 'driver':
            self.message = f'waiting for {" and ".join(self._names)}'
        else:
            self.subscribe(wire.BASE_MOTION, self._take_motion)
            self.subscribe(wire.THEORY, self._take_theory)

    def endpoints(self, sheet: RunSheet) -> list[str]:
        motion = ['a publisher of base/motion'] if 'platform' in sheet.peers else []
        return [*motion, *(f'a publisher of {name}' for name in self._names)]

    # --- a run

    def armed(self, sheet: RunSheet) -> None:
        for raw in self._raw:
            raw.clear()
        self._stage = AnalyzerStage(self.spec, sheet.step_ns or None)
        named = self.spec.text('folder')
        self._folder = Path(named) if named else runfolder.new_folder(sheet.scenario, sheet.run_id)
        self._recording = Recording(self._folder, *self._names)
        self._recording.sheet(sheet.start_ns, sheet)
        self._first_at = self._last_at = 0.0
        self._live.begin(sheet.run_id, self._predictions)
        real_time = sheet.mode == 'real_time'
        step_s = (sheet.step_ns or 1) / NS
        self._batch = max(1, int(BATCH_S / step_s)) if real_time else sheet.chunk
        self._reached = [sheet.start_ns - (sheet.step_ns or NS)] * 2

    def _take_theory(self, raw: bytes) -> None:
        try:
            told = wire.decode_json(raw, wire.THEORY.name)
            self._theory = str(told.get('run_id')), from_document(told)
        except InputError as error:  # a run needs no theory
            self.get_logger().warning(f'{wire.THEORY.name}: {error}')

    @property
    def _predictions(self) -> tuple[Prediction, ...]:
        """What theory says of this run; nothing of a driver's."""
        run_id, predictions = self._theory
        return predictions if self.sheet and run_id == self.sheet.run_id else ()

    def _take_motion(self, raw: bytes) -> None:
        if self.busy and self._recording:
            self._recording.motion(raw)

    def _take_top(self, raw: bytes) -> None:
        top = self._raw[1]
        top.append(raw)
        if len(top) >= self._batch:
            self.attempt(self._process)

    def _process(self) -> None:
        if not self.busy:
            if self.spec.text('analyzer.source') != 'driver' or not all(self._raw):
                for raw in self._raw:  # nobody's samples, or one sensor alone: keep the newest
                    del raw[:-1000]
                return
            self._begin_driver()
        stage, recording = self._stage, self._recording
        assert stage is not None and recording is not None and self.sheet is not None
        base, top = (list(raw) for raw in self._raw)
        for raw in self._raw:
            raw.clear()
        if base:
            batch = recording.base(base)
            stage.push_base(batch)
            self._mark(0, batch)
        if top:
            batch = recording.top(top)
            stage.push_top(batch)
            self._mark(1, batch)
        if self.sheet.mode == 'lockstep' or self.sheet.samples == self.index:
            self.say()
        self._live.show(stage)

    def _mark(self, plate: int, batch: ImuBatch) -> None:
        assert self.sheet is not None
        self._last_at = time.monotonic()
        self._first_at = self._first_at or self._last_at
        self._reached[plate] = max(self._reached[plate], int(batch.stamps_ns.max()))
        # both sensors must have reached a sample before it counts as done
        step_ns = self.sheet.step_ns or NS
        self.index = (min(self._reached) - self.sheet.start_ns) // step_ns + 1

    def tick(self) -> None:
        super().tick()
        if any(self._raw):
            self._process()
        if self._recording and self.busy:
            self._recording.tick()
        silence = self.spec.number('analyzer.silence')
        driver = self.spec.text('analyzer.source') == 'driver' and self.busy
        if driver and silence and time.monotonic() - self._last_at > silence:
            self._end(self._driver_sheet('finished'))
        if self.spec.flag('progress') and time.monotonic() - self._printed_at > 0.1:
            self._print_progress()

    def conclude(self, sheet: RunSheet) -> None:
        if self._stage is None or self._recording is None:
            return
        self.busy = True  # what is still in the lists belongs to this run
        self._process()
        self.busy = False
        estimate = self._stage.result()
        end_ns = max(*self._reached, sheet.start_ns)
        self._recording.sheet(end_ns, sheet)
        self._recording.close()
        self._recording = None
        path = files.write_new(self._folder / 'estimate.json', estimate.to_json() + '\n')
        if self._predictions:
            runfolder.keep_theory(self._folder, sheet.run_id, self._predictions, estimate)
        document = runfolder.run_document(
            sheet.run_id,
            sheet.mode,
            rig_s=(end_ns - sheet.start_ns) / NS,
            wall_s=self._last_at - self._first_at,
            topics=self._topics(sheet),
            files={'bag': self._folder, 'estimate': path, 'report': None},
            state=sheet.state,
            reason=sheet.reason,
            scenario=sheet.scenario,
        )
        files.write_new_json(self._folder / 'run.json', document)
        self._live.conclude(estimate)
        self.get_logger().info(f'kept {self._folder}')

    def close(self) -> None:
        recording: Recording | None = getattr(self, '_recording', None)
        if recording:
            recording.close()

    def _topics(self, sheet: RunSheet) -> dict[str, dict[str, int]]:
        assert self._stage is not None
        topics = {}
        for name, counts in zip(self._names, self._stage.counts.values(), strict=True):
            fresh = counts.received - counts.duplicated
            # the sheet knows how many there should be; a driver's stamps show only inner gaps
            published = sheet.samples if sheet.step_ns and sheet.state == 'finished' else None
            inner = fresh + counts.lost
            topics[name] = {
                'published': inner if published is None else published,
                'received': counts.received,
                'lost': counts.lost if published is None else published - fresh,
                'duplicated': counts.duplicated,
            }
        return topics

    # --- a driver's Imu pair instead of a run

    def _begin_driver(self) -> None:
        first = wire.stamp_of(self._raw[0][0])
        self.sheet = RunSheet(
            step_ns=0, samples=0, mode='real_time', chunk=1, scenario='driver',
            run_id=uuid.uuid4().hex[:8], start_ns=first, state='running',
            spec=self.spec.sections(*self.sections),
        )  # fmt: skip
        base, top = (list(raw) for raw in self._raw)
        self.armed(self.sheet)
        self._raw[0].extend(base)
        self._raw[1].extend(top)
        self.busy, self.state, self.message = True, 'running', 'analyzing'
        self._batch = 20
        self.get_logger().info(f'analyzing {" and ".join(self._names)} into {self._folder}')

    def _driver_sheet(self, state: str) -> RunSheet:
        assert self.sheet is not None
        return self.sheet.of(state=state)

    def operator_stop(self, why: str) -> None:
        if self.busy and self.spec.text('analyzer.source') == 'driver':
            self._end(self._driver_sheet('finished'))
        super().operator_stop(why)

    def _save(self, request: Any, response: Any) -> Any:
        driver = self.spec.text('analyzer.source') == 'driver'
        response.success = bool(self.busy and driver)
        if response.success:
            folder = self._folder
            self.attempt(lambda: self._end(self._driver_sheet('finished')))
            response.message = f'kept {folder}'
        else:
            response.message = (
                'nothing to save' if driver else 'a run saves itself when it ends; see ~/abort'
            )
        return self.answer(response)

    # --- what people watch

    _printed_at = 0.0

    def _print_progress(self) -> None:
        self._printed_at = time.monotonic()
        samples = self.sheet.samples if self.sheet else 0
        line = {'state': self.state, 'message': self.message, 'done': self.index, 'of': samples}
        for dof, hz in self._live.frequency_hz.items():
            line[f'{dof}_hz'] = hz
        print(json.dumps(line), flush=True)

    def details(self) -> dict[str, str]:
        if self._stage is None:
            return {}
        values = {}
        for name, counts in zip(self._names, self._stage.counts.values(), strict=True):
            values[f'received {name}'] = str(counts.received)
            values[f'lost {name}'] = str(counts.lost)
            values[f'duplicated {name}'] = str(counts.duplicated)
        return values


def main() -> None:
    """`ros2 run qzs_rig analyzer`."""
    leave(run(Analyzer))


if __name__ == '__main__':
    main()
