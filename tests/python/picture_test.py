"""Pictures."""

import pathlib
import struct
import tempfile
import zlib

import brute
import numpy as np
from shared import ServerTest


class PictureTest(ServerTest):
    def test_the_whole_scene_is_inside(self):
        for axis in ("y", "z", None):
            vertices, faces = brute.box()
            for stretch in ([1, 1, 1], [10, 1, 1], [1, 1, 10]):
                scene = self.client.import_arrays("box", vertices * stretch + 50, faces, replace=True, up_axis=axis)
                for size in ((64, 48), (40, 120)):
                    hit = scene.render(size).hits.hit
                    self.assertEqual(hit.shape, size[::-1])
                    self.assertTrue(hit.any())
                    self.assertFalse(hit[[0, -1]].any() or hit[:, [0, -1]].any())

    def test_a_view(self):
        scene = self.scene_of(brute.box())
        picture = scene.render((40, 20), eye=(0.5, 0.5, 5), at=(0.5, 0.5, 0), up=(0, 1, 0), fov=30)
        hit = np.zeros((20, 40), bool)
        half = 10 / (4 * np.tan(np.radians(15))) / 2
        near = np.abs(np.arange(40) + 0.5 - 20) < half, np.abs(np.arange(20) + 0.5 - 10) < half
        hit[np.ix_(near[1], near[0])] = True
        np.testing.assert_array_equal(picture.hits.hit, hit)
        self.assertTrue((picture.pixels[~hit] == 255).all())
        np.testing.assert_array_equal(np.unique(picture.pixels[hit], axis=0), [picture.pixels[10, 20]])
        with self.assertRaises(AttributeError):
            picture.hits.position
        places = scene.render((40, 20), eye=(0.5, 0.5, 5), at=(0.5, 0.5, 0), up=(0, 1, 0), fov=30,
                              fields=("position",)).hits.position
        np.testing.assert_array_equal(places[hit][:, 2], 1)
        self.assertTrue(np.isnan(places[~hit]).all())
        with self.assertRaises(ValueError):
            scene.render((0, 10))
        with self.assertRaises(ValueError):
            scene.render(eye=(0, 0, 0), at=(0, 0, 0))

    def test_an_empty_scene(self):
        picture = self.client.create_scene("empty").render((8, 4))
        self.assertTrue((picture.pixels == 255).all())

    def test_png(self):
        picture = self.scene_of(brute.box()).render((31, 17))
        data = picture._repr_png_()
        self.assertEqual(data[:8], b"\x89PNG\r\n\x1a\n")
        at, content = 8, b""
        while at < len(data):
            length, kind = struct.unpack(">I4s", data[at:at + 8])
            body = data[at + 8:at + 8 + length]
            self.assertEqual(struct.unpack(">I", data[at + 8 + length:at + 12 + length])[0], zlib.crc32(kind + body))
            content += body if kind == b"IDAT" else b""
            at += 12 + length
        rows = np.frombuffer(zlib.decompress(content), np.uint8).reshape(17, 1 + 3 * 31)
        np.testing.assert_array_equal(rows[:, 1:].reshape(17, 31, 3), picture.pixels)
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder, "picture.png")
            picture.save(file)
            self.assertEqual(file.read_bytes(), data)
            with self.assertRaisesRegex(ValueError, "not .jpg"):
                picture.save(file.with_suffix(".jpg"))
