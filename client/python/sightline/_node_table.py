"""The nodes of a scene by name: those that a word or a pattern stands for.

A word is a node's name, or several names parted by slashes, each of a child of the one before; after a slash at the
front, the first is a root. A pattern has *, ? or [...] as file names have them; one without a slash is about names, one
with slashes about names from a root down.
"""

from __future__ import annotations

import difflib
import fnmatch
import re
from typing import Dict, Iterable, List, Optional

from . import _proto, errors
from ._connection import Connection
from ._query import set_consistency
from ._retries import sleep
from .node_info import NodeInfo
from .scene_info import SceneInfo

MOST_NODES = 512  # in one BatchGetNodes
_LONGEST_GAP = 1_000_000  # ids without a node, after which there are no more: ids are given in order, and never again
_ATTEMPTS = 4  # to read all nodes at one revision
_PAUSE = 0.05  # seconds between them
_SHOWN = 8  # ids in an error
_SPECIAL = re.compile(r"[*?[]")


class NodeTable:
    """All nodes of a scene, as one revision has them, by id."""

    def __init__(self, revision: int, token: str, nodes: "List[NodeInfo]"):
        self.revision, self.token = revision, token
        self.nodes = nodes
        self._by_id: "Dict[int, NodeInfo]" = {node.id: node for node in nodes}
        self._by_name: "Dict[str, List[NodeInfo]]" = {}
        for node in nodes:
            self._by_name.setdefault(node.name, []).append(node)

    def find(self, word: str) -> int:
        """The id of the one node of this name, or that matches this pattern. Errors: ValueError, several do;
        NotFound."""
        found = self.find_all(word)
        if len(found) > 1:
            shown = " ".join(str(node.id) for node in found[:_SHOWN])
            more = " ..." if len(found) > _SHOWN else ""
            raise ValueError(f"{len(found)} nodes are {word!r}: name one by its id ({shown}{more})")
        return found[0].id

    def find_all(self, word: str) -> "List[NodeInfo]":
        """Those of matching(). Errors: also NotFound, none."""
        found = self.matching(word)
        if not found:
            near = difflib.get_close_matches(word, {name for name in self._by_name if name}, 1)
            meant = f", did you mean {near[0]!r}?" if near else ""
            raise errors.NotFound(f"there is no node {word!r}{meant}", "NODE_NOT_FOUND")
        return found

    def matching(self, word: str) -> "List[NodeInfo]":
        """The nodes of this name; if there are none and it is a pattern, those that match it. Errors: ValueError, an
        empty word."""
        if not word:
            raise ValueError("a node is named by an id or a name, which is not empty")
        found = self._named(word)
        if not found and _SPECIAL.search(word):
            fits = re.compile(fnmatch.translate(word if "/" not in word or word.startswith("/") else "*/" + word)).match
            found = [node for node in self.nodes if fits(self._path(node) if "/" in word else node.name)]
        return found

    def outermost(self, nodes: "Iterable[NodeInfo]") -> "List[int]":
        """The ids of those that are not under others of them."""
        chosen = {node.id for node in nodes}
        return [number for number in chosen if not any(above in chosen for above in self._above(number))]

    def _named(self, word: str) -> "List[NodeInfo]":
        """By a name, which may have slashes of its own, or by the names of the nodes above, too."""
        if "/" not in word:
            return self._by_name.get(word, [])
        if word.startswith("/"):
            return [node for node in self.nodes if node.name == word or self._path(node) == word]
        return [node for node in self.nodes if self._path(node).endswith("/" + word)]

    def _path(self, node: NodeInfo) -> str:
        names = [node.name, *(self._by_id[above].name for above in self._above(node.id))]
        return "/" + "/".join(reversed(names))

    def _above(self, number: int) -> "Iterable[int]":
        node: Optional[NodeInfo] = self._by_id.get(number)
        while node is not None and node.parent:
            node = self._by_id.get(node.parent)
            if node is not None:
                yield node.id


def read_nodes(connection: Connection, scene: str, ids: "List[int]", at_least: Optional[str] = None,
               revision: Optional[int] = None) -> "List[NodeInfo]":
    """Nodes by id; one that does not exist has id 0."""
    found: "List[NodeInfo]" = []
    for at in range(0, len(ids), MOST_NODES):
        request = _proto.BatchGetNodesRequest(scene=scene, ids=ids[at:at + MOST_NODES])
        set_consistency(request, at_least, revision)
        found += map(NodeInfo.of, connection.call("BatchGetNodes", request).nodes)
    return found


def read_table(connection: Connection, scene: str, known: Optional[NodeTable] = None) -> NodeTable:
    """All nodes at the newest revision; `known`, if it is of that. Errors: Aborted, the scene changes faster than it
    can be read."""
    for attempt in range(_ATTEMPTS):
        info = SceneInfo.of(connection.call("GetScene", _proto.GetSceneRequest(name=scene)).scene)
        if known is not None and known.token == info.token:
            return known
        try:
            return NodeTable(info.revision, info.token, _all_nodes(connection, info))
        except errors.OutOfRange:  # not kept any more, or another server does not have it yet
            sleep(_PAUSE * 2 ** attempt)
    raise errors.Aborted(f"{scene} changes faster than its nodes can be read: name nodes by their ids")


def _all_nodes(connection: Connection, info: SceneInfo) -> "List[NodeInfo]":
    nodes: "List[NodeInfo]" = []
    first, last = 1, 0
    while len(nodes) < info.nodes and first - last <= _LONGEST_GAP:
        some = [node for node in read_nodes(connection, info.name, list(range(first, first + MOST_NODES)),
                                            revision=info.revision) if node.id]
        nodes += some
        first, last = first + MOST_NODES, nodes[-1].id if nodes else 0
    if len(nodes) < info.nodes:
        raise errors.Aborted(f"of the {info.nodes} nodes of {info.name} only {len(nodes)} could be found: name nodes by "
                             "their ids")
    return nodes
