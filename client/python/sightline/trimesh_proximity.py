"""ProximityQuery, and the functions beside it, for programs that were written for trimesh.proximity. docs/python.md
explains the differences.

A mesh is an object with `vertices` (v, 3) and `faces` (f, 3) such as trimesh.Trimesh. It goes to a server with the
first query, and again after it has changed. client: default, the server of SIGHTLINE_ENDPOINT, else a private one.
"""

from __future__ import annotations

from typing import Any, Optional, Tuple

import numpy as np
from numpy.typing import ArrayLike

from . import _tangent_spheres
from ._faces import dot
from ._surface import OfMesh, Surface, points_of, side_rays, surface_of
from ._types import Array
from .client import Client

_NEAR = 1e-8          # a length: nearer to the surface no side is told; of squares of distances, too
_FACING = 1 - 1e-12   # a cosine that no other face has more of
_BEHIND = -1 + 1e-6   # one of faces that the point is straight behind


class ProximityQuery(OfMesh):
    """What is nearest to points on one mesh. Pickles as its mesh."""

    def on_surface(self, points: ArrayLike) -> Tuple[Array, Array, Array]:
        """As closest_point()."""
        return _closest(self._surface(), points_of(points))

    def vertex(self, points: ArrayLike) -> Tuple[Array, Array]:
        """The vertex of a face that is nearest to each of points (..., 3): distance (...) float64 and its number (...)
        int64; of equal ones the least. A point that is not finite: NaN and -1; a mesh without faces: +inf and -1."""
        surface, array = self._surface(), np.asarray(points)
        cloud = surface.cloud
        near = cloud.own.scene.closest(array, fields=("distance", "primitive"))
        number, distance = np.full(near.shape, -1), near.distance
        number[near.hit] = cloud.numbers[near.primitive[near.hit]]
        if cloud.is_moved:
            distance[near.hit] = np.linalg.norm(array[near.hit] - surface.vertices[number[near.hit]], axis=1)
        return distance[()], number[()]

    def signed_distance(self, points: ArrayLike) -> Array:
        """As the function of this name."""
        return _signed(self._surface(), self.mesh, points_of(points))


def closest_point(mesh: Any, points: ArrayLike, *,
                  client: Optional[Client] = None) -> Tuple[Array, Array, Array]:
    """The nearest point of a mesh for each of points (n, 3): closest (n, 3) and distance (n) float64, triangle_id (n)
    int64. Of the two nearest faces, if squares of their distances differ by less than 1e-8 and are above it, it is that
    whose normal points more toward the point. A point that is not finite has NaN and -1, a mesh without faces +inf, NaN
    and -1. Errors: ValueError, points of another shape."""
    return _closest(surface_of(mesh, client), points_of(points))


def signed_distance(mesh: Any, points: ArrayLike, *, client: Optional[Client] = None) -> Array:
    """float64 (n): the distance of points (n, 3) from a mesh, positive inside and within 1e-8 of the surface, else
    negative. Where a point projects into its nearest face the face's normal tells the side, elsewhere a ray, or three
    where the mesh is not closed. A point that is not finite has NaN, a mesh without faces -inf."""
    return _signed(surface_of(mesh, client), mesh, points_of(points))


def longest_ray(mesh: Any, points: ArrayLike, directions: ArrayLike, *, client: Optional[Client] = None) -> Array:
    """float64 (n): how far rays from points (n, 3) go in directions (n, 3) until they meet the mesh; +inf where they do
    not. Faces within 1e-5 of the start do not count, so that rays may begin on the surface."""
    return _tangent_spheres.longest_rays(surface_of(mesh, client), *_vectors(points, directions, "directions"))


def max_tangent_sphere(mesh: Any, points: ArrayLike, inwards: bool = True, normals: Optional[ArrayLike] = None,
                       threshold: float = 1e-6, max_iter: int = 100, *,
                       client: Optional[Client] = None) -> Tuple[Array, Array]:
    """The largest spheres that touch a mesh at points (n, 3) of its surface and have none of it inside: centers (n, 3)
    and radii (n) float64; NaN and +inf where nothing limits one. normals (n, 3), of any length: outward at the points;
    None: those of the nearest faces. A sphere is found when a step shrinks it by less than `threshold` times the
    diagonal of the mesh, or after max_iter steps."""
    surface, array = surface_of(mesh, client), points_of(points)
    array, outward = _with_normals(surface, array, normals)
    return _tangent_spheres.shrink(surface, array, -outward if inwards else outward, threshold, max_iter)


