"""What others do to a server, each a function of an Attacker that goes on until it is killed. Refusals are what they earn."""

import base64
import hashlib
import itertools
import os
import pathlib
import queue
import random
import socket
import struct
import sys
import threading
import time
import urllib.request

import grpc
import numpy as np
from sightline import _proto

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "server/floods"))
from frames import FLOODS, GREETING, Peer  # noqa: E402

_MIB = 1 << 20
_LARGEST = [("grpc.max_receive_message_length", 64 * _MIB), ("grpc.use_local_subchannel_pool", 1)]


class Attacker:
    """`scene` is one of its own, a sheet of triangles from 0 to 100 with `mesh` as its digest; `token` may write there."""

    def __init__(self, port, admin_port, token, budget, scenes):
        self.port, self.admin_port, self.budget = port, admin_port, budget
        self.scenes = scenes
        self._metadata = (("authorization", f"Bearer {token}"),)
        self._random = random.Random(os.getpid())
        self.rays = np.random.default_rng(os.getpid())

    def connect(self):
        """Calls by name: connect().CastRays(request)."""
        channel = grpc.insecure_channel(f"127.0.0.1:{self.port}", [*_LARGEST, ("attack", self._random.getrandbits(30))])
        return Calls(channel, self._metadata)

    def name(self, prefix):
        return f"{self.scenes}{prefix}{self._random.getrandbits(40)}"

    def make_scene(self):
        calls = self.connect()
        while True:
            try:
                self.mesh = upload(calls, sheet(100))
                self.scene = self.name("scene")
                calls.CreateScene(scene={"name": self.scene})
                calls.ApplyUpdates(scene=self.scene, updates=[put(-1, self.mesh)])
                return
            except grpc.RpcError:
                time.sleep(0.1)

    def cast_request(self, rays, scene="", **more):
        origins = self.rays.uniform(0, 100, (rays, 3))
        directions = self.rays.normal(size=(rays, 3))
        return _proto.CastRaysRequest(scene=scene or self.scene, **more, rays={
            "float64": True, "origins": origins.tobytes(), "directions": directions.tobytes(), "count": rays})


class Calls:
    def __init__(self, channel, metadata):
        self.channel = channel
        for name, method in _proto.methods.items():
            kind = f"{'stream' if method.client_streaming else 'unary'}_{'stream' if method.server_streaming else 'unary'}"
            call = getattr(channel, kind)(method.path, method.request.SerializeToString, method.response.FromString)
            setattr(self, name, self._bound(call, method, metadata))

    @staticmethod
    def _bound(call, method, metadata):
        def run(request=None, timeout=60, future=False, **fields):
            if request is None:
                request = method.request(**fields)
            return (call.future if future else call)(request, timeout=timeout, metadata=metadata)
        return run


# ---- what is sent

def sheet(size, z=0.0):
    """A mesh of 2 * size * size triangles, as a blob."""
    x, y = np.meshgrid(np.arange(size + 1), np.arange(size + 1), indexing="ij")
    vertices = np.stack([x.ravel(), y.ravel(), np.full(x.size, z)], axis=1).astype("<f4")
    first = (np.arange(size)[:, None] * (size + 1) + np.arange(size)).ravel()
    faces = np.concatenate([np.stack([first, first + 1, first + size + 1], axis=1),
                            np.stack([first + 1, first + size + 2, first + size + 1], axis=1)]).astype("<u4")
    return b"SLM1" + struct.pack("<IQQ", 0, len(vertices), len(faces)) + vertices.tobytes() + faces.tobytes()


def upload(calls, blob):
    digest = f"sha256:{hashlib.sha256(blob).hexdigest()}/{len(blob)}"
    parts = range(0, len(blob), _MIB)
    calls.UploadBlob(iter([_proto.UploadBlobRequest(digest="" if at else digest, offset=at, data=blob[at:at + _MIB],
                                                    finish=at == parts[-1]) for at in parts]))
    return digest


def put(node, mesh, x=0.0, mobility=0):
    matrix = [1, 0, 0, x, 0, 1, 0, 0, 0, 0, 1, 0]
    return {"put_node": {"node": node, "mesh_digest": mesh, "transform": {"matrix": matrix}, "mobility": mobility}}


def move(nodes, z):
    rows = np.zeros((nodes, 3, 4))
    rows[:, :, :3] = np.eye(3)
    rows[:, 2, 3] = z
    return {"set_transforms": {"nodes": list(range(1, nodes + 1)), "matrices": rows.tobytes()}}


def repeat(step, *arguments):
    while True:
        try:
            step(*arguments)
        except (grpc.RpcError, OSError):
            time.sleep(0.01)


