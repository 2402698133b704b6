"""Answers with a row for each ray, as arrays with the leading shape of the rays."""

from __future__ import annotations

import math
from typing import Any, Dict, Iterator, Optional, Sequence

import numpy as np

from ._answer import INVALID, INVALID_COUNT, UNANSWERED, UNANSWERED_COUNT, Answer, some_rays
from ._generated import Generated
from ._optional import optional_module
from ._types import Array, Bools, Doubles, UInt32s

_AXES = {"uv": ("corner", "uv"), "normal": ("axis", "xyz"), "position": ("axis", "xyz")}  # of some columns


class Hits(Answer):
    """A row for each ray: of kinds "closest", "any" and "count". Arrays have the leading shape of the rays."""

    def _shaped(self, column: Array) -> Array:
        return column.reshape(self.shape + column.shape[1:])

    def __len__(self) -> int:
        return self.shape[0] if self.shape else 1

    def __getitem__(self, index: Any) -> "Hits":
        """The answers to some rays, by any index that an array of the leading shape takes. Its stats are those of the
        whole cast."""
        numbers = np.arange(math.prod(self.shape)).reshape(self.shape)[index]
        rows = np.asarray(numbers).reshape(-1)
        part = type(self)(np.shape(numbers), rays=some_rays(self._rays, rows), **self._some(rows))
        if self._found_names is not None:
            part._found_names = self._found_names[rows]
        return part

    def __iter__(self) -> "Iterator[Hits]":
        return (self[at] for at in range(len(self))) if self.shape else iter((self,))

    def __repr__(self) -> str:
        status = self._status()
        told = f"{(status == 1).sum()} of {status.size} {self._ROW}s hit" if self._tells_hits() else \
            f"{status.size} {self._ROW}s"
        for value, word in ((INVALID, "invalid"), (UNANSWERED, "unanswered")):
            count = (status == value).sum()
            told += f", {count} {word}" if count else ""
        return f"<{type(self).__name__} {self.shape}: {told}{self._summary()}>"

    @property
    def hit(self) -> Bools:
        """bool: whether the ray hits."""
        return self._shaped(self._status() == 1)

    @property
    def invalid(self) -> Bools:
        """bool: whether the ray cannot be cast (not finite, or without a direction)."""
        return self._shaped(self._status() == INVALID)

    @property
    def unanswered(self) -> Bools:
        """bool: whether the ray has no answer: `time_budget`, `allow_partial` of Scene.cast."""
        return self._shaped(self._status() == UNANSWERED)

    def _status(self) -> Array:
        """0 miss, 1 hit, 2 invalid, 4 unanswered, from whichever column tells."""
        if "hit" in self._columns:
            return self._columns["hit"]
        if "count" in self._columns:
            count = self._columns["count"]
            return np.where(count == INVALID_COUNT, INVALID, np.where(count == UNANSWERED_COUNT, UNANSWERED, count > 0))
        return self._status_of(self._column("t"))

    @staticmethod
    def _status_of(t: Array) -> Array:
        return np.where(np.isnan(t), INVALID, np.where(t == -np.inf, UNANSWERED, np.isfinite(t)))

    @property
    def count(self) -> UInt32s:
        """uint32: how many (node, primitive) the ray hits; an invalid ray 2**32 - 1, an unanswered one 2**32 - 2.
        Kind "count"."""
        return self._shaped(self._column("count"))

    @property
    def work(self) -> UInt32s:
        """uint32: steps and triangle tests; the top bit is set where the ray met a cell that is not built."""
        return self._shaped(self._column("work"))

    @property
    def position(self) -> Doubles:
        """float64 (..., 3): origin + t * direction; NaN where nothing is hit."""
        if "position" in self._columns:
            return self._shaped(self._columns["position"])
        rays = self._need_rays()
        return self._ends(rays.origins, rays.directions)

    def to_pandas(self) -> Any:
        """A DataFrame with a row for each ray or point, in the order of the flattened ones. Error: ImportError, pandas
        is not installed."""
        pandas = optional_module("pandas", "to_pandas")

        table = self._table()
        for name in ("count", "work", "signed", "inside", "votes", "hit"):
            if name in self._columns or (name == "hit" and self._tells_hits()):
                table[name] = getattr(self, name).reshape(-1)
        index = pandas.RangeIndex(len(next(iter(table.values()))), name=self._ROW)
        return pandas.DataFrame(table, index=index)

    def _tells_hits(self) -> bool:
        """Whether a column says what is hit: of points one may ask for sides alone."""
        return True

    def to_xarray(self, dims: "Optional[Sequence[str]]" = None) -> Any:
        """A Dataset with the columns as arrays over the leading shape. dims: names of its axes; default: those of
        scans, pictures, pairs and grids, which have their angles or points as coordinates, too, else dim_0, dim_1, ...
        Errors: ImportError, xarray is not installed; ValueError, other than one name an axis."""
        xarray = optional_module("xarray", "to_xarray")
        source = self._rays if isinstance(self._rays, Generated) else None
        usual = source.dims if source else tuple(f"dim_{i}" for i in range(len(self.shape)))
        axes = usual if dims is None else tuple(dims)
        if len(axes) != len(self.shape) or len(set(axes)) != len(axes):
            raise ValueError(f"dims are {len(self.shape)} names that differ, not {axes}")
        variables: "Dict[str, Any]" = {}
        for name, column in self._columns.items():
            vector = _AXES.get(name)
            told = getattr(self, name) if name in ("hit", "inside") else self._shaped(column)
            variables[self._T if name == "t" else name] = ((*axes, vector[0]) if vector else axes, told)
        if "hit" not in variables and self._tells_hits():
            variables["hit"] = (axes, self.hit)
        coordinates: "Dict[str, Any]" = {axis: list(words) for name, (axis, words) in _AXES.items()
                                         if name in self._columns}
        if source is not None:
            renamed = dict(zip(source.dims, axes))
            coordinates.update({name: (tuple(renamed[axis] for axis in along), values)
                                for name, (along, values) in source.coordinates.items() if name not in variables})
        return xarray.Dataset(variables, coordinates, {"revision": self.revision, "token": self.token})
