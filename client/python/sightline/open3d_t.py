"""RaycastingScene, for programs that were written for open3d.t.geometry. docs/python.md explains the differences.

Answers are arrays; they are tensors of Open3D where such a tensor was passed.
"""

from __future__ import annotations

from typing import Any, Callable, Dict, List, Optional, Union

import numpy as np

from ._meshes_of import OwnScene
from ._pinhole import intrinsic_rays, look_at
from ._sides import check_rays
from ._types import Array
from .client import Client
from .hits import Hits

_INVALID_ID = 0xFFFFFFFF


class Tensor(np.ndarray):  # type: ignore[type-arg]
    """An array with the methods of a tensor that give an array."""

    def numpy(self) -> Array:
        return self.view(np.ndarray)

    def cpu(self) -> "Tensor":
        return self


class RaycastingScene:
    """Meshes that rays are cast at. client: default, the server of SIGHTLINE_ENDPOINT, else a private one. `nthreads`
    and `device` are accepted, and have no effect: the server decides."""

    INVALID_ID = _INVALID_ID

    def __init__(self, nthreads: int = 0, device: Any = None, *, client: Optional[Client] = None):
        self._own = OwnScene(client)
        self._nodes: "List[int]" = []  # the nodes of geometry ids; node ids rise, too

    def add_triangles(self, vertex_positions: Any, triangle_indices: Any = None) -> int:
        """Adds a mesh, positions (v, 3) and indices (f, 3), or an object that has them. Returns its geometry id, from 0
        upward. Errors: TypeError, ValueError (not a mesh)."""
        if triangle_indices is None:
            vertex_positions, triangle_indices = _arrays_of(vertex_positions)
        vertices, faces = _array(vertex_positions), _array(triangle_indices)
        node = self._own.scene.add(name=f"{len(self._nodes)}") if not len(faces) else self._own.add(vertices, faces)
        self._nodes.append(node.id)
        return len(self._nodes) - 1

    def cast_rays(self, rays: Any, nthreads: int = 0) -> Dict[str, Any]:
        """What rays (..., 6) hit first: t_hit (...) float32, +inf for none; geometry_ids, primitive_ids (...) uint32,
        INVALID_ID for none; primitive_uvs (..., 2), primitive_normals (..., 3) float32."""
        hits = self._own.scene.cast(_array(rays))
        wrap = _wrapper(rays)
        return {"t_hit": wrap(_distances(hits.t)), "geometry_ids": wrap(self._geometry(hits.node)),
                "primitive_ids": wrap(_or_invalid(hits)), "primitive_uvs": wrap(hits.uv),
                "primitive_normals": wrap(hits.normal)}

    def test_occlusions(self, rays: Any, tnear: float = 0.0, tfar: float = float("inf"), nthreads: int = 0) -> Any:
        """bool (...): whether rays hit anything with tnear <= t <= tfar."""
        hits = self._own.scene.cast(_array(rays), tmin=tnear, tmax=tfar, kind="any")
        return _wrapper(rays)(hits.hit)

    def count_intersections(self, rays: Any, nthreads: int = 0) -> Any:
        """int32 (...): how many triangles each ray crosses; 0 for a ray that cannot be cast."""
        hits = self._own.scene.cast(_array(rays), kind="count")
        return _wrapper(rays)(np.where(hits.invalid, 0, hits.count).astype(np.int32))

    def list_intersections(self, rays: Any, nthreads: int = 0) -> Dict[str, Any]:
        """Every hit of rays (..., 6), near to far for each: ray_splits (n + 1) and ray_ids (m) uint32; t_hit (m),
        primitive_uvs (m, 2) float32; geometry_ids, primitive_ids (m) uint32. The hits of flattened ray i are the rows
        ray_splits[i] up to ray_splits[i + 1]."""
        hits = self._own.scene.cast(_array(rays), kind="all", fields=("t", "node", "primitive", "uv"))
        wrap = _wrapper(rays)
        return {"ray_splits": wrap(hits.offset.astype(np.uint32)), "ray_ids": wrap(hits.ray.astype(np.uint32)),
                "t_hit": wrap(hits.t.astype(np.float32)), "geometry_ids": wrap(self._geometry(hits.node)),
                "primitive_ids": wrap(hits.primitive), "primitive_uvs": wrap(hits.uv)}

    @staticmethod
    def create_rays_pinhole(*arguments: Any, **named: Any) -> Any:
        """float32 (height, width, 6), rays through the middles of pixels, row by row. Two forms:

        create_rays_pinhole(intrinsic_matrix (3, 3), extrinsic_matrix (4, 4), width_px, height_px)
        create_rays_pinhole(fov_deg, center (3), eye (3), up (3), width_px, height_px), fov from left to right
        """
        wrap = _wrapper(*arguments, *named.values())
        arguments, named = tuple(map(_array, arguments)), {name: _array(value) for name, value in named.items()}
        if len(arguments) + len(named) == 6:
            return wrap(look_at(*arguments, **named))
        return wrap(intrinsic_rays(*arguments, **named))

    def compute_closest_points(self, query_points: Any, nthreads: int = 0) -> Dict[str, Any]:
        """What is nearest to points (..., 3): points (..., 3) float32 on the surface, NaN where there is none;
        geometry_ids, primitive_ids (...) uint32, INVALID_ID for none; primitive_uvs (..., 2), primitive_normals
        (..., 3) float32."""
        near = self._own.scene.closest(_array(query_points), fields=("position", "node", "primitive", "uv", "normal"))
        wrap = _wrapper(query_points)
        return {"points": wrap(near.position.astype(np.float32)), "geometry_ids": wrap(self._geometry(near.node)),
                "primitive_ids": wrap(_or_invalid(near)), "primitive_uvs": wrap(near.uv),
                "primitive_normals": wrap(near.normal)}

    def compute_distance(self, query_points: Any, nthreads: int = 0) -> Any:
        """float32 (...): the distance of points (..., 3) from the surface; +inf where there is none, NaN of a point
        that is not finite."""
        near = self._own.scene.closest(_array(query_points), fields=("distance",))
        with np.errstate(over="ignore"):
            return _wrapper(query_points)(near.distance.astype(np.float32))

    def compute_signed_distance(self, query_points: Any, nthreads: int = 0, nsamples: int = 1) -> Any:
        """float32 (...): the distance of points (..., 3) from the surface, negative inside the closed meshes; +inf
        where there is no surface, NaN of a point that is not finite. nsamples, odd, at most 63: of so many rays the
        majority tells the inside, which helps where meshes have holes. Errors: ValueError, another number of them."""
        near = self._own.scene.closest(_array(query_points), fields=("signed",), side_rays=check_rays(nsamples, "nsamples"))
        with np.errstate(over="ignore"):
            return _wrapper(query_points)(near.signed.astype(np.float32))

    def compute_occupancy(self, query_points: Any, nthreads: int = 0, nsamples: int = 1) -> Any:
        """float32 (...): 1 for points (..., 3) inside the closed meshes, else 0, also for a point that is not finite.
        nsamples, and errors: as of compute_signed_distance()."""
        inside = self._own.scene.contains(_array(query_points), side_rays=check_rays(nsamples, "nsamples"))
        return _wrapper(query_points)(inside.astype(np.float32))

    def _geometry(self, node: Array) -> Array:
        """Geometry ids of nodes."""
        known = np.array(self._nodes, np.uint64)
        return np.where(node == 0, _INVALID_ID, np.searchsorted(known, node)).astype(np.uint32)


