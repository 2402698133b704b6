"""What rays hit."""

from __future__ import annotations

from typing import Any, Iterator, Literal, Optional, overload

from . import _out, _query, _types
from ._precision import warn_of_origins
from ._queried import Changes, Nodes, Queried, is_generated, is_iterator, one_root, refuse_beside, refuse_out
from .all_hits import AllHits
from .hits import Hits
from .label import select
from .point_grid import PointGrid
from .rays import as_rays


class RayQueries(Queried):
    """Casts rays at a scene."""

    @overload
    def cast(self, rays: Iterator[Any], *, origins: Any = None, directions: Any = None, tmin: Any = None,
             tmax: Any = None, masks: Any = None, kind: Literal["all"], fields: "Optional[_types.Words]" = None,
             build: Optional[str] = None, cull: Optional[str] = None, under: Nodes = 0, exclude: Nodes = (),
             max_hits: int = 0, at_least: Optional[str] = None, revision: Optional[int] = None,
             timeout: Optional[float] = None, progress: _types.Progress = False,
             time_budget: Optional[float] = None, allow_partial: bool = False, route_key: str = "",
             out: Optional[_out.Out] = None, apply: Changes = None) -> "Iterator[AllHits]": ...

    @overload
    def cast(self, rays: Iterator[Any], *, origins: Any = None, directions: Any = None, tmin: Any = None,
             tmax: Any = None, masks: Any = None, kind: _types.Kind = "closest", fields: "Optional[_types.Words]" = None,
             build: Optional[str] = None, cull: Optional[str] = None, under: Nodes = 0, exclude: Nodes = (),
             max_hits: int = 0, at_least: Optional[str] = None, revision: Optional[int] = None,
             timeout: Optional[float] = None, progress: _types.Progress = False,
             time_budget: Optional[float] = None, allow_partial: bool = False, route_key: str = "",
             out: Optional[_out.Out] = None, apply: Changes = None) -> "Iterator[Hits]": ...

    @overload
    def cast(self, rays: _types.Rows = None, *, origins: Any = None, directions: Any = None, tmin: Any = None,
             tmax: Any = None, masks: Any = None, kind: Literal["all"], fields: "Optional[_types.Words]" = None,
             build: Optional[str] = None, cull: Optional[str] = None, under: Nodes = 0, exclude: Nodes = (),
             max_hits: int = 0, at_least: Optional[str] = None, revision: Optional[int] = None,
             timeout: Optional[float] = None, progress: _types.Progress = False,
             time_budget: Optional[float] = None, allow_partial: bool = False, route_key: str = "",
             out: Optional[_out.Out] = None, apply: Changes = None) -> AllHits: ...

    @overload
    def cast(self, rays: _types.Rows = None, *, origins: Any = None, directions: Any = None, tmin: Any = None,
             tmax: Any = None, masks: Any = None, kind: _types.Kind = "closest", fields: "Optional[_types.Words]" = None,
             build: Optional[str] = None, cull: Optional[str] = None, under: Nodes = 0, exclude: Nodes = (),
             max_hits: int = 0, at_least: Optional[str] = None, revision: Optional[int] = None,
             timeout: Optional[float] = None, progress: _types.Progress = False,
             time_budget: Optional[float] = None, allow_partial: bool = False, route_key: str = "",
             out: Optional[_out.Out] = None, apply: Changes = None) -> Hits: ...

    def cast(self, rays: Any = None, *, origins: Any = None, directions: Any = None, tmin: Any = None,
             tmax: Any = None, masks: Any = None, kind: str = "closest", fields: "Optional[_types.Words]" = None,
             build: Optional[str] = None, cull: Optional[str] = None, under: Nodes = 0, exclude: Nodes = (),
             max_hits: int = 0, at_least: Optional[str] = None, revision: Optional[int] = None,
             timeout: Optional[float] = None, progress: _types.Progress = False,
             time_budget: Optional[float] = None, allow_partial: bool = False, route_key: str = "",
             out: Optional[_out.Out] = None, apply: Changes = None) -> Any:
        """What rays hit.

        rays: real (..., 6), ox oy oz dx dy dz, or (..., 8), and tmin tmax; or origins and directions (..., 3), and
        tmin, tmax, masks (...), which are broadcast to one leading shape. float32 is sent as it is, all else as
        float64. Directions have any length but zero; t counts in it; tmin and tmax are closed bounds. Or an iterator of
        such arrays (or of sightline.Rays): the answer is then an iterator of their hits, all at one revision, and only
        a few batches are in memory; the batches are taken by another thread. Or a sightline.SphericalScan, Pinhole or
        VisibilityPairs, whose rays the server makes; their hits have positions unless `fields` leaves them out.

        kind: "closest", "any" (only whether there is a hit), "count" (of distinct (node, primitive)), "all".
        fields: of t node primitive uv normal hit work position name; None: the first five for closest and all. Hits
        with t have positions, and those with node have names, also where these are not named; named, the server sends
        them.
        build: trees to grow: "lazy" (where rays enter), "full", "none", "built-only"; None: as the server is set.
        cull: "back" or "front", hits that do not count.
        under: only this node and those under it exist; exclude: one or several, which do not, with those under them.
        Nodes are objects, ids, or names: see Scene.find; `exclude` takes all that have a name or match a pattern. Names
        are looked up at the newest revision. Both take a sightline.Label, too, or several, at most 64 each, for the
        nodes that have one of them at the revision that answers; under=[node, label]: what is under both.
        max_hits: for "all", the nearest of a ray; 0: all, however many they are.
        at_least: a token, of hits or of an update, that the answer must not be older than; revision: answer at it.
        time_budget: seconds for the cast on the server; rays without an answer by then are marked (`unanswered`), and
        casting them again goes on from there, since what was built stays. allow_partial: if one of several servers that
        share the scene is lost, rays that need it are marked likewise, and the cast does not fail.
        route_key: for balancers that keep each part of a scene on a server of its own: equal keys go to the same
        server.
        timeout: seconds. progress: True (a bar by tqdm, if installed) or a function of (done, total).
        out: arrays by field, such as {"t": t, "node": node}, which are filled and are the answer's; their fields are
        asked for, if `fields` does not name others beside them. Contiguous, with the leading shape of the rays and the
        answer's types; hit as uint8: 0 miss, 1 hit, 2 invalid, 4 unanswered. Not for "all", iterators and names.
        Together with rays in one SharedMemory, nothing is copied.
        apply: changes of the scene that are applied before, in the same call, all or none and once: an open batch of
        this scene, or changes of sightline.updates. The rays, as many as one call holds (16,384 in a message; through
        shared memory 262,144, or 16,384 with names) and not of kind "all", are answered at the revision that they make,
        and `applied` of the hits tells it; under and exclude are ids, or names from before. If the call is refused,
        nothing was applied. After another error, such as Unavailable, that is not known: the end of the batch applies
        what was not.

        Returns Hits, or AllHits for "all", with the leading shape of the rays. Errors: TypeError, ValueError (rays or
        words of another form), OutOfRange (the revision is not kept), DeadlineExceeded, ResourceExhausted (the server
        has too much work, also after a minute of attempts), Unavailable (after some attempts). A ray that is not finite
        or has no direction is answered as invalid, and fails nothing. Warnings: PrecisionWarning, origins are float32
        and so far out that float32 does not hold them well.
        """
        made = is_generated(rays)
        fields = _out.fields_with(out, fields)
        if fields is None and made and kind in ("closest", "all"):
            fields = (*_query.GEOMETRY, "position")
        chosen = self._choose(under, exclude, revision, at_least, apply is not None)
        query = _query.describe(_query.RAYS, self.name, kind, fields, build, cull, one_root(chosen), chosen.exclude,
                                max_hits, chosen.at_least, revision, time_budget, allow_partial, route_key=route_key)
        select(query.request, chosen.only_labels, chosen.exclude_labels)
        self._add_updates(query, apply, rays)
        caster = self._caster(query, timeout, warn_of_origins)
        if is_iterator(rays):
            refuse_out(out)
            return self._ask_iterator(caster, map(as_rays, rays), progress, "rays")
        if isinstance(rays, PointGrid):
            raise TypeError("a PointGrid is asked about by closest(), not by cast()")
        if made:
            refuse_beside(rays, origins=origins, directions=directions, tmin=tmin, tmax=tmax, masks=masks)
        batch = rays if made else as_rays(rays, origins, directions, tmin, tmax, masks)
        return self._ask(caster, query, batch, apply, out, progress, "rays")
