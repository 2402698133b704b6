"""The points of a cloud as the rows of a file, and the file that they go to."""

from __future__ import annotations

import contextlib
import os
from typing import Any, BinaryIO, ContextManager, Union

import numpy as np
from numpy.typing import NDArray

from .._warnings import PrecisionWarning, warn
from .cloud import PointCloud

File = Union[str, "os.PathLike[str]", BinaryIO]
_NOTICED = 1e-3  # units by which float32 may move a point without a warning


def rows(cloud: PointCloud, coordinates: str, ring: str) -> NDArray[Any]:
    """(n), packed and little-endian, with x y z as `coordinates`, "f4" or "f8", and intensity ring time. Warnings:
    PrecisionWarning, float32 moves points noticeably. Errors: ValueError, another type, or a point that float32 does
    not hold."""
    if coordinates not in ("f4", "f8"):
        raise ValueError(f"coordinates are 'f4' or 'f8', not {coordinates!r}")
    table = np.empty(len(cloud), [(axis, f"<{coordinates}") for axis in "xyz"]
                     + [("intensity", "<f4"), ("ring", ring), ("time", "<f8")])
    with np.errstate(over="ignore"):
        for axis, exact in zip("xyz", cloud.position.T):
            table[axis] = exact
    moved = max(float(np.abs(table[axis] - exact).max(initial=0)) for axis, exact in zip("xyz", cloud.position.T))
    if moved == np.inf:
        raise ValueError("a coordinate is beyond the range of float32: pass coordinates='f8'")
    if moved > _NOTICED:
        warn(f"coordinates are written as float32, which moves points by up to {moved:.2g}: pass coordinates='f8', or "
             "write positions about a point near them", PrecisionWarning)
    for name in ("intensity", "ring", "time"):
        table[name] = getattr(cloud, name)
    return table


def opened(file: File) -> "ContextManager[Any]":
    """A file to write bytes to: one of this path, or the caller's, which stays open."""
    if isinstance(file, (str, os.PathLike)):
        return open(file, "wb")
    return contextlib.nullcontext(file)
