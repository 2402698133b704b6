"""Reading the mesh of a node, part by part."""

from __future__ import annotations

from . import _proto, errors
from ._connection import Connection
from .node_mesh import NodeMesh

_ATTEMPTS = 8  # from the first part on


def read_mesh(connection: Connection, scene: str, node: int) -> NodeMesh:
    """See Scene.read_mesh."""
    for _ in range(_ATTEMPTS):
        try:
            return _read(connection, scene, node)
        except errors.OutOfRange:  # the revision of the first part is not kept any more
            pass
    raise errors.Aborted(f"the mesh of node {node} of {scene} changes faster than it can be read")


def _read(connection: Connection, scene: str, node: int) -> NodeMesh:
    part = connection.call("ReadMesh", _proto.ReadMeshRequest(scene=scene, node=node))
    revision, data = part.served.revision, bytearray(part.data)
    while len(data) < part.size:
        rest = _proto.ReadMeshRequest(scene=scene, node=node, offset=len(data), revision=revision)
        part = connection.call("ReadMesh", rest)
        if not part.data:
            raise errors.DataLoss(f"the mesh of node {node} ended after {len(data)} of {part.size} bytes")
        data += part.data
    return NodeMesh.of_blob(bytes(data), revision)
