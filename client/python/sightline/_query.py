"""What is asked of rays or points: the request of a cast without its rays, and which columns its answer has."""

from __future__ import annotations

import time
from typing import Any, Iterable, NamedTuple, Optional, Tuple

import numpy as np

from . import _proto, _sides


class Column(NamedTuple):
    """A column of hits: its number on the wire, element type there, and the shape of a row."""

    number: int
    dtype: "np.dtype[Any]"
    row: Tuple[int, ...]


def _column(name: str, dtype: str, *row: int) -> Column:
    return Column(_proto.enum_value(f"HIT_FIELD_{name}"), np.dtype(dtype), row)


COLUMNS = {
    "t": _column("T", "<f8"),
    "node": _column("NODE", "<u8"),
    "primitive": _column("PRIMITIVE", "<u4"),
    "uv": _column("BARYCENTRIC", "<f4", 2),
    "normal": _column("NORMAL", "<f4", 3),
    "hit": _column("HIT", "u1"),
    "work": _column("WORK", "<u4"),
    "count": _column("COUNT", "<u4"),
    "offset": _column("OFFSET", "<u4"),
    "position": _column("POSITION", "<f8", 3),
    "name": _column("NAME", "<u4"),  # a row of the answer's names
    "signed": _column("SIGNED", "<f8"),
    "inside": _column("INSIDE", "u1"),
    "votes": _column("VOTES", "u1"),
}
NAME_OF = {column.number: name for name, column in COLUMNS.items()}
MOST_LISTED = 16384  # hits of a ray, in an answer
GEOMETRY = ("t", "node", "primitive", "uv", "normal")
OF_HITS = (*GEOMETRY, "position", "name")  # for kind "all": a row for each hit

KINDS = ("closest", "any", "count", "all")

# The columns that an answer always has, and those that may be named.
_ALWAYS = {"closest": (), "any": ("hit",), "count": ("count",), "all": ("offset", "hit")}
_ALLOWED = {"closest": {*OF_HITS, "hit", "work"}, "any": {"hit", "work"}, "count": {"count", "hit", "work"},
            "all": {*OF_HITS, "hit", "work"}}
_CULLING = {None: "UNSPECIFIED", "back": "BACK", "front": "FRONT"}
_BUILD = {None: "UNSPECIFIED", "lazy": "LAZY", "full": "FULL", "none": "NONE", "built-only": "BUILT_ONLY"}


class Form(NamedTuple):
    """How one asks about rays, or about points, which are cast as rays are: `rays` are points then."""

    call: str       # of one message
    stream: str     # of many
    request: Any    # the class of the request
    generator: str  # the request's field of rays that the server makes
    t: str          # what users call the column t
    default: Tuple[str, ...]  # columns of hits, if none are named


RAYS = Form("CastRays", "StreamCastRays", _proto.CastRaysRequest, "generator", "t", GEOMETRY)
POINTS = Form("QueryPoints", "StreamQueryPoints", _proto.QueryPointsRequest, "grid", "distance",
              (*GEOMETRY, "position"))


class Query(NamedTuple):
    """A cast without its rays."""

    form: Form
    kind: str
    columns: Tuple[str, ...]  # columns of the answer
    request: Any              # of the form's class
    most: Optional[int] = None  # hits of a ray, for kind "all"; None: any number
    hidden: Tuple[str, ...] = ()  # columns that were not asked for
    route_key: str = ""  # for balancers

    def has_updates(self) -> bool:
        """Whether updates are applied before."""
        return bool(self.request.HasField("apply"))

    def needs_more(self) -> bool:
        """Whether rays that have more hits than one answer lists are cast again."""
        return self.kind == "all" and (self.most is None or self.most > MOST_LISTED)

    def again(self, revision: int, end_of_budget: Optional[float]) -> "Query":
        """The query for the rest of the hits: at this revision, as many as an answer lists, within the budget's
        rest."""
        query = self.going_on(revision, end_of_budget)
        query.request.max_hits = MOST_LISTED
        return query._replace(most=MOST_LISTED, hidden=())

    def going_on(self, revision: int, end_of_budget: Optional[float]) -> "Query":
        """The query for further rays: at this revision, within the budget's rest."""
        request = self.form.request()
        request.CopyFrom(self.request)
        set_consistency(request, None, revision)
        if end_of_budget is not None:
            request.time_budget_ms = milliseconds(end_of_budget - time.monotonic())
        return self._replace(request=request)


