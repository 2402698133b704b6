"""The programs of docs/languages: their answers are those of the Python client, bit by bit.

They run by the commands that docs/other_languages.md shows, and print what it says. They are skipped where a language or
its packages are missing. npm fetches packages only where SIGHTLINE_NPM=1 lets it.
"""

import hashlib
import os
import pathlib
import re
import shutil
import subprocess
import tempfile
import unittest
from contextlib import contextmanager

import grpc
import numpy as np
from refusing import Refusing
from shared import ServerTest

ROOT = pathlib.Path(__file__).resolve().parents[2]
PAGE = (ROOT / "docs/other_languages.md").read_text()
LANGUAGES = ROOT / "docs/languages"
INSTALLED = "/usr/share/sightline/proto"
SIDE = 257
ORIGINS = [[10.3, 20.6, 30], [100.25, 200.5, 30], [-5, -5, 30], [0, 0, 30]]
DIRECTIONS = [[0, 0, -1], [0.1, 0.2, -1], [0, 0, -1], [0, 0, 0]]


def blocks(language, heading):
    """The code that a section of the page shows."""
    section = re.search(rf"^## {heading}\n(.*?)^## ", PAGE, re.MULTILINE | re.DOTALL)[1]
    return re.findall(rf"^```{language}\n(.*?)^```$", section, re.MULTILINE | re.DOTALL)


def node_lacks():
    """What is missing to run the program for Node; empty: nothing."""
    if not shutil.which("node"):
        return "needs node (deploy/install-packages languages)"
    version = subprocess.run(["node", "--version"], capture_output=True, text=True, check=True).stdout.strip()
    if int(version[1:].split(".")[0]) < 18:
        return f"needs node 18 or later, not {version}"
    if (LANGUAGES / "node/node_modules").is_dir():
        return ""
    if os.environ.get("SIGHTLINE_NPM") != "1":
        return "needs SIGHTLINE_NPM=1, which lets npm fetch the packages of docs/languages/node"
    return "" if shutil.which("npm") else "needs npm (deploy/install-packages languages)"


def ruby_lacks():
    """What is missing to run the program for Ruby; empty: nothing."""
    if not all(shutil.which(name) for name in ("ruby", "protoc", "grpc_ruby_plugin")):
        return "needs ruby-grpc and protobuf-compiler-grpc (deploy/install-packages languages)"
    if subprocess.run(["ruby", "-e", 'require "grpc"'], capture_output=True, check=False).returncode != 0:
        return "needs ruby-grpc (deploy/install-packages languages)"
    return ""


def hills():
    """The mesh that the programs make."""
    y, x = np.divmod(np.arange(SIDE * SIDE), SIDE)
    vertices = np.stack([x, y, (x * x + 3 * y * y + x * y) % 64 / 8], axis=-1)
    corner = np.arange(SIDE * SIDE).reshape(SIDE, SIDE)[:-1, :-1].reshape(-1, 1)
    return vertices, (corner + [0, 1, SIDE, 1, SIDE + 1, SIDE]).reshape(-1, 3)


def numbers(hits):
    """The hits of a cast as the programs' lines have them."""
    rows = zip(hits.t, hits.node, hits.primitive)
    return [(repr(float(t)), int(node), int(primitive)) for t, node, primitive in rows]


@contextmanager
def served(folder, *flags):
    """A server of one test, in this folder. Yields the line of its log that says where it listens."""
    server = subprocess.Popen([os.environ["SIGHTLINED"], *flags], cwd=folder, stderr=subprocess.PIPE, text=True)
    try:
        yield next(line for line in server.stderr if "event=started" in line)
    finally:
        server.terminate()
        server.communicate()


