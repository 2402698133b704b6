"""Rays that the server makes: scans, pictures, pairs."""

import pickle
import unittest

import brute
import numpy as np
import sightline
from shared import ServerTest

SCAN = sightline.SphericalScan([0.1, 0.2, 0.3], columns=40, rows=30, azimuth=(-2, 2.5), elevation=(-1, 1.2))


def directions_of(scan):
    azimuth, elevation = (scan.coordinates[name][1] for name in ("azimuth", "elevation"))
    level = np.cos(azimuth)[:, None] * scan.forward + np.sin(azimuth)[:, None] * scan.left
    return np.cos(elevation)[:, None, None] * level + np.sin(elevation)[:, None, None] * np.array(scan.up)


class GeneratedTest(ServerTest):
    def check(self, hits, origins, directions, **bounds):
        given = self.scene.cast(origins=origins, directions=directions, **bounds)
        np.testing.assert_allclose(hits.t, given.t, rtol=1e-9)
        np.testing.assert_array_equal(hits.primitive, given.primitive)
        np.testing.assert_allclose(hits.position, given.position, rtol=1e-9)

    def setUp(self):
        self.scene = self.scene_of(brute.soup())

    def test_scan(self):
        hits = self.scene.cast(SCAN)
        self.assertEqual(hits.shape, (30, 40))
        self.assertTrue(hits.hit.any() and not hits.hit.all())
        self.check(hits, SCAN.origin, directions_of(SCAN))
        near = self.scene.cast(sightline.SphericalScan(SCAN.origin, 40, 30, (-2, 2.5), (-1, 1.2), tmin=0.1, tmax=0.6))
        self.check(near, SCAN.origin, directions_of(SCAN), tmin=0.1, tmax=0.6)

    def test_pinhole(self):
        camera = sightline.Pinhole.looking_at([2, 2, 3], [0.5, 0.5, 0.5], [0, 0, 1], 30, 20,
                                              samples=((0.25, 0.5), (0.75, 0.5)))
        hits = self.scene.cast(camera)
        self.assertEqual(hits.shape, (20, 30, 2))
        x = (np.arange(30)[:, None] + np.array([0.25, 0.75])) / 30
        y = (np.arange(20) + 0.5) / 20
        ways = camera.corner + x[..., None] * camera.across + y[:, None, None, None] * np.array(camera.down)
        self.check(hits, camera.eye, ways / np.linalg.norm(ways, axis=-1, keepdims=True))

    def test_pairs(self):
        random = np.random.default_rng(3)
        one, other = random.random((20, 3)), random.random((30, 3))
        pairs = sightline.VisibilityPairs(one, other, tmin=1e-9)
        self.check(self.scene.cast(pairs), one[:, None], other - one[:, None], tmin=1e-9, tmax=1)
        hidden = self.scene.cast(pairs, kind="any").hit
        some = random.integers(0, 20, (9, 2))
        listed = self.scene.cast(sightline.VisibilityPairs(one, other, some, tmin=1e-9), kind="any").hit
        np.testing.assert_array_equal(listed, hidden[some[:, 0], some[:, 1]])
        bad = one.copy()
        bad[3, 1] = np.nan
        self.assertTrue(self.scene.cast(sightline.VisibilityPairs(bad, other)).invalid[3].all())

    def test_kinds_and_transports_agree(self):
        large = sightline.SphericalScan(SCAN.origin, columns=300, rows=100)
        with sightline.connect(self.server.endpoint, use_segments=False) as client:
            messages = client.scene(self.scene.name)
            hits = messages.cast(large)
            np.testing.assert_array_equal(hits.t, self.scene.cast(large).t)
            np.testing.assert_array_equal(hits.hit, messages.cast(large, kind="any").hit)
            count = messages.cast(large, kind="count").count
            every = messages.cast(large, kind="all")
        np.testing.assert_array_equal(every.count, count)
        np.testing.assert_array_equal(hits.hit, count > 0)
        nearest = every[every.offset[:-1][count.reshape(-1) > 0]]
        np.testing.assert_array_equal(nearest.t, hits.t[hits.hit])
        np.testing.assert_array_equal(nearest.position, hits.position[hits.hit])

    def test_more_hits_than_an_answer_lists_by_default(self):
        height = np.arange(600.0)
        corners = np.array([[-9, -9, 0], [9, -9, 0], [0, 9, 0]])
        vertices = (corners + height[:, None, None] * [0, 0, 1]).reshape(-1, 3)
        tower = self.client.import_arrays("tower", vertices, np.arange(1800).reshape(-1, 3))
        pairs = sightline.VisibilityPairs([[0, 0, -1], [50, 0, -1]], [[0, 0, 700]])
        every = tower.cast(pairs, kind="all", fields=("primitive",))
        self.assertEqual(every.count.tolist(), [[600], [0]])
        np.testing.assert_array_equal(every.primitive, np.arange(600))
        self.assertEqual(tower.cast(pairs, kind="all", max_hits=300).count.tolist(), [[300], [0]])

    def test_changes_come_with_it(self):
        hits = self.scene.cast(SCAN, apply=[sightline.updates.delete_node(1)])
        self.assertFalse(hits.hit.any())
        self.assertEqual(hits.applied.revision, hits.revision)

    def test_pickled(self):
        for made in (SCAN, sightline.VisibilityPairs([[0, 0, 0]], [[1, 1, 1]]),
                     sightline.PointGrid((0, 0, 0), (1, 0, 0), (0, 1, 0), 3, 2)):
            self.assertEqual(pickle.loads(pickle.dumps(made)).message(), made.message())

    def test_what_is_refused(self):
        far = [np.inf, 0, 0]
        for error, text, asking in (
                (ValueError, "origin", lambda: sightline.SphericalScan(far, 3, 3)),
                (ValueError, "columns is from 1 to 1048576, not 0", lambda: sightline.SphericalScan([0, 0, 0], 0, 3)),
                (ValueError, "radians", lambda: sightline.SphericalScan([0, 0, 0], 3, 3, azimuth=(0, 65))),
                (ValueError, "tmax", lambda: sightline.SphericalScan([0, 0, 0], 3, 3, tmax=np.nan)),
                (ValueError, "32 bits", lambda: sightline.SphericalScan([0, 0, 0], 3, 3, mask=2 ** 32)),
                (ValueError, "from 0 to 1", lambda: sightline.Pinhole(*np.eye(4, 3), 3, 3, samples=((0, 2),))),
                (ValueError, "fov", lambda: sightline.Pinhole.looking_at([0, 0, 0], [1, 0, 0], [0, 0, 1], 3, 3, 180)),
                (ValueError, "at - eye", lambda: sightline.Pinhole.looking_at([0, 0, 0], [0, 0, 0], [0, 0, 1], 3, 3)),
                (ValueError, "from 1 to 16384", lambda: sightline.VisibilityPairs(np.zeros((16385, 3)), [[0, 0, 1]])),
                (ValueError, "rows of 1 and of 1", lambda: sightline.VisibilityPairs([[0, 0, 0]], [[0, 0, 1]], [[0, 1]])),
                (TypeError, "integers", lambda: sightline.VisibilityPairs([[0, 0, 0]], [[0, 0, 1]], [[0.0, 0.0]])),
                (TypeError, "tmax", lambda: self.scene.cast(SCAN, tmax=3)),
                (TypeError, "PointGrid", lambda: self.scene.closest(SCAN)),
                (TypeError, "closest", lambda: self.scene.cast(sightline.PointGrid((0, 0, 0), (1, 0, 0), (0, 1, 0), 3, 2)))):
            with self.subTest(text), self.assertRaisesRegex(error, text):
                asking()


if __name__ == "__main__":
    unittest.main()
