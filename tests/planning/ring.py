"""Consistent hashing: replicas own arcs of a ring, so that a replica that goes or comes moves its own scenes only."""
import numpy as np

POINTS = 64  # arcs of one replica
_ONE, _TWO = np.uint64(0xBF58476D1CE4E5B9), np.uint64(0x94D049BB133111EB)


def mix(values, salt):
    """Places on the ring: 64 bits that depend on all bits of a number (the finaliser of splitmix64)."""
    with np.errstate(over="ignore"):
        x = np.asarray(values, np.uint64) + np.uint64(salt) * np.uint64(0x9E3779B97F4A7C15)
        x = (x ^ (x >> np.uint64(30))) * _ONE
        x = (x ^ (x >> np.uint64(27))) * _TWO
        return x ^ (x >> np.uint64(31))


class Ring:
    """The arcs of these replicas. Where an arc lies depends on its replica's number alone."""

    def __init__(self, replicas):
        self.replicas = list(replicas)
        ids = np.repeat(np.asarray(self.replicas, np.uint64), POINTS)
        places = mix(ids * np.uint64(POINTS) + np.tile(np.arange(POINTS, dtype=np.uint64), len(self.replicas)), 1)
        order = np.argsort(places)
        self._places, self._owners = places[order], ids[order].astype(int)

    def _first_arcs(self, scenes):
        return np.searchsorted(self._places, mix(scenes, 2)) % len(self._places)

    def owners(self, scenes):
        """The replica of each scene."""
        return self._owners[self._first_arcs(scenes)]

    def preference(self, scene):
        """All replicas, in the order in which a scene asks them: its owner first."""
        begin, seen = int(self._first_arcs([scene])[0]), set()
        for step in range(len(self._owners)):
            owner = int(self._owners[(begin + step) % len(self._owners)])
            if owner not in seen:
                seen.add(owner)
                yield owner