def in_threads(count, step, *arguments):
    """Each with what it needs from `arguments`, which are called."""
    threads = [threading.Thread(target=repeat, args=(step, *[make() for make in arguments]), daemon=True) for _ in range(count)]
    for thread in threads:
        thread.start()
    threading.Event().wait()


# ---- without a token

def floods(it):
    """All kinds of frames, one after the other; a connection that is ended is replaced by the next."""
    for flood in itertools.cycle(FLOODS.values()):
        peer, until = Peer(it.port), time.monotonic() + 2
        going = peer.send(GREETING)
        for piece in flood():
            if not going or time.monotonic() > until:
                break
            going = peer.send(piece)
        peer.close()


def connections(it):
    """As many as one address can have, half of them silent, and then one new one after the other."""
    held = []
    while True:
        try:
            plug = socket.socket()
            plug.bind(("127.0.0.2", 0))
            plug.settimeout(1)
            plug.connect(("127.0.0.1", it.port))
            plug.sendall(GREETING if len(held) % 2 else b"P")
            held.append(plug)
        except OSError:
            time.sleep(0.01)
        if len(held) > 1500:
            held.pop(0).close()


def page_sockets(it):
    """Calls through the page's socket whose answers nobody reads."""
    def step():
        with socket.socket() as plug:
            plug.bind(("127.0.0.2", 0))
            plug.settimeout(5)
            plug.connect(("127.0.0.1", it.admin_port))
            key = base64.b64encode(os.urandom(16)).decode()
            plug.sendall(f"GET / HTTP/1.1\r\nHost: 127.0.0.1:{it.admin_port}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
                         f"Sec-WebSocket-Key: {key}\r\nSec-WebSocket-Version: 13\r\n\r\n".encode())
            # TunnelRequest: call, method, message.
            path = b"/sightline.v1.RayQueryService/StreamCastRays"
            message = bytes(400_000)
            start = b"\x08\x01\x12" + bytes([len(path)]) + path + b"\x2a" + varint(len(message)) + message
            more = b"\x08\x01\x2a" + varint(len(message)) + message
            plug.sendall(websocket_frame(start))
            while True:
                plug.sendall(websocket_frame(more))
    in_threads(4, step)


def varint(number):
    parts = []
    while number > 127:
        parts.append(number & 127 | 128)
        number >>= 7
    return bytes([*parts, number])


def websocket_frame(payload):
    return b"\x82\xff" + struct.pack(">Q", len(payload)) + bytes(4) + payload


def metrics(it):
    def step():
        with urllib.request.urlopen(f"http://127.0.0.1:{it.admin_port}/metrics", timeout=5) as reply:
            reply.read()
    in_threads(8, step)


def strangers(it):
    """Calls without a token."""
    def step(calls):
        for call in [calls.GetServerInfo(future=True) for _ in range(64)]:
            call.exception()
    in_threads(4, step, lambda: Calls(grpc.insecure_channel(f"127.0.0.1:{it.port}", _LARGEST), ()))


# ---- rays

def large_casts(it):
    """All hits of many rays that run along the sheet."""
    def step(calls):
        request = it.cast_request(16384, kind=4, max_hits=4096)
        for _ in calls.StreamCastRays(iter([_proto.StreamCastRaysRequest(request=request)])):
            pass
    in_threads(6, step, it.connect)


def casts_without_trees(it):
    in_threads(6, lambda calls: calls.CastRays(it.cast_request(16384, build=3)), it.connect)


def small_casts(it):
    """64 at a time on each connection."""
    def step(calls):
        request = it.cast_request(1)
        for call in [calls.CastRays(request, future=True) for _ in range(64)]:
            call.exception()
    in_threads(4, step, it.connect)


def cancelled_casts(it):
    def step(calls):
        call = calls.CastRays(it.cast_request(8192), future=True)
        time.sleep(random.random() * 0.01)
        call.cancel()
    in_threads(4, step, it.connect)


def unread_answers(it):
    """Streams that ask and do not read."""
    def step(calls):
        request = _proto.StreamCastRaysRequest(request=it.cast_request(16384, kind=4, max_hits=64))
        call = calls.StreamCastRays(itertools.repeat(request), timeout=20)
        next(call)
        time.sleep(15)
        call.cancel()
    in_threads(20, step, it.connect)


def cold_trees(it):
    """Everything is built and thrown away again."""
    def step(calls):
        for _ in calls.Prefetch(scene=it.scene):
            pass
        calls.CoolScene(scene=it.scene)
    in_threads(4, step, it.connect)


# ---- scenes

def updates(it):
    in_threads(4, lambda calls: calls.ApplyUpdates(
        scene=it.scene, updates=[put(-1 - i, it.mesh, 200.0 + i) for i in range(3000)]), it.connect)


