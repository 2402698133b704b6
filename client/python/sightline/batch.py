"""Several changes of nodes as one revision."""

from __future__ import annotations

import dataclasses
import uuid
from typing import TYPE_CHECKING, Any, List, Optional, Tuple

from . import _proto
from ._connection import Connection

if TYPE_CHECKING:
    from .nodes import Node
    from .scene import Scene


@dataclasses.dataclass(frozen=True)
class Applied:
    """What a batch came to. nodes: the ids of the nodes that were put, in order. committed: it is on disk."""

    revision: int
    token: str
    nodes: Tuple[int, ...]
    committed: bool


def apply(connection: Connection, scene: str, changes: "List[Any]",
          expected_revision: Optional[int] = None) -> Applied:
    """Applies messages Update, all or none, once, even if the request has to be sent several times."""
    request = _proto.ApplyUpdatesRequest(scene=scene, updates=changes, request_id=uuid.uuid4().hex)
    if expected_revision is not None:
        request.expected_revision = expected_revision
    answer = connection.call("ApplyUpdates", request)
    committed = answer.durability == _proto.enum_value("DURABILITY_COMMITTED")
    return Applied(answer.revision.revision, answer.revision.token, tuple(answer.nodes), committed)


class Batch:
    """See Scene.batch."""

    def __init__(self, scene: "Scene", expected_revision: Optional[int]):
        self._scene = scene
        self._expected_revision = expected_revision
        self._changes: "List[Any]" = []
        self._nodes: "List[Node]" = []
        self.applied: Optional[Applied] = None  #: once the `with` block has ended well and changed something

    def __enter__(self) -> "Batch":
        if self._scene._batch is not None:
            raise RuntimeError("the scene has an open batch")
        self._scene._batch = self
        return self

    def __exit__(self, kind: Any, *_: Any) -> None:
        self._scene._batch = None
        if kind is None and self._changes:
            self.applied = apply(self._scene._connection, self._scene.name, self._changes, self._expected_revision)
            for node, number in zip(self._nodes, self.applied.nodes):
                node.number = number

    def next_alias(self) -> int:
        """The number of the next new node."""
        return -len(self._nodes) - 1

    def add(self, changes: "List[Any]", made: "List[Node]") -> None:
        """Collects changes; `made` are the new nodes that they put."""
        self._changes += changes
        self._nodes += made
