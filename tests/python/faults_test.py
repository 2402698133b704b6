"""Broken connections, servers that are gone, deadlines, interrupts."""

import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import threading
import time
import unittest

import brute
import numpy as np
import sightline
from proxy import Proxy
from shared import ServerTest


class BrokenConnectionTest(ServerTest):
    def setUp(self):
        self.proxy = Proxy(self.server.endpoint)
        self.addCleanup(self.proxy.close)
        self.remote = sightline.connect(self.proxy.endpoint, use_segments=False)
        self.addCleanup(self.remote.close)
        self.scene = self.remote.import_arrays(self.id().rpartition(".")[2].lower().replace("_", "-"), *brute.soup(),
                                               replace=True)

    def test_a_cast_goes_on_at_its_revision(self):
        rays = np.tile(brute.rays(300), (300, 1))
        expected = self.scene.cast(rays)
        source = iter(np.array_split(rays, 30))
        hits = self.scene.cast(source)
        found = [next(hits)]
        self.client.scene(self.scene.name).delete_node(1)  # a later revision, which must not answer
        for part in hits:
            if len(found) in (5, 15):
                self.proxy.cut()
            found.append(part)
        np.testing.assert_array_equal(np.concatenate([part.t for part in found]), expected.t)
        self.assertEqual({part.revision for part in found}, {1})

    def test_a_cast_of_an_array_and_of_all_hits(self):
        rays = np.tile(brute.rays(300), (100, 1))
        for kind in ("closest", "all"):
            expected = self.scene.cast(rays, kind=kind, fields=("t",))
            self.proxy.cut_after(300_000)
            again = self.scene.cast(rays, kind=kind, fields=("t",))
            np.testing.assert_array_equal(again.t, expected.t)

    def test_closest_points_go_on(self):
        points = np.tile(brute.rays(300)[:, :3], (300, 1))
        for kind in ("closest", "all"):
            expected = self.scene.closest(points, 0.3, kind=kind, fields=("distance",))
            self.proxy.cut_after(300_000)
            again = self.scene.closest(points, 0.3, kind=kind, fields=("distance",))
            np.testing.assert_array_equal(again.distance, expected.distance)
        self.proxy.cut()
        small = self.scene.closest(points[:300], 0.3)
        self.client.scene(self.scene.name).delete_node(1)
        self.proxy.cut()
        np.testing.assert_array_equal(self.scene.closest(points[:300], 0.3, revision=1).distance, small.distance)

    def test_small_casts_are_repeated(self):
        rays = brute.rays(300)
        expected = self.scene.cast(rays)
        for _ in range(3):
            self.proxy.cut()
            np.testing.assert_array_equal(self.scene.cast(rays).t, expected.t)

    def test_changes_that_come_with_a_cast_are_applied_once(self):
        rays = brute.rays(300)
        expected = self.scene.cast(rays)
        for turn, cut_after in enumerate((0, 5_000, 20_000, 25_000, 30_000)):  # the request has 14,400 bytes
            if cut_after:
                self.proxy.cut_after(cut_after)
            else:
                self.proxy.cut()
            hits = self.scene.cast(rays, apply=[sightline.updates.put_node(-1, 0, "", None, "", None, None)])
            np.testing.assert_array_equal(hits.t, expected.t)
            self.assertEqual(hits.applied.revision, turn + 2)
        self.assertEqual(self.scene.info().nodes, 6)

    def test_an_update_stream_applies_each_batch_once(self):
        with self.scene.update_stream("producer") as stream:
            for x in range(200):
                if x % 40 == 20:
                    self.proxy.cut()
                stream.send([sightline.updates.put_node(-1, 0, f"{x}", None, "", None, None)])
            stream.flush()
        self.assertEqual(self.scene.info().nodes, 201)
        self.assertEqual([node.name for node in self.scene.nodes(range(2, 202))], [f"{x}" for x in range(200)])

    def test_a_watch_goes_on(self):
        changes = self.scene.watch(0)
        for revision in range(1, 10):
            self.assertEqual(next(changes).revision, revision)
            self.proxy.cut()
            self.client.scene(self.scene.name).add()
        changes.close()

    def test_an_upload_goes_on(self):
        mesh = brute.soup(100_000, seed=5)
        self.proxy.cut_after(2_000_000)
        node = self.scene.add(mesh)
        self.assertEqual(self.scene.nodes([node])[0].mesh_digest, sightline.meshes.as_mesh(mesh).digest())


