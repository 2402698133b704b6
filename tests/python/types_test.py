"""The package and the recipes by mypy, strictly, and what imports what."""

import ast
import importlib.util
import os
import pathlib
import subprocess
import tempfile
import unittest

import sightline

ROOT = pathlib.Path(__file__).resolve().parents[2]
PACKAGE = pathlib.Path(sightline.__file__).parent
SYSTEM_PYTHON = "/usr/bin/python3"  # which sees the distribution's mypy
HAS_MYPY = importlib.util.find_spec("mypy") is not None
# What a program gets: each line is right. The test of mistakes has what is wrong.
USE = """
from typing import Iterator

import numpy as np
import sightline
import sightline.aio
from numpy.typing import NDArray


def use(scene: sightline.Scene, client: sightline.Client, rays: NDArray[np.float64],
        parts: Iterator[NDArray[np.float64]]) -> None:
    hits: sightline.Hits = scene.cast(rays)
    t: NDArray[np.float64] = hits.t
    node: NDArray[np.uint64] = hits[3].node
    seen: NDArray[np.bool_] = scene.cast([[0, 0, 0, 0, 0, 1]], kind="any").hit
    every: sightline.AllHits = scene.cast(sightline.SphericalScan([0, 0, 0], 8, 8), kind="all", exclude=["win*", 3])
    several: Iterator[sightline.Hits] = scene.cast(parts)
    near: sightline.Nearest = scene.closest(sightline.PointGrid([0, 0, 0], [1, 0, 0], [0, 1, 0], 3, 3), under="door")
    faces: sightline.AllNearest = scene.closest(rays, kind="all")
    inside: NDArray[np.bool_] = scene.contains(rays)
    stats: int = scene.stats().triangles_built
    limit: int = client.server_info().max_rays_per_request
    nodes: list[sightline.NodeInfo] = scene.find_all("win*")
    vertices: NDArray[np.float32] = scene.read_mesh(nodes[0]).vertices
    print(t, node, seen, every, several, near, faces, inside, stats, limit, vertices)


async def wait(scene: sightline.aio.Scene, rays: NDArray[np.float64]) -> None:
    hits: sightline.Hits = await scene.cast(rays)
    report: sightline.PrefetchReport = await scene.prefetch(under="door")
    every: sightline.AllHits = await scene.cast(rays, kind="all")
    async for part in scene.cast_batches([rays]):
        print(part.t, hits, report, every)
"""
MISTAKES = ["scene.cast(rays, kind='every')", "scene.cast(rays, max_hits='3')", "scene.cast(rays).distance",
            "scene.stats().triangles", "scene.closest(rays, max_dist=3)", "scene.prefetch(rays, bar=True)",
            "client.import_file(3)", "client.server_info().max_ray"]


@unittest.skipUnless(HAS_MYPY and os.path.exists(SYSTEM_PYTHON), "needs mypy")
class TypesTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.cache = cls.enterClassContext(tempfile.TemporaryDirectory())

    def check(self, *files):
        """What mypy says of files."""
        done = subprocess.run(
            [SYSTEM_PYTHON, "-m", "mypy", "--config-file", ROOT / "client/python/pyproject.toml", "--cache-dir", self.cache,
             "--scripts-are-modules", *files], env={**os.environ, "MYPYPATH": str(PACKAGE.parent)}, cwd=ROOT, text=True,
            capture_output=True, check=False)
        return done.stdout + done.stderr

    def test_package_and_recipes(self):
        self.assertIn("Success: no issues found", self.check(PACKAGE, *sorted((ROOT / "docs/recipes").glob("*.py"))))

    def test_types_of_what_programs_get(self):
        with tempfile.TemporaryDirectory() as folder:
            use = pathlib.Path(folder) / "use.py"
            use.write_text(USE)
            self.assertIn("Success: no issues found", self.check(use))
            wrong = pathlib.Path(folder) / "wrong.py"
            wrong.write_text(USE.partition("\n\nasync")[0] + "".join(f"    {line}\n" for line in MISTAKES))
            told = self.check(wrong)
            for number, line in enumerate(MISTAKES, len(USE.partition("\n\nasync")[0].splitlines()) + 1):
                self.assertIn(f"wrong.py:{number}: error", told, line)


class ImportsTest(unittest.TestCase):
    def test_no_circles(self):
        """Those for types alone count, too."""
        graph = {file.stem: self.imports_of(file) for file in PACKAGE.glob("*.py")}
        graph["_connection"].discard("_segments")  # it makes the pool of the segments that its own calls fill
        seen, open_ = set(), []

        def walk(name):
            self.assertNotIn(name, open_)
            if name in seen:
                return
            open_.append(name)
            for other in sorted(graph.get(name, ())):
                walk(other)
            open_.pop()
            seen.add(name)

        for name in graph:
            walk(name)

    @staticmethod
    def imports_of(file):
        found = set()
        for node in ast.walk(ast.parse(file.read_text())):
            if isinstance(node, ast.ImportFrom) and node.level == 1:
                found.update([node.module.split(".")[0]] if node.module else [alias.name for alias in node.names])
        return {name for name in found if (PACKAGE / f"{name}.py").exists()}

    def test_one_class_a_file(self):
        """Of classes that programs meet; errors, and changes of nodes, are families of small ones."""
        for file in PACKAGE.glob("[a-z]*.py"):
            classes = [node.name for node in ast.parse(file.read_text()).body if isinstance(node, ast.ClassDef)]
            public = [name for name in classes if not name.startswith("_") and name in sightline.__all__]
            if file.stem not in ("errors", "updates", "shared_memory"):
                self.assertLessEqual(len(public), 1, file.name)


if __name__ == "__main__":
    unittest.main()
