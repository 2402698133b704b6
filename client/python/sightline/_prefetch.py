"""Building trees before rays come."""

from __future__ import annotations

from typing import Any, Iterator, Optional

import numpy as np

from . import _proto, errors
from ._cast import RAYS_PER_MESSAGE
from ._connection import Connection
from ._generated import Generated
from ._progress import Amount
from ._query import KINDS
from ._retries import sleep
from .point_grid import PointGrid
from .points import Points
from .prefetch_report import PrefetchReport

_ATTEMPTS = 4  # without an answer between them
_FIRST_PAUSE = 0.1  # seconds; doubled after each attempt


def prefetch(connection: Connection, request: Any, source: Any, kind: str, timeout: Optional[float],
             amount: Amount) -> PrefetchReport:
    """See Scene.prefetch. `source`: Rays, Points, a Generated, or None."""
    if kind not in KINDS:
        raise ValueError(f"kind is {', '.join(KINDS)}, not {kind!r}")
    if source is None:
        return _call(connection, request, timeout, amount)
    request.kind = _proto.enum_value(f"QUERY_KIND_{kind.upper()}")
    done: Optional[PrefetchReport] = None
    for part in _parts(source):
        one = type(request)()
        one.CopyFrom(request)
        one.MergeFrom(part)
        report = _call(connection, one, timeout, None)
        done = report if done is None else done.plus(report)
        amount.report(done.rays_done, source.count)
    if done is None:
        raise ValueError("there are no rays or points to build for")
    return done


def _parts(source: Any) -> "Iterator[Any]":
    """Requests with some of the rays or points each."""
    if isinstance(source, Generated):
        field = "grid" if isinstance(source, PointGrid) else "generator"
        for first in range(0, source.count, RAYS_PER_MESSAGE):
            yield _proto.PrefetchRequest(**{field: source.part(first, min(RAYS_PER_MESSAGE, source.count - first))})
        return
    for begin, end in source.slices(RAYS_PER_MESSAGE):
        names = ("positions", "max_distance", "masks") if isinstance(source, Points) else \
            ("origins", "directions", "tmin", "tmax", "masks")
        columns = {name: np.ascontiguousarray(column[begin:end]).tobytes()
                   for name, column in zip(names, source.columns()) if column is not None}
        made = (_proto.Points if isinstance(source, Points) else _proto.Rays)(
            float64=source.dtype.itemsize == 8, count=end - begin, **columns)
        yield _proto.PrefetchRequest(**{"points" if isinstance(source, Points) else "rays": made})


def _call(connection: Connection, request: Any, timeout: Optional[float], amount: Optional[Amount]) -> PrefetchReport:
    failures = 0
    while True:
        try:
            with connection.stream("Prefetch", request, timeout, request.scene) as stream:
                for message in stream:
                    failures = 0
                    if amount is not None:
                        amount.report(message.triangles_done, message.triangles_total)
                    if message.done:
                        return PrefetchReport.of(message)
            raise errors.Unavailable("the server ended the call")
        except errors.Unavailable:
            failures += 1
            if failures == _ATTEMPTS:
                raise
            sleep(_FIRST_PAUSE * 2 ** failures)
