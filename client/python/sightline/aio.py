"""The client for asyncio: the same calls, awaited.

    async with sightline.aio.connect("127.0.0.1:50151") as client:
        hits = await client.scene("engine").cast(rays)

The work of a call, copies of arrays included, is done on threads, so that it does not hold up the event loop. Cancelling a
task cancels its call on the server, too. Arguments, answers and errors are those of sightline.connect().
"""

from __future__ import annotations

import asyncio
import concurrent.futures
import contextvars
import functools
from typing import Any, AsyncIterator, Callable, Iterator, List, Optional

from . import batch as _batch
from . import client as _client
from . import scene as _scene
from . import update_stream as _update_stream
from ._scope import CallScope, scope
from ._warnings import give
from .shared_memory import SharedMemory, Transport

_THREADS = 64  # as many calls as a server takes of one connection at a time
_END = object()


class _Threads:
    def __init__(self) -> None:
        self._executor = concurrent.futures.ThreadPoolExecutor(_THREADS, "sightline")

    async def run(self, function: "Callable[..., Any]", *arguments: Any, **named: Any) -> Any:
        return await self.run_in(*_new_context(), functools.partial(function, *arguments, **named))

    async def run_in(self, context: contextvars.Context, calls: CallScope, function: "Callable[[], Any]") -> Any:
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


def _new_context() -> "tuple[contextvars.Context, CallScope]":
    context, calls = contextvars.copy_context(), CallScope()
    context.run(scope.set, calls)
    return context, calls


class Results:
    """An asynchronous iterator over what an iterator makes on threads. Leaving it by `aclose()`, `async with`, an
    exception in it, or cancelling cancels its call."""

    def __init__(self, threads: _Threads, results: "Iterator[Any]"):
        self._threads = threads
        self._results = results
        self._context, self._calls = _new_context()

    def __aiter__(self) -> "AsyncIterator[Any]":
        return self

    async def __anext__(self) -> Any:
        found = await self._threads.run_in(self._context, self._calls,
                                           functools.partial(next, self._results, _END))
        if found is _END:
            raise StopAsyncIteration
        return found

    async def aclose(self) -> None:
        """Cancels what is left of the call."""
        self._calls.cancel()

    async def __aenter__(self) -> "Results":
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


def _iterator_of(batches: Any) -> "Iterator[Any]":
    if hasattr(batches, "__aiter__"):
        return _from_loop(batches.__aiter__(), asyncio.get_running_loop())
    return iter(batches)


def connect(endpoint: Optional[str] = None, **options: Any) -> "Client":
    """A client; the options of sightline.connect()."""
    return Client(_client.connect(endpoint, **options))


class Client:
    """sightline.Client, awaited."""

    def __init__(self, client: _client.Client):
        self._client = client
        self._threads = _Threads()

    async def __aenter__(self) -> "Client":
        return self

    async def __aexit__(self, *_: Any) -> None:
        await self.close()

    async def close(self) -> None:
        """Ends the connection and all calls."""
        self._client.close()
        self._threads.close()

    def scene(self, name: str) -> "Scene":
        return Scene(self._client.scene(name), self._threads)

    async def create_scene(self, name: str, **options: Any) -> "Scene":
        return Scene(await self._threads.run(self._client.create_scene, name, **options), self._threads)

    async def import_arrays(self, name: str, vertices: Any, faces: Any, **options: Any) -> "Scene":
        made = await self._threads.run(self._client.import_arrays, name, vertices, faces, **options)
        return Scene(made, self._threads)

    async def delete_scene(self, name: str) -> None:
        await self._threads.run(self._client.delete_scene, name)

    async def scenes(self, project: str = "default") -> "List[_scene.SceneInfo]":
        return await self._threads.run(self._client.scenes, project)

    list_scenes = scenes

    async def server_info(self) -> Any:
        return await self._threads.run(self._client.server_info)

    @property
    def transport(self) -> Transport:
        return self._client.transport

    async def share_memory(self, size: int) -> SharedMemory:
        return await self._threads.run(self._client.share_memory, size)


def _awaited(name: str) -> Any:
    original = getattr(_scene.Scene, name)

    @functools.wraps(original)
    async def call(self: "Scene", *arguments: Any, **named: Any) -> Any:
        return await self._threads.run(getattr(self._scene, name), *arguments, **named)

    return call


