#!/usr/bin/python3
"""A slice through a closed mesh: the signed distances of a grid of points, and the outline where they change their sign.

The outline is found by marching squares: between two grid points, one inside and one outside, it is where a straight line
between their distances is 0.
"""

from typing import Any

import numpy as np
import sightline
from numpy.typing import NDArray

Array = NDArray[Any]


def ball(radius: float, rings: int = 60, parts: int = 120) -> tuple[Array, Array]:
    """A closed mesh around the origin: vertices and faces, outside counterclockwise."""
    polar, turn = np.meshgrid(np.pi * np.arange(1, rings) / rings, 2 * np.pi * np.arange(parts) / parts, indexing="ij")
    belt = np.stack([np.sin(polar) * np.cos(turn), np.sin(polar) * np.sin(turn), np.cos(polar)], axis=-1).reshape(-1, 3)
    vertices = radius * np.concatenate([belt, [[0, 0, 1], [0, 0, -1]]])
    top, bottom = len(belt), len(belt) + 1
    ring, part = np.meshgrid(np.arange(rings - 2), np.arange(parts), indexing="ij")
    a, b = (ring * parts + part).ravel(), (ring * parts + (part + 1) % parts).ravel()
    first, after = np.arange(parts), (np.arange(parts) + 1) % parts
    last = (rings - 2) * parts
    faces = [(a, a + parts, b + parts), (a, b + parts, b), (np.full(parts, top), first, after),
             (np.full(parts, bottom), last + after, last + first)]
    return vertices, np.concatenate([np.stack(three, axis=-1) for three in faces])


def slice_of(scene: sightline.Scene, grid: sightline.PointGrid) -> Array:
    """The signed distances (rows, columns) of a sightline.PointGrid, negative inside."""
    return scene.closest(grid, fields=("signed",)).signed


def outline(signed: Array) -> Array:
    """Segments (n, 2, 2) where distances (rows, columns) are 0, each of two ends (row, column) in steps of the grid."""
    inside = signed < 0
    with np.errstate(divide="ignore", invalid="ignore"):  # where both ends are on one side
        along_row = signed[:, :-1] / (signed[:, :-1] - signed[:, 1:])
        along_column = signed[:-1] / (signed[:-1] - signed[1:])
    row, column = np.indices((signed.shape[0] - 1, signed.shape[1] - 1), float)  # of the squares' upper left corners
    upper, lower = np.stack([row, column + along_row[:-1]], -1), np.stack([row + 1, column + along_row[1:]], -1)
    left, right = np.stack([row + along_column[:, :-1], column], -1), np.stack([row + along_column[:, 1:], column + 1], -1)
    cuts = np.stack([upper, right, lower, left], axis=2)
    corners = np.stack([inside[:-1, :-1], inside[:-1, 1:], inside[1:, 1:], inside[1:, :-1]], axis=2)  # clockwise
    is_cut = corners != np.roll(corners, -1, axis=2)
    two, four = is_cut.sum(axis=2) == 2, is_cut.all(axis=2)
    # Two corners across a square are inside: they hang together if its middle is inside, too.
    middle = signed[:-1, :-1] + signed[:-1, 1:] + signed[1:, 1:] + signed[1:, :-1] < 0
    hang_together = middle[four] == corners[four][:, 0]
    pairs = np.where(hang_together[:, None, None], [[0, 1], [2, 3]], [[3, 0], [1, 2]])
    saddles = cuts[four][np.arange(len(pairs))[:, None, None], pairs]
    return np.concatenate([cuts[two][is_cut[two]].reshape(-1, 2, 2), saddles.reshape(-1, 2, 2)])


def place(grid: sightline.PointGrid, at: Array) -> Array:
    """Positions (..., 3) of places (..., 2) in steps of the grid."""
    return np.asarray(grid.origin + at[..., 1:] * grid.across + at[..., :1] * grid.down)


def main() -> None:
    radius, height, step = 1.0, 0.6, 0.02
    grid = sightline.PointGrid(origin=[-1.2, 1.2, height], across=[step, 0, 0], down=[0, -step, 0], columns=121, rows=121)
    with sightline.serve() as server:
        signed = slice_of(server.client.import_arrays("ball", *ball(radius)), grid)
    ends = place(grid, outline(signed))
    np.save("signed.npy", signed)
    np.save("outline.npy", ends)
    length = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=-1).sum()
    print(f"signed.npy: {signed.shape[0]} x {signed.shape[1]} distances, from {signed.min():+.2f} to {signed.max():+.2f}")
    print(f"outline.npy: {len(ends)} segments, together {length:.2f} long; "
          f"a true circle is {2 * np.pi * np.sqrt(radius ** 2 - height ** 2):.2f}")


if __name__ == "__main__":
    main()
