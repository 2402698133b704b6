"""The examples of docs/python.md run, in order."""

import contextlib
import io
import pathlib
import re
import unittest

PAGE = pathlib.Path(__file__).resolve().parents[2] / "docs" / "python.md"


class PageTest(unittest.TestCase):
    def test_examples(self):
        examples = re.findall(r"^```python\n(.*?)^```$", PAGE.read_text(), re.MULTILINE | re.DOTALL)
        self.assertGreater(len(examples), 5)
        printed, names = io.StringIO(), {}
        with contextlib.redirect_stdout(printed):
            for example in examples:
                exec(compile(example, str(PAGE), "exec"), names)
        self.addCleanup(names["server"].close)
        self.assertIn("SCENE_NOT_FOUND", printed.getvalue())
        self.assertIn("[1. 0.]", printed.getvalue())
        self.assertEqual(names["picture"].pixels.shape, (240, 320, 3))
        self.assertEqual(names["near"].hit.tolist(), [True, True, False])
        self.assertEqual(names["two"].point.tolist(), [0, 0, 1, 1, 2, 2])
        self.assertEqual(names["clearance"].shape, (31, 41))
        self.assertEqual([names["sides"].inside.tolist(), names["sides"].votes.tolist()], [[True, False], [7, 0]])
