"""A scene that was restored from a backup."""

from __future__ import annotations

from typing import NamedTuple


class RestoredScene(NamedTuple):
    """A scene that was restored. token: the revision's; older tokens of a scene of this name are not valid any more."""

    name: str
    revision: int
    token: str
