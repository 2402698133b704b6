"""Changes of a scene's nodes: as messages to send, and as values from a watch."""

from __future__ import annotations

import dataclasses
import operator
from typing import Any, Iterable, List, Optional, Union

import numpy as np

from . import _proto

_ROWS_PER_UPDATE = 4096  # transforms, so that each message stays far below the server's limit
_VERTICES_PER_UPDATE = 65536
MOBILITIES = ("static", "rigid", "deforming")


@dataclasses.dataclass(frozen=True)
class PutNode:
    """A node that was made or replaced. transform: float64 (3, 4), parent from local; parent 0: a root."""

    node: int
    parent: int
    name: str
    transform: np.ndarray
    mesh_digest: str
    mobility: str
    mask: int


@dataclasses.dataclass(frozen=True)
class SetTransforms:
    """Nodes that moved. nodes: uint64 (n); transforms: float64 (n, 3, 4)."""

    nodes: np.ndarray
    transforms: np.ndarray


@dataclasses.dataclass(frozen=True)
class DeleteNode:
    """A node that was deleted; with those under it if `subtree`."""

    node: int
    subtree: bool


@dataclasses.dataclass(frozen=True)
class PatchVertices:
    """Vertices of nodes' mesh that moved, from `first` on. vertices: float32 (n, 3), in the mesh's frame."""

    nodes: np.ndarray
    first: int
    vertices: np.ndarray


Update = Union[PutNode, SetTransforms, DeleteNode, PatchVertices]


def as_matrix(transform: Any) -> np.ndarray:
    """float64 (..., 3, 4) of matrices (..., 3, 4) or (..., 4, 4), or of 12 or 16 numbers, row by row."""
    array = np.asarray(transform, "f8")
    if array.ndim == 1 and array.size in (12, 16):
        array = array.reshape(-1, 4)
    if array.ndim < 2 or array.shape[-1] != 4 or array.shape[-2] not in (3, 4):
        raise ValueError(f"a transform has the shape (3, 4) or (4, 4), not {array.shape}")
    if array.shape[-2] == 4 and not np.array_equal(array[..., 3, :], np.broadcast_to([0, 0, 0, 1], array[..., 3, :].shape)):
        raise ValueError("the last row of a transform (4, 4) is 0 0 0 1")
    return array[..., :3, :]


def ids(nodes: "Iterable[Any]") -> "List[int]":
    """The ids of nodes or numbers."""
    return [operator.index(node) for node in nodes]


def put_node(node: int, parent: int, name: str, transform: Any, digest: str, mobility: Optional[str],
             mask: Optional[int]) -> Any:
    """A message that makes (node < 0, an alias) or replaces a node."""
    if mobility is not None and mobility not in MOBILITIES:
        raise ValueError(f"mobility is {', '.join(MOBILITIES)}, not {mobility!r}")
    put = _proto.PutNode(node=node, parent=parent, name=name, mesh_digest=digest)
    if transform is not None:
        put.transform.matrix.extend(as_matrix(transform).reshape(12))
    if mobility is not None:
        put.mobility = _proto.enum_value(f"MOBILITY_{mobility.upper()}")
    if mask is not None:
        put.mask = mask
    return _proto.Update(put_node=put)


def set_transforms(nodes: "Iterable[Any]", transforms: Any) -> "List[Any]":
    """Messages that move nodes to transforms (n, 3, 4) or (n, 4, 4)."""
    numbers = ids(nodes)
    matrices = np.ascontiguousarray(as_matrix(transforms), "<f8")
    if matrices.shape != (len(numbers), 3, 4):
        raise ValueError(f"{len(numbers)} nodes need transforms of shape ({len(numbers)}, 3, 4), not {matrices.shape}")
    return [_proto.Update(set_transforms=_proto.SetTransforms(
        nodes=numbers[at:at + _ROWS_PER_UPDATE], matrices=matrices[at:at + _ROWS_PER_UPDATE].tobytes()))
        for at in range(0, len(numbers), _ROWS_PER_UPDATE)]


def delete_node(node: Any, subtree: bool) -> Any:
    """A message that deletes a node."""
    return _proto.Update(delete_node=_proto.DeleteNode(node=operator.index(node), subtree=subtree))


def patch_vertices(nodes: "Iterable[Any]", first: int, vertices: Any) -> "List[Any]":
    """Messages that move vertices of the one mesh of nodes."""
    positions = np.ascontiguousarray(vertices, "<f4")
    if positions.ndim != 2 or positions.shape[1] != 3:
        raise ValueError(f"vertices have the shape (n, 3), not {positions.shape}")
    numbers = ids(nodes)
    return [_proto.Update(patch_vertices=_proto.PatchVertices(
        nodes=numbers, first=first + at, positions=positions[at:at + _VERTICES_PER_UPDATE].tobytes()))
        for at in range(0, len(positions), _VERTICES_PER_UPDATE)]


def decode(update: Any) -> Update:
    """The value of a message."""
    kind = update.WhichOneof("update")
    value = getattr(update, kind)
    if kind == "put_node":
        matrix = np.array(value.transform.matrix or np.eye(3, 4).reshape(12)).reshape(3, 4)
        mobility = MOBILITIES[max(value.mobility, 1) - 1]
        mask = value.mask if value.HasField("mask") else 0xFFFFFFFF
        return PutNode(value.node, value.parent, value.name, matrix, value.mesh_digest, mobility, mask)
    if kind == "set_transforms":
        return SetTransforms(np.array(value.nodes, np.uint64), np.frombuffer(value.matrices, "<f8").reshape(-1, 3, 4))
    if kind == "delete_node":
        return DeleteNode(value.node, value.subtree)
    return PatchVertices(np.array(value.nodes, np.uint64), value.first,
                         np.frombuffer(value.positions, "<f4").reshape(-1, 3))
