"""Trees that are built before rays come, dropped, and shown; what a server says of them, and of itself."""

import dataclasses
import unittest

import brute
import numpy as np
import sightline
from shared import ServerTest
from sightline import _proto


class TreesTest(ServerTest):
    def setUp(self):
        self.mesh = brute.soup(3000)
        self.scene = self.scene_of(self.mesh)

    def test_everything(self):
        told = []
        report = self.scene.prefetch(progress=lambda done, total: told.append((done, total)))
        self.assertEqual((report.meshes_done, report.meshes_total, report.triangles_done), (1, 1, 3000))
        self.assertEqual(told[-1], (3000, 3000))
        stats = self.scene.stats()
        self.assertEqual((stats.triangles_built, stats.cells_deferred, stats.revision), (3000, 0, 1))
        self.assertEqual(self.scene.prefetch().cells_expanded, 0)
        self.assertGreater(self.scene.cool(), 0)
        self.assertEqual(self.scene.stats().triangles_built, 0)

    def test_what_rays_would_build(self):
        rays = brute.rays(20000)
        for given in ({"rays": rays}, {"points": rays[:, :3], "max_distance": 0.1},
                      {"rays": sightline.SphericalScan([0, 0, 0], 200, 100)},
                      {"points": sightline.PointGrid((0, 0, 0), (0.005, 0, 0), (0, 0.01, 0), 200, 100)}):
            told = []
            self.scene.cool()
            report = self.scene.prefetch(**given, progress=lambda done, total: told.append((done, total)))
            self.assertEqual((report.rays_done, report.rays_total, told), (20000, 20000, [(16384, 20000), (20000, 20000)]))
            self.assertGreater(report.cells_expanded, 0)
            self.assertEqual(self.scene.prefetch(**given).cells_expanded, 0)
            if "rays" in given:
                self.assertEqual(self.scene.cast(given["rays"]).stats.get("cells_expanded", 0), 0)
        self.scene.prefetch(rays, kind="all")
        self.assertEqual(self.scene.cast(rays, kind="count").stats.get("cells_expanded", 0), 0)

    def test_under_and_exclude(self):
        one, other = self.scene.add(brute.soup(500, 7), name="one"), self.scene.add(brute.soup(700, 8), name="other")
        self.assertEqual(self.scene.prefetch(under=["one", other]).triangles_total, 1200)
        self.assertEqual(self.scene.prefetch(exclude="o*").triangles_total, 3000)
        self.assertEqual(self.scene.prefetch(under=one).triangles_total, 500)

    def test_what_is_refused(self):
        rays, grid = brute.rays(10), sightline.PointGrid((0, 0, 0), (1, 0, 0), (0, 1, 0), 2, 2)
        for error, text, options in ((TypeError, "either", {"rays": rays, "points": rays[:, :3]}),
                                     (TypeError, "max_distance", {"rays": rays, "max_distance": 3}),
                                     (TypeError, "PointGrid", {"rays": grid}),
                                     (TypeError, "PointGrid", {"points": sightline.SphericalScan((0, 0, 0), 2, 2)}),
                                     (ValueError, "kind", {"rays": rays, "kind": "every"}),
                                     (ValueError, "kind", {"kind": "every"}),
                                     (ValueError, "shape", {"rays": rays[:, :5]}),
                                     (sightline.NotFound, "99", {"under": 99})):
            with self.subTest(text), self.assertRaisesRegex(error, text):
                self.scene.prefetch(**options)
        self.assertEqual(self.scene.prefetch(np.empty((0, 6))).rays_done, 0)

    def test_deferred_cells(self):
        cells = self.scene.deferred_cells()
        self.assertEqual((cells.boxes.shape, cells.total, cells.revision), ((1, 2, 3), 1, 1))
        np.testing.assert_allclose(cells.boxes[0], self.scene.info().bounds, rtol=1e-5)
        self.scene.cast(brute.rays(1))
        some = self.scene.deferred_cells(2)
        self.assertEqual(len(some.boxes), min(2, some.total))
        for most in (0, 4097):
            with self.assertRaisesRegex(ValueError, f"from 1 to 4096, not {most}"):
                self.scene.deferred_cells(most)

    def test_meshes(self):
        large = brute.soup(100_000, 5)  # in several parts
        node = self.scene.add(large, name="large")
        for wanted in (node, node.id, "large", self.scene.find("large")):
            mesh = self.scene.read_mesh(wanted)
            np.testing.assert_array_equal(mesh.vertices, np.asarray(large[0], "f4"))
            np.testing.assert_array_equal(mesh.faces, large[1])
        self.assertEqual(mesh.revision, 2)
        far = self.scene.add((np.array(large[0]) + 4e6, large[1]), origin=[4e6, 4e6, 4e6])
        self.assertEqual(self.scene.read_mesh(far).faces.shape, large[1].shape)
        with self.assertRaisesRegex(sightline.FailedPrecondition, "NODE_WITHOUT_MESH"):
            self.scene.read_mesh(self.scene.add(name="group"))
        with self.assertRaises(sightline.NotFound):
            self.scene.read_mesh(99)
        for blob in (b"", b"SLM1" + bytes(19), b"SLM2" + bytes(20), b"SLM1" + bytes(21)):
            with self.assertRaises(sightline.DataLoss):
                sightline.NodeMesh.of_blob(blob, 1)


class ServerInfoTest(ServerTest):
    def check_fields(self, made, message, *others):
        """Every field of the message is one of the class."""
        self.assertEqual({field.name for field in dataclasses.fields(made)} - set(others),
                         {field.name for field in message.DESCRIPTOR.fields})

    def test_classes_have_all_fields_of_messages(self):
        self.check_fields(sightline.ServerInfo, _proto.GetServerInfoResponse)
        self.check_fields(sightline.StorageLimits, _proto.StorageLimits)
        self.check_fields(sightline.SceneStats, _proto.GetSceneStatsResponse, "token")

    def test_values(self):
        info = self.client.server_info()
        self.assertEqual((info.version, info.storage, info.max_rays_per_request), (
            sightline.__version__, None, self.client.max_rays_per_request()))
        self.assertIn("closest", info.features)
        self.assertIn("trees", info.memory)

    def test_log(self):
        self.client.create_scene("logged")
        log = self.read_log_until("logged", 0)
        self.assertEqual(log.last, log.first + len(log.lines) - 1)
        self.client.create_scene("later")
        later = self.read_log_until("later", log.last)
        self.assertEqual(later.first, log.last + 1)
        self.assertFalse(any("scenes/logged" in line for line in later.lines))
        self.assertEqual(self.client.read_log(later.last + 10).lines, ())

    def read_log_until(self, name, after):
        while True:  # lines are written a moment after the answer
            log = self.client.read_log(after)
            if any(f"scenes/{name}" in line for line in log.lines):
                return log


if __name__ == "__main__":
    unittest.main()