class FaultTest(unittest.TestCase):
    def test_nothing_listens(self):
        client = sightline.connect("127.0.0.1:1", timeout=20)
        for call in (client.server_info, client.scenes, lambda: client.scene("s").cast([[0] * 6])):
            with self.assertRaises(ConnectionError) as raised:
                call()
            self.assertIsInstance(raised.exception, sightline.Unavailable)

    def test_a_server_that_does_not_answer_meets_the_deadline(self):
        with sightline.serve() as server:
            scene = server.client.import_arrays("s", *brute.box())
            scene.cast([[0] * 6])
            process = self.server_of(server)
            os.kill(process, signal.SIGSTOP)
            while ") T " not in pathlib.Path(f"/proc/{process}/stat").read_text():
                time.sleep(0.01)
            try:
                start = time.monotonic()
                for rays in (np.zeros((5, 6)), np.zeros((50000, 6))):
                    with self.assertRaises(TimeoutError):
                        scene.cast(rays, timeout=0.3)
                self.assertLess(time.monotonic() - start, 20)
            finally:
                os.kill(process, signal.SIGCONT)

    def server_of(self, server):
        """The process of a private server: the child of its guard that is no shell."""
        for status in pathlib.Path("/proc").glob("[0-9]*/cmdline"):
            try:
                words = status.read_bytes().split(b"\0")
            except OSError:
                continue
            if words[0].endswith(b"sightlined") and server.endpoint.encode() in words:
                return int(status.parent.name)
        self.fail("the server is not there")

    def test_options_of_connections(self):
        for options in ({"tls_cert": "a"}, {"tls_cert": "a", "tls_key": "b"}, {"token": "not visible"}):
            with self.subTest(options), self.assertRaises(ValueError):
                sightline.connect("127.0.0.1:1", **options)
        with tempfile.NamedTemporaryFile() as file:
            for token in (b"a b", b"a\nb", "\u00e4".encode(), "\u00e4".encode("latin-1"), b"a\0"):
                pathlib.Path(file.name).write_bytes(token)
                with self.subTest(token), self.assertRaisesRegex(ValueError, "visible ASCII"):
                    sightline.connect("127.0.0.1:1", token_file=file.name)
        for endpoint in ("host", ":1", "host:x", "unix:", "host:99999", "host:1,", "host:1,other"):
            with self.subTest(endpoint), self.assertRaises(ValueError):
                sightline.connect(endpoint)
        with self.assertRaises(sightline.Unauthenticated) as raised:
            sightline.connect("example.org:1", token="secret")
        self.assertEqual(raised.exception.reason, "TOKEN_IN_PLAINTEXT")
        with self.assertRaises(FileNotFoundError):
            sightline.connect("127.0.0.1:1", tls_ca="/none")

    def replica(self, folder, z):
        """A server on a port, its address, and a triangle at this z in its scene "turns"."""
        file = pathlib.Path(folder) / str(z)
        process = subprocess.Popen([os.environ["SIGHTLINED"], "--listen", "127.0.0.1:0", "--port-file", str(file)],
                                   stderr=subprocess.DEVNULL)
        self.addCleanup(process.wait)
        self.addCleanup(process.kill)
        while not file.exists():
            self.assertIsNone(process.poll())
            time.sleep(0.01)
        address = f"127.0.0.1:{file.read_text().strip()}"
        with sightline.connect(address) as client:
            client.import_arrays("turns", [[0, 0, z], [1, 0, z], [0, 1, z]], [[0, 1, 2]])
        return process, address

    def test_replicas_take_turns_and_one_may_go(self):
        with tempfile.TemporaryDirectory() as folder:
            near, near_address = self.replica(folder, 1.0)
            _, far_address = self.replica(folder, 2.0)
        client = sightline.connect(f"{near_address},{far_address}")
        self.addCleanup(client.close)
        scene, ray, seen = client.scene("turns"), [[0.2, 0.2, 0, 0, 0, 1]], set()
        for _ in range(1000):
            seen.add(float(scene.cast(ray).t[0]))
            if len(seen) == 2:
                break
        self.assertEqual(seen, {1.0, 2.0})
        near.kill()
        near.wait()
        self.assertEqual({float(scene.cast(ray).t[0]) for _ in range(20)}, {2.0})

    def test_serving_fails_with_what_the_server_printed(self):
        with self.assertRaisesRegex(sightline.Unavailable, "no-such-flag"):
            sightline.serve(options=["--no-such-flag"])
        with self.assertRaises(FileNotFoundError):
            sightline.serve("/none/sightlined")

    def run_python(self, text):
        return subprocess.Popen([sys.executable, "-c", text], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)

    def test_the_server_ends_with_its_process(self):
        for ending in (signal.SIGKILL, signal.SIGTERM, None):
            with self.run_python("import sightline\ns = sightline.serve()\nprint(s.endpoint, flush=True)\ninput()") as own:
                path = own.stdout.readline().strip()[len("unix:"):]
                self.assertTrue(os.path.exists(path))
                own.communicate("\n") if ending is None else own.send_signal(ending)
                own.wait()
            end = time.monotonic() + 20
            while os.path.exists(path) and time.monotonic() < end:
                time.sleep(0.05)
            self.assertFalse(os.path.exists(path))

    def test_interrupts_end_casts(self):
        """Wherever they come: the connection goes on."""
        rounds = 20
        text = """
import signal, sys; sys.path.insert(0, {here!r})
import brute, numpy, sightline
signal.signal(signal.SIGINT, signal.default_int_handler)  # jobs in the background of a shell begin with it ignored
with sightline.serve() as server:
    scene = server.client.import_arrays("s", *brute.soup())
    def source():
        while True:
            yield brute.rays(300)
    for _ in range({rounds}):
        try:
            for i, _ in enumerate(scene.cast(source())):
                if i == 3:
                    print("casting", flush=True)
        except KeyboardInterrupt:
            print("interrupted", server.client.scene("s").cast(brute.rays(3)).shape, flush=True)
""".format(here=os.path.dirname(os.path.abspath(__file__)), rounds=rounds)
        with self.run_python(text) as own:
            ended = threading.Timer(60, own.kill)
            ended.start()
            for _ in range(rounds):
                self.assertEqual(own.stdout.readline(), "casting\n")
                own.send_signal(signal.SIGINT)
                self.assertEqual(own.stdout.readline(), "interrupted (3,)\n")
            own.wait()
            ended.cancel()
        self.assertEqual(own.returncode, 0)
