"""Answers that come one after the other."""

from __future__ import annotations

import asyncio
from typing import Any, AsyncIterator, Generic, Iterator, TypeVar

from ._threads import Threads, new_context

T = TypeVar("T")
_END = object()


class Results(Generic[T]):
    """An asynchronous iterator over what an iterator makes on threads. Leaving it by `aclose()`, `async with`, an
    exception in it, or cancelling cancels its call."""

    def __init__(self, threads: Threads, results: "Iterator[T]"):
        self._threads = threads
        self._results = results
        self._context, self._calls = new_context()

    def __aiter__(self) -> "AsyncIterator[T]":
        return self

    async def __anext__(self) -> T:
        found: Any = await self._threads.run_in(self._context, self._calls,
                                           lambda: next(self._results, _END))
        if found is _END:
            raise StopAsyncIteration
        return found  # type: ignore[no-any-return]

    async def aclose(self) -> None:
        """Cancels what is left of the call."""
        self._calls.cancel()

    async def __aenter__(self) -> "Results[T]":
        return self

    async def __aexit__(self, *_: Any) -> None:
        await self.aclose()

    def __del__(self) -> None:
        self._calls.cancel()


def _from_loop(batches: "AsyncIterator[Any]", loop: asyncio.AbstractEventLoop) -> "Iterator[Any]":
    """What an asynchronous iterator makes on the event loop, in another thread."""

    async def following() -> Any:
        try:
            return await batches.__anext__()
        except StopAsyncIteration:
            return _END

    while True:
        found = asyncio.run_coroutine_threadsafe(following(), loop).result()
        if found is _END:
            return
        yield found


def iterator_of(batches: Any) -> "Iterator[Any]":
    """An iterator for another thread, of an iterable or an asynchronous one."""
    if hasattr(batches, "__aiter__"):
        return _from_loop(batches.__aiter__(), asyncio.get_running_loop())
    return iter(batches)
