"""A cluster that runs already, as `deploy/cluster status --json` describes it."""


class GivenCluster:
    """`replicas` are pids, by port; `haproxy` and `postgres` are pids. HAProxy hashes as it is configured there."""

    def __init__(self, status):
        self.replicas = {int(replica["port"]): int(replica["pid"]) for replica in status["replicas"]}
        self._endpoint = status["endpoint"]
        self.haproxy, self.postgres = int(status["haproxy"]["pid"]), int(status["primary"]["pid"])

    def endpoints(self):
        return ",".join(f"127.0.0.1:{port}" for port in self.replicas)

    def start_haproxy(self, bound=None):
        if bound is not None:
            raise ValueError("this cluster's HAProxy has no bound")
        return self._endpoint

    def renew(self):
        """It stays as it is: scenes that are new to it are not loaded."""
