"""Points that a sensor has measured, as columns."""

from __future__ import annotations

import dataclasses
from typing import Any, Iterable

import numpy as np
from numpy.typing import NDArray

_TYPES = {"position": "f8", "intensity": "f4", "ring": "u2", "time": "f8", "range": "f8", "ray": "i8"}


@dataclasses.dataclass(frozen=True, eq=False)
class PointCloud:
    """position: float64 (n, 3). intensity: float32 (n), 1 for a white surface that faces the sensor. ring: uint16 (n),
    the row of the beam in its table. time: float64 (n), seconds, when the beam was fired. range: float64 (n), as
    measured. ray: int64 (n), the index of the flattened ray in its sweep, by which other columns of the hits are found:
    hits.node.reshape(-1)[cloud.ray]. Errors: ValueError, columns of different lengths, positions or times not
    finite."""

    position: NDArray[Any]
    intensity: NDArray[Any]
    ring: NDArray[Any]
    time: NDArray[Any]
    range: NDArray[Any]
    ray: NDArray[Any]

    def __post_init__(self) -> None:
        count = len(np.atleast_1d(np.asarray(self.position)))
        for name, kind in _TYPES.items():
            given = np.asarray(getattr(self, name))
            column = given if given.dtype == kind else _converted(name, given, kind)
            shape = (count, 3) if name == "position" else (count,)
            if column.shape != shape:
                raise ValueError(f"{name} has the shape {shape}, not {column.shape}")
            if name in ("position", "intensity", "time") and not np.isfinite(column).all():
                raise ValueError(f"{name} of point {int(np.argwhere(~np.isfinite(column))[0][0])} is not finite")
            object.__setattr__(self, name, column)

    def __len__(self) -> int:
        return len(self.position)

    def __repr__(self) -> str:
        return f"<point cloud of {len(self)} points>"

    @staticmethod
    def joined(clouds: "Iterable[PointCloud]") -> "PointCloud":
        """The points of several clouds, one after the other; `ray` stays that of each sweep."""
        parts = list(clouds)
        columns = {name: np.concatenate([np.empty((0, 3) if name == "position" else 0, kind)]
                                        + [getattr(part, name) for part in parts]) for name, kind in _TYPES.items()}
        return PointCloud(**columns)


def _converted(name: str, given: NDArray[Any], kind: str) -> NDArray[Any]:
    """A column in its type. TypeError: not numbers. ValueError: numbers that the type does not hold."""
    if given.dtype.kind not in "fiu":
        raise TypeError(f"{name} has numbers, not {given.dtype}")
    with np.errstate(over="ignore", invalid="ignore"):
        column = given.astype(kind)
    if np.dtype(kind).kind != "f" and not np.array_equal(column.astype("f8"), given.astype("f8")):
        raise ValueError(f"{name} has integers that {np.dtype(kind)} holds")
    return column