class Scene:
    """sightline.Scene, awaited. Within a batch, changes are awaited, too."""

    def __init__(self, scene: _scene.Scene, threads: _Threads):
        self._scene = scene
        self._threads = threads
        self.name = scene.name

    info = _awaited("info")
    stats = _awaited("stats")
    delete = _awaited("delete")
    render = _awaited("render")
    nodes = _awaited("nodes")
    add = _awaited("add")
    put = _awaited("put")
    set_transforms = _awaited("set_transforms")
    patch_vertices = _awaited("patch_vertices")
    delete_node = _awaited("delete_node")

    async def cast(self, rays: Any = None, **options: Any) -> Any:
        """Hits, as of sightline.Scene.cast."""
        return await self._threads.run(self._scene.cast, rays, **_plain(options))

    def cast_batches(self, batches: Any, **options: Any) -> Results:
        """The hits of each batch of an iterator or an asynchronous iterator, with a few batches in memory."""
        return Results(self._threads, self._scene.cast(_iterator_of(batches), **options))

    async def closest(self, points: Any, max_distance: Any = None, **options: Any) -> Any:
        """Nearest faces, as of sightline.Scene.closest."""
        return await self._threads.run(self._scene.closest, points, max_distance, **_plain(options))

    def closest_batches(self, batches: Any, max_distance: Any = None, **options: Any) -> Results:
        """The nearest faces of each batch of an iterator or an asynchronous iterator, with a few batches in memory."""
        return Results(self._threads, self._scene.closest(_iterator_of(batches), max_distance, **options))

    async def contains(self, points: Any, **options: Any) -> Any:
        """Whether points are inside, as of sightline.Scene.contains."""
        return await self._threads.run(self._scene.contains, points, **options)

    def contains_batches(self, batches: Any, **options: Any) -> Results:
        """The same for each batch of an iterator or an asynchronous iterator, with a few batches in memory."""
        return Results(self._threads, self._scene.contains(_iterator_of(batches), **options))

    def watch(self, start: Optional[int] = None) -> Results:
        """Changes, as of sightline.Scene.watch."""
        return Results(self._threads, self._scene.watch(start))

    def batch(self, expected_revision: Optional[int] = None) -> "Batch":
        """For `async with`."""
        return Batch(self._scene.batch(expected_revision), self._threads)

    def update_stream(self, producer: str, **options: Any) -> "UpdateStream":
        """For `async with`."""
        return UpdateStream(functools.partial(self._scene.update_stream, producer, **options), self._threads)


class Batch:
    """sightline.Batch, for `async with`."""

    def __init__(self, batch: _batch.Batch, threads: _Threads):
        self._batch = batch
        self._threads = threads

    @property
    def applied(self) -> Optional[_batch.Applied]:
        return self._batch.applied

    async def __aenter__(self) -> "Batch":
        self._batch.__enter__()
        return self

    async def __aexit__(self, *raised: Any) -> None:
        await self._threads.run(self._batch.__exit__, *raised)


def _plain(options: "dict[str, Any]") -> "dict[str, Any]":
    """The options of a cast, with the batch of sightline behind one of these."""
    changes = options.get("apply")
    return {**options, "apply": changes._batch} if isinstance(changes, Batch) else options


class UpdateStream:
    """sightline.UpdateStream, for `async with`."""

    def __init__(self, opening: "Callable[[], _update_stream.UpdateStream]", threads: _Threads):
        self._opening = opening
        self._threads = threads

    async def __aenter__(self) -> "UpdateStream":
        self._stream = await self._threads.run(self._opening)
        return self

    async def __aexit__(self, *raised: Any) -> None:
        await self._threads.run(self._stream.__exit__, *raised)

    async def send(self, changes: Any) -> int:
        return await self._threads.run(self._stream.send, changes)

    async def set_transforms(self, nodes: Any, transforms: Any) -> int:
        return await self._threads.run(self._stream.set_transforms, nodes, transforms)

    async def patch_vertices(self, nodes: Any, vertices: Any, first: int = 0) -> int:
        return await self._threads.run(self._stream.patch_vertices, nodes, vertices, first)

    async def flush(self, timeout: Optional[float] = None) -> int:
        return await self._threads.run(self._stream.flush, timeout)
