"""The byte layout of the MCAP records that are built or parsed by the thousand (mcap.dev/spec)."""

from __future__ import annotations

import struct
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

Bytes = NDArray[np.uint8]
Stamps = NDArray[np.int64]

MAGIC = b'\x89MCAP0\r\n'

RECORD_HEAD = struct.Struct('<BQ')
"""Opcode, length of what follows."""

CHUNK_HEAD = struct.Struct('<QQQI')
"""First log time, last log time, uncompressed size, CRC-32 of the uncompressed records."""

MESSAGE_HEAD = np.dtype(
    [
        ('opcode', 'u1'),
        ('length', '<u8'),
        ('channel', '<u2'),
        ('sequence', '<u4'),
        ('log_time', '<u8'),
        ('publish_time', '<u8'),
    ]
)

MESSAGE_FIELDS = MESSAGE_HEAD.itemsize - RECORD_HEAD.size
"""Bytes of a message record between its head and its payload: 22."""


@lru_cache(maxsize=64)
def message_record(payload: int) -> np.dtype[Any]:
    """One whole message record with `payload` bytes, packed."""
    return np.dtype([*MESSAGE_HEAD.descr, ('payload', f'V{payload}')])
