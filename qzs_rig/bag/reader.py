"""Reads a bag: its messages in log-time order, or all messages of a topic as arrays."""

from __future__ import annotations

import json
import sqlite3
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import Any, Protocol

import numpy as np

from qzs_rig.bag.folder import Channel, absolute, bag_file, typestore
from qzs_rig.bag.mcap_source import McapSource
from qzs_rig.bag.records import Bytes, MessageBlock, Offsets, Stamps
from qzs_rig.bag.scan import Limits
from qzs_rig.errors import BagError

RUN_SHEET = '/rig/run'
STRING = 'std_msgs/msg/String'
BATCH = 4096


class Source(Protocol):
    """A storage file of any kind."""

    path: Path
    closed: bool
    damage: list[str]

    @property
    def channels(self) -> Mapping[int, Channel]:
        """What the file says about its topics, as far as it is read."""

    def blocks(self, channels: frozenset[int] | None = None) -> Iterator[MessageBlock]:
        """The messages of some channels, or of all, as they lie in the file."""

    def close(self) -> None:
        """Let go of the file."""


def source_of(file: Path, limits: Limits, *, lenient: bool = False) -> Source:
    """The storage `file`, opened; what is damaged in MCAP raises BagError or, if `lenient`, is
    listed in `damage`."""
    if file.suffix == '.db3':
        return SqliteSource(file, limits)
    return McapSource(file, limits, lenient=lenient)


class SqliteSource:
    """A rosbag2 SQLite file (.db3), as older recorders write by default; it has no CRCs."""

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

    def blocks(self, channels: frozenset[int] | None = None) -> Iterator[MessageBlock]:
        """The messages of some channels, or of all, by log time."""
        wanted = ','.join(map(str, sorted(self.channels if channels is None else channels)))
        query = (
            'SELECT topic_id, timestamp, length(data), data FROM messages '
            f'WHERE topic_id IN ({wanted}) ORDER BY timestamp, id'
        )
        try:
            cursor = self._base.execute(query)
            while batch := cursor.fetchmany(BATCH):
                yield _block(batch)
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


@dataclass(frozen=True)
class TopicRows:
    """All messages of a topic by log time: stamps (n,), lengths (n,), payloads back to back."""

    topic: str
    msgtype: str
    stamps_ns: Stamps
    lengths: Offsets
    data: Bytes

    def __len__(self) -> int:
        return len(self.stamps_ns)

    @property
    def equal(self) -> bool:
        """All messages have one length, so that `rows` exists."""
        return bool((self.lengths == self.lengths[:1]).all())

    @property
    def rows(self) -> Bytes:
        """The messages (n, length) uint8; raises BagError where their lengths differ."""
        if not self.equal:
            raise BagError(
                f'messages of {self.topic} have {self.lengths.min()} to {self.lengths.max()} '
                'bytes; take them one by one'
            )
        return self.data.reshape(len(self), int(self.lengths[0]) if len(self) else 0)

    def messages(self) -> list[bytes]:
        """The messages one by one."""
        ends = np.cumsum(self.lengths)
        buffer = self.data.tobytes()
        bounds = zip((ends - self.lengths).tolist(), ends.tolist(), strict=True)
        return [buffer[start:end] for start, end in bounds]


