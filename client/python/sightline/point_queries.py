"""Which faces are nearest to points, and which points are inside."""

from __future__ import annotations

from typing import Any, Iterator, Literal, Optional, Union, overload

from . import _out, _query, _types
from ._as_points import as_points, check_grid
from ._precision import warn_of_points
from ._queried import Changes, Nodes, Queried, is_generated, is_iterator, one_root, refuse_out
from .all_nearest import AllNearest
from .label import select
from .nearest import Nearest


class PointQueries(Queried):
    """Asks a scene about points."""

    @overload
    def closest(self, points: Iterator[Any], max_distance: Any = None, *, masks: Any = None,
                kind: Literal["all"], fields: "Optional[_types.Words]" = None,
                build: Optional[str] = None, under: Nodes = 0, exclude: Nodes = (), max_hits: int = 0,
                at_least: Optional[str] = None, revision: Optional[int] = None, timeout: Optional[float] = None,
                progress: _types.Progress = False, time_budget: Optional[float] = None, allow_partial: bool = False,
                route_key: str = "", side: str = "parity", side_rays: int = 1,
                out: Optional[_out.Out] = None, apply: Changes = None) -> "Iterator[AllNearest]": ...

    @overload
    def closest(self, points: Iterator[Any], max_distance: Any = None, *, masks: Any = None,
                kind: _types.Kind = "closest", fields: "Optional[_types.Words]" = None,
                build: Optional[str] = None, under: Nodes = 0, exclude: Nodes = (), max_hits: int = 0,
                at_least: Optional[str] = None, revision: Optional[int] = None, timeout: Optional[float] = None,
                progress: _types.Progress = False, time_budget: Optional[float] = None, allow_partial: bool = False,
                route_key: str = "", side: str = "parity", side_rays: int = 1,
                out: Optional[_out.Out] = None, apply: Changes = None) -> "Iterator[Nearest]": ...

    @overload
    def closest(self, points: _types.Rows, max_distance: Any = None, *, masks: Any = None,
                kind: Literal["all"], fields: "Optional[_types.Words]" = None,
                build: Optional[str] = None, under: Nodes = 0, exclude: Nodes = (), max_hits: int = 0,
                at_least: Optional[str] = None, revision: Optional[int] = None, timeout: Optional[float] = None,
                progress: _types.Progress = False, time_budget: Optional[float] = None, allow_partial: bool = False,
                route_key: str = "", side: str = "parity", side_rays: int = 1,
                out: Optional[_out.Out] = None, apply: Changes = None) -> AllNearest: ...

    @overload
    def closest(self, points: _types.Rows, max_distance: Any = None, *, masks: Any = None,
                kind: _types.Kind = "closest", fields: "Optional[_types.Words]" = None,
                build: Optional[str] = None, under: Nodes = 0, exclude: Nodes = (), max_hits: int = 0,
                at_least: Optional[str] = None, revision: Optional[int] = None, timeout: Optional[float] = None,
                progress: _types.Progress = False, time_budget: Optional[float] = None, allow_partial: bool = False,
                route_key: str = "", side: str = "parity", side_rays: int = 1,
                out: Optional[_out.Out] = None, apply: Changes = None) -> Nearest: ...

    def closest(self, points: Any, max_distance: Any = None, *, masks: Any = None,
                kind: str = "closest", fields: "Optional[_types.Words]" = None,
                build: Optional[str] = None, under: Nodes = 0, exclude: Nodes = (), max_hits: int = 0,
                at_least: Optional[str] = None, revision: Optional[int] = None, timeout: Optional[float] = None,
                progress: _types.Progress = False, time_budget: Optional[float] = None, allow_partial: bool = False,
                route_key: str = "", side: str = "parity", side_rays: int = 1,
                out: Optional[_out.Out] = None, apply: Changes = None) -> Any:
        """The faces that are nearest to points.

        points: real (..., 3), with which max_distance and masks (...) are broadcast; float32 is sent as it is, all else
        as float64. max_distance, in the scene's units: a face at exactly this distance counts, and none does below 0;
        None: any distance. Or a sightline.PointGrid, whose points the server makes. Or an iterator of such arrays (or
        of sightline.Points): the answer is then an iterator, as of cast(), and max_distance and masks go with each
        array.

        kind: "closest" (the face with the least (distance, node, primitive)), "any" (only whether a face is within
        max_distance), "count" (how many are), "all" (each of them, near to far). max_hits: for "all", the nearest faces
        of a point, at most 16,384: k of them are its k nearest; 0: all within max_distance, up to 16,384, and a warning
        says how many points have more.
        fields: of distance node primitive uv normal position hit work name, and of
        signed inside votes for closest; None: the first six for closest and all. Answers with node have names, also
        where these are not named; positions must be.
        build, under, exclude, at_least, revision, timeout, progress, time_budget, allow_partial, route_key, out, apply:
        as for cast(); `inside` as uint8: 0 outside, 1 inside, 2 invalid, 4 unanswered.

        side: what tells the inside, for signed, inside and votes: "parity" (a ray from the point crosses an odd number
        of faces: closed meshes), "winding" (it does not cross as many from behind as from the front: closed meshes that
        overlap), "normal" (the point is behind its nearest face: open surfaces). side_rays: for the first two, of how
        many rays the majority counts, odd, at most 63; more than one helps where surfaces have holes, which votes show.

        The distance is that from a point to a face as it stands in the scene, rounded once to double; a face without
        area is the segment or the point that it is. Returns Nearest, or AllNearest for "all", with the leading shape of
        the points. Errors: as of cast(), and Unimplemented (the server is of a version without this query). A point or
        a max_distance that is NaN, or a point that is infinite, is answered as invalid, and fails nothing. Warnings:
        PrecisionWarning, points are float32 and so far out that float32 does not hold them well.
        """
        fields = _out.fields_with(out, fields)
        chosen = self._choose(under, exclude, revision, at_least, apply is not None)
        query = _query.describe(_query.POINTS, self.name, kind, fields, build, None, one_root(chosen), chosen.exclude,
                                max_hits, chosen.at_least, revision, time_budget, allow_partial, side, side_rays,
                                route_key)
        select(query.request, chosen.only_labels, chosen.exclude_labels)
        self._add_updates(query, apply, points)
        caster = self._caster(query, timeout, warn_of_points)
        if is_iterator(points):
            refuse_out(out)
            batches = (as_points(part, max_distance, masks) for part in points)
            return self._ask_iterator(caster, batches, progress, "points")
        if is_generated(points):
            check_grid(points, max_distance, masks)
        batch = points if is_generated(points) else as_points(points, max_distance, masks)
        return self._ask(caster, query, batch, apply, out, progress, "points")

    @overload
    def contains(self, points: Iterator[Any], *, side: str = "parity", side_rays: int = 1, masks: Any = None,
                 build: Optional[str] = None, under: Nodes = 0, exclude: Nodes = (), at_least: Optional[str] = None,
                 revision: Optional[int] = None, timeout: Optional[float] = None, progress: _types.Progress = False,
                 route_key: str = "") -> "Iterator[_types.Bools]": ...

    @overload
    def contains(self, points: _types.Rows, *, side: str = "parity", side_rays: int = 1, masks: Any = None,
                 build: Optional[str] = None, under: Nodes = 0, exclude: Nodes = (), at_least: Optional[str] = None,
                 revision: Optional[int] = None, timeout: Optional[float] = None, progress: _types.Progress = False,
                 route_key: str = "") -> _types.Bools: ...

    def contains(self, points: Any, *, side: str = "parity", side_rays: int = 1, masks: Any = None,
                 build: Optional[str] = None, under: Nodes = 0, exclude: Nodes = (), at_least: Optional[str] = None,
                 revision: Optional[int] = None, timeout: Optional[float] = None, progress: _types.Progress = False,
                 route_key: str = "") -> "Union[_types.Bools, Iterator[_types.Bools]]":
        """bool, with the leading shape of points (..., 3): whether each is inside; no distance is computed. What it
        takes, and its errors, are those of closest(); an iterator of arrays gives an iterator of answers. A point that
        is not finite is in no mesh: False. There is no time budget, as its answers could not be told from others:
        closest() with fields=("inside",) marks them.
        """
        near: Any = self.closest(points, fields=("inside",), side=side, side_rays=side_rays, masks=masks, build=build,
                                 under=under, exclude=exclude, at_least=at_least, revision=revision, timeout=timeout,
                                 progress=progress, route_key=route_key)
        return near.inside if isinstance(near, Nearest) else (some.inside for some in near)
