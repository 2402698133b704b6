"""Files of point clouds: read back by a few lines here, and by other programs' readers where these are installed."""

import importlib.util
import io
import os
import pathlib
import struct
import tempfile
import unittest
import warnings

import numpy as np
import sightline
from sightline import lidar


def cloud(count, about=(0, 0, 0), seed=1):
    """Points in a box of 200 units about a point."""
    rng = np.random.default_rng(seed)
    return lidar.PointCloud(position=rng.uniform(-100, 100, (count, 3)) + about,
                            intensity=rng.random(count).astype("f4"),
                            ring=rng.integers(0, 65536, count), time=rng.uniform(1e5, 2e5, count), range=rng.random(count),
                            ray=np.arange(count))


SURVEY = (388096.37, 3948996.81, 41.25)
CLOUDS = {"none": cloud(0), "one": cloud(1), "many": cloud(1000)}


def written(write, *arguments, **options):
    file = io.BytesIO()
    write(file, *arguments, **options)
    return file.getvalue()


class PointCloudTest(unittest.TestCase):
    def test_what_is_refused(self):
        good = {name: getattr(cloud(3), name) for name in ("position", "intensity", "ring", "time", "range", "ray")}
        for error, text, change in (
                (ValueError, r"ring has the shape \(3,\)", {"ring": [1, 2]}),
                (ValueError, r"position has the shape \(3, 3\)", {"position": [[1, 2]] * 3}),
                (ValueError, "position of point 1 is not finite", {"position": [[0, 0, 0], [0, np.nan, 0], [0, 0, 0]]}),
                (ValueError, "time of point 2 is not finite", {"time": [0, 1, np.inf]}),
                (ValueError, "ring has integers that uint16 holds", {"ring": [0, 1, 65536]}),
                (ValueError, "ring has integers", {"ring": [0, 1.5, 2]}),
                (ValueError, "ring has integers", {"ring": [0, -1, 2]}),
                (TypeError, "time has numbers", {"time": ["a", "b", "c"]})):
            with self.subTest(text, **change), self.assertRaisesRegex(error, text):
                lidar.PointCloud(**{**good, **change})


class PcdTest(unittest.TestCase):
    def test_fields(self):
        for name, points in CLOUDS.items():
            for coordinates in ("f4", "f8"):
                with self.subTest(name, coordinates=coordinates):
                    header, _, rows = written(lidar.write_pcd, points, coordinates=coordinates).partition(b"DATA binary\n")
                    size = coordinates[1]
                    self.assertEqual(header.decode().splitlines()[1:], [
                        "VERSION 0.7", "FIELDS x y z intensity ring time", f"SIZE {size} {size} {size} 4 2 8",
                        "TYPE F F F F U F", "COUNT 1 1 1 1 1 1", f"WIDTH {len(points)}", "HEIGHT 1",
                        "VIEWPOINT 0 0 0 1 0 0 0", f"POINTS {len(points)}"])
                    table = np.frombuffer(rows, [("xyz", f"<{coordinates}", 3), ("intensity", "<f4"), ("ring", "<u2"),
                                                 ("time", "<f8")])
                    self.check(points, table["xyz"], table, coordinates)
                    _, _, text = written(lidar.write_pcd, points, binary=False, coordinates=coordinates).partition(
                        b"DATA ascii\n")
                    lines = [line.split() for line in text.decode().splitlines()]
                    self.assertEqual(len(lines), len(points))
                    columns = [np.array([line[at] for line in lines], kind) for at, kind in
                               enumerate((coordinates, coordinates, coordinates, "f4", "u2", "f8"))]
                    self.check(points, np.column_stack(columns[:3]),
                               dict(zip(("intensity", "ring", "time"), columns[3:])),
                               coordinates)

    def check(self, points, positions, table, coordinates):
        np.testing.assert_array_equal(positions, points.position.astype(coordinates))
        for name in ("intensity", "ring", "time"):
            np.testing.assert_array_equal(table[name], getattr(points, name))

    def test_far_from_the_origin(self):
        for write in (lidar.write_pcd, lidar.write_ply):
            with self.assertWarnsRegex(sightline.PrecisionWarning, "by up to 0.1.*f8"):
                written(write, cloud(1000, SURVEY))
            with warnings.catch_warnings():
                warnings.simplefilter("error")
                written(write, cloud(1000, SURVEY), coordinates="f8")
            for text, points, options in (("beyond the range", cloud(1, (1e300, 0, 0)), {}),
                                          ("'f4' or 'f8', not 'f2'", cloud(1), {"coordinates": "f2"})):
                with tempfile.TemporaryDirectory() as folder, self.assertRaisesRegex(ValueError, text):
                    write(os.path.join(folder, "file"), points, **options)

    def test_paths_and_files(self):
        for write in (lidar.write_pcd, lidar.write_ply, lidar.write_las):
            with tempfile.TemporaryDirectory() as folder:
                path = pathlib.Path(folder, "points")
                write(path, CLOUDS["many"])
                self.assertEqual(path.read_bytes(), written(write, CLOUDS["many"]))
                with self.assertRaises(FileNotFoundError):
                    write(os.path.join(folder, "none", "points"), CLOUDS["many"])


