#!/usr/bin/env python3
"""What a new operator does with deploy/cluster: up, import, cast, kill replicas while casting, status, down; prints a
transcript. No cast fails, and nothing is left running.

cluster_test.py SIGHTLINED SIGHTLINE
"""

import os
import signal
import sys
import threading

from cluster_operator import with_operator

QUAD = "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nf 1 2 3\nf 1 3 4\n"
RAYS = "".join(f"{x / 10},0.3,10,0,0,-1\n" for x in range(-9, 10))
CASTS_AROUND = 10  # before a replica is killed, and after


class Casting:
    """Casts again and again, and holds each answer against the first."""

    def __init__(self, operator, expected):
        self._operator, self._expected = operator, expected
        self._changed = threading.Condition()
        self._count, self._failure, self._ends = 0, None, False
        self._thread = threading.Thread(target=self._run)
        self._thread.start()

    def _run(self):
        while not self._ends and self._failure is None:
            try:
                failure = None if cast(self._operator) == self._expected else "another answer"
            except SystemExit as error:
                failure = str(error)
            with self._changed:
                self._count += 1
                self._failure = self._failure or failure
                self._changed.notify_all()

    def wait_for(self, count):
        """Until so many more casts have ended."""
        with self._changed:
            end = self._count + count
            self._changed.wait_for(lambda: self._count >= end or self._failure is not None)

    def end(self):
        self._ends = True
        self._thread.join()
        if self._failure is not None:
            sys.exit(f"failed: {self._failure} after {self._count} casts")
        print(f"{self._count} casts meanwhile, all with the same answer")


def kill_each_replica(operator, expected):
    casting = Casting(operator, expected)
    try:
        for number in range(3):
            casting.wait_for(CASTS_AROUND)
            pid = operator.status()["replicas"][number]["pid"]
            print(f"$ kill -9 {pid}")
            os.kill(pid, signal.SIGKILL)
            casting.wait_for(CASTS_AROUND)
            operator.cluster("status")
            if operator.status()["replicas"][number]["pid"] is not None:
                sys.exit("failed: the killed replica is said to run")
            operator.cluster("up")
    finally:
        casting.end()


def cast(operator):
    return operator.run(operator.sightline, "cast", "yard", "--in", "-", "--out", "-", stdin=RAYS, quiet=True)


def tour(operator):
    (operator.folder / "quad.obj").write_text(QUAD)
    operator.cluster("status", exit_code=3)
    operator.cluster("up")
    operator.cluster("up")
    status = operator.status()
    if not status["complete"] or len({replica["pid"] for replica in status["replicas"]}) != 3:
        sys.exit("failed: the cluster is not complete")
    operator.environment["SIGHTLINE_ENDPOINT"] = status["endpoint"]
    operator.run(operator.sightline, "scene", "import", "yard", "quad.obj", "--up", "z")
    expected = cast(operator)
    print(expected, end="")
    if ",1," not in expected:
        sys.exit("failed: nothing was hit")
    kill_each_replica(operator, expected)
    operator.cluster("promote")
    operator.cluster("up")
    if cast(operator) != expected or operator.status()["primary"]["name"] != "db2":
        sys.exit("failed: after the promotion")
    operator.cluster("restart")
    operator.cluster("status")
    operator.cluster("down")
    operator.cluster("up")
    if cast(operator) != expected:
        sys.exit("failed: the scene is lost")
    operator.cluster("down", "--delete")
    operator.cluster("status", exit_code=3)


with_operator(tour)
