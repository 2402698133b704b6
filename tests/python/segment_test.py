"""Casts through memory that client and server share, compared with casts by messages."""

import asyncio
import contextlib
import gc
import os
import pathlib
import socket
import subprocess
import tempfile
import threading
import time
import unittest

import brute
import numpy as np
import sightline
from proxy import Proxy
from shared import ServerTest
from sightline import _segment, _segments, aio, errors
from sightline._endpoint import Endpoint
from sightline._segment_columns import LEAST_ROWS


def are_same(one, other):
    """Bit by bit, as NaN is no answer to compare."""
    return one.dtype == other.dtype and one.shape == other.shape and (
        (one == other).all() if one.dtype == object else one.tobytes() == other.tobytes())


class BlockListTest(unittest.TestCase):
    def test_the_lowest_free_block_is_taken(self):
        blocks = _segment.BlockList(10 * 64 + 7)
        self.assertEqual([blocks.take(size) for size in (1, 65, 0)], [0, 64, 192])
        blocks.release(0, 1)
        self.assertEqual([blocks.take(size) for size in (128, 64, 4 * 64 + 1, 4 * 64, 0)], [256, 0, None, 384, None])

    def test_free_neighbours_are_one_block(self):
        for order in ((0, 1, 2), (0, 2, 1), (1, 0, 2), (2, 1, 0)):
            blocks = _segment.BlockList(3 * 64)
            for _ in order:
                blocks.take(64)
            for number in order:
                blocks.release(64 * number, 64)
            self.assertEqual(blocks.take(3 * 64), 0)


class HandoverTest(unittest.TestCase):
    """What a client takes from the socket of a server."""

    def receive(self, files, size=4096):
        """`thread` is that of the server, and ends when the client has closed its connection."""
        listener = socket.socket(socket.AF_UNIX)
        listener.bind("")  # an abstract name that the system chooses
        listener.listen()

        def serve():
            caller, _ = listener.accept()
            caller.recv(32, socket.MSG_WAITALL)
            socket.send_fds(caller, [b"."], files)
            self.assertEqual(caller.recv(1), b"", "the client closes it")
            caller.close()
            listener.close()

        self.thread = threading.Thread(target=serve)
        self.thread.start()
        memory, process = _segment._receive(listener.getsockname()[1:], b"k" * 32, size, 60)
        if process is not None:
            os.close(process)
        return memory

    def memfd(self, size, seals):
        import fcntl

        file = os.memfd_create("segment", os.MFD_CLOEXEC | os.MFD_ALLOW_SEALING)
        self.addCleanup(os.close, file)
        os.ftruncate(file, size)
        fcntl.fcntl(file, fcntl.F_ADD_SEALS, seals)
        return file

    def test_sealed_memory_is_taken_and_no_other(self):
        sealed, small, open_file = self.memfd(4096, 2), self.memfd(4095, 2), self.memfd(4096, 0)
        memory = self.receive([sealed])
        memory[4095] = 42
        self.assertEqual(os.pread(sealed, 1, 4095), b"*")
        del memory
        self.thread.join()
        for files in ([small], [open_file], [], [sealed, sealed]):
            with self.assertRaises(errors.Unavailable):
                self.receive(files)
            self.thread.join()
        for name, key in ((b"", b"k" * 32), (b"n" * 108, b"k" * 32), (b"name", b"k")):
            with self.assertRaises(errors.Internal):
                _segment._receive(name, key, 4096, 60)
        with self.assertRaises(errors.Unavailable):
            _segment._receive(b"no process listens here", b"k" * 32, 4096, 60)


    def test_the_connection_stays_as_long_as_an_array(self):
        memory = self.receive([self.memfd(4096, 2)])
        array = np.frombuffer(memory, "u1")[4000:][::5]
        del memory
        gc.collect()
        self.assertTrue(self.thread.is_alive())
        self.assertEqual(array[-1], 0)
        del array
        gc.collect()
        self.thread.join()


