"""On which side of surfaces points are, compared with formulas."""

import types
import unittest

import brute
import numpy as np
import sightline
from shared import ServerTest

try:
    import pandas
except ImportError:
    pandas = None

RULES = ("parity", "winding", "normal")
SIDES = ("signed", "inside", "votes")


def somewhere(count, low=-1.0, high=2.0, seed=8):
    """Points (n, 3) in a cube."""
    return np.random.default_rng(seed).uniform(low, high, (count, 3))


def height_of(points, low=0.0, high=1.0):
    """(...): distances of points (..., 3) from a box, negative inside."""
    beside = np.maximum(low - points, points - high)
    outside = np.linalg.norm(np.maximum(beside, 0), axis=-1)
    return np.where((beside < 0).all(axis=-1), beside.max(axis=-1), outside)


def moved(mesh, by, scale=1.0):
    return mesh[0] * scale + by, mesh[1]


def icosphere(rounds=3):
    """A closed mesh, its vertices on the unit sphere."""
    golden = (1 + 5 ** 0.5) / 2
    vertices = np.array([[s, t * golden, 0] for s in (-1, 1) for t in (-1, 1)])
    vertices = np.concatenate([np.roll(vertices, k, axis=1) for k in range(3)])
    table = np.linalg.norm(vertices[:, None] - vertices, axis=-1)
    beside = np.isclose(table, 2)
    faces = np.array([[i, j, k] for i in range(12) for j in range(i) for k in range(j)
                      if beside[i, j] and beside[j, k] and beside[k, i]])
    for _ in range(rounds):
        a, b, c = faces.T
        pairs, row = np.unique(np.sort(np.stack([[a, b], [b, c], [c, a]]).transpose(0, 2, 1), axis=2).reshape(-1, 2),
                               axis=0, return_inverse=True)
        ab, bc, ca = row.reshape(3, -1) + len(vertices)
        vertices = np.concatenate([vertices, vertices[pairs].mean(axis=1)])
        faces = np.concatenate([np.stack(three, axis=1) for three in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))])
    vertices /= np.linalg.norm(vertices, axis=1, keepdims=True)
    corners = vertices[faces]
    turned = np.einsum("ij,ij->i", np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), corners[:, 0]) < 0
    faces[turned] = faces[turned, ::-1]
    return vertices, faces


