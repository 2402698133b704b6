"""The steady state beside the event simulation, where both can be had: small fleets with little memory, so that all of the model is used."""
import dataclasses

from events import Simulation
from fleet import POLICIES, Fleet
from steady import steady_state
from workload import Workload

WORKLOAD = Workload(clients=1_000, scenes=300, median_triangles=20_000, tree_life_s=20)
REPLICAS = 1, 3, 10, 30
REQUESTS, SKIPPED = 60_000, 20_000
LOADS = 0.05, 0.15  # of the cores of a replica, on the average, if all were warm
BUDGET_GIB = 0.3   # a quarter of the scenes, with their trees


def agreement(costs):
    rows = []
    for policy in POLICIES:
        for replicas in REPLICAS:
            for load in LOADS:
                fleet = Fleet(replicas=replicas, policy=policy, memory_gib=BUDGET_GIB)
                rows.append(_compare(costs, _loaded(costs, fleet, load), fleet, load))
    return rows


def _loaded(costs, fleet, load):
    """The workload with as many clients as make this load. Trees live as long in requests, whatever the rate."""
    rate = load * fleet.replicas * fleet.cores / costs.warm_s(WORKLOAD.rays, fleet.policy)
    return dataclasses.replace(WORKLOAD, clients=max(1, round(rate)), tree_life_s=WORKLOAD.tree_life_s * WORKLOAD.clients / rate)


def _compare(costs, workload, fleet, load):
    tally = Simulation(costs, workload, fleet).run_open(REQUESTS, SKIPPED)
    state = steady_state(costs, workload, fleet)
    return {"policy": fleet.policy, "replicas": fleet.replicas, "warm_load": load,
            "events_warm_share": tally.warm_share, "steady_warm_share": state.warm_share,
            "events_mean_load": float(tally.busy.mean()) / fleet.cores, "steady_mean_load": state.mean_load,
            "events_busiest": float(tally.busy.max()) / fleet.cores, "steady_busiest": state.busiest,
            "events_p50_ms": tally.quantile_ms(0.5), "steady_p50_ms": state.p50_ms,
            "events_p99_ms": tally.quantile_ms(0.99), "steady_p99_ms": state.p99_ms}
