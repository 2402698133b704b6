"""Answers with a row for each hit."""

from __future__ import annotations

import math
from typing import Any, Dict, Iterator, Type

import numpy as np

from ._answer import CUT_OFF, INVALID, UNANSWERED, Answer, some_rays
from ._optional import optional_module
from ._query import OF_HITS
from ._types import Bools, Doubles, Int64s, UInt64s
from .hits import Hits

_COSTS = ("traversal_steps", "triangle_tests", "instances_entered", "cells_expanded", "queue_us", "build_us",
          "trace_us")


class AllHits(Answer):
    """Every hit, of kind "all": a row for each hit, in the order of the flattened rays, then by (t, node,
    primitive)."""

    _ROW_TYPE: "Type[Hits]" = Hits

    @property
    def offset(self) -> UInt64s:
        """uint64 (n + 1): the hits of flattened ray i are the rows offset[i] up to offset[i + 1]."""
        return self._column("offset")

    @property
    def count(self) -> Int64s:
        """int64, with the leading shape of the rays: how many hits are listed."""
        return np.diff(self.offset.astype("i8")).reshape(self.shape)

    @property
    def ray(self) -> Int64s:
        """int64, for each hit: the index of its flattened ray."""
        return np.repeat(np.arange(len(self.offset) - 1), np.diff(self.offset.astype("i8")))

    @property
    def hit(self) -> Bools:
        """bool, with the leading shape of the rays: whether the ray hits."""
        status = self._column("hit")
        return np.asarray((status == 1) | (status == CUT_OFF)).reshape(self.shape)

    @property
    def invalid(self) -> Bools:
        """bool, with the leading shape of the rays: whether the ray cannot be cast."""
        return np.asarray(self._column("hit") == INVALID).reshape(self.shape)

    @property
    def unanswered(self) -> Bools:
        """bool, with the leading shape of the rays: whether the ray has no answer: `time_budget`, `allow_partial` of
        Scene.cast."""
        return np.asarray(self._column("hit") == UNANSWERED).reshape(self.shape)

    @property
    def cut_off(self) -> Bools:
        """bool, with the leading shape of the rays: whether there are more hits than are listed, which are the nearest:
        as many as max_hits, or fewer if time_budget was too short for the others."""
        return np.asarray(self._column("hit") == CUT_OFF).reshape(self.shape)

    @property
    def position(self) -> Doubles:
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

    def __getitem__(self, index: Any) -> Hits:
        """Some of the hits, by any index that an array of all of them takes, with a row for each."""
        numbers = np.arange(len(self))[index]
        rows = np.asarray(numbers).reshape(-1)
        columns = {name: column[rows] for name, column in self._columns.items() if name in OF_HITS}
        if not columns:
            columns["hit"] = np.ones(len(rows), np.uint8)
        made = self._ROW_TYPE(np.shape(numbers), columns, self.revision, self.token, self.stats,
                              some_rays(self._rays, self.ray[rows]), self._names)
        if self._found_names is not None:
            made._found_names = self._found_names[rows]
        return made

    def __iter__(self) -> "Iterator[Hits]":
        return (self[at] for at in range(len(self)))

    def of(self, ray: Any) -> Hits:
        """The hits of one ray, near to far: by its index in the leading shape. Errors: IndexError."""
        number = int(np.arange(math.prod(self.shape)).reshape(self.shape)[ray])
        return self[int(self.offset[number]):int(self.offset[number + 1])]

    def __repr__(self) -> str:
        cut = int(self.cut_off.sum())
        return f"<{type(self).__name__} {self.shape}: {len(self)} hits of {len(self.offset) - 1} {self._ROW}s" \
               f"{f', {cut} cut off' if cut else ''}{self._summary()}>"

    def to_pandas(self) -> Any:
        """A DataFrame with a row for each hit; `ray` (or `point`) is the index of the flattened ray (or point). Error:
        ImportError, pandas is not installed."""
        pandas = optional_module("pandas", "to_pandas")

        return pandas.DataFrame({self._ROW: self.ray, **self._table()})
