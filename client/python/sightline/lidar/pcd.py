"""Clouds as PCD files, which the Point Cloud Library and Open3D read."""

from __future__ import annotations

import numpy as np

from ._rows import File, opened, rows
from .cloud import PointCloud

_DIGITS = {4: "%.9g", 8: "%.17g"}  # with which a number reads back as it was, by its size


def write_pcd(file: File, cloud: PointCloud, *, binary: bool = True, coordinates: str = "f4") -> None:
    """Writes PCD 0.7 with the fields x y z intensity ring time; as text with `binary=False`, which reads back as the
    same numbers. file: a path or an open binary file. coordinates: "f4", which all programs read, or "f8". Warnings:
    PrecisionWarning, float32 moves points by more than 0.001. Errors: ValueError, OSError."""
    table = rows(cloud, coordinates, "<u2")
    kinds = [table.dtype[name] for name in table.dtype.names or ()]
    header = "\n".join(("# .PCD v0.7 - Point Cloud Data file format", "VERSION 0.7",
                        f"FIELDS {' '.join(table.dtype.names or ())}",
                        f"SIZE {' '.join(str(kind.itemsize) for kind in kinds)}",
                        f"TYPE {' '.join('U' if kind.kind == 'u' else 'F' for kind in kinds)}",
                        f"COUNT {' '.join('1' for _ in kinds)}", f"WIDTH {len(table)}", "HEIGHT 1",
                        "VIEWPOINT 0 0 0 1 0 0 0", f"POINTS {len(table)}",
                        f"DATA {'binary' if binary else 'ascii'}", ""))
    with opened(file) as stream:
        stream.write(header.encode())
        if binary:
            stream.write(table.tobytes())
        else:
            np.savetxt(stream, table, ["%d" if kind.kind == "u" else _DIGITS[kind.itemsize] for kind in kinds])
