"""The beams of a sensor: where each points, and when it is fired."""

from __future__ import annotations

import math
import operator
from typing import Any, Optional, Tuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._arrays import reals
from .sweep import Out, Sweep
from .trajectory import Trajectory

MOST_BEAMS = 65536     # a ring is a number of 16 bits
MOST_RAYS = 1 << 48    # whose numbers, and times the number of beams, stay exact


class BeamTable:
    """Beams of a sensor whose head turns about its z axis and fires all of them, a column, at equal intervals.

    elevations: degrees above the xy plane, (b). azimuths: degrees from the head's direction, counterclockwise seen from
    above, (b) or one number. times: seconds from the start of a column until the beam is fired, while the head goes on
    turning, (b) or one number.
    period: seconds of a revolution; math.inf: the head stands still. columns: of a revolution; or interval: seconds
    from a column to the next, where these do not divide the period. zero: the head's azimuth in degrees at column 0.
    clockwise: how it turns, seen from above. radius: how far from the axis, in the head's direction, beams begin, from
    where ranges count. ranges: the least and the greatest range that is measured. Lengths are in units of the scene.

    Errors: ValueError, TypeError: a number that is not finite or out of its range, columns of different lengths."""

    def __init__(self, elevations: ArrayLike, azimuths: ArrayLike = 0.0, times: ArrayLike = 0.0, *, period: float,
                 columns: Optional[int] = None, interval: Optional[float] = None, zero: float = 0.0,
                 clockwise: bool = True, radius: float = 0.0, ranges: "Tuple[float, float]" = (0.0, math.inf)):
        given = reals(elevations, "elevations")
        if given.ndim != 1 or not 1 <= len(given) <= MOST_BEAMS:
            raise ValueError(f"elevations have the shape (b), for 1 to {MOST_BEAMS} beams, not {given.shape}")
        self.elevations = _column("elevations", given, len(given), -90.0, 90.0)
        self.azimuths = _column("azimuths", azimuths, len(given), -360.0, 360.0)
        self.times = _column("times", times, len(given), 0.0, 3600.0)
        self.period = float(period)
        if not self.period > 0:
            raise ValueError(f"period is above 0, not {period}")
        self._columns_a_turn, self.interval = _columns(self.period, columns, interval)
        self.zero, self.radius, self.clockwise = float(zero), float(radius), bool(clockwise)
        if not math.isfinite(self.zero):
            raise ValueError(f"zero is finite, not {zero}")
        if not (math.isfinite(self.radius) and self.radius >= 0):
            raise ValueError(f"radius is finite and not below 0, as {radius} is")
        least, greatest = (float(bound) for bound in ranges)
        if not 0 <= least <= greatest or math.isinf(least):
            raise ValueError(f"ranges are a least one, not below 0, and a greatest one, not below that: not {ranges}")
        self.ranges = (least, greatest)
        turned = 0.0 * self.times if math.isinf(self.period) else self._sense * 360 * (self.times / self.period)
        # Both (b, 3), in the head's frame at the start of a column.
        self.directions = _units(self.elevations, self.azimuths + turned)
        self.origins = self.radius * _units(0 * turned, turned)

    @property
    def columns(self) -> int:
        """Of a revolution, as far as they are complete; 1 where the head stands still."""
        return max(1, math.floor(self._columns_a_turn * (1 + 1e-12)))

    @property
    def shape(self) -> "Tuple[int, int]":
        """(columns, beams) of a revolution."""
        return self.columns, len(self.elevations)

    def sweep(self, trajectory: Trajectory, *, first: int = 0, columns: Optional[int] = None, start: float = 0.0,
              out: Optional[Out] = None) -> Sweep:
        """The rays of columns from number `first` on, by default of a revolution, of a sensor that moves along a
        trajectory.

        start: the time of column 0. Each ray has the pose of its own time. Columns are counted on from revolution to
        revolution, and a ray is the same, bit by bit, in whatever sweep it is. out: arrays (columns, beams, 3) of
        float32 or float64 for origins and directions, such as those of Client.share_memory(); the sweep has its rays
        there, until another one is written over them. Errors: ValueError, TypeError: numbers out of range, arrays of
        another form, times that the trajectory does not have."""
        first, count = operator.index(first), operator.index(self.columns if columns is None else columns)
        if count < 0 or first < 0 or (first + count) * len(self.elevations) > MOST_RAYS:
            raise ValueError(f"columns are from 0 on, up to {MOST_RAYS} rays, not {count} columns from {first} on")
        if not math.isfinite(start):
            raise ValueError(f"start is finite, not {start}")
        return Sweep(self, trajectory, first, count, start, out)

    def heads(self, first: int, columns: int) -> NDArray[Any]:
        """(columns, 3, 3): sensor from head, for columns from number `first` on."""
        numbers = np.arange(first, first + columns, dtype="f8")
        a_turn = self._columns_a_turn
        turn = np.fmod(numbers, a_turn) / a_turn if math.isfinite(self.period) else 0 * numbers
        angle = np.radians(self.zero + self._sense * 360 * turn)
        c, s, o = np.cos(angle), np.sin(angle), 0 * angle
        return np.stack([np.stack(row, axis=-1) for row in ([c, -s, o], [s, c, o], [o, o, o + 1])], axis=-2)

    @property
    def _sense(self) -> int:
        return -1 if self.clockwise else 1


def _columns(period: float, columns: Optional[int], interval: Optional[float]) -> "Tuple[float, float]":
    """Columns of a revolution, and seconds from one to the next."""
    if (columns is None) == (interval is None):
        raise ValueError("pass either columns or interval")
    if interval is None:
        if columns != int(columns or 0) or not columns >= 1 or math.isinf(period):
            raise ValueError(f"columns divide a period that is finite, and are 1 or more: not {columns} of {period} s")
        return float(columns), period / columns
    if not (interval > 0 and math.isfinite(interval) and interval <= period):
        raise ValueError(f"interval is above 0 and not above the period, {period} s, as {interval} is")
    if math.isfinite(period) and period / interval > MOST_RAYS:
        raise ValueError(f"a revolution has at most {MOST_RAYS} columns, not {period} s in steps of {interval} s")
    return (period / interval if math.isfinite(period) else 1.0), float(interval)


def _column(name: str, values: ArrayLike, count: int, least: float, greatest: float) -> NDArray[Any]:
    array = reals(values, name).astype("f8")
    if array.ndim == 0:
        array = np.full(count, array)
    if array.shape != (count,):
        raise ValueError(f"{name} have a row for each of {count} beams, not the shape {array.shape}")
    wrong = np.flatnonzero(~((array >= least) & (array <= greatest)))
    if wrong.size:
        raise ValueError(f"{name} are from {least:g} to {greatest:g}, but beam {int(wrong[0])} has {array[wrong[0]]}")
    return array


def _units(elevations: NDArray[Any], azimuths: NDArray[Any]) -> NDArray[Any]:
    """(b, 3), of angles in degrees."""
    up, around = np.radians(elevations), np.radians(azimuths)
    return np.stack([np.cos(up) * np.cos(around), np.cos(up) * np.sin(around), np.sin(up)], axis=-1)