class FormulaTest(ServerTest):
    def test_box(self):
        scene = self.scene_of(brute.box())
        points = somewhere(3000)
        height = height_of(points)
        for side in RULES:
            fields = ("distance", "signed", "inside", *(() if side == "normal" else ("votes",)))
            near = scene.closest(points, fields=fields, side=side)
            np.testing.assert_allclose(near.signed, height, rtol=1e-14)
            np.testing.assert_array_equal(np.abs(near.signed), near.distance)
            np.testing.assert_array_equal(near.inside, height < 0)
            self.assertEqual((near.signed.dtype, near.inside.dtype), (np.float64, np.bool_))
            self.assertTrue(near.hit.all() and not near.invalid.any())
            np.testing.assert_array_equal(scene.contains(points, side=side), height < 0)
        for side in ("parity", "winding"):
            near = scene.closest(points, fields=("votes",), side=side, side_rays=5)
            np.testing.assert_array_equal(near.votes, np.where(height < 0, 5, 0))
            self.assertEqual(near.votes.dtype, np.uint8)

    def test_planes_edges_and_corners(self):
        scene = self.scene_of(brute.box())
        axis = np.array([-1, 0, 0.25, 0.5, 1, np.nextafter(1, 2), np.nextafter(1, 0), 1.5])
        points = np.stack(np.meshgrid(axis, axis, axis, indexing="ij"), axis=-1)
        outside, inside = ((points < 0) | (points > 1)).any(axis=-1), ((points > 0) & (points < 1)).all(axis=-1)
        for side in RULES:
            near = scene.closest(points, fields=("signed", "inside"), side=side)
            self.assertFalse(near.inside[outside].any())
            self.assertTrue(near.inside[inside].all())
            np.testing.assert_array_equal(np.sign(near.signed[outside]), 1)
            np.testing.assert_array_equal(np.sign(near.signed[inside]), -1)
            on_it = near.signed[~outside & ~inside]
            self.assertTrue((on_it == 0).all() and not np.signbit(on_it).any())

    def test_sphere(self):
        scene = self.scene_of(icosphere())
        points = somewhere(3000, -1.5, 1.5)
        length = np.linalg.norm(points, axis=1)
        clear = np.abs(length - 1) > 0.02  # the mesh is within 0.01 of the sphere
        for side in RULES:
            near = scene.closest(points, fields=("signed", "inside"), side=side)
            np.testing.assert_allclose(near.signed, length - 1, atol=0.01)
            np.testing.assert_array_equal(near.inside[clear], length[clear] < 1)
            np.testing.assert_array_equal(near.inside, near.signed < 0)

    def test_parts_that_overlap(self):
        scene = self.client.create_scene("overlap")
        scene.add(brute.box())
        scene.add(moved(brute.box(), [0.5, 0, 0]))
        scene.add(moved(brute.box(), [3, 0, 0]), name="beside")
        points = somewhere(3000, -0.5, 4)
        one, two, three = (((points > low) & (points < np.array(low) + 1)).all(axis=1)
                           for low in ([0, 0, 0], [0.5, 0, 0], [3, 0, 0]))
        self.assertTrue((one & two).any())
        np.testing.assert_array_equal(scene.contains(points), one ^ two ^ three)
        np.testing.assert_array_equal(scene.contains(points, side="winding"), one | two | three)
        np.testing.assert_array_equal(scene.contains(points, side="winding", side_rays=7), one | two | three)

    def test_cavities_and_turned_faces(self):
        vertices, faces = brute.box()
        hollow = (np.concatenate([vertices, vertices * 0.5 + 0.25]), np.concatenate([faces, faces[:, ::-1] + 8]))
        points = somewhere(2000, -0.2, 1.2)
        inside = (height_of(points) < 0) & (height_of(points, 0.25, 0.75) > 0)
        scene = self.scene_of(hollow)
        for side in RULES:
            np.testing.assert_array_equal(scene.contains(points, side=side), inside)
        turned = faces.copy()
        turned[::3] = turned[::3, ::-1]
        scene = self.client.import_arrays("turned", vertices, turned)
        np.testing.assert_array_equal(scene.contains(points), height_of(points) < 0)

    def test_nodes_that_close_together(self):
        vertices, faces = brute.box()
        scene = self.client.create_scene("six-nodes")
        with scene.batch():
            for k in range(0, 12, 2):
                scene.add((vertices, faces[k:k + 2]), name=f"side {k}")
        points = somewhere(2000)
        np.testing.assert_array_equal(scene.contains(points), height_of(points) < 0)
        np.testing.assert_array_equal(scene.contains(points, side="winding"), height_of(points) < 0)
        self.assertFalse(scene.contains(points, exclude=[1])[height_of(points) > 0].all())

    def test_terrain(self):
        y, x = np.mgrid[:30, :40].astype(float)
        heights = np.sin(x / 3) + np.cos(y / 4)
        number = np.arange(1200).reshape(30, 40)
        a, b, c, d = (part.ravel() for part in (number[:-1, :-1], number[:-1, 1:], number[1:, :-1], number[1:, 1:]))
        mesh = (np.stack([x, y, heights], axis=-1).reshape(-1, 3),
                np.concatenate([np.stack([a, b, d], axis=1), np.stack([a, d, c], axis=1)]))
        scene = self.scene_of(mesh, up_axis="z")
        points = np.random.default_rng(3).uniform([5, 5, -4], [33, 23, 4], (2000, 3))
        above = brute.closest(*mesh, points, np.broadcast_to([0, 0, 1.0], points.shape))[0]
        below = brute.closest(*mesh, points, np.broadcast_to([0, 0, -1.0], points.shape))[0]
        self.assertTrue((np.isfinite(above) ^ np.isfinite(below)).all())
        near = scene.closest(points, fields=("signed", "inside", "distance"), side="normal")
        np.testing.assert_array_equal(near.inside, np.isfinite(above))
        np.testing.assert_array_equal(near.signed, np.where(np.isfinite(above), -near.distance, near.distance))

    def test_holes_show_in_votes(self):
        vertices, faces = brute.box()
        scene = self.client.import_arrays("hole", vertices, faces[1:])
        points = somewhere(2000, -0.2, 1.2)
        inside = height_of(points) < 0
        near = scene.closest(points, fields=("inside", "votes"), side_rays=31)
        self.assertTrue(((near.votes > 0) & (near.votes < 31)).any())
        np.testing.assert_array_equal(near.inside, near.votes > 15)
        single = scene.contains(points)
        self.assertLess((near.inside != inside).mean(), 0.05)
        self.assertLess((near.inside != inside).sum(), (single != inside).sum())


