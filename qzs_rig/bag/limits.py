"""What a bag from elsewhere may cost: checked before memory is spent on it."""

from __future__ import annotations

import zlib
from dataclasses import dataclass

MIB = 1 << 20


class DamageError(Exception):
    """A piece of a bag cannot be used; the caller knows the file and makes it a BagError."""


@dataclass(frozen=True)
class Limits:
    """Refused beyond: bytes of one expanded chunk, of one message definition, channels, and
    expanded bytes of the whole file per byte on disk (small files may reach `expanded_bytes`)."""

    chunk_bytes: int = 64 * MIB
    record_bytes: int = 4 * MIB
    channels: int = 4096
    expansion: int = 1000
    expanded_bytes: int = 256 * MIB

    def expanded(self, file_bytes: int) -> int:
        """Bytes all chunks of a file of `file_bytes` may hold together."""
        return max(self.expanded_bytes, self.expansion * file_bytes)


def expand(compression: str, data: bytes, size: int, crc: int, limits: Limits) -> bytes:
    """The records of a chunk that claims `size` bytes and `crc` (0: none); raises DamageError."""
    if size > limits.chunk_bytes:
        raise DamageError(f'claims {size} bytes, above the limit of {limits.chunk_bytes}')
    try:
        records = EXPANDERS[compression](data, size)
    except KeyError:
        known = ', '.join(filter(None, EXPANDERS))
        raise DamageError(f'compression {compression!r} is unknown, known are {known}') from None
    if len(records) != size:
        raise DamageError(f'claims {size} bytes and holds {len(records)}')
    if crc and zlib.crc32(records) != crc:
        raise DamageError(f'CRC {zlib.crc32(records):08x} is not the {crc:08x} it was written with')
    return records


def expand_torn(compression: str, data: bytes, size: int, limits: Limits) -> bytes:
    """As many bytes as the beginning of a chunk yields; never more than it claims."""
    if size > limits.chunk_bytes:
        return b''
    if compression == 'zstd':
        return _torn_zstd(data, size)
    return data[:size] if compression == '' else b''


def _plain(data: bytes, size: int) -> bytes:
    return data


def _zstd(data: bytes, size: int) -> bytes:
    """The content size in the frame decides what the library allocates: check it first."""
    import zstandard

    try:
        claimed = zstandard.frame_content_size(data)
        if claimed > size:
            raise DamageError(f'expands to {claimed} bytes, not to the {size} it claims')
        decompressor = zstandard.ZstdDecompressor(max_window_size=128 * MIB)
        return decompressor.decompress(data, max_output_size=size) if size else b''
    except zstandard.ZstdError as error:
        raise DamageError(f'zstd: {error}') from None


def _torn_zstd(data: bytes, size: int) -> bytes:
    import zstandard

    parts: list[bytes] = []
    produced = 0
    reader = zstandard.ZstdDecompressor(max_window_size=128 * MIB).stream_reader(data)
    try:
        while produced < size and (part := reader.read(min(MIB, size - produced))):
            parts.append(part)
            produced += len(part)
    except zstandard.ZstdError:
        pass  # the frame ends here: what came out before is whole
    return b''.join(parts)


def _lz4(data: bytes, size: int) -> bytes:
    import lz4.frame  # type: ignore[import-untyped]

    try:
        return bytes(lz4.frame.LZ4FrameDecompressor().decompress(data, max_length=size + 1))
    except RuntimeError as error:
        raise DamageError(f'lz4: {error}') from None


EXPANDERS = {'': _plain, 'zstd': _zstd, 'lz4': _lz4}
