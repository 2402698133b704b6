"""What the scenes of one client share: the connection, a limit of the server, and what is known of scenes by name."""

from __future__ import annotations

from typing import Dict, Optional, Tuple

from . import _proto
from ._connection import Connection
from ._lattice import Lattice
from ._node_table import NodeTable


class Session:
    """Threads: any."""

    def __init__(self, connection: Connection):
        self.connection = connection
        #: The token of a revision, and the length of the scene's diagonal there.
        self.diagonals: "Dict[str, Tuple[str, float]]" = {}
        #: The nodes of scenes whose names were asked for, as one revision of each has them.
        self.node_tables: "Dict[str, NodeTable]" = {}
        self._lattices: "Dict[str, Lattice]" = {}
        self._most_rays: Optional[int] = None

    def max_rays_per_request(self) -> int:
        """A limit of the server, which is asked once."""
        if self._most_rays is None:
            info = self.connection.call("GetServerInfo", _proto.GetServerInfoRequest())
            self._most_rays = int(info.max_rays_per_request)
        return self._most_rays

    def lattice(self, scene: str) -> Lattice:
        """The lattice of a scene, for what this client adds to it."""
        return self._lattices.setdefault(scene, Lattice())

    def begin_scene(self, scene: str, lattice: Optional[Lattice] = None) -> None:
        """The scene is made anew, or gone."""
        self._lattices.pop(scene, None)
        self.node_tables.pop(scene, None)
        if lattice is not None:
            self._lattices[scene] = lattice

    def delete_scene(self, scene: str) -> None:
        """Errors: NotFound."""
        self.connection.call("DeleteScene", _proto.DeleteSceneRequest(name=scene))
        self.begin_scene(scene)
