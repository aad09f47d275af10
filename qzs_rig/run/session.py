"""What an analyzer makes of one run or of one stretch of a driver's samples, up to its files."""

from __future__ import annotations

import time
import uuid
from collections.abc import Mapping, Sequence
from pathlib import Path

from qzs_rig import wire
from qzs_rig.estimation.estimate import Estimate
from qzs_rig.parameters import RunSpec, Value
from qzs_rig.prediction.curve import Prediction
from qzs_rig.run.runfolder import Recording, keep_results, new_folder
from qzs_rig.run.sheet import RunSheet, SheetState
from qzs_rig.run.stages import AnalyzerStage
from qzs_rig.samples import NS, Samples

BATCH_S = 0.02
"""Rig time that is estimated in one go in real time."""
DRIVER_BATCH = 20
"""Samples of a driver that are estimated in one go."""


class Session:
    """A run on the grid of its sheet: estimated by `stage`, kept by a Recording.

    `index` is the number of samples that both sensors have reached; `batch`, how many are best
    pushed in one go.
    """

    def __init__(
        self,
        spec: RunSpec,
        sheet: RunSheet,
        topics: tuple[str, str],
        predictions: Sequence[Prediction] = (),
    ) -> None:
        """`topics` are the names of the base's and the top's Imu."""
        self.sheet, self._topics, self._predictions = sheet, topics, predictions
        self.index = 0
        self.batch, self._step_ns = self._pace()
        self.stage = self._new_stage(spec)
        named = spec.text('folder')
        self.folder = Path(named) if named else new_folder(sheet.scenario, sheet.run_id)
        self._recording = Recording(self.folder, *topics)
        self._recording.sheet(sheet.start_ns, sheet)
        self._first_at = self.last_at = 0.0
        self._reached = [sheet.start_ns - self._step_ns] * 2

    # --- what differs for a driver

    def _pace(self) -> tuple[int, int]:
        """Samples that are estimated in one go, and the step of `index` in ns."""
        step_ns = self.sheet.step_ns
        real_time = self.sheet.mode == 'real_time'
        return max(1, int(BATCH_S * NS / step_ns)) if real_time else self.sheet.chunk, step_ns

    def _new_stage(self, spec: RunSpec) -> AnalyzerStage:
        return AnalyzerStage(spec, self.sheet.step_ns)

    def _published(self, sheet: RunSheet, received: int) -> int:
        """How many samples a topic should have brought; `received` is what its stamps show."""
        return sheet.samples if sheet.state is SheetState.FINISHED else received

    # --- the work

    def motion(self, raw: bytes) -> None:
        """Record a chunk of the commanded motion."""
        self._recording.motion([wire.stamp_of(raw)], [raw])

    def push(self, base: list[bytes], top: list[bytes]) -> None:
        """Record and estimate serialised Imu messages of both sensors."""
        if base:
            readings = wire.decode_imu(base)
            self._recording.base(readings.stamps_ns, base)
            self.stage.push_base(readings)
            self._mark(0, readings)
        if top:
            readings = wire.decode_imu(top)
            self._recording.top(readings.stamps_ns, top)
            self.stage.push_top(readings)
            self._mark(1, readings)

    def _mark(self, plate: int, readings: Samples) -> None:
        self.last_at = time.monotonic()
        self._first_at = self._first_at or self.last_at
        self._reached[plate] = max(self._reached[plate], int(readings.stamps_ns.max()))
        # both sensors must have reached a sample before it counts as done
        self.index = (min(self._reached) - self.sheet.start_ns) // self._step_ns + 1

    def tick(self) -> None:
        """Let the recording reach the disk."""
        self._recording.tick()

    def close(self) -> None:
        """Close the bag, whatever happened."""
        self._recording.close()

    def conclude(self, sheet: RunSheet) -> Estimate:
        """Write bag, estimate, theory and run.json of the run, which ended as `sheet` says."""
        estimate = self.stage.result()
        end_ns = max(*self._reached, sheet.start_ns)
        self._recording.sheet(end_ns, sheet)
        self._recording.close()
        keep_results(
            self.folder,
            sheet,
            estimate,
            self._predictions,
            rig_s=(end_ns - sheet.start_ns) / NS,
            wall_s=self.last_at - self._first_at,
            topics=self._counts(sheet),
            bag=self.folder,
        )
        return estimate

    def _counts(self, sheet: RunSheet) -> dict[str, dict[str, int]]:
        topics = {}
        for name, counts in zip(self._topics, self.stage.counts.values(), strict=True):
            fresh = counts.received - counts.duplicated
            published = self._published(sheet, fresh + counts.lost)
            topics[name] = {
                'published': published,
                'received': counts.received,
                'lost': published - fresh,
                'duplicated': counts.duplicated,
            }
        return topics

    def details(self) -> dict[str, str]:
        """Counters for the status."""
        return {
            f'{word} {name}': str(getattr(counts, word))
            for name, counts in zip(self._topics, self.stage.counts.values(), strict=True)
            for word in ('received', 'lost', 'duplicated')
        }


class DriverSession(Session):
    """Samples of somebody else's driver: no grid is known, `index` counts seconds.

    The stamps show only inner gaps, so nothing is said of samples before the first or after the
    last.
    """

    def _pace(self) -> tuple[int, int]:
        return DRIVER_BATCH, NS

    def _new_stage(self, spec: RunSpec) -> AnalyzerStage:
        return AnalyzerStage(spec, None)

    def _published(self, sheet: RunSheet, received: int) -> int:
        return received


def driver_sheet(first: bytes, spec: Mapping[str, Value]) -> RunSheet:
    """A sheet for what begins with the serialised Imu message `first`; `step_ns` 0: no grid."""
    return RunSheet(
        step_ns=0,
        samples=0,
        mode='real_time',
        chunk=1,
        scenario='driver',
        run_id=uuid.uuid4().hex[:8],
        start_ns=wire.stamp_of(first),
        state=SheetState.RUNNING,
        spec=spec,
    )