def _or_invalid(hits: Hits) -> Array:
    """uint32, faces of hits, INVALID_ID for none."""
    return np.where(hits.hit, hits.primitive, np.uint32(_INVALID_ID))


def _distances(t: Array) -> Array:
    """float32, with +inf for rays that cannot be cast, too."""
    return np.where(np.isnan(t), np.inf, t).astype(np.float32)


def _arrays_of(mesh: Any) -> "tuple[Any, Any]":
    """The arrays of a mesh with tensors (`vertex`, `triangle`), with older arrays, or with `vertices` and `faces`."""
    if hasattr(mesh, "vertex") and hasattr(mesh, "triangle"):
        return mesh.vertex["positions"], mesh.triangle["indices"]
    if hasattr(mesh, "vertices") and hasattr(mesh, "triangles"):
        return np.asarray(mesh.vertices), np.asarray(mesh.triangles)
    if hasattr(mesh, "vertices") and hasattr(mesh, "faces"):
        return mesh.vertices, mesh.faces
    raise TypeError(f"a {type(mesh).__name__} is not a mesh")


def _is_tensor(value: Any) -> bool:
    return type(value).__module__.partition(".")[0] == "open3d"


def _array(value: Any) -> Any:
    return value.cpu().numpy() if _is_tensor(value) or isinstance(value, Tensor) else value


def _wrapper(*arguments: Any) -> "Callable[[Array], Union[Tensor, Any]]":
    """What answers are given as."""
    for value in arguments:
        if _is_tensor(value) and hasattr(type(value), "from_numpy"):
            return lambda array: type(value).from_numpy(np.ascontiguousarray(array))
    return lambda array: np.asarray(array).view(Tensor)
