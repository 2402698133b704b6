#!/usr/bin/python3
"""How far a scanned cloud deviates from the part it was made after: signed distances, a histogram, a coloured PLY.

Positive is too much material, negative is too little.
"""

from typing import Any, BinaryIO

import numpy as np
import sightline
from numpy.typing import NDArray

Array = NDArray[Any]

SIZE = np.array([100.0, 60.0, 20.0])  # of the part, millimetres
RANGE = 0.5                           # of colours and of the histogram


def part() -> tuple[Array, Array]:
    """A block: vertices (8, 3) and faces (12, 3)."""
    corners = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)])
    faces = np.array([[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1],
                      [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]])
    return corners * SIZE, faces


def error_at(x: Array, y: Array) -> Array:
    """What is wrong with the made part's top at (x, y): a dent and a slant."""
    dent = -0.4 * np.exp(-((x - 30) ** 2 + (y - 25) ** 2) / (2 * 6.0 ** 2))
    return np.asarray(dent + 0.2 * (x / SIZE[0] - 0.5))


def scan(count: int, seed: int = 1) -> Array:
    """Points (n, 3) that a scanner sees of the made part's top."""
    x, y = np.random.default_rng(seed).uniform([1, 1], SIZE[:2] - 1, (count, 2)).T
    return np.stack([x, y, SIZE[2] + error_at(x, y)], axis=-1)


def deviations(scene: sightline.Scene, points: Array) -> Array:
    """Millimetres (n): distances outward from the part."""
    return scene.closest(points, fields=("signed",)).signed


def write_ply(file: BinaryIO, points: Array, millimetres: Array) -> None:
    """A cloud, red where there is too much, blue where there is too little, white where it is right."""
    share = np.clip(millimetres / RANGE, -1, 1)[:, None]
    colors = np.where(share > 0, 1 - share * [0, 1, 1], 1 + share * [1, 1, 0])
    rows = np.zeros(len(points), [("xyz", "<f4", 3), ("rgb", "u1", 3)])
    rows["xyz"], rows["rgb"] = points, np.round(255 * colors)
    header = ["ply", "format binary_little_endian 1.0", f"element vertex {len(points)}",
              *(f"property float {name}" for name in "xyz"),
              *(f"property uchar {name}" for name in ("red", "green", "blue")), "end_header", ""]
    file.write("\n".join(header).encode() + rows.tobytes())


def main() -> None:
    points = scan(50_000)
    with sightline.serve() as server:
        millimetres = deviations(server.client.import_arrays("part", *part(), meters_per_unit=0.001), points)
    counts, edges = np.histogram(millimetres, bins=10, range=(-RANGE, RANGE))
    for count, low, high in zip(counts, edges, edges[1:]):
        print(f"{low:+.1f} to {high:+.1f} mm: {count:6d} {'#' * (60 * count // counts.max())}")
    with open("deviations.ply", "wb") as file:
        write_ply(file, points, millimetres)
    print(f"deviations.ply: {len(points)} points, from {millimetres.min():+.3f} to {millimetres.max():+.3f} mm")


if __name__ == "__main__":
    main()
