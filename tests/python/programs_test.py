"""Where the package looks for the programs."""

import os
import pathlib
import tempfile
import unittest
from unittest import mock

import sightline
from sightline import _programs


class ProgramsTest(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(self.enterContext(tempfile.TemporaryDirectory()))
        self.enterContext(mock.patch.dict(os.environ, {"PATH": str(self.folder / "path")}))
        os.environ.pop("SIGHTLINED")
        self.enterContext(mock.patch.object(_programs, "_BUNDLED", self.folder / "site/sightline_programs/bin"))

    def program(self, name, mode=0o755):
        file = self.folder / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text("#!/bin/sh\n")
        file.chmod(mode)
        return str(file)

    def found(self, given=None):
        return _programs.find_program("sightlined", given, "SIGHTLINED")

    def test_what_is_named_comes_first_then_the_wheels_own_then_path(self):
        in_path = self.program("path/sightlined")
        self.assertEqual(self.found(), in_path)
        own = self.program("site/sightline_programs/bin/sightlined")
        self.assertEqual(self.found(), own)
        os.environ["SIGHTLINED"] = ""
        self.assertEqual(self.found(), own)
        os.environ["SIGHTLINED"] = self.program("named")
        self.assertEqual(self.found(), os.environ["SIGHTLINED"])
        given = self.program("given")
        self.assertEqual(self.found(given), given)

    def test_what_is_named_has_to_be_a_program(self):
        self.program("path/sightlined")
        for name in (self.folder / "missing", self.program("plain", 0o644), self.folder):
            with self.assertRaisesRegex(FileNotFoundError, f"^{name} is not a program: set SIGHTLINED"):
                self.found(str(name))

    def test_without_a_program_the_error_says_how_to_get_one(self):
        with self.assertRaisesRegex(FileNotFoundError, "no sightlined.*deploy/wheel.*sightline-server.*SIGHTLINED"):
            sightline.serve()

    def test_a_wheel_that_lost_its_modes_is_not_passed_over(self):
        self.program("path/sightlined")
        own = self.program("site/sightline_programs/bin/sightlined", 0o644)
        with self.assertRaisesRegex(FileNotFoundError, f"^{own} is not executable: .* pip"):
            self.found()
