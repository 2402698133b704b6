#!/usr/bin/env python3
"""The wheel with programs: it works where it is unpacked, and one that would not work elsewhere is refused.

wheel_test.py BUILD_DIR    a build that has sightlined, sightline and the wheel without programs

Exits with 77 where what makes the wheel is not installed.
"""

import base64
import csv
import hashlib
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest
import zipfile

SYSTEM_PYTHON = "/usr/bin/python3"
ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.dont_write_bytecode = True
sys.path.insert(0, str(ROOT / "deploy"))
from platform_wheel import archive, check, libraries, licences  # noqa: E402
from platform_wheel.commands import Failure, output_of  # noqa: E402

BUILD = pathlib.Path()
TOOLS = ("patchelf", "readelf", "strip", "ldd", "dpkg-query")


def missing_tools():
    found = [tool for tool in TOOLS if not shutil.which(tool)]
    if subprocess.run([sys.executable, "-c", "import wheel"], capture_output=True, check=False).returncode != 0:
        found.append("wheel")
    return found


def unpack(wheel, folder):
    """As pip does, which keeps the modes of files."""
    with zipfile.ZipFile(wheel) as files:
        for entry in files.infolist():
            path = pathlib.Path(files.extract(entry, folder))
            path.chmod(entry.external_attr >> 16 & 0o777)


class WheelTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.scratch = pathlib.Path(cls.enterClassContext(tempfile.TemporaryDirectory()))
        cls.pure = next(BUILD.glob("sightline-*-py3-none-any.whl"))
        cls.programs = (BUILD / "client/sightline", BUILD / "server/sightlined")
        cls.wheel = archive.make_wheel(cls.pure, cls.programs, cls.scratch / "out")
        unpack(cls.wheel, cls.scratch / "site")
        cls.package = cls.scratch / "site/sightline_programs"
        cls.information = next((cls.scratch / "site").glob("*.dist-info"))

    def bundle(self):
        """A copy of programs and libraries, to be spoilt."""
        copy = pathlib.Path(self.enterContext(tempfile.TemporaryDirectory())) / "bundle"
        shutil.copytree(self.package, copy)
        return copy

    def test_its_name_and_content_say_the_same_platform(self):
        self.assertEqual(list((self.scratch / "out").iterdir()), [self.wheel])
        tag = self.wheel.name.removesuffix(".whl").split("-", 2)[2]
        glibc = os.confstr("CS_GNU_LIBC_VERSION").split()[1].replace(".", "_")
        self.assertEqual(tag, f"py3-none-manylinux_{glibc}_{os.uname().machine}")
        said = (self.information / "WHEEL").read_text()
        self.assertIn(f"Tag: {tag}\n", said)
        self.assertIn("Root-Is-Purelib: false\n", said)

    def test_it_holds_the_package_of_the_wheel_without_programs(self):
        with zipfile.ZipFile(self.pure) as files:
            for name in files.namelist():
                if name.startswith("sightline/"):
                    self.assertEqual((self.scratch / "site" / name).read_bytes(), files.read(name), name)

    def test_its_record_has_the_digest_of_every_file(self):
        with (self.information / "RECORD").open() as file:
            recorded = {name: digest for name, digest, _ in csv.reader(file)}
        present = {}
        for file in filter(pathlib.Path.is_file, (self.scratch / "site").rglob("*")):
            digest = base64.urlsafe_b64encode(hashlib.sha256(file.read_bytes()).digest()).decode().rstrip("=")
            present[str(file.relative_to(self.scratch / "site"))] = "" if file.name == "RECORD" else f"sha256={digest}"
        self.assertEqual(recorded, present)

    def test_its_commands_become_the_programs(self):
        for name in ("sightline", "sightlined"):
            self.assertIn(f"{name} = sightline_programs:{name}\n", (self.information / "entry_points.txt").read_text())
            script = f"import sys, sightline_programs as found; sys.argv[:] = [{name!r}, '--version']; found.{name}()"
            said = output_of("env", "-i", f"PYTHONPATH={self.scratch / 'site'}", sys.executable, "-B", "-c", script)
            self.assertEqual(said, output_of(self.programs[name == "sightlined"], "--version"))

    def test_every_library_has_a_licence_and_a_version(self):
        with (self.information / "licenses/packages.csv").open() as file:
            rows = list(csv.DictReader(file))
        listed = [name for row in rows for name in row["libraries"].split()]
        self.assertEqual(sorted(listed), sorted(file.name for file in (self.package / "lib").iterdir()))
        for row in rows:
            self.assertGreater((self.information / "licenses" / row["package"] / "copyright").stat().st_size, 0)
            self.assertRegex(row["version"], r"^[0-9]")
        self.assertTrue((self.information / "licenses/LICENSE").exists())
        self.assertTrue((self.information / "licenses/common/LGPL-2.1").exists())

    def test_no_library_of_the_c_library_is_inside(self):
        self.assertEqual({file.name for file in (self.package / "lib").iterdir()} & libraries.system_libraries(), set())

    def test_other_versions_in_the_environment_are_not_taken(self):
        other = self.bundle() / "lib"
        for file in other.iterdir():
            file.write_bytes(b"no library")
        for name in ("sightline", "sightlined"):
            said = subprocess.run([self.package / "bin" / name, "--version"], env={"LD_LIBRARY_PATH": str(other)},
                                  text=True, capture_output=True, check=False)
            self.assertEqual((said.returncode, said.stderr), (0, ""))

    def test_a_library_that_is_left_out_is_refused(self):
        # The first is named by the programs, the second by the first, the third by libraries of libpq.
        for name in ("libgrpc.so.29", "libcares.so.2", "libkrb5support.so.0"):
            bundle = self.bundle()
            (bundle / "lib" / name).unlink()
            with self.assertRaisesRegex(Failure, f"needs {name}, which is left out"):
                check.check_files(bundle)

    def test_files_that_would_look_elsewhere_are_refused(self):
        bundle = self.bundle()
        output_of("patchelf", "--set-rpath", "/opt/lib", bundle / "lib/libfmt.so.9")
        with self.assertRaisesRegex(Failure, r"libfmt\.so\.9 looks .*/opt/lib"):
            check.check_files(bundle)
        bundle = self.bundle()
        output_of("patchelf", "--remove-rpath", bundle / "bin/sightline")
        with self.assertRaisesRegex(Failure, "sightline looks .*the folders of the system"):
            check.check_files(bundle)

    def test_a_program_of_another_version_is_refused(self):
        with self.assertRaisesRegex(Failure, "of version 99"):
            check.check_versions(self.package, "99")

    def test_a_library_without_a_package_or_a_licence_is_refused(self):
        with tempfile.TemporaryDirectory() as made:
            own = pathlib.Path(made) / "libown.so"
            own.write_bytes(b"")
            with self.assertRaisesRegex(Failure, "no Debian package"):
                licences.write_licences({"libown.so": own}, pathlib.Path(made) / "licences")


if __name__ == "__main__":
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    if os.path.realpath(sys.executable) != os.path.realpath(SYSTEM_PYTHON) and os.path.exists(SYSTEM_PYTHON):
        os.execv(SYSTEM_PYTHON, [SYSTEM_PYTHON, *sys.argv])  # the distribution's has its packages
    tools = missing_tools()
    if tools:
        print(f"skipped: {', '.join(tools)} missing (deploy/install-packages build package)")
        sys.exit(77)
    BUILD = pathlib.Path(sys.argv.pop(1)).resolve()
    unittest.main(verbosity=2)
