"""Three replicas, HAProxy before them and PostgreSQL behind them, as processes of this one, on loopback."""
import contextlib
import os
import pathlib
import pwd
import shutil
import signal
import socket
import subprocess
import sys
import time

from costs import ROOT

POSTGRES = pathlib.Path("/usr/lib/postgresql/15/bin")
NAMES = "ABC"
THREADS = 2  # of a replica
_WAIT_S = 60


class CannotRun(Exception):
    """A program is missing, or does not start."""


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


def wait_for(holds, process, what):
    end = time.monotonic() + _WAIT_S
    while not holds():
        if process.poll() is not None or time.monotonic() > end:
            raise CannotRun(f"{what} does not start")
        time.sleep(0.02)


def listens(port):
    with socket.socket() as probe:
        return probe.connect_ex(("127.0.0.1", port)) == 0


class OwnCluster:
    """Leaving `with` stops all of it. `replicas` are pids, by port; `haproxy` and `postgres` are pids; `admins`
    are the replicas' admin ports, in their order."""

    def __init__(self, sightlined, folder):
        for program in (sightlined, shutil.which("haproxy"), POSTGRES / "initdb"):
            if program is None or not pathlib.Path(program).exists():
                raise CannotRun(f"there is no {program or 'haproxy'}")
        self._sightlined, self._folder = str(sightlined), pathlib.Path(folder)
        self._stack = contextlib.ExitStack()
        self.replicas, self.haproxy, self.postgres, self.store = {}, None, None, None
        self._servers, self._proxy, self.admins = [], None, []

    def __enter__(self):
        signal.signal(signal.SIGTERM, lambda *_: sys.exit(128 + signal.SIGTERM))  # so that nothing stays behind
        with contextlib.ExitStack() as stack:
            self._stack = stack
            self._start_postgres()
            self._stack = stack.pop_all()
        return self

    def __exit__(self, *_):
        self._stack.close()

    def _spawn(self, command, **options):
        log = open(self._folder / "log", "ab")
        self._stack.callback(log.close)
        process = subprocess.Popen([str(word) for word in command], stdout=log, stderr=log, stdin=subprocess.DEVNULL,
                                   **options)
        self._stack.callback(process.wait)
        self._stack.callback(process.terminate)
        return process

    # ---- PostgreSQL

    def _start_postgres(self):
        """It refuses to run as root, and belongs to a user of its own then."""
        data, user = self._folder / "postgres", {}
        data.mkdir(mode=0o700)
        if os.geteuid() == 0:
            entry = pwd.getpwnam("postgres")
            user = {"user": entry.pw_uid, "group": entry.pw_gid, "extra_groups": []}
            os.chown(data, entry.pw_uid, entry.pw_gid)
            os.chmod(self._folder, 0o755)
        subprocess.run([POSTGRES / "initdb", "-D", data, "-U", "sightline", "-A", "trust", "-E", "UTF8", "--locale=C"],
                       check=True, stdout=subprocess.DEVNULL, cwd="/", **user)
        port = free_port()
        server = self._spawn([POSTGRES / "postgres", "-D", data, "-k", "", "-h", "127.0.0.1", "-p", port,
                              "-c", "max_connections=80"], cwd="/", **user)
        self.postgres = server.pid
        wait_for(lambda: subprocess.run([POSTGRES / "pg_isready", "-q", "-h", "127.0.0.1", "-p", str(port)]).returncode == 0,
                 server, "PostgreSQL")
        self.store = f"postgresql://sightline@127.0.0.1:{port}/postgres"

    # ---- replicas

    @contextlib.contextmanager
    def server(self, store=True):
        """One server more; yields its port and its pid."""
        port, process, _ = self._start_server(store)
        try:
            yield port, process.pid
        finally:
            process.terminate()
            process.wait()

    def _start_server(self, store):
        port, admin = free_port(), free_port()
        command = [self._sightlined, "--listen", f"127.0.0.1:{port}", "--admin", f"127.0.0.1:{admin}", "--threads", THREADS,
                   "--log-level", "warn"]
        process = self._spawn(command + (["--store", self.store] if store else []))
        wait_for(lambda: listens(port), process, "sightlined")
        return port, process, admin

    def renew(self):
        """New replicas in the place of the old ones: they know the scenes that the database has by now, and have loaded none."""
        for process in self._servers:
            process.terminate()
        for process in self._servers:
            process.wait()
        started = [self._start_server(True) for _ in NAMES]
        self._servers = [process for _, process, _ in started]
        self.admins = [admin for _, _, admin in started]
        self.replicas = {port: process.pid for port, process, _ in started}

    def endpoints(self):
        return ",".join(f"127.0.0.1:{port}" for port in self.replicas)

    # ---- HAProxy

    def start_haproxy(self, bound=None):
        """deploy/haproxy/haproxy.cfg, with hash-balance-factor if there is a bound. Returns its endpoint."""
        if self._proxy is not None:
            self._proxy.kill()
            self._proxy.wait()
        text = (ROOT / "deploy/haproxy/haproxy.cfg").read_text()
        if bound is not None:
            text = text.replace("  hash-type consistent\n", f"  hash-type consistent\n  hash-balance-factor {round(100 * bound)}\n")
        self.statistics = self._folder / "haproxy"
        text = text.replace("global\n", f"global\n  stats socket {self.statistics}\n", 1)
        config = self._folder / "haproxy.cfg"
        config.write_text(text)
        port = free_port()
        names = {"SIGHTLINE_BIND": f"127.0.0.1:{port}"}
        for name, replica, admin in zip(NAMES, self.replicas, self.admins):
            names[f"SIGHTLINE_REPLICA_{name}"] = f"127.0.0.1:{replica}"
            names[f"SIGHTLINE_ADMIN_{name}"] = str(admin)
        self._proxy = self._spawn(["haproxy", "-db", "-f", config], env={**os.environ, **names})
        self.haproxy = self._proxy.pid
        wait_for(lambda: listens(port), self._proxy, "HAProxy")
        return f"127.0.0.1:{port}"
