"""What the server's log says of an import: one line, however many meshes it has."""

import os
import pathlib
import subprocess
import tempfile
import time
import unittest

import brute
import sightline

CLI = pathlib.Path(os.environ.get("SIGHTLINED", "")).parents[1] / "client" / "sightline"


class LogTest(unittest.TestCase):
    def setUp(self):
        self.server = sightline.serve()
        self.addCleanup(self.server.close)

    def lines(self, last):
        """Those about scenes and meshes, up to one of an event, which is waited for: the log is written in time."""
        while f"event={last} " not in self.server.log():
            time.sleep(0.01)
        lines = self.server.log().splitlines()
        end = next(i for i, line in enumerate(lines) if f"event={last} " in line)
        return [line for line in lines[:end + 1] if "event=scene_" in line or "event=mesh_" in line]

    @unittest.skipUnless(CLI.exists(), "needs the command")
    def test_an_import_of_many_meshes(self):
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder) / "boxes.obj"
            vertices, faces = brute.box()
            file.write_text("".join(f"o part{i}\n" + "".join("v %g %g %g\n" % tuple((i + 1) * v) for v in vertices)
                                    + "".join("f %d %d %d\n" % tuple(f + 1 + 8 * i) for f in faces) for i in range(30)))
            subprocess.run([CLI, "--endpoint", self.server.endpoint, "scene", "import", "boxes", str(file), "-q"],
                           check=True)
        line, = self.lines("scene_put")
        for word in ("event=scene_put", "scene=projects/default/scenes/boxes", "meshes=30", "triangles=360"):
            self.assertIn(word, line)

    def test_a_scene_of_one_mesh_and_meshes_that_are_added(self):
        scene = self.server.client.import_arrays("box", *brute.box())
        with scene.batch():
            for seed in range(10):
                scene.add(brute.soup(20, seed))
        self.assertEqual(scene.info().meshes, 11)
        self.assertEqual(len(self.lines("scene_updated")), 2)
