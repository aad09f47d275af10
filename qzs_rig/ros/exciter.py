"""The exciter node: publishes the commanded base motion and leads the run."""

from __future__ import annotations

from rclpy.context import Context

from qzs_rig import wire
from qzs_rig.ros.lead import Lead
from qzs_rig.ros.process import leave, run
from qzs_rig.run.sheet import RunSheet
from qzs_rig.run.stages import ExciterStage
from qzs_rig.scenario import step_ns_of


class Exciter(Lead):
    """Publishes what ExciterStage gives, as fast as the lead lets it."""

    role = 'exciter'
    sections = ('run', 'excitation', 'shaker')
    # bursts of 5 at 1 kHz: `ros2 topic hz` and sensor-data subscribers keep no more
    tick_s = 0.005

    def __init__(self, context: Context | None = None) -> None:
        super().__init__(context)
        self._stage: ExciterStage | None = None

    @property
    def stage(self) -> ExciterStage:
        """The stage of this configuration or run."""
        assert self._stage is not None
        return self._stage

    def open(self) -> None:
        super().open()
        self.publisher(wire.BASE_MOTION)
        self._stage = ExciterStage(self.spec, step_ns_of(self.spec))  # refuses a bad plan now

    def prepare(self) -> RunSheet:
        step_ns = step_ns_of(self.spec)
        self._stage = ExciterStage(self.spec, step_ns)  # of the parameters of now
        return RunSheet(
            step_ns=step_ns,
            samples=self._stage.samples,
            mode=self.spec.text('run.mode'),
            chunk=self.spec.count('run.chunk'),
            spec=self.spec.sections(*self.sections),
        )

    def endpoints(self) -> list[str]:
        return ['a subscriber of base/motion'] if self.peers else []

    def arm(self, start_ns: int) -> int:
        self.stage.start(start_ns, self.run.predictions)
        return start_ns

    def feed(self, n: int) -> int:
        motion = self.stage.take(n)
        self.publish(wire.BASE_MOTION, wire.encode_motion(motion))
        if self.stage.stopped and not self.run.abort_reason:
            self._ramp_down(self.stage.stopped)
        return len(motion)

    def soft_stop(self) -> int:
        self.stage.stop()
        return self.stage.samples


def main() -> None:
    """`ros2 run qzs_rig exciter`."""
    leave(run(Exciter))


if __name__ == '__main__':
    main()
