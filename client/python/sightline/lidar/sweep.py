"""The rays of a sensor that turns and moves, and the points that it measures."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Optional, Tuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import AllHits, Rays, as_rays
from .cloud import PointCloud
from .noise import RangeNoise
from .trajectory import Trajectory

if TYPE_CHECKING:
    from .beams import BeamTable

Out = Tuple[NDArray[Any], NDArray[Any]]


class Sweep:
    """Columns of rays, from BeamTable.sweep(). origins, directions: (columns, beams, 3), in the scene, directions of
    length 1. times: (columns, beams), when each ray is fired. first: the number of the first column."""

    def __init__(self, beams: "BeamTable", trajectory: Trajectory, first: int, columns: int, start: float,
                 out: Optional[Out]):
        self.beams, self.first, self.shape = beams, first, (columns, len(beams.elevations))
        begins = start + np.arange(first, first + columns, dtype="f8")[:, None] * beams.interval
        fired = begins + (beams.times if beams.times.any() else np.zeros(1))  # (columns, beams), or (columns, 1)
        self.times = np.broadcast_to(fired, self.shape)
        turns, places = trajectory.at(fired)
        from_head = _product(turns, beams.heads(first, columns)[:, None])
        self.origins, self.directions = _arrays(out, self.shape)
        _rotate(from_head, beams.directions, self.directions)
        if beams.radius:
            _rotate(from_head, beams.origins, self.origins, places)
        else:
            np.copyto(self.origins, places, casting="same_kind")

    def __repr__(self) -> str:
        return f"<sweep of {self.shape[0]} columns from {self.first} on, of {self.shape[1]} beams>"

    @property
    def rays(self) -> Rays:
        """For Scene.cast(). They end at the greatest range; what is nearer than the least one is hit, as it hides what
        is behind it."""
        greatest = self.beams.ranges[1]
        if np.isinf(greatest):
            return as_rays(origins=self.origins, directions=self.directions)
        kind = np.result_type(self.origins, self.directions)
        bound = np.asarray(greatest, kind)
        if bound < greatest:
            bound = np.nextafter(bound, np.asarray(np.inf, kind))
        return as_rays(origins=self.origins, directions=self.directions, tmax=bound)

    def points(self, hits: Any, *, noise: Optional[RangeNoise] = None, reflectivity: ArrayLike = 1.0,
               frame: str = "scene") -> PointCloud:
        """What is measured where the rays hit: a point for each ray that returns.

        hits: of Scene.cast(sweep.rays), with t, and with normal for intensities. Intensity is the reflectivity times
        the cosine between ray and normal, without the loss by distance, for which sensors correct it; without normals
        it is the reflectivity. reflectivity: one number, or for each ray, (columns, beams), as by a table of hits.node.
        frame: "scene"; or "sensor", coordinates of the sensor as it stood when it fired each beam, in which its motion
        distorts the scene. Rays without an answer, which hits.unanswered tells, return nothing. Errors: TypeError,
        hits of kind "all"; ValueError, hits of rays of another shape, reflectivities that are negative or not
        finite."""
        if isinstance(hits, AllHits):
            raise TypeError("hits of kind 'all' have several rows for a ray: cast with kind='closest'")
        if tuple(hits.shape) != self.shape:
            raise ValueError(f"the hits are of rays of shape {tuple(hits.shape)}, the sweep's is {self.shape}")
        if frame not in ("scene", "sensor"):
            raise ValueError(f"frame is 'scene' or 'sensor', not {frame!r}")
        least, greatest = self.beams.ranges
        t = np.asarray(hits.t, "f8").reshape(-1)
        with np.errstate(invalid="ignore"):
            ranges = np.where((t >= least) & (t <= greatest), t, np.inf)
        if noise is not None:
            ranges = noise.measured(self.first * self.shape[1], ranges)
            ranges = np.where((ranges >= least) & (ranges <= greatest), ranges, np.inf)
        ray = np.flatnonzero(np.isfinite(ranges))
        measured, ring = ranges[ray], (ray % self.shape[1]).astype("u2")
        if frame == "scene":
            position = _rows(self.origins, ray) + measured[:, None] * _rows(self.directions, ray)
        else:
            position = self._in_sensor(ray, measured)
        return PointCloud(position=position, intensity=self._intensity(hits, ray, reflectivity), ring=ring,
                          time=self.times.reshape(-1)[ray], range=measured, ray=ray)

    def _in_sensor(self, ray: NDArray[Any], measured: NDArray[Any]) -> NDArray[Any]:
        heads = self.beams.heads(self.first, self.shape[0])[:, None]
        place, direction = np.empty((*self.shape, 3)), np.empty((*self.shape, 3))
        _rotate(heads, self.beams.origins, place)
        _rotate(heads, self.beams.directions, direction)
        return np.asarray(_rows(place, ray) + measured[:, None] * _rows(direction, ray))

    def _intensity(self, hits: Any, ray: NDArray[Any], reflectivity: ArrayLike) -> NDArray[Any]:
        given: NDArray[Any] = np.broadcast_to(np.asarray(reflectivity, "f8"), self.shape).reshape(-1)[ray]
        wrong = np.flatnonzero(~((given >= 0) & (given < np.inf)))
        if wrong.size:
            raise ValueError(f"reflectivities are finite and not below 0, as {given[wrong[0]]} is")
        normals: Optional[NDArray[Any]] = getattr(hits, "normal", None)
        if normals is None:
            return given.astype("f4")
        towards = (_rows(np.asarray(normals), ray) * _rows(self.directions, ray)).sum(axis=1)
        return np.asarray(given * np.minimum(np.abs(towards), 1.0), "f4")


def _rows(columns: NDArray[Any], ray: NDArray[Any]) -> NDArray[Any]:
    return np.asarray(columns.reshape(-1, 3)[ray], "f8")


def _arrays(out: Optional[Out], shape: "Tuple[int, int]") -> Out:
    """The arrays for origins and directions. TypeError, ValueError: those of the caller do not fit."""
    if out is None:
        return np.empty((*shape, 3)), np.empty((*shape, 3))
    origins, directions = out
    for name, array in (("origins", origins), ("directions", directions)):
        if not isinstance(array, np.ndarray) or array.dtype not in (np.dtype("f4"), np.dtype("f8")):
            kind = getattr(array, "dtype", type(array))
            raise TypeError(f"out has a NumPy array of float32 or float64 for {name}, not {kind}")
        if array.shape != (*shape, 3) or not array.flags.writeable:
            raise ValueError(f"out has a writable array of shape {(*shape, 3)} for {name}, not of {array.shape}")
    if np.shares_memory(origins, directions):
        raise ValueError("the arrays of out for origins and directions share memory")
    return origins, directions


# Sums are written out, in one order, so that a ray does not depend on how many others are computed with it: products of
# matrices by BLAS may round differently at the ends of arrays.


def _product(left: NDArray[Any], right: NDArray[Any]) -> NDArray[Any]:
    """Of matrices (..., 3, 3)."""
    return np.asarray(left[..., :, 0, None] * right[..., None, 0, :] + left[..., :, 1, None] * right[..., None, 1, :]
                      + left[..., :, 2, None] * right[..., None, 2, :])


def _rotate(matrices: NDArray[Any], vectors: NDArray[Any], out: NDArray[Any],
            shift: Optional[NDArray[Any]] = None) -> None:
    """Writes matrices (columns, beams or 1, 3, 3) times vectors (beams, 3), plus shift (columns, beams or 1, 3)."""
    x, y, z = (np.ascontiguousarray(column) for column in vectors.T)
    for axis in range(3):
        row = matrices[..., axis, :]
        total = row[..., 0] * x
        total += row[..., 1] * y
        total += row[..., 2] * z
        if shift is not None:
            total += shift[..., axis]
        np.copyto(out[..., axis], total, casting="same_kind")
