"""Rays as arrays."""

from __future__ import annotations

from typing import Any, List, Optional, Tuple

import numpy as np

from ._arrays import Broadcast, Rows, bits, reals, triples
from ._types import Array


class Rays(Rows):
    """Rays with a leading shape, as columns over all `count` of them.

    origins, directions: (n, 3) of `dtype`, float32 or float64, as are tmin and tmax (n) or None; masks: (n) uint32 or
    None. The arrays may be views of the caller's, of any strides. origin_type: what the origins were given as.
    """

    def __init__(self, shape: Tuple[int, ...], origins: Array, directions: Array,
                 tmin: Optional[Array], tmax: Optional[Array], masks: Optional[Array],
                 origin_type: Optional[np.dtype[Any]] = None):
        super().__init__(shape, origins.dtype)
        self.origins, self.directions = origins, directions
        self.tmin, self.tmax, self.masks = tmin, tmax, masks
        self.origin_type = origin_type or origins.dtype

    def from_t(self, rows: Array, tmin: Array) -> "Rays":
        """Some of the rays (m), in double, from another tmin (m) on."""
        bound = None if self.tmax is None else self.tmax[rows].astype("f8")
        return Rays((len(rows),), self.origins[rows].astype("f8"), self.directions[rows].astype("f8"),
                    tmin.astype("f8"), bound, None if self.masks is None else self.masks[rows])

    def some(self, rows: Array) -> "Rays":
        """Those with these numbers (m)."""
        tmin, tmax, masks = (None if column is None else column[rows] for column in (self.tmin, self.tmax, self.masks))
        return Rays((len(rows),), self.origins[rows], self.directions[rows], tmin, tmax, masks, self.origin_type)

    def columns(self) -> "List[Optional[Array]]":
        return [self.origins, self.directions, self.tmin, self.tmax, self.masks]


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
        table = reals(rays, "rays")
        if table.ndim == 0 or table.shape[-1] not in (6, 8):
            raise ValueError(f"rays have the shape (..., 6) or (..., 8), not {table.shape}")
        if table.shape[-1] == 8:
            if tmin is not None or tmax is not None:
                raise TypeError("rays of shape (..., 8) have their own tmin and tmax")
            tmin, tmax = table[..., 6], table[..., 7]
        origins, directions = table[..., :3], table[..., 3:6]
    if origins is None or directions is None:
        raise TypeError("rays need origins and directions")
    vectors = [triples(origins, "origins"), triples(directions, "directions")]
    bounds = [None if t is None else reals(t, name) for t, name in ((tmin, "tmin"), (tmax, "tmax"))]
    columns = Broadcast(vectors, bounds, bits(masks))
    (begin, along), (first, last) = columns.vectors, columns.numbers
    return Rays(columns.shape, begin, along, first, last, columns.masks, vectors[0].dtype)
