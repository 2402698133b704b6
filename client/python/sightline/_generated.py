"""Rays and points that the server makes from a short description."""

from __future__ import annotations

import math
from typing import Any, Dict, Optional, Tuple

from . import _proto
from ._arrays import bits, reals
from ._types import Doubles

MOST_IN_A_ROW = 1 << 20
Triple = Any  # three numbers, in any form that NumPy takes; a tuple of floats once they are checked


class Generated:
    """What a server makes rays or points of, of any number: `shape` is the leading shape of the answers."""

    @property
    def shape(self) -> Tuple[int, ...]:
        raise NotImplementedError

    @property
    def dims(self) -> Tuple[str, ...]:
        """Names of the axes of the answers."""
        raise NotImplementedError

    @property
    def coordinates(self) -> "Dict[str, Tuple[Tuple[str, ...], Doubles]]":
        """Where the rays or points are along the axes: arrays by name, and the axes of each."""
        return {}

    @property
    def count(self) -> int:
        """How many rays or points there are."""
        return math.prod(self.shape)

    def message(self) -> Any:
        """The message that describes all of them."""
        raise NotImplementedError

    def part(self, first: int, count: int) -> Any:
        """The message that describes some of them."""
        message = self.message()
        message.first, message.count = first, count
        return message


def vector(value: Any, name: str) -> "Tuple[float, float, float]":
    """Three finite numbers. Errors: TypeError, ValueError."""
    array = reals(value, name)
    if array.shape != (3,) or not all(map(math.isfinite, array.tolist())):
        raise ValueError(f"{name} has three finite numbers, not {value!r}")
    x, y, z = array.astype("f8").tolist()
    return x, y, z


def size(value: int, name: str) -> int:
    """How many there are along an axis. Errors: ValueError."""
    if not 1 <= value <= MOST_IN_A_ROW:
        raise ValueError(f"{name} is from 1 to {MOST_IN_A_ROW}, not {value}")
    return int(value)


def generator(tmin: Optional[float], tmax: Optional[float], mask: Optional[int], **kind: Any) -> Any:
    """A message RayGenerator. Errors: TypeError, ValueError, a mask that has not 32 bits; ValueError, a bound that is
    NaN."""
    for name, bound in (("tmin", tmin), ("tmax", tmax)):
        if bound is not None and math.isnan(bound):
            raise ValueError(f"{name} is a number, not {bound}")
    bits(mask)
    return _proto.RayGenerator(tmin=tmin, tmax=tmax, mask=mask, **kind)
