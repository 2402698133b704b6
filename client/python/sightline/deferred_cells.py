"""Where a scene is not built yet."""

from __future__ import annotations

from typing import NamedTuple

from ._types import Floats


class DeferredCells(NamedTuple):
    """Cells of trees that no ray has entered yet. boxes: float32 (n, 2, 3) in scene coordinates, least and greatest,
    the largest cells first; total: how many cells there are, a cell of a mesh once for each node that has it."""

    boxes: Floats
    total: int
    revision: int