class RefusalTest(unittest.TestCase):
    def test_one_server_on_this_machine(self):
        for endpoint in ("unix:/run/socket", "127.0.0.1:5", "localhost:5"):
            self.assertEqual(_segments.refusal_of(Endpoint(endpoint), True), "")
            self.assertNotEqual(_segments.refusal_of(Endpoint(endpoint), False), "")
        for endpoint in ("10.1.2.3:5", "server:5", "127.0.0.1:5,127.0.0.1:6"):
            self.assertNotEqual(_segments.refusal_of(Endpoint(endpoint), True), "")

    def test_ordinary_memory_behaves_alike(self):
        with sightline.connect("unix:/nowhere", use_segments=False) as client:
            self.assertEqual(client.transport.kind, "messages")
            memory = client.share_memory(4096)
            self.assertFalse(memory.is_shared)
            self.assertEqual(memory.why_not_shared, client.transport.reason)
            array = memory.empty((4, 128), "f8")
            self.assertEqual((array.shape, array.dtype, array.flags.c_contiguous), ((4, 128), np.dtype("f8"), True))
            view = array[1:3, 5]
            with self.assertRaisesRegex(errors.ResourceExhausted, "8 bytes"):
                memory.empty(1)
            del array
            gc.collect()
            with self.assertRaises(errors.ResourceExhausted):
                memory.empty(1)  # a view keeps it
            del view
            gc.collect()
            self.assertEqual(memory.empty(512).nbytes, 4096)
            self.assertEqual(memory.empty((3, 0)).shape, (3, 0))
            memory._segment.abandon()
            self.assertFalse(memory._segment.is_abandoned, "no server writes to it")
            for error, make in ((ValueError, lambda: memory.empty(1, object)), (ValueError, lambda: memory.empty((2, -1))),
                                (ValueError, lambda: client.share_memory(0)),
                                (errors.ResourceExhausted, lambda: client.share_memory(1 << 62))):
                with self.assertRaises(error):
                    make()