class Programs:
    """The tests of one language. `NAME`: its folder; `HEADING`: its section of the page."""

    NAME = HEADING = ""

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.folder = pathlib.Path(folder.name) / "program"
        shutil.copytree(LANGUAGES / cls.NAME, cls.folder, ignore=shutil.ignore_patterns("node_modules"))
        *prepare, cls.command = blocks("sh", cls.HEADING)[0].replace("\\\n", "").splitlines()
        for line in cls.commands(prepare):
            subprocess.run(line.replace(INSTALLED, str(ROOT / "proto")), shell=True, cwd=cls.folder, check=True)

    @classmethod
    def commands(cls, prepare):
        """Those by which the page prepares the program."""
        return prepare

    def start(self, endpoint, **variables):
        """Runs the program as the page does."""
        environment = {name: value for name, value in os.environ.items() if not name.startswith("SIGHTLINE")}
        environment.update(SIGHTLINE_PROTO=str(ROOT / "proto"), SIGHTLINE_ENDPOINT=endpoint, **variables)
        return subprocess.run(self.command, shell=True, cwd=self.folder, env=environment, capture_output=True,
                              text=True, check=False)

    def lines(self, endpoint, **variables):
        """What the program prints, without the mesh and the name of its scene."""
        ran = self.start(endpoint, **variables)
        self.assertEqual((ran.returncode, ran.stderr), (0, ""))
        return ran.stdout.replace(f"hills-{self.NAME}", "hills-node").splitlines()

    def shown(self):
        """What the page says that the programs print."""
        section = re.search(r"^## What both print\n(.*)", PAGE, re.MULTILINE | re.DOTALL)[1]
        return [line[4:] for line in section.splitlines() if line.startswith("    ")]

    def test_answers_are_those_of_python(self):
        lines = self.lines(self.server.endpoint)
        scene = self.client.import_arrays(f"hills-of-python-for-{self.NAME}", *hills(), replace=True)
        digest = scene.nodes()[0].mesh_digest
        expected = [f"mesh {digest}", "scene of 1 node, 131072 triangles", "revision 1",
                    *numbers(scene.cast(origins=ORIGINS, directions=DIRECTIONS))]
        ray = np.arange(100_000)
        origins = np.stack([ray % 500 * 0.53, ray // 500 * 1.31, np.full(ray.size, 20.0)], axis=-1)
        many = scene.cast(origins=origins, directions=[0.25, -0.125, -1])
        columns = b"".join(np.ascontiguousarray(column).tobytes() for column in (many.t, many.node, many.primitive))
        expected.append(f"100000 rays, {many.hit.sum()} hits, columns {hashlib.sha256(columns).hexdigest()}")
        scene.set_transforms([1], np.array([[[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 2.5]]], "f8"))
        expected += ["moved at revision 2, and again: replayed", "revision 2",
                     *numbers(scene.cast(origins=ORIGINS, directions=DIRECTIONS)),
                     "as expected: there is no scene projects/default/scenes/hills-node-2"]
        found = [(repr(float(hit[1])), int(hit[2]), int(hit[3])) if hit else line for line, hit in
                 ((line, re.fullmatch(r"  t (\S+) node (\d+) primitive (\d+)", line)) for line in lines)]
        self.assertEqual(found, expected)
        self.assertEqual(lines, self.shown())
        made = self.client.scene(f"hills-{self.NAME}")
        vertices, faces = hills()
        mesh = made.read_mesh(1)
        np.testing.assert_array_equal(mesh.vertices, vertices.astype("f4"))
        np.testing.assert_array_equal(mesh.faces, faces)

    def test_a_scene_that_is_there_is_replaced(self):
        self.assertEqual(self.lines(self.server.endpoint), self.lines(self.server.endpoint))

    def test_what_is_refused_for_now_is_sent_again(self):
        status = grpc.StatusCode
        for code, delay, refusals in ((status.RESOURCE_EXHAUSTED, 0.001, 5), (status.UNAVAILABLE, None, 3)):
            with self.subTest(code.name):
                between = Refusing(self.server.endpoint)
                self.addCleanup(between.close)
                between.refusal.code = code
                between.refusal.trailing_metadata = type(between.refusal)("QUEUE_FULL", delay).trailing_metadata
                between.refusals = {"CastRays": refusals, "ApplyUpdates": refusals, "FindMissingBlobs": refusals}
                self.assertEqual(self.lines(between.endpoint), self.shown())
                self.assertEqual(between.calls["ApplyUpdates"], refusals + 2)

    def test_what_is_refused_for_good_is_not_sent_again(self):
        between = Refusing(self.server.endpoint)
        self.addCleanup(between.close)
        between.refusal = type(between.refusal)("TOO_MANY_RAYS", None)
        between.refusals = {"CastRays": 1}
        ran = self.start(between.endpoint)
        self.assertNotEqual(ran.returncode, 0)
        self.assertIn("come back later", ran.stderr)
        self.assertEqual(between.calls["CastRays"], 1)

    def test_a_socket(self):
        with tempfile.TemporaryDirectory() as folder, served(folder, "--listen", f"unix:{folder}/socket"):
            self.assertEqual(self.lines(f"unix:{folder}/socket"), self.shown())

    @unittest.skipUnless(shutil.which("openssl"), "needs openssl")
    def test_tokens_and_tls(self):
        with tempfile.TemporaryDirectory() as name:
            folder = pathlib.Path(name)
            subprocess.run("openssl req -x509 -newkey ec -pkeyopt ec_paramgen_curve:P-256 -nodes -subj /CN=localhost "
                           "-addext subjectAltName=DNS:localhost -days 2 -keyout key.pem -out cert.pem", shell=True,
                           cwd=folder, check=True, capture_output=True)
            digest = hashlib.sha256(b"secret").hexdigest()
            (folder / "tokens.toml").write_text(
                f'[[token]]\nname = "it"\nsha256 = "{digest}"\nrole = "admin"\nscenes = [""]\n')
            authority = {"SIGHTLINE_TLS_CA": str(folder / "cert.pem")}
            wrong = {"SIGHTLINE_TOKEN": "other", **authority}
            with served(folder, "--listen", "localhost:0", "--tls-cert", "cert.pem", "--tls-key", "key.pem", "--tokens",
                        "tokens.toml") as line:
                endpoint = f"localhost:{re.search(r' port=([0-9]+)', line)[1]}"
                self.assertEqual(self.lines(endpoint, SIGHTLINE_TOKEN="secret", **authority), self.shown())
                for variables, code in ((authority, "UNAUTHENTICATED"), (wrong, "UNAUTHENTICATED"),
                                        ({"SIGHTLINE_TOKEN": "secret"}, "UNAVAILABLE")):
                    ran = self.start(endpoint, **variables)
                    self.assertNotEqual(ran.returncode, 0)
                    self.assertRegex(ran.stderr.upper(), code)

    def test_a_token_that_others_could_read_is_not_sent(self):
        for endpoint in ("192.0.2.1:50151", "127.0.0.1.example.org:50151", "localhost.example.org:50151"):
            ran = self.start(endpoint, SIGHTLINE_TOKEN="secret")
            self.assertNotEqual(ran.returncode, 0)
            self.assertIn(f"the token is not sent to {endpoint} without encryption", ran.stderr)
        self.assertIn("other than visible ASCII", self.start("127.0.0.1:1", SIGHTLINE_TOKEN="two words").stderr)

    def test_the_page_shows_the_programs(self):
        sources = "".join(file.read_text() for file in (LANGUAGES / self.NAME).iterdir() if file.is_file())
        shown = blocks({"node": "js", "ruby": "ruby"}[self.NAME], self.HEADING)
        self.assertEqual(len(shown), 1)
        self.assertIn(shown[0], sources)


@unittest.skipIf(node_lacks(), node_lacks())
class NodeTest(Programs, ServerTest):
    NAME, HEADING = "node", "Node"

    @classmethod
    def commands(cls, prepare):
        present = LANGUAGES / "node/node_modules"
        if not present.is_dir():
            return prepare
        (cls.folder / "node_modules").symlink_to(present)
        return []


@unittest.skipIf(ruby_lacks(), ruby_lacks())
class RubyTest(Programs, ServerTest):
    NAME, HEADING = "ruby", "Ruby"