def thickness(mesh: Any, points: ArrayLike, exterior: bool = False, normals: Optional[ArrayLike] = None,
              method: str = "max_sphere", *, client: Optional[Client] = None) -> Array:
    """float64 (n): how thick a mesh is at points (n, 3) of its surface, or with `exterior` how far it is to the next of
    it outside; +inf where nothing is there. method: "max_sphere", the diameter of the largest tangent sphere, or "ray",
    the length of a ray along the normal. normals: as for max_tangent_sphere(). Errors: ValueError, another method."""
    if method not in ("max_sphere", "ray"):
        raise ValueError(f"method is max_sphere or ray, not {method!r}")
    if method == "max_sphere":
        return max_tangent_sphere(mesh, points, not exterior, normals, client=client)[1] * 2
    surface, array = surface_of(mesh, client), points_of(points)
    array, outward = _with_normals(surface, array, normals)
    return _tangent_spheres.longest_rays(surface, array, outward if exterior else -outward)


def _closest(surface: Surface, points: Array,
             least: float = _FACING) -> Tuple[Array, Array, Array]:
    """As closest_point(). least: where the nearest face points toward the point by at least so much, as the cosine of
    an angle, the second is not looked at."""
    near = surface.scene.closest(points, fields=("distance", "primitive", "position"))
    closest, distance = near.position, near.distance
    triangle = np.where(near.hit, near.primitive.astype("i8"), -1)
    there = np.flatnonzero(near.hit)
    closest[there], distance[there] = surface.measured(points[there], triangle[there], closest[there], distance[there])
    toward = _toward(surface, points[there], triangle[there], closest[there])
    unsure = there[(distance[there] ** 2 > _NEAR) & (toward < least)]
    if len(unsure):
        closest[unsure], distance[unsure], triangle[unsure] = _of_two(surface, points[unsure], distance[unsure])
    return closest, distance, triangle


def _of_two(surface: Surface, points: Array, nearest: Array) -> Tuple[Array, Array, Array]:
    """The same where two faces are looked at. nearest (n): distances."""
    limit = np.sqrt((nearest + surface.shift) ** 2 + _NEAR) + 2 * surface.shift
    exact = points.astype("f8", copy=False)  # which warns once of points that float32 does not hold well
    near = surface.scene.closest(exact, limit, kind="all", max_hits=2, fields=("distance", "primitive", "position"))
    triangles, begin = near.primitive.astype("i8"), near.offset[:-1].astype("i8")
    closest, distance = surface.measured(points[near.point], triangles, near.position, near.distance)
    second = begin + (near.count > 1)
    chosen = np.where(distance[second] < distance[begin], second, begin)
    squares = distance ** 2
    rows = np.flatnonzero((np.abs(squares[second] - squares[begin]) < _NEAR) &
                          (np.minimum(squares[begin], squares[second]) > _NEAR) & (second != begin))
    one, other = (_toward(surface, points[rows], triangles[some[rows]], closest[some[rows]]) for some in (begin, second))
    chosen[rows] = np.where(other > one, second[rows], begin[rows])
    return closest[chosen], distance[chosen], triangles[chosen]


def _toward(surface: Surface, points: Array, triangles: Array, closest: Array) -> Array:
    """(n): cosines of the angles between normals and the ways from the faces to points (n, 3)."""
    offset = points - closest
    length = np.linalg.norm(offset, axis=1)
    along = dot(surface.normals(triangles), offset)
    return np.divide(along, length, out=np.zeros_like(along), where=length > 0)


def _signed(surface: Surface, mesh: Any, points: Array) -> Array:
    closest, distance, triangle = _closest(surface, points, _BEHIND)
    far = np.flatnonzero((distance > _NEAR) & (triangle >= 0))
    offset, normals = points[far] - closest[far], surface.normals(triangle[far])
    height = dot(offset, normals)
    corners = surface.corners(triangle[far])
    size = np.ptp(corners, axis=1).max(axis=1)
    projects = np.linalg.norm(offset - height[:, None] * normals, axis=1) <= _NEAR * size
    inside = height < 0
    if not projects.all():
        others = ~projects
        exact = points[far[others]].astype("f8", copy=False)
        inside[others] = surface.scene.contains(exact, side_rays=side_rays(mesh))
    sign = np.where(np.isinf(distance), -1.0, 1.0)
    sign[far] = np.where(inside, 1.0, -1.0)
    signed: Array = distance * sign
    return signed


def _with_normals(surface: Surface, points: Array,
                  normals: Optional[ArrayLike]) -> Tuple[Array, Array]:
    """The points, and normals float64 (n, 3), unit."""
    if normals is None:
        triangle = _closest(surface, points)[2]
        found = np.full((len(points), 3), np.nan)
        found[triangle >= 0] = surface.normals(triangle[triangle >= 0])
        return points.astype("f8", copy=False), found
    given = _vectors(points, normals, "normals")[1].astype("f8")
    length = np.linalg.norm(given, axis=1, keepdims=True)
    return points, np.divide(given, length, out=np.full_like(given, np.nan), where=length > 0)


def _vectors(points: ArrayLike, vectors: ArrayLike, name: str) -> Tuple[Array, Array]:
    array, others = points_of(points), np.asarray(vectors)
    if others.shape != array.shape:
        raise ValueError(f"points and {name} have one shape (n, 3), not {array.shape} and {others.shape}")
    return array, others
