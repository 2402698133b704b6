"""Answers to casts, as arrays with the leading shape of the rays."""

from __future__ import annotations

from typing import Any, Callable, Dict, Optional, Tuple

import numpy as np

from ._query import COLUMNS, OF_HITS
from .batch import Applied
from .rays import Rays

INVALID_COUNT = 0xFFFFFFFF
UNANSWERED_COUNT = INVALID_COUNT - 1
INVALID, CUT_OFF, UNANSWERED = 2, 3, 4  # values of the column `hit`
_COSTS = ("traversal_steps", "triangle_tests", "instances_entered", "cells_expanded", "queue_us", "build_us",
          "trace_us")
NameLookup = Callable[[np.ndarray, int], "Dict[int, str]"]


class _Answer:
    """What all answers have: the revision, its token, statistics, the columns that were asked for."""

    _T, _ROW = "t", "ray"  # what the column t and a row are called

    def __init__(self, shape: Tuple[int, ...], columns: "Dict[str, np.ndarray]", revision: int, token: str,
                 stats: "Dict[str, int]", rays: Any, names: NameLookup):
        self.shape = shape  #: leading shape of the rays
        self.revision = revision  #: the revision of the scene that answered
        self.token = token  #: that revision's token, for `at_least`
        self.applied: Optional[Applied] = None  #: what the updates of Scene.cast(apply=...) came to
        self.stats = stats  #: what the cast cost: rays, hits, invalid, cells_expanded, build_us, trace_us, ...
        self._columns = columns
        self._rays = rays
        self._names = names
        self._found_names: Optional[np.ndarray] = None

    def _column(self, name: str) -> np.ndarray:
        column = self._columns.get(name)
        if column is None:
            raise AttributeError(f"{self._T if name == 't' else name} was not asked for: name it in fields, or ask with "
                                 "another kind")
        return column

    def _shaped(self, column: np.ndarray) -> np.ndarray:
        return column

    @property
    def t(self) -> np.ndarray:
        """float64, in lengths of the ray's direction; a miss +inf, an invalid ray NaN, an unanswered one -inf."""
        return self._shaped(self._column("t"))

    @property
    def node(self) -> np.ndarray:
        """uint64, the id of the node that is hit; 0: none."""
        return self._shaped(self._column("node"))

    @property
    def primitive(self) -> np.ndarray:
        """uint32, the face's index in the node's mesh; 0 where nothing is hit."""
        return self._shaped(self._column("primitive"))

    @property
    def uv(self) -> np.ndarray:
        """float32 (..., 2): weights of the face's vertices 1 and 2."""
        return self._shaped(self._column("uv"))

    @property
    def normal(self) -> np.ndarray:
        """float32 (..., 3): the face's unit normal in scene coordinates, on the side that shows its corners
        counterclockwise in the mesh's own frame, so that a mirrored node's stay outside; 0 where nothing is hit."""
        return self._shaped(self._column("normal"))

    def _ends(self, origins: np.ndarray, directions: np.ndarray) -> np.ndarray:
        """The points of hits, as the server computes HIT_FIELD_POSITION."""
        t = self._column("t")
        with np.errstate(invalid="ignore", over="ignore"):
            ends = origins.astype("f8", copy=False) + t[:, None] * directions.astype("f8", copy=False)
        ends[~np.isfinite(t)] = np.nan
        return self._shaped(ends)

    def _need_rays(self) -> Rays:
        if self._rays is None:
            raise AttributeError("positions of rays that the server makes: name position in fields")
        return self._rays

    @property
    def name(self) -> np.ndarray:
        """str objects: names of the nodes that are hit, "" for none. Unless it was named in fields, the server is asked
        when it is first used. Errors, then: OutOfRange, the revision is not kept any more."""
        if "name" in self._columns:
            return self._shaped(self._columns["name"])
        if self._found_names is None:
            ids, inverse = np.unique(self._column("node"), return_inverse=True)
            by_id = self._names(ids[ids != 0], self.revision)
            names = np.array([by_id.get(int(i), "") for i in ids], dtype=object)
            self._found_names = names[inverse]
        return self._shaped(self._found_names)

    def _table(self) -> "Dict[str, np.ndarray]":
        table: "Dict[str, np.ndarray]" = {}
        for name in OF_HITS:
            column = self._columns.get(name)
            if name == "uv" and column is not None:
                table.update(u=column[:, 0], v=column[:, 1])
            elif name == "normal" and column is not None:
                table.update(nx=column[:, 0], ny=column[:, 1], nz=column[:, 2])
            elif name == "position" and column is not None:
                table.update(x=column[:, 0], y=column[:, 1], z=column[:, 2])
            elif column is not None:
                table[self._T if name == "t" else name] = column
        return table


