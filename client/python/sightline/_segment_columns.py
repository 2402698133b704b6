"""Where the columns of a cast lie in a segment."""

from __future__ import annotations

import threading
from typing import TYPE_CHECKING, Any, Dict, Iterator, List, NamedTuple, Optional, Tuple

import numpy as np

from . import _proto, errors
from ._arrays import Rows
from ._query import COLUMNS, Query
from ._segment import Segment, aligned
from .points import Points

if TYPE_CHECKING:
    from ._cast_codec import Answer
    from ._connection import Connection

LEAST_ROWS = 8192       # a cast of fewer goes by messages: a call with a segment costs about as much as sending them
_REGIONS = 5            # one more than the messages that are on their way: that of the answer which is being copied
_REGION_BYTES = 2 << 20  # of rows that are copied: few enough to stay in the caches
_LEAST_IN_MESSAGE, _MOST_IN_MESSAGE, _MESSAGES = 16384, 65536, 8
_ROWS_AT_ONCE = 4096    # the server traces so many at a time
_MOST_NAMED = 16384     # rows of a message that asks for names, of which an answer has at most 2 MiB
_RAYS = ("origins", "directions", "tmin", "tmax", "masks")
_POINTS = ("positions", "max_distance", "masks")
_PROCESS_END = 0.5  # seconds that the end of a process may come after that of its connections


class SharedPiece(NamedTuple):
    """Rows of one message, whose answers are in a segment."""

    columns: "SegmentColumns"
    number: int
    begin: int
    end: int


class _Column(NamedTuple):
    """`given`: the caller's array (n, ...), of rays or for answers. It stays where it is if `offset` is set, else a part of
    each region is for it."""

    given: np.ndarray
    dtype: np.dtype
    row: Tuple[int, ...]
    offset: Optional[int]

    @property
    def row_bytes(self) -> int:
        return self.dtype.itemsize * int(np.prod(self.row, dtype=int))


