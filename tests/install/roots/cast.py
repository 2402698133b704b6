"""Casts rays at the scene that the command has imported, as a user of the Python package does."""

import os
import time

import numpy
import sightline

start = time.monotonic()
client = sightline.connect(os.environ["SIGHTLINE_ENDPOINT"])
rays = numpy.tile([0.0, 500, 0, 0, -1, 0], (1000, 1))
rays[500:, 4] = 1  # these go away from it
hits = client.scene("engine").cast(rays)
assert numpy.isfinite(hits.t[:500]).all() and numpy.isinf(hits.t[500:]).all(), hits.t
print(f"{numpy.isfinite(hits.t).sum()} hits of {len(rays)} rays, t {hits.t[0]:g}, in {time.monotonic() - start:.2f} s")
print(f"sightline {sightline.__version__} of {os.path.dirname(sightline.__file__)}")
