"""Trees of nodes from scenes of trimesh: a graph of transforms, and meshes by name."""

from __future__ import annotations

import contextlib
from typing import TYPE_CHECKING, Any, Dict, List, Tuple

from .nodes import Node, translation

if TYPE_CHECKING:
    from .scene import Scene


def is_hierarchy(source: Any) -> bool:
    """Whether it is a scene of trimesh, or has the same two parts."""
    return hasattr(source, "graph") and hasattr(source, "geometry")


def add_hierarchy(scene: "Scene", source: Any, *, mobility: Any, mask: Any, **root: Any) -> Node:
    """Puts the nodes of `source` under a new node, and returns that. Geometry without faces is left out."""
    meshes = {name: scene._upload(mesh) for name, mesh in source.geometry.items() if len(getattr(mesh, "faces", ()))}
    children: "Dict[str, List[Tuple[str, Any]]]" = {}
    for parent, child, edge in source.graph.to_edgelist():
        children.setdefault(parent, []).append((child, edge))
    batch: Any = scene.batch() if scene._batch is None else contextlib.nullcontext()
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
