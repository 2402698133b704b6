"""Scene files, which the command reads."""

import asyncio
import pathlib
import sys
import tempfile
import unittest
import warnings

import brute
import sightline
import sightline.aio
from shared import COMMAND, ServerTest

OPEN_BOX = "o lid\nv 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\nf 1 2 3 4\n"
DOWN = [[0.3, 0.4, 5, 0, 0, -1]]


@unittest.skipUnless(COMMAND.exists(), "needs the command")
class ImportFileTest(ServerTest):
    def setUp(self):
        self.folder = pathlib.Path(self.enterContext(tempfile.TemporaryDirectory()))
        self.file = self.folder / "- lid.obj"
        vertices, faces = brute.box()
        self.file.write_text("o box\n" + "".join("v %g %g %g\n" % tuple(v) for v in vertices)
                             + "".join("f %d %d %d\n" % tuple(f + 1) for f in faces))

    def import_file(self, name, file=None, **options):
        return self.client.import_file(name, file or self.file, program=str(COMMAND), **options)

    def test_import(self):
        scene = self.import_file("whole", up_axis="z", meters_per_unit=0.5, mobility="rigid")
        info = scene.info()
        self.assertEqual((info.up_axis, info.meters_per_unit, info.triangles_unique), ("z", 0.5, 12))
        hits = scene.cast(DOWN)
        self.assertEqual((hits.t.tolist(), scene.nodes(hits.node)[0].mobility), ([4.0], "rigid"))

    def test_replace(self):
        scene = self.import_file("replaced")
        with self.assertRaisesRegex(sightline.AlreadyExists, "replace=True"):
            self.import_file("replaced")
        lid = self.folder / "lid.obj"
        lid.write_text(OPEN_BOX)
        with self.assertWarnsRegex(sightline.FileWarning, "edges"):
            self.import_file("replaced", lid, replace=True)
        self.assertEqual(scene.cast(DOWN).t.tolist(), [5.0])

    def test_what_is_refused(self):
        (self.folder / "bad.glb").write_bytes(b"glTF nothing")
        (self.folder / "points.obj").write_text("v 0 0 0\n")
        for error, text, asking in (
                (FileNotFoundError, "none.obj", lambda: self.import_file("x", self.folder / "none.obj")),
                (IsADirectoryError, "", lambda: self.import_file("x", self.folder)),
                (sightline.InvalidArgument, "bad.glb", lambda: self.import_file("x", self.folder / "bad.glb")),
                (sightline.InvalidArgument, "no ray can hit", lambda: self.import_file("x", self.folder / "points.obj")),
                (ValueError, "projects/default/scenes/-X", lambda: self.import_file("-X")),
                (ValueError, "up_axis", lambda: self.import_file("x", up_axis="x")),
                (ValueError, "mobility", lambda: self.import_file("x", mobility="fast")),
                (ValueError, "meters", lambda: self.import_file("x", meters_per_unit=-1)),
                (FileNotFoundError, "SIGHTLINE", lambda: self.client.import_file("x", self.file, program="/none"))):
            with self.subTest(text), self.assertRaisesRegex(error, text):
                asking()
        self.assertEqual([scene.name for scene in self.client.scenes() if scene.name.endswith("/x")], [])

    def test_allow_empty(self):
        (self.folder / "points.obj").write_text("v 0 0 0\n")
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            scene = self.import_file("empty", self.folder / "points.obj", allow_empty=True)
        self.assertIsNone(scene.info().bounds)

    def test_a_command_that_fails_without_a_word(self):
        with self.assertRaisesRegex(sightline.Unknown, "exit code 1"):
            self.client.import_file("x", self.file, program="false")

    def test_cancelled(self):
        begun = self.folder / "begun"
        waiting = self.folder / "waiting"
        waiting.write_text(f"#!{sys.executable}\nimport pathlib, time\npathlib.Path({str(begun)!r}).touch()\n"
                           "time.sleep(1000)\n")
        waiting.chmod(0o755)

        async def run():
            async with sightline.aio.connect(self.server.endpoint) as client:
                task = asyncio.create_task(client.import_file("x", self.file, program=str(waiting)))
                while not begun.exists():
                    await asyncio.sleep(0.01)
                task.cancel()
                with self.assertRaises(asyncio.CancelledError):
                    await task
                scene = await client.import_file("by-aio", self.file, program=str(COMMAND))
                return (await scene.cast(DOWN)).hit.tolist()

        self.assertEqual(asyncio.run(run()), [True])


if __name__ == "__main__":
    unittest.main()
