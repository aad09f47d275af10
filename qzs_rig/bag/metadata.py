"""metadata.yaml, version 9, as rosbag2 writes it beside a bag."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from pathlib import Path

from qzs_rig.bag.topics import Channel

NEVER_NS = 2**63 - 1
"""Start of a bag without messages, as rosbag2 gives it."""

QOS_LINE = re.compile(r'^(- | {2,})\w+:( [\w.]+)?$')


def information(
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


def save(folder: Path, text: str) -> None:
    """Replace metadata.yaml as a whole: a reader sees the old one or the new one."""
    lines = ''.join(f'  {line}\n' for line in text.splitlines())
    temporary = folder / '.metadata.yaml.tmp'
    try:
        temporary.write_text(f'rosbag2_bagfile_information:\n{lines}', encoding='utf-8')
        temporary.replace(folder / 'metadata.yaml')
    except OSError:
        temporary.unlink(missing_ok=True)
        raise


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
