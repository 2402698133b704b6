"""Labels of nodes: facts about them as keys and values, of which queries select nodes."""

from __future__ import annotations

import dataclasses
from typing import Any, Dict, Iterable, List, Mapping, Optional

from . import _proto


@dataclasses.dataclass(frozen=True)
class Label:
    """Stands for the nodes that have a label with this key and this value (None: any), and for those under them,
    where a query takes `under` or `exclude`."""

    key: str
    value: Optional[str] = None


def checked(labels: "Optional[Mapping[str, str]]") -> "Dict[str, str]":
    """A node's labels, values by keys. TypeError: they are no mapping of strings."""
    if labels is None:
        return {}
    if not isinstance(labels, Mapping):
        raise TypeError(f"labels are a dict of strings, not {labels!r}")
    made = dict(labels)
    for key, value in made.items():
        if not isinstance(key, str) or not isinstance(value, str):
            raise TypeError(f"labels are a dict of strings, not of {key!r}: {value!r}")
    return made


def encode(labels: "Mapping[str, str]") -> "List[Any]":
    """A node's labels as messages."""
    return [_proto.Label(key=key, value=value) for key, value in labels.items()]


def decode(labels: "Iterable[Any]") -> "Dict[str, str]":
    """A node's labels, of messages."""
    return {label.key: label.value for label in labels}


def select(request: Any, only: "Iterable[Label]", exclude: "Iterable[Label]") -> None:
    """Puts into the request of a query which labels its nodes have, and which not."""
    request.only_labels.extend(map(_match, only))
    request.exclude_labels.extend(map(_match, exclude))


def _match(label: Label) -> Any:
    return _proto.LabelMatch(key=label.key, value=label.value)
