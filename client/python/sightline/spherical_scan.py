"""Rays of a scanner, which the server makes."""

from __future__ import annotations

import dataclasses
import math
from typing import Any, Dict, Optional, Sequence, Tuple

import numpy as np

from . import _proto
from ._generated import Generated, Triple, generator, size, vector
from ._types import Doubles

_MOST_RADIANS = 64.0


@dataclasses.dataclass(frozen=True)
class SphericalScan(Generated):
    """Rays from one point in equal steps of two angles, for Scene.cast, of shape (rows, columns).

    origin, forward, left, up: (3), finite; unit and orthogonal axes give unit directions: azimuth a and elevation e are
    the direction cos e (cos a forward + sin a left) + sin e up. azimuth, elevation: begin and end in radians, from -64
    to 64, cut into `columns` and `rows` parts, at most 1,048,576; each ray goes through the middle of its part. tmin,
    tmax, mask: every ray's. Errors: TypeError, ValueError.
    """

    origin: Triple
    columns: int
    rows: int
    azimuth: Sequence[float] = (-math.pi, math.pi)
    elevation: Sequence[float] = (-math.pi / 2, math.pi / 2)
    forward: Triple = (1.0, 0.0, 0.0)
    left: Triple = (0.0, 1.0, 0.0)
    up: Triple = (0.0, 0.0, 1.0)
    tmin: Optional[float] = None
    tmax: Optional[float] = None
    mask: Optional[int] = None

    def __post_init__(self) -> None:
        for name in ("origin", "forward", "left", "up"):
            object.__setattr__(self, name, vector(getattr(self, name), name))
        for name in ("azimuth", "elevation"):
            object.__setattr__(self, name, _interval(getattr(self, name), name))
        for name in ("columns", "rows"):
            size(getattr(self, name), name)
        self.message()

    @property
    def shape(self) -> Tuple[int, ...]:
        """(rows, columns)."""
        return self.rows, self.columns

    @property
    def dims(self) -> Tuple[str, ...]:
        return "row", "column"

    @property
    def coordinates(self) -> "Dict[str, Tuple[Tuple[str, ...], Doubles]]":
        """The angles of the rows and columns, in radians."""
        return {"elevation": (("row",), _middles(self.elevation, self.rows)),
                "azimuth": (("column",), _middles(self.azimuth, self.columns))}

    def message(self) -> Any:
        """A message RayGenerator of all rays."""
        scan = _proto.SphericalScan(origin=self.origin, forward=self.forward, left=self.left, up=self.up,
                                    azimuth=self.azimuth, elevation=self.elevation, columns=self.columns, rows=self.rows)
        return generator(self.tmin, self.tmax, self.mask, scan=scan)


def _interval(value: Any, name: str) -> "Tuple[float, float]":
    begin, end = (float(angle) for angle in value)
    if not (abs(begin) <= _MOST_RADIANS and abs(end) <= _MOST_RADIANS):
        raise ValueError(f"{name} has a begin and an end from {-_MOST_RADIANS:g} to {_MOST_RADIANS:g} radians, not "
                         f"{value!r}")
    return begin, end


def _middles(interval: "Sequence[float]", parts: int) -> Doubles:
    return interval[0] + (np.arange(parts) + 0.5) / parts * (interval[1] - interval[0])
