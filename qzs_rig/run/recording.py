"""The bag that a run leaves behind, written by the analyzer node and by the in-process run."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from qzs_rig import wire
from qzs_rig.bag import BagWriter, TopicSpec
from qzs_rig.run.sheet import RunSheet
from qzs_rig.wire import Bytes, ImuBatch, Stamps, Topic


class Recording:
    """The bag of one run; stamps of the messages are the times in the bag."""

    def __init__(self, folder: Path, base_topic: str, top_topic: str) -> None:
        """Opens `folder` as a new bag with `base/motion`, the two Imu topics and `rig/run`."""
        imu = wire.BASE_IMU.type
        topics = (
            wire.BASE_MOTION,
            Topic(base_topic, imu, wire.BASE_IMU.depth),
            Topic(top_topic, imu, wire.TOP_IMU.depth),
            wire.RUN,
        )
        self.folder = folder
        self._base, self._top = base_topic, top_topic
        self._writer = BagWriter(
            folder,
            [
                TopicSpec(
                    topic.name,
                    topic.type,
                    topic.depth,
                    durability='transient_local' if topic.latched else 'volatile',
                )
                for topic in topics
            ],
        )

    def sheet(self, stamp_ns: int, sheet: RunSheet) -> None:
        """Keep the run sheet."""
        self._writer.write(wire.RUN.name, [stamp_ns], [wire.encode_json(sheet.to_document())])

    def motion(self, message: bytes) -> None:
        """Keep a chunk of base motion."""
        self._writer.write(wire.BASE_MOTION.name, [wire.stamp_of(message)], [message])

    def motions(self, starts_ns: Stamps, messages: Bytes) -> None:
        """Keep chunks of base motion that start at `starts_ns` (m,), messages (m, length)."""
        self._writer.write_rows(wire.BASE_MOTION.name, starts_ns, messages)

    def base(self, messages: Sequence[bytes] | Bytes) -> ImuBatch:
        """Keep messages of the base sensor; returns what is in them."""
        return self._imu(self._base, messages)

    def top(self, messages: Sequence[bytes] | Bytes) -> ImuBatch:
        """Keep messages of the top sensor; returns what is in them."""
        return self._imu(self._top, messages)

    def tick(self) -> None:
        """Hand over what has waited long enough."""
        self._writer.tick()

    def close(self) -> None:
        """Finish the bag; a second call does nothing."""
        self._writer.close()

    def _imu(self, topic: str, messages: Sequence[bytes] | Bytes) -> ImuBatch:
        rows = messages if isinstance(messages, np.ndarray) else wire.stack(messages)
        batch = wire.decode_imu(messages if rows is None else rows)
        if rows is None:
            self._writer.write(topic, batch.stamps_ns, list(messages))
        else:
            self._writer.write_rows(topic, batch.stamps_ns, rows)
        return batch
