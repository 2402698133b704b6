"""One workload on a real cluster of three replicas, and in the event simulation with the unit costs of the same machine and minutes."""
import dataclasses
import statistics

from closed_loop import closed_loop
from costs import Costs
from events import Simulation
from fleet import Fleet
from request_costs import built_by, put_scenes, request_costs, scene_sizes
from workload import Workload, popularity, scene_triangles

WORKLOAD = Workload(scenes=30, median_triangles=50_000, sigma=0.6, tree_life_s=1e9)
CLIENTS, REQUESTS = 6, 250  # each sends so many
WARM_REQUESTS = 300         # of each client, to measure unit costs
BOUND = 1.25
PLENTY_GIB = 1e6
QUANTITIES = "throughput", "built_ratio", "p50_ms"


def fill(measured):
    """Costs of which only those of requests are known; the others do not matter here."""
    return Costs(**{field.name: measured.get(field.name, 0.0) for field in dataclasses.fields(Costs)})


def simulate(costs, policy, replicas, cores):
    fleet = Fleet(replicas=replicas, policy=policy, bound=BOUND, memory_gib=PLENTY_GIB)
    return Simulation(costs, WORKLOAD, fleet, shared_cores=cores).run_closed(CLIENTS, CLIENTS * REQUESTS)


@dataclasses.dataclass(frozen=True)
class Round:
    """What was measured."""
    costs: Costs
    measured: dict  # by policy: figures by name


def median_costs(rounds):
    return Costs(**{field.name: statistics.median(getattr(one.costs, field.name) for one in rounds) for field in dataclasses.fields(Costs)})


def compare(rounds, replicas):
    """A row for each round and policy. The simulation has the medians of the unit costs, and of the cores that the processes had: one
    prediction for all rounds."""
    costs = median_costs(rounds)
    base = simulate(costs, "round_robin", 1, 1).built
    rows = []
    for policy in rounds[0].measured:
        given = statistics.median(one.measured[policy]["cores"] for one in rounds)
        tally = simulate(costs, policy, replicas, given)
        simulated = {"throughput": tally.throughput(), "built_ratio": tally.built / base, "p50_ms": tally.quantile_ms(0.5),
                     "p99_ms": tally.quantile_ms(0.99), "cpu_ms": 1e3 * float(tally.busy[0]) / tally.throughput(), "cores": given}
        for number, one in enumerate(rounds, 1):
            rows.append({"round": number, "policy": policy, **{f"{who}_{name}": of[name] for name in simulated for who, of in
                                                               (("measured", one.measured[policy]), ("simulated", simulated))}})
    return rows


class Comparison:
    """With one cluster."""

    def __init__(self, cluster, policies):
        self._cluster, self._policies, self._round, self._puts = cluster, policies, 0, 0

    def round(self):
        """Unit costs, then a run under each policy. Scenes are new in every run."""
        self._round += 1
        costs = self._measure_costs()
        base = self._run("one")[1]
        measured = {}
        for policy in self._policies:
            run, built = self._run(policy)
            measured[policy] = {"throughput": run.throughput(), "built_ratio": built / base, "p50_ms": run.quantile_ms(0.5),
                                "p99_ms": run.quantile_ms(0.99), "cpu_ms": 1e3 * run.cores() / run.throughput(), "cores": run.cores()}
        return Round(costs, measured)

    def _measure_costs(self):
        scenes = self._put("costs", scene_sizes(WORKLOAD))
        bound = BOUND if "bounded" in self._policies else None
        return fill(request_costs(self._cluster, scenes, WORKLOAD, CLIENTS, WARM_REQUESTS, bound))

    def _run(self, policy):
        """From cold. Returns what clients saw, and the triangles that all replicas built."""
        names, _ = self._put(policy, scene_triangles(WORKLOAD))
        proxy = policy in ("hashing", "bounded")
        ports = list(self._cluster.replicas)
        if proxy:
            endpoint = self._cluster.start_haproxy(BOUND if policy == "bounded" else None)
        else:
            endpoint = f"127.0.0.1:{ports[0]}" if policy == "one" else self._cluster.endpoints()
        run = closed_loop(self._cluster, endpoint, names, popularity(WORKLOAD), CLIENTS, REQUESTS, WORKLOAD.rays, WORKLOAD.window,
                          self._round, proxy=proxy)
        return run, sum(built_by(port, names).sum() for port in ports)

    def _put(self, prefix, sizes):
        """Meshes that no replica has seen: equal ones would share their trees."""
        self._puts += 1
        scenes = put_scenes(self._cluster.endpoints().split(",")[0], f"{prefix}-{self._round}-", sizes, 1_000 * self._puts)
        self._cluster.renew()
        return scenes
