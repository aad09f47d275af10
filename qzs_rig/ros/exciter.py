"""The exciter node: publishes the commanded base motion and leads the run."""

from __future__ import annotations

from qzs_rig import wire
from qzs_rig.ros.lead import Lead
from qzs_rig.ros.leaving import leave
from qzs_rig.ros.spinning import run
from qzs_rig.run.sheet import RunSheet
from qzs_rig.run.stages import ExciterStage
from qzs_rig.samples import TimeHistory
from qzs_rig.scenario import step_ns_of


class Exciter(Lead):
    """A shell over ExciterStage."""

    role = 'exciter'
    sections = ('run', 'excitation', 'shaker')
    # bursts of 5 at 1 kHz: `ros2 topic hz` and sensor-data subscribers keep no more
    tick_s = 0.005

    def open(self) -> None:
        super().open()
        self._motion = self.publisher(wire.BASE_MOTION)
        self._get_stage()

    def _get_stage(self) -> None:
        self._step_ns = step_ns_of(self.spec)
        self._stage = ExciterStage(self.spec, 0, self._step_ns)

    def prepare(self) -> RunSheet:
        self._get_stage()
        return RunSheet(
            step_ns=self._step_ns,
            samples=self._stage.samples,
            mode=self.spec.text('run.mode'),
            chunk=self.spec.count('run.chunk'),
            spec=self.spec.sections(*self.sections),
        )

    def endpoints(self) -> list[str]:
        return ['a subscriber of base/motion'] if self.peers else []

    def arm(self, start_ns: int) -> int:
        self._stage = ExciterStage(self.spec, start_ns, self._step_ns, self.predictions)
        return start_ns

    def feed(self, n: int) -> int:
        motion: TimeHistory = self._stage.take(n)
        self._motion.publish(wire.encode_motion(motion.start_ns, motion.step_ns, motion.data))
        if self._stage.stopped and not self._abort_reason:
            self._ramp_down(self._stage.stopped)
        return len(motion)

    def soft_stop(self) -> int:
        self._stage.stop()
        return self._stage.samples


def main() -> None:
    """`ros2 run qzs_rig exciter`."""
    leave(run(Exciter))


if __name__ == '__main__':
    main()
