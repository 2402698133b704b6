"""The class for programs that were written for trimesh."""

import copy
import os
import pickle
import time
import types
import warnings

import brute
import numpy as np
from shared import ServerTest
from sightline.trimesh_ray import RayMeshIntersector


class RayMeshIntersectorTest(ServerTest):
    def setUp(self):
        self.mesh = types.SimpleNamespace()
        self.mesh.vertices, self.mesh.faces = brute.soup()
        self.rays = brute.rays(200)
        self.arguments = {"ray_origins": self.rays[:, :3], "ray_directions": self.rays[:, 3:]}
        self.ray = RayMeshIntersector(self.mesh, client=self.client)
        self.table = brute.hits(self.mesh.vertices, self.mesh.faces, self.rays[:, :3], self.rays[:, 3:])

    def test_every_hit(self):
        face, ray, places = self.ray.intersects_id(**self.arguments, return_locations=True)
        self.assertEqual({(int(r), int(f)) for r, f in zip(ray, face)},
                         {(int(r), int(f)) for r, f in np.argwhere(~np.isnan(self.table))})
        t = self.table[ray, face]
        np.testing.assert_allclose(places, self.rays[ray, :3] + t[:, None] * self.rays[ray, 3:], rtol=1e-4, atol=1e-4)
        self.assertEqual((face.dtype, ray.dtype, places.dtype), (np.int64, np.int64, np.float64))
        again, ray_again, face_again = self.ray.intersects_location(**self.arguments)
        np.testing.assert_array_equal(again, places)
        np.testing.assert_array_equal([ray_again, face_again], [ray, face])

    def test_first_hits(self):
        t = np.where(np.isnan(self.table), np.inf, self.table)
        first = np.where(np.isfinite(t.min(axis=1)), t.argmin(axis=1), -1)
        np.testing.assert_array_equal(self.ray.intersects_first(**self.arguments), first)
        np.testing.assert_array_equal(self.ray.intersects_any(**self.arguments), first >= 0)
        face, ray = self.ray.intersects_id(**self.arguments, multiple_hits=False)
        np.testing.assert_array_equal(ray, np.flatnonzero(first >= 0))
        np.testing.assert_array_equal(face, first[first >= 0])

    def test_max_hits_warns(self):
        with self.assertWarnsRegex(UserWarning, "more than max_hits=1"):
            face, ray = self.ray.intersects_id(**self.arguments, max_hits=1)
        self.assertEqual(len(ray), len(np.unique(ray)))

    def test_contains_points(self):
        self.mesh.vertices, self.mesh.faces = brute.box()
        points = np.random.default_rng(3).uniform(-0.5, 1.5, (500, 3))
        inside = ((points > 0) & (points < 1)).all(axis=1)
        for is_watertight in (True, False):
            self.mesh.is_watertight = is_watertight
            np.testing.assert_array_equal(self.ray.contains_points(points), inside)
        self.assertEqual(self.ray.contains_points([[np.nan, 0, 0]]).tolist(), [False])

    def test_a_changed_mesh_is_noticed(self):
        before = self.ray.intersects_any(**self.arguments)
        self.assertTrue(before.any())
        self.mesh.vertices = self.mesh.vertices + np.float32(100)
        self.assertFalse(self.ray.intersects_any(**self.arguments).any())
        self.mesh.vertices -= 100
        np.testing.assert_array_equal(self.ray.intersects_any(**self.arguments), before)
        self.mesh.faces = np.zeros((0, 3), int)
        self.assertEqual([len(column) for column in self.ray.intersects_id(**self.arguments)], [0, 0])

    def test_one_scene_at_a_time(self):
        def names():
            return {scene.name for scene in self.client.scenes()}

        before = names()  # another thread may still delete some
        for shift in range(3):
            self.mesh.vertices = self.mesh.vertices + np.float32(shift)
            self.ray.intersects_any(**self.arguments)
        self.assertEqual(len(names() - before), 1)
        del self.ray
        while names() - before:  # it is deleted by another thread
            time.sleep(0.01)

    def test_pickles_and_copies(self):
        os.environ["SIGHTLINE_ENDPOINT"] = self.server.endpoint
        self.addCleanup(os.environ.pop, "SIGHTLINE_ENDPOINT")
        expected = self.ray.intersects_first(**self.arguments)
        for other in (pickle.loads(pickle.dumps(self.ray)), copy.copy(self.ray), copy.deepcopy(self.ray)):
            np.testing.assert_array_equal(other.intersects_first(**self.arguments), expected)

    def test_far_from_the_origin(self):
        far = np.array([4e6, 5e6, 0.0])
        vertices, self.mesh.faces = brute.box()
        self.mesh.vertices = vertices + far
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            places, _, _ = self.ray.intersects_location([far + [0.3, 0.4, 5]], [[0, 0, -1]])
        np.testing.assert_allclose(places - far, [[0.3, 0.4, 1], [0.3, 0.4, 0]], atol=1e-6)

    def test_bad_rays(self):
        with self.assertRaisesRegex(ValueError, "one shape"):
            self.ray.intersects_any([[0, 0, 0]], [[0, 0, 1], [0, 1, 0]])
