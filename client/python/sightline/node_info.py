"""What the server says of a node."""

from __future__ import annotations

import dataclasses
from typing import Any, Dict

import numpy as np

from . import label
from ._types import Doubles
from .updates import mobility_name


@dataclasses.dataclass(frozen=True, eq=False)
class NodeInfo:
    """A node as one revision has it. Stands for its id where one is needed. id 0: there is no such node; parent 0: a
    root. transform: float64 (3, 4), parent from local. mesh_digest: that of the mesh that it was put with, "" for a
    group; patched: its vertices have changed since. labels: values by keys."""

    id: int
    parent: int
    name: str
    transform: Doubles
    mesh_digest: str
    mobility: str
    mask: int
    patched: bool
    labels: Dict[str, str] = dataclasses.field(default_factory=dict)

    def __index__(self) -> int:
        return self.id

    @classmethod
    def of(cls, node: Any) -> "NodeInfo":
        """The value of a message Node."""
        matrix = np.array(node.transform.matrix or np.eye(3, 4).reshape(12)).reshape(3, 4)
        return cls(node.id, node.parent, node.name, matrix, node.mesh_digest, mobility_name(node.mobility), node.mask,
                   node.patched, label.decode(node.labels))
