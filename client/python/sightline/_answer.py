"""What all answers to casts have."""

from __future__ import annotations

from typing import Any, Dict, Optional, Tuple

import numpy as np

from ._generated import Generated
from ._query import COLUMNS, OF_HITS
from ._types import Array, Doubles, Floats, NameLookup, Objects, UInt32s, UInt64s
from .applied import Applied
from .rays import Rays

INVALID_COUNT = 0xFFFFFFFF
UNANSWERED_COUNT = INVALID_COUNT - 1
INVALID, CUT_OFF, UNANSWERED = 2, 3, 4  # values of the column `hit`


class Answer:
    """What all answers have: the revision, its token, statistics, the columns that were asked for. Pickled, it has all
    of them; names of nodes only if they were looked at, or named in fields."""

    _T, _ROW = "t", "ray"  # what the column t and a row are called

    def __init__(self, shape: Tuple[int, ...], columns: "Dict[str, Array]", revision: int, token: str,
                 stats: "Dict[str, int]", rays: Any, names: Optional[NameLookup]):
        self.shape = shape  #: leading shape of the rays
        self.revision = revision  #: the revision of the scene that answered
        self.token = token  #: that revision's token, for `at_least`
        self.applied: Optional[Applied] = None  #: what the updates of Scene.cast(apply=...) came to
        self.stats = stats  #: what the cast cost: rays, hits, invalid, cells_expanded, build_us, trace_us, ...
        self._columns = columns
        self._rays = rays
        self._names = names
        self._found_names: Optional[Objects] = None

    def __getstate__(self) -> "Dict[str, Any]":
        return {**self.__dict__, "_names": None}

    def _column(self, name: str) -> Array:
        column = self._columns.get(name)
        if column is None:
            raise AttributeError(f"{self._T if name == 't' else name} was not asked for: name it in fields, or ask with "
                                 "another kind")
        return column

    def _shaped(self, column: Array) -> Array:
        return column

    @property
    def t(self) -> Doubles:
        """float64, in lengths of the ray's direction; a miss +inf, an invalid ray NaN, an unanswered one -inf."""
        return self._shaped(self._column("t"))

    @property
    def node(self) -> UInt64s:
        """uint64, the id of the node that is hit; 0: none."""
        return self._shaped(self._column("node"))

    @property
    def primitive(self) -> UInt32s:
        """uint32, the face's index in the node's mesh; 0 where nothing is hit."""
        return self._shaped(self._column("primitive"))

    @property
    def uv(self) -> Floats:
        """float32 (..., 2): weights of the face's vertices 1 and 2."""
        return self._shaped(self._column("uv"))

    @property
    def normal(self) -> Floats:
        """float32 (..., 3): the face's unit normal in scene coordinates, on the side that shows its corners
        counterclockwise in the mesh's own frame, so that a mirrored node's stay outside; 0 where nothing is hit."""
        return self._shaped(self._column("normal"))

    def _ends(self, origins: Array, directions: Array) -> Doubles:
        """The points of hits, as the server computes HIT_FIELD_POSITION."""
        t = self._column("t")
        with np.errstate(invalid="ignore", over="ignore"):
            ends = origins.astype("f8", copy=False) + t[:, None] * directions.astype("f8", copy=False)
        ends[~np.isfinite(t)] = np.nan
        return self._shaped(ends)

    def _need_rays(self) -> Rays:
        if not isinstance(self._rays, Rays):
            raise AttributeError("positions of rays that the server makes: name position in fields")
        return self._rays

    @property
    def name(self) -> Objects:
        """str objects: names of the nodes that are hit, "" for none. Unless it was named in fields, the server is asked
        when it is first used. Errors, then: OutOfRange, the revision is not kept any more."""
        if "name" in self._columns:
            return self._shaped(self._columns["name"])
        if self._found_names is None:
            node = self._column("node")
            if self._names is None:
                raise AttributeError("names are not kept by pickle unless they were looked at before, or named in fields")
            ids, inverse = np.unique(node, return_inverse=True)
            by_id = self._names(ids[ids != 0], self.revision)
            self._found_names = np.array([by_id.get(int(i), "") for i in ids], dtype=object)[inverse]
        return self._shaped(self._found_names)

    def _some(self, rows: Array) -> "Dict[str, Any]":
        """Of these rows, what answers of the same kind are made of beside their shape. `rows` are those of columns."""
        return {"columns": {name: column[rows] for name, column in self._columns.items()}, "revision": self.revision,
                "token": self.token, "stats": self.stats, "names": self._names}

    def _table(self) -> "Dict[str, Array]":
        table: "Dict[str, Array]" = {}
        for name in OF_HITS:
            column = self._columns.get(name)
            if name == "uv" and column is not None:
                table.update(u=column[:, 0], v=column[:, 1])
            elif name == "normal" and column is not None:
                table.update(nx=column[:, 0], ny=column[:, 1], nz=column[:, 2])
            elif name == "position" and column is not None:
                table.update(x=column[:, 0], y=column[:, 1], z=column[:, 2])
            elif column is not None:
                table[self._T if name == "t" else name] = column
        return table

    def _summary(self) -> str:
        """Of the finite t, from which to which, and how many nodes they are of."""
        told = ""
        if "t" in self._columns:
            t = self._columns["t"]
            finite = t[np.isfinite(t)]
            if len(finite):
                told += f", {self._T} from {finite.min():.6g} to {finite.max():.6g}"
        if "node" in self._columns:
            nodes = np.unique(self._columns["node"])
            count = int((nodes != 0).sum())
            told += f", {count} node{'' if count == 1 else 's'}"
        return f"{told}, revision {self.revision}"


def some_rays(rays: Any, rows: Array) -> Any:
    """The rays with these numbers, where their positions are computed from them."""
    return None if isinstance(rays, Generated) or rays is None else rays.some(rows)


def empty_columns(names: "Tuple[str, ...]", rows: int) -> "Dict[str, Array]":
    """Arrays for so many rows."""
    return {name: np.empty((rows, *COLUMNS[name].row), object if name == "name" else COLUMNS[name].dtype)
            for name in names}
