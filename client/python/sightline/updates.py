"""Changes of a scene's nodes: what is sent, and what a watch tells."""

from __future__ import annotations

import dataclasses
import operator
from typing import Any, Dict, Iterable, List, Mapping, Optional, Union

import numpy as np

from . import _proto, label
from ._types import Array, Doubles, Floats

_ROWS_PER_UPDATE = 4096  # transforms, so that each message stays far below the server's limit
_VERTICES_PER_UPDATE = 65536
MOBILITIES = ("static", "rigid", "deforming")
ALL_BITS = 0xFFFFFFFF  # the mask of a node that is given none


@dataclasses.dataclass(frozen=True)
class PutNode:
    """A node that is made (its number is a negative alias, then) or replaced. transform: float64 (3, 4), parent from
    local; parent 0: a root. labels: values by keys."""

    node: int
    parent: int
    name: str
    transform: Doubles
    mesh_digest: str
    mobility: str
    mask: int
    labels: Dict[str, str] = dataclasses.field(default_factory=dict)


@dataclasses.dataclass(frozen=True)
class SetTransforms:
    """Nodes that move. nodes: integers (n), ids or, where they are sent, aliases; transforms: float64 (n, 3, 4)."""

    nodes: Array
    transforms: Doubles


@dataclasses.dataclass(frozen=True)
class DeleteNode:
    """A node that is deleted; with those under it if `subtree`."""

    node: int
    subtree: bool


@dataclasses.dataclass(frozen=True)
class PatchVertices:
    """Vertices of nodes' mesh that move, from `first` on. vertices: float32 (n, 3), in the mesh's frame."""

    nodes: Array
    first: int
    vertices: Floats


Update = Union[PutNode, SetTransforms, DeleteNode, PatchVertices]


def as_matrix(transform: Any) -> Doubles:
    """float64 (..., 3, 4) of matrices (..., 3, 4) or (..., 4, 4), or of 12 or 16 numbers, row by row."""
    array = np.asarray(transform, "f8")
    if array.ndim == 1 and array.size in (12, 16):
        array = array.reshape(-1, 4)
    if array.ndim < 2 or array.shape[-1] != 4 or array.shape[-2] not in (3, 4):
        raise ValueError(f"a transform has the shape (3, 4) or (4, 4), not {array.shape}")
    if array.shape[-2] == 4 and not np.array_equal(array[..., 3, :], np.broadcast_to([0, 0, 0, 1], array[..., 3, :].shape)):
        raise ValueError("the last row of a transform (4, 4) is 0 0 0 1")
    matrix: Doubles = array[..., :3, :]
    return matrix


def ids(nodes: "Iterable[Any]") -> "List[int]":
    """The ids of nodes or numbers."""
    return [operator.index(node) for node in nodes]


def put_node(node: int, parent: int = 0, name: str = "", transform: Any = None, digest: str = "",
             mobility: Optional[str] = None, mask: Optional[int] = None,
             labels: "Optional[Mapping[str, str]]" = None) -> PutNode:
    """Makes (node < 0, an alias) or replaces a node. Errors: ValueError, another mobility, a transform of another
    shape, a mask of more than 32 bits; TypeError, labels that are not strings."""
    if mobility is not None:
        check_mobility(mobility)
    if mask is not None and not 0 <= mask <= ALL_BITS:
        raise ValueError(f"a mask has 32 bits, not {mask}")
    matrix = np.eye(3, 4) if transform is None else as_matrix(transform)
    if matrix.shape != (3, 4):
        raise ValueError(f"a transform has the shape (3, 4) or (4, 4), not {matrix.shape}")
    return PutNode(operator.index(node), operator.index(parent), name, matrix, digest, mobility or "static",
                   ALL_BITS if mask is None else mask, label.checked(labels))


