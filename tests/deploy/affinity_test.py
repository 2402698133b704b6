#!/usr/bin/env python3
"""Scenes in a cluster have a replica each: together the replicas build what one server would, and when one is lost, its scenes move
and no other does.

affinity_test.py SIGHTLINED SIGHTLINE
"""

import json
import os
import signal
import sys

from cluster_operator import with_operator

SCENES = 30
MOST_BUILT = 1.1  # over what one server builds


def sheet(side):
    """An OBJ of 2 * side * side triangles."""
    lines = [f"v {x} {x * y % 7} {y}" for y in range(side + 1) for x in range(side + 1)]
    for y in range(side):
        for x in range(side):
            a, b = y * (side + 1) + x + 1, (y + 1) * (side + 1) + x + 1
            lines += [f"f {a} {a + 1} {b + 1}", f"f {a} {b + 1} {b}"]
    return "\n".join(lines) + "\n"


class Fleet:
    """The replicas, and what each has built."""

    def __init__(self, operator):
        self._operator = operator
        self.scenes = [f"scene{number}" for number in range(SCENES)]
        for number, scene in enumerate(self.scenes):
            (operator.folder / f"{scene}.obj").write_text(sheet(20 + number))
            operator.run(operator.sightline, "scene", "import", scene, f"{scene}.obj", quiet=True)

    def build_all(self):
        """As clients do, through the balancer."""
        for scene in self.scenes:
            self._operator.run(self._operator.sightline, "prefetch", scene, quiet=True)

    def built(self):
        """Of each living replica, by its port: the triangles that it has built, by scene."""
        ports = [replica["port"] for replica in self._operator.status()["replicas"] if replica["pid"] is not None]
        return {port: self._built_by(port) for port in ports}

    def _built_by(self, port):
        counts = {}
        for scene in self.scenes:
            stats = json.loads(self._operator.run(self._operator.sightline, "--endpoint", f"127.0.0.1:{port}", "stats", scene, "--json",
                                                  quiet=True))
            counts[scene] = stats["triangles_built"]
        return counts

    def triangles(self):
        return sum(2 * (20 + number) ** 2 for number in range(SCENES))


def owned(built):
    return {port: {scene for scene, count in counts.items() if count > 0} for port, counts in built.items()}


def tour(operator):
    operator.cluster("up", quiet=True)
    operator.environment["SIGHTLINE_ENDPOINT"] = operator.status()["endpoint"]
    fleet = Fleet(operator)
    fleet.build_all()
    built = fleet.built()
    share = sum(sum(counts.values()) for counts in built.values()) / fleet.triangles()
    before = owned(built)
    print(f"triangles built, over one server's: {share:.3f}; scenes of each replica: {[len(scenes) for scenes in before.values()]}")
    if not 1 <= share <= MOST_BUILT:
        sys.exit(f"failed: the replicas build {share:.3f} times what one server does")

    lost = next(replica for replica in operator.status()["replicas"] if before[replica["port"]])
    os.kill(lost["pid"], signal.SIGKILL)
    fleet.build_all()
    after = owned(fleet.built())
    moved = {port: after[port] - before[port] for port in after}
    print(f"scenes that moved when one was lost: {[len(scenes) for scenes in moved.values()]} of its {len(before[lost['port']])}")
    if set().union(*moved.values()) != before[lost["port"]]:
        sys.exit(f"failed: other scenes moved, or not all of the lost replica's: {moved}")
    if sum(map(len, moved.values())) != len(before[lost["port"]]):
        sys.exit(f"failed: a scene moved to more than one replica: {moved}")
    operator.cluster("down", "--delete", quiet=True)


with_operator(tour)
