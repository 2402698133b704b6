"""Steady states over fleets and workloads, and what operators ask: the smallest fleet for so many clients."""
import dataclasses

from fleet import POLICIES, Fleet
from steady import steady_state
from workload import Workload

REPLICAS = 1, 2, 3, 5, 10, 20, 30, 50, 100, 200, 300, 500, 1000
CLIENTS = 1_000, 3_000, 10_000, 30_000, 100_000, 300_000, 1_000_000
ZIPF = 0.8, 1.0, 1.2
FULL = 0.8         # an operator adds replicas at this load of the busiest one
UPDATES_S = 10, 100, 1_000
CLIENTS_A_REPLICA = 300  # where updates are what is varied


def row_of(workload, fleet, state):
    return {"policy": fleet.policy, "replicas": fleet.replicas, "clients": workload.clients, "zipf": workload.zipf,
            "updates_a_request": workload.update_share, **dataclasses.asdict(state)}


def sweep(costs, workload=Workload(), fleet=Fleet()):
    """Every policy, size, number of clients and exponent; one row each."""
    rows = []
    for policy in POLICIES:
        for replicas in REPLICAS:
            for zipf in ZIPF:
                for clients in CLIENTS:
                    work = dataclasses.replace(workload, clients=clients, zipf=zipf)
                    size = dataclasses.replace(fleet, replicas=replicas, policy=policy)
                    rows.append(row_of(work, size, steady_state(costs, work, size)))
    return rows


def sweep_log(costs, workload=Workload(), fleet=Fleet()):
    """PostgreSQL's load: every policy and size, with some updates a second beside requests that leave the replicas room."""
    rows = []
    for policy in POLICIES:
        for updates in UPDATES_S:
            for replicas in REPLICAS:
                clients = CLIENTS_A_REPLICA * replicas
                work = dataclasses.replace(workload, clients=clients, update_share=updates / clients * workload.request_every_s)
                size = dataclasses.replace(fleet, replicas=replicas, policy=policy)
                rows.append({**row_of(work, size, steady_state(costs, work, size)), "updates_s": updates})
    return rows


def suffices(row):
    """Whether every request is answered, and nothing is nearly full."""
    return row["busiest"] <= FULL


def smallest_fleets(rows):
    """Of a sweep: for each policy, exponent and number of clients, the row of the smallest fleet that suffices, if there is one."""
    found = {}
    for row in sorted(rows, key=lambda row: row["replicas"]):
        key = row["policy"], row["zipf"], row["clients"]
        if key not in found and suffices(row):
            found[key] = row
    return found