class SidesTest(ServerTest):
    def setUp(self):
        self.scene = self.scene_of(brute.box())
        self.points = somewhere(300)
        self.inside = height_of(self.points) < 0

    def test_they_do_not_depend_on_max_distance(self):
        near = self.scene.closest(self.points, 0.05, fields=("signed", "inside", "votes"))
        np.testing.assert_array_equal(near.inside, self.inside)
        np.testing.assert_array_equal(near.votes, self.inside)
        far = np.abs(height_of(self.points)) > 0.05
        self.assertTrue((far & self.inside).any())
        self.assertEqual(set(near.signed[far]), {np.inf})
        np.testing.assert_array_equal(near.hit, ~far)
        self.assertTrue((near.signed[~far & self.inside] < 0).all())

    def test_shapes_and_types(self):
        for shape in ((300,), (3, 100), (5, 3, 20), (300, 1)):
            inside = self.scene.contains(self.points.reshape(*shape, 3))
            self.assertEqual((inside.shape, inside.dtype), (shape, np.bool_))
            np.testing.assert_array_equal(inside.ravel(), self.inside)
        self.assertTrue(bool(self.scene.contains([0.5, 0.5, 0.5])))
        self.assertEqual(self.scene.contains(self.points.tolist()).tolist(), self.inside.tolist())
        self.assertEqual(self.scene.contains(np.zeros((4, 0, 3))).shape, (4, 0))
        single = self.points.astype("f4")
        near, again = (self.scene.closest(points, fields=("signed",)) for points in (single, single.astype("f8")))
        np.testing.assert_array_equal(near.signed, again.signed)
        grid = sightline.PointGrid([-0.5, -0.5, 0.5], [0.25, 0, 0], [0, 0.25, 0], 9, 7, max_distance=0.1)
        np.testing.assert_array_equal(self.scene.contains(grid), self.scene.contains(grid.positions()))
        self.assertEqual(self.scene.contains(grid).shape, (7, 9))

    def test_many_points_and_batches(self):
        many = np.tile(self.points, (70, 1)).reshape(7, 3000, 3)
        near = self.scene.closest(many, fields=SIDES, side="winding", side_rays=3)
        np.testing.assert_array_equal(near.inside.reshape(70, 300), np.tile(self.inside, (70, 1)))
        np.testing.assert_array_equal(near.votes, 3 * near.inside)
        parts = np.array_split(self.points, 7)
        answers = self.scene.contains(iter(parts))
        np.testing.assert_array_equal(np.concatenate(list(answers)), self.inside)
        signed = [near.signed for near in self.scene.closest(iter(parts), fields=("signed",))]
        np.testing.assert_array_equal(np.concatenate(signed) < 0, self.inside)

    def test_invalid_points(self):
        points = self.points.copy()
        points[3, 0], points[5, 2], points[7, 1] = np.nan, np.inf, 1e80
        for fields in (SIDES, ("inside",), ("votes",), ("inside", "distance")):
            near = self.scene.closest(points, fields=fields)
            self.assertEqual(np.flatnonzero(near.invalid).tolist(), [3, 5, 7])
            self.assertEqual(near.stats["invalid"], 3)
            self.assertFalse(near.inside[[3, 5, 7]].any() or near.unanswered.any())
        near = self.scene.closest(points, fields=SIDES)
        self.assertTrue(np.isnan(near.signed[[3, 5, 7]]).all())
        self.assertEqual(near.votes[[3, 5, 7]].tolist(), [0, 0, 0])
        expected = self.inside.copy()
        expected[[3, 5, 7]] = False
        for side in RULES:
            np.testing.assert_array_equal(self.scene.contains(points, side=side), expected)

    def test_nothing_there(self):
        empty = self.client.create_scene("nothing")
        near = empty.closest(self.points, fields=SIDES)
        self.assertEqual((set(near.signed), set(near.inside), set(near.votes)), ({np.inf}, {False}, {0}))
        for side in RULES:
            self.assertFalse(empty.contains(self.points, side=side).any())
            self.assertFalse(self.scene.contains(self.points, masks=0, side=side).any())

    def test_masks_under_and_exclude(self):
        scene = self.client.create_scene("selected")
        inner = scene.add(moved(brute.box(), 0.25, 0.5), mask=1)
        outer = scene.add(brute.box(), mask=2)
        point = [0.5, 0.5, 0.6]
        for options, inside in (({}, False), ({"masks": 1}, True), ({"masks": 2}, True), ({"under": inner}, True),
                                ({"exclude": [outer]}, True), ({"exclude": [inner, outer]}, False)):
            self.assertEqual(bool(scene.contains(point, **options)), inside)
            self.assertEqual(bool(scene.closest(point, fields="signed", **options).signed < 0), inside)
        self.assertEqual(scene.contains([point] * 3, masks=[1, 3, 4]).tolist(), [True, False, False])
        for build in ("full", "lazy", "none"):
            self.assertTrue(scene.contains(point, side="winding", build=build))

    def test_revisions(self):
        before = self.scene.closest(self.points, fields=("inside",))
        self.scene.delete_node(1)
        self.assertFalse(self.scene.contains(self.points).any())
        np.testing.assert_array_equal(self.scene.contains(self.points, revision=before.revision), self.inside)

    def test_time_budget(self):
        many = np.tile(self.points, (100, 1))
        budget, near = 1e-3, None
        while near is None or near.unanswered.any():
            near = self.scene.closest(many, fields=("inside",), side_rays=9, time_budget=budget)
            self.assertFalse((near.inside & near.unanswered).any())
            budget *= 4
        np.testing.assert_array_equal(near.inside, np.tile(self.inside, 100))

    def test_what_is_not_asked_for(self):
        near = self.scene.closest(self.points, fields=("inside", "votes"))
        for name in ("hit", "distance", "signed", "node"):
            with self.assertRaisesRegex(AttributeError, f"{name} was not asked for"):
                getattr(near, name)
        with self.assertRaisesRegex(AttributeError, "inside was not asked for"):
            self.scene.closest(self.points).inside
        self.assertTrue(self.scene.closest(self.points, fields=("inside", "hit")).hit.all())

    def test_marks_of_a_server(self):
        columns = {"inside": np.array([0, 1, 2, 4], "u1")}
        near = sightline.Nearest((4,), columns, 1, "", {}, None, None)
        self.assertEqual(near.inside.tolist(), [False, True, False, False])
        self.assertEqual(near.invalid.tolist(), [False, False, True, False])
        self.assertEqual(near.unanswered.tolist(), [False, False, False, True])
        columns = {"signed": np.array([-1, np.inf, np.nan, -np.inf])}
        near = sightline.Nearest((4,), columns, 1, "", {}, None, None)
        self.assertEqual([near.hit.tolist(), near.invalid.tolist(), near.unanswered.tolist()],
                         [[True, False, False, False], [False, False, True, False], [False, False, False, True]])

    def test_what_is_refused(self):
        nothing = types.SimpleNamespace()  # points are looked at after the words
        for words, text in (
                ({"fields": "signed", "side": "odd"}, "side is parity, winding, normal"),
                ({"fields": "signed", "side_rays": 2}, "odd and from 1 to 63, not 2"),
                ({"fields": "signed", "side_rays": 0}, "odd"), ({"fields": "signed", "side_rays": -1}, "odd"),
                ({"fields": "signed", "side_rays": 65}, "from 1 to 63, not 65"),
                ({"side": "winding"}, "belong to the fields signed, inside, votes"),
                ({"side_rays": 3}, "belong to the fields"),
                ({"kind": "any", "side": "normal"}, "belong to the fields"),
                ({"fields": "signed", "side": "normal", "side_rays": 3}, "casts no rays"),
                ({"fields": ("inside", "votes"), "side": "normal"}, "has no field 'votes'"),
                *(({"kind": kind, "fields": field}, f"has no field '{field}'")
                  for kind in ("any", "count", "all") for field in SIDES)):
            with self.subTest(words), self.assertRaisesRegex(ValueError, text):
                self.scene.closest(nothing, **words)
        with self.assertRaises(TypeError):
            self.scene.closest(self.points, fields="signed", side_rays=1.0)
        with self.assertRaisesRegex(ValueError, "side is"):
            self.scene.contains(self.points, side="outer")
        with self.assertRaisesRegex(ValueError, "has no field 'inside'"):
            self.scene.cast(np.ones((1, 6)), fields="inside")
        self.assertEqual(len(self.scene.contains(self.points, side_rays=63)), 300)

    @unittest.skipUnless(pandas, "needs pandas")
    def test_pandas(self):
        frame = self.scene.closest(self.points, fields=("distance", *SIDES)).to_pandas()
        self.assertEqual(list(frame.columns), ["distance", "signed", "inside", "votes", "hit"])
        np.testing.assert_array_equal(frame.inside, self.inside)
        frame = self.scene.closest(self.points, fields=("votes",)).to_pandas()
        self.assertEqual((list(frame.columns), len(frame)), (["inside", "votes"], 300))
