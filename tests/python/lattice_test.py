"""Surfaces that are cut into meshes far from the origin: rays at the seams hit once."""

import types
import unittest
import warnings

import brute
import numpy as np
import sightline
from shared import ServerTest
from sightline._lattice import Lattice
from sightline.open3d_t import RaycastingScene

UTM = np.array([388096.37, 3948996.81, 41.25])
ECEF = np.array([3969478.123, 1004892.456, 4873791.789])


def grid(columns, rows, cell, frame=np.eye(3), at=UTM, seed=1):
    """A rough surface of columns x rows vertices, (rows, columns, 3) float64, in a frame at a place."""
    rng = np.random.default_rng(seed)
    y, x = np.mgrid[:rows, :columns].astype(float)
    jitter = rng.uniform(-0.2, 0.2, (2, rows, columns))
    local = np.stack([cell * (x + jitter[0]), cell * (y + jitter[1]), cell * rng.uniform(0, 0.5, (rows, columns))], axis=-1)
    return local @ np.asarray(frame).T + at


def mesh_of(points):
    """Vertices and faces of a grid or a part of one."""
    rows, columns = points.shape[:2]
    number = np.arange(rows * columns).reshape(rows, columns)
    a, b, c, d = number[:-1, :-1], number[:-1, 1:], number[1:, :-1], number[1:, 1:]
    faces = np.concatenate([np.stack([a, b, d], -1).reshape(-1, 3), np.stack([a, d, c], -1).reshape(-1, 3)])
    return points.reshape(-1, 3), faces


def tiles(points, cuts):
    """Meshes of the parts between cuts, which are numbers of rows and columns; neighbours share vertices."""
    return [mesh_of(points[r0:r1 + 1, c0:c1 + 1]) for r0, r1 in zip(cuts, cuts[1:]) for c0, c1 in zip(cuts, cuts[1:])]


def seam_rays(points, cuts, count, up, height, seed=2):
    """float64 (count, 6) that cross the surface where inner cuts run: at vertices, and anywhere on the edges."""
    rng = np.random.default_rng(seed)
    last = points.shape[0] - 1
    which, along = rng.choice(cuts[1:-1], count), rng.integers(1, last - 1, count)
    part = np.where(rng.random(count) < 0.4, 0.0, rng.random(count))[:, None]
    turned = rng.random(count) < 0.5
    first = np.where(turned[:, None], points[which, along], points[along, which])
    second = np.where(turned[:, None], points[which, along + 1], points[along + 1, which])
    targets = first + part * (second - first)
    lean = rng.uniform(-0.2, 0.2, (count, 3)) * (rng.random((count, 1)) < 0.7)
    origins = targets + height * (np.asarray(up) + lean)
    return np.hstack([origins, targets - origins])


def turned_frame():
    """Columns: east, north and up at ECEF."""
    up = ECEF / np.linalg.norm(ECEF)
    east = np.cross([0, 0, 1], up)
    east /= np.linalg.norm(east)
    return np.stack([east, np.cross(up, east), up], axis=1)


