"""Meshes of other libraries behind the drop-in classes: each in a scene of its own, sent again when it has changed."""

from __future__ import annotations

import functools
import hashlib
import os
import threading
import weakref
from typing import Any, Dict, NamedTuple, Optional, Tuple

import numpy as np
from numpy.typing import ArrayLike

from ._faces import closest_on_faces, cross
from ._lattice import Placement
from ._meshes_of import OwnScene
from ._types import Array
from .client import Client
from .scene import Scene

Kept = Tuple["weakref.ref[Any]", Optional[Client], "Current"]
_kept: "Dict[Tuple[int, int, int], Kept]" = {}  # by mesh, client and process


class Cloud(NamedTuple):
    """The vertices that faces have, each as a face of its own."""

    own: OwnScene
    numbers: Array  # (f) int64: the vertices of its faces
    is_moved: bool       # whether rounding has moved one


class Surface:
    """A mesh as it was when this was made, in a scene of its own. The server keeps its vertices as float32 about a
    point near them."""

    def __init__(self, mesh: Any, client: Optional[Client]):
        self._client = client
        self.vertices, self.faces = np.asarray(mesh.vertices), np.asarray(mesh.faces)
        self.own = OwnScene(client)
        self._placement = self.own.add_placed(self.vertices, self.faces)[1] if len(self.faces) else None

    @property
    def scene(self) -> Scene:
        return self.own.scene

    @functools.cached_property
    def shift(self) -> float:
        """How far rounding has moved a vertex, at most."""
        shifts = _shifts(self.vertices, self._placement)
        return float(shifts.max(initial=0.0, where=np.isfinite(shifts)))

    @functools.cached_property
    def _moved(self) -> Array:
        """bool (f): whether rounding has moved a vertex of the face."""
        is_moved = np.append(_shifts(self.vertices, self._placement) != 0, False)
        of_faces: Array = is_moved[np.minimum(self.faces, len(self.vertices))].any(axis=1)
        return of_faces

    @functools.cached_property
    def cloud(self) -> Cloud:
        """Made at its first use."""
        numbers = np.unique(self.faces).astype("i8")
        numbers = numbers[numbers < len(self.vertices)]
        own, placement = OwnScene(self._client), None
        if len(numbers):
            _, placement = own.add_placed(self.vertices, np.repeat(numbers[:, None], 3, axis=1))
        return Cloud(own, numbers, bool(_shifts(self.vertices, placement)[numbers].any()))

    def corners(self, faces: Array) -> Array:
        """float64 (m, 3, 3), of these faces (m)."""
        corners: Array = self.vertices[self.faces[faces]].astype("f8", copy=False)
        return corners

    def normals(self, faces: Array) -> Array:
        """float64 (m, 3), unit, of these faces (m); 0 for one without area."""
        corners = self.corners(faces)
        normals = cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        length = np.linalg.norm(normals, axis=1, keepdims=True)
        return np.divide(normals, length, out=np.zeros_like(normals), where=length > 0)

    def measured(self, points: Array, faces: Array, positions: Array,
                 distances: Array) -> "Tuple[Array, Array]":
        """The points of faces (m) nearest to points (m, 3), and how far they are: the server's, which are changed here
        where rounding has moved a face."""
        rows = np.flatnonzero(self._moved[faces])
        if len(rows):
            positions[rows], distances[rows] = closest_on_faces(self.corners(faces[rows]), points[rows])
        return positions, distances


class Current:
    """The surface of one mesh as it is now. Threads: any, while the mesh does not change."""

    def __init__(self, client: Optional[Client]):
        self._client = client
        self._lock = threading.Lock()
        self._surface: Optional[Surface] = None
        self._key: Any = None

    def of(self, mesh: Any) -> Surface:
        key = _content(mesh)
        with self._lock:
            if self._surface is None or key != self._key:
                surface = Surface(mesh, self._client)
                if self._surface is not None:
                    self._surface.own.close()
                self._surface, self._key = surface, key
            return self._surface


class OfMesh:
    """Queries on one mesh, as it is at each of them."""

    def __init__(self, mesh: Any, client: Optional[Client] = None):
        if mesh is None:
            raise TypeError("a mesh is needed")
        self.mesh = mesh
        self._client = client
        self._current = Current(client)

    def __getstate__(self) -> Any:
        return {"mesh": self.mesh}

    def __setstate__(self, state: Any) -> None:
        self.__init__(state["mesh"])  # type: ignore[misc]

    def __deepcopy__(self, *_: Any) -> Any:
        return self.__copy__()

    def __copy__(self) -> Any:
        return type(self)(self.mesh, client=self._client)

    def _surface(self) -> Surface:
        return self._current.of(self.mesh)


def _shifts(vertices: Array, placement: Optional[Placement]) -> Array:
    """(v): how far rounding moves each vertex of a mesh that is kept so."""
    exact = np.asarray(vertices, "f8").reshape(-1, 3)
    with np.errstate(over="ignore", invalid="ignore"):
        kept = exact.astype("f4").astype("f8") if placement is None else placement.residuals(exact) + placement.origin
        return np.asarray(np.linalg.norm(kept - exact, axis=1))


def surface_of(mesh: Any, client: Optional[Client] = None) -> Surface:
    """The surface of a mesh as it is now, kept for as long as the mesh is there, if one can tell that."""
    try:
        reference = weakref.ref(mesh, lambda _: _kept.pop(key, None))
    except TypeError:
        return Surface(mesh, client)
    key = (id(mesh), id(client), os.getpid())
    found = _kept.get(key)
    if found is None or found[0]() is not mesh:
        found = _kept[key] = (reference, client, Current(client))
    return found[2].of(mesh)


def points_of(points: ArrayLike) -> Array:
    """ValueError: not (n, 3)."""
    array = np.asarray(points)
    if array.ndim != 2 or array.shape[1] != 3:
        raise ValueError(f"points have the shape (n, 3), not {array.shape}")
    return array


def side_rays(mesh: Any) -> int:
    """Of how many rays the majority tells the inside of a mesh: three where it is not known to be closed."""
    return 1 if getattr(mesh, "is_watertight", False) else 3


def _content(mesh: Any) -> Any:
    """What changes with the mesh. Meshes of trimesh have a hash of their content, which they keep up to date."""
    if type(mesh).__module__.partition(".")[0] == "trimesh":
        return hash(mesh)
    digest = hashlib.blake2b()
    for array in (mesh.vertices, mesh.faces):
        array = np.ascontiguousarray(array)
        digest.update(repr((array.shape, array.dtype.str)).encode())
        digest.update(array.tobytes())
    return digest.digest()
