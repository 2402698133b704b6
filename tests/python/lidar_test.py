"""LiDAR: rays of tables of beams, poses between poses, noise by seeds, and points; with formulas written out."""

import asyncio
import math
import unittest

import brute
import numpy as np
from shared import ServerTest
from sightline import aio, lidar


def turned(axis, degrees, position=(0, 0, 0)):
    """A pose (3, 4), by Rodrigues' formula."""
    x, y, z = np.asarray(axis) / np.linalg.norm(axis)
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    angle = math.radians(degrees)
    turn = np.eye(3) + math.sin(angle) * cross + (1 - math.cos(angle)) * cross @ cross
    return np.column_stack([turn, position])


STILL = lidar.Trajectory([0], [turned([0, 0, 1], 0)])


class TrajectoryTest(unittest.TestCase):
    def test_between_two_poses(self):
        axis = [1, -2, 3]
        for degrees in (0, 1e-7, 1e-4, 40, 179.9):
            path = lidar.Trajectory([2, 4], [turned(axis, 10, [1, 2, 3]), turned(axis, 10 + degrees, [3, 2, -1])])
            turns, positions = path.at([2, 2.5, 3.9, 4])
            for turn, position, share in zip(turns, positions, (0, 0.25, 0.95, 1)):
                np.testing.assert_allclose(turn, turned(axis, 10 + share * degrees)[:, :3], atol=1e-14)
                np.testing.assert_allclose(position, [1 + 2 * share, 2, 3 - 4 * share], atol=1e-14)

    def test_the_shorter_way_and_any_rotation(self):
        rng = np.random.default_rng(1)
        for axis in [*np.eye(3), *-np.eye(3), *rng.normal(size=(20, 3))]:
            poses = [turned(axis, degrees) for degrees in (0, 170, 180, 350, 360, 359)]
            turns, _ = lidar.Trajectory(range(6), poses).at(np.arange(0, 5.1, 0.5))
            for turn, degrees in zip(turns, (0, 85, 170, 175, 180, 265, 350, 355, 360, 359.5, 359)):
                np.testing.assert_allclose(turn, turned(axis, degrees)[:, :3], atol=1e-13)

    def test_quaternions(self):
        half = math.radians(25)
        quaternions = np.array([[0, 0, math.sin(half), math.cos(half)],
                                [0, -7 * math.sin(half), 0, 7 * math.cos(half)]])
        turns, positions = lidar.Trajectory.from_quaternions([0, 1], [[1, 2, 3], [4, 5, 6]], quaternions).at([0, 1])
        np.testing.assert_allclose(turns, [turned([0, 0, 1], 50)[:, :3], turned([0, -1, 0], 50)[:, :3]], atol=1e-15)
        self.assertEqual(positions.tolist(), [[1, 2, 3], [4, 5, 6]])

    def test_one_pose_is_there_at_all_times(self):
        turns, positions = lidar.Trajectory([5], turned([1, 0, 0], 30, [1, 2, 3])).at([[-1e9], [1e9]])
        self.assertEqual((turns.shape, positions.tolist()), ((2, 1, 3, 3), [[[1, 2, 3]], [[1, 2, 3]]]))

    def test_what_is_refused(self):
        pose, mirrored, scaled = turned([0, 0, 1], 0), turned([0, 0, 1], 0), turned([0, 0, 1], 0)
        mirrored[0, 0], scaled[1, 1] = -1, 1.001
        for text, make in (("increase, but time 2 is 1 after 1", lambda: lidar.Trajectory([0, 1, 1], [pose] * 3)),
                           ("2 poses, and times of shape", lambda: lidar.Trajectory([0], [pose, pose])),
                           ("0 poses", lambda: lidar.Trajectory([], np.empty((0, 3, 4)))),
                           ("time 1 of the trajectory is not finite",
                            lambda: lidar.Trajectory([0, np.inf], [pose, pose])),
                           ("poses are finite", lambda: lidar.Trajectory([0], [np.full((3, 4), np.nan)])),
                           ("pose 1 .* mirrors", lambda: lidar.Trajectory([0, 1], [pose, mirrored])),
                           ("pose 0 .* 0.002 away", lambda: lidar.Trajectory([0, 1], [scaled, pose])),
                           ("quaternion 1 is zero", lambda: lidar.Trajectory.from_quaternions(
                               [0, 1], [[0, 0, 0]] * 2, [[0, 0, 0, 1], [0, 0, 0, 0]])),
                           ("shapes", lambda: lidar.Trajectory.from_quaternions([0], [[0, 0, 0]], [[0, 0, 1]])),
                           ("from 0 to 1 s, and has no pose at 1.5 s",
                            lambda: lidar.Trajectory([0, 1], [pose, pose]).at(1.5)),
                           ("no pose at nan", lambda: lidar.Trajectory([0, 1], [pose, pose]).at(np.nan))):
            with self.subTest(text), self.assertRaisesRegex(ValueError, text):
                make()


