"""Points as arrays, and grids of points that the server makes."""

from __future__ import annotations

import dataclasses
from typing import Any, Dict, List, Optional, Tuple

import numpy as np

from . import _proto
from ._arrays import Broadcast, Rows, bits, reals, triples
from ._generated import Generated, size, vector
from ._types import Array, Doubles


class Points(Rows):
    """Points with a leading shape, as columns over all `count` of them.

    positions: (n, 3) of `dtype`, float32 or float64, as is max_distance (n) or None; masks: (n) uint32 or None. The
    arrays may be views of the caller's, of any strides. position_type: what the positions were given as.
    """

    def __init__(self, shape: Tuple[int, ...], positions: Array, max_distance: Optional[Array],
                 masks: Optional[Array], position_type: Optional[np.dtype[Any]] = None):
        super().__init__(shape, positions.dtype)
        self.positions, self.max_distance, self.masks = positions, max_distance, masks
        self.position_type = position_type or positions.dtype

    def some(self, rows: Array) -> "Points":
        """Those with these numbers (m)."""
        bound, masks = (None if column is None else column[rows] for column in (self.max_distance, self.masks))
        return Points((len(rows),), self.positions[rows], bound, masks, self.position_type)

    def columns(self) -> "List[Optional[Array]]":
        return [self.positions, self.max_distance, self.masks]


@dataclasses.dataclass(frozen=True)
class PointGrid(Generated):
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
            object.__setattr__(self, name, vector(getattr(self, name), name))
        for along in self.shape:
            size(along, "each of columns, rows and layers")
        bits(self.mask)

    @property
    def shape(self) -> Tuple[int, ...]:
        """(rows, columns), or (layers, rows, columns)."""
        return (self.rows, self.columns) if self.layers is None else (self.layers, self.rows, self.columns)

    @property
    def dims(self) -> Tuple[str, ...]:
        return ("row", "column") if self.layers is None else ("layer", "row", "column")

    @property
    def coordinates(self) -> "Dict[str, Tuple[Tuple[str, ...], Doubles]]":
        """Where the points are."""
        positions = self.positions()
        return {name: (self.dims, positions[..., axis]) for axis, name in enumerate("xyz")}

    def positions(self) -> Doubles:
        """float64 (*shape, 3): the points, bit for bit as the server makes them."""
        return self._made(np.arange(self.count)).reshape(*self.shape, 3)

    def some(self, rows: Array) -> Points:
        """Those with these numbers (m)."""
        return as_points(self._made(rows), self.max_distance, self.mask)

    def _made(self, number: Array) -> Array:
        i, j, k = number % self.columns, number // self.columns % self.rows, number // self.columns // self.rows
        origin, across, down, deep = map(np.array, (self.origin, self.across, self.down, self.deep))
        made: Array = origin + i[:, None] * across + j[:, None] * down + k[:, None] * deep
        return made

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
    return Points(columns.shape, columns.vectors[0], columns.numbers[0], columns.masks, positions.dtype)


def check_grid(points: Any, max_distance: Any, masks: Any) -> None:
    """TypeError: what the server makes are rays, not points; and as check_bounds()."""
    if not isinstance(points, PointGrid):
        raise TypeError(f"points are an array or a PointGrid, not {type(points).__name__}")
    check_bounds(points, max_distance, masks)


def check_bounds(points: Any, max_distance: Any, masks: Any) -> None:
    """TypeError: Points or a PointGrid, which have max_distance and masks of their own, and one of these beside."""
    if isinstance(points, (Points, PointGrid)) and (max_distance is not None or masks is not None):
        raise TypeError(f"{type(points).__name__} have their own max_distance and masks")
