"""What the server says of a scene."""

from __future__ import annotations

import dataclasses
from typing import Any, Optional

import numpy as np

from ._types import Doubles


@dataclasses.dataclass(frozen=True, eq=False)
class SceneInfo:
    """What the server says of a scene. bounds: float64 (2, 3), least and greatest; None without triangles. `read` is
    false where a listed scene is on disk only, and its counts are not known."""

    name: str
    revision: int
    token: str
    up_axis: Optional[str]
    meters_per_unit: float
    nodes: int
    instances: int
    meshes: int
    triangles_unique: int
    triangles_instanced: int
    triangles_nonfinite: int
    bytes_geometry: int
    bounds: Optional[Doubles]
    read: bool

    @classmethod
    def of(cls, scene: Any) -> "SceneInfo":
        """The SceneInfo of a message Scene."""
        counts = {name: getattr(scene, name) for name in (
            "nodes", "instances", "meshes", "triangles_unique", "triangles_instanced", "triangles_nonfinite",
            "bytes_geometry", "meters_per_unit")}
        bounds = np.array(scene.bounds).reshape(2, 3) if scene.bounds else None
        return cls(name=scene.name, revision=scene.head.revision, token=scene.head.token,
                   up_axis=(None, "y", "z")[scene.up_axis], bounds=bounds, read=not scene.unread, **counts)