class Hits(_Answer):
    """A row for each ray: of kinds "closest", "any" and "count". Arrays have the leading shape of the rays."""

    def _shaped(self, column: np.ndarray) -> np.ndarray:
        return column.reshape(self.shape + column.shape[1:])

    def __len__(self) -> int:
        return self.shape[0] if self.shape else 1

    def __repr__(self) -> str:
        return f"<{type(self).__name__} of {self.stats.get('rays', 0)} {self._ROW}s: {self.stats.get('hits', 0)} hit, " \
               f"{self.stats.get('invalid', 0)} invalid, revision {self.revision}>"

    @property
    def hit(self) -> np.ndarray:
        """bool: whether the ray hits."""
        return self._shaped(self._status() == 1)

    @property
    def invalid(self) -> np.ndarray:
        """bool: whether the ray cannot be cast (not finite, or without a direction)."""
        return self._shaped(self._status() == INVALID)

    @property
    def unanswered(self) -> np.ndarray:
        """bool: whether the ray has no answer: `time_budget`, `allow_partial` of Scene.cast."""
        return self._shaped(self._status() == UNANSWERED)

    def _status(self) -> np.ndarray:
        """0 miss, 1 hit, 2 invalid, 4 unanswered, from whichever column tells."""
        if "hit" in self._columns:
            return self._columns["hit"]
        if "count" in self._columns:
            count = self._columns["count"]
            return np.where(count == INVALID_COUNT, INVALID, np.where(count == UNANSWERED_COUNT, UNANSWERED, count > 0))
        return self._status_of(self._column("t"))

    @staticmethod
    def _status_of(t: np.ndarray) -> np.ndarray:
        return np.where(np.isnan(t), INVALID, np.where(t == -np.inf, UNANSWERED, np.isfinite(t)))

    @property
    def count(self) -> np.ndarray:
        """uint32: how many (node, primitive) the ray hits; an invalid ray 2**32 - 1, an unanswered one 2**32 - 2.
        Kind "count"."""
        return self._shaped(self._column("count"))

    @property
    def work(self) -> np.ndarray:
        """uint32: steps and triangle tests; the top bit is set where the ray met a cell that is not built."""
        return self._shaped(self._column("work"))

    @property
    def position(self) -> np.ndarray:
        """float64 (..., 3): origin + t * direction; NaN where nothing is hit."""
        if "position" in self._columns:
            return self._shaped(self._columns["position"])
        rays = self._need_rays()
        return self._ends(rays.origins, rays.directions)

    def to_pandas(self) -> Any:
        """A DataFrame with a row for each ray or point, in the order of the flattened ones."""
        import pandas

        table = self._table()
        for name in ("count", "work", "signed", "inside", "votes", "hit"):
            if name in self._columns or (name == "hit" and self._tells_hits()):
                table[name] = getattr(self, name).reshape(-1)
        index = pandas.RangeIndex(len(next(iter(table.values()))), name=self._ROW)
        return pandas.DataFrame(table, index=index)

    def _tells_hits(self) -> bool:
        """Whether a column says what is hit: of points one may ask for sides alone."""
        return True


class AllHits(_Answer):
    """Every hit, of kind "all": a row for each hit, in the order of the flattened rays, then by (t, node, primitive)."""

    @property
    def offset(self) -> np.ndarray:
        """uint64 (n + 1): the hits of flattened ray i are the rows offset[i] up to offset[i + 1]."""
        return self._column("offset")

    @property
    def count(self) -> np.ndarray:
        """int64, with the leading shape of the rays: how many hits are listed."""
        return np.diff(self.offset.astype("i8")).reshape(self.shape)

    @property
    def ray(self) -> np.ndarray:
        """int64, for each hit: the index of its flattened ray."""
        return np.repeat(np.arange(len(self.offset) - 1), np.diff(self.offset.astype("i8")))

    @property
    def hit(self) -> np.ndarray:
        """bool, with the leading shape of the rays: whether the ray hits."""
        status = self._column("hit")
        return ((status == 1) | (status == CUT_OFF)).reshape(self.shape)

    @property
    def invalid(self) -> np.ndarray:
        """bool, with the leading shape of the rays: whether the ray cannot be cast."""
        return (self._column("hit") == INVALID).reshape(self.shape)

    @property
    def unanswered(self) -> np.ndarray:
        """bool, with the leading shape of the rays: whether the ray has no answer: `time_budget`, `allow_partial` of Scene.cast."""
        return (self._column("hit") == UNANSWERED).reshape(self.shape)

    @property
    def cut_off(self) -> np.ndarray:
        """bool, with the leading shape of the rays: whether there are more hits than are listed, which are the nearest: as
        many as max_hits, or fewer if time_budget was too short for the others."""
        return (self._column("hit") == CUT_OFF).reshape(self.shape)

    @property
    def position(self) -> np.ndarray:
        """float64 (m, 3), for each hit: origin + t * direction."""
        if "position" in self._columns:
            return self._columns["position"]
        rays, ray = self._need_rays(), self.ray
        return self._ends(rays.origins[ray], rays.directions[ray])

    def add_cost(self, stats: "Dict[str, int]") -> None:
        """Another cast was made for this answer."""
        for name in _COSTS:
            if name in stats:
                self.stats[name] = self.stats.get(name, 0) + stats[name]

    def __len__(self) -> int:
        return int(self.offset[-1])

    def __repr__(self) -> str:
        return f"<{type(self).__name__} of {len(self.offset) - 1} {self._ROW}s: {len(self)} hits, " \
               f"revision {self.revision}>"

    def to_pandas(self) -> Any:
        """A DataFrame with a row for each hit; `ray` (or `point`) is the index of the flattened ray (or point)."""
        import pandas

        return pandas.DataFrame({self._ROW: self.ray, **self._table()})


def empty_columns(names: "Tuple[str, ...]", rows: int) -> "Dict[str, np.ndarray]":
    """Arrays for so many rows."""
    return {name: np.empty((rows, *COLUMNS[name].row), object if name == "name" else COLUMNS[name].dtype)
            for name in names}
