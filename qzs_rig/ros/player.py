"""The player node: puts a bag's topics back, with their stamps, in place of the exciter."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from rclpy.context import Context

from qzs_rig import wire
from qzs_rig.bag import BagReader
from qzs_rig.errors import BagError, InputError
from qzs_rig.parameters import Parameter, positive
from qzs_rig.ros.lead import LEAD_PARAMETERS, Lead
from qzs_rig.ros.process import leave, run
from qzs_rig.run.offline import last_sheet
from qzs_rig.run.sheet import RunSheet
from qzs_rig.samples import Stamps
from qzs_rig.wire import Topic


@dataclass(frozen=True)
class Track:
    """Recorded messages of one topic, and the sample index of each."""

    topic: Topic
    messages: Sequence[bytes]
    index: Stamps


class Player(Lead):
    """Replays base motion into a platform, or Imu topics into an analyzer, bit by bit."""

    role = 'player'
    own = (
        *LEAD_PARAMETERS,
        Parameter('bag', str, '', '', 'bag to replay'),
        Parameter('topics', str, 'motion', '', 'what is replayed', choices=('motion', 'imu')),
        Parameter('mode', str, 'lockstep', '', 'pace', choices=('lockstep', 'real_time')),
        positive('rate', 1.0, '', 'rig seconds a wall second', 1000.0),
    )
    tick_s = 0.01

    def __init__(self, context: Context | None = None) -> None:
        super().__init__(context)
        self._tracks: tuple[Track, ...] = ()
        self._recording: RunSheet | None = None

    @property
    def recording(self) -> RunSheet:
        """The sheet of the recorded run, as far as it is replayed."""
        assert self._recording is not None
        return self._recording

    def open(self) -> None:
        super().open()
        with BagReader(Path(self.spec.text('bag'))) as reader:
            found = last_sheet(reader)
            topics = self._topics(found)
            rows = [reader.rows(topic.name, topic.type) for topic in topics]
        self._recording = sheet = self._recorded(found, rows[0].stamps_ns)
        for topic in topics:
            self.publisher(topic)
        self._tracks = tuple(
            Track(topic, item.messages(), (item.stamps_ns - sheet.start_ns) // sheet.step_ns)
            for topic, item in zip(topics, rows, strict=True)
        )

    def _topics(self, sheet: RunSheet | None) -> list[Topic]:
        """What is replayed, under the names that the recorded analyzer listened to."""
        if self.spec.text('topics') == 'motion':
            return [wire.BASE_MOTION]
        spec = sheet.spec if sheet else {}
        return [
            topic._replace(name=str(spec.get(f'analyzer.{plate}.topic', topic.name)))
            for plate, topic in (('base', wire.BASE_IMU), ('top', wire.TOP_IMU))
        ]

    def prepare(self) -> RunSheet:
        return self.recording.replace(
            mode=self.spec.text('mode'), pace=self.spec.number('rate'), reason=''
        )

    def endpoints(self) -> list[str]:
        return [f'a subscriber of {t.topic.name}' for t in self._tracks] if self.peers else []

    def arm(self, start_ns: int) -> int:
        return self.recording.start_ns  # original stamps

    def feed(self, n: int) -> int:
        sent = self.run.sent
        for track in self._tracks:
            # what was stamped before the first sample goes with it
            first = int(np.searchsorted(track.index, sent)) if sent else 0
            last = int(np.searchsorted(track.index, sent + n))
            self.publish(track.topic, *track.messages[first:last])
        return min(n, self.run.sheet.samples - sent)

    def soft_stop(self) -> int:
        return self.run.sent

    def _recorded(self, sheet: RunSheet | None, stamps: Stamps) -> RunSheet:
        if len(stamps) == 0:
            raise BagError(f'{self.spec.text("bag")} has nothing on {self.spec.text("topics")}')
        if sheet:
            samples = sheet.samples
            if self.spec.text('topics') == 'imu':
                samples = min(samples, int(stamps[-1] - sheet.start_ns) // sheet.step_ns + 1)
            return sheet.replace(samples=samples)
        if self.spec.text('topics') == 'motion':
            raise InputError(
                'this bag has no run sheet on rig/run; only topics:=imu can be replayed'
            )
        step = int(np.median(np.diff(stamps))) if len(stamps) > 1 else 1
        return RunSheet(
            step_ns=step,
            samples=int(stamps[-1] - stamps[0]) // step + 1,
            mode='real_time',
            chunk=40,
            start_ns=int(stamps[0]),
            scenario='replay',
        )


def main() -> None:
    """`ros2 run qzs_rig player`."""
    leave(run(Player))


if __name__ == '__main__':
    main()