def describe(form: Form, scene: str, kind: str, fields: "Optional[Iterable[str]]", build: "Optional[str]",
             cull: "Optional[str]", under: int, exclude: "Iterable[int]", max_hits: int, at_least: "Optional[str]",
             revision: "Optional[int]", time_budget: "Optional[float]" = None, allow_partial: bool = False,
             side: str = "parity", side_rays: int = 1, route_key: str = "") -> Query:
    """`cull` is None for points, and the sides are those of points. ValueError: an unknown word, a field that the kind
    does not have, for points a max_hits above what an answer lists, a max_hits below 0, sides that the server would
    refuse, a time budget that is not above 0, or a route key that is not visible ASCII."""
    if kind not in _ALWAYS:
        raise ValueError(f"kind is {_words(_ALWAYS)}, not {kind!r}")
    if build not in _BUILD:
        raise ValueError(f"build is {_words(_BUILD)}, not {build!r}")
    if cull not in _CULLING:
        raise ValueError(f"cull is {_words(_CULLING)}, not {cull!r}")
    if at_least is not None and revision is not None:
        raise ValueError("pass either at_least or revision")
    if max_hits < 0:
        raise ValueError(f"max_hits is 0 or above, not {max_hits}")
    if not all(" " < c <= "~" for c in route_key):
        raise ValueError(f"route_key is visible ASCII, not {route_key!r}")
    if form is POINTS and max_hits > MOST_LISTED:
        raise ValueError(f"max_hits is at most {MOST_LISTED} for points, not {max_hits}")
    named = _named(form, kind, fields)
    request = form.request(
        scene=scene, kind=_proto.enum_value(f"QUERY_KIND_{kind.upper()}"),
        build=_proto.enum_value(f"BUILD_MODE_{_BUILD[build]}"), root=under, exclude=list(exclude),
        max_hits=min(max_hits, MOST_LISTED), allow_partial=allow_partial)
    if cull is not None:
        request.culling = _proto.enum_value(f"CULLING_{_CULLING[cull]}")
    most = max_hits or None
    hidden = () if "t" in named or kind != "all" or (most or MOST_LISTED + 1) <= MOST_LISTED else ("t",)
    columns = tuple(dict.fromkeys((*_ALWAYS[kind], *named, *hidden)))
    if kind == "closest":
        columns = _sides.telling(columns)
    if form is POINTS:
        _sides.ask(request, columns, side, side_rays)
    request.fields.extend(COLUMNS[name].number for name in columns)
    set_consistency(request, at_least, revision)
    if time_budget is not None:
        if not time_budget > 0:
            raise ValueError(f"time_budget is above 0, not {time_budget!r}")
        request.time_budget_ms = milliseconds(time_budget)
    return Query(form, kind, columns, request, most, hidden, route_key)


def _named(form: Form, kind: str, fields: "Optional[Iterable[str]]") -> "Tuple[str, ...]":
    """The columns that are asked for, by the names that they have here."""
    if fields is None:
        return form.default if kind in ("closest", "all") else ()
    allowed = _ALLOWED[kind].union(_sides.FIELDS if form is POINTS and kind == "closest" else ())
    words = {form.t if name == "t" else name: name for name in allowed}
    asked = [fields] if isinstance(fields, str) else list(fields)
    for name in asked:
        if name not in words:
            raise ValueError(f"kind {kind!r} has no field {name!r}; it has {_words(words)}")
    return tuple(dict.fromkeys(words[name] for name in asked))


def milliseconds(seconds: float) -> int:
    """A time budget on the wire: at least 1, since 0 is none."""
    return int(min(max(seconds * 1000, 1), 2 ** 32 - 1))


def set_consistency(request: Any, at_least: "Optional[str]", revision: "Optional[int]") -> None:
    """Which revision answers, in any request that has the field."""
    if at_least is not None:
        request.consistency.at_least = at_least
    elif revision is not None:
        request.consistency.exact_revision = revision


def _words(names: "Iterable[Optional[str]]") -> str:
    return ", ".join(sorted(str(name) for name in names))
