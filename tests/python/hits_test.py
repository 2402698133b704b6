"""Answers as values: pickled, indexed, shown, and as tables of other packages."""

import importlib.util
import pickle
import unittest
import unittest.mock

import brute
import numpy as np
import sightline
from shared import ServerTest

HAS_XARRAY = importlib.util.find_spec("xarray") is not None


class HitsTest(ServerTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.scene = cls.client.import_arrays("hits", *brute.soup())
        cls.rays = brute.rays(60).reshape(3, 20, 6)

    def check_equal(self, one, other):
        self.assertEqual((one.shape, one.revision, one.token), (other.shape, other.revision, other.token))
        for name in ("t", "node", "primitive", "uv", "normal", "position", "hit"):
            np.testing.assert_array_equal(getattr(one, name), getattr(other, name))

    def test_pickle(self):
        near = self.scene.closest(self.rays[..., :3])
        for hits in (self.scene.cast(self.rays), self.scene.cast(self.rays, kind="all"), near,
                     self.scene.closest(self.rays[..., :3], 0.3, kind="all")):
            again = pickle.loads(pickle.dumps(hits))
            self.assertIs(type(again), type(hits))
            self.check_equal(again, hits)
            with self.assertRaisesRegex(AttributeError, "pickle"):
                again.name
            self.assertIn("mesh", hits.name)
            np.testing.assert_array_equal(pickle.loads(pickle.dumps(hits)).name, hits.name)

    def test_index(self):
        hits = self.scene.cast(self.rays)
        near = self.scene.closest(self.rays[..., :3])
        for index in (1, -1, slice(1, None), (2, 3), (slice(None), 4), hits.hit, np.array([2, 0, 2]), ..., (None, 1)):
            for whole in (hits, near):
                part = whole[index]
                self.assertIs(type(part), type(whole))
                for name in ("t", "normal", "position", "hit", "name"):
                    np.testing.assert_array_equal(getattr(part, name), getattr(whole, name)[index])
        self.assertEqual((len(hits), [row.shape for row in hits]), (3, [(20,)] * 3))
        self.assertEqual(hits[0, 0].t.shape, ())
        for index in (3, (0, 20), -4):
            with self.assertRaises(IndexError):
                hits[index]

    def test_index_of_all_hits(self):
        hits = self.scene.cast(self.rays, kind="all")
        for index in (0, slice(2, 9), hits.t < 0.5, [3, 3]):
            for name in ("t", "primitive", "position", "name"):
                np.testing.assert_array_equal(getattr(hits[index], name), getattr(hits, name)[index])
        self.assertEqual(hits[5:9].hit.tolist(), [True] * 4)
        self.assertEqual(sum(len(hits.of((i, j))) for i in range(3) for j in range(20)), len(hits))
        first = hits.of((0, 0))
        np.testing.assert_array_equal(first.t, hits.t[:len(first)])
        with self.assertRaises(IndexError):
            hits.of((3, 0))
        bare = self.scene.cast(self.rays, kind="all", fields=())
        self.assertEqual(bare[:2].hit.tolist(), [True, True])

    def test_repr(self):
        rays = np.array([[0, 0, 0, np.nan, 0, 1], [50, 50, 50, 1, 0, 0]])
        self.assertEqual(repr(self.scene.cast(rays)), "<Hits (2,): 0 of 2 rays hit, 1 invalid, 0 nodes, revision 1>")
        hits = self.scene.cast(self.rays)
        finite = hits.t[hits.hit]
        self.assertEqual(repr(hits), f"<Hits (3, 20): {len(finite)} of 60 rays hit, t from {finite.min():.6g} to "
                                     f"{finite.max():.6g}, 1 node, revision 1>")
        every = self.scene.cast(self.rays, kind="all", fields=("node",), max_hits=1)
        self.assertEqual(repr(every), f"<AllHits (3, 20): {len(every)} hits of 60 rays, {every.cut_off.sum()} cut off, "
                                      "1 node, revision 1>")
        inside = self.scene.closest([[0, 0, 0]], fields=("inside",))
        self.assertEqual(repr(inside), "<Nearest (1,): 1 points, revision 1>")

    @unittest.skipUnless(HAS_XARRAY, "needs xarray")
    def test_xarray(self):
        hits = self.scene.cast(self.rays)
        table = hits.to_xarray()
        self.assertEqual(table["t"].dims, ("dim_0", "dim_1"))
        self.assertEqual(hits.to_xarray(("scan", "beam"))["normal"].dims, ("scan", "beam", "axis"))
        for name in ("t", "node", "primitive", "uv", "normal", "hit"):
            np.testing.assert_array_equal(table[name], getattr(hits, name))
        self.assertEqual(table.attrs, {"revision": hits.revision, "token": hits.token})
        for dims in (("one",), ("one", "one")):
            with self.assertRaisesRegex(ValueError, "2 names that differ"):
                hits.to_xarray(dims)

    @unittest.skipUnless(HAS_XARRAY, "needs xarray")
    def test_xarray_of_grids_and_scans(self):
        grid = sightline.PointGrid((0, 0, 0), (0.1, 0, 0), (0, 0.1, 0), 7, 5, (0, 0, 0.1), 3)
        near = self.scene.closest(grid, fields=("distance", "inside"))
        table = near.to_xarray()
        self.assertEqual(table["distance"].dims, ("layer", "row", "column"))
        np.testing.assert_array_equal(np.stack([table[axis] for axis in "xyz"], axis=-1), grid.positions())
        np.testing.assert_array_equal(table["inside"], near.inside)
        scan = sightline.SphericalScan([0, 0, 0], 8, 4)
        table = self.scene.cast(scan, fields=("t",)).to_xarray(("ring", "beam"))
        self.assertEqual((table["azimuth"].dims, table["elevation"].dims), (("beam",), ("ring",)))
        self.assertEqual(pickle.loads(pickle.dumps(self.scene.cast(scan))).to_xarray()["t"].dims, ("row", "column"))

    def test_missing_packages_are_named(self):
        hits = self.scene.cast(self.rays)
        with unittest.mock.patch("importlib.import_module", side_effect=ImportError("no module")):
            for asking, name in ((hits.to_xarray, "xarray"), (hits.to_pandas, "pandas")):
                with self.assertRaisesRegex(ImportError, f"pip install {name}, or on Debian apt install python3-{name}"):
                    asking()


if __name__ == "__main__":
    unittest.main()
