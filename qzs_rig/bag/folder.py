"""The folder of a bag as rosbag2 lays it out: which storage file a path means (bag folder, run
folder, the file), a new folder, and metadata.yaml, version 9."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache, lru_cache
from pathlib import Path
from typing import TYPE_CHECKING

from qzs_rig import files
from qzs_rig.errors import BagError


@dataclass(frozen=True)
class TopicSpec:
    """A topic to record, with the profile its publisher offers: reliable, keep last `depth`,
    `latched` for late joiners or volatile."""

    name: str
    msgtype: str
    depth: int = 2000
    latched: bool = False


@dataclass(frozen=True)
class Channel:
    """A topic as it stands in a bag: MCAP channel and schema in one."""

    id: int
    topic: str
    msgtype: str
    definition: bytes
    schema_encoding: str = 'ros2msg'
    message_encoding: str = 'cdr'
    metadata: Mapping[str, str] = field(default_factory=dict)

    @property
    def offered_qos(self) -> str:
        """The offered profiles, YAML as rosbag2 writes it; empty when the recorder kept none."""
        return self.metadata.get('offered_qos_profiles', '')

    @property
    def type_hash(self) -> str:
        """RIHS01 hash of the type (REP 2011); empty when the recorder kept none."""
        return self.metadata.get('topic_type_hash', '')


def absolute(topic: str) -> str:
    """The name as rosbag2 writes it: with a leading slash."""
    return '/' + topic.lstrip('/')


def declare(spec: TopicSpec, channel_id: int) -> Channel:
    """The channel of a topic to record; raises BagError for a type nobody knows."""
    definition, type_hash = definition_of(spec.msgtype)
    return Channel(
        id=channel_id,
        topic=absolute(spec.name),
        msgtype=spec.msgtype,
        definition=definition.encode(),
        metadata={'offered_qos_profiles': qos_text(spec), 'topic_type_hash': type_hash},
    )


@cache
def typestore() -> Typestore:
    """The messages of ROS 2 Kilted; imported when the first one is met."""
    from rosbags.typesys import Stores, get_typestore

    return get_typestore(Stores.ROS2_KILTED)


@lru_cache(maxsize=64)
def definition_of(msgtype: str) -> tuple[str, str]:
    """Full ros2msg definition and RIHS01 hash of a message type of ROS 2 Kilted."""
    from rosbags.typesys import TypesysError

    store = typestore()
    try:
        definition, _ = store.generate_msgdef(msgtype, ros_version=2)
        return definition, store.hash_rihs01(msgtype)
    except (TypesysError, KeyError):
        raise BagError(
            f'message type {msgtype!r} is not one of ROS 2 Kilted; '
            'give it as package/msg/Name, for instance sensor_msgs/msg/Imu'
        ) from None


def qos_text(spec: TopicSpec) -> str:
    """The offered profile as rosbag2 writes it (metadata version 9)."""
    durability = 'transient_local' if spec.latched else 'volatile'
    for_ever = '\n    sec: 9223372036\n    nsec: 854775807'
    return (
        f'- history: keep_last\n  depth: {spec.depth}\n'
        f'  reliability: reliable\n  durability: {durability}\n'
        f'  deadline:{for_ever}\n  lifespan:{for_ever}\n'
        f'  liveliness: automatic\n  liveliness_lease_duration:{for_ever}\n'
        '  avoid_ros_namespace_conventions: false'
    )


if TYPE_CHECKING:
    from rosbags.typesys.store import Typestore

SUFFIXES = ('.mcap', '.db3')
COMPRESSED = re.compile(r'^\s*compression_mode:\s*["\']?(file|message)\b', re.IGNORECASE | re.M)

NEVER_NS = 2**63 - 1
"""Start of a bag without messages, as rosbag2 gives it."""

QOS_LINE = re.compile(r'^(- | {2,})\w+:( [\w.]+)?$')


def bag_file(path: Path) -> Path:
    """The one storage file at `path`; raises BagError naming what is there instead."""
    path = Path(path)
    if not path.exists():
        raise BagError(f'{path} does not exist; give a bag folder, a run folder or an .mcap file')
    if path.is_file():
        if path.suffix not in SUFFIXES:
            raise BagError(f'{path} is not a bag; give a bag folder, a run folder or an .mcap file')
        return path
    if (path / 'bag').is_dir() and not _storages(path):
        return bag_file(path / 'bag')
    _refuse_compressed(path)
    found = _storages(path)
    if not found:
        raise BagError(f'{path} holds no bag (no .mcap, no .db3); give the folder of a run')
    if len(found) > 1:
        names = ', '.join(file.name for file in found)
        raise BagError(f'{path} holds {len(found)} bags ({names}); give one of these files')
    return found[0]


def new_folder(folder: Path) -> Path:
    """`folder`, made where it is missing; raises BagError where something lies already."""
    folder = Path(folder)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        occupied = any(folder.iterdir())
    except OSError as error:
        raise BagError(
            f'bag folder {folder} cannot be made ({error.strerror}); choose another'
        ) from error
    if occupied:
        raise BagError(f'bag folder {folder} is not empty; choose a new one or move it away')
    return folder


def _storages(folder: Path) -> list[Path]:
    return sorted(file for file in folder.iterdir() if file.suffix in SUFFIXES)


def _refuse_compressed(folder: Path) -> None:
    """rosbag2 can compress whole files or single messages; MCAP compresses its chunks itself."""
    description = folder / 'metadata.yaml'
    if not description.is_file():
        return
    with description.open(encoding='utf-8', errors='replace') as text:
        mode = COMPRESSED.search(text.read(1 << 22))
    if mode:
        raise BagError(
            f'{folder} is compressed by {mode[1].lower()}, which only rosbag2 unpacks; '
            'convert it with `ros2 bag convert` to uncompressed MCAP'
        )


def metadata_text(
    file_name: str,
    channels: Mapping[int, Channel],
    counts: Mapping[int, int],
    start_ns: int | None,
    end_ns: int | None,
) -> str:
    """The content of rosbag2_bagfile_information as YAML."""
    start = NEVER_NS if start_ns is None else start_ns
    duration = 0 if start_ns is None or end_ns is None else end_ns - start_ns
    total = sum(counts.values())
    topics = ''.join(_topic(channels[x], counts.get(x, 0)) for x in sorted(channels))
    name = json.dumps(file_name)
    return (
        'version: 9\n'
        'storage_identifier: mcap\n'
        f'duration:\n  nanoseconds: {duration}\n'
        f'starting_time:\n  nanoseconds_since_epoch: {start}\n'
        f'message_count: {total}\n'
        f'topics_with_message_count:{topics or " []"}\n'
        'compression_format: ""\n'
        'compression_mode: ""\n'
        f'relative_file_paths:\n  - {name}\n'
        f'files:\n  - path: {name}\n'
        f'    starting_time:\n      nanoseconds_since_epoch: {start}\n'
        f'    duration:\n      nanoseconds: {duration}\n'
        f'    message_count: {total}\n'
        'custom_data: ~\n'
        'ros_distro: kilted'
    )


def save_metadata(folder: Path, text: str) -> None:
    """Replace metadata.yaml as a whole: a reader sees the old one or the new one."""
    lines = ''.join(f'  {line}\n' for line in text.splitlines())
    files.rewrite(folder / 'metadata.yaml', f'rosbag2_bagfile_information:\n{lines}')


def _topic(channel: Channel, count: int) -> str:
    return (
        f'\n  - topic_metadata:\n'
        f'      name: {json.dumps(channel.topic)}\n'
        f'      type: {json.dumps(channel.msgtype)}\n'
        f'      serialization_format: {json.dumps(channel.message_encoding)}\n'
        f'      offered_qos_profiles:{_qos(channel.offered_qos)}\n'
        f'      type_description_hash: {json.dumps(channel.type_hash)}\n'
        f'    message_count: {count}'
    )


def _qos(text: str) -> str:
    """Profiles nested as version 9 wants them; those of older recorders (numbers) are left out."""
    lines = text.splitlines()
    if not lines or not all(map(QOS_LINE.match, lines)) or not re.search(r'history: [a-z]', text):
        return ' []'
    return ''.join(f'\n        {line}' for line in lines)
