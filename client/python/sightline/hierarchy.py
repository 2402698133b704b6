"""Trees of nodes from scenes of trimesh: a graph of transforms, and meshes by name."""

from __future__ import annotations

import contextlib
from typing import Any, ContextManager, Dict, List, Mapping, Optional, Protocol, Tuple

from ._lattice import Placement
from .batch import Batch
from .nodes import Node, translation


class Growing(Protocol):
    """What a hierarchy needs of the scene that it is put into."""

    _batch: Optional[Batch]

    def batch(self, expected_revision: Optional[int] = None) -> Batch: ...

    def put(self, digest: str, *, name: str = "", parent: Any = 0, transform: Any = None, origin: Any = (0.0, 0.0, 0.0),
            mobility: Optional[str] = None, mask: Optional[int] = None,
            labels: "Optional[Mapping[str, str]]" = None) -> Node: ...

    def _upload(self, mesh: Any) -> "Tuple[str, Optional[Placement]]": ...


def is_hierarchy(source: Any) -> bool:
    """Whether it is a scene of trimesh, or has the same two parts."""
    return hasattr(source, "graph") and hasattr(source, "geometry")


def add_hierarchy(scene: Growing, source: Any, *, mobility: Any, mask: Any, **root: Any) -> Node:
    """Puts the nodes of `source` under a new node, and returns that. Geometry without faces is left out."""
    meshes = {name: scene._upload(mesh) for name, mesh in source.geometry.items() if len(getattr(mesh, "faces", ()))}
    children: "Dict[str, List[Tuple[str, Any]]]" = {}
    for parent, child, edge in source.graph.to_edgelist():
        children.setdefault(parent, []).append((child, edge))
    batch: "ContextManager[Any]" = contextlib.nullcontext()
    if scene._batch is None:
        batch = scene.batch()
    with batch:
        top = scene.put("", mobility=mobility, mask=mask, **root)
        waiting = [(source.graph.base_frame, top)]
        while waiting:
            name, node = waiting.pop()
            for child, edge in children.get(name, ()):
                digest, placement = meshes.get(edge.get("geometry"), ("", None))
                # A node's mesh hangs under it, so that its origin does not move the node's children.
                below = scene.put("", name=child, parent=node, transform=edge.get("matrix"), mobility=mobility, mask=mask)
                if digest:
                    scene.put(digest, name=str(edge["geometry"]), parent=below, mobility=mobility, mask=mask,
                              transform=None if placement is None else translation(placement.origin))
                waiting.append((child, below))
    return top
