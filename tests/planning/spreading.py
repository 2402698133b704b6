"""Which share of each scene's requests each replica gets in the long run, for many requests at once."""
import dataclasses

import numpy as np

from ring import Ring


@dataclasses.dataclass(frozen=True)
class Spread:
    """Columns of one length: replica `replica` gets `share` of all requests, those of `scene`. `alike` replicas are like
    each one that is listed."""
    scene: np.ndarray
    replica: np.ndarray
    share: np.ndarray
    replicas: int
    alike: int = 1


def spread(popularity, replicas, policy, bound):
    scenes = np.arange(len(popularity))
    if policy == "round_robin":
        return Spread(scenes, np.zeros_like(scenes), popularity / replicas, 1, replicas)
    ring = Ring(range(replicas))
    if policy == "hashing":
        return Spread(scenes, ring.owners(scenes), popularity, replicas)
    return _spread_bounded(popularity, ring, bound)


def _spread_bounded(popularity, ring, bound):
    """Scenes fill replicas in their order, each to the bound; the most popular first, as they are always there."""
    room = np.full(len(ring.replicas), bound / len(ring.replicas))
    scene, replica, share = [], [], []
    for number, left in enumerate(popularity):
        for chosen in ring.preference(number):
            part = min(left, room[chosen])
            if part <= 0:
                continue
            room[chosen] -= part
            left -= part
            scene.append(number)
            replica.append(chosen)
            share.append(part)
            if left <= 1e-15:
                break
    return Spread(np.array(scene), np.array(replica), np.array(share), len(ring.replicas))
