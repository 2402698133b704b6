"""From rays to hits: puts the answers of messages together."""

from __future__ import annotations

from typing import Any, Callable, Dict, Iterable, Iterator, List, Optional, Tuple, Union

import numpy as np

from . import _cast_codec as codec
from ._cast import RAYS_PER_MESSAGE, CastStream, Piece, cast_once, generated, pieces
from ._connection import Connection
from ._query import OF_HITS, Query
from .hits import AllHits, Hits, NameLookup, empty_columns
from .rays import Rays, as_rays

Progress = Callable[[int], None]  # is told how many more rays are answered
_MOST_GENERATED = 16384


class _Totals:
    """What the answers of a cast say beside their columns."""

    def __init__(self) -> None:
        self.revision, self.token = 0, ""
        self.stats: "Dict[str, int]" = {}

    def add(self, answer: codec.Answer) -> None:
        self.revision, self.token = answer.revision, answer.token
        if answer.stats is not None:
            for field, value in answer.stats.ListFields():
                self.stats[field.name] = self.stats.get(field.name, 0) + value


class _PerRay:
    """Fills a row for each ray."""

    def __init__(self, query: Query, count: int):
        self._columns = empty_columns(query.columns, count)
        self._totals = _Totals()
        self._filled = 0

    def add(self, count: int, answers: "List[codec.Answer]") -> None:
        begin, self._filled = self._filled, self._filled + count
        for name, column in self._columns.items():
            column[begin:self._filled] = answers[0].rows(name, count)
        self._totals.add(answers[0])

    def hits(self, shape: "Tuple[int, ...]", rays: Optional[Rays], names: NameLookup) -> Hits:
        totals = self._totals
        return Hits(shape, self._columns, totals.revision, totals.token, totals.stats, rays, names)


class _PerHit:
    """Collects a row for each hit."""

    def __init__(self, query: Query, _: int):
        self._parts: "Dict[str, List[np.ndarray]]" = {name: [] for name in query.columns}
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

    def hits(self, shape: "Tuple[int, ...]", rays: Optional[Rays], names: NameLookup) -> AllHits:
        columns = {name: np.concatenate(parts) if parts else empty_columns((name,), 0)[name]
                   for name, parts in self._parts.items()}
        totals = self._totals
        return AllHits(shape, columns, totals.revision, totals.token, totals.stats, rays, names)


def _collector(query: Query, count: int) -> "Union[_PerRay, _PerHit]":
    return _PerHit(query, count) if query.kind == "all" else _PerRay(query, count)


def cast_rays(connection: Connection, limit: int, query: Query, rays: Rays, timeout: Optional[float],
              names: NameLookup, progress: Progress) -> "Union[Hits, AllHits]":
    """All rays of an array. `limit`: how many the server takes in a request."""
    collector = _collector(query, rays.count)
    if rays.count <= limit and query.kind != "all":
        collector.add(rays.count, [cast_once(connection, query, rays, timeout)])
        progress(rays.count)
    else:
        source = pieces([rays], min(limit, RAYS_PER_MESSAGE))
        for piece, answers in CastStream(connection, query, source, timeout).answers():
            collector.add(piece.end - piece.begin, answers)
            progress(piece.end - piece.begin)
    return collector.hits(rays.shape, rays, names)


def cast_batches(connection: Connection, limit: int, query: Query, batches: "Iterable[Any]",
                 timeout: Optional[float], names: NameLookup,
                 progress: Progress) -> "Iterator[Union[Hits, AllHits]]":
    """The hits of each batch, in order. A few messages are in memory at a time, and the batches that they belong to."""
    source = pieces(map(as_rays, batches), min(limit, RAYS_PER_MESSAGE))
    collector = None
    for piece, answers in CastStream(connection, query, source, timeout).answers():
        if collector is None:
            collector = _collector(query, piece.rays.count)
        collector.add(piece.end - piece.begin, answers)
        progress(piece.end - piece.begin)
        if _is_last(piece):
            yield collector.hits(piece.rays.shape, piece.rays, names)
            collector = None


def _is_last(piece: Piece) -> bool:
    return piece.end == piece.rays.count


def cast_generated(connection: Connection, query: Query, generator: Any, shape: "Tuple[int, ...]",
                   timeout: Optional[float], names: NameLookup) -> Hits:
    """Rays that the server makes, of another kind than "all": as many as `shape` has elements."""
    total = int(np.prod(shape))
    collector = _PerRay(query, total)
    source = generated(generator, total, _MOST_GENERATED)
    for part, answers in CastStream(connection, query, source, timeout).answers():
        collector.add(part.count, answers)
    return collector.hits(shape, None, names)