class SegmentColumns:
    """The columns of one cast. Those that lie in the user's shared memory stay there; the others have regions, in turn.
    Use it in a `with` block, which frees the regions.

    `source` is Rows, or a message of what makes the rows; `answers` are arrays for the answers, by column."""

    @staticmethod
    def make(connection: "Connection", query: Query, source: Any, count: int, answers: "Dict[str, np.ndarray]",
             timeout: Optional[float]) -> "Optional[SegmentColumns]":
        """None: there is no segment, or no room. Errors: FailedPrecondition (MEMORY_ABANDONED), the server may still write
        to an array of `answers`."""
        pool = connection.segments
        found = {name: pool.find(array) for name, array in answers.items()}
        for name, segment in found.items():
            if segment is not None and segment.is_abandoned:
                raise errors.FailedPrecondition(f"{name} lies in shared memory that is not: {segment.why_not_shared}. Share "
                                                "new memory", "MEMORY_ABANDONED")
        if count < LEAST_ROWS or not answers:
            return None
        limits = pool.limits(timeout)
        if limits is None:
            return None
        most = min(limits.rows, _MOST_NAMED) if "name" in answers else limits.rows
        rows = _rows_of(source)
        users = [segment for segment in (*(pool.find(c) for c in rows.values()), *found.values()) if segment is not None]
        for user in [users[0], None] if users and users[0].is_shared else [None]:
            made = SegmentColumns(query, source, count, user, rows, answers, most)
            if made.message_rows and made._take(pool, timeout):
                return made
        return None

    def __init__(self, query: Query, source: Any, count: int, user: Optional[Segment], rows: "Dict[str, np.ndarray]",
                 answers: "Dict[str, np.ndarray]", most: int):
        self._query, self._source, self._count = query, source, count
        dtype = source.dtype.newbyteorder("<") if isinstance(source, Rows) else np.dtype("f8")
        self._rows = {name: _Column(array, np.dtype("<u4") if name == "masks" else dtype, array.shape[1:], None)
                      for name, array in rows.items()}
        self._answers = {name: _Column(array, COLUMNS[name].dtype, COLUMNS[name].row, None)
                         for name, array in answers.items()}
        if user is not None:
            self._stay_in(user)
        self._segment = user
        self._regions: Optional[int] = None
        self._lock = threading.Lock()  # gRPC's threads may still make a message when its call is over
        self._is_over = False
        if query.has_updates():  # one call, or none
            self._region_count, self.message_rows = 1, count if count <= most else 0
        else:
            copied = sum(column.row_bytes for column in self._copied().values())
            self._region_count, self.message_rows = _REGIONS, _message_rows(count, copied, most)
        self._places: "Dict[str, int]" = {}  # of copied columns in a region
        self._region_size = 0
        for name, column in self._copied().items():
            self._places[name] = self._region_size
            self._region_size += aligned(column.row_bytes * self.message_rows)

    def _copied(self) -> "Dict[str, _Column]":
        return {name: column for name, column in {**self._rows, **self._answers}.items() if column.offset is None}

    def _stay_in(self, user: Segment) -> None:
        stays = {name: column._replace(offset=user.offset_of(column.given))
                 for name, column in {**self._rows, **self._answers}.items()
                 if column.given.dtype == column.dtype and column.given.dtype.byteorder != ">"}
        ranges = sorted((column.offset, column.offset + column.given.nbytes, name in self._answers)
                        for name, column in stays.items() if column.offset is not None)
        for (_, end, is_answer), (begin, _, is_next_answer) in zip(ranges, ranges[1:]):
            if begin < end and (is_answer or is_next_answer):  # answers would be written over rows, or over others
                return
        self._rows.update((name, column) for name, column in stays.items() if name in self._rows)
        self._answers.update((name, column) for name, column in stays.items() if name in self._answers)

    def _take(self, pool: Any, timeout: Optional[float]) -> bool:
        self._pool, size = pool, self._region_count * self._region_size
        if self._segment is None:
            found = pool.take(size, timeout)
            if found is not None:
                self._segment, self._regions = found
        elif size:
            self._regions = self._segment.take(size)
        return self._regions is not None or (self._segment is not None and not size)

    def __enter__(self) -> "SegmentColumns":
        return self

    def __exit__(self, *_: Any) -> None:
        with self._lock:
            self._is_over = True
        if self._regions is not None and self._segment is not None:
            self._segment.release(self._regions, self._region_count * self._region_size)
            self._regions = None

    def description(self) -> Any:
        """The request without rows and without columns of answers."""
        request = self._query.form.request()
        request.CopyFrom(self._query.request)
        request.ClearField("fields")
        return request

    def pieces(self) -> "Iterator[SharedPiece]":
        """The messages."""
        for number, begin in enumerate(range(0, self._count, self.message_rows)):
            yield SharedPiece(self, number, begin, min(begin + self.message_rows, self._count))

    def request(self, piece: SharedPiece) -> bytes:
        """What a message has beside the description. Copies its rows."""
        with self._lock:
            return b"" if self._is_over else self._request(piece)

    def _request(self, piece: SharedPiece) -> bytes:
        form = self._query.form
        answers = [_proto.SharedColumn(field=COLUMNS[name].number, offset=self._offset(name, column, piece))
                   for name, column in self._answers.items()]
        made = form.request(segment=self._known().name, answer=answers)
        if not isinstance(self._source, Rows):
            part = getattr(made, form.generator)
            part.CopyFrom(self._source)
            part.first, part.count = self._source.first + piece.begin, piece.end - piece.begin
            return bytes(made.SerializeToString())
        shared = made.shared
        shared.float64, shared.count = self._source.dtype.itemsize == 8, piece.end - piece.begin
        for name, column in self._rows.items():
            if column.offset is None:
                np.copyto(self._region(name, column, piece), column.given[piece.begin:piece.end])
            setattr(shared, name, self._offset(name, column, piece))
        return bytes(made.SerializeToString())

    def put(self, piece: SharedPiece, answer: "Answer") -> None:
        """Adds the columns that are in regions to the answer of a message; the others are where the caller wants them."""
        for name, column in self._answers.items():
            if column.offset is None:
                answer.put(name, self._region(name, column, piece))
            else:
                answer.in_place.add(name)

    def end_call(self, error: BaseException) -> None:
        """Raises the error that ended a call, unless the rows without an answer may go by messages."""
        segment = self._known()
        # gRPC repeats calls with updates: the connection may have broken, and the segment ended with it, under a first one
        # that still writes.
        is_repeated = self._query.has_updates() and getattr(error, "reason", "") == "SEGMENT_NOT_FOUND"
        # With a reason, the server itself has ended it, after all of its work.
        if isinstance(error, errors.SightlineError) and error.reason and not is_repeated:
            if error.reason == "SEGMENT_NOT_FOUND":
                self._pool.lose(segment)
            if error.retry_delay is None:
                return
            raise error
        is_broken = is_repeated or isinstance(error, (errors.Unavailable, errors.Unknown))
        if segment.has_server_ended(_PROCESS_END if is_broken else 0):
            self._pool.lose(segment)
        else:
            segment.abandon()  # late answers must not reach the rows of another cast
            if any(column.offset is not None for column in self._answers.values()):
                if is_repeated:
                    raise errors.Unavailable("the segment of the answers has ended, or the connection: share new memory") from error
                raise error
        if not isinstance(error, errors.SightlineError) or isinstance(error, (errors.Cancelled, errors.DeadlineExceeded)):
            raise error

    def _known(self) -> Segment:
        assert self._segment is not None
        return self._segment

    def _offset(self, name: str, column: _Column, piece: SharedPiece) -> int:
        if column.offset is not None:
            return column.offset + piece.begin * column.row_bytes
        assert self._regions is not None
        return self._regions + piece.number % self._region_count * self._region_size + self._places[name]

    def _region(self, name: str, column: _Column, piece: SharedPiece) -> np.ndarray:
        count = (piece.end - piece.begin) * int(np.prod(column.row, dtype=int))
        flat = self._known().array(self._offset(name, column, piece), column.dtype, count)
        return flat.reshape(-1, *column.row)


def _rows_of(source: Any) -> "Dict[str, np.ndarray]":
    if not isinstance(source, Rows):
        return {}
    names: "Tuple[str, ...]" = _POINTS if isinstance(source, Points) else _RAYS
    columns: "List[Optional[np.ndarray]]" = source.columns()
    return {name: column for name, column in zip(names, columns) if column is not None}


def _message_rows(count: int, copied: int, most: int) -> int:
    """Rows of a message, of which so many bytes a row are copied: copying and tracing overlap."""
    rows = most
    if copied:
        rows = min(most, max(_LEAST_IN_MESSAGE, min(_MOST_IN_MESSAGE, count // _MESSAGES)), _REGION_BYTES // copied)
    if rows >= count:
        return count
    return rows // _ROWS_AT_ONCE * _ROWS_AT_ONCE or rows