class BagReader:
    """A closed bag at `path`: bag folder, run folder with `bag/` in it, .mcap or .db3 file.

    Raises BagError, also for a bag that was not closed, is damaged or goes beyond `limits`.
    """

    def __init__(self, path: Path, limits: Limits | None = None) -> None:
        self.path = bag_file(path)
        self._source = source_of(self.path, limits or Limits())

    @property
    def topics(self) -> dict[str, str]:
        """Message type of each topic; raises BagError for a topic of two types."""
        types: dict[str, str] = {}
        for channel in self._source.channels.values():
            known = types.setdefault(channel.topic, channel.msgtype)
            if known != channel.msgtype:
                raise BagError(
                    f'{self.path}: topic {channel.topic} is both {known} and {channel.msgtype}; '
                    'record it under two names'
                )
        return dict(sorted(types.items()))

    @property
    def channels(self) -> tuple[Channel, ...]:
        """What the bag says about its topics, by channel id."""
        return tuple(channel for _, channel in sorted(self._source.channels.items()))

    def messages(self, topics: Sequence[str] | None = None) -> Iterator[tuple[str, int, bytes]]:
        """(topic, log time, CDR bytes) by log time, those of equal time as they lie in the file."""
        channels = self._channels_of(list(self.topics) if topics is None else topics)
        names = {channel.id: channel.topic for channel in channels}
        found = by_time(self._source.blocks(frozenset(names)))
        for channel, stamp_ns, message in zip(
            found.channels.tolist(), found.stamps_ns.tolist(), found.payloads(), strict=True
        ):
            yield names[channel], stamp_ns, message

    def rows(self, topic: str, msgtype: str | None = None) -> TopicRows:
        """All messages of one topic; raises BagError if it is missing or not of `msgtype`."""
        channels = self._channels_of([topic])
        name, found = channels[0].topic, self.topics[channels[0].topic]
        if msgtype is not None and found != msgtype:
            raise BagError(
                f'{self.path}: topic {name} is {found}, not {msgtype}; name another topic'
            )
        block = by_time(self._source.blocks(frozenset(channel.id for channel in channels)))
        return TopicRows(name, found, block.stamps_ns, block.lengths, block.packed())

    def run_sheets(self) -> list[dict[str, Any]]:
        """The JSON documents of rig/run, of any namespace, by log time; BagError for others."""
        ids = frozenset(channel.id for channel in self.channels if is_run_sheet(channel))
        if not ids:
            return []
        return [sheet_in(self.path, raw) for raw in by_time(self._source.blocks(ids)).payloads()]

    def close(self) -> None:
        """Let go of the file."""
        self._source.close()

    def __enter__(self) -> BagReader:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self.close()

    def _channels_of(self, topics: Sequence[str]) -> list[Channel]:
        names = {self._resolve(topic) for topic in topics}
        return [channel for channel in self.channels if channel.topic in names]

    def _resolve(self, topic: str) -> str:
        """The topic of that name, or the only one of that name in a namespace."""
        name, known = absolute(topic), list(self.topics)
        if name in known or topic in known:
            return name if name in known else topic
        spaced = [other for other in known if other.endswith(name)]
        if len(spaced) == 1:
            return spaced[0]
        several = f'is one of {", ".join(spaced)}; ' if spaced else 'is not in it; '
        raise BagError(f'{self.path}: topic {name} {several}take one of {", ".join(known)}')


def by_time(blocks: Iterable[MessageBlock]) -> MessageBlock:
    """One block of all messages by log time, those of equal time as they lie in the file."""
    parts = list(blocks)
    lengths, data, channels, stamps_ns = (
        np.concatenate([np.empty(0, kind), *columns])
        for kind, columns in (
            (np.int64, (block.lengths for block in parts)),
            (np.uint8, (block.packed() for block in parts)),
            (np.uint16, (block.channels for block in parts)),
            (np.int64, (block.stamps_ns for block in parts)),
        )
    )
    joined = MessageBlock(data, channels, stamps_ns, np.cumsum(lengths) - lengths, lengths)
    if (np.diff(stamps_ns) >= 0).all():
        return joined
    return joined.select(np.argsort(stamps_ns, kind='stable'))


def is_run_sheet(channel: Channel) -> bool:
    """Whether a topic is rig/run, of any namespace."""
    return channel.topic.endswith(RUN_SHEET) and channel.msgtype == STRING


def sheet_in(path: Path, message: bytes) -> dict[str, Any]:
    """The run sheet in a serialised std_msgs/String; raises BagError where it is no document."""
    from rosbags.serde import SerdeError

    try:
        text: Any = typestore().deserialize_cdr(message, STRING)
        document = json.loads(text.data)
    except (SerdeError, ValueError, RecursionError) as error:
        raise BagError(f'{path}: a run sheet on rig/run is no JSON ({error})') from error
    if not isinstance(document, dict):
        raise BagError(
            f'{path}: a run sheet on rig/run is no JSON object; another node used rig/run'
        )
    return document
