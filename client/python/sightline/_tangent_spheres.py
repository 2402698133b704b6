"""Rays from a surface, and the largest spheres that touch it at a point and have none of it inside.

A sphere begins large enough and is shrunk until it is empty: while a point of the surface lies inside, the sphere
through that point and the start is the next (Inui, Umezu, Shimane: Shrinking sphere, 2016).
"""

from __future__ import annotations

from typing import Tuple

import numpy as np

from ._faces import dot
from ._surface import Surface
from ._types import Array

_START = 1e-5      # a length: what is nearer to the start does not count
_FLATTEST = 1e-7   # of the reach of a mesh: what rises less above the plane at the start does not limit a sphere
_SHIFTS = 4        # times the rounding of vertices, which puts a start on the surface as far beside it


def longest_rays(surface: Surface, points: Array, directions: Array) -> Array:
    """(n): lengths of rays from points (n, 3) to the surface, beyond the start; +inf for none, NaN for an invalid
    ray."""
    length = np.linalg.norm(directions.astype("f8", copy=False), axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        start = np.nextafter(max(_START, _SHIFTS * surface.shift) / length, np.inf)
        reach: Array = surface.scene.cast(origins=points, directions=directions, tmin=start, fields=("t",)).t * length
        return reach


def shrink(surface: Surface, points: Array, axes: Array, threshold: float,
           max_iter: int) -> "Tuple[Array, Array]":
    """centers (n, 3) and radii (n) of spheres that touch the surface at points (n, 3), with their centers along unit
    axes (n, 3). NaN and +inf where nothing limits one."""
    if not len(surface.faces):
        return np.full(points.shape, np.nan), np.full(len(points), np.inf)
    low, high = _bounds(surface)
    step = threshold * float(np.linalg.norm(high - low))
    reach = np.linalg.norm(np.maximum(np.abs(points - low), np.abs(points - high)), axis=1)
    flat = np.maximum(_START, _FLATTEST * reach)
    radii, points = longest_rays(surface, points, axes) / 2, points.astype("f8", copy=False)
    is_open = np.isinf(radii)
    # Larger than any sphere through a point of the mesh that rises by more than `flat`.
    radii[is_open] = reach[is_open] ** 2 / (2 * flat[is_open])
    active = np.flatnonzero(np.isfinite(radii))
    for _ in range(max_iter):
        if not len(active):
            break
        start, axis, radius = points[active], axes[active], radii[active]
        touched, distance = _nearest(surface, start + radius[:, None] * axis)
        offset = touched - start
        rise = dot(offset, axis)
        limited = distance < radius - step
        unlimited = is_open[active] & ~(limited & (rise >= flat[active]))
        with np.errstate(divide="ignore", invalid="ignore"):
            smaller = np.where(limited & (rise > 0), np.minimum(radius, dot(offset, offset) / (2 * rise)), radius)
        radii[active] = np.where(unlimited, np.inf, smaller)
        is_open[active] = False
        active = active[limited & ~unlimited & (radius - smaller >= step)]
    centers = points + np.where(np.isfinite(radii), radii, np.nan)[:, None] * axes
    return centers, radii


def _nearest(surface: Surface, points: Array) -> "Tuple[Array, Array]":
    """The points (n, 3) of the surface that are nearest, and how far (n) they are."""
    near = surface.scene.closest(points, fields=("distance", "primitive", "position"))
    positions, distances, there = near.position, near.distance, np.flatnonzero(near.hit)
    positions[there], distances[there] = surface.measured(points[there], near.primitive[there], positions[there],
                                                          distances[there])
    return positions, distances


def _bounds(surface: Surface) -> "Tuple[Array, Array]":
    """Of the vertices that faces have."""
    corners = surface.vertices[np.minimum(np.unique(surface.faces), len(surface.vertices) - 1)].astype("f8")
    corners = corners[np.isfinite(corners).all(axis=1)]
    return corners.min(axis=0), corners.max(axis=0)
