"""Somebody who types commands at a cluster on this machine, which is gone afterwards."""

import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile

from operator_files import DEPLOY, SKIPPED, needs


class Operator:
    """Types commands, and prints them with their output."""

    def __init__(self, folder, sightlined, sightline):
        self.folder = folder
        self.sightline = sightline
        self.environment = {**os.environ, "SIGHTLINE_CLUSTER_DIR": str(folder / "cluster"), "SIGHTLINED": sightlined}

    def run(self, *command, stdin="", exit_code=0, quiet=False):
        done = subprocess.run([*map(str, command)], cwd=self.folder, env=self.environment, input=stdin, text=True,
                              capture_output=True, check=False)
        if not quiet or done.returncode != exit_code:
            print("$", *command)
            print(done.stdout + done.stderr, end="", flush=True)
        if done.returncode != exit_code:
            sys.exit(f"failed: exit code {done.returncode}")
        return done.stdout

    def cluster(self, *arguments, exit_code=0, quiet=False):
        return self.run(DEPLOY / "cluster", *arguments, exit_code=exit_code, quiet=quiet)

    def status(self):
        return json.loads(self.cluster("status", "--json", quiet=True))


def processes_of(folder):
    """Command lines in which the folder of the cluster is named, as in those of all its parts."""
    lines = []
    for path in pathlib.Path("/proc").glob("[0-9]*/cmdline"):
        try:
            lines.append(path.read_bytes().replace(b"\0", b" ").decode(errors="replace"))
        except OSError:
            pass
    return [line for line in lines if str(folder) in line]


def with_operator(act):
    """Calls act(operator), which leaves no cluster behind. Arguments of the program: SIGHTLINED SIGHTLINE."""
    if not list(pathlib.Path("/usr/lib/postgresql").glob("*/bin/initdb")):
        print("skipped: there is no PostgreSQL")
        sys.exit(SKIPPED)
    os.environ["PATH"] += ":/usr/sbin"
    for program in ("haproxy", "prometheus"):
        needs(program)
    folder = pathlib.Path(tempfile.mkdtemp())
    folder.chmod(0o711)  # PostgreSQL may run as another user
    operator = Operator(folder, *sys.argv[1:3])
    try:
        act(operator)
        left = processes_of(folder)
        if left or (folder / "cluster").exists():
            sys.exit(f"failed: left behind: {left}")
    finally:
        subprocess.run([DEPLOY / "cluster", "down", "--delete"], env=operator.environment, check=False, capture_output=True)
        shutil.rmtree(folder, ignore_errors=True)
