"""A connection to a server, whose calls are awaited."""

from __future__ import annotations

import functools
from typing import Any, Optional

from .. import client
from .._types import Path
from ..shared_memory import Transport
from ._threads import Threads, awaited
from .scene import Scene


def connect(endpoint: Optional[str] = None, *, tls_ca: Optional[Path] = None, tls_cert: Optional[Path] = None,
            tls_key: Optional[Path] = None, token: Optional[str] = None, token_file: Optional[Path] = None,
            timeout: Optional[float] = None, use_segments: bool = True) -> "Client":
    """A client; the options of sightline.connect()."""
    return Client(client.connect(endpoint, tls_ca=tls_ca, tls_cert=tls_cert, tls_key=tls_key, token=token,
                                 token_file=token_file, timeout=timeout, use_segments=use_segments))


class Client:
    """sightline.Client, awaited."""

    def __init__(self, original: client.Client):
        self._original = original
        self._threads = Threads()

    async def __aenter__(self) -> "Client":
        return self

    async def __aexit__(self, *_: Any) -> None:
        await self.close()

    def __repr__(self) -> str:
        return f"<asynchronous {repr(self._original)[1:]}"

    async def close(self) -> None:
        """Ends the connection and all calls."""
        self._original.close()
        self._threads.close()

    @property
    def endpoint(self) -> str:
        """Where the server listens."""
        return self._original.endpoint

    @property
    def transport(self) -> Transport:
        """As of sightline.Client."""
        return self._original.transport

    def scene(self, name: str) -> Scene:
        """A scene; makes no call."""
        return Scene(self._original.scene(name), self._threads)

    async def create_scene(self, name: str, *, up_axis: Optional[str] = None, meters_per_unit: float = 0) -> Scene:
        """As of sightline.Client."""
        return Scene(await self._threads.run(self._original.create_scene, name, up_axis=up_axis,
                                             meters_per_unit=meters_per_unit), self._threads)

    async def import_arrays(self, name: str, vertices: Any, faces: Any, **options: Any) -> Scene:
        """As of sightline.Client."""
        make = functools.partial(self._original.import_arrays, name, vertices, faces, **options)
        return Scene(await self._threads.run(make), self._threads)

    async def import_file(self, name: str, path: Path, **options: Any) -> Scene:
        """As of sightline.Client. Cancelling the task ends the command."""
        make = functools.partial(self._original.import_file, name, path, **options)
        return Scene(await self._threads.run(make), self._threads)

    delete_scene = awaited(client.Client.delete_scene)
    scenes = awaited(client.Client.scenes)
    list_scenes = scenes
    server_info = awaited(client.Client.server_info)
    max_rays_per_request = awaited(client.Client.max_rays_per_request)
    read_log = awaited(client.Client.read_log)
    share_memory = awaited(client.Client.share_memory)
    backup = awaited(client.Client.backup)
    restore = awaited(client.Client.restore)
