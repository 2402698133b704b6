"""What a batch of changes came to."""

from __future__ import annotations

import dataclasses
from typing import Any, Tuple

from . import _proto


@dataclasses.dataclass(frozen=True)
class Applied:
    """What a batch came to. nodes: the ids of the nodes that were put, in order. committed: it is on disk. replayed: an
    earlier attempt of the same call had applied it."""

    revision: int
    token: str
    nodes: Tuple[int, ...]
    committed: bool
    replayed: bool = False

    @classmethod
    def of(cls, answer: Any) -> "Applied":
        """The value of a message ApplyUpdatesResponse."""
        committed = answer.durability == _proto.enum_value("DURABILITY_COMMITTED")
        return cls(answer.revision.revision, answer.revision.token, tuple(answer.nodes), committed, answer.replayed)
