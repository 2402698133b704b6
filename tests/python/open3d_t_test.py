"""The class for programs that were written for Open3D."""

import types

import brute
import numpy as np
from shared import ServerTest
from sightline.open3d_t import RaycastingScene


class RaycastingSceneTest(ServerTest):
    def setUp(self):
        self.mesh = brute.soup()
        self.scene = RaycastingScene(client=self.client)
        self.assertEqual(self.scene.add_triangles(*self.mesh), 0)
        self.rays = brute.rays(200).astype("f4")
        self.table = brute.hits(*self.mesh, self.rays[:, :3], self.rays[:, 3:])

    def test_cast_rays(self):
        vertices, faces = brute.box()
        lower = types.SimpleNamespace(vertices=vertices - [0, 0, 10], triangles=faces)
        self.assertEqual(self.scene.add_triangles(lower), 1)
        answer = self.scene.cast_rays(self.rays.reshape(4, 50, 6))
        t = np.where(np.isnan(self.table), np.inf, self.table)
        hit = np.isfinite(t.min(axis=1)).reshape(4, 50)
        self.assertEqual({name: column.shape[2:] for name, column in answer.items()}, {
            "t_hit": (), "geometry_ids": (), "primitive_ids": (), "primitive_uvs": (2,), "primitive_normals": (3,)})
        self.assertEqual([column.dtype.str for column in answer.values()], ["<f4", "<u4", "<u4", "<f4", "<f4"])
        np.testing.assert_allclose(answer["t_hit"].numpy()[hit], t.min(axis=1).reshape(4, 50)[hit], rtol=1e-4)
        np.testing.assert_array_equal(answer["primitive_ids"][hit], t.argmin(axis=1).reshape(4, 50)[hit])
        self.assertTrue((answer["geometry_ids"][hit] == 0).all())
        self.assertTrue((answer["primitive_ids"][np.isinf(answer["t_hit"])] == RaycastingScene.INVALID_ID).all())
        down = self.scene.cast_rays([[0.3, 0.4, -5, 0, 0, -2]])
        self.assertEqual((down["geometry_ids"][0], down["t_hit"][0]), (1, 2.0))

    def test_counts_and_lists(self):
        count = (~np.isnan(self.table)).sum(axis=1)
        np.testing.assert_array_equal(self.scene.count_intersections(self.rays), count)
        answer = self.scene.list_intersections(self.rays.reshape(20, 10, 6))
        np.testing.assert_array_equal(answer["ray_splits"], [0, *np.cumsum(count)])
        np.testing.assert_array_equal(answer["ray_ids"], np.repeat(np.arange(200), count))
        np.testing.assert_allclose(answer["t_hit"], self.table[answer["ray_ids"], answer["primitive_ids"]], rtol=1e-4)
        self.assertEqual(answer["primitive_uvs"].shape, (count.sum(), 2))

    def test_occlusions(self):
        for tnear, tfar in ((0, np.inf), (0.3, np.inf), (0, 0.6), (0.3, 0.6)):
            with np.errstate(invalid="ignore"):
                expected = ((self.table >= tnear) & (self.table <= tfar)).any(axis=1)
            np.testing.assert_array_equal(self.scene.test_occlusions(self.rays, tnear, tfar), expected)

    def test_sides(self):
        scene = RaycastingScene(client=self.client)
        self.assertEqual(scene.compute_signed_distance([[0, 0, 0]]).tolist(), [np.inf])
        self.assertEqual(scene.compute_occupancy([[0, 0, 0]]).tolist(), [0])
        scene.add_triangles(*brute.box())
        points = np.random.default_rng(3).uniform(-0.5, 1.5, (10, 20, 3)).astype("f4")
        inside = ((points > 0) & (points < 1)).all(axis=-1)
        distance = scene.compute_distance(points)
        for options in ({}, {"nsamples": 1}, {"nthreads": 2, "nsamples": 3}, {"nsamples": 63}):
            occupancy, signed = (ask(points, **options) for ask in (scene.compute_occupancy,
                                                                    scene.compute_signed_distance))
            self.assertEqual([(some.shape, some.dtype.str) for some in (occupancy, signed)], [((10, 20), "<f4")] * 2)
            np.testing.assert_array_equal(occupancy, inside)
            np.testing.assert_array_equal(signed.numpy(), np.where(inside, -distance, distance))
        self.assertEqual(scene.compute_occupancy([0.5, 0.5, 0.5]).shape, ())
        np.testing.assert_array_equal(scene.compute_signed_distance([[0.5, 0.5, 0.75], [0, 0, 0], [np.nan, 0, 0]], 0, 3),
                                      [-0.25, 0, np.nan])
        self.assertEqual(scene.compute_occupancy([[np.nan, 0, 0]]).tolist(), [0])
        for nsamples in (2, 0, -1, 64, 65):
            for ask in (scene.compute_occupancy, scene.compute_signed_distance):
                with self.assertRaisesRegex(ValueError, "nsamples is odd and from 1 to 63"):
                    ask(points, nsamples=nsamples)

    def test_geometries_that_are_closed_together(self):
        scene = RaycastingScene(client=self.client)
        vertices, faces = brute.box()
        scene.add_triangles(vertices, faces[:6])
        scene.add_triangles(vertices, faces[6:])
        scene.add_triangles(vertices + [0.5, 0, 0], faces)
        points = np.array([[0.25, 0.5, 0.5], [0.75, 0.5, 0.5], [1.25, 0.5, 0.5], [1.75, 0.5, 0.5]])
        np.testing.assert_array_equal(scene.compute_occupancy(points), [1, 0, 1, 0])  # parts that overlap cancel
        np.testing.assert_array_equal(scene.compute_signed_distance(points), [-0.25, 0.25, -0.25, 0.25])

    def test_pinhole(self):
        rays = RaycastingScene.create_rays_pinhole(90, center=[0, 0, 0], eye=[0, 0, -2], up=[0, 1, 0], width_px=4,
                                                   height_px=2)
        self.assertEqual((rays.shape, rays.dtype), ((2, 4, 6), np.float32))
        np.testing.assert_allclose(rays[0, 0], [0, 0, -2, -0.75, -0.25, 1])
        np.testing.assert_allclose(rays[1, 3], [0, 0, -2, 0.75, 0.25, 1])
        intrinsic = [[2, 0, 2], [0, 2, 1], [0, 0, 1]]
        extrinsic = np.eye(4)
        extrinsic[2, 3] = 2
        np.testing.assert_allclose(RaycastingScene.create_rays_pinhole(intrinsic, extrinsic, 4, 2), rays)
        with self.assertRaisesRegex(ValueError, "along the view"):
            RaycastingScene.create_rays_pinhole(90, [0, 0, 0], [0, 0, -2], [0, 0, 1], 4, 2)

    def test_closest_points(self):
        vertices, faces = brute.box()
        self.assertEqual(self.scene.add_triangles(vertices - [0, 0, 10], faces), 1)
        points = np.random.default_rng(5).uniform(-1, 2, (4, 50, 3)).astype("f4")
        points[1] -= [0, 0, 10]
        answer = self.scene.compute_closest_points(points)
        self.assertEqual({name: column.shape[2:] for name, column in answer.items()}, {
            "points": (3,), "geometry_ids": (), "primitive_ids": (), "primitive_uvs": (2,), "primitive_normals": (3,)})
        self.assertEqual([column.dtype.str for column in answer.values()], ["<f4", "<u4", "<u4", "<f4", "<f4"])
        self.assertEqual({column.shape[:2] for column in answer.values()}, {(4, 50)})
        self.assertEqual([set(row) for row in answer["geometry_ids"].tolist()], [{0}, {1}, {0}, {0}])
        upper = [0, 2, 3]
        table, nearest = brute.distances(*self.mesh, points[upper].reshape(-1, 3))
        face = table.argmin(axis=1)
        np.testing.assert_array_equal(answer["primitive_ids"][upper].reshape(-1), face)
        np.testing.assert_allclose(answer["points"][upper].reshape(-1, 3), nearest[np.arange(150), face], atol=1e-6)
        distance = self.scene.compute_distance(points)
        self.assertEqual((distance.shape, distance.dtype), ((4, 50), np.float32))
        np.testing.assert_allclose(distance.numpy()[upper].reshape(-1), table.min(axis=1), rtol=1e-6)
        np.testing.assert_allclose(np.linalg.norm(answer["points"] - points, axis=-1), distance, rtol=1e-4, atol=1e-6)
        self.assertEqual(self.scene.compute_distance([0.5, 0.5, -12]).shape, ())

    def test_closest_points_of_nothing_and_of_no_point(self):
        empty = RaycastingScene(client=self.client)
        for scene, point, distance in ((empty, [[0, 0, 0]], np.inf), (self.scene, [[np.nan, 0, 0]], np.nan)):
            np.testing.assert_array_equal(scene.compute_distance(point), [distance])
            answer = scene.compute_closest_points(point)
            self.assertTrue(np.isnan(answer["points"]).all())
            self.assertEqual(answer["geometry_ids"].tolist(), [RaycastingScene.INVALID_ID])
            self.assertEqual(answer["primitive_ids"].tolist(), [RaycastingScene.INVALID_ID])
