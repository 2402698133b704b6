"""Repeating what a server refuses for now, and says when to repeat."""

from __future__ import annotations

import random
import time
from typing import Optional

from . import errors
from ._scope import scope

_LONGEST = 60.0       # seconds of waiting, without progress between
_LONGEST_PAUSE = 8.0  # seconds
_FIRST_DOUBLED = 3    # refusals in a row from which on pauses grow


class Retries:
    """The retries of one call. `deadline`: a time.monotonic() that no pause passes; None: none."""

    def __init__(self, deadline: Optional[float] = None):
        self._deadline = deadline
        self.progressed()

    def progressed(self) -> None:
        """The call made progress: later refusals count anew."""
        self._refused = 0
        self._waited = 0.0

    def pause(self, error: errors.SightlineError) -> Optional[float]:
        """Seconds to wait before the call is repeated. None: the error is none that passes, or there is no time left.
        Callers that were refused together come back one after the other."""
        if not isinstance(error, errors.ResourceExhausted) or error.retry_delay is None:
            return None
        self._refused += 1
        longest = error.retry_delay * 2.0 ** max(0, self._refused - _FIRST_DOUBLED)
        pause = max(error.retry_delay, min(longest, _LONGEST_PAUSE)) * random.uniform(1.0, 1.5)
        late = self._deadline is not None and time.monotonic() + pause > self._deadline
        if late or self._waited + pause > _LONGEST:
            return None
        self._waited += pause
        return pause

    def wait(self, error: errors.SightlineError) -> bool:
        """Sleeps for the pause, if there is one. Errors: Cancelled, of a task."""
        pause = self.pause(error)
        if pause is not None:
            sleep(pause)
        return pause is not None


def sleep(seconds: float) -> None:
    """Sleeps. Errors: Cancelled, as soon as the task of sightline.aio is cancelled that the call belongs to."""
    calls = scope.get()
    if calls is None:
        time.sleep(seconds)
    elif calls.wait(seconds):
        raise errors.Cancelled("the call was cancelled")
