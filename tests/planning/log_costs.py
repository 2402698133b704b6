"""Unit costs of the log, measured: an update at the replica that takes it and in PostgreSQL, a notice, a read of what is new."""
import pathlib
import re
import statistics
import subprocess
import time
import urllib.request

import numpy as np
import sightline

from own_cluster import POSTGRES
from processor_time import tree_used_s, used_s
from terrain import terrain

UPDATES, LISTENERS, NOTICES, READS = 400, 40, 2_000, 4_000
NOTIFY = "NOTIFY sightline, '1';\n"
READ = """\\set scene 1
\\set revision 1
SELECT revision, base, logged, base_logged FROM scene WHERE id = :scene AND removed = 0;
SELECT time, checksum, updates FROM batch WHERE scene = :scene AND revision = :revision;
"""


def send_updates(endpoint, name, used, streamed=False):
    """Moves the node of a scene: one update after the other, or as fast as a stream takes them. Returns the median seconds of an update
    (one after the other), and what each adds to `used`."""
    client, seconds = sightline.connect(endpoint, token=""), []
    scene = client.create_scene(name)
    node = scene.add(terrain(2_000, 77), name="part", mobility="rigid")
    poses = [np.hstack([np.eye(3), [[step], [0], [0]]]) for step in range(UPDATES)]
    before = used()
    if streamed:
        with scene.update_stream("mover") as stream:
            for pose in poses:
                stream.set_transforms([node], pose[None])
            stream.flush()
    else:
        for pose in poses:
            began = time.monotonic()
            scene.set_transforms([node], pose[None])
            seconds.append(time.monotonic() - began)
    spent = (used() - before) / UPDATES
    client.close()
    return statistics.median(seconds or [0.0]), spent


def transactions(admin):
    """Of a server's store, so far: how many, and how many updates they had."""
    with urllib.request.urlopen(f"http://127.0.0.1:{admin}/metrics", timeout=30) as reply:
        found = dict(re.findall(r"^(?:\w*_)?commit_batch_size_(count|sum) (\S+)$", reply.read().decode(), re.MULTILINE))
    return np.array([float(found["count"]), float(found["sum"])])


def commit_costs(cluster):
    """What a transaction and an update cost PostgreSQL: of updates one by one, and of a stream, which has many in a transaction."""
    port, pid = next(iter(cluster.replicas.items()))
    used = lambda: np.array([used_s([pid]), tree_used_s(cluster.postgres)])
    seconds, (writer, alone) = send_updates(f"127.0.0.1:{port}", "one-by-one", used)
    before = transactions(cluster.admins[0])
    _, (_, together) = send_updates(f"127.0.0.1:{port}", "streamed", used, streamed=True)
    commits, updates = transactions(cluster.admins[0]) - before
    commit = max(0.0, alone - together) / (1 - commits / updates)
    return {"update_write_s": float(writer), "commit_s": seconds, "database_commit_s": commit,
            "database_update_s": max(0.0, float(alone) - commit)}


def pgbench(store, script, transactions, folder):
    file = pathlib.Path(folder) / "pgbench.sql"
    file.write_text(script)
    subprocess.run([POSTGRES / "pgbench", "-n", "-M", "prepared", "-f", str(file), "-t", str(transactions), store], check=True,
                   stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


def notice_s(cluster, folder):
    """PostgreSQL's processor seconds for a notice, for each connection that listens."""
    def cost():
        before = tree_used_s(cluster.postgres)
        pgbench(cluster.store, NOTIFY, NOTICES, folder)
        return tree_used_s(cluster.postgres) - before

    alone = cost()
    listeners = [subprocess.Popen(["psql", "-q", cluster.store], stdin=subprocess.PIPE, text=True) for _ in range(LISTENERS)]
    try:
        for listener in listeners:
            listener.stdin.write("LISTEN sightline;\n")
            listener.stdin.flush()
        listening = "SELECT count(*) FROM pg_stat_activity WHERE query LIKE 'LISTEN sightline%' AND application_name = 'psql'"
        while int(subprocess.run(["psql", "-Atq", cluster.store, "-c", listening], check=True, capture_output=True, text=True).stdout) < LISTENERS:
            time.sleep(0.05)
        return max(0.0, cost() - alone) / NOTICES / LISTENERS
    finally:
        for listener in listeners:
            listener.stdin.close()
            listener.wait()


def read_s(cluster, folder):
    before = tree_used_s(cluster.postgres)
    pgbench(cluster.store, READ, READS, folder)
    return (tree_used_s(cluster.postgres) - before) / READS


def log_costs(cluster, folder):
    """The fields of Costs that concern the log. A follower applies what a server without a store applies: `update_follow_s` is all that
    such a server does for an update, with its call, and so rather too much."""
    found = commit_costs(cluster)
    with cluster.server(store=False) as (port, alone):
        _, found["update_follow_s"] = send_updates(f"127.0.0.1:{port}", "followed", lambda: used_s([alone]))
    return {**found, "database_notice_s": notice_s(cluster, folder), "database_read_s": read_s(cluster, folder)}
