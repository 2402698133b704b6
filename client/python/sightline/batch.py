"""Several changes of nodes as one revision."""

from __future__ import annotations

import uuid
from typing import TYPE_CHECKING, Any, Callable, Iterable, List, Optional

from . import _proto
from ._connection import Connection
from .applied import Applied
from .updates import Update, encode

if TYPE_CHECKING:
    from .nodes import Node


def request_of(scene: str, changes: "Iterable[Update]", expected_revision: Optional[int] = None,
               request_id: Optional[str] = None) -> Any:
    """A message of changes, which the server applies once, even if it is sent several times."""
    request = _proto.ApplyUpdatesRequest(scene=scene, updates=map(encode, changes),
                                         request_id=request_id or uuid.uuid4().hex)
    if expected_revision is not None:
        request.expected_revision = expected_revision
    return request


def apply(connection: Connection, scene: str, changes: "Iterable[Update]",
          expected_revision: Optional[int] = None) -> Applied:
    """Applies changes, all or none."""
    return Applied.of(connection.call("ApplyUpdates", request_of(scene, changes, expected_revision)))


class Batch:
    """See Scene.batch. `hold` keeps it as the scene's open batch, or ends that."""

    def __init__(self, connection: Connection, scene: str, expected_revision: Optional[int],
                 hold: "Callable[[Optional[Batch]], None]"):
        self._connection, self._hold = connection, hold
        self._expected_revision = expected_revision
        self._changes: "List[Update]" = []
        self._nodes: "List[Node]" = []
        self._id = uuid.uuid4().hex  # of the request, until it is known to be applied
        self.scene_name = scene      #: the scene whose changes it collects
        self.applied: Optional[Applied] = None  #: of what was applied last: at the end of the `with` block, or by a cast

    def __enter__(self) -> "Batch":
        self._hold(self)
        return self

    def __exit__(self, kind: Any, *_: Any) -> None:
        self._hold(None)
        if kind is None and self._changes:
            self.end_request(Applied.of(self._connection.call("ApplyUpdates", self.request())))

    def request(self) -> Any:
        """The changes as a message."""
        return request_of(self.scene_name, self._changes, self._expected_revision, self._id)

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

    def add(self, changes: "Iterable[Update]", made: "Iterable[Node]" = ()) -> None:
        """Collects changes; `made` are the new nodes that they put."""
        self._changes += changes
        self._nodes += made
