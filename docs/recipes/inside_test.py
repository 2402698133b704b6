#!/usr/bin/python3
"""Whether points are inside a closed mesh, and how far its surface is from them.

By default a point is inside if a ray from it crosses an odd number of faces. One ray is enough for a closed mesh: on an edge
or a vertex it counts one crossing.
"""

from typing import Any

import numpy as np
import sightline
from numpy.typing import NDArray

Array = NDArray[Any]


def torus(ring: float = 2.0, tube: float = 0.7, around: int = 60, across: int = 30) -> tuple[Array, Array]:
    """A closed mesh: vertices (around * across, 3) and faces. The z axis goes through the hole."""
    u, v = np.meshgrid(2 * np.pi * np.arange(around) / around, 2 * np.pi * np.arange(across) / across, indexing="ij")
    distance = ring + tube * np.cos(v)
    vertices = np.stack([distance * np.cos(u), distance * np.sin(u), tube * np.sin(v)], axis=-1).reshape(-1, 3)
    i, j = np.meshgrid(np.arange(around), np.arange(across), indexing="ij")
    a, b = i * across + j, (i + 1) % around * across + j
    c, d = (i + 1) % around * across + (j + 1) % across, i * across + (j + 1) % across
    faces = np.concatenate([np.stack([a, b, c], axis=-1).reshape(-1, 3), np.stack([a, c, d], axis=-1).reshape(-1, 3)])
    return vertices, faces


def main() -> None:
    rng = np.random.default_rng(1)
    points = rng.uniform([-3, -3, -1], [3, 3, 1], (100_000, 3))
    with sightline.serve() as server:
        scene = server.client.import_arrays("torus", *torus())
        inside = scene.contains(points)
        near = scene.closest([2.0, 0.0, 0.1], fields=("signed",))  # negative inside
    print(f"the surface is {-near.signed:.2f} from a point 0.1 beside the middle of the tube")
    volume = inside.mean() * 6 * 6 * 2
    print(f"{inside.sum()} of {len(points)} points are inside: a volume of {volume:.2f}, "
          f"of a true torus {2 * np.pi ** 2 * 2.0 * 0.7 ** 2:.2f}")


if __name__ == "__main__":
    main()
