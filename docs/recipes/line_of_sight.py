#!/usr/bin/python3
"""Which of many points see each other: a line-of-sight matrix between antennas on a town's roofs."""

from typing import Any

import numpy as np
import sightline
from numpy.typing import NDArray

Array = NDArray[Any]


def town(seed: int = 1, blocks: int = 8) -> tuple[Array, Array, Array]:
    """Houses of random heights on a grid: vertices, faces, and the middle of each roof (blocks^2, 3)."""
    rng = np.random.default_rng(seed)
    unit = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], float)
    faces = np.array([[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1],
                      [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]])
    corners = 20.0 * np.stack(np.meshgrid(np.arange(blocks), np.arange(blocks), [0]), axis=-1).reshape(-1, 3)
    sizes = np.column_stack([np.full(len(corners), 12.0), np.full(len(corners), 12.0), rng.uniform(4, 30, len(corners))])
    vertices = (corners[:, None] + unit * sizes[:, None]).reshape(-1, 3)
    all_faces = (faces + 8 * np.arange(len(corners))[:, None, None]).reshape(-1, 3)
    return vertices, all_faces, corners + sizes * [0.5, 0.5, 1]


def sees(scene: sightline.Scene, observers: Array, targets: Array) -> Array:
    """bool (n, m): whether the line from observers (n, 3) to targets (m, 3), which lie on no surface, is free."""
    lines = targets[None] - observers[:, None]
    blocked = scene.cast(origins=observers[:, None], directions=lines, tmax=1.0, kind="any").hit
    return ~blocked


def main() -> None:
    vertices, faces, roofs = town()
    antennas = roofs + [0, 0, 2]
    with sightline.serve() as server:
        scene = server.client.import_arrays("town", vertices, faces)
        matrix = sees(scene, antennas, antennas)
    np.fill_diagonal(matrix, False)  # from a point to itself there is no line
    print(f"{matrix.sum() // 2} of {matrix.size // 2} pairs see each other")
    best = matrix.sum(axis=1).argmax()
    print(f"antenna {best}, at height {antennas[best, 2]:.1f}, sees most others: {matrix[best].sum()}")


if __name__ == "__main__":
    main()
