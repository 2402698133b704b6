"""Runs clients against a cluster, and tells what they saw and what it took."""
import dataclasses
import json
import pathlib
import subprocess
import sys

import numpy as np

from processor_time import tree_used_s, used_s

CLIENT = pathlib.Path(__file__).resolve().parent / "client.py"


@dataclasses.dataclass(frozen=True)
class Run:
    """Of all clients together; processor seconds are those of a request."""
    requests: int
    seconds: float
    responses_s: np.ndarray
    client_s: float
    server_s: float
    proxy_s: float
    store_s: float        # PostgreSQL

    def throughput(self):
        return self.requests / self.seconds

    def quantile_ms(self, q):
        return 1e3 * float(np.quantile(self.responses_s, q))

    def cores(self):
        """That all of it had, on the average."""
        return (self.client_s + self.server_s + self.proxy_s + self.store_s) * self.throughput()


def closed_loop(cluster, endpoint, scenes, shares, clients, requests, rays, window, seed, proxy=False):
    """`requests` by each client. The rays are the same for the same seed, whatever the endpoint."""
    processes = [subprocess.Popen([sys.executable, CLIENT], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) for _ in range(clients)]
    try:
        for number, process in enumerate(processes):
            task = {"endpoint": endpoint, "scenes": list(scenes), "shares": list(shares), "requests": requests, "rays": rays,
                    "window": window, "seed": 1000 * seed + number}
            process.stdin.write(json.dumps(task) + "\n")
            process.stdin.flush()
        for process in processes:
            if process.stdout.readline() != "ready\n":
                raise RuntimeError("a client failed")
        servers, proxies = list(cluster.replicas.values()), [cluster.haproxy] if proxy else []
        used = lambda: np.array([used_s(servers), used_s(proxies), tree_used_s(cluster.postgres)])
        before = used()
        for process in processes:
            process.stdin.write("go\n")
            process.stdin.flush()
        answers = [json.loads(process.stdout.readline()) for process in processes]
        server, proxy_used, store = (used() - before) / (clients * requests)
    finally:
        for process in processes:
            process.stdin.close()
            process.wait()
    total = clients * requests
    return Run(total, max(a["ended"] for a in answers) - min(a["began"] for a in answers),
               np.concatenate([a["responses_s"] for a in answers]), sum(a["cpu_s"] for a in answers) / total,
               server, proxy_used, store)
