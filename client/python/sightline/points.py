"""Points as arrays."""

from __future__ import annotations

from typing import Any, List, Optional, Tuple

import numpy as np

from ._arrays import Rows
from ._types import Array


class Points(Rows):
    """Points with a leading shape, as columns over all `count` of them.

    positions: (n, 3) of `dtype`, float32 or float64, as is max_distance (n) or None; masks: (n) uint32 or None. The
    arrays may be views of the caller's, of any strides. position_type: what the positions were given as.
    """

    def __init__(self, shape: Tuple[int, ...], positions: Array, max_distance: Optional[Array],
                 masks: Optional[Array], position_type: Optional[np.dtype[Any]] = None):
        super().__init__(shape, positions.dtype)
        self.positions, self.max_distance, self.masks = positions, max_distance, masks
        self.position_type = position_type or positions.dtype

    def some(self, rows: Array) -> "Points":
        """Those with these numbers (m)."""
        bound, masks = (None if column is None else column[rows] for column in (self.max_distance, self.masks))
        return Points((len(rows),), self.positions[rows], bound, masks, self.position_type)

    def columns(self) -> "List[Optional[Array]]":
        return [self.positions, self.max_distance, self.masks]