class PlyTest(unittest.TestCase):
    def test_properties(self):
        for name, points in CLOUDS.items():
            for coordinates, word in (("f4", "float"), ("f8", "double")):
                with self.subTest(name, coordinates=coordinates):
                    header, _, rows = written(lidar.write_ply, points, coordinates=coordinates).partition(b"end_header\n")
                    self.assertEqual(header.decode().splitlines(), [
                        "ply", "format binary_little_endian 1.0", f"element vertex {len(points)}", f"property {word} x",
                        f"property {word} y", f"property {word} z", "property float intensity", "property int ring",
                        "property double time"])
                    table = np.frombuffer(rows, [("xyz", f"<{coordinates}", 3), ("intensity", "<f4"), ("ring", "<i4"),
                                                 ("time", "<f8")])
                    np.testing.assert_array_equal(table["xyz"], points.position.astype(coordinates))
                    for column in ("intensity", "ring", "time"):
                        np.testing.assert_array_equal(table[column], getattr(points, column))


class LasTest(unittest.TestCase):
    def test_header_and_points(self):
        """By the offsets of the specification's tables."""
        for points in (*CLOUDS.values(), cloud(1000, SURVEY)):
            for wkt in ("", 'LOCAL_CS["site"]'):
                data = written(lidar.write_las, points, wkt=wkt)
                self.assertEqual((data[:4], data[24], data[25], data[104]), (b"LASF", 1, 4, 6))
                encoding, (header, start, records) = struct.unpack_from("<H", data, 6)[0], struct.unpack_from("<HII", data, 94)
                length, legacy = struct.unpack_from("<HI", data, 105)
                self.assertEqual((encoding & 16, header, records, length, legacy), (16, 375, 1 + bool(wkt), 32, 0))
                self.assertEqual(struct.unpack_from("<16Q", data, 247), (len(points), len(points)) + (0,) * 14)
                self.assertEqual(len(data), start + 32 * len(points))
                scale, offset = np.frombuffer(data, "<f8", 3, 131), np.frombuffer(data, "<f8", 3, 155)
                table = np.frombuffer(data, [("xyz", "<i4", 3), ("intensity", "<u2"), ("returns", "u1"), ("", "V7"),
                                             ("time", "<f8"), ("ring", "<u2")], len(points), start)
                found = table["xyz"] * scale + offset
                np.testing.assert_allclose(found, points.position, atol=0.00051, rtol=0)
                np.testing.assert_array_equal(table["time"], points.time)
                np.testing.assert_array_equal(table["ring"], points.ring)
                np.testing.assert_allclose(table["intensity"], points.intensity * 65535, atol=0.51)
                self.assertTrue((table["returns"] == 0x11).all())
                if len(points):
                    bounds = np.column_stack([found.max(axis=0), found.min(axis=0)]).reshape(-1)
                    np.testing.assert_array_equal(np.frombuffer(data, "<f8", 6, 179), bounds)
                self.assertEqual(wkt.encode() + b"\0" if wkt else b"", data[start - len(wkt) - 1:start] if wkt else b"")

    def test_bright_points_and_scales(self):
        points = lidar.PointCloud([[0, 0, 0], [1, 2, 3]], [0.5, 7], [0, 1], [0, 1], [1, 1], [0, 1])
        data = written(lidar.write_las, points, scale=0.5)
        start = struct.unpack_from("<I", data, 96)[0]
        table = np.frombuffer(data, [("xyz", "<i4", 3), ("intensity", "<u2"), ("", "V18")], 2, start)
        self.assertEqual(table["intensity"].tolist(), [32768, 65535])
        np.testing.assert_array_equal(table["xyz"] * 0.5 + np.frombuffer(data, "<f8", 3, 155), [[0, 0, 0], [1, 2, 3]])
        far = lidar.PointCloud([[0, 0, 0], [1e7, 0, 0]], [0, 0], [0, 1], [0, 1], [1, 1], [0, 1])
        for text, options in (("span 1e\\+07 units, and steps of 0.001 reach 4.29497e\\+06", {}), ("scale is", {"scale": 0}),
                              ("scale is", {"scale": np.nan}), ("wkt is", {"wkt": "a\0b"}), ("wkt is", {"wkt": "a" * 65535})):
            with self.subTest(text), self.assertRaisesRegex(ValueError, text):
                written(lidar.write_las, far, **options)
        self.assertEqual(struct.unpack_from("<d", written(lidar.write_las, far, scale=0.01), 179)[0], 1e7)


