"""The event simulation: every request by itself, from its client to a replica that has or lacks its trees."""
import dataclasses
import heapq

import numpy as np

from choosing import chooser
from processor import Processor
from tree_cache import TreeCache
from workload import popularity, reach, scene_triangles


@dataclasses.dataclass
class Tally:
    """`arrived` = answered + refused + in_flight. The others are of what was answered after the first requests."""
    arrived: int = 0
    answered: int = 0
    refused: int = 0
    in_flight: int = 0
    seconds: float = 0.0
    responses_s: np.ndarray = None
    built: float = 0.0            # triangles, of all requests
    warm_share: float = 0.0       # of what requests needed, what was built before they came
    busy: np.ndarray = None       # mean cores in use, for each processor
    evictions: int = 0

    def throughput(self):
        return len(self.responses_s) / self.seconds

    def quantile_ms(self, q):
        return 1e3 * float(np.quantile(self.responses_s, q))


class Simulation:
    """Replicas have processors of their own; with `shared_cores` clients, HAProxy, replicas and PostgreSQL share so many instead, and
    a request costs what it takes of all of them."""

    def __init__(self, costs, workload, fleet, shared_cores=None, queue_limit=10_000):
        self._costs, self._work, self._fleet = costs, workload, fleet
        self._random = np.random.default_rng(workload.seed + 1)
        self._shared, self._limit = shared_cores is not None, queue_limit
        count = 1 if self._shared else fleet.replicas
        self._processors = [Processor(shared_cores or fleet.cores) for _ in range(count)]
        self._caches = [TreeCache(fleet.budget_bytes(), costs.geometry_bytes, costs.tree_bytes) for _ in range(fleet.replicas)]
        self._chooser = chooser(fleet.policy, fleet.replicas, fleet.bound)
        self._triangles = scene_triangles(workload)
        self._reach = reach(workload, self._triangles, costs.piece_triangles)
        self._cumulative = np.cumsum(popularity(workload))
        self._in_flight = [0] * fleet.replicas
        self._ends = []      # (time, processor, version): when a processor's first job ends
        self._versions = [0] * count
        self._number = 0
        self.tally = Tally()

    # ---- what happens

    def run_open(self, requests, skip=0):
        """Requests and updates arrive at random times at the workload's rate, whatever the replicas do."""
        rate = self._work.request_rate()
        times = np.cumsum(self._random.exponential(1 / rate, requests))
        scenes = self._draw(requests)
        updates = self._random.random(requests) < self._work.update_share
        self._begin(skip)
        for number, (now, scene) in enumerate(zip(times, scenes)):
            self._run_until(now)
            self._measuring(number, skip, now)
            self._send(now, int(scene), None)
            if updates[number]:
                self._update(now, int(scene))
        return self._end(times[-1])

    def run_closed(self, clients, requests, skip=0):
        """Each client sends its next request when the one before is answered. Ends when all `requests` are answered."""
        scenes = iter(self._draw(requests))
        self._begin(skip)
        self._waiting = scenes
        for client in range(min(clients, requests)):
            self._send(0.0, int(next(scenes)), client)
        now = self._run_until(float("inf"))
        return self._end(now)

    def _draw(self, count):
        return np.searchsorted(self._cumulative, self._random.random(count) * self._cumulative[-1])

    def _begin(self, skip):
        self._skip, self._began = skip, 0.0
        self._responses, self._missing, self._waiting = [], [], None
        self._busy_before = np.zeros(len(self._processors))

    def _measuring(self, number, skip, now):
        """After the first `skip` requests the tally begins."""
        if number == skip and skip > 0:
            self._began = now
            self._responses.clear()
            self._missing.clear()
            for processor in self._processors:
                processor.advance(now)
            self._busy_before = np.array([processor.busy_s for processor in self._processors])

    def _send(self, now, scene, client):
        """What the client itself does comes first, where it shares the processor."""
        if self._shared:
            self._add(now, 0, self._costs.client_s(self._work.rays, self._fleet.policy), ("send", scene, now, client))
        else:
            self._request(now, now, scene, client)

    def _request(self, now, began, scene, client):
        """At the balancer."""
        replica = self._chooser.choose(scene, self._in_flight)
        self.tally.arrived += 1
        if self._in_flight[replica] >= self._limit:
            self.tally.refused += 1
            return
        life = self._random.exponential(self._work.tree_life_s)
        visit = self._caches[replica].visit(now, scene, self._triangles[scene], self._reach[scene], life)
        self._missing.append(visit.missing)
        self._in_flight[replica] += 1
        self._add(now, replica, self._seconds(scene, visit), ("request", replica, began, client))

    def _seconds(self, scene, visit):
        """Processor seconds of a request, on the processor that it runs on."""
        costs, rays, policy = self._costs, self._work.rays, self._fleet.policy
        seconds = costs.warm_s(rays, policy) + costs.build_triangle_s * visit.built
        if visit.opened:
            seconds += costs.open_scene_s + costs.open_triangle_s * self._triangles[scene]
        if self._shared:
            seconds += visit.opened * costs.database_open_triangle_s * self._triangles[scene]
            seconds += costs.client_triangle_s * visit.built + costs.proxy_s(rays, policy)
        return seconds

    def _update(self, now, scene):
        """One replica takes it, the others that have the scene follow the log."""
        writer = self._chooser.choose(scene, self._in_flight)
        self._add(now, writer, self._costs.update_write_s, ("update", writer, now, None))
        for replica, cache in enumerate(self._caches):
            if replica != writer and scene in cache:
                self._add(now, replica, self._costs.update_follow_s, ("update", replica, now, None))

    # ---- the queue of events

    def _add(self, now, replica, seconds, job):
        self._number += 1
        index = 0 if self._shared else replica
        self._processors[index].add(now, seconds, (self._number, job))
        self._schedule(index)

    def _schedule(self, index):
        self._versions[index] += 1
        end = self._processors[index].next_end()
        if end < float("inf"):
            heapq.heappush(self._ends, (end, index, self._versions[index]))

    def _run_until(self, limit):
        """Ends all jobs that end before. Returns when the last did."""
        last = 0.0
        while self._ends and self._ends[0][0] <= limit:
            now, index, version = heapq.heappop(self._ends)
            if version != self._versions[index]:
                continue
            last = now
            _, (kind, what, began, client) = self._processors[index].finish(now)
            self._schedule(index)
            if kind == "send":
                self._request(now, began, what, client)
            elif kind == "request":
                self._answer(now, what, began, client)
        return last

    def _answer(self, now, replica, began, client):
        self.tally.answered += 1
        self._in_flight[replica] -= 1
        if began >= self._began:
            self._responses.append(now - began)
        if client is not None:
            self._measuring(self.tally.answered, self._skip, now)
            scene = next(self._waiting, None)
            if scene is not None:
                self._send(now, int(scene), client)

    def _end(self, now):
        tally = self.tally
        for processor in self._processors:
            processor.advance(now)
        tally.seconds = now - self._began
        tally.in_flight = sum(self._in_flight)
        tally.responses_s = np.array(self._responses)
        if not self._shared:
            tally.responses_s += self._costs.proxy_s(self._work.rays, self._fleet.policy)
        tally.built = sum(cache.built for cache in self._caches)
        tally.warm_share = 1 - float(np.mean(self._missing))
        tally.busy = (np.array([p.busy_s for p in self._processors]) - self._busy_before) / tally.seconds
        tally.evictions = sum(cache.evictions for cache in self._caches)
        return tally
