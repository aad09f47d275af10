"""The whole rig in one process: exciter, platform, analyzer and recorder, chunk by chunk."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from qzs_rig.estimation.estimate import Estimate
from qzs_rig.parameters import RunSpec
from qzs_rig.prediction.curve import Prediction
from qzs_rig.prediction.predict import predict
from qzs_rig.run.stages import AnalyzerStage, ExciterStage, PlatformOutput, PlatformStage
from qzs_rig.samples import NS, Samples
from qzs_rig.scenario import step_ns_of

CHUNK = 8000
"""Samples a chunk in process: long enough that the work, not the calls, takes the time."""

Tap = Callable[[Samples, PlatformOutput], None]


@dataclass(frozen=True)
class RunResult:
    """What a run in process gave; `wall_s` counts from the first to the last sample. `stopped`
    says why the predictive abort ended it, empty where it did not."""

    estimate: Estimate
    samples: int
    rig_s: float
    wall_s: float
    cautions: tuple[str, ...]
    stopped: str = ''


def run(
    spec: RunSpec,
    start_ns: int = 0,
    tap: Tap | None = None,
    progress: Callable[[int, int], None] | None = None,
    chunk: int = CHUNK,
    predictions: Sequence[Prediction] | None = None,
    exciter: ExciterStage | None = None,
) -> RunResult:
    """Perform `spec`; `tap` sees every chunk of base motion with the readings it caused.

    `predictions` of the run and its `exciter`, if they are at hand, save it from making them.

    `progress(done, samples)` is called after each chunk. KeyboardInterrupt passes through; what
    `tap` has seen by then is complete.
    """
    step_ns = step_ns_of(spec)
    if predictions is None and spec.flag('run.predictive_abort'):
        predictions = predict(spec)
    exciter = exciter or ExciterStage(spec, step_ns)
    exciter.start(start_ns, predictions)
    platform = PlatformStage(spec, step_ns)
    analyzer = AnalyzerStage(spec, step_ns)
    began = time.perf_counter()
    while exciter.given < exciter.samples:
        base = exciter.take(chunk)
        out = platform.push(base)
        if tap:
            tap(base, out)
        analyzer.push_base(out.base_imu)
        analyzer.push_top(out.top_imu)
        if progress:
            progress(exciter.given, exciter.samples)
    estimate = analyzer.result()
    driven = tuple(bool(a) for a in exciter.drive.amplitude)
    return RunResult(
        estimate,
        exciter.samples,
        (exciter.samples - 1) * step_ns / NS,
        time.perf_counter() - began,
        tuple(platform.cautions(driven)),
        exciter.stopped,
    )
