"""Updates over one call."""

from __future__ import annotations

from typing import Any, Callable

from .. import update_stream
from ._threads import Threads, awaited


class UpdateStream:
    """sightline.UpdateStream, for `async with`."""

    def __init__(self, opening: "Callable[[], update_stream.UpdateStream]", threads: Threads):
        self._opening = opening
        self._threads = threads

    async def __aenter__(self) -> "UpdateStream":
        self._original = await self._threads.run(self._opening)
        return self

    async def __aexit__(self, *raised: Any) -> None:
        await self._threads.run(self._original.__exit__, *raised)

    @property
    def revision(self) -> int:
        """The one that holds all answered batches."""
        return self._original.revision

    @property
    def token(self) -> str:
        """That revision's."""
        return self._original.token

    send = awaited(update_stream.UpdateStream.send)
    set_transforms = awaited(update_stream.UpdateStream.set_transforms)
    patch_vertices = awaited(update_stream.UpdateStream.patch_vertices)
    flush = awaited(update_stream.UpdateStream.flush)
    close = awaited(update_stream.UpdateStream.close)
