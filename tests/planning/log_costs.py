"""Unit costs of the log, measured: an update at the replica that takes it and in PostgreSQL, a notice, a read of what is new."""
import pathlib
import statistics
import subprocess
import time

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


def send_updates(endpoint, name):
    """Moves the node of a scene, one update after the other. Returns the seconds that each took."""
    client, seconds = sightline.connect(endpoint, token=""), []
    vertices, faces = terrain(2_000, 77)
    client.create_scene(name)
    scene = client.scene(name)
    node = scene.add((vertices, faces), name="part", mobility="rigid")
    pose = np.eye(3, 4)
    for step in range(UPDATES):
        pose[0, 3] = step
        began = time.monotonic()
        scene.set_transforms([node], pose[None])
        seconds.append(time.monotonic() - began)
    client.close()
    return seconds


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
            listener.stdin.write("LISTEN sightline;\n\\echo listens\n")
            listener.stdin.flush()
        listening = f"SELECT count(*) FROM pg_stat_activity WHERE query LIKE 'LISTEN sightline%' AND application_name = 'psql'"
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
    port, pid = next(iter(cluster.replicas.items()))
    before = used_s([pid]), tree_used_s(cluster.postgres)
    seconds = send_updates(f"127.0.0.1:{port}", "log")
    found = {"update_write_s": (used_s([pid]) - before[0]) / UPDATES,
             "database_update_s": (tree_used_s(cluster.postgres) - before[1]) / UPDATES, "commit_s": statistics.median(seconds)}
    with cluster.server(store=False) as (port, pid):
        begun = used_s([pid])
        send_updates(f"127.0.0.1:{port}", "log")
        found["update_follow_s"] = (used_s([pid]) - begun) / UPDATES
    return {**found, "database_notice_s": notice_s(cluster, folder), "database_read_s": read_s(cluster, folder)}
