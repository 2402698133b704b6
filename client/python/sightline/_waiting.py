"""Waiting for gRPC so that Ctrl-C does no harm.

Python may run a signal's handler in the main thread when it has just taken a lock of gRPC's Python code and has not
yet entered the block that releases it. gRPC's own threads then wait for that lock for ever, and with them every later
call of the channel. So the main thread waits at a SimpleQueue, which cannot be left half way.
"""

from __future__ import annotations

import threading
from queue import SimpleQueue
from typing import Any, Iterator

_END = object()


def result_of(call: Any) -> Any:
    """What call.result() returns or raises."""
    ended: "SimpleQueue[Any]" = SimpleQueue()
    call.add_done_callback(ended.put)
    ended.get()
    return call.result()


def read_ahead(source: "Iterator[Any]", ahead: int) -> "Iterator[Any]":
    """The items of `source`, which another thread takes from it, at most `ahead` before they are asked for. What it
    raises is raised here."""
    wanted: "SimpleQueue[bool]" = SimpleQueue()
    taken: "SimpleQueue[Any]" = SimpleQueue()
    for _ in range(ahead):
        wanted.put(True)

    def take() -> None:
        try:
            while wanted.get():
                taken.put((next(source, _END), None))
        except BaseException as error:  # it is raised where the items are read
            taken.put((_END, error))

    threading.Thread(target=take, name="sightline-reader", daemon=True).start()
    try:
        while True:
            item, error = taken.get()
            if error is not None:
                raise error
            if item is _END:
                return
            wanted.put(True)
            yield item
    finally:
        wanted.put(False)
