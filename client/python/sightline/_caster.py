"""From rays to hits, and from points to faces: puts the answers of messages together."""

from __future__ import annotations

import functools
import time
from typing import Any, Callable, Dict, Iterable, Iterator, List, Optional, Tuple, Union

import numpy as np

from . import _cast_codec as codec
from . import errors
from ._answer import empty_columns
from ._arrays import Rows
from ._cast import RAYS_PER_MESSAGE, CastStream, Piece, cast_generated_once, cast_once, generated, pieces
from ._completion import complete, complete_rows
from ._connection import Connection
from ._generated import Generated
from ._segment_columns import SegmentColumns
from ._segments import MOST_SEGMENTS
from ._query import OF_HITS, POINTS, Query
from ._types import Array, NameLookup
from .all_hits import AllHits
from .all_nearest import AllNearest
from .applied import Applied
from .hits import Hits
from .nearest import Nearest
from .point_grid import PointGrid
from .points import Points
from .rays import Rays

Progress = Callable[[int], None]  # called with how many more rays are answered
Answered = Union[Hits, AllHits]
_MOST_LOST = MOST_SEGMENTS + 2  # segments that a server that is started again has forgotten: the pool's and two of a user
Source = Union[Rows, Generated]   # what is cast


class _Totals:
    """What the answers of a cast say beside their columns."""

    def __init__(self) -> None:
        self.revision, self.token = 0, ""
        self.stats: "Dict[str, int]" = {}
        self.applied: Optional[Applied] = None

    def add(self, answer: codec.Answer) -> None:
        self.revision, self.token = answer.revision, answer.token
        if answer.applied is not None:
            self.applied = Applied.of(answer.applied)
        if answer.stats is not None:
            for field, value in answer.stats.ListFields():
                self.stats[field.name] = self.stats.get(field.name, 0) + value


class _PerRay:
    """Fills a row for each ray."""

    def __init__(self, query: Query, count: int, out: "Dict[str, Array]"):
        self._made = Nearest if query.form is POINTS else Hits
        others = tuple(name for name in query.columns if name not in out)
        self.columns = {**empty_columns(others, count), **out}
        self._totals = _Totals()
        self.filled = 0

    def add(self, count: int, answers: "List[codec.Answer]") -> None:
        begin, self.filled = self.filled, self.filled + count
        for name, column in self.columns.items():
            if name not in answers[0].in_place:
                column[begin:self.filled] = answers[0].rows(name, count)
        self._totals.add(answers[0])

    @property
    def revision(self) -> int:
        """The one that has answered the rows that are filled."""
        return self._totals.revision

    def hits(self, shape: "Tuple[int, ...]", rays: Optional[Source], names: NameLookup) -> Hits:
        totals = self._totals
        hits = self._made(shape, self.columns, totals.revision, totals.token, totals.stats, rays, names)
        hits.applied = totals.applied
        return hits


class _PerHit:
    """Collects a row for each hit."""

    def __init__(self, query: Query, _: int):
        self._made = AllNearest if query.form is POINTS else AllHits
        self._parts: "Dict[str, List[Array]]" = {name: [] for name in query.columns}
        self._parts["offset"].append(np.zeros(1, np.uint64))
        self._totals = _Totals()
        self._listed = 0

    def add(self, count: int, answers: "List[codec.Answer]") -> None:
        for answer in answers:
            offset = answer.columns.get("offset", np.zeros(1, np.uint32))
            listed = int(offset[-1])
            for name, parts in self._parts.items():
                if name == "offset":
                    parts.append(offset[1:].astype(np.uint64) + np.uint64(self._listed))
                else:
                    parts.append(answer.rows(name, listed if name in OF_HITS else len(offset) - 1))
            self._listed += listed
            self._totals.add(answer)

    def hits(self, shape: "Tuple[int, ...]", rays: Optional[Source], names: NameLookup) -> AllHits:
        columns = {name: np.concatenate(parts) if parts else empty_columns((name,), 0)[name]
                   for name, parts in self._parts.items()}
        totals = self._totals
        return self._made(shape, columns, totals.revision, totals.token, totals.stats, rays, names)


