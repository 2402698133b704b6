"""On which side of a surface points are: what decides, and the columns that tell."""

from __future__ import annotations

import operator
from typing import Any, Iterable, Tuple

from . import _proto

FIELDS = ("signed", "inside", "votes")
MOST_RAYS = 63
_RULES = ("parity", "winding", "normal")


def check_rays(count: Any, name: str = "side_rays") -> int:
    """The number of rays whose majority decides. TypeError, ValueError: it is not an odd number up to MOST_RAYS."""
    rays = operator.index(count)
    if not 1 <= rays <= MOST_RAYS or rays % 2 == 0:
        raise ValueError(f"{name} is odd and from 1 to {MOST_RAYS}, not {count}")
    return rays


def ask(request: Any, columns: "Iterable[str]", side: str, side_rays: int) -> None:
    """Puts into a request what decides. TypeError, ValueError: what the server would refuse."""
    asked = [name for name in columns if name in FIELDS]
    rays = check_rays(side_rays)
    if side not in _RULES:
        raise ValueError(f"side is {', '.join(_RULES)}, not {side!r}")
    if not asked and (side != "parity" or rays != 1):
        raise ValueError(f"side and side_rays belong to the fields {', '.join(FIELDS)}, of which none is asked for")
    if side == "normal" and rays != 1:
        raise ValueError("side 'normal' casts no rays: side_rays belongs to 'parity' and 'winding'")
    if side == "normal" and "votes" in asked:
        raise ValueError("side 'normal' has no field 'votes': it casts no rays")
    if asked:
        request.side_rule = _proto.enum_value(f"SIDE_RULE_{side.upper()}")
        request.side_rays = rays


def telling(columns: "Tuple[str, ...]") -> "Tuple[str, ...]":
    """The columns of closest faces or of sides, with one that tells points without an answer from the others. Where
    sides alone are asked for it is `inside`, since with any other the server computes distances."""
    if not {"t", "signed", "hit"}.isdisjoint(columns):
        return columns
    if columns and set(columns) <= set(FIELDS):
        return columns if "inside" in columns else (*columns, "inside")
    return (*columns, "hit")
