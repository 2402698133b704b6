"""A scene in a backup."""

from __future__ import annotations

from typing import NamedTuple


class BackupScene(NamedTuple):
    """A scene in a backup. base, revision: the oldest and the newest revision that it can be restored at."""

    name: str
    base: int
    revision: int
