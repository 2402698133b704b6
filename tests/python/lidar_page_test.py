"""The examples of docs/lidar.md run, in order."""

import contextlib
import io
import os
import pathlib
import re
import tempfile
import unittest

import numpy as np

PAGE = pathlib.Path(__file__).resolve().parents[2] / "docs" / "lidar.md"


class LidarPageTest(unittest.TestCase):
    def test_examples(self):
        printed, names = io.StringIO(), {}
        with tempfile.TemporaryDirectory() as folder, contextlib.redirect_stdout(printed):
            self.addCleanup(os.chdir, os.getcwd())
            os.chdir(folder)
            for example in re.findall(r"^```python\n(.*?)^```$", PAGE.read_text(), re.MULTILINE | re.DOTALL):
                exec(compile(example, str(PAGE), "exec"), names)
            self.assertEqual(os.listdir(folder), ["ground.las"])
        self.addCleanup(names["server"].close)
        self.assertTrue(printed.getvalue().endswith("True\n"), printed.getvalue())
        heights = names["cloud"].position[:, 2]
        self.assertTrue(len(heights) > 30_000 and np.abs(heights).max() < 0.1)


if __name__ == "__main__":
    unittest.main()
