"""Arrays that users pass, made columns of one type, without copies where they are contiguous."""

from __future__ import annotations

import math
from typing import Any, Iterator, List, Optional, Tuple

import numpy as np
from numpy.typing import ArrayLike

from ._types import Array


class Rows:
    """Rays or points with a leading shape, as columns over all `count` of them. dtype: that of columns but masks,
    float32 or float64."""

    def __init__(self, shape: Tuple[int, ...], dtype: np.dtype[Any]):
        self.shape = shape
        self.count = math.prod(shape)
        self.dtype = dtype

    def columns(self) -> "List[Optional[Array]]":
        """Those of the message, in its order; None: one that is not sent."""
        raise NotImplementedError

    def slices(self, size: int, first: int = 0) -> "Iterator[Tuple[int, int]]":
        """Ranges of at most `size` rows, from row `first` on; one empty range where there are no rows."""
        for begin in range(first, max(self.count, 1), size):
            yield begin, min(begin + size, self.count)


class Broadcast:
    """Columns that are broadcast to one leading shape and made one type. vectors: (..., 3); numbers: (...) or None, as
    is masks."""

    def __init__(self, vectors: "List[Array]", numbers: "List[Optional[Array]]", masks: Optional[Array]):
        self.dtype = common_type([*vectors, *numbers])
        given = [v.shape[:-1] for v in vectors] + [t.shape for t in (*numbers, masks) if t is not None]
        self.shape = np.broadcast_shapes(*given)
        self.vectors = [np.broadcast_to(v.astype(self.dtype, copy=False), self.shape + (3,)).reshape(-1, 3)
                        for v in vectors]
        self.numbers = [self._flat(t, self.dtype) for t in numbers]
        self.masks = self._flat(masks, np.dtype("<u4"))

    def _flat(self, column: Optional[Array], dtype: np.dtype[Any]) -> Optional[Array]:
        if column is None:
            return None
        return np.broadcast_to(column.astype(dtype, copy=False), self.shape).reshape(-1)


def reals(value: ArrayLike, name: str) -> Array:
    """TypeError: not real numbers."""
    array = np.asarray(value)
    if array.dtype == object:
        raise TypeError(f"{name}: rows of different lengths, or not numbers")
    if array.dtype.kind not in "fiu":
        raise TypeError(f"{name}: real numbers are needed, not {array.dtype}")
    return array


def triples(value: ArrayLike, name: str) -> Array:
    """TypeError: not real numbers. ValueError: not (..., 3)."""
    array = reals(value, name)
    if array.ndim == 0 or array.shape[-1] != 3:
        raise ValueError(f"{name} have the shape (..., 3), not {array.shape}")
    return array


def bits(value: Any) -> Optional[Array]:
    """Masks, or None where none are given. TypeError, ValueError: not integers of 32 bits."""
    if value is None:
        return None
    array = np.asarray(value)
    if array.dtype.kind not in "iu":
        raise TypeError(f"masks: integers of 32 bits are needed, not {array.dtype}")
    if array.size and (array.min() < 0 or array.max() > 0xFFFFFFFF):
        raise ValueError("masks have 32 bits")
    return array


def common_type(columns: "List[Optional[Array]]") -> np.dtype[Any]:
    """float32 if it holds every column exactly by its type, or by its value for single numbers; else float64."""
    for column in columns:
        if column is None or column.dtype.newbyteorder("<") == np.dtype("<f4") or column.dtype == np.float16:
            continue
        with np.errstate(over="ignore"):
            exact = column.ndim == 0 and (column.astype("<f4") == column or column != column)
        if not exact:
            return np.dtype("<f8")
    return np.dtype("<f4")
