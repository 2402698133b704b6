"""The cluster that is made to fail: deploy/cluster in namespaces of the suite's own, and what its parts are at the moment."""

import json
import os
import pathlib
import signal
import stat
import subprocess
import time
import urllib.request

DEPLOY = pathlib.Path(__file__).resolve().parent.parent.parent / "deploy"
# Each replica has a group of its own, its port, by which packets are told apart.
_IN_GROUP = '#!/bin/sh\n# $2: HOST:PORT to listen on\nexec setpriv --regid="${{2##*:}}" --clear-groups {program} "$@"\n'

_CLEAR = 10000  # rays after which it is clear who gets most of them


class Subject:
    def __init__(self, folder, program, previous):
        self.folder = folder
        self._environment = {**os.environ, "SIGHTLINE_CLUSTER_DIR": str(folder / "cluster")}
        self._programs = {}
        for name, path in (("now", program), ("previous", previous or program)):
            script = folder / f"sightlined-{name}"
            script.write_text(_IN_GROUP.format(program=path.resolve()))
            script.chmod(script.stat().st_mode | stat.S_IXUSR)
            self._programs[name] = script

    def command(self, *arguments):
        """A command of deploy/cluster. Failure ends the suite."""
        done = subprocess.run([DEPLOY / "cluster", *arguments], env=self._environment, text=True, capture_output=True, check=False)
        if done.returncode != 0:
            raise RuntimeError(f"deploy/cluster {' '.join(arguments)}: {done.stderr.strip()}")
        return done.stdout

    def up(self):
        self.command("up", "--sightlined", str(self._programs["now"]))

    def restart(self, which="now"):
        """One replica after the other, with the version "now" or "previous"."""
        self.command("restart", "--sightlined", str(self._programs[which]))

    def end(self):
        self.command("down")
        for name in ("db1", "db2"):  # a fault may have put one on a disk of its own
            subprocess.run(["umount", self.folder / "cluster" / name], check=False, capture_output=True)
        self.command("down", "--delete")

    def status(self):
        return json.loads(self.command("status", "--json"))

    def endpoints(self):
        """HAProxy's, and the list of the replicas."""
        status = self.status()
        return status["endpoint"], ",".join(f"127.0.0.1:{replica['port']}" for replica in status["replicas"])

    def signal(self, part, number):
        """To a part of the status, such as "primary"."""
        os.kill(self.status()[part]["pid"], number)

    def kill(self, part):
        self.signal(part, signal.SIGKILL)

    def replica(self):
        """The one that HAProxy sends the casts to: the others get only those of clients with a list."""
        def rays(replica):
            url = f"http://127.0.0.1:{replica['admin_port']}/metrics"
            with urllib.request.urlopen(url, timeout=10) as reply:
                lines = reply.read().decode().splitlines()
            return sum(float(line.split()[-1]) for line in lines if line.startswith("sightline_rays_total{"))
        replicas = self.status()["replicas"]
        before = [rays(replica) for replica in replicas]
        grown = [0.0]
        while max(grown) < _CLEAR:
            time.sleep(0.1)
            grown = [rays(replica) - was for replica, was in zip(replicas, before)]
        return replicas[grown.index(max(grown))]

    def directory_of(self, part):
        """Of a database server: "primary" or "standby"."""
        return self.folder / "cluster" / self.status()[part]["name"]
