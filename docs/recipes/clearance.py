#!/usr/bin/python3
"""How near a robot's arm comes to its cell while it turns: the least distance for each pose, and what is there.

Points of the arm's surface are moved with it. They ask for the nearest face that is not the arm's own, at a revision that has
the pose.
"""

from typing import Any, Iterator, Sequence

import numpy as np
import sightline
from numpy.typing import ArrayLike, NDArray

Array = NDArray[Any]

STEP = 0.05  # metres between points on the arm


def box(low: ArrayLike, high: ArrayLike) -> tuple[Array, Array]:
    """Vertices (8, 3) and faces (12, 3) of a box, outside counterclockwise."""
    corners = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)])
    faces = [[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1],
             [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]]
    return np.asarray(low) + corners * (np.asarray(high) - low), np.array(faces)


ARM = ([-0.1, -0.1, 0.5], [1.5, 0.1, 0.7])  # turns about the z axis


def surface_points(low: Sequence[float], high: Sequence[float]) -> Array:
    """Points (n, 3) all over a box's surface, its corners included."""
    axes = [np.linspace(a, b, int(np.ceil((b - a) / STEP)) + 1) for a, b in zip(low, high)]
    points = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    on_surface: Array = points[((points == low) | (points == high)).any(axis=1)]
    return on_surface


def cell(client: sightline.Client) -> tuple[sightline.Scene, sightline.Node]:
    """A floor, a wall at x = 1.8, a post, and the arm. Returns scene and arm."""
    scene = client.create_scene("cell", up_axis="z", meters_per_unit=1)
    with scene.batch():
        scene.add(box([-3, -3, -0.1], [3, 3, 0]), name="floor")
        scene.add(box([1.8, -3, 0], [2, 3, 2]), name="wall")
        scene.add(box([-0.2, 1.55, 0], [0.2, 1.9, 1]), name="post")
        arm = scene.add(box(*ARM), name="arm", mobility="rigid")
    return scene, arm


def pose(angle: float) -> Array:
    """Scene from arm (3, 4)."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s, 0, 0], [s, c, 0, 0], [0, 0, 1, 0]])


def clearances(scene: sightline.Scene, arm: sightline.Node, angles: Array) -> "Iterator[tuple[float, str, Array]]":
    """For each angle: the least distance, what is so near, and where on the arm."""
    own = surface_points(*ARM)
    with scene.update_stream("arm") as stream:
        for angle in angles:
            turned = pose(angle)
            stream.set_transforms([arm], turned[None])
            stream.flush()
            points = own @ turned[:, :3].T + turned[:, 3]
            near = scene.closest(points, exclude=[arm], fields=("distance", "name"), at_least=stream.token)
            nearest = near.distance.argmin()
            yield near.distance[nearest], near.name[nearest], points[nearest]


def main() -> None:
    angles = np.radians(np.arange(0, 181, 15))
    with sightline.serve() as server:
        scene, arm = cell(server.client)
        for angle, (metres, name, point) in zip(angles, clearances(scene, arm, angles)):
            print(f"{np.degrees(angle):5.1f} degrees: {metres:.3f} m to the {name}, at {np.round(point, 2)}")


if __name__ == "__main__":
    main()
