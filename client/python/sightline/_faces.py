"""Distances from faces in float64, for meshes whose vertices the server has rounded."""

from __future__ import annotations

from typing import Tuple

import numpy as np

from ._types import Array


def dot(a: Array, b: Array) -> Array:
    """(n), of rows (n, 3)."""
    products: Array = np.einsum("ij,ij->i", a, b)
    return products


def cross(a: Array, b: Array) -> Array:
    """(n, 3), of rows (n, 3)."""
    (ax, ay, az), (bx, by, bz) = a.T, b.T
    return np.stack([ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx], axis=1)


def closest_on_faces(corners: Array, points: Array) -> "Tuple[Array, Array]":
    """Of faces with corners (n, 3, 3), each its point (n, 3) that is nearest to one of points (n, 3), and how far (n)
    that is. A face without area is the segment or the point that it is."""
    points = points.astype("f8", copy=False)
    nearest = _within(corners, points)
    distance = np.linalg.norm(nearest - points, axis=1)
    distance[np.isnan(distance)] = np.inf
    for k in range(3):
        start, along = corners[:, k], corners[:, (k + 1) % 3] - corners[:, k]
        square = dot(along, along)
        share = np.divide(dot(points - start, along), square, out=np.zeros_like(square), where=square > 0)
        on_edge = start + np.clip(share, 0, 1)[:, None] * along
        length = np.linalg.norm(on_edge - points, axis=1)
        rows = length < distance
        nearest[rows], distance[rows] = on_edge[rows], length[rows]
    return nearest, distance


def _within(corners: Array, points: Array) -> Array:
    """(n, 3): the feet of points on the planes of faces, NaN where they lie beside the face."""
    origin, first, second = corners[:, 0], corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    offset, normal = points - origin, cross(first, second)
    square = dot(normal, normal)
    with np.errstate(divide="ignore", invalid="ignore"):
        u, v = dot(cross(offset, second), normal) / square, dot(cross(first, offset), normal) / square
        foot: Array = origin + u[:, None] * first + v[:, None] * second
        foot[~((u >= 0) & (v >= 0) & (u + v <= 1))] = np.nan
    return foot
