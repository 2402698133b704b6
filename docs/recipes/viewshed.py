#!/usr/bin/python3
"""A viewshed: which cells of a height raster are seen from a point above it, written as a raster and as a picture."""

from typing import Any

import numpy as np
import sightline
from numpy.typing import NDArray

Array = NDArray[Any]

EYE_HEIGHT = 1.7     # metres above the ground
TARGET_HEIGHT = 0.1  # of what is looked for in each cell


def hills(rows: int = 200, columns: int = 300, cell: float = 10.0, seed: int = 4) -> Array:
    """A raster of heights (rows, columns) with cells of so many metres: a sum of waves."""
    rng = np.random.default_rng(seed)
    y, x = cell * np.mgrid[:rows, :columns]
    heights = np.zeros((rows, columns))
    for _ in range(12):
        direction, phase, length = rng.uniform(0, 2 * np.pi), rng.uniform(0, 2 * np.pi), rng.uniform(300, 1500)
        heights += length / 50 * np.sin(2 * np.pi * (x * np.cos(direction) + y * np.sin(direction)) / length + phase)
    return heights


def terrain(heights: Array, cell: float) -> tuple[Array, Array]:
    """The raster as a mesh: a vertex for each height, two triangles for each four of them."""
    rows, columns = heights.shape
    y, x = cell * np.mgrid[:rows, :columns]
    vertices = np.stack([x, y, heights], axis=-1).reshape(-1, 3)
    number = np.arange(rows * columns).reshape(rows, columns)
    a, b, c, d = number[:-1, :-1], number[:-1, 1:], number[1:, :-1], number[1:, 1:]
    faces = np.concatenate([np.stack([a, b, d], axis=-1).reshape(-1, 3), np.stack([a, d, c], axis=-1).reshape(-1, 3)])
    return vertices, faces


def viewshed(scene: sightline.Scene, heights: Array, cell: float, row: int, column: int) -> Array:
    """bool (rows, columns): whether each cell is seen by an eye above the cell (row, column)."""
    y, x = cell * np.mgrid[:heights.shape[0], :heights.shape[1]]
    targets = np.stack([x, y, heights + TARGET_HEIGHT], axis=-1)
    eye = [cell * column, cell * row, heights[row, column] + EYE_HEIGHT]
    return ~scene.cast(origins=eye, directions=targets - eye, tmax=1.0, kind="any").hit


def main() -> None:
    cell = 10.0
    heights = hills(cell=cell)
    with sightline.serve() as server:
        scene = server.client.import_arrays("hills", *terrain(heights, cell), up_axis="z", meters_per_unit=1)
        row, column = map(int, np.unravel_index(heights.argmax(), heights.shape))
        seen = viewshed(scene, heights, cell, row, column)
    np.save("viewshed.npy", seen)
    with open("viewshed.pgm", "wb") as file:  # seen cells are white; image viewers and GIS programs read it
        file.write(b"P5 %d %d 255\n" % (seen.shape[1], seen.shape[0]) + (255 * seen).astype("u1").tobytes())
    print(f"viewshed.pgm: {seen.mean():.1%} of {seen.size * cell ** 2 / 1e6:.1f} square km are seen from the summit")


if __name__ == "__main__":
    main()
