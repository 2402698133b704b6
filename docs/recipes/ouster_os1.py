#!/usr/bin/python3
"""An Ouster OS1-64 on a mast: a revolution of 64 x 1,024 rays as PLY, in the sensor's own frame.

All beams of a column are fired at once, in four directions side by side.
"""

import numpy as np
import sightline
from sightline import lidar

# OS1 of the first generation, the design values in Ouster's Software User Manual (beam_altitude_angles,
# beam_azimuth_angles, lidar_origin_to_beam_origin_mm), which hold where a sensor's own calibration is not known. The
# manual counts azimuths clockwise, as the sensor turns, and BeamTable counterclockwise: the sign changes.
ELEVATIONS = np.linspace(16.611, -16.611, 64)
AZIMUTHS = -np.tile([3.164, 1.055, -1.055, -3.164], 16)
BEAM_RADIUS = 0.012163  # metres


def os1(columns: int = 1024, turns_a_second: float = 10) -> lidar.BeamTable:
    return lidar.BeamTable(ELEVATIONS, AZIMUTHS, period=1 / turns_a_second, columns=columns, radius=BEAM_RADIUS,
                           ranges=(0.3, 120))


def yard(client: sightline.Client) -> sightline.Scene:
    """A floor of 200 x 200 m and a wall of 40 m at x = 20."""
    vertices = [[-100, -100, 0], [100, -100, 0], [100, 100, 0], [-100, 100, 0],
                [20, -20, 0], [20, 20, 0], [20, 20, 8], [20, -20, 8]]
    faces = [[0, 1, 2], [0, 2, 3], [4, 6, 5], [4, 7, 6]]
    return client.import_arrays("yard", vertices, faces, up_axis="z", meters_per_unit=1)


def main() -> None:
    mast = lidar.Trajectory([0], [np.column_stack([np.eye(3), [0, 0, 3]])])
    sweep = os1().sweep(mast)
    with sightline.serve() as server:
        hits = yard(server.client).cast(sweep.rays, fields=("t", "normal"))
    noise = lidar.RangeNoise(seed=64, sigma=0.01, growth=1e-4, dropout=0.002, resolution=0.001)
    cloud = sweep.points(hits, noise=noise, reflectivity=0.4, frame="sensor")
    lidar.write_ply("yard.ply", cloud)
    wall = cloud.position[:, 2] > -2.5
    print(f"{len(cloud)} points of {hits.hit.size} rays, {wall.sum()} above the floor, "
          f"at x = {np.median(cloud.position[wall, 0]):.2f} m")


if __name__ == "__main__":
    main()
