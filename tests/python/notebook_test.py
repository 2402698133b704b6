"""docs/recipes/first_look.ipynb runs from top to end: as plain Python, and in a kernel where nbclient is installed."""

import contextlib
import io
import json
import pathlib
import tempfile
import unittest

try:
    import ipykernel
    import nbclient
    import nbformat
except ImportError:
    ipykernel = nbclient = nbformat = None

NOTEBOOK = pathlib.Path(__file__).resolve().parents[2] / "docs" / "recipes" / "first_look.ipynb"


class NotebookTest(unittest.TestCase):
    def check(self, printed):
        """The hill has height 12 exp(-x^2 / 400), the mast is 15 high and stands at 3."""
        self.assertIn("x     0   height 12.0", printed)
        self.assertIn("x    40   height  0.22   hill", printed)
        self.assertRegex(printed, r"x    20   height 18\.00   mast")
        self.assertRegex(printed, r"\b\d{2,4} of 79206 triangles are built")
        self.assertIn("now ['mast'] before ['hill']", printed)

    def test_as_plain_python(self):
        cells = json.loads(NOTEBOOK.read_text())["cells"]
        printed, names = io.StringIO(), {}
        with contextlib.redirect_stdout(printed):
            for cell in cells:
                if cell["cell_type"] == "code":
                    self.assertEqual(cell["outputs"], [])  # they would change with every run
                    exec(compile("".join(cell["source"]), str(NOTEBOOK), "exec"), names)
        self.check(printed.getvalue())
        self.assertEqual(names["picture"].pixels.shape, (320, 480, 3))
        self.assertTrue(names["picture"].hits.hit.any())

    @unittest.skipIf(nbclient is None, "python3-nbclient or python3-ipykernel is missing")
    def test_in_a_kernel(self):
        notebook = nbformat.read(NOTEBOOK, as_version=4)
        with tempfile.TemporaryDirectory() as folder:
            nbclient.NotebookClient(notebook, kernel_name="python3", timeout=None,
                                    resources={"metadata": {"path": folder}}).execute()
        outputs = [output for cell in notebook.cells for output in cell.get("outputs", [])]
        self.check("".join(output.get("text", "") for output in outputs))
        self.assertEqual(sum("image/png" in output.get("data", {}) for output in outputs), 1)