def many_scenes(it):
    def step(calls):
        scene = it.name("many")
        calls.CreateScene(scene={"name": scene})
        calls.ApplyUpdates(scene=scene, updates=[put(-1, it.mesh)])
        calls.CastRays(it.cast_request(16, scene))
    in_threads(4, step, it.connect)


def questions(it):
    """What is there to read, all the time."""
    def step(calls):
        calls.GetSceneStats(scene=it.scene)
        calls.ListDeferredCells(scene=it.scene)
        calls.ListScenes(parent="projects/default", page_size=1000)
        calls.ReadMesh(scene=it.scene, node=1)
        calls.FindMissingBlobs(digests=[f"sha256:{it.rays.integers(1 << 60):064x}/100" for _ in range(8000)])
    in_threads(4, step, it.connect)


def pinned_revisions(it):
    """Streams that rest, each at a revision of its own of a scene in which everything moves."""
    moving, calls = it.name("moving"), it.connect()
    calls.CreateScene(scene={"name": moving})
    calls.ApplyUpdates(scene=moving, updates=[put(-1 - i, it.mesh, mobility=2) for i in range(15000)])
    held = []

    def step():
        calls.ApplyUpdates(scene=moving, updates=[move(15000, it.rays.uniform())])
        requests = queue.Queue()
        requests.put(_proto.StreamCastRaysRequest(request=it.cast_request(1, moving)))
        stream = it.connect().StreamCastRays(iter(requests.get, None), timeout=600)
        next(stream)
        held.append(stream)
        if len(held) > 60:
            held.pop(0).cancel()
    repeat(step)


def producers(it):
    """Names of producers, and batches that are half sent."""
    def step(calls):
        def messages():
            yield _proto.StreamUpdatesRequest(open={"scene": it.scene, "producer": it.name("").rsplit("/", 1)[1]})
            yield _proto.StreamUpdatesRequest(batch={"sequence": 1, "more": True,
                                                     "updates": [put(-1 - i, it.mesh) for i in range(10000)]})
            time.sleep(5)
        for _ in calls.StreamUpdates(messages()):
            pass
    in_threads(8, step, it.connect)


def watchers(it):
    def step(calls):
        for _ in calls.WatchScene(scene=it.scene, start_revision=1):
            time.sleep(1)
    in_threads(40, step, it.connect)


# ---- bytes

def declared_uploads(it):
    """Uploads that declare large sizes, and send 64 KiB now and then."""
    def step(calls):
        calls.UploadBlob(_slow_upload(it.budget // 25, 7.0, 65536))
    in_threads(30, step, it.connect)


def half_uploads(it):
    """All but the last byte."""
    def step(calls):
        calls.UploadBlob(_slow_upload(9 * _MIB, 0.0, _MIB), timeout=20)
    in_threads(8, step, it.connect)


def _slow_upload(size, pause, part):
    rows = (size - 24) // 12
    size = 24 + rows * 12
    head = b"SLM1" + struct.pack("<IQQ", 0, rows, 0)
    yield _proto.UploadBlobRequest(digest=f"sha256:{random.getrandbits(256):064x}/{size}", data=head)
    for at in range(len(head), size - part, part):
        yield _proto.UploadBlobRequest(offset=at, data=bytes(part))
        time.sleep(pause)
    time.sleep(15)


def endless_restores(it):
    """A batch that goes on for ever."""
    def step(calls):
        def messages():
            scene = it.name("restored")
            yield _proto.RestoreRequest(scene=scene, part={"scene": {"scene": {"name": scene}, "revision": 5}})
            for _ in range(1000):
                yield _proto.RestoreRequest(part={"batch": {"revision": 1, "more": True, "updates": bytes(_MIB)}})
        calls.Restore(messages())
    in_threads(2, step, it.connect)


#: How many processes of each there are when all attack at once.
ATTACKS = {floods: 1, connections: 1, page_sockets: 1, metrics: 1, strangers: 1, large_casts: 2, casts_without_trees: 1, small_casts: 1,
           cancelled_casts: 1, unread_answers: 1, cold_trees: 1, updates: 1, many_scenes: 1, questions: 1, pinned_revisions: 1,
           producers: 1, watchers: 1, declared_uploads: 1, half_uploads: 1, endless_restores: 1}


def main():
    """attackers.py NAME PORT ADMIN_PORT TOKEN BUDGET SCENES"""
    name, port, admin_port, token, budget, scenes = sys.argv[1:]
    attack = next(attack for attack in ATTACKS if attack.__name__ == name)
    it = Attacker(int(port), int(admin_port), token, int(budget), scenes)
    it.make_scene()
    attack(it)


if __name__ == "__main__":
    main()
