"""What the scenes of one client share: the connection, what the server is, and what is known of scenes by name."""

from __future__ import annotations

from typing import Any, Dict, Optional, Tuple

from . import _proto, errors
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
        self._info: Optional[Any] = None  # the message GetServerInfoResponse

    def max_rays_per_request(self) -> int:
        """A limit of the server."""
        return int(self._server().max_rays_per_request)

    def check_feature(self, name: str) -> None:
        """Errors: Unimplemented, the server is of a version without it, and would ignore what is asked."""
        if name not in self._server().features:
            raise errors.Unimplemented(f"the server is of a version without {name}")

    def _server(self) -> Any:
        """What the server is, which is asked once."""
        if self._info is None:
            self._info = self.connection.call("GetServerInfo", _proto.GetServerInfoRequest())
        return self._info

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
