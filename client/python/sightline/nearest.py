"""Answers to queries of closest points, as arrays with the leading shape of the points."""

from __future__ import annotations

import numpy as np

from ._answer import INVALID, UNANSWERED
from ._sides import FIELDS
from ._types import Array, Bools, Bytes, Doubles
from .hits import Hits


class Nearest(Hits):
    """A row for each point: of kinds "closest", "any" and "count". As Hits, whose rays are the points: `hit` is whether
    a face is within max_distance, and `t` is `distance`."""

    _T, _ROW = "distance", "point"

    @property
    def distance(self) -> Doubles:
        """float64, to the nearest face in the scene's units, rounded once; +inf where none is within max_distance, an
        invalid point NaN, an unanswered one -inf."""
        return self.t

    @property
    def position(self) -> Doubles:
        """float64 (..., 3): the point of the face that is nearest; NaN where there is no face."""
        return self._shaped(self._column("position"))

    @property
    def signed(self) -> Doubles:
        """float64: the distance, negative inside; 0 has no sign; +inf where no face is within max_distance (`inside`
        tells the side there, too), an invalid point NaN, an unanswered one -inf."""
        return self._shaped(self._column("signed"))

    @property
    def inside(self) -> Bools:
        """bool: whether the point is inside, whatever max_distance is; an invalid or unanswered one is not, and
        `invalid` and `unanswered` name it."""
        return self._shaped(self._column("inside") == 1)

    @property
    def votes(self) -> Bytes:
        """uint8: of side_rays, those that say inside. Neither 0 nor all of them: the surface has a hole there."""
        return self._shaped(self._column("votes"))

    @property
    def hit(self) -> Bools:
        """bool: whether a face is within max_distance."""
        if not self._tells_hits():
            raise AttributeError("hit was not asked for: name it in fields beside inside and votes")
        return super().hit

    def _status(self) -> Array:
        if "hit" not in self._columns and "signed" in self._columns:
            return self._status_of(self._columns["signed"])
        if not self._tells_hits():
            inside = self._columns["inside"]
            return np.where((inside == INVALID) | (inside == UNANSWERED), inside, 0)
        return super()._status()

    def _tells_hits(self) -> bool:
        return "signed" in self._columns or not set(self._columns) <= set(FIELDS)
