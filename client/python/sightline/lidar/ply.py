"""Clouds as PLY files."""

from __future__ import annotations

from ._rows import File, opened, rows
from .cloud import PointCloud

_WORDS = {"<f4": "float", "<f8": "double", "<i4": "int"}


def write_ply(file: File, cloud: PointCloud, *, coordinates: str = "f4") -> None:
    """Writes binary PLY 1.0 with the properties x y z intensity ring time of its vertices. file: a path or an open
    binary file.
    coordinates: "f4" or "f8". Warnings: PrecisionWarning, float32 moves points by more than 0.001. Errors: ValueError,
    OSError."""
    table = rows(cloud, coordinates, "<i4")  # Open3D leaves out integers of 16 bits
    properties = [f"property {_WORDS[table.dtype[name].str]} {name}" for name in table.dtype.names or ()]
    header = "\n".join(("ply", "format binary_little_endian 1.0", f"element vertex {len(table)}", *properties,
                        "end_header", ""))
    with opened(file) as stream:
        stream.write(header.encode())
        stream.write(table.tobytes())
