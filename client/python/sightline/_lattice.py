"""The lattice of a scene: where the vertices of its meshes may lie, so that meshes that touch still touch.

A mesh is kept as float32 about an offset. Two meshes that share an edge must share it exactly, or rays slip between
them, so each coordinate is rounded by a rule that looks at nothing but the coordinate and one step of the lattice, a
power of two:

- a coordinate within 16 steps of zero to float32, as if there were no offset;
- one that lies farther out to a multiple of 2^-24 steps.

On an axis where a mesh is wholly within 16 steps of zero its offset is 0, else it is the multiple of the step nearest
to its middle. A mesh is at most a step in size, so that what is left of each rounded coordinate is exactly a float.

Which step a mesh has depends on where it lies and, coarsely, on its size: at 4,000,000 all meshes from 13 to 4,096
units have the step 4,096, and are rounded to a 4,096th. A scene keeps the steps that it has: a mesh takes the smallest
of them that it fits and that is fine enough for it.
"""

from __future__ import annotations

import math
import threading
from typing import Any, Dict, Optional, Tuple

import numpy as np

from ._types import Array
from ._warnings import PrecisionWarning, warn

_FAR = 16                    # steps
_QUANTUM = 2.0 ** -24        # steps
_LOSS = 1e-4                 # share of a mesh's size: a step that rounds more is too coarse for it
_CHOSEN_LOSS = 1e-5          # for a step that no mesh of the scene has yet, so that smaller meshes may share it
_USUAL = 2.0 ** -12          # share of the distance from zero: the step of most meshes
_LARGER, _SMALLER = 16, 1/8  # times a step: for meshes that do not fit it, and for which it is too coarse
Box = Tuple[Array, Array]


class Placement:
    """How one mesh is kept. `origin` (3), float64: what is subtracted from its vertices."""

    def __init__(self, origin: Array, step: float):
        self.origin = origin
        self._step = step

    def residuals(self, vertices: Any) -> Array:
        """float32 (v, 3): vertices relative to the origin. Exact for those that lie within a step of the mesh."""
        exact = np.asarray(vertices, "f8")
        with np.errstate(over="ignore", invalid="ignore"):
            return np.ascontiguousarray(_rounded(exact, self._step) - self.origin, "<f4")


class Lattice:
    """The lattice of one scene. Threads: any."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._boxes: "Dict[float, Box]" = {}  # the box of the meshes of each step
        self._has_warned = False
        #: Meshes that Scene.add has sent, by digest and the origin that it was given.
        self.added: "Dict[Tuple[str, Tuple[float, ...]], Optional[Placement]]" = {}

    def place(self, vertices: Array) -> Placement:
        """Where to keep a mesh of these vertices, real (v, 3)."""
        points = np.asarray(vertices, "f8")
        finite = np.isfinite(points).all(axis=1)
        points = points if finite.all() else points[finite]
        if not len(points):
            return Placement(np.zeros(3), math.inf)
        low, high = points.min(axis=0), points.max(axis=0)
        with np.errstate(over="ignore"):
            size = float((high - low).max())
        if not 0 < size < math.inf:
            return Placement(np.zeros(3), math.inf)
        reach = np.maximum(np.abs(low), np.abs(high))
        with self._lock:
            step = self._step(size, reach)
            self._add(step, (low, high))
        is_far = reach >= _FAR * step
        return Placement(np.where(is_far, step * np.round((low / 2 + high / 2) / step), 0.0), step)

    def _step(self, size: float, reach: Array) -> float:
        for known in sorted(self._boxes):
            if size <= known and _error(known, reach) <= _LOSS * size:
                return known
        exponent = math.frexp(float(reach.max()))[1]
        step = math.ldexp(_USUAL, -(-exponent // 4) * 4)
        while step < size:
            step *= _LARGER
        while _error(step, reach) > _CHOSEN_LOSS * size:
            step *= _SMALLER
        return step

    def _add(self, step: float, box: Box) -> None:
        if step not in self._boxes:
            self._boxes[step] = box
        else:
            low, high = self._boxes[step]
            self._boxes[step] = np.minimum(low, box[0]), np.maximum(high, box[1])
        self._warn_of_gaps(step, box)

    def _warn_of_gaps(self, step: float, box: Box) -> None:
        """Near zero all steps round alike."""
        for other, (low, high) in self._boxes.items():
            finer, coarser = sorted((step, other))
            first, last = np.maximum(low, box[0]), np.minimum(high, box[1])
            is_far = np.maximum(np.abs(first), np.abs(last)).max() >= _FAR * finer
            if other == step or self._has_warned or (first > last).any() or not is_far:
                continue
            self._has_warned = True
            warn(f"meshes that touch differ so much in size that their vertices are rounded to multiples of "
                 f"{finer * _QUANTUM:g} and {coarser * _QUANTUM:g}: rays may slip between them where they share "
                 "an edge", PrecisionWarning)


def _error(step: float, reach: Array) -> float:
    """How far rounding moves a coordinate, at most."""
    return float(np.where(reach >= _FAR * step, step / 2, reach).max()) * _QUANTUM


def _rounded(exact: Array, step: float) -> Array:
    if not math.isfinite(step):
        return exact
    quantum = step * _QUANTUM
    near = exact.astype("f4").astype("f8")
    return np.where(np.abs(exact) < _FAR * step, near, np.round(exact / quantum) * quantum)
