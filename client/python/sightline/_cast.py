"""Casts: one message where the rays fit, else a stream of them with a window, resumed at its revision if it breaks.

Points are cast as rays are, by calls and messages of their own (_query.Form).
"""

from __future__ import annotations

import time
from typing import Any, Callable, Iterable, Iterator, List, NamedTuple, Optional, Tuple

from . import _cast_codec as codec
from . import errors
from ._arrays import Rows
from ._connection import Connection
from ._generated import Generated
from ._retries import Retries, sleep
from ._query import Query, milliseconds
from ._segment_columns import SegmentColumns, SharedPiece
from ._window import Window

RAYS_PER_MESSAGE = 16384
MESSAGES_IN_FLIGHT = 4
_ATTEMPTS = 4  # without an answer between them
_FIRST_PAUSE = 0.1  # seconds; doubled after each attempt


class Piece(NamedTuple):
    """Rays of one message."""

    rays: Rows
    begin: int
    end: int


def cast_once(connection: Connection, query: Query, rays: Rows, timeout: Optional[float]) -> codec.Answer:
    """Casts in one message, which the server's limits allow."""
    parts = codec.request_parts(query.request.SerializeToString(), rays, 0, rays.count)
    return codec.answer(connection.call(query.form.call, b"".join(parts), timeout, light=False,
                                         scene=query.request.scene, route_key=query.route_key))


def pieces(batches: "Iterable[Rows]", size: int, first: int = 0) -> "Iterator[Piece]":
    """The messages of batches, of each from row `first` on."""
    for rays in batches:
        for begin, end in rays.slices(size, first):
            yield Piece(rays, begin, end)


def generated(source: Generated, size: int, begin: int = 0) -> "Iterator[Any]":
    """The requests for the rays of a generator, or the points of a grid, from number `begin` on; each is a message of
    its type."""
    for first in range(begin, source.count, size):
        yield source.part(first, min(size, source.count - first))


def cast_generated_once(connection: Connection, query: Query, source: Generated,
                        timeout: Optional[float]) -> codec.Answer:
    """Casts what the server makes in one message, which its limits allow."""
    request = query.form.request(**{query.form.generator: source.message()}).SerializeToString()
    data = query.request.SerializeToString() + request
    return codec.answer(connection.call(query.form.call, data, timeout, light=False,
                                        scene=query.request.scene, route_key=query.route_key))


class CastStream:
    """Answers to the items of a source, in order, all at one revision.

    Items are Pieces, or messages RayGenerator or PointGrid. They are taken from the source by another thread, a few
    ahead of the answers. With `segment`, items are its pieces, and a broken call is not opened again: the server might
    still write to it.
    """

    def __init__(self, connection: Connection, query: Query, source: "Iterator[Any]", timeout: Optional[float],
                 segment: Optional[SegmentColumns] = None):
        self._connection = connection
        self._query = query
        self._segment = segment
        self._deadline = None
        seconds = connection.timeout if timeout is None else timeout
        if seconds is not None:
            self._deadline = time.monotonic() + seconds
        self._window = Window(source, MESSAGES_IN_FLIGHT)
        self._revision: Optional[int] = None
        budget = query.request.time_budget_ms
        self._budget_end = time.monotonic() + budget / 1000 if budget else None

    def answers(self) -> "Iterator[Tuple[Any, List[codec.Answer]]]":
        """Each item with its answers: one, or several for kind "all". Leaving it cancels the call."""
        failures, retries = 0, Retries(self._deadline)
        try:
            while not self._window.is_done():
                try:
                    for found in self._attempt():
                        failures = 0
                        retries.progressed()
                        yield found
                    if self._window.error is not None:
                        raise self._window.error
                    if not self._window.is_done():
                        raise errors.Unavailable("the server ended the call")
                except errors.Unavailable:
                    if self._segment is not None:
                        raise
                    failures += 1
                    pause = _FIRST_PAUSE * 2 ** failures
                    if failures == _ATTEMPTS or (self._deadline and time.monotonic() + pause > self._deadline):
                        raise
                    sleep(pause)
                except errors.ResourceExhausted as error:
                    if not retries.wait(error):
                        raise
            if self._window.error is not None:
                raise self._window.error
        finally:
            self._window.close()

    def _attempt(self) -> "Iterator[Tuple[Any, List[codec.Answer]]]":
        timeout = None if self._deadline is None else max(0.0, self._deadline - time.monotonic())
        expected, parts = 0, []
        with self._connection.stream(self._query.form.stream, self._window.attempt(self._encoder()), timeout,
                                     self._query.request.scene, self._query.route_key) as stream:
            for data in stream:
                chunk, answer = codec.stream_answer(data)
                item = self._window.oldest()
                if item is None or chunk != expected:
                    raise errors.Internal(f"the server answered message {chunk} instead of {expected}")
                self._revision = answer.revision
                parts.append(answer)
                if isinstance(item, SharedPiece):
                    item.columns.put(item, answer)
                if not answer.more:
                    self._window.answered()
                    yield item, parts
                    expected, parts = expected + 1, []

    def _rest_of_budget(self) -> bytes:
        if self._budget_end is None:
            return b""
        rest = milliseconds(self._budget_end - time.monotonic())
        return bytes(self._query.form.request(time_budget_ms=rest).SerializeToString())

    def _encoder(self) -> "Callable[[int, Any], bytes]":
        form = self._query.form
        request = self._query.request if self._segment is None else self._segment.description()
        if self._revision is not None:
            request.consistency.exact_revision = self._revision
        description = request.SerializeToString()

        def encode(chunk: int, item: Any) -> bytes:
            head = self._rest_of_budget() if chunk else description
            if isinstance(item, SharedPiece):
                return codec.stream_request(chunk, [head, item.columns.request(item)])
            if isinstance(item, Piece):
                return codec.stream_request(chunk, codec.request_parts(head, *item))
            generator = form.request(**{form.generator: item}).SerializeToString()
            return codec.stream_request(chunk, [head, generator])

        return encode
