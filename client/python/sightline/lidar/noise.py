"""Errors of measured ranges, by a seed and the number of the ray, so that they do not depend on how rays are put
together."""

from __future__ import annotations

import math
import operator
from typing import Any

import numpy as np
from numpy.typing import NDArray

_WORDS = 4  # of 64 bits, that the generator makes for each ray


class RangeNoise:
    """Noise of ranges, and rays that are lost.

    The measured range is normally distributed about the true one, with the standard deviation sigma + growth * range,
    and rounded to a multiple of `resolution` (0: not rounded); a share `dropout` of the rays returns nothing. sigma,
    resolution: units of the scene. seed: 0 to 2**128 - 1. The errors of a ray depend on the seed and on the ray's
    number alone, column * beams + beam: two sweeps of one revolution each, or many of a few columns, have the same.
    They come from the generator Philox. Errors: ValueError, TypeError: a number out of its range."""

    def __init__(self, seed: int, *, sigma: float = 0.0, growth: float = 0.0, dropout: float = 0.0,
                 resolution: float = 0.0):
        self.seed = operator.index(seed)
        if not 0 <= self.seed < 1 << 128:
            raise ValueError(f"seed is from 0 to 2**128 - 1, not {seed}")
        for name, value in (("sigma", sigma), ("growth", growth), ("resolution", resolution)):
            if not (value >= 0 and math.isfinite(value)):
                raise ValueError(f"{name} is finite and not below 0, as {value} is")
        if not 0 <= dropout <= 1:
            raise ValueError(f"dropout is a share from 0 to 1, not {dropout}")
        self.sigma, self.growth, self.dropout, self.resolution = sigma, growth, dropout, resolution

    def measured(self, first: int, ranges: NDArray[Any]) -> NDArray[Any]:
        """What is measured of the true ranges (n) of rays from number `first` on; +inf: nothing, as where the range is
        +inf."""
        generator = np.random.Philox(counter=operator.index(first), key=self.seed)
        words = generator.random_raw(_WORDS * len(ranges)).reshape(-1, _WORDS)
        # Normal by Box and Muller: of two uniform numbers, the first above 0.
        size = np.sqrt(-2 * np.log(_uniform(words[:, 0], 1)))
        normal = size * np.cos(2 * math.pi * _uniform(words[:, 1], 0))
        is_there = np.isfinite(ranges)
        true = np.where(is_there, ranges, 0.0)
        found = true + normal * (self.sigma + self.growth * true)
        if self.resolution:
            found = np.rint(found / self.resolution) * self.resolution
        is_there &= _uniform(words[:, 2], 0) >= self.dropout
        return np.where(is_there, found, np.inf)


def _uniform(words: NDArray[Any], above: int) -> NDArray[Any]:
    """Multiples of 2**-53, from 0 up to, not including, 1, or one such step above."""
    return ((words >> np.uint64(11)).astype("f8") + above) * 2.0 ** -53