def _collector(query: Query, count: int, out: "Dict[str, Array]") -> "Union[_PerRay, _PerHit]":
    return _PerHit(query, count) if query.kind == "all" else _PerRay(query, count, out)


def _fill_through_segment(connection: Connection, query: Query, source: Any, count: int, collector: _PerRay,
                          timeout: Optional[float], progress: Progress) -> None:
    """Fills what rows it can, from the first one on; the others go by messages."""
    columns = SegmentColumns.make(connection, query, source, count, collector.columns, timeout)
    if columns is None:
        return
    with columns:
        try:
            for piece, answers in CastStream(connection, query, columns.pieces(), timeout, columns).answers():
                collector.add(piece.end - piece.begin, answers)
                progress(piece.end - piece.begin)
        except BaseException as error:  # it is raised, or noted
            columns.end_call(error)


def _apply_through_segment(connection: Connection, query: Query, source: Source, collector: _PerRay,
                           timeout: Optional[float]) -> "Optional[BaseException]":
    """Applies updates and fills all rows by one call. Returns the error by which the segment was lost, if it was: the rows
    are not filled then, and may go by messages or another segment, as the updates have an id. None, without rows that are
    filled: there is no segment."""
    columns = SegmentColumns.make(connection, query, source.message() if isinstance(source, Generated) else source, source.count, collector.columns, timeout)
    if columns is None:
        return None
    with columns:
        piece = next(columns.pieces())
        request = columns.description().SerializeToString() + columns.request(piece)
        try:
            data = connection.call(query.form.call, request, timeout, light=False, scene=query.request.scene,
                                   route_key=query.route_key)
        except BaseException as error:  # it is raised, or returned
            columns.end_call(error)
            if getattr(error, "reason", "") not in ("", "SEGMENT_NOT_FOUND"):
                raise
            return error
        answer = codec.answer(data)
        _check_applied(answer)
        columns.put(piece, answer)
        collector.add(source.count, [answer])
    return None


def _check_applied(answer: codec.Answer) -> None:
    if answer.applied is None:
        raise errors.Unimplemented("the server is of a version that applies no updates with a cast, and has applied none")


