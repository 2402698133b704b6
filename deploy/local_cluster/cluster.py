"""The commands: all parts up, down, told about, and what an operator does to them."""

import contextlib
import fcntl
import os
import shutil

from . import programs
from .balancer import Balancer
from .databases import Databases
from .monitor import Monitor
from .replicas import Replicas, chosen
from .settings import DATABASES, REPLICAS, Failure, Settings, say

_MARK = "state.json"  # only a directory with it is deleted


class Cluster:
    def __init__(self, directory):
        self._directory = directory
        self._load()

    def _load(self):
        self._settings = Settings(self._directory)
        self._databases = Databases(self._settings)
        self._replicas = Replicas(self._settings, self._databases)
        self._balancer = Balancer(self._settings)
        self._monitor = Monitor(self._settings)

    @contextlib.contextmanager
    def _alone(self):
        """One command changes the cluster at a time; the next one waits."""
        self._directory.mkdir(parents=True, exist_ok=True)
        with (self._directory / "lock").open("w") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX)
            self._load()
            yield

    def up(self, program):
        """Starts what does not run. What runs is left alone."""
        programs.install_packages("cluster")
        program = programs.sightlined(program)
        with self._alone():
            self._directory.chmod(0o711)  # the user of PostgreSQL goes through it to its own
            self._databases.must_be_reachable(self._directory)
            if not self._runs() and not self._settings.has_free_ports():
                self._settings.choose_ports()
                self._settings.save()
            say("starting the databases")
            self._databases.up()
            say("starting the replicas")
            self._replicas.up(program)
            self._balancer.up()
            self._monitor.up()
            say(f"up: SIGHTLINE_ENDPOINT={self.status()['endpoint']}, files in {self._directory}")

    def down(self, delete):
        """Ends what `up` has started, callers first. `delete`: the scenes, too."""
        if not self._directory.exists():
            return
        with self._alone():
            for part in (self._balancer, self._replicas, self._databases, self._monitor):
                part.down()
            if delete:
                if not (self._directory / _MARK).exists():
                    raise Failure(f"{self._directory} is not the directory of a cluster")
                shutil.rmtree(self._directory)
        say("down" + (", and its files are deleted" if delete else f": files stay in {self._directory}"))

    def promote(self):
        with self._alone():
            self._must_be_made()
            self._databases.promote()
            say(f"{self._settings.primary} takes writes; \"up\" makes {self._settings.standby} its standby")

    def restart(self, program, names):
        program = programs.sightlined(program)
        with self._alone():
            self._must_be_made()
            self._replicas.restart(program, self._balancer, chosen(names))

    def _runs(self):
        processes = [*map(self._replicas.process, REPLICAS), *map(self._databases.process, DATABASES), self._balancer.process,
                     self._monitor.process]
        return any(process.pid() is not None for process in processes)

    def _must_be_made(self):
        if not self._settings.ports:
            raise Failure("there is no cluster: start it with \"up\"")

    def status(self):
        """What runs, for a program. A pid is None for what does not run."""
        ports = self._settings.ports
        replicas = [{"name": name, "pid": self._replicas.process(name).pid(), "port": ports.get(name),
                     "admin_port": ports.get(f"admin-{name}")} for name in REPLICAS]
        for replica in replicas:
            replica["ready"] = replica["pid"] is not None and self._replicas.is_ready(replica["name"])
        primary, standby = (self._database(name) for name in (self._settings.primary, self._settings.standby))
        standby["synchronous"] = primary["pid"] is not None and standby["pid"] is not None and self._databases.is_synchronous()
        status = {
            "endpoint": f"127.0.0.1:{ports['endpoint']}" if ports else None,
            "replicas": replicas,
            "primary": primary,
            "standby": standby,
            "haproxy": {"pid": self._balancer.process.pid(), "port": ports.get("endpoint")},
            "prometheus": {"pid": self._monitor.process.pid(), "port": ports.get("prometheus")},
            "directory": os.fspath(self._directory),
        }
        parts = [*replicas, primary, standby, status["haproxy"], status["prometheus"]]
        status["running"] = self._runs()
        status["complete"] = all(part["pid"] is not None for part in parts) and all(
            replica["ready"] for replica in replicas) and standby["synchronous"]
        return status

    def _database(self, name):
        return {"name": name, "pid": self._databases.process(name).pid(), "port": self._settings.ports.get(name)}


def as_text(status):
    """The same for a person."""
    def line(what, part, note=""):
        state = f"pid {part['pid']}" if part["pid"] is not None else "does not run"
        return f"{what:<12} 127.0.0.1:{part['port']}  {state}{note}"

    if not status["running"]:
        return f"nothing runs; files in {status['directory']}"
    lines = [f"{'endpoint':<12} {status['endpoint']}"]
    for replica in status["replicas"]:
        note = f", admin port {replica['admin_port']}" + ("" if replica["ready"] else ", not ready")
        lines.append(line(f"replica {replica['name']}", replica, note))
    lines.append(line("primary", status["primary"], f", {status['primary']['name']}"))
    synchronous = "synchronous" if status["standby"]["synchronous"] else "not synchronous"
    lines.append(line("standby", status["standby"], f", {status['standby']['name']}, {synchronous}"))
    lines += [line(what, status[what]) for what in ("haproxy", "prometheus")]
    return "\n".join([*lines, f"{'files':<12} {status['directory']}"])
