"""Where a sensor is at any time: poses, with positions interpolated linearly between them and rotations along great
arcs."""

from __future__ import annotations

from typing import Any, Tuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..updates import as_matrix

_MOST_SKEW = 1e-6  # of a matrix that counts as a rotation: how far its columns may be from unit and perpendicular


class Trajectory:
    """Poses of a sensor, scene from sensor, at given times.

    times: seconds, increasing, (n). poses: (n, 3, 4) or (n, 4, 4), rotations and positions. Between two times the
    position goes along a line and the rotation about one axis, by the shorter way, each at a constant speed. A single
    pose holds at all times. Errors: ValueError, TypeError (times or poses of another form)."""

    def __init__(self, times: ArrayLike, poses: ArrayLike):
        matrices = as_matrix(poses)
        if matrices.ndim == 2:
            matrices = matrices[None]
        self.times = _times(times, len(matrices))
        if matrices.ndim != 3 or not np.isfinite(matrices).all():
            raise ValueError(f"poses are finite and have the shape (n, 3, 4) or (n, 4, 4), not {np.shape(poses)}")
        self.positions = matrices[:, :, 3].copy()
        self._quaternions = _continuous(_quaternions(matrices[:, :, :3]))
        self._angles = _angles(self._quaternions)

    @classmethod
    def from_quaternions(cls, times: ArrayLike, positions: ArrayLike, quaternions: ArrayLike) -> "Trajectory":
        """From positions (n, 3) and rotations as quaternions (n, 4), x y z w, of any length but zero."""
        points, turns = np.asarray(positions, "f8"), np.asarray(quaternions, "f8")
        if points.ndim != 2 or points.shape[1] != 3 or turns.shape != (len(points), 4):
            raise ValueError("positions and quaternions have the shapes (n, 3) and (n, 4), not "
                             f"{points.shape} and {turns.shape}")
        length = np.linalg.norm(turns, axis=1, keepdims=True)
        wrong = np.flatnonzero(~(np.isfinite(length) & (length > 0)))
        if wrong.size:
            raise ValueError(f"quaternion {int(wrong[0])} is zero or not finite")
        return cls(times, np.concatenate([rotations(turns / length), points[:, :, None]], axis=2))

    def at(self, times: ArrayLike) -> "Tuple[NDArray[Any], NDArray[Any]]":
        """Rotations (..., 3, 3) and positions (..., 3) at times (...). Errors: ValueError, a time before the first pose
        or after the last one, where there are several."""
        asked = np.asarray(times, "f8")
        flat = np.ascontiguousarray(asked.reshape(-1))
        if len(self.times) == 1:
            turn = rotations(self._quaternions)[0]
            return np.broadcast_to(turn, (*asked.shape, 3, 3)), np.broadcast_to(self.positions[0], (*asked.shape, 3))
        outside = ~((flat >= self.times[0]) & (flat <= self.times[-1]))
        if outside.any():
            raise ValueError(f"the trajectory is from {self.times[0]:.9g} to {self.times[-1]:.9g} s, and has no pose "
                             f"at {flat[outside][0]:.9g} s")
        before = np.clip(np.searchsorted(self.times, flat, "right") - 1, 0, len(self.times) - 2)
        share = (flat - self.times[before]) / (self.times[before + 1] - self.times[before])
        turns = rotations(self._between(before, share))
        line = self.positions[before + 1] - self.positions[before]
        points = self.positions[before] + share[:, None] * line
        return turns.reshape(*asked.shape, 3, 3), points.reshape(*asked.shape, 3)

    def _between(self, before: NDArray[Any], share: NDArray[Any]) -> NDArray[Any]:
        """Unit quaternions at shares of the ways from poses to those that follow them."""
        angle = self._angles[before]
        is_small = angle < 1e-9  # sines would be divided by nearly nothing, and a line is as good
        scale = np.where(is_small, 1.0, np.sin(angle))
        first = np.where(is_small, 1 - share, np.sin((1 - share) * angle)) / scale
        second = np.where(is_small, share, np.sin(share * angle)) / scale
        return np.asarray(first[:, None] * self._quaternions[before] + second[:, None] * self._quaternions[before + 1])


