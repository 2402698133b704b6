#!/usr/bin/python3
"""A forklift drives through a hall and a range finder watches the aisle: updates and casts at the same time.

The forklift's program sends poses over a stream. The watcher casts at whatever is newest, or waits for a pose by its token.
"""

from typing import Any, Iterable, Iterator, Optional

import numpy as np
import sightline
from numpy.typing import ArrayLike, NDArray

Array = NDArray[Any]

SENSOR = np.array([0.0, 0.0, 1.0])  # looks along x, down the aisle


def box(size: ArrayLike) -> tuple[Array, Array]:
    """A box (x, y, z) that stands on the middle of its floor."""
    vertices = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (0, 1)]) * size
    faces = np.array([[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1],
                      [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]])
    return vertices, faces


def pose(x: float, y: float, heading: float) -> Array:
    """Scene from forklift (3, 4): turned about z by `heading` radians, then moved to (x, y)."""
    c, s = np.cos(heading), np.sin(heading)
    return np.array([[c, -s, 0, x], [s, c, 0, y], [0, 0, 1, 0]])


def hall(client: sightline.Client) -> tuple[sightline.Scene, sightline.Node]:
    """A wall at x = 20 and a forklift: a node with a body and a fork under it. Returns scene and forklift."""
    scene = client.create_scene("hall", up_axis="z", meters_per_unit=1)
    with scene.batch():
        scene.add(box([0.2, 30, 6]), name="wall", transform=pose(20.1, 0, 0))
        forklift = scene.add(name="forklift", mobility="rigid")  # so is what hangs below it
        forklift.add(box([2, 1.2, 2]), name="body")
        forklift.add(box([1, 1, 0.1]), name="fork", transform=pose(-1.5, 0, 0))
    return scene, forklift


def distance(scene: sightline.Scene, at_least: Optional[str] = None) -> tuple[float, str]:
    """Metres to what is ahead of the sensor, and what it is."""
    hits = scene.cast(origins=SENSOR, directions=[1, 0, 0], at_least=at_least)
    return float(hits.t), str(hits.name)


def drive(scene: sightline.Scene, forklift: sightline.Node,
          path: "Iterable[tuple[float, float, float]]") -> "Iterator[tuple[float, str]]":
    """Sends each pose (x, y, heading) of the path, and yields what the sensor sees then."""
    with scene.update_stream("forklift") as stream:
        for x, y, heading in path:
            stream.set_transforms([forklift], pose(x, y, heading)[None])
            stream.flush()  # until it is applied; a program that does not ask for answers leaves this out
            yield distance(scene, at_least=stream.token)


def main() -> None:
    with sightline.serve() as server:
        scene, forklift = hall(server.client)
        path = [(15 - step, 3 - 0.5 * step, 0) for step in range(10)]
        for (x, y, _), (metres, name) in zip(path, drive(scene, forklift, path)):
            print(f"forklift at ({x:4.1f}, {y:4.1f}): {name} at {metres:.2f} m")


if __name__ == "__main__":
    main()