@unittest.skipUnless(importlib.util.find_spec("laspy"), "laspy is not installed")
class LaspyTest(unittest.TestCase):
    def test_las(self):
        import laspy

        for points in (*CLOUDS.values(), cloud(1000, SURVEY)):
            read = laspy.read(io.BytesIO(written(lidar.write_las, points, wkt='LOCAL_CS["site"]')))
            self.assertEqual((str(read.header.version), read.header.point_format.id, len(read.points)),
                             ("1.4", 6, len(points)))
            np.testing.assert_allclose(read.xyz.reshape(-1, 3), points.position, atol=0.00051, rtol=0)
            np.testing.assert_array_equal(read["ring"], points.ring)
            np.testing.assert_array_equal(read.gps_time, points.time)
            np.testing.assert_allclose(read.intensity, points.intensity * 65535, atol=0.51)
            self.assertEqual(set(read.number_of_returns), {1} if len(points) else set())
            self.assertTrue(read.header.global_encoding.wkt)


@unittest.skipUnless(importlib.util.find_spec("open3d"), "open3d is not installed")
class Open3dTest(unittest.TestCase):
    def test_pcd_and_ply(self):
        import open3d

        for points in (CLOUDS["one"], CLOUDS["many"]):
            for coordinates in ("f4", "f8"):
                for suffix, write, options in ((".pcd", lidar.write_pcd, {}), (".pcd", lidar.write_pcd, {"binary": False}),
                                               (".ply", lidar.write_ply, {})):
                    with self.subTest(suffix, **options), tempfile.TemporaryDirectory() as folder:
                        path = os.path.join(folder, "points" + suffix)
                        write(path, points, coordinates=coordinates, **options)
                        read = open3d.t.io.read_point_cloud(path).point
                        np.testing.assert_array_equal(read["positions"].numpy(), points.position.astype(coordinates))
                        for name in ("intensity", "ring", "time"):
                            np.testing.assert_array_equal(read[name].numpy().reshape(-1), getattr(points, name))


if __name__ == "__main__":
    unittest.main()
