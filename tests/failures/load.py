"""Clients that cast and write while something fails: those of the Python package, with nothing set but the endpoint."""

import threading
import time
import uuid

import numpy as np
import sightline
from sightline import _proto, updates

import world
from truth import Truth

_CASTERS = 2      # for each endpoint
_SEEDS = 8        # sets of rays
_REPEATED = 4     # one of four batches with rays is sent twice
_PAUSE = 0.02     # seconds between two calls of a client, which share the cores with the cluster
RAYS = {seed: world.make_rays(seed) for seed in range(_SEEDS)}


class Client:
    """One thread that calls again and again. `failed` counts calls that raised; `longest` is the longest time in seconds from one
    that did not to the next."""

    def __init__(self, load, endpoint, what):
        self.what = what
        self.failed = self.succeeded = 0
        self.longest = 0.0
        self.errors = {}
        self._load = load
        self._client = sightline.connect(endpoint)
        self._last = time.monotonic()
        self.thread = threading.Thread(target=self._run, daemon=True)

    def _run(self):
        while not self._load.ends:
            self._step()
        self._client.close()

    def _done(self):
        now = time.monotonic()
        self.longest = max(self.longest, now - self._last)
        self._last = now
        self.succeeded += 1

    def _fail(self, error):
        self.failed += 1
        text = f"{type(error).__name__}: {error}"[:150]
        self.errors[text] = self.errors.get(text, 0) + 1


class Caster(Client):
    """Every other cast asks for the newest revision that was acknowledged before."""

    def __init__(self, load, endpoint, what, number):
        super().__init__(load, endpoint, what)
        self._scene = self._client.scene(load.truth.scene)
        self._count = number

    def _step(self):
        self._count += 1
        seed = self._count % _SEEDS
        revision, token = self._load.truth.newest() if self._count % 2 and self._load.truth.newest()[1] else (0, None)
        started = time.monotonic()
        try:
            hits = self._scene.cast(RAYS[seed], fields=("t", "node"), at_least=token)
        except sightline.SightlineError as error:
            self._fail(error)
        else:
            self._load.truth.answer(seed, hits, started, revision)
            self._done()
        time.sleep(_PAUSE)


class Writer(Client):
    """Repeats a request that failed, with its id, until it is acknowledged."""

    def __init__(self, load, endpoint, what, number):
        super().__init__(load, endpoint, what)
        self._number = number
        self._nodes = load.truth.nodes[number]
        self._scene = load.truth.scene
        self._sequence = 0

    def _step(self):
        self._sequence += 1
        request = _proto.ApplyUpdatesRequest(scene=self._client.scene(self._scene).name, request_id=uuid.uuid4().hex,
                                             updates=map(updates.encode, updates.set_transforms(
                                                 self._nodes, world.transforms(self._number, self._sequence))))
        while not self._load.gives_up:
            try:
                revision = self._client._connection.call("ApplyUpdates", request).revision
            except sightline.SightlineError as error:
                self._fail(error)
                time.sleep(_PAUSE)
                continue
            self._load.truth.acknowledge(self._number, self._sequence, revision.revision, revision.revision, revision.token)
            self._done()
            break
        time.sleep(_PAUSE)


class CastingWriter(Writer):
    """The same with rays in the request, which see the batch. Every few of them are sent again when they are acknowledged, as by a
    client that has not heard it: that may make no other revision."""

    def _step(self):
        self._sequence += 1
        request_id = uuid.uuid4().hex
        made = self._cast(request_id, 0)
        if made is not None:
            self._load.truth.acknowledge(self._number, self._sequence, made.revision, made.revision, made.token)
            self._done()
            if self._sequence % _REPEATED == 0:
                self._cast(request_id, made.revision)
        time.sleep(_PAUSE)

    def _cast(self, request_id, least):
        """What the batch came to, at `least` or later. None: the load has ended before."""
        seed, scene = self._sequence % _SEEDS, self._client.scene(self._scene)
        batch = scene.batch()
        batch._id = request_id
        batch.add(updates.set_transforms(self._nodes, world.transforms(self._number, self._sequence)), [])
        while not self._load.gives_up:
            started = time.monotonic()
            try:
                hits = scene.cast(RAYS[seed], fields=("t", "node"), apply=batch)
            except sightline.SightlineError as error:
                self._fail(error)
                time.sleep(_PAUSE)
                continue
            self._load.truth.answer(seed, hits, started, max(least, hits.applied.revision))
            return hits.applied
        return None


