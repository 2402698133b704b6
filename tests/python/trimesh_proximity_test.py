"""The class and the functions for programs that were written for trimesh.proximity."""

import copy
import gc
import os
import pickle
import threading
import time
import types
import warnings

import brute
import numpy as np
from shared import ServerTest
from sightline import _meshes_of
from sightline.trimesh_proximity import (ProximityQuery, closest_point, longest_ray, max_tangent_sphere, signed_distance,
                                         thickness)

ODD = 1 / 3  # times this, vertices of a box are no floats


class Solid:
    """A mesh, as other libraries have them."""

    def __init__(self, vertices, faces, is_watertight=True):
        self.vertices, self.faces, self.is_watertight = np.asarray(vertices, "f8"), np.asarray(faces), is_watertight


def boxes(*bounds):
    """A mesh of boxes, each from low (3) to high (3)."""
    vertices, faces = brute.box()
    parts = [np.asarray(low) + vertices * (np.asarray(high) - low) for low, high in bounds]
    return Solid(np.concatenate(parts), np.concatenate([faces + 8 * k for k in range(len(parts))]))


def somewhere(count, low=-1.0, high=2.0, seed=4):
    return np.random.default_rng(seed).uniform(low, high, (count, 3))


def height_of(points, high=1.0):
    """(n): distances of points (n, 3) from a box at the origin, negative inside."""
    beside = np.maximum(-points, points - high)
    return np.where((beside < 0).all(axis=1), beside.max(axis=1), np.linalg.norm(np.maximum(beside, 0), axis=1))


