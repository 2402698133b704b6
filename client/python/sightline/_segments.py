"""The segments of a client, and whether it has any."""

from __future__ import annotations

import sys
import threading
import time
import weakref
from typing import TYPE_CHECKING, List, NamedTuple, Optional, Tuple

import numpy as np

from . import _proto, errors
from ._endpoint import Endpoint
from ._segment import Segment, open_segment, unshared
from .shared_memory import Transport

if TYPE_CHECKING:
    from ._connection import Connection

SEGMENT_BYTES = 32 << 20
MOST_SEGMENTS = 4
_FIRST_PAUSE, _LONGEST_PAUSE = 1.0, 60.0  # seconds from a failure until the server is asked again
_LONGEST_WAIT = 5.0  # seconds, for an answer to a call without work


class Limits(NamedTuple):
    """What a server says about casts and segments."""

    segment_bytes: int
    rows: int  # of a request by a segment


def refusal_of(endpoint: Endpoint, use_segments: bool) -> str:
    """What speaks against segments; empty: nothing."""
    if not use_segments:
        return "use_segments is off"
    if endpoint.is_balanced():
        return "the endpoint has, or may have, several servers"
    if not endpoint.is_local():
        return "the endpoint is not on this machine"
    return "" if sys.platform == "linux" else "only Linux has the memory that is shared"


class SegmentPool:
    """Opens segments when casts need them. A thread that would wait for another one, or for room, gets none instead.
    After a failure the server is asked again a second later, and later each time. Threads: any."""

    def __init__(self, connection: "Connection", refusal: str):
        self._connection = weakref.proxy(connection)
        self._refusal = refusal
        self._asking = threading.Lock()  # of the thread that waits for the server
        self._lock = threading.Lock()    # for all below
        self._limits: Optional[Limits] = None
        self._pool: "List[Segment]" = []
        self._users: "weakref.WeakSet[Segment]" = weakref.WeakSet()
        self._failure = ""
        self._pause, self._ask_again = _FIRST_PAUSE, 0.0

    def limits(self, timeout: Optional[float]) -> Optional[Limits]:
        """None: casts go by messages. The first call asks the server."""
        if self._refusal or self._limits is not None:
            return self._limits
        if not self._asking.acquire(blocking=False):
            return None
        try:
            if self._limits is None and time.monotonic() >= self._ask_again:
                self._limits = self._ask(timeout)
        except errors.Cancelled:
            raise
        except errors.SightlineError as error:
            self._note(error)
        finally:
            self._asking.release()
        return self._limits

    def _ask(self, timeout: Optional[float]) -> Limits:
        info = self._connection.call("GetServerInfo", _proto.GetServerInfoRequest(), _bounded(timeout))
        if not info.max_segment_bytes or not info.max_rays_per_shared_request:
            raise errors.FailedPrecondition("the server offers no segments to this client", "SEGMENTS_NOT_OFFERED")
        return Limits(info.max_segment_bytes, info.max_rays_per_shared_request)

    def _note(self, error: errors.SightlineError) -> None:
        with self._lock:
            self._failure, self._limits = error.message or error.code.name, None
            self._ask_again = time.monotonic() + self._pause
            self._pause = min(2 * self._pause, _LONGEST_PAUSE)

    def take(self, size: int, timeout: Optional[float]) -> "Optional[Tuple[Segment, int]]":
        """A segment and the offset of a block in it. None: there is no room."""
        found = self._take_from_open(size)
        if found is not None or not self._asking.acquire(blocking=False):
            return found
        try:
            limits = self._limits
            if limits is None or time.monotonic() < self._ask_again:
                return None
            whole = min(SEGMENT_BYTES, limits.segment_bytes)
            if size > whole or len(self._pool) >= MOST_SEGMENTS:
                return None
            segment = self._open(whole, timeout)
            with self._lock:
                self._pool.append(segment)
                self._failure, self._pause = "", _FIRST_PAUSE
        except errors.Cancelled:
            raise
        except errors.SightlineError as error:
            self._note(error)
            return None
        finally:
            self._asking.release()
        return self._take_from_open(size)

    def _take_from_open(self, size: int) -> "Optional[Tuple[Segment, int]]":
        with self._lock:
            self._pool = [segment for segment in self._pool if segment.is_shared]
            for segment in self._pool:
                offset = segment.take(size)
                if offset is not None:
                    return segment, offset
        return None

    def _open(self, size: int, timeout: Optional[float]) -> Segment:
        return open_segment(self._connection.begin("OpenSegment", _proto.OpenSegmentRequest(bytes=size)), size,
                            _bounded(timeout))

    def share(self, size: int) -> Segment:
        """Memory for a user: a segment, or else memory that is not shared, with the reason. Errors: ResourceExhausted."""
        if self._refusal:
            return unshared(size, self._refusal)
        with self._asking:
            try:
                limits = self._limits or self._ask(None)
                if size > limits.segment_bytes:
                    return unshared(size, f"{size} bytes are more than the {limits.segment_bytes} of the largest segment "
                                          "of the server")
                segment = self._open(size, None)
            except errors.Cancelled:
                raise
            except errors.SightlineError as error:
                return unshared(size, error.message)
        with self._lock:
            self._limits = limits
            self._users.add(segment)
        return segment

    def find(self, column: np.ndarray) -> Optional[Segment]:
        """The user's segment that has this array."""
        with self._lock:
            users = list(self._users)
        return next((segment for segment in users if segment.offset_of(column) is not None), None)

    def lose(self, segment: Segment) -> None:
        """The server does not know the segment any more."""
        segment.lose()
        with self._lock:
            self._limits, self._pause, self._ask_again = None, _FIRST_PAUSE, 0.0

    def transport(self) -> Transport:
        if self._refusal:
            return Transport("messages", self._refusal)
        with self._lock:
            if any(segment.is_shared for segment in [*self._pool, *self._users]):
                return Transport("segments", "client and server share memory")
            return Transport("messages", self._failure or "no cast has needed shared memory")


def _bounded(timeout: Optional[float]) -> float:
    return _LONGEST_WAIT if timeout is None else min(timeout, _LONGEST_WAIT)
