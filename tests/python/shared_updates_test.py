"""Casts with updates through memory that client and server share: answers, revisions, and calls that break."""

import asyncio
import os
import pathlib
import subprocess
import tempfile
import unittest

import brute
import numpy as np
import sightline
from proxy import Proxy
from shared import ServerTest
from sightline import aio, errors, updates


def shifted(height):
    """A pose (1, 3, 4) that is raised by a height."""
    pose = np.eye(3, 4)
    pose[2, 3] = height
    return pose[None]


class SharedUpdatesTest(ServerTest):
    def setUp(self):
        self.scene = self.client.create_scene(self.id().lower().rpartition(".")[2].replace("_", "-"))
        self.node = self.scene.add(brute.soup(), mobility="rigid")
        self.revision = self.scene.info().revision
        self.other = sightline.connect(self.server.endpoint, use_segments=False)
        self.addCleanup(self.other.close)
        self.rays = np.tile(brute.rays(300), (200, 1))  # 60,000

    def expected(self, rays, revision, **options):
        """The same by messages, at a revision."""
        return self.other.scene(self.scene.name).cast(rays, revision=revision, **options)

    def test_rays(self):
        for step, (rays, options) in enumerate((
                (self.rays, {}), (self.rays.astype("f4"), {"fields": ("t", "position")}),
                (self.rays[:9000], {"fields": ("node", "name")}), (self.rays[:9000], {"kind": "any"}),
                (self.rays.reshape(20, 3000, 6), {"kind": "count", "time_budget": 3600}))):
            seen = []
            hits = self.scene.cast(rays, apply=updates.set_transforms([self.node], shifted(0.1 * step)),
                                   progress=lambda done, of: seen.append((done, of)), **options)
            self.assertEqual((hits.revision, hits.applied.revision), (self.revision + 1 + step,) * 2)
            expected = self.expected(rays, hits.revision, **options)
            for name, column in expected._columns.items():
                np.testing.assert_array_equal(hits._columns[name], column, name)
            self.assertEqual((hits.shape, seen[-1]), (expected.shape, (hits.stats["rays"],) * 2))
        self.assertEqual(self.client.transport.kind, "segments", self.client.transport.reason)

    def test_points(self):
        near = self.scene.closest(self.rays[:, :3], apply=updates.set_transforms([self.node], shifted(1)))
        self.assertEqual(near.applied.revision, self.revision + 1)
        other = self.other.scene(self.scene.name).closest(self.rays[:, :3])
        np.testing.assert_array_equal(near.distance, other.distance)
        np.testing.assert_array_equal(near.position, other.position)

    def test_arrays_in_shared_memory(self):
        memory = self.client.share_memory(8 << 20)
        self.assertTrue(memory.is_shared, memory.why_not_shared)
        origins, directions = memory.empty((60_000, 3), "f4"), memory.empty((60_000, 3), "f4")
        origins[:], directions[:] = self.rays[:, :3], self.rays[:, 3:]
        out = {"t": memory.empty(60_000), "node": memory.empty(60_000, "u8")}
        for step in range(3):
            hits = self.scene.cast(origins=origins, directions=directions, tmax=100, out=out,
                                   apply=updates.set_transforms([self.node], shifted(0.1 * step)))
            expected = self.expected(self.rays.astype("f4"), self.revision + 1 + step)
            np.testing.assert_array_equal(out["t"], expected.t)
            np.testing.assert_array_equal(out["node"], expected.node)
            self.assertTrue(np.shares_memory(hits.t, out["t"]))
        with self.assertRaises(sightline.ResourceExhausted):  # regions were given back, and the arrays stayed
            memory.empty(8 << 20, "u1")

    def test_a_batch_and_what_it_makes(self):
        with self.scene.batch() as batch:
            made = self.scene.add(brute.box(), name="made")
            hits = self.scene.cast(self.rays, apply=batch)
            self.assertEqual((made.id, batch.applied.revision), (hits.applied.nodes[0], self.revision + 1))
        self.assertEqual(self.scene.info().revision, self.revision + 1)

    def test_asyncio(self):
        async def cast():
            async with aio.connect(self.server.endpoint) as client:
                scene = client.scene(self.scene.name)
                return await scene.cast(self.rays, apply=updates.set_transforms([self.node], shifted(2)))

        hits = asyncio.run(cast())
        self.assertEqual(hits.revision, self.revision + 1)
        np.testing.assert_array_equal(hits.t, self.expected(self.rays, hits.revision).t)

    def test_what_is_refused_applies_nothing(self):
        many = np.tile(self.rays, (5, 1))  # more than a request has through shared memory
        move = updates.set_transforms([self.node], shifted(3))
        with self.assertRaisesRegex(ValueError, "300000 rays"):
            self.scene.cast(many, apply=move)
        with self.assertRaisesRegex(ValueError, "use_segments is off"):
            self.other.scene(self.scene.name).cast(self.rays, apply=move)
        with self.assertRaises(errors.NotFound):
            self.scene.cast(self.rays, apply=updates.set_transforms([99], shifted(3)))
        self.assertEqual(self.scene.info().revision, self.revision)
        self.assertEqual(self.scene.cast(self.rays, apply=move).revision, self.revision + 1)

    def test_a_broken_connection(self):
        proxy = Proxy(self.server.endpoint)
        self.addCleanup(proxy.close)
        few = self.rays[:12_000]
        with sightline.connect(proxy.endpoint) as client:
            scene = client.scene(self.scene.name)
            scene.cast(few)
            self.assertEqual(client.transport.kind, "segments", client.transport.reason)
            for step in range(3):
                proxy.cut()
                hits = scene.cast(few, apply=updates.set_transforms([self.node], shifted(0.1 * step)))
                self.assertEqual(hits.revision, self.revision + 1 + step, "applied once, by messages")
                np.testing.assert_array_equal(hits.t, self.expected(few, hits.revision).t)

    def test_answers_in_shared_memory_whose_connection_breaks(self):
        """The segment may end before the cast, with it or after it: answers are right, or there are none."""
        proxy = Proxy(self.server.endpoint)
        self.addCleanup(proxy.close)
        with sightline.connect(proxy.endpoint) as client:
            scene, memory = client.scene(self.scene.name), client.share_memory(4 << 20)
            self.assertTrue(memory.is_shared, memory.why_not_shared)
            out, move = {"t": memory.empty(len(self.rays))}, updates.set_transforms([self.node], shifted(1))
            scene.cast(self.rays, out=out)
            proxy.cut()
            try:
                hits = scene.cast(self.rays, out=out, apply=move)
                self.assertEqual(hits.revision, self.revision + 1)
                np.testing.assert_array_equal(out["t"], self.expected(self.rays, hits.revision).t)
            except errors.Unavailable:
                with self.assertRaisesRegex(errors.FailedPrecondition, "MEMORY_ABANDONED"):
                    scene.cast(self.rays, out=out, apply=move)
                self.assertFalse(memory.is_shared)