class OnSurfaceTest(ServerTest):
    def test_box(self):
        for size in (1.0, ODD):
            query = ProximityQuery(boxes(([0, 0, 0], [size] * 3)), client=self.client)
            points = size * somewhere(2000)
            closest, distance, face = query.on_surface(points)
            np.testing.assert_allclose(distance, np.abs(height_of(points, size)), rtol=1e-14)
            np.testing.assert_allclose(np.linalg.norm(closest - points, axis=1), distance, rtol=1e-13)
            self.assertLess(np.abs(height_of(closest, size)).max(), 1e-15)
            self.assertEqual((closest.shape, closest.dtype, distance.dtype, face.dtype),
                             ((2000, 3), np.float64, np.float64, np.int64))
            corners = query.mesh.vertices[query.mesh.faces[face]]
            self.assertTrue((closest >= corners.min(axis=1) - 1e-15).all() and
                            (closest <= corners.max(axis=1) + 1e-15).all())

    def test_any_triangles(self):
        rng = np.random.default_rng(2)
        mesh = Solid(rng.normal(size=(300, 3)), rng.integers(0, 300, (200, 3)), False)
        points = rng.normal(size=(500, 3)) * 2
        corners = mesh.vertices[mesh.faces]
        closest, distance, face = closest_point(mesh, points, client=self.client)
        _, expected, _ = self.least(corners, points)
        np.testing.assert_allclose(distance, expected, rtol=1e-6)
        own, single, _ = self.least(corners[face][:, None], points)
        np.testing.assert_allclose(distance, single, rtol=1e-12)
        np.testing.assert_allclose(closest, own, atol=1e-12)

    @staticmethod
    def least(corners, points):
        """Nearest points and distances, by steps along every triangle's sides and a look at its plane."""
        corners = np.broadcast_to(corners, (len(points), *corners.shape[-3:])) if corners.ndim == 3 else corners
        best, where = np.full(corners.shape[:2], np.inf), np.zeros(corners.shape[:2] + (3,))
        given = points[:, None]

        def offer(candidate, there):
            length = np.where(there, np.linalg.norm(candidate - given, axis=-1), np.inf)
            nearer = length < best
            where[nearer], best[nearer] = candidate[nearer], length[nearer]

        for k in range(3):
            start, along = corners[..., k, :], corners[..., (k + 1) % 3, :] - corners[..., k, :]
            share = ((given - start) * along).sum(-1) / np.maximum((along ** 2).sum(-1), 1e-300)
            offer(start + np.clip(share, 0, 1)[..., None] * along, True)
        normal = np.cross(corners[..., 1, :] - corners[..., 0, :], corners[..., 2, :] - corners[..., 0, :])
        square = np.maximum((normal ** 2).sum(-1), 1e-300)
        foot = given - (((given - corners[..., 0, :]) * normal).sum(-1) / square)[..., None] * normal
        offer(foot, np.all([(np.cross(corners[..., (k + 1) % 3, :] - corners[..., k, :], foot - corners[..., k, :])
                             * normal).sum(-1) > 0 for k in range(3)], axis=0))
        row = best.argmin(axis=1)
        return where[np.arange(len(points)), row], best.min(axis=1), row

    def test_of_equally_near_faces_the_one_that_looks_at_the_point(self):
        # Two walls that meet in the z axis: one looks along -x, the other along -y.
        walls = Solid([[0, 0, 0], [0, 0, 1], [0, 1, 0], [1, 0, 0]], [[0, 1, 2], [0, 3, 1]], False)
        points = [[-1, -0.25, 0.25], [-0.25, -1, 0.25], [-1, -0.5, 0.5]]
        closest, _, face = closest_point(walls, points, client=self.client)
        self.assertEqual(face.tolist(), [0, 1, 0])
        np.testing.assert_allclose(closest, [[0, 0, 0.25], [0, 0, 0.25], [0, 0, 0.5]], atol=1e-15)
        # A floor and a wall, the floor seen from behind: it is 1e-9 nearer, and the wall looks at the point.
        corner = Solid([[0, 0, 0], [0, 2, 0], [-2, 0, 0], [0, 0, -2]], [[0, 1, 2], [0, 1, 3]], False)
        for beside, expected in ((1e-9, 1), (-1e-9, 1), (1e-4, 0), (-1e-4, 1)):
            closest, distance, face = closest_point(corner, [[-0.5 - beside, 0.25, -0.5]], client=self.client)
            self.assertEqual((face.tolist(), distance.tolist()), ([expected], [0.5 + beside if expected else 0.5]))
            np.testing.assert_allclose(closest[0], [0, 0.25, -0.5] if expected else [-0.5 - beside, 0.25, 0], atol=1e-15)

    def test_vertices(self):
        rng = np.random.default_rng(7)
        points = rng.random((300, 3))
        for vertices in (rng.random((100, 3)), rng.random((100, 3)).astype("f4")):
            mesh = Solid(vertices, rng.integers(10, 100, (150, 3)), False)
            used = np.unique(mesh.faces)
            table = np.linalg.norm(points[:, None] - mesh.vertices[used], axis=-1)
            distance, number = ProximityQuery(mesh, client=self.client).vertex(points)
            np.testing.assert_allclose(distance, table.min(axis=1), rtol=1e-14)
            np.testing.assert_array_equal(number, used[table.argmin(axis=1)])
            self.assertEqual((distance.dtype, number.dtype), (np.float64, np.int64))
            one = ProximityQuery(mesh, client=self.client).vertex(points[0])
            self.assertEqual((one, np.shape(one[0])), ((distance[0], number[0]), ()))

    def test_far_from_the_origin(self):
        far = np.array([4e6, 5e6, 0.0])
        mesh = boxes((far + 0.1, far + 1.1))
        query = ProximityQuery(mesh, client=self.client)
        points = somewhere(300) + 0.1
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            np.testing.assert_allclose(query.on_surface(points + far)[1], np.abs(height_of(points - 0.1)), atol=1e-8)
            np.testing.assert_allclose(query.signed_distance(points + far), -height_of(points - 0.1), atol=1e-8)
            np.testing.assert_allclose(query.vertex([far + 0.1])[0], [0], atol=1e-8)

    def test_points_and_meshes_without_an_answer(self):
        mesh, nothing = boxes(([0, 0, 0], [1, 1, 1])), Solid(np.zeros((0, 3)), np.zeros((0, 3), int))
        points = [[np.nan, 0, 0], [0.5, 0.5, 0.25], [np.inf, 0, 0]]
        query = ProximityQuery(mesh, client=self.client)
        closest, distance, face = query.on_surface(points)
        np.testing.assert_array_equal(distance, [np.nan, 0.25, np.nan])
        np.testing.assert_array_equal(closest, [[np.nan] * 3, [0.5, 0.5, 0], [np.nan] * 3])
        self.assertEqual((face[0], face[2]), (-1, -1))
        np.testing.assert_array_equal(query.signed_distance(points), [np.nan, 0.25, np.nan])
        distance, number = query.vertex(points)
        self.assertEqual((np.isnan(distance).tolist(), number.tolist()), ([True, False, True], [-1, 0, -1]))
        query = ProximityQuery(nothing, client=self.client)
        closest, distance, face = query.on_surface([[0, 0, 0]])
        self.assertEqual((np.isnan(closest).all(), distance.tolist(), face.tolist()), (True, [np.inf], [-1]))
        self.assertEqual(query.signed_distance([[0, 0, 0]]).tolist(), [-np.inf])
        self.assertEqual([part.tolist() for part in query.vertex([[0, 0, 0]])], [[np.inf], [-1]])
        self.assertEqual([len(part) for part in ProximityQuery(mesh, client=self.client).on_surface(np.zeros((0, 3)))],
                         [0, 0, 0])
        for points in ([0, 0, 0], [[0, 0]], np.zeros((2, 2, 3))):
            for ask in (query.on_surface, query.signed_distance):
                with self.assertRaisesRegex(ValueError, "points have the shape \\(n, 3\\)"):
                    ask(points)
        with self.assertRaisesRegex(TypeError, "a mesh is needed"):
            ProximityQuery(None)


