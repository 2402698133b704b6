"""Following what happens to a scene."""

from __future__ import annotations

from typing import Iterator, List, Optional

from . import _proto, errors, updates
from ._connection import Connection
from ._retries import Retries, sleep
from .change import Change

_ATTEMPTS = 6  # without a message between them
_FIRST_PAUSE = 0.1  # seconds; doubled after each attempt


def watch(connection: Connection, scene: str, start: Optional[int]) -> "Iterator[Change]":
    """See Scene.watch."""
    failures, reached, retries = 0, start, Retries()
    while True:
        request = _proto.WatchSceneRequest(scene=scene)
        if reached is not None:
            request.start_revision = reached
        try:
            with connection.stream("WatchScene", request) as stream:
                parts: "List[updates.Update]" = []
                for message in stream:
                    failures = 0
                    retries.progressed()
                    parts += map(updates.decode, message.updates)
                    if message.more:
                        continue
                    reached = message.revision.revision
                    if not message.progress:
                        yield Change(message.revision.revision, message.revision.token, parts)
                    parts = []
                raise errors.Unavailable("the server ended the watch")
        except errors.Unavailable:
            failures += 1
            if failures == _ATTEMPTS:
                raise
            sleep(_FIRST_PAUSE * 2 ** failures)
        except errors.ResourceExhausted as error:
            if not retries.wait(error):
                raise
