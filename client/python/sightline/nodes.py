"""Nodes of a scene."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Optional

import numpy as np

from . import updates

if TYPE_CHECKING:
    from .scene import Scene


class Node:
    """A node that was put by this program, or that a scene was asked for. Stands for its id where one is needed.

    Within `with scene.batch():` a new node has no id yet, but may be used as parent.
    """

    def __init__(self, scene: "Scene", number: int, origin: Any = (0.0, 0.0, 0.0)):
        self.scene = scene
        self.number = number  #: the id, or a negative alias within a batch
        self._origin = np.asarray(origin, "f8")

    @property
    def id(self) -> int:
        """Its id in the scene. RuntimeError: its batch is not applied, or has failed."""
        if self.number < 0:
            raise RuntimeError("the node has no id before its batch is applied")
        return self.number

    def __index__(self) -> int:
        return self.number

    def __repr__(self) -> str:
        return f"<node {self.number} of {self.scene.name}>"

    def add(self, mesh: Any = None, **options: Any) -> "Node":
        """A node under this one; the options of Scene.add."""
        return self.scene.add(mesh, parent=self, **options)

    def set_transform(self, transform: Any) -> None:
        """Moves it: (3, 4) or (4, 4), parent from local, where local is what the mesh's vertices were given in."""
        self.scene.set_transforms([self], placed(transform, self._origin)[None])

    def patch(self, vertices: Any, first: int = 0) -> None:
        """Moves vertices of its mesh, (n, 3) from number `first` on; other nodes with this mesh keep it."""
        points = np.asarray(vertices)
        self.scene.patch_vertices([self], points - self._origin if self._origin.any() else points, first)

    def delete(self, subtree: bool = False) -> None:
        """Errors: FailedPrecondition, it has children and `subtree` is not set."""
        self.scene.delete_node(self, subtree)


def placed(transform: Optional[Any], origin: Any) -> np.ndarray:
    """The transform (3, 4) of a mesh from whose vertices `origin` was subtracted."""
    matrix = np.eye(3, 4) if transform is None else updates.as_matrix(transform).copy()
    matrix[:, 3] += matrix[:, :3] @ np.asarray(origin, "f8")
    return matrix
