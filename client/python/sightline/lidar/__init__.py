"""LiDAR: rays of a sensor that turns and moves, what it would measure, and files of the points.

    from sightline import lidar

    sensor = lidar.BeamTable(np.linspace(-15, 15, 16), period=0.1, columns=1800, ranges=(0.5, 100))
    path = lidar.Trajectory([0, 0.1], [start, end])                 # poses (3, 4), interpolated between these times
    sweep = sensor.sweep(path)
    hits = scene.cast(sweep.rays, fields=("t", "normal"))           # or awaited, of sightline.aio
    cloud = sweep.points(hits, noise=lidar.RangeNoise(seed=1, sigma=0.02, dropout=0.01))
    lidar.write_las("street.las", cloud)
"""

from .beams import BeamTable
from .cloud import PointCloud
from .las import write_las
from .noise import RangeNoise
from .pcd import write_pcd
from .ply import write_ply
from .sweep import Sweep
from .trajectory import Trajectory

__all__ = ["BeamTable", "PointCloud", "RangeNoise", "Sweep", "Trajectory", "write_las", "write_pcd", "write_ply"]
