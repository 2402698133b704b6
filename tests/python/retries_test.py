"""Calls that the server refuses for now are repeated when it says, as long as that is safe and there is time."""

import asyncio
import os
import pathlib
import subprocess
import tempfile
import threading
import unittest
import unittest.mock

import brute
import numpy as np
import sightline
import sightline.aio
from refusing import Refusing, Status
from shared import ServerTest

CLI = pathlib.Path(os.environ.get("SIGHTLINED", "")).parents[1] / "client" / "sightline"


class RetriesTest(ServerTest):
    def setUp(self):
        self.refusing = Refusing(self.server.endpoint)
        self.addCleanup(self.refusing.close)
        self.remote = sightline.connect(self.refusing.endpoint)
        self.addCleanup(self.remote.close)
        self.name = self.id().rpartition(".")[2].replace("_", "-")
        self.mesh = brute.soup()
        self.client.import_arrays(self.name, *self.mesh)
        self.scene = self.remote.scene(self.name)
        self.rays = brute.rays(300)
        self.expected = self.client.scene(self.name).cast(self.rays)

    def refuse(self, **refusals):
        self.refusing.refusals = refusals

    def test_casts(self):
        for kind, name in (("closest", "CastRays"), ("count", "CastRays"), ("all", "StreamCastRays")):
            self.refuse(**{name: 3})
            hits = self.scene.cast(self.rays, kind=kind)
            np.testing.assert_array_equal(hits.hit, self.expected.hit)
        self.assertEqual(self.refusing.calls["CastRays"], 8)
        self.refuse(StreamCastRays=4)
        parts = list(self.scene.cast(iter(np.array_split(self.rays, 3))))
        np.testing.assert_array_equal(np.concatenate([part.t for part in parts]), self.expected.t)

    def test_casts_with_changes_have_one_effect(self):
        move = sightline.updates.set_transforms([1], np.eye(4)[None])
        self.refuse(CastRays=3, QueryPoints=2)
        hits = self.scene.cast(self.rays, apply=move)
        np.testing.assert_array_equal(hits.hit, self.expected.hit)
        self.assertEqual((hits.applied.revision, self.scene.closest(self.rays[:, :3], apply=move).applied.revision), (2, 3))
        self.assertEqual((self.refusing.calls["CastRays"], self.refusing.calls["QueryPoints"]), (4, 3))
        self.assertEqual(self.scene.info().revision, 3)

    def test_closest_points(self):
        points = self.rays[:, :3]
        expected = self.client.scene(self.name).closest(points, 0.5).hit
        for kind, name in (("closest", "QueryPoints"), ("count", "QueryPoints"), ("all", "StreamQueryPoints")):
            self.refuse(**{name: 3})
            np.testing.assert_array_equal(self.scene.closest(points, 0.5, kind=kind).hit, expected)
        self.assertEqual((self.refusing.calls["QueryPoints"], self.refusing.calls["StreamQueryPoints"]), (8, 4))

    def test_changes_have_one_effect(self):
        self.refuse(ApplyUpdates=2, FindMissingBlobs=1, GetUploadStatus=1, UploadBlob=2, PutScene=2)
        node = self.scene.add(brute.soup(seed=7), name="new")
        self.assertEqual((self.scene.info().revision, node.id), (2, 2))
        made = self.remote.import_arrays(self.name + "-2", *brute.soup(seed=8))
        self.assertEqual(made.info().revision, 1)
        self.assertEqual({name for name, left in self.refusing.refusals.items() if left}, set())

    def test_what_may_have_had_an_effect_is_not_repeated(self):
        self.refuse(CreateScene=1, DeleteScene=1)
        for call in (self.remote.create_scene, self.remote.delete_scene):
            with self.assertRaises(sightline.ResourceExhausted) as raised:
                call(self.name)
            self.assertEqual(raised.exception.retry_delay, 0.001)

    def test_streams_of_updates_and_watches(self):
        self.refuse(StreamUpdates=3, WatchScene=2)
        with self.scene.update_stream("producer") as stream:
            for _ in range(5):
                stream.set_transforms([1], np.eye(4)[None])
        changes = self.scene.watch(1)
        self.assertEqual([next(changes).revision for _ in range(5)], [2, 3, 4, 5, 6])
        changes.close()

    def test_what_does_not_pass_is_raised_at_once(self):
        for status in (Status("MESH_TOO_LARGE", None), Status("TOO_MANY_RAYS", None)):
            self.refusing.refusal = status
            self.refuse(CastRays=1, StreamCastRays=1)
            for kind in ("closest", "all"):
                with self.assertRaises(sightline.ResourceExhausted) as raised:
                    self.scene.cast(self.rays, kind=kind)
                self.assertIsNone(raised.exception.retry_delay)
        self.assertEqual((self.refusing.calls["CastRays"], self.refusing.calls["StreamCastRays"]), (2, 2))

    def test_a_deadline_is_not_slept_through(self):
        self.refusing.refusal = Status("QUEUE_FULL", 30.0)
        self.refuse(CastRays=9, StreamCastRays=9)
        for kind in ("closest", "all"):
            with self.assertRaises(sightline.ResourceExhausted) as raised:
                self.scene.cast(self.rays, kind=kind, timeout=20)
            self.assertEqual((raised.exception.reason, raised.exception.retry_delay), ("QUEUE_FULL", 30.0))
        self.assertEqual((self.refusing.calls["CastRays"], self.refusing.calls["StreamCastRays"]), (1, 1))

    def test_retries_ends(self):
        self.refusing.refusal = Status("QUEUE_FULL", 61.0)
        self.refuse(CastRays=9)
        with self.assertRaises(sightline.ResourceExhausted):
            self.scene.cast(self.rays)
        self.assertEqual(self.refusing.calls["CastRays"], 1)

    def test_cancelling_a_task_ends_its_pause(self):
        async def cancelled():
            async with sightline.aio.connect(self.refusing.endpoint) as client:
                task = asyncio.create_task(client.scene(self.name).cast(self.rays))
                await asyncio.get_running_loop().run_in_executor(None, self.refusing.refused.wait)
                task.cancel()
                with self.assertRaises(asyncio.CancelledError):
                    await task
                threads = [thread for thread in threading.enumerate() if thread.name.startswith("sightline_")]
            for thread in threads:
                thread.join(20)  # the pause is 40 seconds
                self.assertFalse(thread.is_alive())

        self.refusing.refusal = Status("QUEUE_FULL", 40.0)
        self.refuse(CastRays=1)
        asyncio.run(cancelled())
        self.assertEqual(self.refusing.calls["CastRays"], 1)


