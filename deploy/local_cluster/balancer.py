"""HAProxy before the replicas, with the configuration that deploy/haproxy has for every installation."""

import socket

from . import programs
from .processes import Process
from .settings import REPLICAS


class Balancer:
    def __init__(self, settings):
        self._settings = settings
        self.process = Process(settings.directory, "haproxy")
        self._socket = settings.directory / "haproxy.sock"

    def up(self):
        ports = self._settings.ports
        environment = {"SIGHTLINE_BIND": f"127.0.0.1:{ports['endpoint']}"}
        for name in REPLICAS:
            environment[f"SIGHTLINE_REPLICA_{name.upper()}"] = f"127.0.0.1:{ports[name]}"
            environment[f"SIGHTLINE_ADMIN_{name.upper()}"] = str(ports[f"admin-{name}"])
        own = self._settings.directory / "haproxy.cfg"  # what a machine adds: here the socket on which it tells its state
        own.write_text(f"global\n  stats socket {self._socket} mode 600\n")
        self.process.start([programs.find("haproxy"), "-f", programs.DEPLOY / "haproxy/haproxy.cfg", "-f", own], environment)
        self.process.must_run_until(lambda: any(map(self.uses, REPLICAS)), 30)

    def uses(self, name):
        """Whether it sends calls to this replica."""
        for line in self._ask("show stat").splitlines():
            fields = line.split(",")
            if fields[:2] == ["replicas", name]:
                return fields[17] == "UP"
        return False

    def _ask(self, command):
        """Its answer; empty: there is none."""
        try:
            with socket.socket(socket.AF_UNIX) as connection:
                connection.settimeout(2)
                connection.connect(str(self._socket))
                connection.sendall(command.encode() + b"\n")
                return b"".join(iter(lambda: connection.recv(65536), b"")).decode()
        except OSError:
            return ""

    def down(self):
        self.process.stop(seconds=5)