class SignedDistanceTest(ServerTest):
    def test_box(self):
        for size in (1.0, ODD):
            mesh, points = boxes(([0, 0, 0], [size] * 3)), size * somewhere(2000)
            np.testing.assert_allclose(signed_distance(mesh, points, client=self.client), -height_of(points, size),
                                       rtol=1e-13)

    def test_on_planes_and_near_the_surface(self):
        mesh = boxes(([0, 0, 0], [1, 1, 1]))
        points = [[100, 0, 0], [-3, 1, 1], [2, 2, 2], [0.5, 0.5, 0.5], [0.5, 0, 0], [0.5, 0.5, 1 + 5e-9],
                  [0.5, 0.5, 1 + 1e-7], [0.5, 0.5, 1 - 1e-7]]
        signed = signed_distance(mesh, points, client=self.client)
        np.testing.assert_allclose(signed, [-99, -3, -np.sqrt(3), 0.5, 0, 5e-9, -1e-7, 1e-7], rtol=1e-8)

    def test_open_surface(self):
        floor = Solid([[0, 0, 0], [4, 0, 0], [4, 4, 0], [0, 4, 0]], [[0, 1, 2], [0, 2, 3]], False)
        points = [[3, 1, 2], [3, 1, -2], [2, 2, 1], [2, 2, -1], [9, 2, 1]]
        np.testing.assert_allclose(signed_distance(floor, points, client=self.client), [-2, 2, -1, 1, -np.sqrt(26)])

    def test_edges_that_are_sharp(self):
        vertices = np.array([[-1, 0, 0], [1, 0, 0], [0, -3, -0.01], [0, -3, 0.01]])
        blade = Solid(vertices, [[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]])
        points = np.stack([np.linspace(-0.9, 0.9, 40), np.full(40, 0.5), np.linspace(-1, 1, 40)], axis=1)
        distance = np.hypot(points[:, 1], points[:, 2])
        np.testing.assert_allclose(signed_distance(blade, points, client=self.client), -distance, rtol=1e-12)


