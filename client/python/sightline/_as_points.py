"""Points from what users pass."""

from __future__ import annotations

from typing import Any

from ._arrays import Broadcast, bits, reals, triples
from .point_grid import PointGrid
from .points import Points


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
