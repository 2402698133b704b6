#!/usr/bin/env python3
"""A cluster takes ports that are free, and that no other takes which starts at the same moment."""

import contextlib
import os
import pathlib
import socket
import subprocess
import sys
import tempfile
import unittest

from operator_files import DEPLOY

sys.dont_write_bytecode = True
sys.path.insert(0, str(DEPLOY))
from local_cluster.ports import Claims  # noqa: E402
from local_cluster.settings import Settings  # noqa: E402


@contextlib.contextmanager
def listener():
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        yield taken.getsockname()[1]


class Ports(unittest.TestCase):
    def test_one_that_somebody_listens_on_is_not_free(self):
        with listener() as port:
            self.assertFalse(Claims().take([port]))

    def test_one_that_a_starting_cluster_has_chosen_is_not_free(self):
        with listener() as port:
            pass
        first = Claims()
        self.assertTrue(first.take([port]))
        self.assertFalse(Claims().take([port]))

    def test_those_beside_a_taken_one_stay_free(self):
        with listener() as taken:
            with listener() as port:
                pass
            claims = Claims()
            self.assertFalse(claims.take([port, taken]))
            self.assertTrue(claims.take([port]))

    def test_they_are_free_again_when_the_command_has_ended(self):
        with listener() as port:
            pass
        script = f"import sys; sys.path.insert(0, {str(DEPLOY)!r}); from local_cluster.ports import Claims; " \
                 f"sys.exit(not Claims().take([{port}]))"
        for _ in range(2):
            self.assertEqual(subprocess.run([sys.executable, "-c", script], check=False).returncode, 0)

    def test_two_clusters_that_start_together_choose_others(self):
        os.environ.pop("SIGHTLINE_CLUSTER_PORT", None)
        with tempfile.TemporaryDirectory() as folder:
            chosen = [Settings(pathlib.Path(folder)) for _ in range(2)]
            for settings in chosen:
                settings.choose_ports()
            ports = [set(settings.ports.values()) for settings in chosen]
            self.assertFalse(ports[0] & ports[1])


unittest.main(argv=sys.argv[:1], warnings="ignore")  # claims stay until the process ends
