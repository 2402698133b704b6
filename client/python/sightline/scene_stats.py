"""How much of a scene's trees is built."""

from __future__ import annotations

import dataclasses
from typing import Any


@dataclasses.dataclass(frozen=True)
class SceneStats:
    """How much of a scene's trees is built, at one revision. triangles_built: distinct triangles in finished leaves;
    triangles_total: those of distinct meshes. bytes_lists and bytes_wide_nodes are the parts of bytes_trees for what is
    not built in the meshes' trees, and for what is."""

    revision: int
    token: str
    instances_total: int
    instances_entered: int
    trees_built: int
    cells_deferred: int
    cells_expanded: int
    triangles_built: int
    triangles_total: int
    bytes_geometry: int
    bytes_trees: int
    static_instances: int
    dynamic_instances: int
    bytes_lists: int
    bytes_wide_nodes: int

    @classmethod
    def of(cls, answer: Any) -> "SceneStats":
        """The value of a message GetSceneStatsResponse."""
        counts = {field.name: getattr(answer, field.name) for field in dataclasses.fields(cls)
                  if field.name not in ("revision", "token")}
        return cls(revision=answer.revision.revision, token=answer.revision.token, **counts)
