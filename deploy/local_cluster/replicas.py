"""The servers that answer: three sightlined on one database, each with copies of meshes of its own."""

import os

from .processes import Process, answers, wait_for
from .settings import REPLICAS, Failure, say

# After SIGTERM: the balancer looks twice, half a second apart, before it sends no more calls.
_NOT_READY_MS = 1500
_DRAIN_MS = 5000
# Of the machine's memory, for each: the databases and the clients are here, too.
_MEMORY_SHARE = 0.2


class Replicas:
    def __init__(self, settings, databases):
        self._settings = settings
        self._databases = databases
        self._processes = {name: Process(settings.directory, f"replica-{name}") for name in REPLICAS}

    def process(self, name):
        return self._processes[name]

    def up(self, program):
        """All at once: each makes the tables if there are none."""
        for name in REPLICAS:
            self._start(name, program)
        for name in REPLICAS:
            self._processes[name].must_run_until(lambda name=name: self.is_ready(name), 60)

    def is_ready(self, name):
        return answers(f"http://127.0.0.1:{self._settings.ports[f'admin-{name}']}/readyz")

    def restart(self, program, balancer, names):
        """One after the other, each when the one before serves again. `program` may be another version."""
        for name in names:
            say(f"restarting replica {name}")
            self._processes[name].stop(seconds=(_NOT_READY_MS + _DRAIN_MS) / 1000 + 10)
            self._start(name, program)
            self._processes[name].must_run_until(lambda name=name: self.is_ready(name), 60)
            wait_for(lambda name=name: balancer.uses(name), 30, f"the balancer does not use replica {name}")

    def down(self):
        """All are asked before one is waited for."""
        for process in self._processes.values():
            process.ask_to_end()
        for process in self._processes.values():
            process.stop(seconds=(_NOT_READY_MS + _DRAIN_MS) / 1000 + 10)

    def _start(self, name, program):
        ports = self._settings.ports
        cache = self._settings.directory / "meshes" / name
        cache.mkdir(parents=True, exist_ok=True)
        memory = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
        self._processes[name].start(
            [program, "--listen", f"127.0.0.1:{ports[name]}", "--admin", f"127.0.0.1:{ports[f'admin-{name}']}",
             "--mesh-cache", cache, "--memory-budget", str(int(_MEMORY_SHARE * memory)),
             "--not-ready-ms", str(_NOT_READY_MS), "--drain-ms", str(_DRAIN_MS)],
            environment={"SIGHTLINED_STORE": self._databases.address()})


def chosen(names):
    """All without names. Failure: one is not a replica."""
    for name in names:
        if name not in REPLICAS:
            raise Failure(f"\"{name}\" is not one of the replicas {', '.join(REPLICAS)}")
    return list(names) or list(REPLICAS)
