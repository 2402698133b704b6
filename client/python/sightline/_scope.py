"""The calls that one task of sightline.aio has open."""

from __future__ import annotations

import contextvars
import threading
from typing import Any, List, Tuple, Type


class CallScope:
    """Cancelling the task cancels its calls. `warnings`: those of its calls, which the task gives when it goes on."""

    def __init__(self) -> None:
        self._calls: "List[Any]" = []
        self._ended = threading.Event()
        self.warnings: "List[Tuple[str, Type[Warning]]]" = []

    @property
    def cancelled(self) -> bool:
        return self._ended.is_set()

    def add(self, call: Any) -> None:
        self._calls.append(call)
        if self.cancelled:
            call.cancel()

    def cancel(self) -> None:
        self._ended.set()
        for call in list(self._calls):
            call.cancel()

    def wait(self, seconds: float) -> bool:
        """Whether it was cancelled, after so many seconds or as soon as it is."""
        return self._ended.wait(seconds)

    def remove(self, call: Any) -> None:
        self._calls.remove(call)


scope: "contextvars.ContextVar[CallScope | None]" = contextvars.ContextVar("sightline_calls", default=None)
