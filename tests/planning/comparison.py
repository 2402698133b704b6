"""One workload on a real cluster of three replicas, and in the event simulation with the unit costs of the same machine and minutes."""
import dataclasses

from closed_loop import closed_loop
from costs import Costs
from events import Simulation
from fleet import Fleet
from request_costs import COLD_SCENES, GROWTH_SCENES, WARM_SCENES, built_by, put_scenes, request_costs
from workload import Workload, popularity, scene_triangles

WORKLOAD = Workload(scenes=30, median_triangles=50_000, sigma=0.6, tree_life_s=1e9)
CLIENTS, REQUESTS = 6, 250  # each sends so many
WARM_REQUESTS = 200         # of each client, to measure unit costs
BOUND = 1.25
PLENTY_GIB = 1e6
QUANTITIES = "throughput", "built_ratio", "p50_ms"


def fill(measured):
    """Costs of which only those of requests are known; the others do not matter here."""
    return Costs(**{field.name: measured.get(field.name, 0.0) for field in dataclasses.fields(Costs)})


def simulate(costs, policy, replicas, cores):
    fleet = Fleet(replicas=replicas, policy=policy, bound=BOUND, memory_gib=PLENTY_GIB)
    return Simulation(costs, WORKLOAD, fleet, shared_cores=cores).run_closed(CLIENTS, CLIENTS * REQUESTS)


class Comparison:
    """With one cluster."""

    def __init__(self, cluster, policies):
        self._cluster, self._policies, self._round, self._puts = cluster, policies, 0, 0

    def round(self):
        """Unit costs, then a row for each policy. Scenes are new in every run."""
        self._round += 1
        costs, warm = self._measure_costs()
        base = self._run("one")[1]
        base_simulated = simulate(costs, "round_robin", 1, warm["direct"].cores()).built
        rows = []
        for policy in self._policies:
            cores = warm["direct" if policy == "round_robin" else "through"].cores()
            run, built = self._run(policy)
            tally = simulate(costs, policy, len(self._cluster.replicas), cores)
            rows.append({"round": self._round, "policy": policy, "cores": cores, "measured_cores": run.cores(),
                         "measured_cpu_ms": 1e3 * run.cores() / run.throughput(),
                         "simulated_cpu_ms": 1e3 * float(tally.busy[0]) / tally.throughput(),
                         "measured_throughput": run.throughput(), "simulated_throughput": tally.throughput(),
                         "measured_built_ratio": built / base, "simulated_built_ratio": tally.built / base_simulated,
                         "measured_p50_ms": run.quantile_ms(0.5), "simulated_p50_ms": tally.quantile_ms(0.5),
                         "measured_p99_ms": run.quantile_ms(0.99), "simulated_p99_ms": tally.quantile_ms(0.99)})
        return rows, costs

    def _measure_costs(self):
        sizes = scene_triangles(dataclasses.replace(WORKLOAD, scenes=WARM_SCENES + GROWTH_SCENES + COLD_SCENES, seed=5))
        scenes = self._put("costs", sizes)
        measured, runs = request_costs(self._cluster, self._cluster.start_haproxy(), scenes, WORKLOAD, CLIENTS, WARM_REQUESTS)
        return fill(measured), runs

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
