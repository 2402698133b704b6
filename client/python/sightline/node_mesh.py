"""The mesh of a node."""

from __future__ import annotations

import struct
from typing import NamedTuple

import numpy as np

from . import errors
from ._types import Floats, UInt32s

_HEADER = struct.Struct("<4sIQQ")  # the magic number, the twin, and how many vertices and faces there are


class NodeMesh(NamedTuple):
    """The mesh of a node, in the mesh's own frame, as one revision has it. vertices: float32 (v, 3); faces: uint32 (f,
    3), by primitive: one of 2**32 - 1 alone is no triangle."""

    vertices: Floats
    faces: UInt32s
    revision: int

    @classmethod
    def of_blob(cls, blob: bytes, revision: int) -> "NodeMesh":
        """The mesh that these bytes are. Errors: DataLoss, they are none."""
        if len(blob) < _HEADER.size:
            raise errors.DataLoss(f"a mesh has at least {_HEADER.size} bytes, not {len(blob)}")
        magic, _, vertices, faces = _HEADER.unpack_from(blob)
        if magic != b"SLM1" or len(blob) != _HEADER.size + 12 * (vertices + faces):
            raise errors.DataLoss(f"{len(blob)} bytes are no mesh of {vertices} vertices and {faces} faces")
        positions = np.frombuffer(blob, "<f4", 3 * vertices, _HEADER.size).reshape(-1, 3)
        indices = np.frombuffer(blob, "<u4", 3 * faces, _HEADER.size + 12 * vertices).reshape(-1, 3)
        return cls(positions.copy(), indices.copy(), revision)