class ThicknessTest(ServerTest):
    def test_rays(self):
        mesh = boxes(([0, 0, 0], [1, 2, 3]))
        points, directions = [[0.5, 0.5, 0], [0.5, 0.5, 0], [0, 1, 1], [2, 1, 1], [0.5, 1, 1]], \
            [[0, 0, 1], [0, 0, -7], [5, 0, 0], [-0.1, 0, 0], [0, 2, 2]]
        for some in (mesh, boxes(([0, 0, 0], [1, 2, 3 + 1e-9]))):
            np.testing.assert_allclose(longest_ray(some, points, directions, client=self.client),
                                       [3, np.inf, 1, 1, np.sqrt(2)], rtol=1e-6)
        self.assertTrue(np.isnan(longest_ray(mesh, [[0, 0, np.nan], [0, 0, 0]], [[0, 0, 1], [0, 0, 0]],
                                             client=self.client)).all())
        with self.assertRaisesRegex(ValueError, "points and directions have one shape"):
            longest_ray(mesh, points, directions[:2], client=self.client)

    def test_spheres_in_a_box(self):
        mesh = boxes(([0, 0, 0], [1, 1, 1]))
        rng = np.random.default_rng(5)
        points = np.column_stack([rng.random((300, 2)), np.ones(300)])
        normals = np.broadcast_to([0, 0, 1.0], points.shape)
        side = np.minimum(points, 1 - points)[:, :2].min(axis=1)
        for given in (normals, 3 * normals, None):
            centers, radii = max_tangent_sphere(mesh, points, normals=given, client=self.client)
            np.testing.assert_allclose(radii, np.minimum(side, 0.5), atol=1e-5)
            np.testing.assert_allclose(centers, points - radii[:, None] * normals, rtol=1e-14)
        centers, radii = max_tangent_sphere(mesh, points, inwards=False, normals=normals, client=self.client)
        self.assertTrue(np.isinf(radii).all() and np.isnan(centers).all())
        for exterior, expected in ((False, 2 * np.minimum(side, 0.5)), (True, np.full(300, np.inf))):
            np.testing.assert_allclose(thickness(mesh, points, exterior, normals, client=self.client), expected, atol=1e-5)

    def test_spheres_beside_a_wall(self):
        # A floor, whose rays upward meet nothing, and a wall of height 1 beside it.
        for size in (1.0, ODD, 300.0):
            mesh = boxes((np.array([0, -4, -1]) * size, np.array([8, 4, 0]) * size),
                         (np.array([-1, -4, -1]) * size, np.array([0, 4, 1]) * size))
            away = np.linspace(0.1, 7.5, 200)
            points = np.stack([away, np.full(200, 0.3), np.zeros(200)], axis=1) * size
            expected = np.where(away <= 1, away, (away ** 2 + 1) / 2) * size
            _, radii = max_tangent_sphere(mesh, points, False, np.broadcast_to([0, 0, 1.0], points.shape),
                                          threshold=1e-9, client=self.client)
            np.testing.assert_allclose(radii, expected, rtol=1e-4)
            _, few = max_tangent_sphere(mesh, points, False, threshold=1e-9, max_iter=1, client=self.client)
            self.assertTrue((few >= radii * (1 - 1e-9)).all() and (few > radii * 1.01).any())

    def test_plates(self):
        mesh = boxes(([0, 0, 0], [10, 10, 0.25]), ([0, 0, 1.25], [10, 10, 2]))
        points = np.column_stack([np.random.default_rng(1).uniform(3, 7, (100, 2)), np.full(100, 0.25)])
        for method in ("max_sphere", "ray"):
            np.testing.assert_allclose(thickness(mesh, points, method=method, client=self.client), 0.25, rtol=1e-6)
            np.testing.assert_allclose(thickness(mesh, points, exterior=True, method=method, client=self.client), 1,
                                       rtol=1e-6)
        with self.assertRaisesRegex(ValueError, "method is max_sphere or ray, not 'sphere'"):
            thickness(mesh, points, method="sphere", client=self.client)
        with self.assertRaisesRegex(ValueError, "points and normals have one shape"):
            thickness(mesh, points, normals=[[0, 0, 1]], client=self.client)
        nothing = Solid(np.zeros((0, 3)), np.zeros((0, 3), int))
        centers, radii = max_tangent_sphere(nothing, points[:2], normals=points[:2], client=self.client)
        self.assertTrue(np.isnan(centers).all() and np.isinf(radii).all())


