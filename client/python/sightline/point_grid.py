"""Grids of points, which the server makes."""

from __future__ import annotations

import dataclasses
from typing import Any, Dict, Optional, Tuple

import numpy as np

from . import _proto
from ._arrays import bits
from ._generated import Generated, Triple, size, vector
from ._types import Array, Doubles
from .points import Points


@dataclasses.dataclass(frozen=True)
class PointGrid(Generated):
    """Points in equal steps, which the server makes: point (k, j, i) is origin + i across + j down + k deep.

    origin, across, down, deep: (3), finite. columns, rows, layers: how many values i, j and k have, from 0, at most
    1,048,576; layers None: one, and the answer's shape is (rows, columns), else it is (layers, rows, columns).
    max_distance, mask: every point's. Errors: TypeError, ValueError.
    """

    origin: Triple
    across: Triple
    down: Triple
    columns: int
    rows: int
    deep: Triple = (0.0, 0.0, 0.0)
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
        bound = None if self.max_distance is None else np.full(len(rows), self.max_distance)
        masks = None if self.mask is None else np.full(len(rows), self.mask, np.uint32)
        return Points((len(rows),), self._made(rows), bound, masks)

    def _made(self, number: Array) -> Array:
        i, j, k = number % self.columns, number // self.columns % self.rows, number // self.columns // self.rows
        origin, across, down, deep = (np.array(step, "f8") for step in (self.origin, self.across, self.down, self.deep))
        made: Array = origin + i[:, None] * across + j[:, None] * down + k[:, None] * deep
        return made

    def message(self) -> Any:
        """A message PointGrid of all points."""
        return _proto.PointGrid(origin=self.origin, across=self.across, down=self.down, deep=self.deep,
                                columns=self.columns, rows=self.rows, layers=self.layers or 1,
                                max_distance=self.max_distance, mask=self.mask)
