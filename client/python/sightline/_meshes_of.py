"""Scenes behind the drop-in classes: on the server of SIGHTLINE_ENDPOINT, else on a private one of this process."""

from __future__ import annotations

import os
import threading
import uuid
import weakref
from typing import Any, Dict, Optional

from . import errors
from .client import Client, connect
from .nodes import Node, translation
from .scene import Scene
from .server import serve

_lock = threading.Lock()
_clients: "Dict[int, Client]" = {}  # by process: what a fork inherits cannot be used


def default_client() -> Client:
    """The client of all objects of this process, made when first needed. Errors: as of serve()."""
    with _lock:
        client = _clients.get(os.getpid())
        if client is None:
            client = connect() if os.environ.get("SIGHTLINE_ENDPOINT") else serve().client
            _clients[os.getpid()] = client
        return client


class OwnScene:
    """A scene that nothing else uses; it is deleted with this object."""

    def __init__(self, client: Optional[Client]):
        self.scene = (client or default_client()).create_scene(f"own-{uuid.uuid4().hex}")
        self._end = weakref.finalize(self, _delete, self.scene, os.getpid())

    def add(self, vertices: Any, faces: Any) -> Node:
        """Adds a mesh, kept on the lattice of this scene. The node is the one that hits name."""
        digest, placement = self.scene._upload((vertices, faces))
        return self.scene.put(digest, transform=None if placement is None else translation(placement.origin))

    def close(self) -> None:
        self._end()


def _delete(scene: Scene, process: int) -> None:
    if os.getpid() != process:
        return
    try:
        scene.delete()
    except (errors.SightlineError, ValueError):  # the server, or the connection, was closed before
        pass
