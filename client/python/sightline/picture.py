"""Pictures of scenes by ray queries: closest hits shaded by their normals, as PNG."""

from __future__ import annotations

import os
import pathlib
import struct
import zlib
from typing import TYPE_CHECKING, Any, Iterable, Optional, Tuple

import numpy as np

from . import _caster, _proto, _query
from .hits import Hits

if TYPE_CHECKING:
    from .scene import Scene

_FROM = {"y": (1.0, 0.7, 0.8), "z": (0.8, -1.0, 0.7)}  # where the default eye is, seen from the middle
_UP = {"y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}
_MARGIN = 1.05
_BACKGROUND = 255
_DARKEST = 0.35  # brightness of a surface seen edge-on


class Picture:
    """pixels: uint8 (height, width, 3). hits: the Hits of its rays, of shape (height, width)."""

    def __init__(self, pixels: np.ndarray, hits: Hits):
        self.pixels, self.hits = pixels, hits

    def png(self) -> bytes:
        """The picture as a file of PNG."""
        height, width, _ = self.pixels.shape
        rows = np.zeros((height, 1 + 3 * width), np.uint8)  # each row begins with its filter: none
        rows[:, 1:] = self.pixels.reshape(height, -1)
        header = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
        return b"".join((b"\x89PNG\r\n\x1a\n", _chunk(b"IHDR", header), _chunk(b"IDAT", zlib.compress(rows.tobytes())),
                         _chunk(b"IEND", b"")))

    _repr_png_ = png

    def save(self, file: "str | os.PathLike[str]") -> None:
        """Writes a file, whose name ends in .png."""
        path = pathlib.Path(file)
        if path.suffix.lower() != ".png":
            raise ValueError(f"pictures are written as .png, not {path.suffix or path.name}")
        path.write_bytes(self.png())


def _chunk(kind: bytes, data: bytes) -> bytes:
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


def _unit(vector: Any, name: str) -> np.ndarray:
    array = np.asarray(vector, "f8")
    length = np.linalg.norm(array)
    if array.shape != (3,) or not np.isfinite(length) or length == 0:
        raise ValueError(f"{name} cannot be {vector}")
    return array / length


def _default_view(info: Any, tangents: "Tuple[float, float]") -> "Tuple[np.ndarray, np.ndarray]":
    """Eye and target so that the sphere around the scene's box is inside the picture."""
    low, high = info.bounds if info.bounds is not None else (np.full(3, -1.0), np.full(3, 1.0))
    radius = np.linalg.norm(high - low) / 2 or 1.0
    sine = min(np.sin(np.arctan(t)) for t in tangents)
    middle = (low + high) / 2
    return middle + _unit(_FROM[info.up_axis or "y"], "eye") * radius / sine * _MARGIN, middle


def render(scene: "Scene", size: Any, eye: Any = None, at: Any = None, up: Any = None, fov: float = 40.0,
           fields: Iterable[str] = (), at_least: Optional[str] = None, revision: Optional[int] = None, timeout: Optional[float] = None) -> Picture:
    """See Scene.render."""
    width, height = (int(n) for n in size)
    if width < 1 or height < 1 or not 0 < fov < 180:
        raise ValueError("a picture has at least one pixel, and fov is between 0 and 180 degrees")
    info = scene.info()
    half = np.tan(np.radians(fov) / 2)
    half_width = half * width / height
    default_eye, default_at = _default_view(info, (half, half_width))
    target = default_at if at is None else np.asarray(at, "f8")
    origin = default_eye - default_at + target if eye is None else np.asarray(eye, "f8")
    forward = _unit(target - origin, "at - eye")
    upward = _unit(_UP[info.up_axis or "y"] if up is None else up, "up")
    if np.linalg.norm(np.cross(forward, upward)) < 1e-6:
        upward = np.roll(upward, 1)
    right = _unit(np.cross(forward, upward), "up")
    upward = np.cross(right, forward)
    pinhole = _proto.Pinhole(eye=origin, corner=forward + upward * half - right * half_width,
                             across=2 * half_width * right, down=-2 * half * upward, width=width, height=height)
    query = _query.describe(_query.RAYS, scene.name, "closest", (*_query.GEOMETRY, *fields), None, None, 0, (), 0, at_least,
                            revision)
    hits = _caster.cast_generated(scene._connection, query, _proto.RayGenerator(pinhole=pinhole), (height, width),
                                  timeout, scene._names)
    return Picture(_shade(hits, forward), hits)


def _shade(hits: Hits, forward: np.ndarray) -> np.ndarray:
    """Each axis has a colour; what faces the eye is bright."""
    normal = hits.normal.astype("f8")
    facing = normal @ forward
    colour = 0.5 + 0.5 * np.where(facing[..., None] > 0, -normal, normal)
    light = _DARKEST + (1 - _DARKEST) * np.abs(facing)
    pixels = np.full((*hits.shape, 3), _BACKGROUND, np.uint8)
    seen = hits.hit
    pixels[seen] = (255 * colour * light[..., None])[seen].astype(np.uint8)
    return pixels
