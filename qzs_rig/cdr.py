"""CDR, the serialisation of ROS 2 messages (little endian, OMG XCDR1), one field at a time."""

from __future__ import annotations

import struct

from qzs_rig.errors import InputError

HEADER = b'\x00\x01\x00\x00'


class CdrWriter:
    """Appends fields, each aligned to its own size from the end of the encapsulation header."""

    def __init__(self) -> None:
        self._buffer = bytearray(HEADER)

    def align(self, size: int) -> None:
        """Pad with zeros up to a multiple of `size`."""
        self._buffer += bytes(-(len(self._buffer) - 4) % size)

    def byte(self, value: int) -> None:
        """An octet."""
        self._buffer.append(value)

    def u32(self, value: int) -> None:
        """uint32; also the length in front of a sequence."""
        self.align(4)
        self._buffer += struct.pack('<I', value)

    def time(self, stamp_ns: int) -> None:
        """builtin_interfaces/Time or Duration."""
        seconds, nanoseconds = divmod(stamp_ns, 1_000_000_000)
        self.align(4)
        self._buffer += struct.pack('<iI', seconds, nanoseconds)

    def f64s(self, values: list[float]) -> None:
        """A sequence of float64."""
        self.u32(len(values))
        if values:
            self.align(8)
            self._buffer += struct.pack(f'<{len(values)}d', *values)

    def f64(self, value: float) -> None:
        """One float64."""
        self.align(8)
        self._buffer += struct.pack('<d', value)

    def string(self, text: str) -> None:
        """A string with its closing zero."""
        encoded = text.encode() + b'\x00'
        self.u32(len(encoded))
        self._buffer += encoded

    def strings(self, texts: tuple[str, ...]) -> None:
        """A sequence of strings."""
        self.u32(len(texts))
        for text in texts:
            self.string(text)

    def bytes(self) -> bytes:
        """The message so far."""
        return bytes(self._buffer)


class CdrReader:
    """Reads fields in order; raises InputError where the message is too short or not CDR."""

    def __init__(self, message: bytes) -> None:
        if len(message) < 4 or message[:2] != HEADER[:2]:
            raise InputError(
                f'message starts with {bytes(message[:4]).hex()}, not with little-endian CDR; '
                'record it with an XCDR1 middleware'
            )
        self._message = message
        self.offset = 4

    def align(self, size: int) -> None:
        """Skip padding up to a multiple of `size`."""
        self.offset += -(self.offset - 4) % size

    def byte(self) -> int:
        """An octet."""
        return int(self._take('<B', 1)[0])

    def u32(self) -> int:
        """uint32 or a sequence length."""
        return int(self._take('<I', 4)[0])

    def time(self) -> int:
        """builtin_interfaces/Time in ns."""
        seconds, nanoseconds = self._take('<iI', 4)
        return int(seconds) * 1_000_000_000 + int(nanoseconds)

    def string(self) -> str:
        """A string without its closing zero."""
        length = self.u32()
        raw = self._message[self.offset : self.offset + length]
        if len(raw) < length:
            raise InputError(f'message ends inside a string of {length} bytes; it is damaged')
        self.offset += length
        return bytes(raw[:-1]).decode(errors='replace')

    def _take(self, layout: str, alignment: int) -> tuple[float, ...]:
        self.align(alignment)
        try:
            values = struct.unpack_from(layout, self._message, self.offset)
        except struct.error:
            raise InputError(
                f'message of {len(self._message)} bytes is too short for its type'
            ) from None
        self.offset += struct.calcsize(layout)
        return values
