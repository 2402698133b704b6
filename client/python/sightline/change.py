"""What happened to a scene."""

from __future__ import annotations

import dataclasses
from typing import List

from .updates import Update


@dataclasses.dataclass(frozen=True)
class Change:
    """A revision and what made it: PutNode, SetTransforms, DeleteNode, PatchVertices, in order."""

    revision: int
    token: str
    updates: List[Update]
