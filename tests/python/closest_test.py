"""Closest points, compared with formulas and with looking at every triangle."""

import unittest

import brute
import numpy as np
import sightline
from shared import ServerTest
from sightline._answer import CUT_OFF, UNANSWERED
from sightline._completion import complete_rows

try:
    import pandas
except ImportError:
    pandas = None

KINDS = ("closest", "any", "count", "all")


def somewhere(count, low=-1.0, high=2.0, seed=4):
    """Points (n, 3) in a cube."""
    return np.random.default_rng(seed).uniform(low, high, (count, 3))


class FormulaTest(ServerTest):
    """Where the answer is known without looking at faces."""

    def test_cube(self):
        scene = self.scene_of(brute.box())
        points = somewhere(2000)
        outside = np.linalg.norm(np.maximum(np.maximum(-points, points - 1), 0), axis=1)
        inside = np.minimum(points, 1 - points).min(axis=1)
        expected = np.where(inside > 0, inside, outside)
        near = scene.closest(points)
        self.assertIsInstance(near, sightline.Nearest)
        np.testing.assert_allclose(near.distance, expected, rtol=1e-15)
        np.testing.assert_allclose(np.linalg.norm(near.position - points, axis=1), expected, rtol=1e-14)
        beside = inside <= 0
        np.testing.assert_allclose(near.position[beside], np.clip(points, 0, 1)[beside], atol=1e-15)
        self.assertEqual(set(near.name), {"mesh"})
        self.assertTrue((near.node == 1).all() and near.hit.all())
        np.testing.assert_array_equal(near.distance, scene.closest([points.tolist()]).distance[0])

    def test_triangle(self):
        scene = self.scene_of(([[0, 0, 0], [4, 0, 0], [0, 3, 0]], [[0, 1, 2]]))
        for point, distance, position, uv in (
                ([1, 1, 5], 5, [1, 1, 0], [0.25, 1 / 3]),                # the face
                ([1, 1, 0], 0, [1, 1, 0], [0.25, 1 / 3]),
                ([2, -3, 4], 5, [2, 0, 0], [0.5, 0]),                    # edges
                ([-3, 1, -4], 5, [0, 1, 0], [0, 1 / 3]),
                ([2 + 3, 1.5 + 4, 12], 13, [2, 1.5, 0], [0.5, 0.5]),
                ([-2, -3, 6], 7, [0, 0, 0], [0, 0]),                     # corners
                ([6, -3, 6], 7, [4, 0, 0], [1, 0]),
                ([-2, 6, 6], 7, [0, 3, 0], [0, 1])):
            near = scene.closest(point)
            self.assertEqual((near.shape, float(near.distance)), ((), distance))
            np.testing.assert_allclose(near.position, position, atol=1e-15)
            np.testing.assert_allclose(near.uv, uv, rtol=1e-6)
            np.testing.assert_array_equal(near.normal, [0, 0, 1])

    def test_segments_and_points(self):
        line = self.scene_of(([[0, 0, 0], [10, 0, 0], [10, 5, 0]], [[0, 1, 1], [2, 1, 2]]))
        points = somewhere(500, -5, 15)
        x, y, z = points.T
        first = np.sqrt((x - np.clip(x, 0, 10)) ** 2 + y ** 2 + z ** 2)
        second = np.sqrt((x - 10) ** 2 + (y - np.clip(y, 0, 5)) ** 2 + z ** 2)
        near = line.closest(points)
        np.testing.assert_allclose(near.distance, np.minimum(first, second), rtol=1e-14)
        self.assertFalse(near.normal.any())
        cloud = somewhere(300).astype("f4")
        scene = self.client.import_arrays("cloud", cloud, np.repeat(np.arange(300)[:, None], 3, axis=1))
        points = somewhere(100, seed=5)
        table = np.linalg.norm(points[:, None] - cloud.astype("f8"), axis=-1)
        np.testing.assert_allclose(scene.closest(points).distance, table.min(axis=1), rtol=1e-15)
        nearest = scene.closest(points, kind="all", max_hits=8)
        np.testing.assert_array_equal(nearest.primitive.reshape(100, 8), np.argsort(table, axis=1)[:, :8])
        np.testing.assert_allclose(nearest.position.reshape(100, 8, 3)[:, 0], cloud[table.argmin(axis=1)], rtol=1e-6)
        ball = scene.closest(points, 0.4, kind="all")
        np.testing.assert_array_equal(ball.count, (table <= 0.4).sum(axis=1))
        self.assertEqual(ball.cut_off.sum(), 0)

    def test_distances_are_those_in_the_scene(self):
        scene = self.client.create_scene("scaled")
        transform = np.diag([2.0, 1.0, 0.5])
        scene.add(brute.box(), transform=np.hstack([transform, [[10], [0], [0]]]))
        near = scene.closest([[15, 0.5, 0.25], [11, 0.5, 2.5], [13, 2, 0.25]])
        np.testing.assert_array_equal(near.distance, [3, 2, np.sqrt(2)])
        np.testing.assert_array_equal(near.position, [[12, 0.5, 0.25], [11, 0.5, 0.5], [12, 1, 0.25]])


