"""Memory that a client shares with a server on the same machine, so that rays and answers are not copied."""

from __future__ import annotations

import math
import weakref
from typing import TYPE_CHECKING, NamedTuple, Sequence, Union

import numpy as np
from numpy.typing import DTypeLike

from . import errors

if TYPE_CHECKING:
    from ._segment import Segment


class Transport(NamedTuple):
    """How rays and answers of large casts go to the server and back: "messages" or "segments", memory that both have;
    and why, for people."""

    kind: str
    reason: str


class SharedMemory:
    """Memory for the columns of casts, from Client.share_memory(). Arrays in one such memory are not copied, where they
    are contiguous and of a type that casts take: origins and directions (..., 3), tmin, tmax, masks, points, and the arrays
    of `out`. The others of the cast are copied. While a cast runs, do not write to its rays.

    After a cast that was cancelled, or whose deadline passed or connection broke, the server may still write to arrays of
    its `out` that lie here: the cast fails, the memory is not shared any more, and later casts refuse an `out` in it.
    Threads: any."""

    def __init__(self, segment: "Segment"):
        self._segment = segment

    def __repr__(self) -> str:
        return f"<shared memory of {self.size} bytes{'' if self.is_shared else ', not shared: ' + self.why_not_shared}>"

    @property
    def size(self) -> int:
        """In bytes; at least as many as were asked for."""
        return self._segment.size

    @property
    def is_shared(self) -> bool:
        """Whether the server has it, as far as is known. Otherwise it is memory like other memory."""
        return self._segment.is_shared

    @property
    def why_not_shared(self) -> str:
        """For people; empty if it is shared."""
        return self._segment.why_not_shared

    def empty(self, shape: "Union[int, Sequence[int]]", dtype: DTypeLike = "f8") -> np.ndarray:
        """As numpy.empty(), in this memory. It takes its bytes, rounded up to a multiple of 64, until the array and its
        views are gone. Errors: ResourceExhausted, no free part is as large; FailedPrecondition (MEMORY_ABANDONED), the
        server may still write to the memory; ValueError, a type of Python objects."""
        kind = np.dtype(dtype)
        if kind.hasobject:
            raise ValueError(f"{kind} has Python objects, which cannot be shared")
        sizes = (shape,) if isinstance(shape, (int, np.integer)) else tuple(shape)
        if any(size < 0 for size in sizes):
            raise ValueError(f"a shape has no negative sizes, as {sizes} has")
        count = math.prod(int(size) for size in sizes)
        segment, size = self._segment, count * kind.itemsize
        offset = segment.take(size)
        if offset is None and segment.is_abandoned:
            raise errors.FailedPrecondition(f"{segment.why_not_shared}: share new memory", "MEMORY_ABANDONED")
        if offset is None:
            raise errors.ResourceExhausted(f"{size} bytes do not fit the free parts of a shared memory of {self.size} bytes")
        # Its own base, so that it is alive as long as any of its views.
        owner = np.frombuffer(memoryview(segment.bytes)[offset:offset + size], kind) if count else np.empty(0, kind)
        weakref.finalize(owner, segment.release, offset, size).atexit = False
        return owner.reshape(sizes)
