"""The platform node: integrates the model on the base motion and publishes both sensors."""

from __future__ import annotations

import time

import numpy as np
from rclpy.context import Context

from qzs_rig import wire
from qzs_rig.errors import GapError
from qzs_rig.ros.follower import Follower
from qzs_rig.ros.process import leave, run
from qzs_rig.run.sheet import RunSheet, SheetState
from qzs_rig.run.stages import PlatformStage
from qzs_rig.samples import NS, Samples, index_of
from qzs_rig.units import DOFS

JOINT_STATES_S = 1.0 / 60.0


class Platform(Follower):
    """Pushes base motion through PlatformStage and publishes what its sensors read."""

    role = 'platform'
    sections = ('platform', 'sensor')

    def __init__(self, context: Context | None = None) -> None:
        super().__init__(context)
        self._stage: PlatformStage | None = None
        self._joints_at = 0.0

    def open(self) -> None:
        super().open()
        PlatformStage(self.spec, NS, awaited=0)  # refuses a bad design now
        for topic in (wire.BASE_IMU, wire.TOP_IMU, wire.JOINT_STATES, wire.CLOCK):
            self.publisher(topic)
        self._stage = None
        self.subscribe(wire.BASE_MOTION, self._push)

    def endpoints(self, sheet: RunSheet) -> list[str]:
        outputs = (
            ['a subscriber of base/imu', 'a subscriber of top/imu']
            if 'analyzer' in sheet.peers
            else []
        )
        return ['a publisher of base/motion', *outputs]

    def prepare(self, sheet: RunSheet) -> None:
        # in real time no second may take longer than a second
        awaited = sheet.samples if sheet.mode == 'lockstep' else NS // sheet.step_ns
        seeded = {'run.seed': sheet.spec.get('run.seed', 0)}
        self._stage = PlatformStage(self.spec.override(seeded), sheet.step_ns, awaited)

    def armed(self, sheet: RunSheet) -> None:
        self.prepare(sheet)
        assert self._stage is not None
        driven = tuple(bool(sheet.spec.get(f'excitation.amplitude.{dof}')) for dof in DOFS)
        for caution in self._stage.cautions(driven):
            self.get_logger().warning(caution)

    def _push(self, raw: bytes) -> None:
        if not self.busy or self._stage is None or self.sheet is None:
            return
        sheet = self.sheet
        base = wire.decode_motion(raw)
        if not len(base):
            return
        index = index_of(int(base.stamps_ns[0]), sheet.start_ns, sheet.step_ns)
        if index != self.index or (np.diff(base.stamps_ns) != sheet.step_ns).any():
            raise GapError(
                f'base motion jumped from sample {self.index} to {index}; the run cannot go on: '
                'raise the QoS depth, lower run.rate, or use run.mode lockstep'
            )
        out = self._stage.push(base)
        self._publish(out.base_imu, out.top_imu)
        self.index += len(base)
        if sheet.mode == 'lockstep':
            self.publish(wire.CLOCK, wire.encode_clock(int(base.stamps_ns[-1])))
            self.say()
        if time.monotonic() - self._joints_at > JOINT_STATES_S:
            self._joints_at = time.monotonic()
            self.publish(wire.JOINT_STATES, wire.encode_joint_states(base, out.top))

    def _publish(self, base: Samples, top: Samples) -> None:
        base_rows = _messages(wire.encode_imu(base, 'base_imu_link'))
        top_rows = _messages(wire.encode_imu(top, 'top_imu_link'))
        for base_row, top_row in zip(base_rows, top_rows, strict=True):
            self.publish(wire.BASE_IMU, base_row)
            self.publish(wire.TOP_IMU, top_row)

    def conclude(self, sheet: RunSheet) -> None:
        if sheet.state is SheetState.FINISHED and self.index < sheet.samples:
            self.get_logger().warning(f'{sheet.samples - self.index} samples of motion missing')

    def details(self) -> dict[str, str]:
        if self._stage is None:
            return {}
        return {
            'published base/imu': str(self.index),
            'published top/imu': str(self.index),
            'clipped': str(self._stage.clipped),
        }


def _messages(rows: np.ndarray[tuple[int, ...], np.dtype[np.uint8]]) -> list[bytes]:
    buffer, length = rows.tobytes(), rows.shape[1]
    return [buffer[i : i + length] for i in range(0, len(buffer), length)]


def main() -> None:
    """`ros2 run qzs_rig platform`."""
    leave(run(Platform))


if __name__ == '__main__':
    main()