class ClosestTest(ServerTest):
    def setUp(self):
        self.mesh = brute.soup()
        self.scene = self.scene_of(self.mesh)
        self.points = somewhere(300)
        self.table, self.nearest = brute.distances(*self.mesh, self.points)
        self.distance, self.face = self.table.min(axis=1), self.table.argmin(axis=1)

    def check(self, near, rows=slice(None)):
        np.testing.assert_allclose(near.distance, self.distance[rows].reshape(near.shape), rtol=1e-6)
        np.testing.assert_array_equal(near.primitive, self.face[rows].reshape(near.shape))

    def test_closest(self):
        near = self.scene.closest(self.points)
        self.check(near)
        np.testing.assert_allclose(near.distance, self.distance, rtol=1e-12)
        np.testing.assert_allclose(near.position, self.nearest[np.arange(300), self.face], atol=1e-12)
        corners = self.mesh[0][self.mesh[1]][near.primitive].astype("f8")
        u, v = near.uv[..., 0, None], near.uv[..., 1, None]
        there = corners[:, 0] * (1 - u - v) + corners[:, 1] * u + corners[:, 2] * v
        np.testing.assert_allclose(there, near.position, atol=1e-6)
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        np.testing.assert_allclose(near.normal, normals / np.linalg.norm(normals, axis=1, keepdims=True), atol=1e-6)
        self.assertEqual((near.stats["rays"], near.stats["hits"]), (300, 300))
        self.assertEqual(repr(near), f"<Nearest (300,): 300 of 300 points hit, distance from {near.distance.min():.6g} to "
                                     f"{near.distance.max():.6g}, 1 node, revision 1>")

    def test_kinds_agree(self):
        for limit in (0.15, np.linspace(-0.1, 0.5, 300), np.inf):
            count = (self.table <= np.broadcast_to(limit, 300)[:, None]).sum(axis=1)
            near = self.scene.closest(self.points, limit)
            np.testing.assert_array_equal(near.hit, count > 0)
            np.testing.assert_array_equal(np.isfinite(near.distance), count > 0)
            np.testing.assert_array_equal(np.isnan(near.position[:, 0]), count == 0)
            np.testing.assert_array_equal(near.node, count > 0)
            np.testing.assert_array_equal(self.scene.closest(self.points, limit, kind="any").hit, count > 0)
            np.testing.assert_array_equal(self.scene.closest(self.points, limit, kind="count").count, count)
            listed = self.scene.closest(self.points.reshape(3, 100, 3), np.reshape(limit, (-1, 100)) if np.ndim(limit)
                                        else limit, kind="all")
            self.assertIsInstance(listed, sightline.AllNearest)
            np.testing.assert_array_equal(listed.count.reshape(-1), count)
            np.testing.assert_allclose(listed.distance, self.table[listed.point, listed.primitive], rtol=1e-12)
            self.assertTrue((np.diff(listed.distance)[np.diff(listed.point) == 0] >= 0).all())
            first = listed.offset[:-1][count > 0].astype(int)
            np.testing.assert_array_equal(listed.primitive[first], near.primitive[near.hit])
            self.assertEqual(listed.position.shape, (len(listed), 3))

    def test_the_limit_is_closed(self):
        near = self.scene.closest(self.points)
        for limit, hit in ((near.distance, True), (np.nextafter(near.distance, 0), False), (-1, False)):
            for kind in ("closest", "any", "count"):
                self.assertEqual(set(self.scene.closest(self.points, limit, kind=kind).hit), {hit})
        on_it = self.scene.closest(self.mesh[0][:50], 0)
        np.testing.assert_array_equal(on_it.distance, 0)

    def test_k_nearest_are_the_first_of_all(self):
        everything = self.scene.closest(self.points, kind="all")
        self.assertEqual(everything.count.tolist(), [200] * 300)
        for k in (1, 7, 199, 200, 16384):
            some = self.scene.closest(self.points, kind="all", max_hits=k)
            self.assertEqual(set(some.count), {min(k, 200)})
            self.assertEqual(set(some.cut_off), {k < 200})
            for column in ("primitive", "distance"):
                rows = getattr(everything, column).reshape(300, 200)[:, :k]
                np.testing.assert_array_equal(getattr(some, column).reshape(300, -1), rows)
        with self.assertRaisesRegex(ValueError, "max_hits is at most 16384"):
            self.scene.closest(self.points, kind="all", max_hits=16385)

    def test_more_faces_than_an_answer_lists_by_default(self):
        cloud = somewhere(20000, seed=6).astype("f4")
        scene = self.client.import_arrays("dense", cloud, np.repeat(np.arange(20000)[:, None], 3, axis=1))
        points, limit = somewhere(5, 0, 1, seed=7), np.array([0.2, 0.5, 1.0, 1.6, 0.0])
        table = np.linalg.norm(points[:, None] - cloud.astype("f8"), axis=-1)
        count = (table <= limit[:, None]).sum(axis=1)
        self.assertTrue((count[1:4] > 256).all() and count.max() < 16384)
        listed = scene.closest(points, limit, kind="all", fields=("primitive",))
        np.testing.assert_array_equal(listed.count, count)
        self.assertEqual((listed.stats["hits_found"], listed.cut_off.sum()), (count.sum(), 0))
        for i in range(5):
            rows = slice(int(listed.offset[i]), int(listed.offset[i + 1]))
            np.testing.assert_array_equal(listed.primitive[rows], np.argsort(table[i])[:count[i]])
        with self.assertRaisesRegex(AttributeError, "distance was not asked for"):
            listed.distance
        with self.assertWarnsRegex(UserWarning, "1 points have more than 16384 faces"):
            listed = scene.closest(points[:2], [0.2, 9], kind="all")
        self.assertEqual((listed.count.tolist(), listed.cut_off.tolist()), ([count[0], 16384], [False, True]))

    def test_what_has_no_second_answer_keeps_the_first(self):
        def listing(offset, primitive, hit):
            columns = {"offset": np.array(offset, "u8"), "primitive": np.array(primitive, "u4"), "hit": np.array(hit, "u1"),
                       "t": np.arange(len(primitive), dtype="f8")}
            return sightline.AllNearest((len(hit),), columns, 1, "", {}, None, None)

        known, asked = listing([0, 2, 2, 4], [1, 2, 3, 4], [CUT_OFF, 0, CUT_OFF]), []

        def ask(rows):
            asked.extend(rows)
            return listing([0, 0, 3], [5, 6, 7], [UNANSWERED, 1])

        complete_rows(known, ask, "points")
        self.assertEqual(asked, [0, 2])
        self.assertEqual((known.offset.tolist(), known.primitive.tolist()), ([0, 2, 2, 5], [1, 2, 5, 6, 7]))
        self.assertEqual(known.cut_off.tolist(), [True, False, False])
        self.assertEqual((known.stats["hits_found"], known.stats["rays_cut_off"]), (5, 1))

    def test_time_budget(self):
        many = np.repeat(self.points, 100, axis=0)
        for kind in KINDS:
            budget, near = 0.001, None
            while near is None or near.unanswered.any():  # ends on any machine
                near = self.scene.closest(many, 0.2, kind=kind, time_budget=budget)
                self.assertEqual(near.stats.get("unanswered", 0), near.unanswered.sum())
                self.assertFalse((near.hit & near.unanswered).any())
                budget *= 2
            np.testing.assert_array_equal(near.hit, np.repeat(self.distance <= 0.2, 100))
        with self.assertRaisesRegex(ValueError, "time_budget"):
            self.scene.closest(self.points, time_budget=0)
        self.check(self.scene.closest(self.points, allow_partial=True))

    def test_any_type_and_shape(self):
        for table in (self.points.tolist(), np.asfortranarray(self.points), self.points.astype(">f8"),
                      self.points.astype("longdouble"), np.repeat(self.points, 2, axis=0)[::2]):
            self.check(self.scene.closest(table))
        for shape in ((300,), (3, 100), (5, 3, 20), (300, 1, 1)):
            near = self.scene.closest(self.points.reshape(*shape, 3))
            self.assertEqual([column.shape[len(shape):] for column in (near.distance, near.uv, near.position)],
                             [(), (2,), (3,)])
            self.check(near)
        one = self.scene.closest(self.points[0])
        self.assertEqual((one.shape, one.distance.shape, one.position.shape), ((), (), (3,)))
        self.assertEqual(self.scene.closest(np.zeros((0, 3))).distance.shape, (0,))
        self.assertEqual(self.scene.closest(np.zeros((4, 0, 3)), kind="all").count.shape, (4, 0))
        self.assertEqual(self.scene.closest([0, 0, 0], np.ones((2, 5))).distance.shape, (2, 5))

    def test_float32_and_float64_are_asked_as_they_are(self):
        single = self.points.astype("f4")
        near, again = self.scene.closest(single), self.scene.closest(single.astype("f8"))
        np.testing.assert_array_equal(near.distance, again.distance)
        np.testing.assert_array_equal(near.position, again.position)
        exact, _ = brute.distances(*self.mesh, single)
        np.testing.assert_allclose(near.distance, exact.min(axis=1), rtol=1e-12)

    def test_masks_under_and_exclude(self):
        scene = self.client.create_scene("nodes")
        group = scene.add(name="group")
        lower = scene.add(brute.box(), name="lower", mask=1, parent=group)
        upper = scene.add((brute.box()[0] + [0, 0, 10], brute.box()[1]), name="upper", mask=2)
        point = [0.5, 0.5, 4]

        def answer(**options):
            near = scene.closest(point, **options)
            return str(near.name), float(near.distance)

        self.assertEqual(answer(), ("lower", 3))
        self.assertEqual(answer(masks=2), ("upper", 6))
        self.assertEqual(answer(masks=0), ("", np.inf))
        self.assertEqual(answer(under=upper), ("upper", 6))
        self.assertEqual(answer(under=group.id), ("lower", 3))
        self.assertEqual(answer(exclude=[group]), ("upper", 6))
        self.assertEqual(answer(exclude=[lower, upper]), ("", np.inf))
        near = scene.closest([point] * 3, masks=[1, 2, 4])
        self.assertEqual(near.node.tolist(), [lower.id, upper.id, 0])
        self.assertEqual(near.primitive[2], 0)
        for build in ("lazy", "full", "none"):
            self.assertEqual(answer(build=build), ("lower", 3))

    def test_an_empty_scene(self):
        near = self.client.create_scene("empty").closest(self.points[:4])
        self.assertEqual(near.distance.tolist(), [np.inf] * 4)
        self.assertTrue(np.isnan(near.position).all() and not near.hit.any() and not near.node.any())
        self.assertEqual(near.name.tolist(), [""] * 4)

    def test_many_points_go_in_many_messages(self):
        many = np.tile(self.points, (70, 1)).reshape(7, 3000, 3)
        near = self.scene.closest(many)
        np.testing.assert_array_equal(near.distance.reshape(70, 300),
                                      np.tile(self.scene.closest(self.points).distance, (70, 1)))
        self.assertEqual(near.stats["rays"], 21000)
        told = []
        self.scene.closest(many, progress=lambda done, total: told.append((done, total)))
        self.assertEqual(told[-1], (21000, 21000))
        self.scene.closest(self.points, progress=True)
        listed = self.scene.closest(many, 0.2, kind="all", fields=("distance",))
        np.testing.assert_array_equal(listed.count.reshape(70, 300), np.tile((self.table <= 0.2).sum(axis=1), (70, 1)))

    def test_batches(self):
        parts = np.array_split(self.points, 7)
        for part, near in zip(np.array_split(np.arange(300), 7), self.scene.closest(iter(parts))):
            self.check(near, part)
        limited = self.scene.closest(iter(parts), 0.2, kind="any")
        np.testing.assert_array_equal(np.concatenate([near.hit for near in limited]), self.distance <= 0.2)
        own = [sightline.as_points(part, 0.2) for part in parts]
        counts = [near.count for near in self.scene.closest(iter(own), kind="all")]
        np.testing.assert_array_equal(np.concatenate(counts), (self.table <= 0.2).sum(axis=1))
        self.assertEqual(list(self.scene.closest(iter([]))), [])
        with self.assertRaisesRegex(ValueError, "not \\(2,\\)"):
            next(self.scene.closest(iter([[1, 2]])))

    def test_batches_are_taken_as_they_are_needed(self):
        taken = []

        def source():
            for i in range(1000):
                taken.append(i)
                yield self.points

        near = self.scene.closest(source())
        next(near)
        next(near)
        self.assertLess(len(taken), 10)
        near.close()

    def test_invalid_points_fail_nothing(self):
        points, limit = self.points.copy(), np.ones(300)
        points[3, 0], points[5, 2], points[7, 1], limit[9] = np.nan, np.inf, 1e80, np.nan
        for kind in KINDS:
            near = self.scene.closest(points, limit, kind=kind)
            self.assertEqual(list(np.flatnonzero(near.invalid)), [3, 5, 7, 9])
            self.assertEqual(near.stats["invalid"], 4)
            self.assertFalse(near.hit[[3, 5, 7, 9]].any())
        near = self.scene.closest(points, limit)
        self.assertTrue(np.isnan(near.distance[[3, 5, 7, 9]]).all() and np.isnan(near.position[[3, 5, 7, 9]]).all())
        rest = ~near.invalid & (self.distance <= 1)
        np.testing.assert_allclose(near.distance[rest], self.distance[rest], rtol=1e-12)

    def test_fields(self):
        near = self.scene.closest(self.points, fields=("position", "name"))
        np.testing.assert_allclose(near.position, self.nearest[np.arange(300), self.face], atol=1e-12)
        self.assertEqual(near.name.tolist(), ["mesh"] * 300)
        self.assertTrue(near.hit.all())
        with self.assertRaisesRegex(AttributeError, "distance was not asked for"):
            near.distance
        with self.assertRaisesRegex(AttributeError, "position was not asked for"):
            self.scene.closest(self.points, fields="distance").position
        for words in ({"kind": "nearest"}, {"fields": ("t",)}, {"fields": ("signs",)}, {"build": "never"},
                      {"kind": "any", "fields": "distance"}, {"at_least": "a", "revision": 1}):
            with self.subTest(words), self.assertRaises(ValueError):
                self.scene.closest(self.points, **words)

    @unittest.skipUnless(pandas, "needs pandas")
    def test_pandas(self):
        frame = self.scene.closest(self.points).to_pandas()
        self.assertEqual(list(frame.columns),
                         ["distance", "node", "primitive", "u", "v", "nx", "ny", "nz", "x", "y", "z", "hit"])
        np.testing.assert_allclose(frame.distance, self.distance, rtol=1e-12)
        self.assertEqual(frame.index.name, "point")
        frame = self.scene.closest(self.points, 0.2, kind="all", fields=("distance",)).to_pandas()
        self.assertEqual(list(frame.columns), ["point", "distance"])

    def test_revisions(self):
        near = self.scene.closest(self.points)
        self.scene.delete_node(1)
        self.assertFalse(self.scene.closest(self.points).hit.any())
        self.check(self.scene.closest(self.points, revision=near.revision))
        self.check(self.scene.closest(np.tile(self.points, (70, 1)), revision=1), np.tile(np.arange(300), 70))
        with self.assertRaises(sightline.OutOfRange):
            self.scene.closest(self.points, revision=99)
        with self.assertRaises(sightline.InvalidArgument):
            self.scene.closest(self.points, at_least="no token")

    def test_grids_are_the_points_that_they_say(self):
        grid = sightline.PointGrid([-1, -0.9, 0.3], [0.013, 0.007, 0], [0, 0.05, 0.017], 150, 40, deep=[0.1, 0, 0.21],
                                   layers=3, max_distance=0.3)
        for kind in KINDS:
            fields = {"closest": ("distance", "primitive", "position"), "all": ("distance", "primitive")}.get(kind, ())
            made = self.scene.closest(grid, kind=kind, fields=fields)
            own = self.scene.closest(grid.positions(), 0.3, kind=kind, fields=fields)
            self.assertTrue(0 < made.hit.mean() < 1)
            for name in ("hit", *fields):
                np.testing.assert_array_equal(getattr(made, name), getattr(own, name))
        flat = sightline.PointGrid([0, 0, 5], [0.25, 0, 0], [0, 0.25, 0], 4, 3, max_distance=4.5)
        near = self.scene.closest(flat)
        self.assertEqual(near.position.shape, (3, 4, 3))
        np.testing.assert_array_equal(near.distance, self.scene.closest(flat.positions(), 4.5).distance)
        unseen = sightline.PointGrid([0, 0, 0], [1, 0, 0], [0, 1, 0], 4, 3, mask=0)
        self.assertFalse(self.scene.closest(unseen).hit.any())
        with self.assertRaisesRegex(TypeError, "their own max_distance"):
            self.scene.closest(flat, 1)
        told = []
        self.scene.closest(grid, progress=lambda done, total: told.append((done, total)))
        self.assertEqual(told, [(16384, 18000), (18000, 18000)])
