"""A scene: its rays, its closest points, its nodes, its revisions."""

from __future__ import annotations

import dataclasses
import functools
import math
from typing import TYPE_CHECKING, Any, Callable, Dict, Iterable, Iterator, List, Optional, Tuple, Union

import numpy as np

from . import _proto, _query, updates
from ._caster import Caster
from ._connection import Connection
from ._lattice import Placement
from ._precision import warn_of_origins, warn_of_points
from ._progress import reporter
from .batch import Batch, apply
from .hierarchy import add_hierarchy, is_hierarchy
from .hits import AllHits, Hits
from .meshes import as_mesh, upload
from .nodes import Node, patches, translation
from .nearest import AllNearest, Nearest
from .picture import Picture, render
from .points import PointGrid, as_points, check_bounds
from .rays import as_rays
from .update_stream import UpdateStream
from .watch import Change, watch

if TYPE_CHECKING:
    from .client import Client

_MOST_NODES = 512  # in one BatchGetNodes
AnyNode = Union[Node, int]


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


class Scene:
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

    # ---- rays and points

    def cast(self, rays: Any = None, *, origins: Any = None, directions: Any = None, tmin: Any = None,
             tmax: Any = None, masks: Any = None, kind: str = "closest", fields: Optional[Iterable[str]] = None,
             build: Optional[str] = None, cull: Optional[str] = None, under: AnyNode = 0,
             exclude: Iterable[AnyNode] = (), max_hits: int = 0, at_least: Optional[str] = None,
             revision: Optional[int] = None, timeout: Optional[float] = None,
             progress: Union[bool, Callable[[int, Optional[int]], Any]] = False,
             time_budget: Optional[float] = None, allow_partial: bool = False) -> Any:
        """What rays hit.

        rays: real (..., 6), ox oy oz dx dy dz, or (..., 8), and tmin tmax; or origins and directions (..., 3), and
        tmin, tmax, masks (...), which are broadcast to one leading shape. float32 is sent as it is, all else as float64.
        Directions have any length but zero; t counts in it; tmin and tmax are closed bounds. Or an iterator of such
        arrays (or of sightline.Rays): the answer is then an iterator of their hits, all at one revision, and only a few
        batches are in memory; the batches are taken by another thread.

        kind: "closest", "any" (only whether there is a hit), "count" (of distinct (node, primitive)), "all".
        fields: of t node primitive uv normal hit work position name; None: the first five for closest and all. Hits with
        t have positions, and those with node have names, also where these are not named; named, the server sends them.
        build: trees to grow: "lazy" (where rays enter), "full", "none", "built-only"; None: as the server is set.
        cull: "back" or "front", hits that do not count. under: only this node and those under it exist; exclude: these
        and those under them do not. max_hits: for "all", the nearest of a ray; 0: all, however many they are.
        at_least: a token, of hits or of an update, that the answer must not be older than; revision: answer at it.
        time_budget: seconds for the cast on the server; rays without an answer by then are marked (`unanswered`), and
        casting them again goes on from there, since what was built stays. allow_partial: if one of several servers that
        share the scene is lost, rays that need it are marked likewise, and the cast does not fail.
        timeout: seconds. progress: True (a bar by tqdm, if installed) or a function of (done, total).

        Returns Hits, or AllHits for "all", with the leading shape of the rays. Errors: TypeError, ValueError (rays or
        words of another form), OutOfRange (the revision is not kept), DeadlineExceeded, ResourceExhausted (the server
        has too much work, also after a minute of attempts), Unavailable (after some attempts). A ray that is not finite or has no direction is answered
        as invalid, and fails nothing. Warnings: PrecisionWarning, origins are float32 and so far out that float32 does not
        hold them well.
        """
        query = _query.describe(_query.RAYS, self.name, kind, fields, build, cull, updates.ids([under])[0],
                                updates.ids(exclude), max_hits, at_least, revision, time_budget, allow_partial)
        caster = self._caster(query, timeout, warn_of_origins)
        if hasattr(rays, "__next__"):
            return self._cast_iterator(caster, map(as_rays, rays), progress, "rays")
        batch = as_rays(rays, origins, directions, tmin, tmax, masks)
        with reporter(progress, batch.count) as report:
            return caster.cast(batch, report)

    def closest(self, points: Any, max_distance: Any = None, *, masks: Any = None, kind: str = "closest",
                fields: Optional[Iterable[str]] = None, build: Optional[str] = None, under: AnyNode = 0,
                exclude: Iterable[AnyNode] = (), max_hits: int = 0, at_least: Optional[str] = None,
                revision: Optional[int] = None, timeout: Optional[float] = None,
                progress: Union[bool, Callable[[int, Optional[int]], Any]] = False,
                time_budget: Optional[float] = None, allow_partial: bool = False) -> Any:
        """The faces that are nearest to points.

        points: real (..., 3), with which max_distance and masks (...) are broadcast; float32 is sent as it is, all else
        as float64. max_distance, in the scene's units: a face at exactly this distance counts, and none does below 0;
        None: any distance. Or a sightline.PointGrid, whose points the server makes. Or an iterator of such arrays (or
        of sightline.Points): the answer is then an iterator, as of cast(), and max_distance and masks go with each
        array.

        kind: "closest" (the face with the least (distance, node, primitive)), "any" (only whether a face is within
        max_distance), "count" (how many are), "all" (each of them, near to far). max_hits: for "all", the nearest faces
        of a point, at most 16,384: k of them are its k nearest; 0: all within max_distance, up to 16,384, and a warning
        says how many points have more. fields: of distance node primitive uv normal position hit work name; None: the
        first six for closest and all. Answers with node have names, also where these are not named; positions must be.
        build, under, exclude, at_least, revision, timeout, progress, time_budget, allow_partial: as for cast().

        The distance is that from a point to a face as it stands in the scene, rounded once to double; a face without
        area is the segment or the point that it is. Returns Nearest, or AllNearest for "all", with the leading shape of
        the points. Errors: as of cast(), and FailedPrecondition (the server shares its scenes with others),
        Unimplemented (it is of a version without this query). A point or a max_distance that is NaN, or a point that is
        infinite, is answered as invalid, and fails nothing. Warnings: PrecisionWarning, points are float32 and so far
        out that float32 does not hold them well.
        """
        query = _query.describe(_query.POINTS, self.name, kind, fields, build, None, updates.ids([under])[0],
                                updates.ids(exclude), max_hits, at_least, revision, time_budget, allow_partial)
        caster = self._caster(query, timeout, warn_of_points)
        if hasattr(points, "__next__"):
            batches = (as_points(part, max_distance, masks) for part in points)
            return self._cast_iterator(caster, batches, progress, "points")
        if isinstance(points, PointGrid):
            check_bounds(points, max_distance, masks)
        batch = points if isinstance(points, PointGrid) else as_points(points, max_distance, masks)
        with reporter(progress, batch.count, "points") as report:
            return caster.cast(batch, report)

    def _caster(self, query: Any, timeout: Optional[float], check: "Callable[[Scene, Any, str], None]") -> Caster:
        return Caster(self._connection, self.client.max_rays_per_request(), query, timeout, self._names,
                      functools.partial(check, self))

    def _cast_iterator(self, caster: Caster, batches: Iterator[Any], progress: Any,
                       unit: str) -> "Iterator[Union[Hits, AllHits, Nearest, AllNearest]]":
        with reporter(progress, None, unit) as report:
            yield from caster.cast_batches(batches, report)

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
