"""The steady state: means over a long time, computed without events, so that a thousand replicas take milliseconds.

Replicas are independent queues whose cores are shared evenly (`processor.py`). Such a queue is insensitive: the mean response of a
request is its own processor time, times a factor that depends on the load alone. `residence.py` says what is built when it comes.
"""
import dataclasses
import functools
import math

import numpy as np

import residence
from fanout import log_load
from fleet import has_proxy
from spreading import spill_chance, spread
from workload import Workload, popularity, reach, scene_triangles

SAMPLES = 20_000   # requests, of which latencies are quantiles
FULLEST = 0.98     # load up to which a replica's responses are computed; beyond, it refuses what it cannot do


@dataclasses.dataclass(frozen=True)
class State:
    """Rates are those a second."""
    offered: float            # requests
    answered: float
    updates_offered: float
    updates_answered: float
    warm_share: float         # of what requests need, what is built when they come
    copies: float             # mean replicas that have a scene loaded, over requests
    busiest: float            # load of the replica with the most, 1: all cores; above: it refuses
    mean_load: float          # over replicas
    follow_share: float       # of the replicas' work, what goes into following the log
    database_load: float      # 1: all cores of PostgreSQL
    log_reads: float
    proxies: int              # machines of HAProxy that are needed
    network_bytes: float
    memory_gib: float         # of the fullest replica
    p50_ms: float
    p99_ms: float
    cost_an_hour: float
    bound: str                # what is used up first: nothing, replicas, one replica or log

    def rays_answered(self, workload):
        return self.answered * workload.rays


def waiting_factor(cores, load):
    """Mean response over processor time, at a load of 0 to 1 of all cores (Erlang's C)."""
    offered = cores * load
    inverse = 1.0  # Erlang's B, by its recurrence
    for n in range(1, cores + 1):
        inverse = 1 + inverse * n / offered if offered > 0 else math.inf
    blocked = 0 if math.isinf(inverse) else 1 / inverse
    waits = blocked / (1 - load * (1 - blocked))
    return 1 + waits / (cores * (1 - load))


@functools.lru_cache(maxsize=256)
def _known_spread(zipf, scenes, replicas, policy, bound, spill):
    return spread(popularity(Workload(zipf=zipf, scenes=scenes)), replicas, policy, bound, spill)


def _spread_of(costs, workload, fleet):
    """A sweep asks for the same ones again: the number of clients matters to none but bounded."""
    spill = 0.0
    if fleet.policy == "bounded":
        load = workload.request_rate() * costs.warm_s(workload.rays, fleet.policy) / fleet.replicas / fleet.cores
        load = min(load, FULLEST)
        spill = round(spill_chance(load * fleet.cores * waiting_factor(fleet.cores, load), fleet.replicas, fleet.bound) * 20) / 20
    return _known_spread(workload.zipf, workload.scenes, fleet.replicas, fleet.policy, fleet.bound, spill)


def steady_state(costs, workload, fleet):
    spread_ = _spread_of(costs, workload, fleet)
    scene, where = spread_.scene, spread_.replica
    rates = spread_.share * workload.request_rate()
    triangles = scene_triangles(workload)[scene]
    near = reach(workload, triangles, costs.piece_triangles)

    def bytes_of(chance):
        return triangles * (costs.geometry_bytes + costs.tree_bytes * residence.built_share(chance, near))

    patience = residence.patience(rates, where, spread_.replicas, bytes_of, fleet.budget_bytes(), workload.tree_life_s)
    chance = residence.stay(rates, patience[where], workload.tree_life_s)
    missing = residence.missing_share(chance, near)
    total = lambda values: np.bincount(where, values, spread_.replicas)

    seconds = (costs.warm_s(workload.rays, fleet.policy) + costs.build_triangle_s * triangles * near * missing +
               (1 - chance) * (costs.open_scene_s + costs.open_triangle_s * triangles))
    update_rates = popularity(workload) * workload.request_rate() * workload.update_share
    holders = np.bincount(scene, chance, workload.scenes) * spread_.alike
    followers = np.maximum(holders - 1, 0)  # the one that takes an update need not follow it
    # Copies of meshes stay on the replica's disk: PostgreSQL sends one again only when it was replaced.
    served = np.minimum(1, fleet.cores / total(rates * seconds))
    fetched = rates * served[where] * (1 - residence.stay(rates, np.inf, workload.tree_life_s))
    opened = float((fetched * triangles).sum()) * spread_.alike
    log = log_load(costs, float(update_rates.sum()), fleet.replicas, float((update_rates * followers).sum()), opened)
    database_load = log.cores / fleet.database_cores
    acknowledged = min(1.0, 1 / database_load)

    follows = total(update_rates[scene] * chance * (followers / np.maximum(holders, 1e-12))[scene])
    writes = total(rates * workload.update_share)
    log_work = acknowledged * (follows * costs.update_follow_s + writes * costs.update_write_s)
    work = total(rates * seconds) + log_work
    load = work / fleet.cores
    served = np.minimum(1, 1 / load)
    answered = float((rates * served[where]).sum() * spread_.alike)

    responses = _responses_s(costs, workload, fleet, rates * served[where], where, chance, near, triangles, load)
    network = answered * costs.bytes(workload.rays)
    proxies = _proxies(costs, workload, fleet, answered, network)
    offered = workload.request_rate()
    return State(offered=offered, answered=answered, updates_offered=float(update_rates.sum()),
                 updates_answered=float(update_rates.sum()) * acknowledged,
                 warm_share=1 - float((rates * missing).sum() / rates.sum()),
                 copies=float((holders * popularity(workload)).sum()), busiest=float(load.max()), mean_load=float(load.mean()),
                 follow_share=float(acknowledged * (follows * costs.update_follow_s).sum() / work.sum()),
                 database_load=database_load, log_reads=log.reads, proxies=proxies, network_bytes=network,
                 memory_gib=float(total(chance * bytes_of(chance)).max()) / 2**30,
                 p50_ms=1e3 * float(np.quantile(responses, 0.5)), p99_ms=1e3 * float(np.quantile(responses, 0.99)),
                 cost_an_hour=fleet.cost_an_hour(proxies), bound=_bound(load, database_load))


def _bound(load, database_load):
    if load.mean() > 1:
        return "replicas"
    if load.max() > 1:
        return "one replica"
    return "log" if database_load > 1 else "nothing"


def _proxies(costs, workload, fleet, answered, network):
    if not has_proxy(fleet.policy):
        return 0
    by_cores = answered * costs.proxy_s(workload.rays, fleet.policy) / fleet.proxy_cores
    return max(1, math.ceil(max(by_cores, network / fleet.proxy_bytes_s)))


def _responses_s(costs, workload, fleet, rates, where, chance, near, triangles, load):
    """Of some requests: which scene and replica, and the how manieth of a stay, is drawn."""
    random = np.random.default_rng(workload.seed + 2)
    drawn = np.searchsorted(np.cumsum(rates), random.random(SAMPLES) * rates.sum())
    age = random.geometric(np.maximum(1 - chance[drawn], 1e-9))
    built = triangles[drawn] * near[drawn] * (1 - near[drawn]) ** (age - 1)
    opened = age == 1
    seconds = (costs.warm_s(workload.rays, fleet.policy) + costs.build_triangle_s * built +
               opened * (costs.open_scene_s + costs.open_triangle_s * triangles[drawn]))
    factors = np.array([waiting_factor(fleet.cores, x) for x in np.minimum(load, FULLEST)])
    return seconds * factors[where[drawn]] + costs.proxy_s(workload.rays, fleet.policy)