class SegmentTest(ServerTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.by_messages = sightline.connect(cls.server.endpoint, use_segments=False)
        cls.addClassCleanup(cls.by_messages.close)

    def setUp(self):
        self.scene = self.scene_of(brute.soup())
        self.other = self.by_messages.scene(self.scene.name)
        self.rays = np.tile(brute.rays(300), (200, 1))  # 60,000
        self.rays[7::1000, 3:] = 0  # invalid

    def compare(self, found, expected, fields=None, client=None):
        self.assertEqual((found.shape, found.revision), (expected.shape, expected.revision))
        for name in fields or expected._columns:
            if name != "work":  # counts what was done, which depends on what is cast together
                self.assertTrue(are_same(found._columns[name], expected._columns[name]), name)
        for name in ("rays", "hits", "invalid", "hits_found"):
            self.assertEqual(found.stats.get(name), expected.stats.get(name))
        transport = (client or self.client).transport
        self.assertEqual(transport.kind, "segments", transport.reason)

    def test_few_rays_are_sent(self):
        client = sightline.connect(self.server.endpoint)
        self.addCleanup(client.close)
        client.scene(self.scene.name).cast(self.rays[:LEAST_ROWS - 1])
        self.assertEqual(client.transport, ("messages", "no cast has needed shared memory"))
        client.scene(self.scene.name).cast(self.rays[:LEAST_ROWS])
        self.assertEqual(client.transport.kind, "segments", client.transport.reason)

    def test_kinds_and_fields(self):
        bounded = np.hstack([self.rays, np.full((len(self.rays), 1), 0.2), np.full((len(self.rays), 1), 0.9)])
        for rays in (self.rays, self.rays.astype("f4"), bounded, self.rays.reshape(20, 3000, 6)):
            for options in ({}, {"fields": ("t",)}, {"fields": ("node", "position", "name", "hit", "work")},
                            {"kind": "any"}, {"kind": "count", "cull": "back"}, {"time_budget": 3600}):
                with self.subTest(shape=rays.shape, dtype=rays.dtype, **options):
                    self.compare(self.scene.cast(rays, **options), self.other.cast(rays, **options))
        columns = {"origins": self.rays[:, :3], "directions": self.rays[:, 3:],
                   "masks": np.arange(len(self.rays), dtype="u4")}
        self.compare(self.scene.cast(**columns), self.other.cast(**columns))
        hits = self.scene.cast(self.rays, kind="all")
        self.assertTrue(are_same(hits.t, self.other.cast(self.rays, kind="all").t))

    def test_points(self):
        for points in (self.rays[:, :3], self.rays[:, :3].astype("f4")):
            for options in ({}, {"max_distance": 0.3}, {"fields": ("signed", "inside", "votes"), "side_rays": 3},
                            {"kind": "count", "max_distance": 0.3}):
                with self.subTest(dtype=points.dtype, **options):
                    self.compare(self.scene.closest(points, **options), self.other.closest(points, **options))
            np.testing.assert_array_equal(self.scene.contains(points), self.other.contains(points))
        grid = sightline.PointGrid([0, 0, 0], [0.01, 0, 0], [0, 0.01, 0], 200, 300)
        self.compare(self.scene.closest(grid), self.other.closest(grid))

    def test_pictures(self):
        self.compare(self.scene.render((300, 200)).hits, self.other.render((300, 200)).hits)

    def in_memory(self, memory, array):
        copy = memory.empty(array.shape, array.dtype)
        copy[...] = array
        return copy

    def test_arrays_in_shared_memory(self):
        expected = self.other.cast(self.rays, fields=("t", "node", "normal"))
        memory = self.client.share_memory(16 << 20)
        self.assertTrue(memory.is_shared, memory.why_not_shared)
        origins, directions = (self.in_memory(memory, part) for part in (self.rays[:, :3], self.rays[:, 3:]))
        count = len(self.rays)
        out = {"t": memory.empty(count), "node": memory.empty(count, "u8")}
        for given in ({"origins": origins, "directions": directions}, {"origins": origins, "directions": self.rays[:, 3:]},
                      {"rays": self.rays}):
            out["t"][:], out["node"][:] = 0, 0
            found = self.scene.cast(**given, out=out, fields=("t", "node", "normal"))
            self.compare(found, expected)
            self.assertTrue(np.shares_memory(found.t, out["t"]))
        self.assertTrue((origins == self.rays[:, :3]).all())

    def test_answers_over_their_own_rays(self):
        expected = self.other.cast(self.rays, fields=("position",)).position
        memory = self.client.share_memory(8 << 20)
        origins, directions = (self.in_memory(memory, part) for part in (self.rays[:, :3], self.rays[:, 3:]))
        found = self.scene.cast(origins=origins, directions=directions, out={"position": origins})
        self.assertTrue(are_same(origins, expected))
        self.assertTrue(np.shares_memory(found.position, origins))

    def test_out(self):
        for count in (300, len(self.rays)):
            for scene in (self.scene, self.other):
                t, hit = np.empty(count), np.empty(count, "u1")
                found = scene.cast(self.rays[:count], out={"t": t, "hit": hit})
                self.assertEqual(set(found._columns), {"t", "hit"})
                self.assertTrue(are_same(t, self.other.cast(self.rays[:count]).t))
                self.assertTrue(np.shares_memory(found.t, t))
        near = np.empty((3, 100))
        self.scene.closest(self.rays[:300, :3].reshape(3, 100, 3), out={"distance": near})
        self.assertTrue(are_same(near, self.other.closest(self.rays[:300, :3].reshape(3, 100, 3)).distance))
        few, frozen = self.rays[:300], np.empty(300)
        frozen.flags.writeable = False
        for error, text, options in (
                (ValueError, "no array", {"out": {"t": np.empty(300)}, "fields": ("node",)}),
                (ValueError, "no field", {"out": {"distance": np.empty(300)}}),
                (ValueError, "no array", {"out": {"name": np.empty(300, object)}}),
                (TypeError, "float64, not float32", {"out": {"t": np.empty(300, "f4")}}),
                (TypeError, "float64, not <class 'list'>", {"out": {"t": [0.0] * 300}}),
                (ValueError, r"shape \(300,\), not \(299,\)", {"out": {"t": np.empty(299)}}),
                (ValueError, "contiguous", {"out": {"t": np.empty(600)[::2]}}),
                (ValueError, "writable", {"out": {"t": frozen}}),
                (ValueError, "'all' has no out", {"out": {"t": np.empty(300)}, "kind": "all"})):
            with self.subTest(text), self.assertRaisesRegex(error, text):
                self.scene.cast(few, **options)
        with self.assertRaisesRegex(ValueError, "iterator has no out"):
            next(self.scene.cast(iter([few]), out={"t": np.empty(300)}))

    def test_many_threads(self):
        expected = self.other.cast(self.rays)
        failed = []

        def cast():
            for _ in range(3):
                if not are_same(self.scene.cast(self.rays).t, expected.t):
                    failed.append(1)

        threads = [threading.Thread(target=cast) for _ in range(8)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual(failed, [])

    def test_asyncio(self):
        expected = self.other.cast(self.rays)

        async def cast():
            async with aio.connect(self.server.endpoint) as client:
                memory = await client.share_memory(4 << 20)
                t = memory.empty(len(self.rays))
                hits = await client.scene(self.scene.name).cast(self.rays, out={"t": t})
                self.assertEqual(client.transport.kind, "segments")
                return hits

        self.assertTrue(are_same(asyncio.run(cast()).t, expected.t))

    def test_a_broken_connection(self):
        proxy = Proxy(self.server.endpoint)
        self.addCleanup(proxy.close)
        with sightline.connect(proxy.endpoint) as client:
            scene = client.scene(self.scene.name)
            expected = scene.cast(self.rays)
            self.assertEqual(client.transport.kind, "segments", client.transport.reason)
            for _ in range(3):
                proxy.cut()
                self.assertTrue(are_same(scene.cast(self.rays).t, expected.t), "by messages")
            # A failure to open one is followed by a pause of seconds, in which casts go by messages.
            for _ in range(600):
                found = scene.cast(self.rays)
                if client.transport.kind == "segments":
                    break
                time.sleep(0.1)
            self.compare(found, expected, client=client)

    def test_no_segment_left(self):
        with contextlib.ExitStack() as clients:  # a connection has a part of all segments
            taken, before = [], -2
            while len(taken) > before + 1:
                before = len(taken)
                client = clients.enter_context(sightline.connect(self.server.endpoint))
                taken.append(client.share_memory(4096))
                while taken[-1].is_shared and len(taken) < 10_000:
                    taken.append(client.share_memory(4096))
                self.assertFalse(taken[-1].is_shared)
                self.assertNotEqual(taken[-1].why_not_shared, "")
            with sightline.connect(self.server.endpoint) as other:
                self.assertTrue(are_same(other.scene(self.scene.name).cast(self.rays).t, self.other.cast(self.rays).t))
                self.assertEqual(other.transport.kind, "messages")
            del taken


class RestartTest(unittest.TestCase):
    def test_a_server_that_is_started_again(self):
        rays = np.tile(brute.rays(300), (100, 1))
        with tempfile.TemporaryDirectory() as folder:
            socket_path = pathlib.Path(folder, "socket")

            def start():
                ready = pathlib.Path(folder, "port")
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
                    scene = client.import_arrays("kept", *brute.soup())
                    expected = scene.cast(rays)
                    memory = client.share_memory(4 << 20)
                    self.assertTrue(memory.is_shared, memory.why_not_shared)
                    out = {"t": memory.empty(len(rays))}
                    scene.cast(rays, out=out)
                    server.kill()
                    server.wait()
                    server = start()
                    for _ in range(2):
                        out["t"][:] = 0
                        self.assertTrue(are_same(scene.cast(rays, out=out).t, expected.t))
                        self.assertTrue(are_same(scene.cast(rays).t, expected.t))
                    self.assertFalse(memory.is_shared)
                    self.assertEqual(client.transport.kind, "segments", client.transport.reason)
            finally:
                server.kill()
                server.wait()


if __name__ == "__main__":
    unittest.main()
