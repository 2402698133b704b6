"""One server for the tests of a file, and the command."""

import os
import pathlib
import unittest

import sightline

COMMAND = pathlib.Path(os.environ.get("SIGHTLINED", "")).parents[1] / "client" / "sightline"


class ServerTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.server = sightline.serve()
        cls.addClassCleanup(cls.server.close)
        cls.client = cls.server.client

    def scene_of(self, mesh, **options):
        """A scene of a mesh, for this test."""
        return self.client.import_arrays(self.id().lower().rpartition(".")[2].replace("_", "-"), *mesh, **options)
