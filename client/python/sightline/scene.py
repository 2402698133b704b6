"""A scene: its nodes, its revisions, and what it answers."""

from __future__ import annotations

import math
from typing import Any, Dict, Iterable, Iterator, List, Mapping, Optional, Tuple

import numpy as np

from . import _proto, _types, updates
from ._as_points import as_points, check_grid
from ._lattice import Placement
from ._node_table import read_nodes
from ._prefetch import prefetch
from ._progress import Amount
from ._queried import AnyNode, Nodes, is_generated
from ._read_mesh import read_mesh
from ._session import Session
from .applied import Applied
from .batch import Batch, apply
from .change import Change
from .deferred_cells import DeferredCells
from .hierarchy import add_hierarchy, is_hierarchy
from .label import select
from .meshes import as_mesh, upload
from .node_info import NodeInfo
from .node_mesh import NodeMesh
from .nodes import Node, patches, translation
from .picture import Picture, render
from .point_grid import PointGrid
from .point_queries import PointQueries
from .prefetch_report import PrefetchReport
from .ray_queries import RayQueries
from .rays import as_rays
from .scene_info import SceneInfo
from .scene_stats import SceneStats
from .update_stream import UpdateStream
from .watch import watch


class Scene(RayQueries, PointQueries):
    """Threads: any, but a batch belongs to the thread that opened it. Every call may raise NotFound, and what
    Client says."""

    def __init__(self, session: Session, name: str):
        super().__init__(session, name)
        self._batch: Optional[Batch] = None

    def __repr__(self) -> str:
        return f"<scene {self.name} at {self._connection.endpoint}>"

    def info(self) -> SceneInfo:
        """Its size, bounds and revision."""
        return SceneInfo.of(self._connection.call("GetScene", _proto.GetSceneRequest(name=self.name)).scene)

    def stats(self) -> SceneStats:
        """How much of its trees is built. Walks what is built: not for every frame."""
        return SceneStats.of(self._connection.call("GetSceneStats", _proto.GetSceneStatsRequest(scene=self.name)))

    def delete(self) -> None:
        """Deletes the scene with all its nodes."""
        self._session.delete_scene(self.name)

    def render(self, size: "Tuple[int, int]" = (640, 480), *, eye: Any = None, at: Any = None, up: Any = None,
               fov: float = 40.0, fields: "_types.Words" = (), under: Nodes = 0, exclude: Nodes = (),
               at_least: Optional[str] = None, revision: Optional[int] = None, timeout: Optional[float] = None,
               progress: _types.Progress = False) -> Picture:
        """A picture, width x height, of closest hits shaded by their normals; a notebook displays it.

        eye, at, up: (3) in scene coordinates; default: the whole scene is seen from above a corner. fov: degrees from
        the bottom to the top. fields: columns of the picture's hits beside those of geometry, such as ("position",
        "name"). under, exclude, at_least, revision, timeout, progress: as for cast.
        """
        return render(self.info(), self.cast, size, eye, at, up, fov, fields, under=under, exclude=exclude,
                      at_least=at_least, revision=revision, timeout=timeout, progress=progress)

    # ---- trees

    def prefetch(self, rays: Any = None, *, points: Any = None, max_distance: Any = None, under: Nodes = (),
                 exclude: Nodes = (), kind: str = "closest", timeout: Optional[float] = None,
                 progress: _types.Progress = False) -> PrefetchReport:
        """Builds trees before rays come: all of them, or those of the nodes `under` and of those under them, but not
        `exclude`; both take labels as in cast().

        rays, as cast() takes an array or a SphericalScan, Pinhole or VisibilityPairs, or points, as closest() takes an
        array with max_distance, or a PointGrid: builds only what a query of them of this kind would build; then `under`
        is one node at most. What is built stays, also if the call is cancelled. timeout: seconds for each call, of
        16,384 rays or points at most. progress: of triangles, or of rays and points. Errors: ValueError, TypeError,
        rays and points together, none of them, or of another form; ResourceExhausted (TOO_MANY_PREFETCHES).
        """
        if rays is not None and points is not None:
            raise TypeError("pass either rays or points")
        if points is None and max_distance is not None:
            raise TypeError("max_distance belongs to points")
        chosen = self._choose(under, exclude)
        request = _proto.PrefetchRequest(scene=self.name, exclude=chosen.exclude,
                                         roots=[root for root in chosen.under if root])
        select(request, chosen.only_labels, chosen.exclude_labels)
        source = None
        if rays is not None:
            if isinstance(rays, PointGrid):
                raise TypeError("a PointGrid is passed as points, not as rays")
            source = rays if is_generated(rays) else as_rays(rays)
        elif points is not None:
            if is_generated(points):
                check_grid(points, max_distance, None)
            source = points if is_generated(points) else as_points(points, max_distance)
        with Amount(progress, "triangles" if source is None else "rays" if points is None else "points") as amount:
            return prefetch(self._connection, request, source, kind, timeout, amount)

    def cool(self) -> int:
        """Drops its trees, and those of its meshes, which other scenes may share; rays grow them again. Returns about
        how many bytes they took."""
        return int(self._connection.call("CoolScene", _proto.CoolSceneRequest(scene=self.name)).bytes_freed)

    def deferred_cells(self, most: int = 4096) -> DeferredCells:
        """Where it is not built yet: the boxes of the largest cells of trees that no ray has entered, at most 4,096.
        Walks the scene and what is built. Errors: ValueError, `most` is not from 1 to 4,096."""
        if not 1 <= most <= 4096:
            raise ValueError(f"most is from 1 to 4096, not {most}")
        answer = self._connection.call("ListDeferredCells", _proto.ListDeferredCellsRequest(scene=self.name, max_cells=most))
        boxes = np.frombuffer(answer.boxes, "<f4").reshape(-1, 2, 3).copy()
        return DeferredCells(boxes, answer.total, answer.served.revision)

    # ---- nodes

    def nodes(self, ids: "Optional[Iterable[AnyNode]]" = None, *, at_least: Optional[str] = None,
              revision: Optional[int] = None) -> "List[NodeInfo]":
        """Names, parents, transforms, meshes of nodes by id; one that does not exist has id 0. Without ids: of all
        nodes at the newest revision, by id, which takes a call for each 512. Errors: ValueError, at_least or revision
        without ids; Aborted, the scene changes faster than all can be read."""
        if ids is not None:
            return read_nodes(self._connection, self.name, updates.ids(ids), at_least, revision)
        if at_least is not None or revision is not None:
            raise ValueError("all nodes are those of the newest revision: leave out at_least and revision")
        return list(self._table().nodes)

    def find(self, name: str) -> NodeInfo:
        """The one node that a name stands for. "hook" is the name of a node; "crane/hook" is that of one below a
        "crane", and "/crane/hook" of one below a root. If no node has the name, *, ? and [...] match as in names of
        files. All nodes are read once for each revision. Errors: NotFound, with what may have been meant; ValueError,
        several nodes have it."""
        table = self._table()
        number = table.find(name)
        return next(node for node in table.nodes if node.id == number)

    def find_all(self, name: str) -> "List[NodeInfo]":
        """The nodes that a name or pattern stands for, as of find(), by id; none: an empty list."""
        return list(self._table().matching(name))

    def read_mesh(self, node: AnyNode) -> NodeMesh:
        """The mesh of a node as it is now, in the mesh's own frame; of a Node object with an `origin`, that of its
        mesh_node. Errors: NotFound; FailedPrecondition (NODE_WITHOUT_MESH); Aborted, it changes faster than it can be
        read."""
        chosen = self.find(node) if isinstance(node, str) else node.mesh_node if isinstance(node, Node) else node
        return read_mesh(self._connection, self.name, updates.ids([chosen])[0])

    def add(self, mesh: Any = None, *, name: str = "", parent: Any = 0, transform: Any = None,
            origin: Any = (0.0, 0.0, 0.0), mobility: Optional[str] = None, mask: Optional[int] = None,
            labels: "Optional[Mapping[str, str]]" = None) -> Node:
        """A new node, under `parent` (0: a root), and its mesh; None: a group.

        mesh: (vertices (v, 3), faces (f, 3)), or an object that has both, as trimesh's; or a trimesh.Scene, whose nodes
        are put under this one, all as one revision. Vertices are kept as float32; with `origin` (3), a point near them,
        about a point of the scene's lattice, where meshes that share vertices still share them, and by a node of its
        own below the new one if that point is not zero (Node.mesh_node). transform: (3, 4) or (4, 4), parent from
        local. mobility: "static", "rigid", "deforming". mask: 32 bits, of which rays need one. labels: facts about the
        node as values by keys, such as {"class": "IfcWindow"}, by which queries select; those of a trimesh.Scene are
        of this node, not of those under it. Errors: TypeError, ValueError (not a mesh, a transform, labels),
        InvalidArgument (no ray can be transformed into its frame, labels beyond a limit), NotFound (the parent).
        """
        options: "Dict[str, Any]" = {"name": name, "parent": parent, "transform": transform, "mobility": mobility,
                                     "mask": mask, "labels": labels}
        if is_hierarchy(mesh):
            return add_hierarchy(self, mesh, **options)
        if mesh is None:
            return self.put("", **options)
        point = tuple(np.asarray(origin, "f8").reshape(3).tolist())
        if not any(point):
            return self.put(upload(self._connection, as_mesh(mesh)), **options)
        digest, placement = self._upload(mesh)
        self._session.lattice(self.name).added[digest, point] = placement
        return self._put(digest, placement, **options)

    def _upload(self, mesh: Any) -> "Tuple[str, Optional[Placement]]":
        """Sends a mesh that is kept on the scene's lattice."""
        made = as_mesh(mesh, self._session.lattice(self.name))
        return upload(self._connection, made), made.placement

    def put(self, digest: str, *, name: str = "", parent: Any = 0, transform: Any = None,
            origin: Any = (0.0, 0.0, 0.0), mobility: Optional[str] = None, mask: Optional[int] = None,
            labels: "Optional[Mapping[str, str]]" = None) -> Node:
        """A new node with a mesh that the server has, by its digest; "": a group. origin: as given to the add() of this
        program that sent the mesh, or Node.origin of its node."""
        point = tuple(np.asarray(origin, "f8").reshape(3).tolist())
        placement = Placement(np.array(point), math.inf) if digest and any(point) else None
        return self._put(digest, self._session.lattice(self.name).added.get((digest, point), placement), name=name,
                         parent=parent, transform=transform, mobility=mobility, mask=mask, labels=labels)

    def _put(self, digest: str, placement: "Optional[Placement]", *, name: str, parent: AnyNode, transform: Any,
             mobility: Optional[str], mask: Optional[int], labels: "Optional[Mapping[str, str]]") -> Node:
        """A node, and one below it for a mesh that is placed, so that every move of the node moves the mesh with it."""
        alias = self._batch.next_alias() if self._batch else -1
        node = Node(self, alias)
        made = [node]
        changes: "List[updates.Update]" = [updates.put_node(alias, updates.ids([parent])[0], name, transform,
                                                          digest if placement is None else "", mobility, mask, labels)]
        if placement is not None:
            made.append(node.placed(alias - 1, placement))
            changes.append(updates.put_node(alias - 1, alias, name, translation(placement.origin), digest, mobility,
                                            mask))
        self._change(changes, made)
        return node

    def set_transforms(self, nodes: Iterable[AnyNode], transforms: Any) -> None:
        """Moves nodes to transforms (n, 3, 4) or (n, 4, 4), float64, parent from local."""
        self._change(updates.set_transforms(nodes, transforms), [])

    def patch_vertices(self, nodes: Iterable[AnyNode], vertices: Any, first: int = 0) -> None:
        """Moves vertices (n, 3), from number `first` on, of the one mesh that the nodes have: in what the mesh's
        vertices were given in if the nodes are Node objects; of ids, in the mesh's own frame. Errors: ValueError, Node
        objects of different `origin`; InvalidArgument, a node without a mesh."""
        self._change(patches(nodes, first, vertices), [])

    def delete_node(self, node: AnyNode, subtree: bool = False) -> None:
        """Errors: FailedPrecondition, it has children and `subtree` is not set; the node that holds the mesh of a Node
        object with an `origin` does not count."""
        changes: "List[updates.Update]" = [updates.delete_node(node, subtree)]
        if isinstance(node, Node) and node.mesh_node is not node and not subtree:
            changes.insert(0, updates.delete_node(node.mesh_node, False))
        self._change(changes, [])

    def apply(self, changes: "Iterable[updates.Update]", expected_revision: Optional[int] = None) -> Applied:
        """Applies changes of sightline.updates as one revision; all or none, and once, even if the call is repeated. Those
        that a watch tells fit another scene of the same nodes, but that a PutNode of a new node needs an alias. Errors:
        TypeError, what is no change; Aborted, the scene is not at the expected revision; those of the changes."""
        return apply(self._connection, self.name, changes, expected_revision)

    def batch(self, expected_revision: Optional[int] = None) -> Batch:
        """Within `with scene.batch() as batch:` the changes of nodes are collected, and applied at its end as one
        revision, `batch.applied`; all or none. After an exception in it none is. Errors at its end: Aborted, the scene
        is not at the expected revision; those of the changes."""
        return Batch(self._connection, self.name, expected_revision, self._hold)

    def _hold(self, batch: Optional[Batch]) -> None:
        if batch is not None and self._batch is not None:
            raise RuntimeError("the scene has an open batch")
        self._batch = batch

    def _change(self, changes: "Iterable[updates.Update]", made: "List[Node]") -> None:
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
