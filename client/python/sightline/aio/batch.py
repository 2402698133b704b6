"""Several changes of nodes as one revision."""

from __future__ import annotations

from typing import Any, Optional

from .. import batch
from ..applied import Applied
from ._threads import Threads


class Batch:
    """sightline.Batch, for `async with`."""

    def __init__(self, original: batch.Batch, threads: Threads):
        self.original = original  #: the sightline.Batch that it stands for
        self._threads = threads

    @property
    def applied(self) -> Optional[Applied]:
        """What was applied last."""
        return self.original.applied

    async def __aenter__(self) -> "Batch":
        self.original.__enter__()
        return self

    async def __aexit__(self, *raised: Any) -> None:
        await self._threads.run(self.original.__exit__, *raised)
