"""The bag that a run leaves behind, written by the analyzer node and by the in-process run."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from qzs_rig import wire
from qzs_rig.bag import BagWriter, TopicSpec
from qzs_rig.run.sheet import RunSheet
from qzs_rig.samples import Stamps
from qzs_rig.wire import Bytes


class Recording:
    """The bag of one run: messages as they are, at the times of their stamps (n,).

    `messages` are n serialised ones, in a sequence or, of one length, as rows (n, length).
    """

    def __init__(self, folder: Path, base_topic: str, top_topic: str) -> None:
        """Opens `folder` as a new bag with `base/motion`, the two Imu topics and `rig/run`."""
        imus = (wire.BASE_IMU._replace(name=base_topic), wire.TOP_IMU._replace(name=top_topic))
        topics = (wire.BASE_MOTION, *imus, wire.RUN)
        self.folder = folder
        self._base, self._top = base_topic, top_topic
        self._writer = BagWriter(folder, [TopicSpec(*topic) for topic in topics])

    def sheet(self, stamp_ns: int, sheet: RunSheet) -> None:
        """Keep the run sheet."""
        self._writer.write(wire.RUN.name, [stamp_ns], [wire.encode_json(sheet.to_document())])

    def motion(self, stamps_ns: Sequence[int] | Stamps, messages: Sequence[bytes] | Bytes) -> None:
        """Keep chunks of base motion."""
        self._writer.write(wire.BASE_MOTION.name, stamps_ns, messages)

    def base(self, stamps_ns: Stamps, messages: Sequence[bytes] | Bytes) -> None:
        """Keep messages of the base sensor."""
        self._writer.write(self._base, stamps_ns, messages)

    def top(self, stamps_ns: Stamps, messages: Sequence[bytes] | Bytes) -> None:
        """Keep messages of the top sensor."""
        self._writer.write(self._top, stamps_ns, messages)

    def tick(self) -> None:
        """Hand over what has waited long enough."""
        self._writer.tick()

    def close(self) -> None:
        """Finish the bag; a second call does nothing."""
        self._writer.close()
