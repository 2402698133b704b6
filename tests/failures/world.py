"""The scene of the failure suite, boxes that writers move, and what rays hit in it, found without a tree."""

import numpy as np

WRITERS = 4
BOXES = 8              # of each writer, which moves all of them in each batch
RAYS = 128
_EXTENT = 10.0         # boxes of side 1 have their middles in this cube
_FACES = [[0, 2, 1], [1, 2, 3], [4, 5, 6], [5, 7, 6], [0, 1, 4], [1, 5, 4], [2, 6, 3], [3, 6, 7], [0, 4, 2], [2, 4, 6],
          [1, 3, 5], [3, 7, 5]]
_CORNERS = [[x, y, z] for z in (-0.5, 0.5) for y in (-0.5, 0.5) for x in (-0.5, 0.5)]
BOX = (np.array(_CORNERS), np.array(_FACES))
_TOLERANCE = 1e-9      # of t, which two ways of computing in double may differ by


def middles(writer, sequence):
    """Where a batch puts the boxes of its writer (BOXES, 3). Sequence 0: where they are at first."""
    return np.random.default_rng((writer, sequence)).uniform(0, _EXTENT, (BOXES, 3))


def transforms(writer, sequence):
    """The same as matrices (BOXES, 3, 4)."""
    matrices = np.zeros((BOXES, 3, 4))
    matrices[:, :, :3] = np.eye(3)
    matrices[:, :, 3] = middles(writer, sequence)
    return matrices


def make_rays(seed):
    """Through two points of the cube (RAYS, 6)."""
    generator = np.random.default_rng(seed)
    start, end = generator.uniform(-_EXTENT / 2, 1.5 * _EXTENT, (2, RAYS, 3))
    return np.concatenate([start, end - start], axis=1)


class State:
    """What is where at one revision: `sequences` has the newest batch of each writer in it."""

    def __init__(self, sequences):
        self._middles = np.concatenate([middles(writer, sequence) for writer, sequence in enumerate(sequences)])

    def agrees(self, rays, nodes, hits):
        """Whether hits (t, node) are those of all rays with all boxes. nodes (WRITERS * BOXES): the ids of boxes. A ray whose
        nearest boxes are equally near may have hit any of them."""
        entries = self._entries(rays)
        nearest = entries.min(axis=1)
        t, node = hits
        missed = np.isinf(nearest)
        if not np.array_equal(np.isinf(t), missed):
            return False
        if not np.allclose(t[~missed], nearest[~missed], rtol=_TOLERANCE, atol=_TOLERANCE):
            return False
        columns = np.argmax(nodes[None, :] == node[:, None], axis=1)
        of_node = entries[np.arange(len(rays)), columns]
        known = np.isin(node, nodes)
        return bool(np.all(missed | (known & np.isclose(of_node, nearest, rtol=_TOLERANCE, atol=_TOLERANCE))))

    def _entries(self, rays):
        """(rays, boxes): where each ray meets each box, first, from its start on; infinity: it does not."""
        with np.errstate(divide="ignore"):
            to_low = (self._middles[None] - 0.5 - rays[:, None, :3]) / rays[:, None, 3:]
            to_high = (self._middles[None] + 0.5 - rays[:, None, :3]) / rays[:, None, 3:]
        enter = np.minimum(to_low, to_high).max(axis=2)
        leave = np.maximum(to_low, to_high).min(axis=2)
        first = np.where(enter >= 0, enter, leave)  # a ray that starts inside meets the box where it leaves it
        return np.where((enter <= leave) & (leave >= 0), first, np.inf)
