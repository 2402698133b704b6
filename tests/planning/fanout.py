"""The log behind the replicas: what updates cost PostgreSQL, how many replicas must follow each, and what they fetch."""
import dataclasses

POLLS_S = 4.0  # a replica that has heard nothing looks so many times a second (kWatchEvery)


@dataclasses.dataclass(frozen=True)
class LogLoad:
    """`transactions` and `reads` are those a second; `cores` are PostgreSQL's, if it had as many as it needs."""
    transactions: float
    reads: float
    cores: float


def log_load(costs, updates_s, replicas, reads_s, opened_s):
    """updates_s: all updates a second. reads_s: the sum over updates of the replicas that follow them. opened_s:
    triangles of scenes that replicas open.

    A replica commits what waits together, one transaction at a time. Each transaction is a notice to all replicas, and each
    replica that has the scene reads what is new.
    """
    together = 1 + updates_s / replicas * costs.commit_s
    transactions = updates_s / together
    reads = reads_s / together + POLLS_S * replicas
    cores = (updates_s * costs.database_update_s + transactions * (costs.database_commit_s + replicas * costs.database_notice_s) +
             reads * costs.database_read_s + opened_s * costs.database_open_triangle_s)
    return LogLoad(transactions, reads, cores)