class RestartTest(unittest.TestCase):
    def test_a_server_that_is_started_again(self):
        rays = np.tile(brute.rays(300), (200, 1))  # more than a message holds
        with tempfile.TemporaryDirectory() as folder:
            socket_path, ready = pathlib.Path(folder, "socket"), pathlib.Path(folder, "port")

            def start():
                ready.unlink(missing_ok=True)
                server = subprocess.Popen(
                    [os.environ.get("SIGHTLINED", "sightlined"), "--listen", f"unix:{socket_path}", "--data-dir",
                     f"{folder}/data", "--port-file", str(ready)], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
                while not ready.exists() and server.poll() is None:
                    pass
                return server

            server = start()
            try:
                with sightline.connect(f"unix:{socket_path}") as client:
                    scene = client.create_scene("kept")
                    node = scene.add(brute.soup(), mobility="rigid")
                    memory = client.share_memory(4 << 20)
                    out = {"t": memory.empty(len(rays))}
                    for step in range(4):
                        hits = scene.cast(rays, apply=updates.set_transforms([node], shifted(step)),
                                          out=out if step % 2 else None, fields=("t",))
                        self.assertEqual(hits.revision, step + 2, "applied once")
                        np.testing.assert_array_equal(hits.t, scene.cast(rays, revision=hits.revision).t)
                        self.assertEqual(client.transport.kind, "segments", client.transport.reason)
                        server.kill()
                        server.wait()
                        server = start()
            finally:
                server.kill()
                server.wait()


if __name__ == "__main__":
    unittest.main()
