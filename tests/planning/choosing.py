"""Which replica a request goes to, one request at a time."""
import math

from ring import Ring


class RoundRobin:
    """The next replica in turn, whatever the scene."""

    def __init__(self, replicas):
        self._replicas, self._next = replicas, 0

    def choose(self, scene, in_flight):
        chosen = self._next
        self._next = (chosen + 1) % self._replicas
        return chosen


class Hashing:
    """Always the owner of the scene."""

    def __init__(self, replicas):
        self._ring, self._owners = Ring(range(replicas)), {}

    def choose(self, scene, in_flight):
        if scene not in self._owners:
            self._owners[scene] = int(self._ring.owners([scene])[0])
        return self._owners[scene]


class Bounded:
    """The first replica in the scene's order that has fewer requests in flight than its slots (Mirrokni, Thorup and Zadimoghaddam). Slots
    are as of HAProxy's hash-balance-factor: `bound` times all requests, rounded up, shared out evenly, and one at least."""

    def __init__(self, replicas, bound):
        self._ring, self._bound, self._orders = Ring(range(replicas)), bound, {}

    def slots(self, replica, in_flight):
        """With the request that comes."""
        total, count = math.ceil(self._bound * (sum(in_flight) + 1)), len(in_flight)
        return max(1, (replica + 1) * total // count - replica * total // count)

    def choose(self, scene, in_flight):
        if scene not in self._orders:
            self._orders[scene] = list(self._ring.preference(scene))
        return next(replica for replica in self._orders[scene] if in_flight[replica] < self.slots(replica, in_flight))


def chooser(policy, replicas, bound):
    if policy == "round_robin":
        return RoundRobin(replicas)
    return Hashing(replicas) if policy == "hashing" else Bounded(replicas, bound)
