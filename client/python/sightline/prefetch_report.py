"""How far the building of trees has come."""

from __future__ import annotations

import dataclasses
from typing import Any


@dataclasses.dataclass(frozen=True)
class PrefetchReport:
    """What Scene.prefetch() has built. Numbers only grow. Meshes, triangles and bytes_trees are counted without rays
    and points, rays (points count as rays) with them. revision: the one that trees are built for. cells_expanded: by
    this call; build_us: growing trees, summed over the server's threads."""

    revision: int
    meshes_done: int
    meshes_total: int
    triangles_done: int
    triangles_total: int
    rays_done: int
    rays_total: int
    cells_expanded: int
    bytes_trees: int
    build_us: int
    elapsed_us: int

    @classmethod
    def of(cls, answer: Any) -> "PrefetchReport":
        """The value of a message PrefetchResponse."""
        counts = {field.name: getattr(answer, field.name) for field in dataclasses.fields(cls) if field.name != "revision"}
        return cls(revision=answer.served.revision, **counts)

    def plus(self, later: "PrefetchReport") -> "PrefetchReport":
        """The report of this call and of a later one for other rays."""
        return dataclasses.replace(
            later, rays_done=self.rays_done + later.rays_done, rays_total=self.rays_total + later.rays_total,
            cells_expanded=self.cells_expanded + later.cells_expanded, build_us=self.build_us + later.build_us,
            elapsed_us=self.elapsed_us + later.elapsed_us)