class BeamTableTest(unittest.TestCase):
    def test_rays(self):
        """Each ray against sines and cosines of its own, in Python's numbers."""
        elevations, azimuths, times = [-10, 0, 25], [3, -1, 0.5], [0, 1e-4, 3e-4]
        path = lidar.Trajectory([0, 1], [turned([0, 1, 1], 20, [1, 2, 3]), turned([0, 1, 1], 100, [5, 2, 0])])
        for sense, clockwise in ((1, False), (-1, True)):
            sensor = lidar.BeamTable(elevations, azimuths, times, period=0.1, interval=0.0015, zero=90, radius=0.02,
                                     clockwise=clockwise)
            self.assertEqual(sensor.shape, (66, 3))
            sweep = sensor.sweep(path, first=7, columns=100, start=0.25)
            self.assertEqual((sweep.shape, sweep.origins.shape), ((100, 3), (100, 3, 3)))
            for column in range(0, 100, 9):
                for beam in range(3):
                    time = 0.25 + (7 + column) * 0.0015 + times[beam]
                    head = math.radians(90 + sense * 360 * ((7 + column) * 0.0015 + times[beam]) / 0.1)
                    azimuth, elevation = head + math.radians(azimuths[beam]), math.radians(elevations[beam])
                    pose = turned([0, 1, 1], 20 + 80 * time, [1 + 4 * time, 2, 3 - 3 * time])
                    direction = [math.cos(elevation) * math.cos(azimuth), math.cos(elevation) * math.sin(azimuth),
                                 math.sin(elevation)]
                    place = [0.02 * math.cos(head), 0.02 * math.sin(head), 0]
                    self.assertAlmostEqual(sweep.times[column, beam], time, places=14)
                    np.testing.assert_allclose(sweep.directions[column, beam], pose[:, :3] @ direction, atol=1e-12)
                    np.testing.assert_allclose(sweep.origins[column, beam], pose[:, :3] @ place + pose[:, 3],
                                               atol=1e-12)

    def test_a_ray_is_the_same_in_any_sweep(self):
        poses = [turned([0, 0, 1], 0), turned([1, 2, 3], 70, [3, 4, 5]), turned([0, 1, 0], 170)]
        path = lidar.Trajectory([0, 0.13, 1], poses)
        for options in ({"columns": 777}, {"interval": 0.000131, "times": np.arange(5) * 1e-5}):
            sensor = lidar.BeamTable([-3, -1, 0, 1, 7], [0, 1, 2, 3, 4], period=0.1, radius=0.01, **options)
            whole = sensor.sweep(path, columns=2000)
            first = 0
            for columns in (1, 2, 3, 5, 64, 500, 0, 1425):
                part = sensor.sweep(path, first=first, columns=columns)
                for name in ("origins", "directions", "times"):
                    np.testing.assert_array_equal(getattr(part, name), getattr(whole, name)[first:first + columns])
                first += columns
            self.assertEqual(first, 2000)

    def test_revolutions_are_alike(self):
        sensor = lidar.BeamTable([0, 5], period=0.1, columns=1000)
        first, later = sensor.sweep(STILL), sensor.sweep(STILL, first=10 ** 9)
        np.testing.assert_array_equal(first.directions, later.directions)
        self.assertEqual(later.times[0, 0], 10 ** 9 * 0.0001)

    def test_a_head_that_stands_still(self):
        sensor = lidar.BeamTable([0, 0, 0], [-10, 0, 10], period=math.inf, interval=0.05)
        sweep = sensor.sweep(STILL, columns=4)
        self.assertEqual((sensor.shape, sweep.times[:, 1].tolist()), ((1, 3), [0, 0.05, 0.1, 0.05 * 3]))
        self.assertTrue((sweep.directions == sweep.directions[0]).all())
        np.testing.assert_allclose(sweep.directions[0, 2], [math.cos(math.radians(10)), math.sin(math.radians(10)), 0])

    def test_arrays_of_the_caller(self):
        sensor = lidar.BeamTable([-5, 5], period=0.1, columns=100, radius=0.1, ranges=(0, 0.7))
        for dtype in ("f4", "f8"):
            out = np.empty((100, 2, 3), dtype), np.empty((100, 2, 3), dtype)
            sweep = sensor.sweep(STILL, out=out)
            self.assertIs(sweep.directions, out[1])
            self.assertEqual(sweep.rays.dtype, dtype)
            np.testing.assert_array_equal(out[1], sensor.sweep(STILL).directions.astype(dtype))
            self.assertGreaterEqual(float(sweep.rays.tmax[0]), 0.7)  # no hit is lost to rounding
        array = np.empty((100, 2, 3))
        for error, text, wrong in ((ValueError, "share memory", (array, array)),
                                   (TypeError, "int64", (array, np.zeros((100, 2, 3), int))),
                                   (ValueError, "shape", (array, np.empty((99, 2, 3)))), (TypeError, "list", (array, [1]))):
            with self.subTest(text), self.assertRaisesRegex(error, text):
                sensor.sweep(STILL, out=wrong)

    def test_what_is_refused(self):
        good = {"elevations": [0, 1], "period": 0.1, "columns": 10}
        for text, change in (("elevations have the shape", {"elevations": []}),
                             ("elevations have", {"elevations": [[1]]}), ("beam 0 has nan", {"azimuths": np.nan}),
                             ("from -90 to 90, but beam 1 has 91", {"elevations": [0, 91]}),
                             ("times have a row for each of 2 beams", {"times": [1, 2, 3]}),
                             ("beam 1 has -1.0", {"times": [0, -1]}),
                             ("period is above 0, not 0", {"period": 0}), ("period is above 0, not nan", {"period": math.nan}),
                             ("either columns or interval", {"interval": 0.1}), ("columns divide", {"columns": 0}),
                             ("columns divide", {"columns": 1.5}), ("columns divide", {"period": math.inf}),
                             ("interval is above 0", {"columns": None, "interval": 0}),
                             ("not above the period", {"columns": None, "interval": 0.2}),
                             ("at most 281474976710656 columns", {"columns": None, "interval": 1e-300}),
                             ("zero is finite", {"zero": math.nan}), ("radius is finite", {"radius": -1}),
                             ("ranges are", {"ranges": (2, 1)}), ("ranges are", {"ranges": (math.nan, 1)}),
                             ("ranges are", {"ranges": (-1, 1)})):
            with self.subTest(text, **change), self.assertRaisesRegex(ValueError, text):
                lidar.BeamTable(**{**good, **change})
        with self.assertRaisesRegex(TypeError, "elevations"):
            lidar.BeamTable(["a"], period=1, columns=1)
        sensor = lidar.BeamTable(**good)
        for error, options in ((ValueError, {"first": -1}), (ValueError, {"columns": -1}), (ValueError, {"first": 1 << 60}),
                               (TypeError, {"first": 0.5}), (ValueError, {"start": math.nan})):
            with self.subTest(**options), self.assertRaises(error):
                sensor.sweep(STILL, **options)


