"""The analyzer as a stage: two Imu streams in, an Estimate out."""

from __future__ import annotations

from qzs_rig.estimation import ESTIMATORS, Estimator, TrackedSineSettings
from qzs_rig.estimation.alignment import Aligner, StreamCounts
from qzs_rig.estimation.channels import ChannelMap, dofs_of
from qzs_rig.estimation.estimate import Estimate
from qzs_rig.parameters import RunSpec
from qzs_rig.samples import Samples
from qzs_rig.units import DOFS


class AnalyzerStage:
    """Maps both sensors to the degrees of freedom, aligns them and estimates transmissibility.

    The estimate depends on the samples alone, never on how they were cut into chunks, so a live
    run, its bag and the run in process agree in every bit.
    """

    def __init__(self, spec: RunSpec, step_ns: int | None) -> None:
        """`step_ns` of the run; None finds it in the stamps of a driver."""
        self._spec = spec
        self._maps = {plate: ChannelMap.from_spec(spec, plate) for plate in ('base', 'top')}
        self._aligner = Aligner(step_ns)
        self._settings = TrackedSineSettings.from_spec(spec)
        self._dofs = dofs_of(spec)
        self._columns = [DOFS.index(dof) for dof in self._dofs]
        self._estimator: Estimator | None = None

    def push_base(self, readings: Samples) -> None:
        """Readings (n, 6) of the base sensor."""
        self._aligner.push_base(readings.stamps_ns, self._maps['base'].pick(readings.data))

    def push_top(self, readings: Samples) -> None:
        """Readings (n, 6) of the top sensor; then estimates as far as both sensors reach."""
        self._aligner.push_top(readings.stamps_ns, self._maps['top'].pick(readings.data))
        self._advance(final=False)

    def latest(self, dof: str) -> tuple[float, complex] | None:
        """Newest frequency (Hz) and transmissibility of `dof`, None before the first."""
        if self._estimator is None or dof not in self._dofs:
            return None
        return self._estimator.latest(dof)

    @property
    def counts(self) -> dict[str, StreamCounts]:
        """Samples received, lost, duplicated and reordered on 'base' and 'top'."""
        return self._aligner.counts

    def preview(self) -> Estimate:
        """The estimate of what has come so far."""
        return self._estimator.result() if self._estimator else Estimate()

    def result(self) -> Estimate:
        """The estimate of everything; nothing may be pushed afterwards."""
        self._advance(final=True)
        streams = {plate: counts._asdict() for plate, counts in self.counts.items()}
        estimate = self.preview()
        return Estimate(estimate.curves, estimate.events, estimate.quality | {'streams': streams})

    def _advance(self, final: bool) -> None:
        pair = self._aligner.take(final)
        if len(pair.base) == 0:
            return
        if self._estimator is None:
            name = self._spec.text('analyzer.estimator')
            self._estimator = ESTIMATORS[name](self._settings, pair.step_ns, self._dofs)
        columns = self._columns
        self._estimator.push(pair.base[:, columns], pair.top[:, columns])
