"""Nodes of a scene."""

from __future__ import annotations

from typing import Any, Iterable, List, Mapping, Optional, Protocol

import numpy as np

from . import updates
from ._lattice import Placement
from ._types import Doubles


class Changeable(Protocol):
    """What a node needs of its scene."""

    name: str

    def add(self, mesh: Any = None, *, name: str = "", parent: Any = 0, transform: Any = None,
            origin: Any = (0.0, 0.0, 0.0), mobility: Optional[str] = None, mask: Optional[int] = None,
            labels: "Optional[Mapping[str, str]]" = None) -> "Node": ...

    def set_transforms(self, nodes: "Iterable[Any]", transforms: Any) -> None: ...

    def patch_vertices(self, nodes: "Iterable[Any]", vertices: Any, first: int = 0) -> None: ...

    def delete_node(self, node: Any, subtree: bool = False) -> None: ...


class Node:
    """A node that was put by this program. Stands for its id where one is needed.

    Within `with scene.batch():` a new node has no id yet, but may be used as parent.
    """

    def __init__(self, scene: Changeable, number: int):
        self.scene = scene
        self.number = number  #: the id, or a negative alias within a batch
        self._placed: Optional[Node] = None  # below this one, with its mesh
        self._placement: Optional[Placement] = None

    @property
    def id(self) -> int:
        """Its id in the scene. RuntimeError: its batch is not applied, or has failed."""
        if self.number < 0:
            raise RuntimeError("the node has no id before its batch is applied")
        return self.number

    @property
    def mesh_node(self) -> "Node":
        """The node that has its mesh, and that hits name: this one; or, of a mesh that is kept about an `origin`,
        one of the same name below it, which holds the mesh there however this one moves."""
        return self._placed or self

    @property
    def origin(self) -> Doubles:
        """float64 (3): the point that its mesh is kept about; 0 unless it was added with `origin` and lies far out."""
        return np.zeros(3) if self._placement is None else self._placement.origin.copy()

    def __index__(self) -> int:
        return self.number

    def __repr__(self) -> str:
        return f"<node {self.number} of {self.scene.name}>"

    def add(self, mesh: Any = None, *, name: str = "", transform: Any = None, origin: Any = (0.0, 0.0, 0.0),
            mobility: Optional[str] = None, mask: Optional[int] = None,
            labels: "Optional[Mapping[str, str]]" = None) -> "Node":
        """A node under this one; the options of Scene.add."""
        return self.scene.add(mesh, name=name, parent=self, transform=transform, origin=origin, mobility=mobility,
                              mask=mask, labels=labels)

    def set_transform(self, transform: Any) -> None:
        """Moves it: (3, 4) or (4, 4), parent from local, where local is what the mesh's vertices were given in."""
        self.scene.set_transforms([self], updates.as_matrix(transform)[None])

    def patch(self, vertices: Any, first: int = 0) -> None:
        """Moves vertices of its mesh, (n, 3) from number `first` on; other nodes with this mesh keep it."""
        self.scene.patch_vertices([self], vertices, first)

    def delete(self, subtree: bool = False) -> None:
        """Errors: FailedPrecondition, it has children and `subtree` is not set."""
        self.scene.delete_node(self, subtree)

    def placed(self, number: int, placement: Placement) -> "Node":
        """Makes it a group that holds its mesh by a node of this number, which is returned."""
        self._placed, self._placement = Node(self.scene, number), placement
        return self._placed


def translation(offset: Any) -> Doubles:
    """A transform (3, 4)."""
    matrix = np.eye(3, 4)
    matrix[:, 3] = offset
    return matrix


def patches(nodes: "Iterable[Any]", first: int, vertices: Any) -> "List[updates.PatchVertices]":
    """Changes that move vertices of the one mesh of nodes. They are in what the mesh's vertices were given in if the
    nodes are Node objects; of ids, in the mesh's own frame. ValueError: their meshes are kept about several points."""
    given = list(nodes)
    placements = {node._placement if isinstance(node, Node) else None for node in given}
    origins = {None if placement is None else tuple(placement.origin) for placement in placements}
    if len(origins) > 1:
        raise ValueError("the nodes' meshes are kept about different points: patch them one by one")
    placement = placements.pop() if placements else None
    points = vertices if placement is None else placement.residuals(vertices)
    return updates.patch_vertices([node.mesh_node if isinstance(node, Node) else node for node in given], first, points)
