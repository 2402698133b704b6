"""What a scene answers: what rays hit, which faces are nearest to points, which points are inside."""

from __future__ import annotations

import functools
from typing import TYPE_CHECKING, Any, Callable, Dict, Iterable, Iterator, Optional, Union

import numpy as np

from . import _out, _query, updates
from ._caster import Caster
from ._connection import Connection
from ._precision import warn_of_origins, warn_of_points
from ._progress import reporter
from .batch import Batch, request_of
from .hits import AllHits, Hits
from .nearest import AllNearest, Nearest
from .nodes import Node
from .points import PointGrid, as_points, check_bounds
from .rays import as_rays

if TYPE_CHECKING:
    from .client import Client

AnyNode = Union[Node, int]


class Queries:
    """The queries of a Scene."""

    client: "Client"
    name: str
    _connection: Connection

    def cast(self, rays: Any = None, *, origins: Any = None, directions: Any = None, tmin: Any = None,
             tmax: Any = None, masks: Any = None, kind: str = "closest", fields: Optional[Iterable[str]] = None,
             build: Optional[str] = None, cull: Optional[str] = None, under: AnyNode = 0,
             exclude: Iterable[AnyNode] = (), max_hits: int = 0, at_least: Optional[str] = None,
             revision: Optional[int] = None, timeout: Optional[float] = None,
             progress: Union[bool, Callable[[int, Optional[int]], Any]] = False,
             time_budget: Optional[float] = None, allow_partial: bool = False, out: Optional[_out.Out] = None,
             apply: "Union[Batch, Iterable[Any], None]" = None) -> Any:
        """What rays hit.

        rays: real (..., 6), ox oy oz dx dy dz, or (..., 8), and tmin tmax; or origins and directions (..., 3), and
        tmin, tmax, masks (...), which are broadcast to one leading shape. float32 is sent as it is, all else as float64.
        Directions have any length but zero; t counts in it; tmin and tmax are closed bounds. Or an iterator of such
        arrays (or of sightline.Rays): the answer is then an iterator of their hits, all at one revision, and only a few
        batches are in memory; the batches are taken by another thread.

        kind: "closest", "any" (only whether there is a hit), "count" (of distinct (node, primitive)), "all".
        fields: of t node primitive uv normal hit work position name; None: the first five for closest and all. Hits with
        t have positions, and those with node have names, also where these are not named; named, the server sends them.
        build: trees to grow: "lazy" (where rays enter), "full", "none", "built-only"; None: as the server is set.
        cull: "back" or "front", hits that do not count. under: only this node and those under it exist; exclude: these
        and those under them do not. max_hits: for "all", the nearest of a ray; 0: all, however many they are.
        at_least: a token, of hits or of an update, that the answer must not be older than; revision: answer at it.
        time_budget: seconds for the cast on the server; rays without an answer by then are marked (`unanswered`), and
        casting them again goes on from there, since what was built stays. allow_partial: if one of several servers that
        share the scene is lost, rays that need it are marked likewise, and the cast does not fail.
        timeout: seconds. progress: True (a bar by tqdm, if installed) or a function of (done, total).
        out: arrays by field, such as {"t": t, "node": node}, which are filled and are the answer's; their fields are asked for,
        if `fields` does not name others beside them. Contiguous, with the leading shape of the rays and the answer's types;
        hit as uint8: 0 miss, 1 hit, 2 invalid, 4 unanswered. Not for "all", iterators and names. Together with rays in one
        SharedMemory, nothing is copied.
        apply: changes of the scene that are applied before, in the same call, all or none and once: an open batch of this
        scene, or messages Update (made by sightline.updates). The rays, as many as one call holds (16,384 in a message;
        through shared memory 262,144, or 16,384 with names) and not of kind "all", are answered at the revision that they
        make, and `applied` of the hits tells it; under and exclude are ids. If the call is refused, nothing was applied.
        After another error, such as Unavailable, that is not known: the end of the batch applies what was not.

        Returns Hits, or AllHits for "all", with the leading shape of the rays. Errors: TypeError, ValueError (rays or
        words of another form), OutOfRange (the revision is not kept), DeadlineExceeded, ResourceExhausted (the server
        has too much work, also after a minute of attempts), Unavailable (after some attempts). A ray that is not finite or has no direction is answered
        as invalid, and fails nothing. Warnings: PrecisionWarning, origins are float32 and so far out that float32 does not
        hold them well.
        """
        fields = _out.fields_with(out, fields)
        query = _query.describe(_query.RAYS, self.name, kind, fields, build, cull, updates.ids([under])[0],
                                updates.ids(exclude), max_hits, at_least, revision, time_budget, allow_partial)
        self._add_updates(query, apply, rays)
        caster = self._caster(query, timeout, warn_of_origins)
        if hasattr(rays, "__next__"):
            _refuse_out(out)
            return self._cast_iterator(caster, map(as_rays, rays), progress, "rays")
        batch = as_rays(rays, origins, directions, tmin, tmax, masks)
        columns = _out.columns_of(out, query, batch.shape)
        with reporter(progress, batch.count) as report:
            return _end_updates(apply, caster.cast(batch, report, columns))

    def closest(self, points: Any, max_distance: Any = None, *, masks: Any = None, kind: str = "closest",
                fields: Optional[Iterable[str]] = None, build: Optional[str] = None, under: AnyNode = 0,
                exclude: Iterable[AnyNode] = (), max_hits: int = 0, at_least: Optional[str] = None,
                revision: Optional[int] = None, timeout: Optional[float] = None,
                progress: Union[bool, Callable[[int, Optional[int]], Any]] = False,
                time_budget: Optional[float] = None, allow_partial: bool = False, side: str = "parity",
                side_rays: int = 1, out: Optional[_out.Out] = None,
                apply: "Union[Batch, Iterable[Any], None]" = None) -> Any:
        """The faces that are nearest to points.

        points: real (..., 3), with which max_distance and masks (...) are broadcast; float32 is sent as it is, all else
        as float64. max_distance, in the scene's units: a face at exactly this distance counts, and none does below 0;
        None: any distance. Or a sightline.PointGrid, whose points the server makes. Or an iterator of such arrays (or
        of sightline.Points): the answer is then an iterator, as of cast(), and max_distance and masks go with each
        array.

        kind: "closest" (the face with the least (distance, node, primitive)), "any" (only whether a face is within
        max_distance), "count" (how many are), "all" (each of them, near to far). max_hits: for "all", the nearest faces
        of a point, at most 16,384: k of them are its k nearest; 0: all within max_distance, up to 16,384, and a warning
        says how many points have more. fields: of distance node primitive uv normal position hit work name, and of
        signed inside votes for closest; None: the first six for closest and all. Answers with node have names, also where
        these are not named; positions must be.
        build, under, exclude, at_least, revision, timeout, progress, time_budget, allow_partial, out, apply: as for cast();
        `inside` as uint8: 0 outside, 1 inside, 2 invalid, 4 unanswered; apply does not go with a PointGrid.

        side: what tells the inside, for signed, inside and votes: "parity" (a ray from the point crosses an odd number of
        faces: closed meshes), "winding" (it does not cross as many from behind as from the front: closed meshes that
        overlap), "normal" (the point is behind its nearest face: open surfaces). side_rays: for the first two, of how many
        rays the majority counts, odd, at most 63; more than one helps where surfaces have holes, which votes show.

        The distance is that from a point to a face as it stands in the scene, rounded once to double; a face without
        area is the segment or the point that it is. Returns Nearest, or AllNearest for "all", with the leading shape of
        the points. Errors: as of cast(), and Unimplemented (the server is of a version without this query). A point or
        a max_distance that is NaN, or a point that is infinite, is answered as invalid, and fails nothing. Warnings:
        PrecisionWarning, points are float32 and so far out that float32 does not hold them well.
        """
        fields = _out.fields_with(out, fields)
        query = _query.describe(_query.POINTS, self.name, kind, fields, build, None, updates.ids([under])[0],
                                updates.ids(exclude), max_hits, at_least, revision, time_budget, allow_partial, side,
                                side_rays)
        self._add_updates(query, apply, points)
        caster = self._caster(query, timeout, warn_of_points)
        if hasattr(points, "__next__"):
            _refuse_out(out)
            batches = (as_points(part, max_distance, masks) for part in points)
            return self._cast_iterator(caster, batches, progress, "points")
        if isinstance(points, PointGrid):
            check_bounds(points, max_distance, masks)
        batch = points if isinstance(points, PointGrid) else as_points(points, max_distance, masks)
        columns = _out.columns_of(out, query, batch.shape)
        with reporter(progress, batch.count, "points") as report:
            return _end_updates(apply, caster.cast(batch, report, columns))

    def contains(self, points: Any, *, side: str = "parity", side_rays: int = 1, masks: Any = None,
                 build: Optional[str] = None, under: AnyNode = 0, exclude: Iterable[AnyNode] = (),
                 at_least: Optional[str] = None, revision: Optional[int] = None, timeout: Optional[float] = None,
                 progress: Union[bool, Callable[[int, Optional[int]], Any]] = False) -> Any:
        """bool, with the leading shape of points (..., 3): whether each is inside; no distance is computed. What it takes,
        and its errors, are those of closest(); an iterator of arrays gives an iterator of answers. A point that is not
        finite is in no mesh: False. There is no time budget, as its answers could not be told from others: closest()
        with fields=("inside",) marks them.
        """
        near = self.closest(points, fields=("inside",), side=side, side_rays=side_rays, masks=masks, build=build,
                            under=under, exclude=exclude, at_least=at_least, revision=revision, timeout=timeout,
                            progress=progress)
        return near.inside if isinstance(near, Nearest) else (some.inside for some in near)

    def _names(self, ids: np.ndarray, revision: int) -> "Dict[int, str]":
        """Names of nodes by id."""
        raise NotImplementedError

    def _caster(self, query: Any, timeout: Optional[float], check: "Callable[[Scene, Any, str], None]") -> Caster:
        return Caster(self._connection, self.client.max_rays_per_request(), query, timeout, self._names,
                      functools.partial(check, self))

    def _add_updates(self, query: Any, changes: "Union[Batch, Iterable[Any], None]", rows: Any) -> None:
        if changes is None:
            return
        if hasattr(rows, "__next__"):
            raise ValueError("apply goes with one array, not with an iterator of them")
        if query.request.HasField("consistency"):
            raise ValueError("apply makes the revision that answers: leave out at_least and revision")
        if isinstance(changes, Batch) and changes.scene_name != self.name:
            raise ValueError(f"apply is a batch of {changes.scene_name}, not of {self.name}")
        request = changes.request() if isinstance(changes, Batch) else request_of("", changes)
        query.request.apply.CopyFrom(request)

    def _cast_iterator(self, caster: Caster, batches: Iterator[Any], progress: Any,
                       unit: str) -> "Iterator[Union[Hits, AllHits, Nearest, AllNearest]]":
        with reporter(progress, None, unit) as report:
            yield from caster.cast_batches(batches, report)


def _refuse_out(out: Optional[_out.Out]) -> None:
    if out:
        raise ValueError("an iterator has no out: each of its batches has an answer of its own")


def _end_updates(changes: Any, hits: Any) -> Any:
    """The hits, once the batch has been told that its changes are applied."""
    if isinstance(changes, Batch):
        changes.end_request(hits.applied)
    return hits
