#!/usr/bin/python3
"""A LiDAR in a street: each frame moves 20 cars and casts a revolution of rays, in one call and without copies.

    moving_cars.py           a small scan, 16 x 128, of a few frames
    moving_cars.py --full    64 x 1,024 beams, about 302,000 triangles, 300 frames, and how long they took

Rays and answers lie in memory that the server shares, if it is at a Unix socket on this machine. A server elsewhere
takes 16,384 rays with changes in a call; more are cast after `scene.set_transforms()`.
"""

import argparse
import time
from typing import Any, List, Tuple

import numpy as np
import sightline
from numpy.typing import ArrayLike, NDArray
from sightline import lidar

Mesh = Tuple[NDArray[Any], NDArray[Any]]

LENGTH, LANES = 240.0, (-5.25, -1.75, 1.75, 5.25)  # metres of the street, and the middles of its lanes
CAR = (4.4, 1.8, 1.5)
CARS = 20
PERIOD = 0.1                                       # seconds of a revolution, and of a frame


def grid(corner: ArrayLike, right: ArrayLike, up: ArrayLike, columns: int, rows: int) -> Mesh:
    """A rectangle as vertices (v, 3) and faces (f, 3), which are counterclockwise seen against right x up."""
    across, along = np.meshgrid(np.linspace(0, 1, columns + 1), np.linspace(0, 1, rows + 1))
    vertices = np.asarray(corner) + across[..., None] * np.asarray(right) + along[..., None] * np.asarray(up)
    first = (np.arange(rows)[:, None] * (columns + 1) + np.arange(columns)).reshape(-1)
    a, b, c, d = first, first + 1, first + columns + 2, first + columns + 1
    return vertices.reshape(-1, 3), np.concatenate([np.column_stack([a, b, c]), np.column_stack([a, c, d])])


def box(low: ArrayLike, high: ArrayLike, cells: int) -> Mesh:
    """A box of five rectangles, without a floor; each has cells x cells squares."""
    at, (x, y, z) = np.array(low), np.subtract(high, low)
    sides = [grid(at, [x, 0, 0], [0, 0, z], cells, cells), grid(at + [x, 0, 0], [0, y, 0], [0, 0, z], cells, cells),
             grid(at + [x, y, 0], [-x, 0, 0], [0, 0, z], cells, cells),
             grid(at + [0, y, 0], [0, -y, 0], [0, 0, z], cells, cells),
             grid(at + [0, 0, z], [x, 0, 0], [0, y, 0], cells, cells)]
    starts = np.cumsum([0] + [len(vertices) for vertices, _ in sides[:-1]])
    return (np.concatenate([vertices for vertices, _ in sides]),
            np.concatenate([faces + start for (_, faces), start in zip(sides, starts)]))


def street(client: sightline.Client, detail: int) -> Tuple[sightline.Scene, List[sightline.Node]]:
    """A road between two rows of houses, and cars on it: the scene, and the cars. detail: squares on an edge of a
    house's side: 31 makes 301,732 triangles, of which each of 30 houses has 9,610, and each car 250."""
    scene = client.create_scene("street-with-cars", up_axis="z", meters_per_unit=1)
    half = LENGTH / 2
    with scene.batch():
        scene.add(grid([-half, -7, 0], [LENGTH, 0, 0], [0, 14, 0], 8 * detail, (detail + 3) // 2), name="road")
        for number, x in enumerate(np.linspace(-half, half - 16, 15)):
            height = 6 + 3 * (number % 4)
            scene.add(box([x, 10, 0], [x + 13, 22, height], detail), name=f"north {number}")
            scene.add(box([x, -22, 0], [x + 13, -10, height], detail), name=f"south {number}")
        car = box([-CAR[0] / 2, -CAR[1] / 2, 0.2], [CAR[0] / 2, CAR[1] / 2, CAR[2]], max(1, detail // 6))
        first = scene.add(car, name="car 0", mobility="rigid")
        cars = [first] + [scene.add(car, name=f"car {number}", mobility="rigid") for number in range(1, CARS)]
        scene.set_transforms(cars, poses(0))
    return scene, cars


def poses(seconds: float) -> NDArray[Any]:
    """Scene from car (cars, 3, 4): each drives along its lane at its own speed, and comes in again at the other end."""
    number = np.arange(CARS)
    lane = np.asarray(LANES)[number % 4]
    ahead = np.sign(lane)  # the lanes left of the middle are driven towards -x
    along = LENGTH * ((number * 0.381966 + (8 + number % 5) * seconds / LENGTH) % 1) - LENGTH / 2
    matrices = np.tile(np.eye(3, 4), (CARS, 1, 1))
    matrices[:, 0, 0] = matrices[:, 1, 1] = -ahead
    matrices[:, 0, 3], matrices[:, 1, 3] = -ahead * along, lane
    return matrices


class Scanner:
    """A sensor above the road, whose rays and answers stay in one memory."""

    def __init__(self, client: sightline.Client, beams: int, columns: int):
        elevations = np.linspace(-22.5, 22.5, beams)
        self.sensor = lidar.BeamTable(elevations, period=PERIOD, columns=columns, ranges=(0.5, 120))
        shape = self.sensor.shape
        memory = client.share_memory(shape[0] * shape[1] * 64)
        self.rays = memory.empty((*shape, 3), "f4"), memory.empty((*shape, 3), "f4")
        self.answers = {"t": memory.empty(shape), "node": memory.empty(shape, "u8")}
        self.path = lidar.Trajectory([0, 60], [np.column_stack([np.eye(3), [x, 0, 2.2]]) for x in (0, 30)])

    def frame(self, scene: sightline.Scene, cars: List[sightline.Node], number: int) -> Tuple[lidar.Sweep, Any, float]:
        """The sweep and hits of a frame, in which the cars stand still, and the seconds of its call."""
        sweep = self.sensor.sweep(self.path, first=number * self.sensor.columns, out=self.rays)
        moves = sightline.updates.set_transforms(cars, poses(number * PERIOD))
        begin = time.perf_counter()
        hits = scene.cast(sweep.rays, out=self.answers, apply=moves)
        return sweep, hits, time.perf_counter() - begin


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--full", action="store_true")
    full = parser.parse_args().full
    with sightline.serve() as server:
        scene, cars = street(server.client, 31 if full else 4)
        scanner = Scanner(server.client, *((64, 1024) if full else (16, 128)))
        ids, times = [car.id for car in cars], []
        for number in range(300 if full else 5):
            sweep, hits, took = scanner.frame(scene, cars, number)
            times.append(took)
        cloud = sweep.points(hits)
        on_cars = np.isin(hits.node.reshape(-1)[cloud.ray], ids).sum()
        print(f"revision {hits.revision}: {len(cloud)} points of {hits.hit.size} rays, {on_cars} on cars")
        if full:
            seconds = 1000 * np.array(times[20:])  # trees are grown by the first ones
            print(f"{scene.info().triangles_instanced} triangles; update and cast of a frame: p50 "
                  f"{np.percentile(seconds, 50):.2f} ms, p99 {np.percentile(seconds, 99):.2f} ms")


if __name__ == "__main__":
    main()