class BookingTest(unittest.TestCase):
    """A server with little room: a connection may book 2 MiB for lists of hits."""

    def setUp(self):
        server = sightline.serve(options=["--max-bytes-queued", str(8 << 20)])
        self.addCleanup(server.close)
        self.client = server.client
        waits = unittest.mock.patch("sightline._retries.sleep", side_effect=AssertionError("it was refused"))
        waits.start()
        self.addCleanup(waits.stop)

    def test_few_hits_of_many_rays_need_little(self):
        scene = self.client.import_arrays("soup", *brute.soup())
        rays = np.tile(brute.rays(500), (4, 1))
        np.testing.assert_array_equal(scene.cast(rays, kind="all").count, scene.cast(rays, kind="count").count)

    def test_many_hits_come_although_there_is_no_room_to_list_more_at_a_time(self):
        heights = np.arange(1, 201)
        corners = np.tile([[-1.0, -1.0, 0.0], [3.0, -1.0, 0.0], [-1.0, 3.0, 0.0]], (200, 1))
        corners[:, 2] = np.repeat(heights, 3)
        scene = self.client.import_arrays("layers", corners, np.arange(600).reshape(200, 3))
        rays = np.tile([0.1, 0.2, 0.0, 0.0, 0.0, 1.0], (1000, 1))
        rays[::3, 0] = 50
        hits = scene.cast(rays, kind="all")
        self.assertEqual(hits.count.tolist(), np.where(np.arange(1000) % 3 == 0, 0, 200).tolist())
        np.testing.assert_array_equal(hits.t.reshape(-1, 200), np.tile(heights, (len(hits) // 200, 1)))


@unittest.skipUnless(CLI.exists(), "needs the command")
class CommandTest(ServerTest):
    def test_the_command_comes_back_too(self):
        refusing = Refusing(self.server.endpoint)
        self.addCleanup(refusing.close)
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder) / "box.obj"
            vertices, faces = brute.box()
            file.write_text("".join("v %g %g %g\n" % tuple(v) for v in vertices)
                            + "".join("f %d %d %d\n" % tuple(f + 1) for f in faces))
            updates = pathlib.Path(folder) / "ops.ndjson"
            updates.write_text('{"put_node": {"node": -1}}\n')
            ray = "0.3 0.4 5 0 0 -1\n"
            for method, words, given in (("UploadBlob", ("scene", "import", "refused", str(file)), None),
                                         ("PutScene", ("scene", "import", "refused", str(file), "--replace"), None),
                                         ("ApplyUpdates", ("update", "refused", "--file", str(updates)), None),
                                         ("StreamCastRays", ("cast", "refused", "-q"), ray),
                                         ("StreamCastRays", ("cast", "refused", "--kind", "all", "-q"), ray),
                                         ("Prefetch", ("prefetch", "refused"), None)):
                with self.subTest(method=method, words=words):
                    refusing.refusals = {method: 2}
                    done = subprocess.run([CLI, "--endpoint", refusing.endpoint, *words], input=given, text=True,
                                          capture_output=True, check=False)
                    self.assertEqual(done.returncode, 0, done.stderr)


class ManyThreadsTest(ServerTest):
    def test_all_kinds_from_many_threads_of_one_client(self):
        mesh, rays = brute.soup(400), np.tile(brute.rays(1000), (2, 1))
        scene = self.scene_of(mesh)
        expected = {kind: scene.cast(rays, kind=kind) for kind in ("closest", "any", "count", "all")}
        failed, together = [], threading.Barrier(64)

        def cast(kind):
            together.wait()
            try:
                for _ in range(2):
                    np.testing.assert_array_equal(scene.cast(rays, kind=kind).hit, expected[kind].hit)
            except Exception as error:
                failed.append(error)

        threads = [threading.Thread(target=cast, args=(kind,)) for kind in expected for _ in range(16)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual(failed, [])

    def test_uploads_from_many_threads(self):
        scene = self.client.create_scene("uploads")
        threads = [threading.Thread(target=scene.add, args=(brute.soup(20000, seed),)) for seed in range(16)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual(scene.info().meshes, 16)
