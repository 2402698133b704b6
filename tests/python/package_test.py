"""The package as it is delivered."""

import os
import pathlib
import shutil
import subprocess
import sys
import tarfile
import tempfile
import types
import unittest

import grpc
import sightline

try:
    import setuptools
except ImportError:
    setuptools = None

ROOT = pathlib.Path(__file__).resolve().parents[2]


def files_below(folder):
    """Relative paths, without what an interpreter leaves behind that imports the package."""
    return {file.relative_to(folder) for file in folder.rglob("*") if file.is_file() and file.parent.name != "__pycache__"}


class PackageTest(unittest.TestCase):
    def test_it_has_descriptors_types_and_a_version_and_no_generated_code(self):
        folder = pathlib.Path(sightline.__file__).parent
        self.assertTrue((folder / "py.typed").exists())
        self.assertRegex(sightline.__version__, r"^\d+\.\d+\.\d+$")
        self.assertEqual(list(folder.rglob("*_pb2*")), [])

    @unittest.skipUnless(setuptools and shutil.which("protoc"), "needs setuptools and protoc")
    def test_a_source_archive_builds_the_same_package(self):
        with tempfile.TemporaryDirectory() as made:
            folder = pathlib.Path(made)
            for part in ("client/python", "proto"):
                shutil.copytree(ROOT / part, folder / "tree" / part, ignore=shutil.ignore_patterns("__pycache__"))
            shutil.copy(ROOT / "CMakeLists.txt", folder / "tree")
            self.set_up(folder / "tree/client/python", "sdist", "--dist-dir", made)
            shutil.rmtree(folder / "tree")
            name = f"sightline-{sightline.__version__}"
            with tarfile.open(folder / f"{name}.tar.gz") as archive:
                archive.extractall(made)
            self.set_up(folder / name, "build", "--build-lib", folder / "lib")
            built = folder / "lib/sightline"
            used = pathlib.Path(sightline.__file__).parent
            files = files_below(used)
            self.assertEqual(files_below(built), files)
            for file in files:
                self.assertEqual((built / file).read_bytes(), (used / file).read_bytes(), file)

    def set_up(self, folder, *words):
        done = subprocess.run([sys.executable, "setup.py", "-q", *map(str, words)], cwd=folder, capture_output=True,
                              text=True, check=False)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)

    def test_its_messages_clash_with_none(self):
        # Another version of the same files in the default pool, before and after.
        text = """
from google.protobuf import descriptor_pb2, descriptor_pool
def add():
    for name in ("google/rpc/status.proto", "sightline/v1/common.proto"):
        package = name.rpartition("/")[0].replace("/", ".")
        file = descriptor_pb2.FileDescriptorProto(name=name, package=package)
        file.message_type.add(name="Status" if "rpc" in name else "Transform")
        descriptor_pool.Default().AddSerializedFile(file.SerializeToString())
add()
import sightline
from sightline import _proto
assert _proto.Transform(matrix=[1]).matrix == [1]
assert _proto.message("google.rpc.Status")(code=3).code == 3
import sys
assert "google.rpc" not in sys.modules
print("ok")
"""
        done = subprocess.run([sys.executable, "-c", text], capture_output=True, text=True, check=False)
        self.assertEqual((done.stdout, done.stderr), ("ok\n", ""))

    def test_its_server_is_the_one_of_the_tests(self):
        with sightline.serve() as server:
            self.assertEqual(server.client.server_info().version, sightline.__version__)
            self.assertTrue(os.path.exists(server.endpoint[len("unix:"):]))

    def test_errors_are_what_python_calls_them(self):
        errors = sightline.errors
        self.assertIsInstance(errors.of_code(5, "text", "REASON"), LookupError)
        error = errors.of_code(3, "text", "REASON")
        self.assertIsInstance(error, ValueError)
        self.assertEqual((error.message, error.reason, str(error)), ("text", "REASON", "text [REASON]"))
        self.assertIsInstance(errors.of_code(99, "text"), errors.Unknown)
        call = types.SimpleNamespace(code=lambda: grpc.StatusCode.UNIMPLEMENTED, details=lambda: "",
                                     trailing_metadata=lambda: None)
        error = errors.of_call(call)  # what a server says of a call that it does not know
        self.assertIsInstance(error, errors.Unimplemented)
        self.assertRegex(str(error), "does not have this call")
