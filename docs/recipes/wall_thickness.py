#!/usr/bin/python3
"""How thick the walls of a part are: at points of its surface, the diameter of the largest ball that fits inside there.

A ray along the normal tells another thickness where walls are not parallel: across the part, not to the wall beside it.
"""

from typing import Any

import numpy as np
import sightline
from numpy.typing import NDArray
from sightline.trimesh_proximity import thickness

Array = NDArray[Any]

OUTER = np.array([8.0, 6.0, 4.0])
WALLS = np.array([[0.5, 0.4, 0.3], [0.6, 0.5, 0.2]])  # at the low and at the high end of x, y and z


class Part:
    """A mesh, as trimesh has them; one of trimesh will do, too."""

    def __init__(self, vertices: Array, faces: Array):
        self.vertices, self.faces, self.is_watertight = vertices, faces, True


def hollow_box() -> Part:
    """A closed box with a closed cavity, whose faces look inward."""
    corners = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)])
    faces = np.array([[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1],
                      [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]])
    cavity = WALLS[0] + corners * (OUTER - WALLS.sum(axis=0))
    return Part(np.concatenate([corners * OUTER, cavity]), np.concatenate([faces, faces[:, ::-1] + 8]))


def points_outside(count: int, seed: int = 1) -> tuple[Array, Array]:
    """Points (n, 3) on the outer faces, and for each the number of its face: axis + 3 if it is at the high end."""
    rng = np.random.default_rng(seed)
    points, side = rng.random((count, 3)) * OUTER, rng.integers(0, 6, count)
    points[np.arange(count), side % 3] = np.where(side < 3, 0, OUTER[side % 3])
    return points, side


def main() -> None:
    part = hollow_box()
    points, side = points_outside(20_000)
    with sightline.serve() as server:
        balls = thickness(part, points, client=server.client)
        rays = thickness(part, points, method="ray", client=server.client)
    for number in range(6):
        name = f"{'low' if number < 3 else 'high'} {'xyz'[number % 3]}"
        print(f"{name:>6}: {np.median(balls[side == number]):.3f} by balls, {np.median(rays[side == number]):.3f} by rays")
    thin = balls < 0.25
    print(f"{thin.mean():.1%} of the points are at walls, or beside edges, thinner than 0.25")


if __name__ == "__main__":
    main()
