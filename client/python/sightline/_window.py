"""The messages of a stream that are on their way: bounded, sent in order, sent again on another call if one breaks."""

from __future__ import annotations

import threading
from collections import deque
from typing import Any, Callable, Deque, Iterator, Optional


class Window:
    """Takes items from a source, in the threads that gRPC sends from, no more than `size` beyond the answers.

    An error of the source ends the items; `error` then has it.
    """

    def __init__(self, source: "Iterator[Any]", size: int):
        self._source = source
        self._size = size
        self._lock = threading.RLock()  # entering a condition by itself could be interrupted half way
        self._changed = threading.Condition(self._lock)
        self._items: "Deque[Any]" = deque()  # not answered yet
        self._first = 0                      # the number of the oldest
        self._attempt = 0
        self._is_pulling = False
        self._ended = False
        self.error: Optional[BaseException] = None

    def attempt(self, encode: "Callable[[int, Any], bytes]") -> "Iterator[bytes]":
        """Messages for a new call: the items without an answer, then the others, numbered from 0. Ends those of the
        attempt before."""
        with self._lock:
            self._attempt += 1
            attempt, first = self._attempt, self._first
            self._changed.notify_all()
        return self._messages(attempt, first, encode)

    def _messages(self, attempt: int, first: int, encode: "Callable[[int, Any], bytes]") -> "Iterator[bytes]":
        number = first
        while True:
            item = self._take(attempt, number)
            if item is None:
                return
            yield encode(number - first, item)
            number += 1

    def _take(self, attempt: int, number: int) -> Any:
        """The item of this number, once it may be sent; None at the end, and when the attempt is over."""
        while True:
            with self._lock:
                self._changed.wait_for(lambda: self._is_ready(attempt, number))
                if attempt != self._attempt:
                    return None
                if number - self._first < len(self._items):
                    return self._items[number - self._first]
                if self._ended:
                    return None
                self._is_pulling = True
            self._pull()

    def _is_ready(self, attempt: int, number: int) -> bool:
        return (attempt != self._attempt or number - self._first < len(self._items) or self._ended
                or (len(self._items) < self._size and not self._is_pulling))

    def _pull(self) -> None:
        item, error = None, None
        try:
            item = next(self._source, None)
        except BaseException as raised:  # it is raised where the answers are read
            error = raised
        with self._lock:
            self._is_pulling = False
            if item is None:
                self._ended, self.error = True, error
            else:
                self._items.append(item)
            self._changed.notify_all()

    def oldest(self) -> Any:
        """The item that the next answer belongs to; None if there is none."""
        with self._lock:
            return self._items[0] if self._items else None

    def answered(self) -> None:
        """The oldest item has its whole answer."""
        with self._lock:
            self._items.popleft()
            self._first += 1
            self._changed.notify_all()

    def is_done(self) -> bool:
        with self._lock:
            return self._ended and not self._items

    def close(self) -> None:
        """No attempt sends any more."""
        with self._lock:
            self._attempt += 1
            self._ended = True
            self._changed.notify_all()
