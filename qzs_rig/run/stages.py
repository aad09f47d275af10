"""The streaming stages: samples in, samples out, and the same bits however they are cut."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from qzs_rig.estimation import ESTIMATORS, Estimator, TrackedSineSettings
from qzs_rig.estimation.alignment import Aligner, StreamCounts
from qzs_rig.estimation.channels import ChannelMap, dofs_of
from qzs_rig.estimation.estimate import Estimate
from qzs_rig.excitation.drive import Drive, fade_out, shaped
from qzs_rig.excitation.shaker import refuse_beyond_limits
from qzs_rig.mechanics.coupled_integrator import CoupledIntegrator
from qzs_rig.mechanics.equilibrium import cautions
from qzs_rig.mechanics.geometry import SIX, Geometry
from qzs_rig.mechanics.integrator import Integrator
from qzs_rig.mechanics.platform import Platform
from qzs_rig.parameters import RunSpec
from qzs_rig.prediction.curve import Prediction
from qzs_rig.prediction.lookout import Foreseen, look_out, refuse_vague
from qzs_rig.samples import IMU_CHANNELS, MOTION_CHANNELS, NS, Array, Channel, Samples, Stamps
from qzs_rig.sensing import SENSORS, Sensor
from qzs_rig.sensing.imu import specific_force_and_rate
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


SIX_CHANNELS = MOTION_CHANNELS + tuple(
    Channel(f'{dof}.{quantity}', unit + per)
    for quantity, per in (('position', ''), ('velocity', '/s'), ('acceleration', '/s²'))
    for dof, unit in zip(SIX[4:], ('m', 'rad'), strict=True)
)
"""Motion of a coupled top plate: what follows the first twelve is y and the roll about x."""
INTERPRETED = 20_000
"""Steps that the interpreter has done before compiled code would be loaded (half a second)."""


class ExciterStage:
    """Gives the commanded base motion piece by piece; `stop` ramps it down early."""

    def __init__(self, spec: RunSpec, step_ns: int) -> None:
        """Raises what makes this run impossible: InputError, LimitError."""
        self.drive = Drive.from_spec(spec, step_ns)
        refuse_beyond_limits(self.drive, spec)
        refuse_vague(spec)
        self.stopped = ''
        """Why the stage itself ended the run early; empty as long as it has not."""
        self.samples = self.drive.samples
        self.given = 0
        self._spec = spec
        self._start_ns, self._step_ns = 0, step_ns
        self._foreseen: Foreseen | None = None
        self._stop_at: int | None = None

    def start(self, start_ns: int, predictions: Sequence[Prediction] | None = None) -> None:
        """Sample 0 is stamped `start_ns`; `predictions` of this run are needed where
        run.predictive_abort is to act."""
        self._start_ns = start_ns
        if predictions is not None:
            self._foreseen = look_out(self._spec, self.drive, predictions)

    def take(self, n: int) -> Samples:
        """The next `n` samples (n, 12), fewer at the end of the run."""
        if self._foreseen and self.given + n > self._foreseen.sample:
            self.stopped = self._foreseen.reason
            self._stop_from(self._foreseen.sample)
        last = min(self.given + n, self.samples)
        motion = self.drive.motion(self.given, last)
        if self._stop_at is not None:
            fades = slice(max(self._stop_at - self.given, 0), None)
            t = (np.arange(self.given, last) * self._step_ns / NS)[fades]
            t -= self._stop_at * self._step_ns / NS
            motion[fades] = _faded(motion[fades], t, self.drive.ramp)
        stamps_ns = self._start_ns + np.arange(self.given, last) * self._step_ns
        self.given = last
        return Samples(stamps_ns, motion, MOTION_CHANNELS)

    def stop(self) -> None:
        """Ramp down from here over the ramp of the run; `samples` shrinks to where that ends."""
        self._stop_from(self.given)

    def _stop_from(self, sample: int) -> None:
        if self._stop_at is None:
            self._foreseen = None
            self._stop_at = sample
            ramp_samples = math.ceil(self.drive.ramp * NS / self._step_ns) + 1
            self.samples = min(self.samples, sample + ramp_samples)


class PlatformOutput(NamedTuple):
    """Readings of both sensors (n, 6) and the top's motion (n, 12), (n, 18) where it is
    coupled, for a chunk of base motion."""

    base_imu: Samples
    top_imu: Samples
    top: Samples


class PlatformStage:
    """Integrates the platform on the base motion and reads the sensors on both plates.

    Where `platform.kernel` is auto, up to INTERPRETED steps of the `awaited` samples, those that
    somebody waits for at once, are left to the interpreter; the bits are the same.
    """

    def __init__(self, spec: RunSpec, step_ns: int, awaited: float = math.inf) -> None:
        self.platform = Platform.from_spec(spec)
        substeps, kernel = spec.count('platform.substeps'), spec.text('platform.kernel')
        if kernel == 'auto' and awaited * substeps <= INTERPRETED:
            kernel = 'python'
        how = (step_ns / NS, substeps, kernel)
        self._integrator: Integrator | CoupledIntegrator
        self._cautions: list[str] = []
        if self.platform.coupled:
            geometry = Geometry.from_spec(spec)
            self._cautions = cautions(geometry, 'platform.hinge' in spec)
            self._integrator = CoupledIntegrator(geometry, *how)
            self._top_channels = SIX_CHANNELS
        else:
            self._integrator = Integrator(self.platform, *how)
            self._top_channels = MOTION_CHANNELS
        sensor, seed = SENSORS[spec.text('sensor.kind')], spec.count('run.seed')
        self._base_sensor = sensor(spec, step_ns, (seed, 0))
        self._top_sensor = sensor(spec, step_ns, (seed, 1))

    def cautions(self, driven: tuple[bool, ...]) -> list[str]:
        """What a user should know before trusting a run of the `driven` degrees of freedom."""
        return self._cautions + self.platform.cautions(driven)

    @property
    def clipped(self) -> int:
        """Readings beyond the sensors' range so far."""
        return self._base_sensor.clipped + self._top_sensor.clipped

    def push(self, base: Samples) -> PlatformOutput:
        """Readings at the samples of `base` (n, 12); raises DivergenceError (no NaN comes out)."""
        top = self._integrator.push(base.data)
        return PlatformOutput(
            _readings(self._base_sensor, base.stamps_ns, base.data),
            _readings(self._top_sensor, base.stamps_ns, top),
            Samples(base.stamps_ns, top, self._top_channels),
        )


def _readings(sensor: Sensor, stamps_ns: Stamps, motion: Array) -> Samples:
    return Samples(stamps_ns, sensor.read(specific_force_and_rate(motion)), IMU_CHANNELS)


def _faded(motion: Array, t: Array, ramp: float) -> Array:
    level, slope, bend = fade_out(t, ramp)
    parts = (motion[:, :4], motion[:, 4:8], motion[:, 8:])
    envelope = (level[:, None], slope[:, None], bend[:, None])
    return np.concatenate(shaped(envelope, parts), axis=1)