def rotations(quaternions: NDArray[Any]) -> NDArray[Any]:
    """Matrices (n, 3, 3) of unit quaternions (n, 4), x y z w."""
    x, y, z, w = (np.ascontiguousarray(column) for column in quaternions.T)
    rows = [[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def _times(times: ArrayLike, count: int) -> NDArray[Any]:
    found: Any = np.asarray(times, "f8")
    if found.shape != (count,) or not count:
        raise ValueError(f"each of one pose or more has a time: {count} poses, and times of shape {found.shape}")
    if not np.isfinite(found).all():
        raise ValueError(f"time {int(np.argmin(np.isfinite(found)))} of the trajectory is not finite")
    late = np.flatnonzero(np.diff(found) <= 0)
    if late.size:
        at = int(late[0])
        raise ValueError(f"times increase, but time {at + 1} is {found[at + 1]:.9g} after {found[at]:.9g}")
    return np.array(found)


def _quaternions(matrices: NDArray[Any]) -> NDArray[Any]:
    """Unit quaternions (n, 4), x y z w, of rotation matrices (n, 3, 3). Errors: ValueError, one is no rotation."""
    skew = np.abs(matrices.transpose(0, 2, 1) @ matrices - np.eye(3)).max(axis=(1, 2))
    is_mirrored = np.linalg.det(matrices) < 0
    wrong = np.flatnonzero((skew > _MOST_SKEW) | is_mirrored)
    if wrong.size:
        at = int(wrong[0])
        what = "mirrors" if is_mirrored[at] else f"is {skew[at]:.3g} away from a rotation, and may be {_MOST_SKEW:g}"
        raise ValueError(f"pose {at} is no rotation and a position: its matrix {what}")
    m = matrices
    trace = m[:, 0, 0] + m[:, 1, 1] + m[:, 2, 2]
    xx, yy, zz, ww = *(1 + 2 * m[:, axis, axis] - trace for axis in range(3)), 1 + trace
    # Four times the products of each component with each other one; the row of the largest is divided by its own root.
    yz, zx, xy = m[:, 2, 1] + m[:, 1, 2], m[:, 0, 2] + m[:, 2, 0], m[:, 1, 0] + m[:, 0, 1]
    xw, yw, zw = m[:, 2, 1] - m[:, 1, 2], m[:, 0, 2] - m[:, 2, 0], m[:, 1, 0] - m[:, 0, 1]
    products = np.array([[xx, xy, zx, xw], [xy, yy, yz, yw], [zx, yz, zz, zw], [xw, yw, zw, ww]])
    largest = np.array([xx, yy, zz, ww]).argmax(axis=0)
    found = products[largest, :, np.arange(len(m))]
    return np.array(found / np.linalg.norm(found, axis=1, keepdims=True))


def _continuous(quaternions: NDArray[Any]) -> NDArray[Any]:
    """The same rotations, with signs by which each is near the one before it."""
    against = (quaternions[1:] * quaternions[:-1]).sum(axis=1) < 0
    signs = np.where(np.concatenate([[False], np.logical_xor.accumulate(against)]), -1.0, 1.0)
    return np.array(quaternions * signs[:, None])


def _angles(quaternions: NDArray[Any]) -> NDArray[Any]:
    """(n - 1): angles between neighbours, as vectors of four dimensions; exact for small ones, too."""
    apart = np.linalg.norm(quaternions[1:] - quaternions[:-1], axis=1)
    together = np.linalg.norm(quaternions[1:] + quaternions[:-1], axis=1)
    return np.asarray(2 * np.arctan2(apart, together))
