"""A client that casts 16 rays again and again, and once a second sends an update and a mesh. All answers are checked afterwards,
without a tree."""

import pathlib
import sys
import threading
import time
import uuid

import numpy as np
import sightline
from sightline import _proto, meshes, updates

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "failures"))
import world  # noqa: E402

_PAUSE = 0.01   # seconds between two casts
_SEEDS = 64     # sets of rays
_RAYS = 16


class GoodClient:
    """It repeats nothing but what the package repeats. Threads: one for each kind of call."""

    def __init__(self, endpoint, token, scene):
        self._endpoint, self._token, self._scene = endpoint, token, scene
        self.times = {"cast": [], "update": [], "upload": []}   # seconds of a call, in the part that begins with forget_times()
        self.errors = {}
        self.wrong = self.checked = 0
        self._answers = []
        self._ends = threading.Event()
        with self._connect() as client:
            made = client.create_scene(scene)
            with made.batch() as batch:
                nodes = [[made.add(world.BOX, transform=transform, mobility="rigid") for transform in world.transforms(writer, 0)]
                         for writer in range(world.WRITERS)]
        self._nodes = np.array([[node.number for node in row] for row in nodes], np.uint64)
        self._sequences = {batch.applied.revision: 0}
        self._failed = []  # updates that may have been made
        self._threads = [threading.Thread(target=self._run, args=arguments, daemon=True) for arguments in
                         (("cast", self._cast, _PAUSE), ("update", self._update, 1.0), ("upload", self._upload, 1.0))]
        for thread in self._threads:
            thread.start()

    def forget_times(self):
        for times in self.times.values():
            times.clear()

    def stop(self):
        """Checks the answers, too."""
        self._ends.set()
        for thread in self._threads:
            thread.join(90)
        by_revision = {}
        for answer in self._answers:
            by_revision.setdefault(answer[1], []).append(answer)
        for revision, answers in by_revision.items():
            # What no call has told of is an update whose call failed.
            sequences = [self._sequences[revision]] if revision in self._sequences else list(self._failed)
            for seed, _, t, node in answers:
                agreed = [sequence for sequence in sequences if world.State([sequence] + [0] * (world.WRITERS - 1)).agrees(
                    _rays(seed), self._nodes.ravel(), (t, node))]
                self.checked += 1
                self.wrong += not agreed
                sequences = agreed or sequences

    def _connect(self):
        return sightline.connect(self._endpoint, token=self._token)

    def _run(self, what, call, pause):
        with self._connect() as client:
            number = 0
            while not self._ends.wait(pause):
                number += 1
                began = time.monotonic()
                try:
                    call(client, number)
                except sightline.SightlineError as error:
                    text = f"{what}: {type(error).__name__}: {error}"[:400]
                    self.errors[text] = self.errors.get(text, 0) + 1
                else:
                    self.times[what].append(time.monotonic() - began)

    def _cast(self, client, number):
        hits = client.scene(self._scene).cast(_rays(number % _SEEDS), fields=("t", "node"))
        self._answers.append((number % _SEEDS, hits.revision, hits.t, hits.node))

    def _update(self, client, number):
        request = _proto.ApplyUpdatesRequest(
            scene=client.scene(self._scene).name, request_id=uuid.uuid4().hex,
            updates=map(updates.encode, updates.set_transforms(self._nodes[0], world.transforms(0, number))))
        try:
            revision = client._connection.call("ApplyUpdates", request).revision.revision
        except sightline.SightlineError:
            self._failed.append(number)
            raise
        self._sequences[revision] = number

    def _upload(self, client, number):
        corners, faces = world.BOX
        meshes.upload(client._connection, meshes.as_mesh((np.float32(corners + 0.001 * number), faces)))


def _rays(seed):
    return world.make_rays(seed)[:_RAYS]
