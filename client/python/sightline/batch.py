"""Several changes of nodes as one revision."""

from __future__ import annotations

import dataclasses
import uuid
from typing import TYPE_CHECKING, Any, Iterable, List, Optional, Tuple

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

    @classmethod
    def of(cls, answer: Any) -> "Applied":
        """The value of a message ApplyUpdatesResponse."""
        committed = answer.durability == _proto.enum_value("DURABILITY_COMMITTED")
        return cls(answer.revision.revision, answer.revision.token, tuple(answer.nodes), committed)


def request_of(scene: str, changes: "Iterable[Any]", expected_revision: Optional[int] = None,
               request_id: Optional[str] = None) -> Any:
    """A message of messages Update, which the server applies once, even if it is sent several times."""
    request = _proto.ApplyUpdatesRequest(scene=scene, updates=changes, request_id=request_id or uuid.uuid4().hex)
    if expected_revision is not None:
        request.expected_revision = expected_revision
    return request


def apply(connection: Connection, scene: str, changes: "List[Any]") -> Applied:
    """Applies messages Update, all or none."""
    return Applied.of(connection.call("ApplyUpdates", request_of(scene, changes)))


class Batch:
    """See Scene.batch."""

    def __init__(self, scene: "Scene", expected_revision: Optional[int]):
        self._scene = scene
        self._expected_revision = expected_revision
        self._changes: "List[Any]" = []
        self._nodes: "List[Node]" = []
        self._id = uuid.uuid4().hex  # of the request, until it is known to be applied
        self.applied: Optional[Applied] = None  #: of what was applied last: at the end of the `with` block, or by a cast

    def __enter__(self) -> "Batch":
        if self._scene._batch is not None:
            raise RuntimeError("the scene has an open batch")
        self._scene._batch = self
        return self

    def __exit__(self, kind: Any, *_: Any) -> None:
        self._scene._batch = None
        if kind is None and self._changes:
            self.end_request(Applied.of(self._scene._connection.call("ApplyUpdates", self.request())))

    @property
    def scene_name(self) -> str:
        """The scene whose changes it collects."""
        return self._scene.name

    def request(self) -> Any:
        """The changes as a message."""
        return request_of(self._scene.name, self._changes, self._expected_revision, self._id)

    def end_request(self, applied: Applied) -> None:
        """The changes were applied: those that follow are another request."""
        self.applied = applied
        for node, number in zip(self._nodes, applied.nodes):
            node.number = number
        self._changes, self._nodes, self._id = [], [], uuid.uuid4().hex
        if self._expected_revision is not None:
            self._expected_revision = applied.revision

    def next_alias(self) -> int:
        """The number of the next new node."""
        return -len(self._nodes) - 1

    def add(self, changes: "List[Any]", made: "List[Node]") -> None:
        """Collects changes; `made` are the new nodes that they put."""
        self._changes += changes
        self._nodes += made
