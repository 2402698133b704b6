"""Casts, compared with looking at every triangle."""

import unittest

import brute
import numpy as np
import sightline
from shared import ServerTest
from sightline import _proto

try:
    import pandas
except ImportError:
    pandas = None


class CastTest(ServerTest):
    def setUp(self):
        self.mesh = brute.soup()
        self.scene = self.scene_of(self.mesh)
        self.rays = brute.rays(300)
        self.t, self.face = brute.closest(*self.mesh, self.rays[:, :3], self.rays[:, 3:])

    def check(self, hits, rows=slice(None)):
        t = self.t[rows].reshape(hits.shape)
        np.testing.assert_allclose(hits.t, t, rtol=1e-4)
        np.testing.assert_array_equal(hits.hit, np.isfinite(t))
        np.testing.assert_array_equal(hits.primitive[hits.hit], self.face[rows].reshape(hits.shape)[hits.hit])

    def test_closest(self):
        hits = self.scene.cast(self.rays)
        self.check(hits)
        self.assertGreater(hits.hit.sum(), 50)
        seen = hits.hit
        np.testing.assert_allclose(hits.position[seen], self.rays[seen, :3] + self.t[seen, None] * self.rays[seen, 3:],
                                   rtol=1e-4, atol=1e-4)
        corners = self.mesh[0][self.mesh[1]][hits.primitive]
        u, v = hits.uv[..., 0, None], hits.uv[..., 1, None]
        places = corners[:, 0] * (1 - u - v) + corners[:, 1] * u + corners[:, 2] * v
        np.testing.assert_allclose(places[seen], hits.position[seen], atol=1e-4)
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        np.testing.assert_allclose(hits.normal[seen], normals[seen], atol=1e-4)
        self.assertTrue((hits.name[seen] == "mesh").all() and (hits.name[~seen] == "").all())
        self.assertTrue(np.isnan(hits.position[~seen]).all())

    def test_kinds_agree(self):
        table = brute.hits(*self.mesh, self.rays[:, :3], self.rays[:, 3:])
        count = (~np.isnan(table)).sum(axis=1)
        np.testing.assert_array_equal(self.scene.cast(self.rays, kind="any").hit, count > 0)
        np.testing.assert_array_equal(self.scene.cast(self.rays, kind="count").count, count)
        hits = self.scene.cast(self.rays.reshape(3, 100, 6), kind="all")
        np.testing.assert_array_equal(hits.count.reshape(-1), count)
        np.testing.assert_array_equal(np.diff(hits.offset.astype(int)), count)
        np.testing.assert_allclose(hits.t, table[hits.ray, hits.primitive], rtol=1e-4)
        self.assertTrue((np.diff(hits.t)[np.diff(hits.ray) == 0] >= 0).all())
        self.assertEqual(hits.position.shape, (len(hits), 3))

    def test_max_hits(self):
        all_hits = self.scene.cast(self.rays, kind="all")
        hits = self.scene.cast(self.rays, kind="all", max_hits=1)
        np.testing.assert_array_equal(hits.cut_off, all_hits.count > 1)
        np.testing.assert_allclose(hits.t, self.t[np.isfinite(self.t)], rtol=1e-4)

    def test_time_budget(self):
        for kind in ("closest", "any", "count", "all"):
            budget, hits = 0.001, None
            while hits is None or hits.unanswered.any():  # ends on any machine
                hits = self.scene.cast(np.repeat(self.rays, 200, axis=0), kind=kind, time_budget=budget)
                self.assertEqual(hits.stats.get("unanswered", 0), hits.unanswered.sum())
                self.assertFalse((hits.hit & hits.unanswered).any())
                budget *= 2
            np.testing.assert_array_equal(hits.hit, np.repeat(np.isfinite(self.t), 200))
        for wrong in (0, -1, float("nan")):
            with self.assertRaisesRegex(ValueError, "time_budget"):
                self.scene.cast(self.rays, time_budget=wrong)

    def test_allow_partial_where_nothing_is_lost(self):
        hits = self.scene.cast(self.rays, allow_partial=True)
        self.assertFalse(hits.unanswered.any())
        self.check(hits)

    def test_any_type_and_shape(self):
        for table in (self.rays.tolist(), np.asfortranarray(self.rays), self.rays.astype(">f8"),
                      self.rays.astype("longdouble"), np.repeat(self.rays, 2, axis=0)[::2], self.rays[::-1][::-1]):
            self.check(self.scene.cast(table))
        for shape in ((300,), (3, 100), (5, 3, 20), (300, 1, 1)):
            hits = self.scene.cast(self.rays.reshape(*shape, 6))
            self.assertEqual((hits.t.shape, hits.uv.shape, hits.normal.shape), (shape, (*shape, 2), (*shape, 3)))
            self.check(hits)
        one = self.scene.cast(self.rays[0])
        self.assertEqual((one.shape, one.t.shape, one.position.shape), ((), (), (3,)))
        self.assertEqual(self.scene.cast(np.zeros((0, 6))).t.shape, (0,))
        self.assertEqual(self.scene.cast(np.zeros((4, 0, 6)), kind="all").count.shape, (4, 0))

    def test_float32_and_float64_are_cast_as_they_are(self):
        single = self.rays.astype("f4")
        hits = self.scene.cast(single)
        again = self.scene.cast(single.astype("f8"))
        np.testing.assert_array_equal(hits.t, again.t)

    def test_bounds_and_masks(self):
        bounded = np.hstack([self.rays, np.full((300, 1), 0.2), np.full((300, 1), 0.9)])
        t, _ = brute.closest(*self.mesh, self.rays[:, :3], self.rays[:, 3:], tmin=0.2, tmax=0.9)
        np.testing.assert_allclose(self.scene.cast(bounded).t, t, rtol=1e-4)
        columns = {"origins": self.rays[:, :3], "directions": self.rays[:, 3:]}
        np.testing.assert_allclose(self.scene.cast(**columns, tmin=0.2, tmax=0.9).t, t, rtol=1e-4)
        self.assertFalse(self.scene.cast(self.rays, masks=0).hit.any())

    def test_many_rays_go_in_many_messages(self):
        many = np.tile(self.rays, (70, 1)).reshape(7, 3000, 6)
        hits = self.scene.cast(many)
        np.testing.assert_array_equal(hits.t.reshape(70, 300), np.tile(self.scene.cast(self.rays).t, (70, 1)))
        self.assertEqual(hits.stats["rays"], 21000)
        all_hits = self.scene.cast(many, kind="all", fields=("t",))
        count = np.tile(self.scene.cast(self.rays, kind="count").count, 70)
        np.testing.assert_array_equal(all_hits.count.reshape(-1), count)

    def test_batches(self):
        parts = np.array_split(self.rays, 7)
        for part, hits in zip(np.array_split(np.arange(300), 7), self.scene.cast(iter(parts))):
            self.check(hits, part)
        self.assertEqual(list(self.scene.cast(iter([]))), [])

    def test_batches_are_taken_as_they_are_needed(self):
        taken = []

        def source():
            for i in range(1000):
                taken.append(i)
                yield self.rays

        hits = self.scene.cast(source())
        next(hits)
        next(hits)
        self.assertLess(len(taken), 10)
        hits.close()

    def test_an_error_of_the_source_comes_after_the_answers(self):
        def source():
            yield self.rays
            raise ZeroDivisionError("from the source")

        hits = self.scene.cast(source())
        self.check(next(hits))
        with self.assertRaisesRegex(ZeroDivisionError, "from the source"):
            next(hits)
        with self.assertRaisesRegex(ValueError, "not \\(3,\\)"):
            next(self.scene.cast(iter([[1, 2, 3]])))

    def test_invalid_rays_fail_nothing(self):
        rays = self.rays.copy()
        rays[3, 0], rays[5, 3:] = np.nan, 0
        for kind in ("closest", "any", "count", "all"):
            hits = self.scene.cast(rays, kind=kind)
            self.assertEqual(list(np.flatnonzero(hits.invalid)), [3, 5])
            self.assertEqual(hits.stats["invalid"], 2)
            self.assertFalse(hits.hit[[3, 5]].any())

    def test_fields(self):
        hits = self.scene.cast(self.rays, fields=("normal",))
        np.testing.assert_array_equal(hits.hit, np.isfinite(self.t))
        with self.assertRaisesRegex(AttributeError, "primitive was not asked for"):
            hits.primitive
        for words in ({"kind": "nearest"}, {"fields": ("colour",)}, {"build": "never"}, {"cull": "left"},
                      {"kind": "any", "fields": "t"}):
            with self.subTest(words), self.assertRaises(ValueError):
                self.scene.cast(self.rays, **words)

    def test_the_server_sends_the_positions_and_names_that_are_named(self):
        made = self.scene.cast(self.rays)
        many = np.tile(self.rays, (70, 1)).reshape(70, 300, 6)  # several messages
        for rays in (self.rays, self.rays.astype("f4"), many):
            sent = self.scene.cast(rays, fields=("position", "name"))
            same = self.scene.cast(rays)
            np.testing.assert_array_equal(sent.position, same.position)  # bit for bit
            np.testing.assert_array_equal(sent.name, same.name)
            self.assertEqual(sent.position.shape, rays.shape[:-1] + (3,))
            with self.assertRaisesRegex(AttributeError, "t was not asked for"):
                sent.t
        listed = self.scene.cast(self.rays, kind="all", fields="position name t".split())
        np.testing.assert_array_equal(listed.position, self.scene.cast(self.rays, kind="all").position)
        self.assertEqual(listed.name.tolist(), ["mesh"] * len(listed))
        self.assertEqual(self.scene.cast(self.rays[:0], fields=("position", "name")).name.shape, (0,))
        self.scene.delete_node(1)
        with self.scene.batch():
            pass
        sent = self.scene.cast(self.rays, fields="name", revision=made.revision)
        np.testing.assert_array_equal(sent.name, made.name)

    def test_bytes_of_another_type_are_refused(self):
        request = _proto.CastRaysRequest(scene=self.scene.name)
        request.rays.origins = request.rays.directions = self.rays[:, :3].astype("f4").tobytes()
        request.rays.count = 300
        request.rays.float64 = True
        with self.assertRaisesRegex(sightline.InvalidArgument, "300 rays, but the 3600 bytes .* hold 150") as caught:
            self.client._connection.call("CastRays", request.SerializeToString())
        self.assertEqual(caught.exception.reason, "RAY_COUNT")

    def test_progress(self):
        told = []
        self.scene.cast(np.tile(self.rays, (70, 1)), progress=lambda done, total: told.append((done, total)))
        self.assertEqual(told[-1], (21000, 21000))
        self.scene.cast(self.rays, progress=True)

    @unittest.skipUnless(pandas, "needs pandas")
    def test_pandas(self):
        frame = self.scene.cast(self.rays).to_pandas()
        self.assertEqual(list(frame.columns), ["t", "node", "primitive", "u", "v", "nx", "ny", "nz", "hit"])
        np.testing.assert_allclose(frame.t, self.t, rtol=1e-4)
        all_hits = self.scene.cast(self.rays, kind="all")
        self.assertEqual(len(all_hits.to_pandas()), len(all_hits))
        frame = self.scene.cast(self.rays, fields=("position", "name")).to_pandas()
        self.assertEqual(list(frame.columns), ["x", "y", "z", "name", "hit"])

    def test_revisions(self):
        hits = self.scene.cast(self.rays)
        self.scene.delete_node(1)
        self.assertFalse(self.scene.cast(self.rays).hit.any())
        self.check(self.scene.cast(self.rays, revision=hits.revision))
        self.check(self.scene.cast(np.tile(self.rays, (70, 1)), revision=1), np.tile(np.arange(300), 70))
        with self.assertRaises(sightline.OutOfRange) as raised:
            self.scene.cast(self.rays, revision=99)
        self.assertRegex(raised.exception.reason, "^REVISION_NOT_(THERE|KEPT)$")
        with self.assertRaises(sightline.InvalidArgument):
            self.scene.cast(self.rays, at_least="no token")
