"""Answers to queries of closest points with a row for each face."""

from __future__ import annotations

from typing import Type

from ._types import Doubles, Int64s
from .all_hits import AllHits
from .hits import Hits
from .nearest import Nearest


class AllNearest(AllHits):
    """Every face, of kind "all": a row for each, in the order of the flattened points, then by (distance, node,
    primitive). As AllHits, whose rays are the points."""

    _T, _ROW = "distance", "point"
    _ROW_TYPE: "Type[Hits]" = Nearest

    @property
    def distance(self) -> Doubles:
        """float64, for each face: how far it is from its point."""
        return self.t

    @property
    def point(self) -> Int64s:
        """int64, for each face: the index of its flattened point."""
        return self.ray

    @property
    def position(self) -> Doubles:
        """float64 (m, 3), for each face: its point that is nearest."""
        return self._column("position")
