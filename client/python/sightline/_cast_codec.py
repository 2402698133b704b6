"""Casts on the wire: requests put together from the buffers of arrays, answers as views of the received bytes."""

from __future__ import annotations

from typing import Any, Dict, List, NamedTuple, Optional, Set, Tuple

import numpy as np

from . import _proto, _wire, errors
from ._arrays import Rows
from ._query import COLUMNS, NAME_OF
from ._types import Array
from .points import Points


def _numbers(message: Any) -> "Dict[str, int]":
    return {field.name: field.number for field in message.DESCRIPTOR.fields}


class _Source(NamedTuple):
    """How rays or points stand in a request."""

    number: int               # of the field that has them
    fields: "Dict[str, int]"  # numbers in that field
    columns: Tuple[str, ...]  # as Rows.columns() lists them


_RAYS = _Source(_numbers(_proto.CastRaysRequest)["rays"], _numbers(_proto.Rays),
                ("origins", "directions", "tmin", "tmax", "masks"))
_POINTS = _Source(_numbers(_proto.QueryPointsRequest)["points"], _numbers(_proto.Points),
                  ("positions", "max_distance", "masks"))
# Answers, and what streams put around messages, have the same numbers for points.
_RESPONSE = _numbers(_proto.CastRaysResponse)
_COLUMN = _numbers(_proto.HitColumn)
_STREAM_REQUEST = _numbers(_proto.StreamCastRaysRequest)
_STREAM_RESPONSE = _numbers(_proto.StreamCastRaysResponse)


def request_parts(description: bytes, rays: Rows, begin: int, end: int) -> "List[Any]":
    """A CastRaysRequest of some rays, or a QueryPointsRequest of some points, as buffers to be joined. `description` is
    the request without them."""
    source = _POINTS if isinstance(rays, Points) else _RAYS
    numbers = source.fields
    parts: "List[Any]" = [_wire.number_field(numbers["float64"], rays.dtype.itemsize == 8)]
    parts.append(_wire.number_field(numbers["count"], end - begin))
    for name, column in zip(source.columns, rays.columns()):
        if column is not None and end > begin:
            rows = np.ascontiguousarray(column[begin:end])
            parts += [_wire.bytes_header(numbers[name], rows.nbytes), rows.data.cast("B")]
    return [description, _wire.bytes_header(source.number, _length(parts)), *parts]


def stream_request(chunk: int, request: "List[Any]") -> bytes:
    """A StreamCastRaysRequest, or StreamQueryPointsRequest, of the parts of a request."""
    return b"".join([_wire.number_field(_STREAM_REQUEST["chunk"], chunk),
                     _wire.bytes_header(_STREAM_REQUEST["request"], _length(request)), *request])


def _length(parts: "List[Any]") -> int:
    return sum(map(len, parts))


class Answer:
    """A decoded CastRaysResponse or QueryPointsResponse. `columns` are views of the received bytes, by name; names of
    nodes are str objects."""

    def __init__(self, data: memoryview):
        self.columns: "Dict[str, Array]" = {}
        self.revision = 0
        self.token = ""
        self.stats: Optional[Any] = None
        self.applied: Optional[Any] = None  # a message ApplyUpdatesResponse, if there were updates
        self.first_ray = 0
        self.more = False
        self.in_place: "Set[str]" = set()  # columns that are where the caller wants them
        self._names: "List[str]" = []
        for number, value in _wire.fields(data):
            if number == _RESPONSE["columns"]:
                self._add_column(value)
            elif number == _RESPONSE["served"]:
                served = _proto.SceneRevision.FromString(bytes(value))
                self.revision, self.token = served.revision, served.token
            elif number == _RESPONSE["stats"]:
                self.stats = _proto.CastStats.FromString(bytes(value))
            elif number == _RESPONSE["first_ray"]:
                self.first_ray = value
            elif number == _RESPONSE["more"]:
                self.more = bool(value)
            elif number == _RESPONSE["applied"]:
                self.applied = _proto.ApplyUpdatesResponse.FromString(bytes(value))
            elif number == _RESPONSE["names"]:
                self._names.append(str(value, "utf-8"))
        if "name" in self.columns:
            self._put_names()

    def put(self, name: str, rows: Array) -> None:
        """Adds a column of a segment. Errors: Internal, a row has no name."""
        if name != "name":
            self.columns[name] = rows
            return
        self.columns[name] = rows.copy()  # another process cannot change it after it is checked
        try:
            self._put_names()
        except ValueError as error:
            raise errors.Internal(str(error)) from None

    def _add_column(self, data: memoryview) -> None:
        field, content = 0, memoryview(b"")
        for number, value in _wire.fields(data):
            if number == _COLUMN["field"]:
                field = value
            elif number == _COLUMN["data"]:
                content = value
        name = NAME_OF.get(field)
        if name is None:
            return
        column = COLUMNS[name]
        rows = np.frombuffer(content, column.dtype) if len(content) else np.empty(0, column.dtype)
        self.columns[name] = rows.reshape(-1, *column.row)

    def _put_names(self) -> None:
        rows, names = self.columns["name"], self._names
        if len(rows) and rows.max() >= len(names):
            raise ValueError(f"the server's answer names row {rows.max()} of {len(names)} names")
        self.columns["name"] = np.array(names, object)[rows] if names else np.empty(0, object)

    def rows(self, name: str, count: int) -> Array:
        """A column that must have so many rows."""
        column = self.columns.get(name)
        if column is None or len(column) != count:
            got = "none" if column is None else len(column)
            raise errors.Internal(f"the server answered {got} rows of {name} instead of {count}")
        return column


def answer(data: bytes) -> Answer:
    """The answer of CastRays or QueryPoints."""
    try:
        return Answer(memoryview(data))
    except ValueError as error:
        raise errors.Internal(str(error)) from None


def stream_answer(data: bytes) -> "tuple[int, Answer]":
    """An answer of StreamCastRays or StreamQueryPoints: the number of the chunk that it answers, and the answer."""
    chunk, response = 0, memoryview(b"")
    try:
        for number, value in _wire.fields(memoryview(data)):
            if number == _STREAM_RESPONSE["chunk"]:
                chunk = value
            elif number == _STREAM_RESPONSE["response"]:
                response = value
        return chunk, Answer(response)
    except ValueError as error:
        raise errors.Internal(str(error)) from None
