"""Triangle meshes as arrays, as the bytes that the server stores, and their upload."""

from __future__ import annotations

import hashlib
import struct
from typing import Any, Callable, Iterator, Optional, Tuple

import numpy as np

from . import _proto, errors
from ._connection import Connection
from ._lattice import Lattice, Placement
from ._progress import Amount
from ._retries import Retries, sleep
from ._types import Array, Floats, Progress, UInt32s
from ._warnings import PrecisionWarning, warn

_CHUNK = 1 << 20  # bytes of an upload in one message
_ATTEMPTS = 4
_NO_TRIANGLE = 0xFFFFFFFF  # all three indices of a face that holds no triangle
_LOSS = 1e-4  # share of the mesh's size that rounding vertices to float32 may cost without a warning


class Mesh:
    """vertices: float32 (v, 3), in the mesh's frame; faces: uint32 (f, 3); placement: how that frame lies in the one
    that the vertices were given in, None: it is the same."""

    def __init__(self, vertices: Floats, faces: UInt32s, placement: Optional[Placement] = None):
        self.vertices, self.faces, self.placement = vertices, faces, placement

    def parts(self, copy_number: int = 0) -> "Tuple[memoryview, ...]":
        header = struct.pack("<4sIQQ", b"SLM1", copy_number, len(self.vertices), len(self.faces))
        return (memoryview(header), *(array.data.cast("B") if len(array) else memoryview(b"")
                                      for array in (self.vertices, self.faces)))

    def digest(self, copy_number: int = 0) -> str:
        """Its name on the server."""
        sha, size = hashlib.sha256(), 0
        for part in self.parts(copy_number):
            sha.update(part)
            size += len(part)
        return f"sha256:{sha.hexdigest()}/{size}"


def as_mesh(mesh: Any, lattice: Optional[Lattice] = None) -> Mesh:
    """A mesh of (vertices, faces), or of an object that has both, as trimesh's do. With a lattice it is kept near
    itself, else about zero. Errors: TypeError, ValueError, by what is wrong."""
    if hasattr(mesh, "vertices") and hasattr(mesh, "faces"):
        vertices, faces = mesh.vertices, mesh.faces
    elif isinstance(mesh, tuple) and len(mesh) == 2:
        vertices, faces = mesh
    else:
        raise TypeError(f"a mesh is (vertices, faces) or has both as attributes; {type(mesh).__name__} does not")
    faces = _faces(faces)
    if not len(faces):
        raise ValueError("a mesh without faces has nothing to hit")
    vertices = _vertices(vertices)
    real = faces[(faces != _NO_TRIANGLE).any(axis=1)]
    if len(real) and int(real.max()) >= len(vertices):
        raise ValueError(f"a face has vertex {int(real.max())}, but there are {len(vertices)} vertices")
    placement = None if lattice is None else lattice.place(vertices)
    if placement is None or not placement.origin.any():
        return Mesh(_as_floats(vertices), faces)
    return Mesh(placement.residuals(vertices), faces, placement)


def _vertices(value: Any) -> Array:
    array = np.asarray(value)
    if array.dtype.kind not in "fiu":
        raise TypeError(f"vertices: real numbers are needed, not {array.dtype}")
    if array.ndim != 2 or array.shape[1] != 3:
        raise ValueError(f"vertices have the shape (v, 3), not {array.shape}")
    return array


def _as_floats(array: Array) -> Array:
    with np.errstate(over="ignore", invalid="ignore"):
        rounded = np.ascontiguousarray(array, "<f4")
        if array.dtype.itemsize > 4 and len(array):
            _warn_of_loss(array, rounded)
    return rounded


def _warn_of_loss(exact: Array, rounded: Array) -> None:
    finite = np.isfinite(exact).all(axis=1)
    if not finite.any():
        return
    size = float(np.ptp(exact[finite], axis=0).max())
    loss = float(np.abs(exact[finite] - rounded[finite]).max())
    if loss > _LOSS * size:
        warn(f"vertices are kept as float32, which moves them by up to {loss:g}, far from the origin: pass origin=, "
             "a point near them", PrecisionWarning)


def _faces(value: Any) -> Array:
    array = np.asarray(value)
    if array.size == 0:
        return np.zeros((0, 3), "<u4")
    if array.dtype.kind not in "iu":
        raise TypeError(f"faces: integers are needed, not {array.dtype}")
    if array.ndim != 2 or array.shape[1] != 3:
        raise ValueError(f"faces have the shape (f, 3), not {array.shape}: triangulate the mesh first")
    if array.min() < 0 or array.max() > _NO_TRIANGLE:
        raise ValueError("a face has a vertex index that is negative or too large")
    return np.ascontiguousarray(array, "<u4")


def upload(connection: Connection, mesh: Mesh, timeout: Optional[float] = None, progress: Progress = False) -> str:
    """Sends a mesh that the server does not have, resuming where an attempt stopped. Returns its digest. progress: of
    bytes."""
    digest = mesh.digest()
    missing = connection.call("FindMissingBlobs", _proto.FindMissingBlobsRequest(digests=[digest]), timeout)
    failures, retries = 0, Retries()
    size = sum(map(len, mesh.parts()))
    while missing.digests:
        try:
            status = connection.call("GetUploadStatus", _proto.GetUploadStatusRequest(digest=digest), timeout)
            if not status.complete:
                with Amount(progress, "B") as amount:
                    chunks = _chunks(mesh, digest, status.committed_size, lambda sent: amount.report(sent, size))
                    connection.call("UploadBlob", chunks, timeout, light=False)
            break
        except (errors.Unavailable, errors.Aborted, errors.OutOfRange):
            failures += 1
            if failures == _ATTEMPTS:
                raise
            sleep(0.05 * 2 ** failures)
        except errors.ResourceExhausted as error:
            if not retries.wait(error):
                raise
    return digest


def _chunks(mesh: Mesh, digest: str, offset: int, report: "Callable[[int], None]") -> "Iterator[Any]":
    """The rest of an upload from a byte on."""
    size = sum(map(len, mesh.parts()))
    begin = 0
    for part in mesh.parts():
        for at in range(max(0, offset - begin), len(part), _CHUNK):
            data = bytes(part[at:at + _CHUNK])
            yield _proto.UploadBlobRequest(digest=digest, offset=begin + at, data=data,
                                           finish=begin + at + len(data) == size)
            report(begin + at + len(data))
        begin += len(part)
    if offset == size:
        yield _proto.UploadBlobRequest(digest=digest, offset=size, finish=True)
