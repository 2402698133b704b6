"""Arrays of the caller that answers are written to."""

from __future__ import annotations

from typing import Any, Dict, Iterable, Mapping, Optional, Tuple

import numpy as np

from ._query import COLUMNS, Form, Query
from ._types import Array

Out = Mapping[str, Array]


def fields_with(out: Optional[Out], fields: "Optional[Iterable[str]]") -> "Optional[Iterable[str]]":
    """What is asked for: by default what `out` has arrays for."""
    return tuple(out) if out and fields is None else fields


def columns_of(out: Optional[Out], query: Query, shape: "Tuple[int, ...]") -> "Dict[str, Array]":
    """The arrays as columns over all rows, by the names of columns. TypeError, ValueError: they are not of the type or
    shape of the answer, not contiguous, not writable, or not of what is asked for."""
    if not out:
        return {}
    if query.kind == "all":
        raise ValueError("kind 'all' has no out: its answers do not have a row for each ray")
    return {_name(query.form, name): _column(query, name, array, shape) for name, array in out.items()}


def _name(form: Form, name: str) -> str:
    return "t" if name == form.t else name


def _column(query: Query, name: str, array: Any, shape: "Tuple[int, ...]") -> Array:
    known = _name(query.form, name)
    if known not in query.columns or known == "name" or (known == "t") != (name == query.form.t):
        raise ValueError(f"out has {name!r}, which is no array of what is asked for")
    column = COLUMNS[known]
    if not isinstance(array, np.ndarray) or array.dtype != column.dtype:
        raise TypeError(f"out[{name!r}] is a NumPy array of {column.dtype}, not {getattr(array, 'dtype', type(array))}")
    if array.shape != shape + column.row:
        raise ValueError(f"out[{name!r}] has the shape {shape + column.row}, not {array.shape}")
    if not (array.flags.c_contiguous and array.flags.writeable):
        raise ValueError(f"out[{name!r}] is contiguous and writable, which this array is not")
    return array.reshape(-1, *column.row) if array.size else array.reshape(0, *column.row)
