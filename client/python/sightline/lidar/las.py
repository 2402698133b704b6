"""Clouds as LAS files, the exchange format of the ASPRS: version 1.4, point data record format 6 (specification
1.4-R15)."""

from __future__ import annotations

import math
import struct
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import __version__
from ._rows import File, opened
from .cloud import PointCloud

_HEADER = struct.Struct("<4sHH16sBB32s32sHHHIIBHI5I3d3d6dQQIQ15Q")
_VLR = struct.Struct("<H16sHH32s")
_EXTRA = struct.Struct("<2xBB32s4x120x32s")  # describes one extra column; no limits, scale or offset
_UINT16 = 3     # a type of an extra column
_WKT = 1 << 4   # global encoding: coordinate systems are in WKT, as format 6 demands
_MOST = (1 << 31) - 1
_MOST_WKT = 65535 - 1
_POINT = np.dtype([("xyz", "<i4", 3), ("intensity", "<u2"), ("returns", "u1"), ("flags", "u1"), ("class", "u1"),
                   ("user", "u1"), ("angle", "<i2"), ("source", "<u2"), ("time", "<f8"), ("ring", "<u2")])


def write_las(file: File, cloud: PointCloud, *, scale: float = 0.001, wkt: str = "") -> None:
    """Writes LAS 1.4 of point format 6, with the ring as an extra column of that name (16 bits).

    Coordinates are integers, of `scale` units each, about the middle of the points; intensities of 1 and above are
    65535, 0 is 0; times are as they are, as the format's GPS time. Each point is the single return of its pulse. wkt:
    the coordinate reference system. The same cloud gives the same bytes: the date of the file is not set. file: a path
    or an open binary file. Errors: ValueError, points that lie too far apart for the scale, a scale or text that is not
    right; OSError."""
    if not (scale > 0 and math.isfinite(scale)):
        raise ValueError(f"scale is finite and above 0, not {scale}")
    text = wkt.encode()
    if len(text) > _MOST_WKT or "\0" in wkt:
        raise ValueError(f"wkt is a text of at most {_MOST_WKT} bytes without zeros, not of {len(text)}")
    position = cloud.position
    low = position.min(axis=0, initial=np.inf) if len(cloud) else np.zeros(3)
    high = position.max(axis=0, initial=-np.inf) if len(cloud) else np.zeros(3)
    offset = np.rint(low / 2 + high / 2)
    steps = np.rint((position - offset) / scale)
    if np.abs(steps).max(initial=0) > _MOST or not np.isfinite(steps).all():
        raise ValueError(f"points span {float((high - low).max()):.6g} units, and steps of {scale:g} reach "
                         f"{2 * _MOST * scale:.6g}: pass a larger scale")
    table = np.zeros(len(cloud), _POINT)
    table["xyz"] = steps
    table["intensity"] = np.rint(np.clip(cloud.intensity.astype("f8"), 0, 1) * 65535)
    table["returns"] = 1 | 1 << 4  # the first of one
    table["time"], table["ring"] = cloud.time, cloud.ring
    written = table["xyz"].astype("f8") * scale + offset
    bounds = ([written.min(axis=0), written.max(axis=0)] if len(cloud) else [np.zeros(3)] * 2)
    records = _record("LASF_Spec", 4, _EXTRA.pack(_UINT16, 0, b"ring", b"row of the beam in its table"))
    if text:
        records += _record("LASF_Projection", 2112, text + b"\0")
    with opened(file) as stream:
        stream.write(_header(len(cloud), 1 + bool(text), len(records), scale, offset, bounds[0], bounds[1]))
        stream.write(records)
        stream.write(table.tobytes())


def _record(user: str, number: int, content: bytes) -> bytes:
    """A variable length record."""
    return _VLR.pack(0, user.encode(), number, len(content), b"") + content


def _header(count: int, records: int, record_bytes: int, scale: float, offset: NDArray[Any], low: NDArray[Any],
            high: NDArray[Any]) -> bytes:
    extremes = [value for pair in zip(high.tolist(), low.tolist()) for value in pair]  # greatest x, least x, ...
    by_return = [count] + [0] * 14
    return _HEADER.pack(b"LASF", 0, _WKT, b"", 1, 4, b"Sightline", f"sightline {__version__}".encode(), 0, 0,
                        _HEADER.size, _HEADER.size + record_bytes, records, 6, _POINT.itemsize, 0, *[0] * 5,
                        *[scale] * 3, *offset.tolist(), *extremes, 0, 0, 0, count, *by_return)
