"""All hits of rays that have more of them than one answer lists: the rays are cast again from behind what is known.

Points have no bound that leaves out what is near, and the rays of a generator have one for all. Those that have more
faces or hits than an answer lists by default are asked again, once, for as many as an answer can list.
"""

from __future__ import annotations

from typing import Callable, Dict, Optional

import numpy as np

from ._answer import CUT_OFF, UNANSWERED
from ._query import MOST_LISTED, OF_HITS
from ._types import Array
from ._warnings import warn
from .all_hits import AllHits
from .rays import Rays

Columns = Dict[str, Array]


def complete(known: AllHits, rays: Rays, most: Optional[int], cast: "Callable[[Rays], AllHits]") -> None:
    """Adds to `known` what it left out, up to `most` hits of a ray; None: all. cast() lists the nearest MOST_LISTED
    hits of rays at the same revision, with the same columns, which include t.

    Hits come by (t, node, primitive), so that only those at a ray's last t may be cut in two: the ray is cast again
    from that t on, and its answer takes the place of the hits at that t. Where more hits than an answer lists are at
    one t nothing tells them apart; a warning then says how many rays miss some.
    """
    columns = known._columns
    ended, tied = np.zeros(rays.count, bool), np.zeros(rays.count, bool)
    while True:
        listed = np.diff(columns["offset"].astype("i8"))
        cut = (columns["hit"] == CUT_OFF) & ~ended
        if most is not None:
            cut &= listed < most
        rows = np.flatnonzero(cut)
        if not len(rows):
            break
        last = columns["t"][columns["offset"][rows + 1].astype("i8") - 1]
        more = cast(rays.from_t(rows, last))
        known.add_cost(more.stats)
        ended[rows] = more._columns["hit"] == UNANSWERED
        tied[rows] = _are_at_one_t(more._columns, last)
        ended |= tied
        _replace(columns, rows, last, more._columns)
    if tied.any():
        warn(f"{int(tied.sum())} rays have more than {MOST_LISTED} hits at one distance: further hits there and behind "
             "are left out", UserWarning)
    if most is not None:
        _keep_nearest(columns, most)
    _count(known)


def complete_rows(known: AllHits, ask: "Callable[[Array], AllHits]", what: str) -> None:
    """Adds to `known` what it left out. ask() lists the nearest MOST_LISTED hits of the rays, or faces of the points,
    with these numbers, at the same revision, with the same columns, which include t. A warning says how many have more;
    `what` they are."""
    columns = known._columns
    rows = np.flatnonzero(columns["hit"] == CUT_OFF)
    if not len(rows):
        return
    more = ask(rows)
    known.add_cost(more.stats)
    _replace(columns, rows, np.full(len(rows), -np.inf), more._columns)
    left_out = int((more._columns["hit"] == CUT_OFF).sum())
    if left_out:
        found = "faces within max_distance" if what == "points" else "hits"
        warn(f"{left_out} {what} have more than {MOST_LISTED} {found}: the nearest are listed", UserWarning)
    _count(known)


def _count(known: AllHits) -> None:
    known.stats["hits_found"] = int(known._columns["offset"][-1])
    known.stats["rays_cut_off"] = int((known._columns["hit"] == CUT_OFF).sum())


def _are_at_one_t(more: Columns, last: Array) -> Array:
    """For each ray, whether its whole answer is at its last t, and there is more."""
    is_cut, end = more["hit"] == CUT_OFF, more["offset"][1:].astype("i8")
    at_one: Array = is_cut.copy()
    at_one[is_cut] = more["t"][end[is_cut] - 1] == last[is_cut]
    return at_one


def _replace(columns: Columns, rows: Array, last: Array, more: Columns) -> None:
    """Puts the answers for `rows` in the place of their hits at `last` and behind."""
    is_answered = more["hit"] != UNANSWERED
    limit = np.full(len(columns["hit"]), np.inf)
    limit[rows[is_answered]] = last[is_answered]
    ray = np.repeat(np.arange(len(limit)), np.diff(columns["offset"].astype("i8")))
    kept = columns["t"] < limit[ray]
    ray = np.concatenate([ray[kept], np.repeat(rows, np.diff(more["offset"].astype("i8")))])
    order = np.argsort(ray, kind="stable")
    for name in OF_HITS:
        if name in columns:
            columns[name] = np.concatenate([columns[name][kept], more[name]])[order]
    columns["offset"] = np.append(0, np.cumsum(np.bincount(ray, minlength=len(limit)))).astype("u8")
    columns["hit"] = columns["hit"].copy()
    columns["hit"][rows[is_answered]] = more["hit"][is_answered]


def _keep_nearest(columns: Columns, most: int) -> None:
    offset = columns["offset"].astype("i8")
    count = np.diff(offset)
    if not (count > most).any():
        return
    kept = np.arange(offset[-1]) - np.repeat(offset[:-1], count) < most
    for name in OF_HITS:
        if name in columns:
            columns[name] = columns[name][kept]
    columns["offset"] = np.append(0, np.cumsum(np.minimum(count, most))).astype("u8")
    columns["hit"] = np.where(count > most, CUT_OFF, columns["hit"]).astype("u1")
