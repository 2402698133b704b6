#!/usr/bin/python3
"""A game's tick: agents walk between pillars, and who sees whom is asked in the same call that moves them.

Each line of sight is answered at the revision that the moves make, so that an agent who steps into it blocks it in the same tick.
"""

from typing import Any, Sequence

import numpy as np
import sightline
from numpy.typing import ArrayLike, NDArray

Array = NDArray[Any]

HALL = 40.0   # metres, square
WIDTH = 0.6   # of an agent
EYES = 1.6    # above the floor


def box(size: ArrayLike) -> tuple[Array, Array]:
    """A box (x, y, z) that stands on the middle of its floor."""
    vertices = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (0, 1)]) * size
    faces = np.array([[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1],
                      [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]])
    return vertices, faces


def poses(places: "Sequence[Any] | Array") -> Array:
    """Scene from agent (n, 3, 4), for places on the floor (n, 2)."""
    matrices = np.tile(np.eye(3, 4), (len(places), 1, 1))
    matrices[:, :2, 3] = places
    return matrices


def arena(client: sightline.Client, places: Array) -> tuple[sightline.Scene, list[sightline.Node], Array]:
    """Pillars in a grid, and an agent at each place (n, 2). Returns the scene, the agents and the pillars' middles."""
    pillars = np.stack(np.meshgrid(np.arange(4, HALL, 8), np.arange(4, HALL, 8)), axis=-1).reshape(-1, 2)
    scene = client.create_scene("arena", up_axis="z", meters_per_unit=1)
    with scene.batch():
        for x, y in pillars:
            scene.add(box([2, 2, 4]), name="pillar", transform=poses([(x, y)])[0])
        agents = [scene.add(box([WIDTH, WIDTH, 1.8]), name=f"agent {i}", transform=pose, mobility="rigid")
                  for i, pose in enumerate(poses(places))]
    return scene, agents, pillars


def tick(scene: sightline.Scene, agents: list[sightline.Node], places: Array, pairs: Array) -> tuple[Array, int]:
    """Moves the agents, and tells of pairs (m, 2) of them whether the one sees the other: bool (m), and the revision."""
    eyes = np.column_stack([places, np.full(len(places), EYES)])
    origins, lines = eyes[pairs[:, 0]], eyes[pairs[:, 1]] - eyes[pairs[:, 0]]
    own = WIDTH / np.maximum(np.linalg.norm(lines, axis=1), 2.5 * WIDTH)  # the share of a line within a body at its end
    hits = scene.cast(origins=origins, directions=lines, tmin=own, tmax=1 - own, kind="any",
                      apply=sightline.updates.set_transforms(agents, poses(places)))
    return ~hits.hit, hits.revision


def walk(rng: np.random.Generator, places: Array) -> Array:
    """A step of each agent, who stays in the hall."""
    return np.asarray(np.clip(places + rng.normal(0, 0.4, places.shape), 1, HALL - 1))


def main() -> None:
    rng = np.random.default_rng(7)
    places = rng.uniform(1, HALL - 1, (50, 2))
    pairs = np.array([(i, j) for i in range(50) for j in (i + 1, i + 7, i + 19, i + 31)]) % 50
    with sightline.serve() as server:
        scene, agents, _ = arena(server.client, places)
        for _ in range(10):
            places = walk(rng, places)
            sees, revision = tick(scene, agents, places, pairs)
    print(f"revision {revision}: {sees.sum()} of {len(pairs)} lines of sight are free")


if __name__ == "__main__":
    main()
