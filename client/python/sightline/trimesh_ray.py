"""RayMeshIntersector, for programs that were written for trimesh.ray. docs/python.md explains the differences."""

from __future__ import annotations

from typing import Any, Optional, Tuple

import numpy as np
from numpy.typing import ArrayLike

from ._surface import OfMesh, points_of, side_rays
from ._types import Array
from ._warnings import warn
from .client import Client
from .scene import Scene


class RayMeshIntersector(OfMesh):
    """Ray queries on one mesh, an object with `vertices` (v, 3) and `faces` (f, 3) such as trimesh.Trimesh.

    The mesh goes to a server with the first query, and again after it has changed. client: default, the server of
    SIGHTLINE_ENDPOINT, else a private one. Pickles as its mesh. `scale_to_box` is accepted and has no effect.
    """

    def __init__(self, geometry: Any = None, scale_to_box: bool = True, *, mesh: Any = None,
                 client: Optional[Client] = None):
        super().__init__(geometry if geometry is not None else mesh, client)

    def intersects_id(self, ray_origins: ArrayLike, ray_directions: ArrayLike, multiple_hits: bool = True,
                      max_hits: Optional[int] = 100, return_locations: bool = False) -> Tuple[Array, ...]:
        """The faces that rays hit, by ray, then near to far: index_tri (m), index_ray (m), both int64, and locations
        (m, 3) float64 if `return_locations`. Without `multiple_hits` only the first of each ray. A warning says if a
        ray has more than `max_hits`; None: all are listed."""
        origins, directions = rays_of(ray_origins, ray_directions)
        if multiple_hits:
            hits = self._scene().cast(origins=origins, directions=directions, kind="all", fields=("t", "primitive"),
                                      max_hits=max_hits or 0)
            if max_hits and hits.cut_off.any():
                warn(f"{int(hits.cut_off.sum())} rays have more than max_hits={max_hits} hits; the nearest are listed")
            ray, face, locations = hits.ray, hits.primitive, hits.position
        else:
            first = self._scene().cast(origins=origins, directions=directions, fields=("t", "primitive"))
            ray = np.flatnonzero(first.hit)
            face, locations = first.primitive[ray], first.position[ray]
        index_tri, index_ray = face.astype(np.int64), ray.astype(np.int64)
        return (index_tri, index_ray, locations) if return_locations else (index_tri, index_ray)

    def intersects_location(self, ray_origins: ArrayLike, ray_directions: ArrayLike,
                            multiple_hits: bool = True) -> Tuple[Array, Array, Array]:
        """Where rays hit, all hits of each ray or the first: locations (m, 3), index_ray (m), index_tri (m)."""
        face, ray, locations = self.intersects_id(ray_origins, ray_directions, multiple_hits, None, True)
        return locations, ray, face

    def intersects_first(self, ray_origins: ArrayLike, ray_directions: ArrayLike) -> Array:
        """int64 (n): the first face that each ray hits, or -1."""
        origins, directions = rays_of(ray_origins, ray_directions)
        hits = self._scene().cast(origins=origins, directions=directions, fields=("t", "primitive"))
        return np.where(hits.hit, hits.primitive.astype(np.int64), -1)

    def intersects_any(self, ray_origins: ArrayLike, ray_directions: ArrayLike) -> Array:
        """bool (n): whether each ray hits."""
        origins, directions = rays_of(ray_origins, ray_directions)
        return self._scene().cast(origins=origins, directions=directions, kind="any").hit

    def contains_points(self, points: ArrayLike) -> Array:
        """bool (n): whether each point (n, 3) is inside the mesh: a ray from it crosses an odd number of faces. Where
        the mesh is not closed, by the majority of three rays. A point on the surface may get either answer."""
        return self._scene().contains(points_of(points), side_rays=side_rays(self.mesh))

    def _scene(self) -> Scene:
        """The scene of the mesh as it is now."""
        return self._surface().scene


def rays_of(ray_origins: ArrayLike, ray_directions: ArrayLike) -> Tuple[Array, Array]:
    origins, directions = np.asarray(ray_origins), np.asarray(ray_directions)
    if origins.shape != directions.shape or origins.ndim != 2 or origins.shape[1] != 3:
        raise ValueError(f"origins and directions have one shape (n, 3), not {origins.shape} and {directions.shape}")
    return origins, directions