class SeamTest(ServerTest):
    CUTS = [0, 7, 9, 20, 32, 39]

    def check(self, count, points):
        """Every ray counts 1."""
        lost, doubled = int((count == 0).sum()), int((count > 1).sum())
        self.assertEqual((lost, doubled), (0, 0), f"of {len(count)} rays; the surface has {len(points)} rows")

    def test_tiles_of_open3d(self):
        for cell, at, frame, up in ((25.0, UTM, np.eye(3), [0, 0, 1]), (0.01, UTM, np.eye(3), [0, 0, 1]),
                                    (300.0, UTM, np.eye(3), [0, 0, 1]), (1.0, ECEF, turned_frame(), turned_frame()[:, 2]),
                                    (1.0, [3.7, -2.2, 0.1], np.eye(3), [0, 0, 1]), (40.0, -10 * UTM, np.eye(3), [0, 0, 1])):
            with self.subTest(cell=cell, at=tuple(at)):
                points = grid(40, 40, cell, frame, at)
                scene = RaycastingScene(client=self.client)
                with warnings.catch_warnings():
                    warnings.simplefilter("error")
                    for mesh in tiles(points, self.CUTS):
                        scene.add_triangles(*mesh)
                    rays = seam_rays(points, self.CUTS, 3000, up, 10 * cell)
                    self.check(scene.count_intersections(rays), points)
                hit = scene.cast_rays(rays)["t_hit"]
                np.testing.assert_allclose(hit, 1, atol=1e-4)

    def test_tiles_that_are_added_with_origins_of_their_own(self):
        points = grid(40, 40, 25.0)
        scene = self.client.create_scene("own-origins")
        for vertices, faces in reversed(tiles(points, self.CUTS)):
            scene.add((vertices, faces), origin=vertices.mean(axis=0) + [0.1, 0.2, 0.3])
        rays = seam_rays(points, self.CUTS, 3000, [0, 0, 1], 200.0)
        self.check(scene.cast(rays, kind="count").count, points)

    def test_tiles_of_two_clients(self):
        points = grid(40, 40, 25.0)
        scene = self.client.create_scene("two-clients")
        with sightline.connect(self.server.endpoint) as other:
            for number, (vertices, faces) in enumerate(tiles(points, [0, 13, 26, 39])):
                (scene if number % 2 else other.scene("two-clients")).add((vertices, faces), origin=vertices[0])
        rays = seam_rays(points, [0, 13, 26, 39], 3000, [0, 0, 1], 200.0)
        self.check(scene.cast(rays, kind="count").count, points)

    def test_geometries_of_a_scene_of_trimesh(self):
        points = grid(40, 40, 25.0)
        meshes = {f"{number}": types.SimpleNamespace(vertices=vertices, faces=faces)
                  for number, (vertices, faces) in enumerate(tiles(points, self.CUTS))}
        edges = [("world", f"node {name}", {"geometry": name}) for name in meshes]
        graph = types.SimpleNamespace(base_frame="world", to_edgelist=lambda: edges)
        scene = self.client.create_scene("geometries")
        scene.add(types.SimpleNamespace(graph=graph, geometry=meshes))
        rays = seam_rays(points, self.CUTS, 3000, [0, 0, 1], 200.0)
        self.check(scene.cast(rays, kind="count").count, points)

    def test_vertices_that_move_stay_together(self):
        points = grid(40, 40, 25.0)
        scene = self.client.create_scene("moving-vertices")
        nodes = [scene.add(mesh, origin=UTM, mobility="deforming") for mesh in tiles(points, self.CUTS)]
        points = points + np.random.default_rng(9).uniform(-1, 1, points.shape)
        with scene.update_stream("producer") as stream:
            for number, (node, (vertices, _)) in enumerate(zip(nodes, tiles(points, self.CUTS))):
                node.patch(vertices) if number % 2 else stream.patch_vertices([node], vertices)
        rays = seam_rays(points, self.CUTS, 3000, [0, 0, 1], 200.0)
        self.check(scene.cast(rays, kind="count").count, points)


class LatticeTest(unittest.TestCase):
    def kept(self, placement, vertices):
        """Where vertices lie then."""
        return placement.residuals(vertices).astype("f8") + placement.origin

    def test_equal_vertices_stay_equal_and_near_theirs(self):
        rng = np.random.default_rng(4)
        for at in (UTM, ECEF, 1e3 * ECEF, UTM / 1e3, np.zeros(3), np.array([1e7, 0, -3.0])):
            for size in (1e-3, 0.1, 1.0, 16.0, 977.3, 1e5):
                lattice = Lattice()
                shared = at + rng.uniform(-0.5, 0.5, (50, 3)) * size
                meshes = [np.concatenate([shared, shared[:1] + rng.uniform(-1, 1, (50, 3)) * size * factor])
                          for factor in (0.6, 0.3, 0.1)]
                kept = [self.kept(lattice.place(vertices), vertices)[:50] for vertices in meshes]
                np.testing.assert_array_equal(kept[0], kept[1])
                np.testing.assert_array_equal(kept[0], kept[2])
                allowed = max(1e-4 * size, 2e-16 * np.abs(at).max())
                self.assertLessEqual(np.abs(kept[0] - shared).max(), allowed, (at, size))

    def test_float32_vertices_do_not_move(self):
        rng = np.random.default_rng(5)
        for at in (UTM, ECEF, np.zeros(3)):
            for size in (0.1, 30.0, 5e4):
                vertices = (at + rng.uniform(-1, 1, (100, 3)) * size).astype("f4")
                if np.ptp(vertices, axis=0).max() > 0:
                    np.testing.assert_array_equal(self.kept(Lattice().place(vertices), vertices), vertices)

    def test_a_small_mesh_of_a_scene_is_not_made_coarse(self):
        lattice = Lattice()
        lattice.place(mesh_of(grid(20, 20, 1000.0, at=UTM + 1e6))[0])
        box = brute.box()[0] * 0.1 + UTM
        placement = lattice.place(box)
        np.testing.assert_allclose(np.ptp(self.kept(placement, box), axis=0), 0.1, rtol=1e-4)

    def test_sizes_too_different_to_share_vertices_are_warned_about(self):
        box, lattice = brute.box()[0], Lattice()
        lattice.place(UTM + 0.1 * box)
        with self.assertWarnsRegex(sightline.PrecisionWarning, "differ so much in size"):
            lattice.place(UTM + 10000 * box)
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            lattice.place(UTM + 10000 * box)  # once a scene
            near, apart = Lattice(), Lattice()
            for size in (0.1, 10000.0):
                near.place(size * box)  # at the origin floats are floats
                apart.place(UTM + size * (1 + box))

    def test_what_has_no_size(self):
        for vertices in (np.zeros((0, 3)), np.full((3, 3), np.nan), np.tile(UTM, (3, 1)), [[1e308] * 3, [-1e308] * 3]):
            self.assertFalse(Lattice().place(np.asarray(vertices)).origin.any())
