"""Rays of a camera, which the server makes."""

from __future__ import annotations

import dataclasses
from typing import Any, Optional, Sequence, Tuple

import numpy as np

from . import _proto
from ._generated import Generated, Triple, generator, size, vector
from ._types import Doubles

_MOST_SAMPLES = 64


@dataclasses.dataclass(frozen=True)
class Pinhole(Generated):
    """The rays of a picture, for Scene.cast, of shape (height, width): unit directions from `eye` through the middles
    of pixels.

    eye, corner, across, down: (3), finite: the vector from the eye to the top left corner of the picture plane, and
    those along its top and its left edge. width, height: pixels, at most 1,048,576. samples: (k, 2), places in a pixel
    from its top left corner, 0 to 1, at most 64, which make the shape (height, width, k). tmin, tmax, mask: every
    ray's. Errors: TypeError, ValueError.
    """

    eye: Triple
    corner: Triple
    across: Triple
    down: Triple
    width: int
    height: int
    samples: Optional[Sequence[Sequence[float]]] = None
    tmin: Optional[float] = None
    tmax: Optional[float] = None
    mask: Optional[int] = None

    def __post_init__(self) -> None:
        for name in ("eye", "corner", "across", "down"):
            object.__setattr__(self, name, vector(getattr(self, name), name))
        for name in ("width", "height"):
            size(getattr(self, name), name)
        if self.samples is not None:
            object.__setattr__(self, "samples", _places(self.samples))
        self.message()

    @classmethod
    def looking_at(cls, eye: Any, at: Any, up: Any, width: int, height: int, fov: float = 40.0,
                   samples: "Optional[Sequence[Sequence[float]]]" = None) -> "Pinhole":
        """A camera at `eye` that looks at `at`. fov: degrees from the bottom of the picture to its top."""
        if width < 1 or height < 1 or not 0 < fov < 180:
            raise ValueError("a picture has at least one pixel, and fov is between 0 and 180 degrees")
        position = np.array(vector(eye, "eye"))
        forward, upward = _unit(np.array(vector(at, "at")) - position, "at - eye"), _unit(up, "up")
        if np.linalg.norm(np.cross(forward, upward)) < 1e-6:
            upward = np.roll(upward, 1)
        right = _unit(np.cross(forward, upward), "up")
        upward, half = np.cross(right, forward), np.tan(np.radians(fov) / 2)
        half_width = half * width / height
        corner = forward + upward * half - right * half_width
        return cls(vector(position, "eye"), vector(corner, "corner"), vector(2 * half_width * right, "across"),
                   vector(-2 * half * upward, "down"), width, height, samples)

    @property
    def shape(self) -> Tuple[int, ...]:
        """(height, width), or (height, width, k)."""
        return (self.height, self.width) if self.samples is None else (self.height, self.width, len(self.samples))

    @property
    def dims(self) -> Tuple[str, ...]:
        return ("row", "column") if self.samples is None else ("row", "column", "sample")

    def message(self) -> Any:
        """A message RayGenerator of all rays."""
        places = np.array(self.samples or ()).reshape(-1)
        picture = _proto.Pinhole(eye=self.eye, corner=self.corner, across=self.across, down=self.down, width=self.width,
                                 height=self.height, samples=places)
        return generator(self.tmin, self.tmax, self.mask, pinhole=picture)


def _places(value: Any) -> "Tuple[Tuple[float, float], ...]":
    places = np.asarray(value, "f8")
    if places.ndim != 2 or places.shape[1] != 2 or not 1 <= len(places) <= _MOST_SAMPLES:
        raise ValueError(f"samples have the shape (k, 2), with k from 1 to {_MOST_SAMPLES}, not {places.shape}")
    if not ((places >= 0) & (places <= 1)).all():
        raise ValueError("samples are places in a pixel, from 0 to 1")
    return tuple((x, y) for x, y in places.tolist())


def _unit(value: Any, name: str) -> Doubles:
    array: Doubles = np.asarray(value, "f8")
    length = np.linalg.norm(array)
    if array.shape != (3,) or not np.isfinite(length) or length == 0:
        raise ValueError(f"{name} cannot be {value}")
    unit: Doubles = array / length
    return unit
