"""Answers to queries of closest points, as arrays with the leading shape of the points."""

from __future__ import annotations

import numpy as np

from .hits import AllHits, Hits


class Nearest(Hits):
    """A row for each point: of kinds "closest", "any" and "count". As Hits, whose rays are the points: `hit` is whether
    a face is within max_distance, and `t` is `distance`."""

    _T, _ROW = "distance", "point"

    @property
    def distance(self) -> np.ndarray:
        """float64, to the nearest face in the scene's units, rounded once; +inf where none is within max_distance, an
        invalid point NaN, an unanswered one -inf."""
        return self.t

    @property
    def position(self) -> np.ndarray:
        """float64 (..., 3): the point of the face that is nearest; NaN where there is no face."""
        return self._shaped(self._column("position"))


class AllNearest(AllHits):
    """Every face, of kind "all": a row for each, in the order of the flattened points, then by (distance, node,
    primitive). As AllHits, whose rays are the points."""

    _T, _ROW = "distance", "point"

    @property
    def distance(self) -> np.ndarray:
        """float64, for each face: how far it is from its point."""
        return self.t

    @property
    def point(self) -> np.ndarray:
        """int64, for each face: the index of its flattened point."""
        return self.ray

    @property
    def position(self) -> np.ndarray:
        """float64 (m, 3), for each face: its point that is nearest."""
        return self._column("position")
