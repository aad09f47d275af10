"""`qzs-rig run`: the whole rig in this process, as fast as it goes."""

from __future__ import annotations

import argparse
import time
import uuid
from collections import deque
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path
from typing import Any

from qzs_rig import files, scenario, wire
from qzs_rig.cli import options as shared
from qzs_rig.cli.options import bar
from qzs_rig.cli.outcome import caution, present
from qzs_rig.errors import RigError, RunAbortedError
from qzs_rig.parameters import RunSpec
from qzs_rig.prediction.predict import predict
from qzs_rig.run import in_process, runfolder
from qzs_rig.run.runfolder import Recording
from qzs_rig.run.sheet import RunSheet, SheetState
from qzs_rig.run.stages import ExciterStage, PlatformOutput
from qzs_rig.samples import NS, Samples

PENDING = 8
"""Chunks that may wait for the disk."""


def add_to(verbs: Any) -> None:
    """`run` on the command line."""
    command = verbs.add_parser(
        'run',
        help='perform a scenario in this process, hundreds of times faster than real time',
        description='Perform a scenario without ROS: the same stages, the same bits as the nodes.',
    )
    shared.scenario(command)
    command.add_argument(
        '--no-bag', action='store_true', help='keep no bag, only estimate and report'
    )
    command.set_defaults(execute=execute)


def execute(options: argparse.Namespace) -> int:
    """Perform, keep, print."""
    spec = scenario.load(options.scenario, options.assignments)
    run_id = uuid.uuid4().hex[:8]
    folder = options.out or runfolder.new_folder(options.scenario, run_id)
    files.refuse_occupied(folder)
    exciter = ExciterStage(spec, scenario.step_ns_of(spec))
    sheet = sheet_of(spec, exciter.samples, options.scenario, run_id)
    recorder = None if options.no_bag else Recorder(folder, spec, sheet)
    predictions = predict(spec)
    progress = bar(sheet.samples * sheet.step_ns / NS, 's', 'run')
    try:
        result = in_process.run(
            spec,
            sheet.start_ns,
            tap=recorder.keep if recorder else None,
            progress=lambda done, _: progress.update(done * sheet.step_ns / NS - progress.n),
            predictions=predictions,
            exciter=exciter,
        )
    except (RigError, KeyboardInterrupt) as error:
        reason = str(error) or 'stopped by the operator'
        if recorder:
            recorder.close(sheet.replace(state=SheetState.ABORTED, reason=reason))
            reason += f'; kept {folder}, see qzs-rig analyze {folder}'
        raise RunAbortedError(reason) from error
    finally:
        progress.close()
    state = SheetState.ABORTED if result.stopped else SheetState.FINISHED
    sheet = sheet.replace(state=state, reason=result.stopped, samples=result.samples)
    if recorder:
        recorder.close(sheet)
    caution(result.cautions)
    counts = {'published': result.samples, 'received': result.samples, 'lost': 0, 'duplicated': 0}
    document = runfolder.keep_results(
        folder,
        sheet,
        result.estimate,
        predictions,
        rig_s=result.rig_s,
        wall_s=result.wall_s,
        topics=dict.fromkeys(('base/imu', 'top/imu'), counts),
        bag=folder if recorder else None,
        report=folder / 'report.html',
    )
    return present(options, document, result.estimate, spec, folder, predictions)


def sheet_of(spec: RunSpec, samples: int, name: str, run_id: str) -> RunSheet:
    """The sheet of a run in process that begins now."""
    return RunSheet(
        step_ns=scenario.step_ns_of(spec),
        samples=samples,
        mode='in_process',
        chunk=spec.count('run.chunk'),
        spec=dict(spec),
        run_id=run_id,
        scenario=Path(name).stem,
        start_ns=time.time_ns(),
        state=SheetState.RUNNING,
    )


class Recorder:
    """Writes what the nodes would have published, on a thread: compression needs no interpreter."""

    def __init__(self, folder: Path, spec: RunSpec, sheet: RunSheet) -> None:
        names = [spec.text(f'analyzer.{plate}.topic') for plate in ('base', 'top')]
        self._recording = Recording(folder, names[0], names[1])
        self._sheet = sheet
        self._recording.sheet(sheet.start_ns, sheet)
        self._writer = ThreadPoolExecutor(max_workers=1)
        self._pending: deque[Future[None]] = deque()

    def keep(self, base: Samples, out: PlatformOutput) -> None:
        """One chunk of the run; waits where the disk is far behind."""
        self._pending.append(self._writer.submit(self._keep, base, out))
        while len(self._pending) > PENDING:
            self._pending.popleft().result()

    def _keep(self, base: Samples, out: PlatformOutput) -> None:
        whole = len(base) // self._sheet.chunk * self._sheet.chunk
        for part, n in ((base[:whole], self._sheet.chunk), (base[whole:], len(base) - whole)):
            if len(part):
                self._recording.motion(part.stamps_ns[::n], wire.encode_motions(part, n))
        self._recording.base(base.stamps_ns, wire.encode_imu(out.base_imu, 'base_imu_link'))
        self._recording.top(base.stamps_ns, wire.encode_imu(out.top_imu, 'top_imu_link'))

    def close(self, sheet: RunSheet) -> None:
        """Keep the last sheet and finish the bag."""
        self._writer.shutdown()
        for written in self._pending:
            written.result()
        self._recording.sheet(sheet.start_ns + sheet.samples * sheet.step_ns, sheet)
        self._recording.close()
