"""Pictures of scenes by ray queries: closest hits shaded by their normals, as PNG."""

from __future__ import annotations

import pathlib
import struct
import zlib
from typing import Any, Callable, Tuple

import numpy as np

from ._query import GEOMETRY
from ._types import Bytes, Doubles, Path, Words
from .hits import Hits
from .pinhole import Pinhole
from .scene_info import SceneInfo

_FROM = {"y": (1.0, 0.7, 0.8), "z": (0.8, -1.0, 0.7)}  # where the default eye is, seen from the middle
_UP = {"y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}
_MARGIN = 1.05
_BACKGROUND = 255
_DARKEST = 0.35  # brightness of a surface seen edge-on


class Picture:
    """pixels: uint8 (height, width, 3). hits: the Hits of its rays, of shape (height, width)."""

    def __init__(self, pixels: Bytes, hits: Hits):
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

    def save(self, file: Path) -> None:
        """Writes a file, whose name ends in .png."""
        path = pathlib.Path(file)
        if path.suffix.lower() != ".png":
            raise ValueError(f"pictures are written as .png, not {path.suffix or path.name}")
        path.write_bytes(self.png())


def _chunk(kind: bytes, data: bytes) -> bytes:
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


def _default_view(info: SceneInfo, tangents: "Tuple[float, float]") -> "Tuple[Doubles, Doubles]":
    """Eye and target so that the sphere around the scene's box is inside the picture."""
    low, high = np.array([[-1.0] * 3, [1.0] * 3]) if info.bounds is None else info.bounds
    radius = np.linalg.norm(high - low) / 2 or 1.0
    sine = min(np.sin(np.arctan(t)) for t in tangents)
    middle, direction = (low + high) / 2, np.array(_FROM[info.up_axis or "y"])
    return middle + direction / np.linalg.norm(direction) * radius / sine * _MARGIN, middle


def render(info: SceneInfo, cast: "Callable[..., Any]", size: Any, eye: Any, at: Any, up: Any, fov: float, fields: Words,
           **options: Any) -> Picture:
    """See Scene.render."""
    width, height = (int(n) for n in size)
    if width < 1 or height < 1 or not 0 < fov < 180:
        raise ValueError("a picture has at least one pixel, and fov is between 0 and 180 degrees")
    half = np.tan(np.radians(fov) / 2)
    default_eye, default_at = _default_view(info, (half, half * width / height))
    target = default_at if at is None else np.asarray(at, "f8")
    origin = default_eye - default_at + target if eye is None else np.asarray(eye, "f8")
    camera = Pinhole.looking_at(origin, target, _UP[info.up_axis or "y"] if up is None else up, width, height, fov)
    named = [fields] if isinstance(fields, str) else list(fields)
    hits = cast(camera, fields=(*GEOMETRY, *named), **options)
    forward = target - origin
    return Picture(_shade(hits, forward / np.linalg.norm(forward)), hits)


def _shade(hits: Hits, forward: Doubles) -> Bytes:
    """Each axis has a colour; what faces the eye is bright."""
    normal = hits.normal.astype("f8")
    facing = normal @ forward
    colour = 0.5 + 0.5 * np.where(facing[..., None] > 0, -normal, normal)
    light = _DARKEST + (1 - _DARKEST) * np.abs(facing)
    pixels = np.full((*hits.shape, 3), _BACKGROUND, np.uint8)
    seen = hits.hit
    pixels[seen] = (255 * colour * light[..., None])[seen].astype(np.uint8)
    return pixels