def set_transforms(nodes: "Iterable[Any]", transforms: Any) -> "List[SetTransforms]":
    """Moves nodes to transforms (n, 3, 4) or (n, 4, 4)."""
    numbers = ids(nodes)
    matrices = np.ascontiguousarray(as_matrix(transforms), "<f8")
    if matrices.shape != (len(numbers), 3, 4):
        raise ValueError(f"{len(numbers)} nodes need transforms of shape ({len(numbers)}, 3, 4), not {matrices.shape}")
    table = np.array(numbers, np.int64)
    return [SetTransforms(table[at:at + _ROWS_PER_UPDATE], matrices[at:at + _ROWS_PER_UPDATE])
            for at in range(0, len(numbers), _ROWS_PER_UPDATE)]


def delete_node(node: Any, subtree: bool = False) -> DeleteNode:
    """Deletes a node."""
    return DeleteNode(operator.index(node), subtree)


def patch_vertices(nodes: "Iterable[Any]", first: int, vertices: Any) -> "List[PatchVertices]":
    """Moves vertices of the one mesh of nodes."""
    positions = np.ascontiguousarray(vertices, "<f4")
    if positions.ndim != 2 or positions.shape[1] != 3:
        raise ValueError(f"vertices have the shape (n, 3), not {positions.shape}")
    table = np.array(ids(nodes), np.int64)
    return [PatchVertices(table, first + at, positions[at:at + _VERTICES_PER_UPDATE])
            for at in range(0, len(positions), _VERTICES_PER_UPDATE)]


def encode(change: Update) -> Any:
    """The message of a change. TypeError: it is none."""
    if isinstance(change, PutNode):
        put = _proto.PutNode(node=change.node, parent=change.parent, name=change.name, mesh_digest=change.mesh_digest,
                             mobility=_proto.enum_value(f"MOBILITY_{change.mobility.upper()}"), mask=change.mask,
                             labels=label.encode(change.labels))
        put.transform.matrix.extend(as_matrix(change.transform).reshape(12))
        return _proto.Update(put_node=put)
    if isinstance(change, SetTransforms):
        return _proto.Update(set_transforms=_proto.SetTransforms(
            nodes=np.asarray(change.nodes).tolist(), matrices=np.ascontiguousarray(change.transforms, "<f8").tobytes()))
    if isinstance(change, DeleteNode):
        return _proto.Update(delete_node=_proto.DeleteNode(node=change.node, subtree=change.subtree))
    if isinstance(change, PatchVertices):
        return _proto.Update(patch_vertices=_proto.PatchVertices(
            nodes=np.asarray(change.nodes).tolist(), first=change.first,
            positions=np.ascontiguousarray(change.vertices, "<f4").tobytes()))
    raise TypeError(f"a change is one of sightline.updates, not {type(change).__name__}")


def check_mobility(mobility: str) -> None:
    """ValueError: it is another word."""
    if mobility not in MOBILITIES:
        raise ValueError(f"mobility is {', '.join(MOBILITIES)}, not {mobility!r}")


def mobility_name(number: int) -> str:
    """The word for an enumerator of Mobility."""
    return MOBILITIES[max(number, 1) - 1]


def decode(update: Any) -> Update:
    """The value of a message."""
    kind = update.WhichOneof("update")
    value = getattr(update, kind)
    if kind == "put_node":
        matrix = np.array(value.transform.matrix or np.eye(3, 4).reshape(12)).reshape(3, 4)
        mask = value.mask if value.HasField("mask") else ALL_BITS
        return PutNode(value.node, value.parent, value.name, matrix, value.mesh_digest, mobility_name(value.mobility), mask,
                       label.decode(value.labels))
    if kind == "set_transforms":
        return SetTransforms(np.array(value.nodes, np.uint64), np.frombuffer(value.matrices, "<f8").reshape(-1, 3, 4))
    if kind == "delete_node":
        return DeleteNode(value.node, value.subtree)
    return PatchVertices(np.array(value.nodes, np.uint64), value.first,
                         np.frombuffer(value.positions, "<f4").reshape(-1, 3))