class StreamWriter(Writer):
    """The same over a stream, one batch at a time. A stream that ended is opened again, and tells what is kept."""

    _stream = None
    _heard = 0  # the revision of the last answer

    def _step(self):
        sequence, least = self._sequence + 1, self._heard + 1
        try:
            if self._stream is None:
                self._stream = self._client.scene(self._scene).update_stream(f"writer-{self._number}")
            opened = self._stream._attempt
            if self._stream._last < sequence:
                self._stream.set_transforms(self._nodes, world.transforms(self._number, sequence))
                self._stream.flush(60)
            certain = opened == self._stream._attempt
        except sightline.SightlineError as error:
            self._fail(error)
            self._stream = None
            return time.sleep(_PAUSE)
        self._sequence = sequence
        self._heard = self._stream.revision
        self._load.truth.acknowledge(self._number, sequence, self._heard if certain else least, self._heard, self._stream.token)
        self._done()
        time.sleep(_PAUSE)


_WRITERS = (StreamWriter, Writer, CastingWriter, CastingWriter)
assert len(_WRITERS) == world.WRITERS


class Load:
    """All clients, on a new scene. `balanced` and `listed` are endpoints: HAProxy, and the replicas themselves."""

    def __init__(self, name, balanced, listed):
        self.ends = self.gives_up = False
        self._admin = sightline.connect(balanced)
        self.truth = _make_scene(self._admin, name)
        self.clients = []
        for what, endpoint in (("haproxy", balanced), ("list", listed)):
            self.clients += [Caster(self, endpoint, f"cast/{what}", number) for number in range(_CASTERS)]
        for number in range(world.WRITERS):
            what, endpoint = (("list", listed), ("haproxy", balanced))[number % 2]
            self.clients.append(_WRITERS[number](self, endpoint, f"update/{what}", number))

    def start(self):
        for client in self.clients:
            client.thread.start()

    def wait_for(self, successes, seconds):
        """Until each client has had so many more. Returns what has not."""
        goals = [(client, client.succeeded + successes) for client in self.clients]
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            goals = [(client, goal) for client, goal in goals if client.succeeded < goal]
            if not goals:
                break
            time.sleep(_PAUSE)
        return [client.what for client, _ in goals]

    def forget_times(self):
        """What was slow before the fault does not count."""
        for client in self.clients:
            client.longest = 0.0

    def stop(self):
        """Writers first get their last batch acknowledged."""
        self.ends = True
        for patience in (60, 5):
            for client in self.clients:
                client.thread.join(patience)
            self.gives_up = True
        return [client.what for client in self.clients if client.thread.is_alive()]

    def judge(self):
        scene = self._admin.scene(self.truth.scene)
        ids = self.truth.nodes.ravel()
        found = self._admin._connection.call("BatchGetNodes", _proto.BatchGetNodesRequest(
            scene=scene.name, ids=[int(node) for node in ids], consistency=_at_least(self.truth.newest()[1])))
        now = np.array([list(node.transform.matrix) for node in found.nodes]).reshape(*self.truth.nodes.shape, 3, 4)
        verdict = self.truth.judge(RAYS, found.served.revision, now)
        self._admin.close()
        return verdict


def _at_least(token):
    return _proto.Consistency(at_least=token) if token else None


def _make_scene(client, name):
    scene = client.create_scene(name)
    with scene.batch() as batch:
        nodes = [[scene.add(world.BOX, transform=transform, mobility="rigid") for transform in world.transforms(writer, 0)]
                 for writer in range(world.WRITERS)]
    ids = np.array([[node.number for node in row] for row in nodes], np.uint64)
    return Truth(name, ids, batch.applied.revision)
