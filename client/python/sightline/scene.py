"""A scene: its nodes, its revisions, and what it answers (queries.py)."""

from __future__ import annotations

import dataclasses
import math
from typing import TYPE_CHECKING, Any, Dict, Iterable, Iterator, List, Optional, Tuple

import numpy as np

from . import _proto, _query, updates
from ._connection import Connection
from ._lattice import Placement
from .batch import Batch, apply
from .hierarchy import add_hierarchy, is_hierarchy
from .meshes import as_mesh, upload
from .nodes import Node, patches, translation
from .picture import Picture, render
from .queries import AnyNode, Queries
from .update_stream import UpdateStream
from .watch import Change, watch

if TYPE_CHECKING:
    from .client import Client

_MOST_NODES = 512  # in one BatchGetNodes


@dataclasses.dataclass(frozen=True)
class SceneInfo:
    """What the server says of a scene. bounds: float64 (2, 3), least and greatest; None without triangles. `read` is
    false where a listed scene is on disk only, and its counts are not known."""

    name: str
    revision: int
    token: str
    up_axis: Optional[str]
    meters_per_unit: float
    nodes: int
    instances: int
    meshes: int
    triangles_unique: int
    triangles_instanced: int
    triangles_nonfinite: int
    bytes_geometry: int
    bounds: Optional[np.ndarray]
    read: bool

    @classmethod
    def of(cls, scene: Any) -> "SceneInfo":
        """The SceneInfo of a message Scene."""
        counts = {name: getattr(scene, name) for name in (
            "nodes", "instances", "meshes", "triangles_unique", "triangles_instanced", "triangles_nonfinite",
            "bytes_geometry", "meters_per_unit")}
        bounds = np.array(scene.bounds).reshape(2, 3) if scene.bounds else None
        return cls(name=scene.name, revision=scene.head.revision, token=scene.head.token,
                   up_axis=(None, "y", "z")[scene.up_axis], bounds=bounds, read=not scene.unread, **counts)


