"""Rays as arrays: what users pass, made columns of one type, without copies where they are contiguous."""

from __future__ import annotations

import math
from typing import Any, Iterator, List, Optional, Tuple

import numpy as np
from numpy.typing import ArrayLike

_FLOATS = {np.dtype("<f4"), np.dtype("<f8")}


class Rays:
    """Rays with a leading shape, as columns over all `count` of them.

    origins, directions: (n, 3) of `dtype`, float32 or float64, as are tmin and tmax (n) or None; masks: (n) uint32 or
    None. The arrays may be views of the caller's, of any strides. origin_type: what the origins were given as.
    """

    def __init__(self, shape: Tuple[int, ...], origins: np.ndarray, directions: np.ndarray,
                 tmin: Optional[np.ndarray], tmax: Optional[np.ndarray], masks: Optional[np.ndarray],
                 origin_type: Optional[np.dtype] = None):
        self.shape = shape
        self.count = math.prod(shape)
        self.dtype = origins.dtype
        self.origins, self.directions = origins, directions
        self.tmin, self.tmax, self.masks = tmin, tmax, masks
        self.origin_type = origin_type or origins.dtype

    def from_t(self, rows: np.ndarray, tmin: np.ndarray) -> "Rays":
        """Some of the rays (m), in double, from another tmin (m) on."""
        bound = None if self.tmax is None else self.tmax[rows].astype("f8")
        return Rays((len(rows),), self.origins[rows].astype("f8"), self.directions[rows].astype("f8"),
                    tmin.astype("f8"), bound, None if self.masks is None else self.masks[rows])

    def columns(self) -> "List[Optional[np.ndarray]]":
        return [self.origins, self.directions, self.tmin, self.tmax, self.masks]

    def slices(self, size: int) -> "Iterator[Tuple[int, int]]":
        """Ranges of at most `size` rays; one empty range where there are none."""
        for begin in range(0, max(self.count, 1), size):
            yield begin, min(begin + size, self.count)


def as_rays(rays: Any = None, origins: Any = None, directions: Any = None, tmin: Any = None, tmax: Any = None,
            masks: Any = None) -> Rays:
    """Rays from one array (..., 6) or (..., 8), or from columns that are broadcast to one leading shape.

    TypeError: not real numbers. ValueError: a shape that is not of rays.
    """
    if isinstance(rays, Rays):
        return rays
    if rays is not None:
        if origins is not None or directions is not None:
            raise TypeError("pass either rays or origins and directions")
        table = _real(rays, "rays")
        if table.ndim == 0 or table.shape[-1] not in (6, 8):
            raise ValueError(f"rays have the shape (..., 6) or (..., 8), not {table.shape}")
        if table.shape[-1] == 8:
            if tmin is not None or tmax is not None:
                raise TypeError("rays of shape (..., 8) have their own tmin and tmax")
            tmin, tmax = table[..., 6], table[..., 7]
        origins, directions = table[..., :3], table[..., 3:6]
    if origins is None or directions is None:
        raise TypeError("rays need origins and directions")
    vectors = [_vectors(origins, "origins"), _vectors(directions, "directions")]
    bounds: "List[Optional[np.ndarray]]" = [None if t is None else _real(t, name) for t, name in ((tmin, "tmin"), (tmax, "tmax"))]
    bits = None if masks is None else _masks(masks)
    dtype = _common_type([*vectors, *bounds])
    shape = np.broadcast_shapes(*(v.shape[:-1] for v in vectors), *(t.shape for t in bounds if t is not None),
                                *(() if bits is None else (bits.shape,)))

    def vector(column: np.ndarray) -> np.ndarray:
        return np.broadcast_to(column.astype(dtype, copy=False), shape + (3,)).reshape(-1, 3)

    def number(column: Optional[np.ndarray], kind: Any) -> Optional[np.ndarray]:
        if column is None:
            return None
        return np.broadcast_to(column.astype(kind, copy=False), shape).reshape(-1)

    return Rays(shape, vector(vectors[0]), vector(vectors[1]), number(bounds[0], dtype), number(bounds[1], dtype),
                number(bits, np.dtype("<u4")), vectors[0].dtype)


def _real(value: ArrayLike, name: str) -> np.ndarray:
    array = np.asarray(value)
    if array.dtype == object:
        raise TypeError(f"{name}: rows of different lengths, or not numbers")
    if array.dtype.kind not in "fiu":
        raise TypeError(f"{name}: real numbers are needed, not {array.dtype}")
    return array


def _vectors(value: ArrayLike, name: str) -> np.ndarray:
    array = _real(value, name)
    if array.ndim == 0 or array.shape[-1] != 3:
        raise ValueError(f"{name} have the shape (..., 3), not {array.shape}")
    return array


def _masks(value: ArrayLike) -> np.ndarray:
    array = np.asarray(value)
    if array.dtype.kind not in "iu":
        raise TypeError(f"masks: integers of 32 bits are needed, not {array.dtype}")
    if array.size and (array.min() < 0 or array.max() > 0xFFFFFFFF):
        raise ValueError("masks have 32 bits")
    return array


def _common_type(columns: "List[Optional[np.ndarray]]") -> np.dtype:
    """float32 if it holds every column exactly by its type, or by its value for single numbers; else float64."""
    for column in columns:
        if column is None or column.dtype.newbyteorder("<") == np.dtype("<f4") or column.dtype == np.float16:
            continue
        with np.errstate(over="ignore"):
            exact = column.ndim == 0 and (column.astype("<f4") == column or column != column)
        if not exact:
            return np.dtype("<f8")
    return np.dtype("<f4")
