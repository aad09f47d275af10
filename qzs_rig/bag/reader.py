"""Reads a bag: messages in log-time order, or all messages of a topic as arrays."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import Any

import numpy as np

from qzs_rig.bag.folder import bag_file
from qzs_rig.bag.limits import Limits
from qzs_rig.bag.mcap_source import McapSource
from qzs_rig.bag.records import Bytes, MessageBlock, Offsets, Stamps
from qzs_rig.bag.sqlite_source import SqliteSource
from qzs_rig.bag.topics import Channel, absolute
from qzs_rig.errors import BagError

RUN_SHEET = '/rig/run'
STRING = 'std_msgs/msg/String'


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
        limits = limits or Limits()
        self.path = bag_file(path)
        self._source: McapSource | SqliteSource
        if self.path.suffix == '.db3':
            self._source = SqliteSource(self.path, limits)
        else:
            self._source = McapSource(self.path, limits)

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
        for block in ordered(self._source, frozenset(names)):
            stamped = zip(
                block.channels.tolist(), block.stamps_ns.tolist(), block.payloads(), strict=True
            )
            for channel, stamp_ns, message in stamped:
                yield names[channel], stamp_ns, message

    def rows(self, topic: str, msgtype: str | None = None) -> TopicRows:
        """All messages of one topic; raises BagError if it is missing or not of `msgtype`."""
        channels = self._channels_of([topic])
        name, found = channels[0].topic, self.topics[channels[0].topic]
        if msgtype is not None and found != msgtype:
            raise BagError(
                f'{self.path}: topic {name} is {found}, not {msgtype}; name another topic'
            )
        ids = frozenset(channel.id for channel in channels)
        blocks = list(ordered(self._source, ids))
        return TopicRows(
            topic=name,
            msgtype=found,
            stamps_ns=np.concatenate([np.empty(0, np.int64), *(x.stamps_ns for x in blocks)]),
            lengths=np.concatenate([np.empty(0, np.int64), *(x.lengths for x in blocks)]),
            data=np.concatenate([np.empty(0, np.uint8), *(x.packed() for x in blocks)]),
        )

    def run_sheets(self) -> list[dict[str, Any]]:
        """The JSON documents of rig/run, of any namespace, by log time; BagError for others."""
        return run_sheets(self._source)

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


def ordered(source: McapSource | SqliteSource, channels: frozenset[int]) -> Iterator[MessageBlock]:
    """Blocks whose messages go by log time, within and across blocks, those of equal time as they
    lie in the file; holds back what a later block may still undercut."""
    held: list[tuple[int, MessageBlock]] = []
    for start_ns, at, block in source.blocks(channels):
        early = [(place, waiting, waiting.stamps_ns < start_ns) for place, waiting in held]
        yield from _merged((place, waiting.select(mask)) for place, waiting, mask in early)
        held = [(place, waiting.select(~mask)) for place, waiting, mask in early if not mask.all()]
        held.append((at, block))
    yield from _merged(held)


def _merged(placed: Iterable[tuple[int, MessageBlock]]) -> Iterator[MessageBlock]:
    in_file_order = sorted(placed, key=lambda entry: entry[0])
    blocks = [block for _, block in in_file_order if len(block)]
    if len(blocks) == 1:
        block = blocks[0]
        in_order = (np.diff(block.stamps_ns) >= 0).all()
        yield block if in_order else block.select(np.argsort(block.stamps_ns, kind='stable'))
    elif blocks:
        lengths = np.concatenate([block.lengths for block in blocks])
        joined = MessageBlock(
            data=np.concatenate([block.packed() for block in blocks]),
            channels=np.concatenate([block.channels for block in blocks]),
            stamps_ns=np.concatenate([block.stamps_ns for block in blocks]),
            starts=np.cumsum(lengths) - lengths,
            lengths=lengths,
        )
        yield joined.select(np.argsort(joined.stamps_ns, kind='stable'))


def run_sheets(source: McapSource | SqliteSource) -> list[dict[str, Any]]:
    """The run sheets of a source; raises BagError for a sheet that is no JSON document."""
    ids = {
        channel.id
        for channel in source.channels.values()
        if channel.topic.endswith(RUN_SHEET) and channel.msgtype == STRING
    }
    messages = (x for block in ordered(source, frozenset(ids)) for x in block.payloads())
    return [_sheet(source.path, message) for message in messages] if ids else []


def _sheet(path: Path, message: bytes) -> dict[str, Any]:
    """CDR of std_msgs/String: 4 bytes of encapsulation, uint32 length, text, terminating zero."""
    order = 'little' if message[1:2] == b'\x01' else 'big'
    length = int.from_bytes(message[4:8], 'little' if order == 'little' else 'big')
    try:
        document = json.loads(message[8 : 8 + length].rstrip(b'\x00').decode())
    except ValueError as error:
        raise BagError(f'{path}: a run sheet on rig/run is no JSON ({error})') from error
    if not isinstance(document, dict):
        raise BagError(
            f'{path}: a run sheet on rig/run is no JSON object; another node used rig/run'
        )
    return document