class SceneTest(ServerTest):
    def count(self, expected):
        """Waits until the server has as many scenes: they are deleted by another thread."""
        for _ in range(1000):
            gc.collect()
            if len(self.client.scenes()) == expected:
                break
            time.sleep(0.01)
        self.assertEqual(len(self.client.scenes()), expected)

    def test_a_changed_mesh_is_noticed(self):
        mesh = boxes(([0, 0, 0], [1, 1, 1]))
        query, point = ProximityQuery(mesh, client=self.client), [[0.5, 0.5, 3.0]]
        for ask in (lambda: query.on_surface(point)[1], lambda: -query.signed_distance(point),
                    lambda: closest_point(mesh, point, client=self.client)[1],
                    lambda: longest_ray(mesh, point, [[0, 0, -1]], client=self.client)):
            self.assertEqual(ask().tolist(), [2])
            mesh.vertices += [0, 0, 1]
            self.assertEqual(ask().tolist(), [1])
            mesh.vertices -= [0, 0, 1]
        self.assertAlmostEqual(query.vertex(point)[0][0], np.sqrt(4.5))
        mesh.vertices *= 2
        self.assertAlmostEqual(query.vertex(point)[0][0], np.sqrt(1.5))

    def test_scenes_end_with_what_needs_them(self):
        mesh = boxes(([0, 0, 0], [1, 1, 1]))
        self.count(0)
        for _ in range(3):
            closest_point(mesh, [[0, 0, 2]], client=self.client)
            thickness(mesh, [[0.5, 0.5, 1]], client=self.client)
        self.count(1)
        mesh.nearest = ProximityQuery(mesh, client=self.client)  # a cycle, as trimesh makes it
        mesh.nearest.vertex([[0, 0, 2]])
        self.count(3)
        del mesh
        self.count(0)
        plain = types.SimpleNamespace(**vars(boxes(([0, 0, 0], [1, 1, 1]))))  # one cannot tell when it ends
        self.assertEqual(closest_point(plain, [[0, 0, 2]], client=self.client)[1].tolist(), [1])
        self.count(0)

    def test_threads_share_a_mesh(self):
        self.count(0)
        mesh, points, answers = boxes(([0, 0, 0], [1, 1, 1])), somewhere(3000), []
        threads = [threading.Thread(target=lambda: answers.append(signed_distance(mesh, points, client=self.client)))
                   for _ in range(8)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual(len(answers), 8)
        for answer in answers:
            np.testing.assert_allclose(answer, -height_of(points), rtol=1e-13)
        self.count(1)

    def test_pickles_and_copies(self):
        os.environ["SIGHTLINE_ENDPOINT"] = self.server.endpoint
        self.addCleanup(os.environ.pop, "SIGHTLINE_ENDPOINT")
        _meshes_of._clients.clear()  # another file's, in this process
        self.addCleanup(_meshes_of._clients.clear)
        mesh = boxes(([0, 0, 0], [1, 1, 1]))
        query = mesh.nearest = ProximityQuery(mesh)
        for other in (pickle.loads(pickle.dumps(query)), copy.copy(query), copy.deepcopy(query),
                      pickle.loads(pickle.dumps(mesh)).nearest):
            self.assertEqual(other.on_surface([[0.5, 0.5, 3]])[1].tolist(), [2])
        self.assertEqual(signed_distance(mesh, [[0.5, 0.5, 3]]).tolist(), [-2])
