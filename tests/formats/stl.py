"""A second reader of STL, for comparison: text or binary."""

import re
import struct

from measures import Damaged, number

HEADER, FACET = 84, 50


def of_binary(data, count):
    out = []
    for i in range(count):
        n = struct.unpack_from("<9f", data, HEADER + FACET * i + 12)
        out.append([n[0:3], n[3:6], n[6:9]])
    return out


def of_text(data):
    """solid NAME, facet normal X Y Z outer loop, three of vertex X Y Z, endloop endfacet, endsolid NAME, where names end with their
    lines. Words that only begin or end what is clear without them may be missing."""
    words = iter(re.sub(rb"^[ \t]*(solid|endsolid)[^\r\n]*", rb" \1", data, flags=re.MULTILINE | re.IGNORECASE).lower().split())
    out, corners, in_facet = [], [], False
    for word in words:
        if word == b"vertex" and in_facet:
            corners.append(tuple(number(next(words, b"")) for _ in range(3)))
        elif word == b"facet" and not in_facet:
            in_facet = True
        elif word == b"endfacet" and in_facet and len(corners) == 3:
            out.append(corners)
            corners, in_facet = [], False
        elif word == b"normal" and in_facet and not corners:
            for _ in range(3):
                next(words, None)
        elif not (in_facet and word in (b"outer", b"loop", b"endloop") or not in_facet and word in (b"solid", b"endsolid")):
            raise Damaged(f"the word {word[:40]!r}")
    if in_facet:
        raise Damaged("no endfacet")
    return out


def polygons(data, _=None):
    if len(data) >= HEADER:
        count = struct.unpack_from("<I", data, HEADER - 4)[0]
        if len(data) == HEADER + FACET * count:
            return of_binary(data, count)
    if data.lstrip()[:5].lower() != b"solid":
        raise Damaged("it is not of the size that it announces")
    return of_text(data)
