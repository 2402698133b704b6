"""What the operator buys: replicas, what stands before and behind them, and prices."""
import dataclasses

GIB = 1 << 30
POLICIES = "round_robin", "hashing", "bounded"


def has_proxy(policy):
    """round_robin is the clients' own; the others need HAProxy, which knows the scene of a call."""
    return policy != "round_robin"


@dataclasses.dataclass(frozen=True)
class Fleet:
    replicas: int = 3
    policy: str = "round_robin"
    bound: float = 1.25               # bounded: no replica has more than this many times the mean load
    cores: int = 4                    # of a replica
    memory_gib: float = 16            # the memory budget of a replica
    database_cores: int = 8           # of PostgreSQL's machine; its standby has as many
    proxy_cores: int = 8              # of one machine of HAProxy
    proxy_bytes_s: float = 1.25e9     # its network, 10 Gbit/s
    core_hour: float = 0.04           # price, in a currency of choice
    gib_hour: float = 0.005

    def __post_init__(self):
        if self.policy not in POLICIES:
            raise ValueError(f"no policy is called {self.policy}; there are {', '.join(POLICIES)}")
        if self.replicas < 1 or self.bound < 1:
            raise ValueError("a fleet has at least one replica, and a bound of at least 1")

    def budget_bytes(self):
        return self.memory_gib * GIB

    def cost_an_hour(self, proxies):
        """Of all machines; `proxies` of them run HAProxy. PostgreSQL has two, with 4 GiB a core."""
        replicas = self.replicas * (self.cores * self.core_hour + self.memory_gib * self.gib_hour)
        database = 2 * self.database_cores * (self.core_hour + 4 * self.gib_hour)
        return replicas + database + proxies * self.proxy_cores * self.core_hour
