"""What the queries of a scene share: nodes by name, and who casts."""

from __future__ import annotations

import functools
from typing import Any, Callable, Dict, Iterable, Iterator, List, Optional, Tuple, Union

from . import _out, updates
from ._caster import Answered, Caster
from ._connection import Connection
from ._generated import Generated
from ._node_table import NodeTable, read_nodes, read_table
from ._progress import reporter
from ._query import Query
from ._session import Session
from ._types import Array, Progress
from .batch import Batch, request_of
from .label import Label
from .node_info import NodeInfo
from .nodes import Node

AnyNode = Union[Node, NodeInfo, int, str]  # one of these, its id, or its name or a pattern
Nodes = Union[AnyNode, Label, Iterable[Union[AnyNode, Label]]]
Changes = Union[Batch, Iterable[updates.Update], None]


class Chosen:
    """The nodes that a query is about, as ids or by labels. at_least: a token, if the answer must not be older than
    their names."""

    def __init__(self, under: "List[int]", exclude: "List[int]", at_least: Optional[str],
                 only_labels: "List[Label]", exclude_labels: "List[Label]"):
        self.under, self.exclude, self.at_least = under, exclude, at_least
        self.only_labels, self.exclude_labels = only_labels, exclude_labels


class Queried:
    """A scene by its name. Threads: any."""

    def __init__(self, session: Session, name: str):
        self.name = name  #: projects/{project}/scenes/{scene}
        self._session = session
        self._connection: Connection = session.connection

    def _names(self, ids: Array, revision: int) -> "Dict[int, str]":
        """Names of nodes by id."""
        return {node.id: node.name for node in read_nodes(self._connection, self.name, ids.tolist(), revision=revision)}

    def _table(self) -> NodeTable:
        """All nodes at the newest revision."""
        known = self._session.node_tables
        table = known[self.name] = read_table(self._connection, self.name, known.get(self.name))
        return table

    def _choose(self, under: Nodes, exclude: Nodes, revision: Optional[int] = None, at_least: Optional[str] = None,
                has_updates: bool = False) -> Chosen:
        """Nodes by their ids, and labels. Names are looked up at the newest revision. Errors: NotFound, ValueError,
        Unimplemented, by what is wrong."""
        roots, only_labels = _parted(under)
        others, exclude_labels = _parted(exclude)
        if only_labels or exclude_labels:
            self._session.check_feature("labels")
        if not any(isinstance(node, str) for node in (*roots, *others)):
            return Chosen(updates.ids(roots), updates.ids(others), at_least, only_labels, exclude_labels)
        table = self._table()
        if revision not in (None, table.revision):
            raise ValueError(f"names of nodes are those of the newest revision, {table.revision}: with "
                             f"revision={revision} pass ids")
        chosen = [table.find(node) if isinstance(node, str) else updates.ids([node])[0] for node in roots]
        left_out: "List[int]" = []
        for node in others:
            left_out += table.outermost(table.find_all(node)) if isinstance(node, str) else updates.ids([node])
        if at_least is None and revision is None and not has_updates:
            at_least = table.token
        return Chosen(chosen, list(dict.fromkeys(left_out)), at_least, only_labels, exclude_labels)

    def _caster(self, query: Query, timeout: Optional[float],
                check: "Callable[[Session, str, Any, str], None]") -> Caster:
        return Caster(self._connection, self._session.max_rays_per_request(), query, timeout, self._names,
                      functools.partial(check, self._session, self.name))

    def _ask(self, caster: Caster, query: Query, rows: Any, changes: Changes, out: Optional[_out.Out],
             progress: Progress, unit: str) -> Answered:
        """The answer for an array, or for what the server makes."""
        columns = _out.columns_of(out, query, rows.shape)
        with reporter(progress, rows.count, unit) as report:
            hits = caster.cast(rows, report, columns)
        if isinstance(changes, Batch) and hits.applied is not None:
            changes.end_request(hits.applied)
        return hits

    def _ask_iterator(self, caster: Caster, batches: "Iterator[Any]", progress: Progress,
                      unit: str) -> "Iterator[Answered]":
        with reporter(progress, None, unit) as report:
            yield from caster.cast_batches(batches, report)

    def _add_updates(self, query: Query, changes: Changes, rows: Any) -> None:
        if changes is None:
            return
        if is_iterator(rows):
            raise ValueError("apply goes with one array, not with an iterator of them")
        if query.request.HasField("consistency"):
            raise ValueError("apply makes the revision that answers: leave out at_least and revision")
        if isinstance(changes, Batch) and changes.scene_name != self.name:
            raise ValueError(f"apply is a batch of {changes.scene_name}, not of {self.name}")
        request = changes.request() if isinstance(changes, Batch) else request_of("", changes)
        query.request.apply.CopyFrom(request)


def as_list(nodes: Nodes) -> "List[Any]":
    """One node, or several, as a list."""
    return [nodes] if isinstance(nodes, (str, Label)) or hasattr(nodes, "__index__") else list(nodes)


def _parted(nodes: Nodes) -> "Tuple[List[Any], List[Label]]":
    """The nodes, and the labels."""
    given = as_list(nodes)
    return ([node for node in given if not isinstance(node, Label)], [node for node in given if isinstance(node, Label)])


def one_root(chosen: Chosen) -> int:
    """ValueError: `under` has several nodes."""
    if len(chosen.under) > 1:
        raise ValueError(f"under is one node, not {len(chosen.under)}")
    return chosen.under[0] if chosen.under else 0


def is_iterator(rows: Any) -> bool:
    """Whether it gives arrays one after the other."""
    return hasattr(rows, "__next__")


def refuse_out(out: Optional[_out.Out]) -> None:
    """ValueError: an iterator is asked about, and there is an `out`."""
    if out:
        raise ValueError("an iterator has no out: each of its batches has an answer of its own")


def refuse_beside(made: Any, **beside: Any) -> None:
    """TypeError: beside what the server makes, or what has its own, there is something of this."""
    given = [name for name, value in beside.items() if value is not None]
    if given:
        raise TypeError(f"{type(made).__name__} has its own {' and '.join(given)}")


def is_generated(rows: Any) -> bool:
    """Whether the server makes them."""
    return isinstance(rows, Generated)