class RangeNoiseTest(unittest.TestCase):
    def test_the_same_for_any_batch(self):
        ranges = np.random.default_rng(0).uniform(0, 100, 10_000)
        ranges[::17] = np.inf
        noise = lidar.RangeNoise(2 ** 100 + 7, sigma=0.02, growth=1e-3, dropout=0.1, resolution=0.004)
        whole, first = noise.measured(123, ranges), 0
        for count in (1, 2, 3, 5, 8, 13, 0, 4000, 10_000 - 4032):
            part = noise.measured(123 + first, ranges[first:first + count])
            np.testing.assert_array_equal(part, whole[first:first + count])
            first += count
        self.assertEqual(first, len(ranges))
        self.assertTrue(np.isinf(whole[::17]).all())
        other = lidar.RangeNoise(2 ** 100 + 8, sigma=0.02, growth=1e-3, dropout=0.1).measured(123, ranges)
        self.assertFalse((other == whole).any(where=np.isfinite(whole)))

    def test_its_distribution(self):
        """Counts of a fixed seed, with bounds of five standard deviations."""
        count, sigma = 200_000, 0.03
        ranges = np.full(count, 50.0)
        found = lidar.RangeNoise(1, sigma=sigma, growth=1e-3, dropout=0.2).measured(0, ranges)
        is_there = np.isfinite(found)
        self.assertLess(abs((~is_there).mean() - 0.2), 5 * math.sqrt(0.16 / count))
        errors = (found[is_there] - 50) / (sigma + 0.05)
        self.assertLess(abs(errors.mean()), 5 / math.sqrt(len(errors)))
        self.assertLess(abs(errors.var() - 1), 5 * math.sqrt(2 / len(errors)))
        within = [(abs(errors) < k).mean() for k in (1, 2, 3)]
        np.testing.assert_allclose(within, [math.erf(k / math.sqrt(2)) for k in (1, 2, 3)], atol=0.006)
        rounded = lidar.RangeNoise(1, resolution=0.25).measured(0, np.array([0.1, 0.9, 1.13, np.inf]))
        self.assertEqual(rounded.tolist(), [0, 1, 1.25, np.inf])
        self.assertTrue(np.isinf(lidar.RangeNoise(1, dropout=1).measured(0, ranges)).all())
        np.testing.assert_array_equal(lidar.RangeNoise(1).measured(0, ranges), ranges)

    def test_what_is_refused(self):
        for options in ({"seed": -1}, {"seed": 1 << 128}, {"sigma": -1}, {"sigma": math.inf}, {"growth": math.nan},
                        {"dropout": 1.1}, {"dropout": math.nan}, {"resolution": -1}):
            with self.subTest(**options), self.assertRaises(ValueError):
                lidar.RangeNoise(**{"seed": 1, **options})
        with self.assertRaises(TypeError):
            lidar.RangeNoise(1.5)


