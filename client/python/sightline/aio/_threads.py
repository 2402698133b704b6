"""The threads that calls of sightline.aio are made on."""

from __future__ import annotations

import asyncio
import concurrent.futures
import contextvars
import functools
from typing import TYPE_CHECKING, Any, Callable, Coroutine, TypeVar

from .._scope import CallScope, scope
from .._warnings import give

if TYPE_CHECKING:
    from typing_extensions import Concatenate, ParamSpec

    P = ParamSpec("P")

T = TypeVar("T")

_THREADS = 64  # as many calls as a server takes of one connection at a time


class Threads:
    def __init__(self) -> None:
        self._executor = concurrent.futures.ThreadPoolExecutor(_THREADS, "sightline")

    async def run(self, function: "Callable[P, T]", *arguments: "P.args", **named: "P.kwargs") -> T:
        return await self.run_in(*new_context(), functools.partial(function, *arguments, **named))

    async def run_in(self, context: contextvars.Context, calls: CallScope, function: "Callable[[], T]") -> T:
        future = self._executor.submit(lambda: context.run(function))
        try:
            return await asyncio.wrap_future(future)
        except asyncio.CancelledError:
            calls.cancel()
            raise
        finally:
            give(calls)

    def close(self) -> None:
        self._executor.shutdown(wait=False)


def new_context() -> "tuple[contextvars.Context, CallScope]":
    context, calls = contextvars.copy_context(), CallScope()
    context.run(scope.set, calls)
    return context, calls


def awaited(method: "Callable[Concatenate[Any, P], T]") -> "Callable[Concatenate[Any, P], Coroutine[Any, Any, T]]":
    """The method of the class of the same name here: it awaits that of `_original`, on `_threads`."""

    @functools.wraps(method)
    async def call(self: Any, /, *arguments: "P.args", **named: "P.kwargs") -> T:
        return await self._threads.run(method, self._original, *arguments, **named)  # type: ignore[no-any-return]

    return call
