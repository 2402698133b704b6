"""Types of arrays, and of what many calls take."""

from __future__ import annotations

import os
from typing import Any, Callable, Dict, Iterable, Literal, Optional, Protocol, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray


class HasRows(Protocol):
    """Rays, Points, or what a server makes some of."""

    @property
    def count(self) -> int: ...


Array = NDArray[Any]
Bools = NDArray[np.bool_]
Bytes = NDArray[np.uint8]
Doubles = NDArray[np.float64]
Floats = NDArray[np.float32]
Int64s = NDArray[np.int64]
Objects = NDArray[np.object_]
UInt32s = NDArray[np.uint32]
UInt64s = NDArray[np.uint64]

Kind = Literal["closest", "any", "count"]  # the kinds of queries with a row for each ray or point
Path = Union[str, "os.PathLike[str]"]
Progress = Union[bool, Callable[[int, Optional[int]], Any]]  # a bar by tqdm, or a function of (done, total)
NameLookup = Callable[[Array, int], Dict[int, str]]          # names of nodes by id, at a revision
Rows = Union[ArrayLike, "HasRows", None]                     # arrays of rays or points, or what has or makes them
Words = Union[str, Iterable[str]]
