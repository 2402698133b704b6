"""Rays between points, which the server makes."""

from __future__ import annotations

from typing import Any, Optional, Tuple

import numpy as np

from . import _proto
from ._arrays import common_type, triples
from ._generated import Generated, generator
from ._types import Array, UInt32s

_MOST = 16384  # points of either side, and pairs


class VisibilityPairs(Generated):
    """Rays from points to points, for Scene.cast: t = 1 is the second point, and `tmax` is 1 unless it is given, so
    that kind="any" tells what is hidden. A small `tmin` passes over the surface at the first point.

    from_points (a, 3), to_points (b, 3), real: each with each, of shape (a, b). pairs (k, 2), integers: only these rows
    of both, of shape (k). At most 16,384 of each. A ray of a point that is not
    finite is answered as invalid. tmin, tmax, mask: every ray's. Errors: TypeError, ValueError.
    """

    def __init__(self, from_points: Any, to_points: Any, pairs: Any = None, *, tmin: Optional[float] = None,
                 tmax: Optional[float] = None, mask: Optional[int] = None):
        given = [_points(from_points, "from_points"), _points(to_points, "to_points")]
        dtype = common_type([*given])
        self.from_points, self.to_points = (np.ascontiguousarray(points, dtype) for points in given)
        self.pairs: Optional[UInt32s] = None
        if pairs is not None:
            self.pairs = _pairs(pairs, len(self.from_points), len(self.to_points))
        self.tmin, self.tmax, self.mask = tmin, tmax, mask
        self.message()

    def __repr__(self) -> str:
        return f"<VisibilityPairs of {len(self.from_points)} and {len(self.to_points)} points: {self.count} rays>"

    @property
    def shape(self) -> Tuple[int, ...]:
        """(a, b), or (k)."""
        return (len(self.from_points), len(self.to_points)) if self.pairs is None else (len(self.pairs),)

    @property
    def dims(self) -> Tuple[str, ...]:
        return ("from", "to") if self.pairs is None else ("pair",)

    def message(self) -> Any:
        """A message RayGenerator of all rays."""
        pairs = _proto.VisibilityPairs(
            float64=self.from_points.dtype.itemsize == 8, to=self.to_points.tobytes(),
            pairs=b"" if self.pairs is None else self.pairs.tobytes(), **{"from": self.from_points.tobytes()})
        return generator(self.tmin, self.tmax, self.mask, pairs=pairs)


def _points(value: Any, name: str) -> Array:
    points = triples(value, name)
    if points.ndim != 2 or not 1 <= len(points) <= _MOST:
        raise ValueError(f"{name} has the shape (n, 3), with n from 1 to {_MOST}, not {points.shape}")
    return points


def _pairs(value: Any, most_from: int, most_to: int) -> UInt32s:
    pairs = np.asarray(value)
    if pairs.dtype.kind not in "iu":
        raise TypeError(f"pairs: integers are needed, not {pairs.dtype}")
    if pairs.ndim != 2 or pairs.shape[1] != 2 or not 1 <= len(pairs) <= _MOST:
        raise ValueError(f"pairs have the shape (k, 2), with k from 1 to {_MOST}, not {pairs.shape}")
    if pairs.min() < 0 or pairs[:, 0].max() >= most_from or pairs[:, 1].max() >= most_to:
        raise ValueError(f"pairs are rows of {most_from} and of {most_to} points, not "
                         f"{pairs.min(axis=0)} to {pairs.max(axis=0)}")
    return np.ascontiguousarray(pairs, "<u4")
