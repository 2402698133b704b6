"""A scene, whose calls are awaited."""

from __future__ import annotations

import functools
from typing import Any, Callable, Dict, Literal, Optional, overload

from .. import scene
from .._types import Bools, Kind
from ..all_hits import AllHits
from ..all_nearest import AllNearest
from ..change import Change
from ..hits import Hits
from ..nearest import Nearest
from ._threads import Threads, awaited
from .batch import Batch
from .results import Results, iterator_of
from .update_stream import UpdateStream


class Scene:
    """sightline.Scene, awaited. Within a batch, changes are awaited, too."""

    def __init__(self, original: scene.Scene, threads: Threads):
        self._original = original
        self._threads = threads
        self.name = original.name

    def __repr__(self) -> str:
        return f"<asynchronous {repr(self._original)[1:]}"

    info = awaited(scene.Scene.info)
    stats = awaited(scene.Scene.stats)
    delete = awaited(scene.Scene.delete)
    render = awaited(scene.Scene.render)
    prefetch = awaited(scene.Scene.prefetch)
    cool = awaited(scene.Scene.cool)
    deferred_cells = awaited(scene.Scene.deferred_cells)
    nodes = awaited(scene.Scene.nodes)
    find = awaited(scene.Scene.find)
    find_all = awaited(scene.Scene.find_all)
    read_mesh = awaited(scene.Scene.read_mesh)
    add = awaited(scene.Scene.add)
    put = awaited(scene.Scene.put)
    set_transforms = awaited(scene.Scene.set_transforms)
    patch_vertices = awaited(scene.Scene.patch_vertices)
    delete_node = awaited(scene.Scene.delete_node)
    apply = awaited(scene.Scene.apply)

    @overload
    async def cast(self, rays: Any = None, *, kind: Literal["all"], **options: Any) -> AllHits: ...

    @overload
    async def cast(self, rays: Any = None, *, kind: Kind = "closest", **options: Any) -> Hits: ...

    async def cast(self, rays: Any = None, *, kind: Any = "closest", **options: Any) -> Any:
        """Hits, as of sightline.Scene.cast."""
        return await self._threads.run(functools.partial(self._original.cast, rays, kind=kind, **_plain(options)))

    @overload
    def cast_batches(self, batches: Any, *, kind: Literal["all"], **options: Any) -> "Results[AllHits]": ...

    @overload
    def cast_batches(self, batches: Any, *, kind: Kind = "closest",
                     **options: Any) -> "Results[Hits]": ...

    def cast_batches(self, batches: Any, *, kind: Any = "closest", **options: Any) -> Any:
        """The hits of each batch of an iterator or an asynchronous iterator, with a few batches in memory."""
        return Results(self._threads, self._original.cast(iterator_of(batches), kind=kind, **options))

    @overload
    async def closest(self, points: Any, max_distance: Any = None, *, kind: Literal["all"],
                      **options: Any) -> AllNearest: ...

    @overload
    async def closest(self, points: Any, max_distance: Any = None, *, kind: Kind = "closest",
                      **options: Any) -> Nearest: ...

    async def closest(self, points: Any, max_distance: Any = None, *, kind: Any = "closest", **options: Any) -> Any:
        """Nearest faces, as of sightline.Scene.closest."""
        return await self._threads.run(functools.partial(self._original.closest, points, max_distance, kind=kind,
                                                         **_plain(options)))

    @overload
    def closest_batches(self, batches: Any, max_distance: Any = None, *, kind: Literal["all"],
                        **options: Any) -> "Results[AllNearest]": ...

    @overload
    def closest_batches(self, batches: Any, max_distance: Any = None, *, kind: Kind = "closest",
                        **options: Any) -> "Results[Nearest]": ...

    def closest_batches(self, batches: Any, max_distance: Any = None, *, kind: Any = "closest", **options: Any) -> Any:
        """The nearest faces of each batch of an iterator or an asynchronous iterator, with a few batches in memory."""
        return Results(self._threads, self._original.closest(iterator_of(batches), max_distance, kind=kind, **options))

    async def contains(self, points: Any, **options: Any) -> Bools:
        """Whether points are inside, as of sightline.Scene.contains."""
        ask: "Callable[[], Any]" = functools.partial(self._original.contains, points, **options)
        inside: Bools = await self._threads.run(ask)
        return inside

    def contains_batches(self, batches: Any, **options: Any) -> "Results[Bools]":
        """The same for each batch of an iterator or an asynchronous iterator, with a few batches in memory."""
        return Results(self._threads, self._original.contains(iterator_of(batches), **options))

    def watch(self, start: Optional[int] = None) -> "Results[Change]":
        """Changes, as of sightline.Scene.watch."""
        return Results(self._threads, self._original.watch(start))

    def batch(self, expected_revision: Optional[int] = None) -> Batch:
        """For `async with`."""
        return Batch(self._original.batch(expected_revision), self._threads)

    def update_stream(self, producer: str, *, latest_wins: bool = False, relaxed: bool = False) -> UpdateStream:
        """For `async with`."""
        opening = functools.partial(self._original.update_stream, producer, latest_wins=latest_wins, relaxed=relaxed)
        return UpdateStream(opening, self._threads)


def _plain(options: "Dict[str, Any]") -> "Dict[str, Any]":
    """The options of a cast, with the batch of sightline behind one of these."""
    changes = options.get("apply")
    return {**options, "apply": changes.original} if isinstance(changes, Batch) else options
