#!/usr/bin/python3
"""A spinning LiDAR on a cart that drives down a street: one revolution as a point cloud.

The sensor moves while it turns, so each column of rays has an origin of its own.
"""

from typing import Any

import numpy as np
import sightline
from numpy.typing import ArrayLike, NDArray

Array = NDArray[Any]

BEAMS = np.radians(np.linspace(-15, 15, 16))  # elevations
COLUMNS = 720                                 # of a revolution
SECONDS = 0.1                                 # for a revolution
RANGE = (0.5, 80.0)                           # metres: nothing is measured nearer or further


def box(low: ArrayLike, high: ArrayLike) -> tuple[Array, Array]:
    """Vertices (8, 3) and faces (12, 3) of a box, outside counterclockwise."""
    corners = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)])
    faces = [[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1],
             [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]]
    return np.asarray(low) + corners * (np.asarray(high) - low), np.array(faces)


def street(client: sightline.Client) -> sightline.Scene:
    """A road along x with houses on both sides, each a node of its own."""
    scene = client.create_scene("street", up_axis="z", meters_per_unit=1)
    with scene.batch():
        scene.add(box([-100, -40, -1], [100, 40, 0]), name="road")
        for x in range(-96, 96, 16):
            scene.add(box([x, 8, 0], [x + 12, 18, 9]), name=f"north {x}")
            scene.add(box([x, -18, 0], [x + 12, -8, 6]), name=f"south {x}")
    return scene


def revolution(position: ArrayLike, velocity: ArrayLike) -> tuple[Array, Array]:
    """Origins (columns, 1, 3) and unit directions (columns, beams, 3): one revolution from a moving position (3)."""
    turn = np.arange(COLUMNS) / COLUMNS
    azimuth, elevation = np.meshgrid(2 * np.pi * turn, BEAMS, indexing="ij")
    directions = np.stack([np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth),
                           np.sin(elevation)], axis=-1)
    origins = np.asarray(position) + turn[:, None] * SECONDS * np.asarray(velocity)
    return origins[:, None, :], directions


def scan(scene: sightline.Scene, position: ArrayLike, velocity: ArrayLike = (0, 0, 0)) -> sightline.Hits:
    """Hits of shape (columns, beams); t is the range in metres, since directions are unit vectors.

    Rays begin at the sensor: what is nearer than it can measure still hides what is behind it.
    """
    origins, directions = revolution(position, velocity)
    hits = scene.cast(origins=origins, directions=directions, tmax=RANGE[1])
    too_near = hits.t < RANGE[0]
    hits.t[too_near], hits.node[too_near] = np.inf, 0  # nothing is measured there
    return hits


def main() -> None:
    with sightline.serve() as server:
        scene = street(server.client)
        hits = scan(scene, position=[0, 0, 1.8], velocity=[10, 0, 0])
        cloud = hits.position[hits.hit]  # (n, 3), in the scene's coordinates
        np.save("cloud.npy", cloud)
        print(f"cloud.npy: {len(cloud)} points of {hits.hit.size} rays, ranges {hits.t[hits.hit].min():.2f} m "
              f"to {hits.t[hits.hit].max():.2f} m")
        names, counts = np.unique(hits.name[hits.hit].astype(str), return_counts=True)
        for place in np.argsort(-counts)[:3]:
            print(f"  {counts[place]} on {names[place]}")


if __name__ == "__main__":
    main()
