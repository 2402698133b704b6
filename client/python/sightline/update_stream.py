"""Updates over one call, batch after batch, each applied once, however often the call breaks."""

from __future__ import annotations

import threading
import time
from collections import deque
from typing import Any, Deque, Iterable, Iterator, List, Optional, Tuple

from . import _proto, errors, updates
from ._connection import Connection
from ._retries import Retries
from .nodes import patches

_MESSAGE_BYTES = 1 << 20  # the most in a message of a batch
_ATTEMPTS = 8  # to open the call, without an answer between them
_FIRST_PAUSE = 0.1  # seconds; doubled after each attempt
_LONGEST_PAUSE = 2.0


class UpdateStream:
    """A producer's stream of updates, for scenes that move with every frame.

    Batches are numbered from 1; a stream continues where the last one of its producer in the scene ended, and replaces
    it if it is still open. Each send() is one batch and becomes one revision; with `latest_wins`, waiting batches of
    transforms and vertices may become one. With `relaxed`, a batch is answered before it is on disk. After a broken
    call the stream opens again and sends what was not answered. A rejected batch has no effect; flush() raises its
    error.

    Leaving `with` closes the stream. Threads: any. Errors: NotFound, no such scene; Aborted, another stream took over
    the producer; Unavailable, after some attempts.
    """

    def __init__(self, connection: Connection, scene: str, producer: str, latest_wins: bool, relaxed: bool):
        self._connection = connection
        durability = _proto.enum_value("DURABILITY_RELAXED" if relaxed else "DURABILITY_UNSPECIFIED")
        self._open = _proto.OpenProducer(scene=scene, producer=producer, latest_wins=latest_wins,
                                         durability=durability)
        self._lock = threading.RLock()  # entering a condition by itself could be interrupted half way
        self._changed = threading.Condition(self._lock)
        self._batches: "Deque[Tuple[int, List[Any]]]" = deque()  # not answered yet
        self._attempt = 0          # attempts to open the call
        self._opened = 0           # the attempt that is open
        self._window = 0
        self._answered = 0         # the last sequence number that was
        self._last = 0             # the last one that was given to a batch
        self._is_closing = False
        self._failure: Optional[BaseException] = None
        self._rejected: "Deque[errors.SightlineError]" = deque()
        self.revision, self.token = 0, ""  #: that holds all answered batches
        self._thread = threading.Thread(target=self._run, name="sightline-updates", daemon=True)
        self._thread.start()
        self._wait(lambda: self._opened > 0, None)

    def send(self, changes: "Iterable[updates.Update]") -> int:
        """One batch of changes, of sightline.updates. Waits while the window is full. Returns its number."""
        batch = list(map(updates.encode, changes))
        self._wait(lambda: len(self._batches) < self._window, None)
        with self._lock:
            if self._is_closing:
                raise RuntimeError("the stream is closed")
            self._last += 1
            self._batches.append((self._last, batch))
            self._changed.notify_all()
            return self._last

    def set_transforms(self, nodes: "Iterable[Any]", transforms: Any) -> int:
        """A batch that moves nodes to transforms (n, 3, 4) or (n, 4, 4)."""
        return self.send(updates.set_transforms(nodes, transforms))

    def patch_vertices(self, nodes: "Iterable[Any]", vertices: Any, first: int = 0) -> int:
        """A batch that moves vertices (n, 3), from number `first` on, of the mesh that the nodes have, as
        Scene.patch_vertices does."""
        return self.send(patches(nodes, first, vertices))

    def flush(self, timeout: Optional[float] = None) -> int:
        """Waits until all batches are answered. Returns the revision that holds them. Errors: of the first batch that
        was rejected since the last flush; DeadlineExceeded, in seconds."""
        self._wait(lambda: not self._batches, timeout)
        with self._lock:
            if self._rejected:
                error = self._rejected[0]
                self._rejected.clear()
                raise error
            return self.revision

    def close(self) -> None:
        """Waits until all batches are answered, and ends the call. Errors: as of flush."""
        try:
            if not self._is_closing:
                self.flush()
        finally:
            self._stop()

    def __enter__(self) -> "UpdateStream":
        return self

    def __exit__(self, kind: Any, *_: Any) -> None:
        if kind is None:
            self.close()
        else:
            self._stop()

    def _stop(self) -> None:
        with self._lock:
            self._is_closing = True
            self._changed.notify_all()
        self._thread.join()

    def _wait(self, condition: Any, timeout: Optional[float]) -> None:
        with self._lock:
            done = self._changed.wait_for(lambda: self._failure is not None or condition(), timeout)
            if self._failure is not None:
                raise self._failure
        if not done:
            raise errors.DeadlineExceeded(f"the batches were not answered within {timeout:g} s")

    # ---- the thread that holds the call open

    def _run(self) -> None:
        failures, retries = 0, Retries()
        while True:
            answered = self._answered
            try:
                self._call()
                if self._is_closing:
                    return
                raise errors.Unavailable("the server ended the stream of updates")
            except errors.SightlineError as error:
                if self._answered > answered:
                    failures = 0
                    retries.progressed()
                pause = retries.pause(error)
                if pause is not None:
                    with self._lock:
                        self._changed.wait_for(lambda: self._is_closing, pause)
                    if not self._is_closing:
                        continue
                failures += 1
                if self._is_closing or not self._may_go_on(error, failures):
                    return self._fail(error)
            except BaseException as error:  # it is raised in the threads that use the stream
                return self._fail(error)
            time.sleep(min(_FIRST_PAUSE * 2 ** failures, _LONGEST_PAUSE))

    def _may_go_on(self, error: errors.SightlineError, failures: int) -> bool:
        if error.reason == "STREAM_IDLE":  # its place is needed: come back when there is something to send
            with self._lock:
                self._changed.wait_for(lambda: self._batches or self._is_closing)
            return not self._is_closing
        return isinstance(error, errors.Unavailable) and failures < _ATTEMPTS

    def _call(self) -> None:
        self._attempt += 1
        with self._connection.stream("StreamUpdates", self._messages(self._attempt), scene=self._open.scene) as stream:
            try:
                for message in stream:
                    self._receive(message)
            finally:
                with self._lock:
                    self._attempt += 1
                    self._changed.notify_all()

    def _fail(self, error: BaseException) -> None:
        with self._lock:
            self._failure = error
            self._changed.notify_all()

    def _receive(self, message: Any) -> None:
        kind = message.WhichOneof("message")
        with self._lock:
            if kind == "opened":
                opened = message.opened
                self._window, self._opened = opened.window, self._attempt
                self._last = max(self._last, opened.last_committed)
                self._advance(opened.last_committed, opened.revision)
            elif kind == "ack":
                self._advance(message.ack.up_to_sequence, message.ack.revision)
            else:
                reject = message.reject
                self._rejected.append(errors.of_code(
                    reject.code, f"batch {reject.sequence}: {reject.message}", reject.reason))
                self._advance(reject.sequence, None)
            self._changed.notify_all()

    def _advance(self, sequence: int, revision: Any) -> None:
        self._answered = max(self._answered, sequence)
        while self._batches and self._batches[0][0] <= sequence:
            self._batches.popleft()
        if revision is not None and revision.revision >= self.revision:
            self.revision, self.token = revision.revision, revision.token

    # ---- the thread that gRPC sends from

    def _messages(self, attempt: int) -> "Iterator[Any]":
        yield _proto.StreamUpdatesRequest(open=self._open)
        sent = 0
        while True:
            with self._lock:
                self._changed.wait_for(lambda: attempt != self._attempt or self._may_send(attempt, sent))
                if attempt != self._attempt:
                    return
                batch = self._after(sent)
                if batch is None:
                    return  # closing
            sent = batch[0]
            yield from _split(*batch)

    def _may_send(self, attempt: int, sent: int) -> bool:
        return self._opened == attempt and (self._is_closing or self._after(sent) is not None)

    def _after(self, sequence: int) -> "Optional[Tuple[int, List[Any]]]":
        return next((batch for batch in self._batches if batch[0] > sequence), None)


def _split(sequence: int, changes: "List[Any]") -> "Iterator[Any]":
    """The messages of a batch."""
    part: "List[Any]" = []
    size = 0
    for change in changes:
        bytes_of = change.ByteSize()
        if part and size + bytes_of > _MESSAGE_BYTES:
            yield _message(sequence, part, True)
            part, size = [], 0
        part.append(change)
        size += bytes_of
    yield _message(sequence, part, False)


def _message(sequence: int, changes: "List[Any]", more: bool) -> Any:
    return _proto.StreamUpdatesRequest(batch=_proto.UpdateBatch(sequence=sequence, updates=changes, more=more))
