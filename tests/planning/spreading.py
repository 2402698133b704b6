"""Which share of each scene's requests each replica gets in the long run, for many requests at once."""
import dataclasses
import math

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


_MOST_ASKED = 8  # replicas that a request is offered to by chance; in the mean far fewer


def spill_chance(in_flight, replicas, bound):
    """Bounded: the chance that a replica has no slot free, though its mean load is below the bound. in_flight: the mean of each replica,
    which varies as Poisson's law says. Slots are those of `Bounded` in choosing.py, for the mean of all requests."""
    slots = bound * (in_flight * replicas + 1) / replicas
    low = math.floor(slots)
    chance = lambda taken: 1 - sum(math.exp(-in_flight) * in_flight ** k / math.factorial(k) for k in range(max(1, taken)))
    return (low + 1 - slots) * chance(low) + (slots - low) * chance(low + 1)


def spread(popularity, replicas, policy, bound, spill=0.0):
    """spill: of `spill_chance`, for bounded."""
    scenes = np.arange(len(popularity))
    if policy == "round_robin":
        return Spread(scenes, np.zeros_like(scenes), popularity / replicas, 1, replicas)
    ring = Ring(range(replicas))
    if policy == "hashing":
        return Spread(scenes, ring.owners(scenes), popularity, replicas)
    return _spread_bounded(popularity, ring, bound, spill)


def _spread_bounded(popularity, ring, bound, spill):
    """Scenes fill replicas in their order, each to the bound; the most popular first, as they are always there. Each replica but the last
    that is asked passes on a share `spill`."""
    room = np.full(len(ring.replicas), bound / len(ring.replicas))
    scene, replica, share = [], [], []
    for number, left in enumerate(popularity):
        asked = 0
        for chosen in ring.preference(number):
            if room[chosen] <= 0:
                continue
            asked += 1
            keeps = 1 if asked >= min(_MOST_ASKED, len(room)) else 1 - spill
            part = min(left * keeps, room[chosen])
            room[chosen] -= part
            left -= part
            scene.append(number)
            replica.append(chosen)
            share.append(part)
            if left <= 1e-3 * popularity[number]:
                share[-1] += left
                break
        else:
            share[-1] += left  # all others are full
    return Spread(np.array(scene), np.array(replica), np.array(share), len(ring.replicas))
