"""One server for the tests of a file."""

import unittest

import sightline


class ServerTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.server = sightline.serve()
        cls.addClassCleanup(cls.server.close)
        cls.client = cls.server.client

    def scene_of(self, mesh, **options):
        """A scene of a mesh, for this test."""
        return self.client.import_arrays(self.id().lower().rpartition(".")[2].replace("_", "-"), *mesh, **options)
