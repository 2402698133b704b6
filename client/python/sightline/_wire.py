"""The encoding of messages, as far as casts need it: large `bytes` fields are the buffers of arrays, without copies.

A message is the concatenation of its fields. A field of bytes or of a message is a tag, a length and the content, so
that a message can be put together from buffers, and views of its fields can be had without decoding the rest.
"""

from __future__ import annotations

from typing import Any, Iterator, Tuple

_VARINT, _FIXED64, _BYTES, _FIXED32 = 0, 1, 2, 5


def varint(value: int) -> bytes:
    """An unsigned number, seven bits a byte, the lowest first."""
    out = bytearray()
    while value > 0x7F:
        out.append(value & 0x7F | 0x80)
        value >>= 7
    out.append(value)
    return bytes(out)


def number_field(number: int, value: int) -> bytes:
    """An unsigned or bool field."""
    return varint(number << 3 | _VARINT) + varint(value)


def bytes_header(number: int, length: int) -> bytes:
    """What stands before the content of a bytes or message field."""
    return varint(number << 3 | _BYTES) + varint(length)


def _read_varint(data: memoryview, at: int) -> Tuple[int, int]:
    value = shift = 0
    while True:
        if at >= len(data) or shift > 63:
            raise ValueError("the server's message is cut off")
        byte = data[at]
        at += 1
        value |= (byte & 0x7F) << shift
        if byte < 0x80:
            return value, at
        shift += 7


def fields(data: memoryview) -> Iterator[Tuple[int, Any]]:
    """The fields of a message in order: its number, and a number or a view. ValueError: not a whole message."""
    at = 0
    while at < len(data):
        tag, at = _read_varint(data, at)
        kind = tag & 7
        if kind == _VARINT:
            value, at = _read_varint(data, at)
            yield tag >> 3, value
            continue
        if kind == _BYTES:
            length, at = _read_varint(data, at)
        elif kind in (_FIXED32, _FIXED64):
            length = 8 if kind == _FIXED64 else 4
        else:
            raise ValueError("the server's message has a field of an unknown kind")
        if length > len(data) - at:
            raise ValueError("the server's message is cut off")
        yield tag >> 3, data[at:at + length]
        at += length