class PointsTest(ServerTest):
    """A sensor in a room of a cube."""

    def setUp(self):
        self.scene = self.scene_of(brute.box())
        self.sensor = lidar.BeamTable([-40, -20, 0, 20, 40], period=0.1, columns=90, radius=0.01, ranges=(0.05, 0.6))
        poses = turned([0, 0, 1], 0, [0.4, 0.5, 0.5]), turned([0, 0, 1], 90, [0.9, 0.5, 0.5])
        self.path = lidar.Trajectory([0, 1], poses)

    def test_ranges_intensities_and_positions(self):
        sweep = self.sensor.sweep(self.path)
        hits = self.scene.cast(sweep.rays, fields=("t", "normal"))
        cloud = sweep.points(hits, reflectivity=np.linspace(0, 2, 5))
        t, _ = brute.closest(*brute.box(), sweep.origins.reshape(-1, 3), sweep.directions.reshape(-1, 3))
        ray = np.flatnonzero((t >= 0.05) & (t <= 0.6))
        self.assertTrue(0 < len(ray) < t.size)
        np.testing.assert_array_equal(cloud.ray, ray)
        np.testing.assert_allclose(cloud.range, t[ray], rtol=1e-6)
        np.testing.assert_array_equal(cloud.position, hits.position.reshape(-1, 3)[ray])
        np.testing.assert_array_equal(cloud.ring, ray % 5)
        np.testing.assert_array_equal(cloud.time, sweep.times.reshape(-1)[ray])
        wall = np.argmin(np.minimum(np.abs(cloud.position), np.abs(1 - cloud.position)), axis=1)
        facing = np.abs(sweep.directions.reshape(-1, 3)[ray, wall])
        np.testing.assert_allclose(cloud.intensity, facing * np.linspace(0, 2, 5)[ray % 5], rtol=1e-5)
        self.assertEqual(sweep.points(self.scene.cast(sweep.rays, fields=("t",))).intensity.tolist(), [1] * len(ray))

    def test_the_frame_of_the_sensor(self):
        sweep = self.sensor.sweep(self.path, first=30)
        hits = self.scene.cast(sweep.rays)
        scene, sensor = sweep.points(hits), sweep.points(hits, frame="sensor")
        turns, places = self.path.at(scene.time)
        np.testing.assert_allclose(np.einsum("nij,nj->ni", turns, sensor.position) + places, scene.position, atol=1e-12)

    def test_noise(self):
        noise = lidar.RangeNoise(3, sigma=0.01, dropout=0.3)
        sweep = self.sensor.sweep(self.path, first=90)
        cloud = sweep.points(self.scene.cast(sweep.rays), noise=noise)
        self.assertTrue((cloud.range >= 0.05).all() and (cloud.range <= 0.6).all())
        parts = []
        for first in range(90, 180, 15):
            part = self.sensor.sweep(self.path, first=first, columns=15)
            parts.append(part.points(self.scene.cast(part.rays), noise=noise))
        joined = lidar.PointCloud.joined(parts)
        for name in ("position", "range", "time", "ring", "intensity"):
            np.testing.assert_array_equal(getattr(joined, name), getattr(cloud, name))
        self.assertEqual((len(joined), len(lidar.PointCloud.joined([]))), (len(cloud), 0))

    def test_asyncio_and_streams(self):
        sweep = self.sensor.sweep(self.path)
        expected = sweep.points(self.scene.cast(sweep.rays))

        async def scan():
            async with aio.connect(self.server.endpoint) as client:
                scene = client.scene(self.scene.name)
                whole = sweep.points(await scene.cast(sweep.rays))
                parts = [self.sensor.sweep(self.path, first=first, columns=30) for first in (0, 30, 60)]
                async with scene.cast_batches(part.rays for part in parts) as answers:
                    return whole, [part.points(hits) for part, hits in zip(parts, [hits async for hits in answers])]

        whole, parts = asyncio.run(scan())
        np.testing.assert_array_equal(whole.position, expected.position)
        np.testing.assert_array_equal(lidar.PointCloud.joined(parts).position, expected.position)

    def test_what_is_refused(self):
        sweep = self.sensor.sweep(self.path)
        hits = self.scene.cast(sweep.rays)
        other = self.scene.cast(sweep.rays, kind="any")
        for error, text, ask in ((ValueError, "shape", lambda: self.sensor.sweep(self.path, columns=1).points(hits)),
                                 (TypeError, "several rows", lambda: sweep.points(self.scene.cast(sweep.rays, kind="all"))),
                                 (ValueError, "frame is", lambda: sweep.points(hits, frame="world")),
                                 (ValueError, "not below 0", lambda: sweep.points(hits, reflectivity=-1)),
                                 (ValueError, "not below 0", lambda: sweep.points(hits, reflectivity=np.nan)),
                                 (ValueError, "", lambda: sweep.points(hits, reflectivity=[1, 2])),
                                 (AttributeError, "t was not asked for", lambda: sweep.points(other))):
            with self.subTest(text), self.assertRaisesRegex(error, text):
                ask()


if __name__ == "__main__":
    unittest.main()
