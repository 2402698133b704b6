"""Points as arrays, and grids of points that the server makes."""

from __future__ import annotations

import dataclasses
import math
from typing import Any, List, Optional, Tuple

import numpy as np

from . import _proto
from ._arrays import Broadcast, Rows, bits, reals, triples

_MOST_IN_A_ROW = 1 << 20


class Points(Rows):
    """Points with a leading shape, as columns over all `count` of them.

    positions: (n, 3) of `dtype`, float32 or float64, as is max_distance (n) or None; masks: (n) uint32 or None. The
    arrays may be views of the caller's, of any strides. position_type: what the positions were given as.
    """

    def __init__(self, shape: Tuple[int, ...], positions: np.ndarray, max_distance: Optional[np.ndarray],
                 masks: Optional[np.ndarray], position_type: Optional[np.dtype] = None):
        super().__init__(shape, positions.dtype)
        self.positions, self.max_distance, self.masks = positions, max_distance, masks
        self.position_type = position_type or positions.dtype

    def some(self, rows: np.ndarray) -> "Points":
        """Those with these numbers (m)."""
        bound, masks = (None if column is None else column[rows] for column in (self.max_distance, self.masks))
        return Points((len(rows),), self.positions[rows], bound, masks, self.position_type)

    def columns(self) -> "List[Optional[np.ndarray]]":
        return [self.positions, self.max_distance, self.masks]


@dataclasses.dataclass(frozen=True)
class PointGrid:
    """Points in equal steps, which the server makes: point (k, j, i) is origin + i across + j down + k deep.

    origin, across, down, deep: (3), finite. columns, rows, layers: how many values i, j and k have, from 0, at most
    1,048,576; layers None: one, and the answer's shape is (rows, columns), else it is (layers, rows, columns).
    max_distance, mask: every point's. Errors: TypeError, ValueError.
    """

    origin: Tuple[float, ...]
    across: Tuple[float, ...]
    down: Tuple[float, ...]
    columns: int
    rows: int
    deep: Tuple[float, ...] = (0.0, 0.0, 0.0)
    layers: Optional[int] = None
    max_distance: Optional[float] = None
    mask: Optional[int] = None

    def __post_init__(self) -> None:
        for name in ("origin", "across", "down", "deep"):
            vector = reals(getattr(self, name), name)
            if vector.shape != (3,) or not np.isfinite(vector).all():
                raise ValueError(f"{name} has three finite numbers, not {getattr(self, name)!r}")
            object.__setattr__(self, name, tuple(vector.astype("f8").tolist()))
        for size in self.shape:
            if not 1 <= size <= _MOST_IN_A_ROW:
                raise ValueError(f"columns, rows and layers are from 1 to {_MOST_IN_A_ROW}, not {size}")
        bits(self.mask)

    @property
    def shape(self) -> Tuple[int, ...]:
        """(rows, columns), or (layers, rows, columns)."""
        return (self.rows, self.columns) if self.layers is None else (self.layers, self.rows, self.columns)

    @property
    def count(self) -> int:
        """How many points there are."""
        return math.prod(self.shape)

    def positions(self) -> np.ndarray:
        """float64 (*shape, 3): the points, bit for bit as the server makes them."""
        return self._made(np.arange(self.count)).reshape(*self.shape, 3)

    def some(self, rows: np.ndarray) -> Points:
        """Those with these numbers (m)."""
        return as_points(self._made(rows), self.max_distance, self.mask)

    def _made(self, number: np.ndarray) -> np.ndarray:
        i, j, k = number % self.columns, number // self.columns % self.rows, number // self.columns // self.rows
        origin, across, down, deep = map(np.array, (self.origin, self.across, self.down, self.deep))
        return origin + i[:, None] * across + j[:, None] * down + k[:, None] * deep

    def message(self) -> Any:
        """A message PointGrid of all points."""
        return _proto.PointGrid(origin=self.origin, across=self.across, down=self.down, deep=self.deep,
                                columns=self.columns, rows=self.rows, layers=self.layers or 1,
                                max_distance=self.max_distance, mask=self.mask)


def as_points(points: Any, max_distance: Any = None, masks: Any = None) -> Points:
    """Points from an array (..., 3), with which max_distance and masks (...) are broadcast; or those of a PointGrid.

    TypeError: not real numbers. ValueError: a shape that is not of points.
    """
    check_bounds(points, max_distance, masks)
    if isinstance(points, Points):
        return points
    if isinstance(points, PointGrid):
        return as_points(points.positions(), points.max_distance, points.mask)
    positions = triples(points, "points")
    bound = None if max_distance is None else reals(max_distance, "max_distance")
    columns = Broadcast([positions], [bound], bits(masks))
    return Points(columns.shape, *columns.vectors, *columns.numbers, columns.masks, positions.dtype)


def check_bounds(points: Any, max_distance: Any, masks: Any) -> None:
    """TypeError: Points or a PointGrid, which have max_distance and masks of their own, and one of these beside."""
    if isinstance(points, (Points, PointGrid)) and (max_distance is not None or masks is not None):
        raise TypeError(f"{type(points).__name__} have their own max_distance and masks")
