"""Scenes behind the drop-in classes: on the server of SIGHTLINE_ENDPOINT, else on a private one of this process."""

from __future__ import annotations

import atexit
import os
import queue
import threading
import uuid
import weakref
from typing import Any, Dict, Optional, Tuple

from . import errors
from ._lattice import Placement
from .client import Client, connect
from .nodes import Node, translation
from .scene import Scene
from .server import serve

_lock = threading.Lock()
_clients: "Dict[int, Client]" = {}  # by process, as the next: what a fork inherits cannot be used
_deletions_of: "Dict[int, _Deletions]" = {}


def default_client() -> Client:
    """The client of all objects of this process, made when first needed. Errors: as of serve()."""
    with _lock:
        client = _clients.get(os.getpid())
        if client is None:
            client = connect() if os.environ.get("SIGHTLINE_ENDPOINT") else serve().client
            _clients[os.getpid()] = client
        return client


class _Deletions:
    """Deletes scenes on a thread of its own. The garbage collector ends objects in any thread, also in one of grpc's that
    holds a lock that a call needs, so that no call may be made there."""

    def __init__(self) -> None:
        self._ended: "queue.SimpleQueue[Optional[Scene]]" = queue.SimpleQueue()
        self._process = os.getpid()
        self._thread: Optional[threading.Thread] = threading.Thread(target=self._run, name="sightline-deletions",
                                                                    daemon=True)
        self._thread.start()
        atexit.register(self._finish)

    def add(self, scene: Scene) -> None:
        if os.getpid() != self._process:
            return
        if self._thread is None:  # the process ends
            _delete(scene)
        else:
            self._ended.put(scene)

    def _run(self) -> None:
        for scene in iter(self._ended.get, None):
            _delete(scene)

    def _finish(self) -> None:
        if os.getpid() == self._process and self._thread is not None:
            self._ended.put(None)
            self._thread.join()
            self._thread = None


def _deletions() -> _Deletions:
    """Those of this process."""
    with _lock:
        found = _deletions_of.get(os.getpid())
        if found is None:
            found = _deletions_of[os.getpid()] = _Deletions()
        return found


class OwnScene:
    """A scene that nothing else uses; it is deleted soon after this object."""

    def __init__(self, client: Optional[Client]):
        self.scene = (client or default_client()).create_scene(f"own-{uuid.uuid4().hex}")
        self._end = weakref.finalize(self, _deletions().add, self.scene)

    def add(self, vertices: Any, faces: Any) -> Node:
        """Adds a mesh, kept on the lattice of this scene. The node is the one that hits name."""
        return self.add_placed(vertices, faces)[0]

    def add_placed(self, vertices: Any, faces: Any) -> "Tuple[Node, Optional[Placement]]":
        """As add(), with how the mesh is kept; None: its vertices are rounded to float32."""
        digest, placement = self.scene._upload((vertices, faces))
        transform = None if placement is None else translation(placement.origin)
        return self.scene.put(digest, transform=transform), placement

    def close(self) -> None:
        """Deletes it now."""
        if self._end.detach() is not None:
            _delete(self.scene)


def _delete(scene: Scene) -> None:
    try:
        scene.delete()
    except (errors.SightlineError, ValueError):  # the server, or the connection, was closed before
        pass
