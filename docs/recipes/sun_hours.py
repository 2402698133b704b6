#!/usr/bin/python3
"""Hours of direct sun on the ground around a house, on one day: a ray to the sun from each point at each step.

x is east, y is north, z is up.
"""

from typing import Any

import numpy as np
import sightline
from numpy.typing import ArrayLike, NDArray

Array = NDArray[Any]

MINUTES = 10  # a step


def sun(latitude: float, day: int, hour: ArrayLike) -> Array:
    """Unit vectors (..., 3) to the sun at solar time `hour` of the day of the year, at a latitude in degrees.

    The declination is Cooper's formula, good to about half a degree. Below the horizon z is negative.
    """
    declination = np.radians(23.45) * np.sin(2 * np.pi * (284 + day) / 365)
    latitude, angle = np.radians(latitude), np.radians(15.0) * (np.asarray(hour) - 12)
    east = -np.cos(declination) * np.sin(angle)
    north = np.cos(latitude) * np.sin(declination) - np.sin(latitude) * np.cos(declination) * np.cos(angle)
    up = np.sin(latitude) * np.sin(declination) + np.cos(latitude) * np.cos(declination) * np.cos(angle)
    return np.stack(np.broadcast_arrays(east, north, up), axis=-1)


def sun_hours(scene: sightline.Scene, points: ArrayLike, latitude: float, day: int) -> Array:
    """Hours (...) of sun at points (..., 3) that lie just above the surfaces of a scene."""
    to_sun = sun(latitude, day, np.arange(0, 24, MINUTES / 60) + MINUTES / 120)  # the middle of each step
    to_sun = to_sun[to_sun[:, 2] > 0]
    shaded = scene.cast(origins=np.asarray(points)[..., None, :], directions=to_sun, kind="any").hit
    return np.asarray((~shaded).sum(axis=-1) * MINUTES / 60)


def house() -> tuple[Array, Array]:
    """A box of 10 x 8 x 6 m with its south-west corner at the origin."""
    vertices = np.array([[x, y, z] for x in (0, 10) for y in (0, 8) for z in (0, 6)])
    faces = np.array([[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1],
                      [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]])
    return vertices, faces


def main() -> None:
    x, y = np.meshgrid(np.arange(-9.5, 20), np.arange(-9.5, 20))  # a point a square metre
    points = np.stack([x, y, np.full_like(x, 0.01)], axis=-1)
    with sightline.serve() as server:
        scene = server.client.import_arrays("house", *house(), up_axis="z", meters_per_unit=1)
        for name, day in (("21 June", 172), ("21 December", 355)):
            hours = sun_hours(scene, points, latitude=48, day=day)
            print(f"{name}: {hours[5, 15]:.1f} h south of the house, {hours[20, 15]:.1f} h north of it, "
                  f"{hours.max():.1f} h at most")


if __name__ == "__main__":
    main()
