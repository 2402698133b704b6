"""Local clients that mean no good, or that die: the server lives, others get their answers, and it holds nothing for them."""

import gc
import pathlib
import subprocess
import sys
import unittest

import brute
import numpy as np
import sightline
from hostile_client import BYTES, STEPS
from proxy import Proxy
from shared import ServerTest
from sightline import _proto, errors

_HOSTILE = pathlib.Path(__file__).with_name("hostile_client.py")


class HostileSegmentTest(ServerTest):
    def setUp(self):
        self.scene = self.scene_of(brute.soup())
        self.rays = np.tile(brute.rays(300), (100, 1))
        self.expected = self.scene.cast(self.rays).t.copy()
        self.before = self.held()  # the good client's own segments

    def held(self):
        info = self.client._connection.call("GetServerInfo", _proto.GetServerInfoRequest())
        return {kind.kind: kind.bytes for kind in info.memory}["segments"]

    def wait_until_given_back(self):
        while self.held() > self.before:
            pass

    def wait_until_ended(self, segment):
        """Until the server finds no segment of this name."""
        request = _proto.CastRaysRequest(scene=self.scene.name, segment=segment)
        request.shared.SetInParent()
        while True:
            try:
                self.client._connection.call("CastRays", request.SerializeToString())
            except errors.NotFound as error:
                return self.assertEqual(error.reason, "SEGMENT_NOT_FOUND")

    def expect_service(self):
        self.assertEqual(self.scene.cast(self.rays).t.tobytes(), self.expected.tobytes())
        self.assertEqual(self.client.transport.kind, "segments", self.client.transport.reason)

    def hostile(self, step):
        """One that has come to this step; and its line."""
        process = subprocess.Popen([sys.executable, str(_HOSTILE), self.server.endpoint, self.scene.name, step],
                                   stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        self.addCleanup(self.end, process)
        line = process.stdout.readline().split()
        self.assertEqual(len(line), 3, step)
        return process, line

    def end(self, process):
        process.kill()
        process.wait()
        process.stdin.close()
        process.stdout.close()

    def again(self, process):
        process.stdin.write("\n")
        process.stdin.flush()
        return process.stdout.readline().split()

    def test_one_that_is_killed_at_any_step(self):
        for step in STEPS:
            with self.subTest(step):
                process, _ = self.hostile(step)
                if not step.startswith("left"):
                    self.assertEqual(self.held(), self.before + BYTES)
                self.expect_service()
                self.end(process)
                self.wait_until_given_back()
                self.expect_service()

    def test_one_that_keeps_its_connection_is_counted(self):
        process, (segment, _, _) = self.hostile("ended")
        self.wait_until_ended(segment)
        self.assertEqual(self.held(), self.before + BYTES)
        self.assertEqual(self.again(process), [segment, str(BYTES // 4096), "True"])
        self.end(process)
        self.wait_until_given_back()

    def test_one_that_keeps_its_mapping_has_none_of_the_memory(self):
        for step in ("left", "left first"):
            with self.subTest(step):
                process, (segment, _, _) = self.hostile(step)
                self.wait_until_given_back()
                self.assertEqual(self.again(process), [segment, "0", "False"])
                self.expect_service()

    def test_many_that_keep_their_mappings_take_nothing(self):
        kept = [self.hostile("left") for _ in range(5)]
        self.wait_until_given_back()
        self.assertEqual([self.again(process)[1:] for process, _ in kept], 5 * [["0", "False"]])
        self.expect_service()

    def test_arrays_of_a_good_client_stay_when_its_connection_breaks(self):
        proxy = Proxy(self.server.endpoint)
        self.addCleanup(proxy.close)
        client = sightline.connect(proxy.endpoint)
        memory = client.share_memory(BYTES)
        self.assertTrue(memory.is_shared, memory.why_not_shared)
        segment = memory._segment.name
        kept = memory.empty((1000, 3))[::2, 1]
        kept[:] = 7
        proxy.cut()
        self.wait_until_ended(segment)
        self.assertEqual(self.held(), self.before + BYTES)
        client.close()
        del memory, client
        gc.collect()
        self.assertEqual(self.held(), self.before + BYTES)
        self.assertTrue((kept == 7).all())
        del kept
        gc.collect()
        self.wait_until_given_back()


if __name__ == "__main__":
    unittest.main()