class Scene(Queries):
    """Threads: any, but a batch belongs to the thread that opened it. Every call may raise NotFound, and what
    Client says."""

    def __init__(self, client: "Client", name: str):
        self.client = client
        self.name = name  #: projects/{project}/scenes/{scene}
        self._connection: Connection = client._connection
        self._batch: Optional[Batch] = None

    def __repr__(self) -> str:
        return f"<scene {self.name} at {self.client.endpoint}>"

    def info(self) -> SceneInfo:
        """Its size, bounds and revision."""
        return SceneInfo.of(self._connection.call("GetScene", _proto.GetSceneRequest(name=self.name)).scene)

    def stats(self) -> Any:
        """How much of its trees is built (a message GetSceneStatsResponse)."""
        return self._connection.call("GetSceneStats", _proto.GetSceneStatsRequest(scene=self.name))

    def delete(self) -> None:
        """Deletes the scene with all its nodes."""
        self.client.delete_scene(self.name)

    def render(self, size: Any = (640, 480), **options: Any) -> Picture:
        """A picture, width x height, of closest hits shaded by their normals; a notebook displays it.

        eye, at, up: (3) in scene coordinates; default: the whole scene is seen from above a corner. fov: degrees from
        the bottom to the top, default 40. fields: columns of the picture's hits beside those of geometry, such as
        ("position", "name"). at_least, revision, timeout: as for cast.
        """
        return render(self, size, **options)

    def _names(self, ids: np.ndarray, revision: int) -> "Dict[int, str]":
        return {node.id: node.name for node in self.nodes(ids, revision=revision)}

    # ---- nodes

    def nodes(self, ids: Iterable[AnyNode], *, at_least: Optional[str] = None,
              revision: Optional[int] = None) -> "List[Any]":
        """Names, parents, transforms, meshes of nodes by id (messages Node); one that does not exist has id 0."""
        wanted, found = updates.ids(ids), []
        for at in range(0, len(wanted), _MOST_NODES):
            request = _proto.BatchGetNodesRequest(scene=self.name, ids=wanted[at:at + _MOST_NODES])
            _query.set_consistency(request, at_least, revision)
            found += self._connection.call("BatchGetNodes", request).nodes
        return found

    def add(self, mesh: Any = None, *, name: str = "", parent: AnyNode = 0, transform: Any = None,
            origin: Any = (0.0, 0.0, 0.0), mobility: Optional[str] = None, mask: Optional[int] = None) -> Node:
        """A new node, under `parent` (0: a root), and its mesh; None: a group.

        mesh: (vertices (v, 3), faces (f, 3)), or an object that has both, as trimesh's; or a trimesh.Scene, whose nodes
        are put under this one, all as one revision. Vertices are kept as float32; with `origin` (3), a point near them,
        about a point of the scene's lattice, where meshes that share vertices still share them, and by a node of its
        own below the new one if that point is not zero (Node.mesh_node). transform: (3, 4) or (4, 4), parent from local.
        mobility: "static", "rigid", "deforming". mask: 32 bits, of which rays need one. Errors: TypeError, ValueError
        (not a mesh, a transform), InvalidArgument (no ray can be transformed into its frame), NotFound (the parent).
        """
        options = {"name": name, "parent": parent, "transform": transform, "mobility": mobility, "mask": mask}
        if is_hierarchy(mesh):
            return add_hierarchy(self, mesh, **options)
        if mesh is None:
            return self.put("", **options)
        point = tuple(np.asarray(origin, "f8").reshape(3).tolist())
        if not any(point):
            return self.put(upload(self._connection, as_mesh(mesh)), **options)
        digest, placement = self._upload(mesh)
        self.client._lattice(self.name).added[digest, point] = placement
        return self._put(digest, placement, **options)

    def _upload(self, mesh: Any) -> "Tuple[str, Optional[Placement]]":
        """Sends a mesh that is kept on the scene's lattice."""
        made = as_mesh(mesh, self.client._lattice(self.name))
        return upload(self._connection, made), made.placement

    def put(self, digest: str, *, name: str = "", parent: AnyNode = 0, transform: Any = None,
            origin: Any = (0.0, 0.0, 0.0), mobility: Optional[str] = None, mask: Optional[int] = None) -> Node:
        """A new node with a mesh that the server has, by its digest; "": a group. origin: as given to the add() of this
        program that sent the mesh, or Node.origin of its node."""
        point = tuple(np.asarray(origin, "f8").reshape(3).tolist())
        placement = Placement(np.array(point), math.inf) if digest and any(point) else None
        return self._put(digest, self.client._lattice(self.name).added.get((digest, point), placement), name=name,
                         parent=parent, transform=transform, mobility=mobility, mask=mask)

    def _put(self, digest: str, placement: "Optional[Placement]", *, name: str, parent: AnyNode, transform: Any,
             mobility: Optional[str], mask: Optional[int]) -> Node:
        """A node, and one below it for a mesh that is placed, so that every move of the node moves the mesh with it."""
        alias = self._batch.next_alias() if self._batch else -1
        node = Node(self, alias)
        made, changes = [node], [updates.put_node(alias, updates.ids([parent])[0], name, transform,
                                                  digest if placement is None else "", mobility, mask)]
        if placement is not None:
            made.append(node.placed(alias - 1, placement))
            changes.append(updates.put_node(alias - 1, alias, name, translation(placement.origin), digest, mobility, mask))
        self._change(changes, made)
        return node

    def set_transforms(self, nodes: Iterable[AnyNode], transforms: Any) -> None:
        """Moves nodes to transforms (n, 3, 4) or (n, 4, 4), float64, parent from local."""
        self._change(updates.set_transforms(nodes, transforms), [])

    def patch_vertices(self, nodes: Iterable[AnyNode], vertices: Any, first: int = 0) -> None:
        """Moves vertices (n, 3), from number `first` on, of the one mesh that the nodes have: in what the mesh's vertices
        were given in if the nodes are Node objects; of ids, in the mesh's own frame. Errors: ValueError, Node objects of
        different `origin`; InvalidArgument, a node without a mesh."""
        self._change(patches(nodes, first, vertices), [])

    def delete_node(self, node: AnyNode, subtree: bool = False) -> None:
        """Errors: FailedPrecondition, it has children and `subtree` is not set; the node that holds the mesh of a Node
        object with an `origin` does not count."""
        changes = [updates.delete_node(node, subtree)]
        if isinstance(node, Node) and node.mesh_node is not node and not subtree:
            changes.insert(0, updates.delete_node(node.mesh_node, False))
        self._change(changes, [])

    def batch(self, expected_revision: Optional[int] = None) -> Batch:
        """Within `with scene.batch() as batch:` the changes of nodes are collected, and applied at its end as one
        revision, `batch.applied`; all or none. After an exception in it none is. Errors at its end: Aborted, the scene
        is not at the expected revision; those of the changes."""
        return Batch(self, expected_revision)

    def _change(self, changes: "List[Any]", made: "List[Node]") -> None:
        if self._batch is not None:
            self._batch.add(changes, made)
            return
        applied = apply(self._connection, self.name, changes)
        for node, number in zip(made, applied.nodes):
            node.number = number

    # ---- streams

    def update_stream(self, producer: str, *, latest_wins: bool = False, relaxed: bool = False) -> UpdateStream:
        """A stream of updates by a producer of this name, [A-Za-z0-9._-]{1,64}; see UpdateStream."""
        return UpdateStream(self._connection, self.name, producer, latest_wins, relaxed)

    def watch(self, start: Optional[int] = None) -> "Iterator[Change]":
        """Every revision after `start` (default: the current one), in order and without gaps, until the iterator is
        closed. A broken call is opened again. Errors: OutOfRange, a revision that is needed is not kept any more."""
        return watch(self._connection, self.name, start)
