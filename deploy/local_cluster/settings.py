"""The directory of the local cluster, its ports, and what it remembers between two commands."""

import json
import os
import pathlib
import sys

from .ports import Claims

REPLICAS = ("a", "b", "c")
DATABASES = ("db1", "db2")
FIRST_PORT = 50151  # of the endpoint: where clients look without being told
_PORTS = ("endpoint", *REPLICAS, *(f"admin-{name}" for name in REPLICAS), *DATABASES, "prometheus")


class Failure(Exception):
    """Ends the command with this message."""


def say(text):
    print(f"cluster: {text}", file=sys.stderr, flush=True)


def default_directory():
    """PostgreSQL, which does not run as root, must be able to enter it: root's home is closed to others."""
    if os.geteuid() == 0:
        return pathlib.Path("/var/lib/sightline-cluster")
    state = os.environ.get("XDG_STATE_HOME") or pathlib.Path.home() / ".local/state"
    return pathlib.Path(state) / "sightline-cluster"


class Settings:
    """`ports` by name, and `primary`, the database server that takes writes; kept in state.json."""

    def __init__(self, directory):
        self.directory = directory
        self._claims = Claims()
        self.ports = {}
        self.primary = DATABASES[0]
        if self._file.exists():
            kept = json.loads(self._file.read_text())
            self.ports, self.primary = kept["ports"], kept["primary"]

    @property
    def _file(self):
        return self.directory / "state.json"

    @property
    def standby(self):
        return next(name for name in DATABASES if name != self.primary)

    @property
    def password_file(self):
        """Of PostgreSQL's user, for the replicas and for psql."""
        return self.directory / "pgpass"

    def save(self):
        """In one step, so that a command that is interrupted leaves the old state or the new one."""
        draft = self.directory / "state.json.new"
        draft.write_text(json.dumps({"ports": self.ports, "primary": self.primary}, indent=2) + "\n")
        draft.replace(self._file)

    def has_free_ports(self):
        """Whether there are ports already, and no other program has taken one. Nor does another cluster, until this command
        ends."""
        return bool(self.ports) and self._claims.take(self.ports.values())

    def choose_ports(self):
        """Ten in a row: those from SIGHTLINE_CLUSTER_PORT on, else the first that are free from FIRST_PORT on. No other cluster
        chooses one until this command ends."""
        wanted = os.environ.get("SIGHTLINE_CLUSTER_PORT")
        if wanted is not None and not wanted.isdigit():
            raise Failure(f"SIGHTLINE_CLUSTER_PORT is a port, not {wanted!r}")
        starts = [int(wanted)] if wanted else range(FIRST_PORT, FIRST_PORT + 2000, 20)
        for start in starts:
            ports = dict(zip(_PORTS, range(start, start + len(_PORTS))))
            if self._claims.take(ports.values()):
                self.ports = ports
                return
        raise Failure(f"of the ports from {starts[0]} on some are in use: set SIGHTLINE_CLUSTER_PORT to the first of "
                      f"{len(_PORTS)} free ones")
