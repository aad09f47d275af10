"""Messages of a rosbag2 SQLite file (.db3), which older recorders write by default."""

from __future__ import annotations

import sqlite3
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from qzs_rig.bag.limits import Limits
from qzs_rig.bag.records import MessageBlock
from qzs_rig.bag.topics import Channel
from qzs_rig.errors import BagError

BATCH = 4096


class SqliteSource:
    """The same face as McapSource; such a file has neither chunks nor CRCs."""

    def __init__(self, path: Path, limits: Limits) -> None:
        self.path = path
        self.closed = True
        self.damage: list[str] = []
        self.channels: dict[int, Channel] = {}
        self._limits = limits
        try:
            self._base = sqlite3.connect(f'{path.resolve().as_uri()}?mode=ro', uri=True)
            self._read_channels()
        except sqlite3.Error as error:
            raise self._failure(error) from error

    def close(self) -> None:
        """Let go of the file."""
        self._base.close()

    def blocks(self, channels: frozenset[int]) -> Iterator[tuple[int, int, MessageBlock]]:
        """(first stamp, place, messages) in log-time order."""
        wanted = ','.join(str(channel) for channel in sorted(channels))
        query = (
            'SELECT topic_id, timestamp, length(data), data FROM messages '
            f'WHERE topic_id IN ({wanted}) ORDER BY timestamp, id'
        )
        try:
            cursor = self._base.execute(query)
            place = 0
            while batch := cursor.fetchmany(BATCH):
                yield int(batch[0][1]), place, _block(batch)
                place += 1
        except sqlite3.Error as error:
            raise self._failure(error) from error

    def _read_channels(self) -> None:
        query = 'SELECT id, name, type, serialization_format FROM topics ORDER BY id'
        for number, name, msgtype, encoding in self._base.execute(query):
            if len(self.channels) >= self._limits.channels:
                raise BagError(f'{self.path} has more than {self._limits.channels} topics')
            self.channels[number] = Channel(
                number, str(name), str(msgtype), b'', '', message_encoding=str(encoding)
            )

    def _failure(self, error: sqlite3.Error) -> BagError:
        return BagError(f'{self.path} is no readable SQLite bag ({error}); record as MCAP')


def _block(batch: list[tuple[int, int, int, bytes]]) -> MessageBlock:
    lengths = np.array([row[2] for row in batch], dtype=np.int64)
    return MessageBlock(
        data=np.frombuffer(b''.join(row[3] for row in batch), dtype=np.uint8),
        channels=np.array([row[0] for row in batch], dtype=np.uint16),
        stamps_ns=np.array([row[1] for row in batch], dtype=np.int64),
        starts=np.cumsum(lengths) - lengths,
        lengths=lengths,
    )