class Caster:
    """One cast, of rays or of points, as the query says. `limit`: how many the server takes in a request. `check` is
    told of those that were cast, and of the token of the revision."""

    def __init__(self, connection: Connection, limit: int, query: Query, timeout: Optional[float], names: NameLookup,
                 check: "Callable[[Any, str], None]"):
        self._connection, self._limit, self._query, self._names = connection, limit, query, names
        self._check = check
        self._seconds = connection.timeout if timeout is None else timeout
        self._deadline: Optional[float] = None    # once the cast has begun, as the next
        self._budget_end: Optional[float] = None

    def cast(self, rays: Source, progress: Progress, out: "Optional[Dict[str, Array]]" = None) -> Answered:
        """All rays of an array, or points of a grid. out: columns that are filled. ValueError: updates, with what one
        call does not hold."""
        if self._query.has_updates() and self._query.kind == "all":
            raise ValueError("apply does not go with kind='all': apply the changes first, and cast with "
                             "revision=batch.applied.revision")
        self._begin()
        return self._completed(self._answers(self._query, rays, progress, out or {}), rays)

    def cast_batches(self, batches: "Iterable[Rows]", progress: Progress) -> "Iterator[Answered]":
        """The hits of each batch, in order. A few messages are in memory at a time, and the batches they belong to."""
        self._begin()
        source = pieces(batches, min(self._limit, RAYS_PER_MESSAGE))
        collector = None
        for piece, answers in self._stream(self._query, source):
            if collector is None:
                collector = _collector(self._query, piece.rays.count, {})
            collector.add(piece.end - piece.begin, answers)
            progress(piece.end - piece.begin)
            if _is_last(piece):
                yield self._completed(collector.hits(piece.rays.shape, piece.rays, self._names), piece.rays)
                collector = None

    def _apply(self, query: Query, rays: Source, collector: _PerRay) -> None:
        """Applies the updates and casts, in one call."""
        lost: Optional[BaseException] = None
        for _ in range(_MOST_LOST):
            error = _apply_through_segment(self._connection, query, rays, collector, self._rest())
            if collector.filled == rays.count and collector.filled:
                return
            lost = error or lost
            if error is None or rays.count <= self._limit:
                break
        if rays.count > self._limit:
            if lost is not None:
                raise errors.Unavailable(f"a cast with changes has lost its shared memory: {lost}") from lost
            kind, reason = self._connection.segments.transport()
            raise ValueError(f"apply goes with what one call holds, not with {rays.count} rays or points: {self._limit} in a "
                             f"message, more through shared memory (here {kind}: {reason}); apply the changes first, and cast "
                             "with revision=batch.applied.revision")
        answer = cast_once(self._connection, query, rays, self._rest()) if isinstance(rays, Rows) else \
            cast_generated_once(self._connection, query, rays, self._rest())
        _check_applied(answer)
        collector.add(rays.count, [answer])

    def _begin(self) -> None:
        now, budget = time.monotonic(), self._query.request.time_budget_ms
        self._deadline = None if self._seconds is None else now + self._seconds
        self._budget_end = now + budget / 1000 if budget else None

    def _answers(self, query: Query, rays: Source, progress: Progress,
                 out: "Dict[str, Array]") -> Answered:
        collector, size, begin = _collector(query, rays.count, out), min(self._limit, RAYS_PER_MESSAGE), 0
        if isinstance(collector, _PerRay) and query.has_updates():
            self._apply(query, rays, collector)
            progress(rays.count)
            return collector.hits(rays.shape, rays, self._names)
        if isinstance(collector, _PerRay):
            source = rays.message() if isinstance(rays, Generated) else rays
            _fill_through_segment(self._connection, query, source, rays.count, collector, self._rest(), progress)
            begin = collector.filled
            query = query.going_on(collector.revision, self._budget_end) if begin else query
        if begin == rays.count and begin:
            pass
        elif isinstance(rays, Generated):
            for part, answers in self._stream(query, generated(rays, size, begin)):
                collector.add(part.count, answers)
                progress(part.count)
        elif not begin and rays.count <= self._limit and query.kind != "all":
            collector.add(rays.count, [cast_once(self._connection, query, rays, self._rest())])
            progress(rays.count)
        else:
            for piece, answers in self._stream(query, pieces([rays], size, begin)):
                collector.add(piece.end - piece.begin, answers)
                progress(piece.end - piece.begin)
        return collector.hits(rays.shape, rays, self._names)

    def _stream(self, query: Query, source: "Iterator[Any]") -> "Iterator[Tuple[Any, List[codec.Answer]]]":
        return CastStream(self._connection, query, source, self._rest()).answers()

    def _rest(self) -> Optional[float]:
        return None if self._deadline is None else max(0.0, self._deadline - time.monotonic())

    def _completed(self, hits: Answered, rays: Source) -> Answered:
        query = self._query

        def again(some: Rows) -> AllHits:
            answer = self._answers(query.again(hits.revision, self._budget_end), some, lambda _: None, {})
            assert isinstance(answer, AllHits)  # the query is of kind "all"
            return answer

        if isinstance(hits, AllHits) and query.needs_more():
            if isinstance(rays, Rays):
                complete(hits, rays, query.most, again)
            elif isinstance(rays, (Points, PointGrid)):
                points = rays
                complete_rows(hits, lambda rows: again(points.some(rows)), "points")
            elif isinstance(rays, Generated):
                complete_rows(hits, functools.partial(self._generated_again, hits.revision, rays), "rays")
        for name in query.hidden:
            del hits._columns[name]
        self._check(rays, hits.token)
        return hits

    def _generated_again(self, revision: int, source: Generated, rows: Array) -> AllHits:
        """Some rays of a generator, one in each message."""
        query = self._query.again(revision, self._budget_end)
        collector = _PerHit(query, len(rows))
        for _, answers in self._stream(query, (source.part(int(row), 1) for row in rows)):
            collector.add(1, answers)
        return collector.hits((len(rows),), None, self._names)


def _is_last(piece: Piece) -> bool:
    return piece.end == piece.rays.count
