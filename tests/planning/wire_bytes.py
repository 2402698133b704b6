"""Bytes on the wire of a ray and of its answer, as HAProxy counts them."""
import csv
import socket

import numpy as np
import sightline

from terrain import window_rays

REQUESTS = 50


def counted(path):
    """Bytes in and out of HAProxy's frontend so far."""
    with socket.socket(socket.AF_UNIX) as connection:
        connection.connect(str(path))
        connection.sendall(b"show stat\n")
        text = b"".join(iter(lambda: connection.recv(65536), b"")).decode()
    row = next(row for row in csv.DictReader(text.lstrip("# ").splitlines()) if row["svname"] == "FRONTEND")
    return np.array([int(row["bin"]), int(row["bout"])])


def wire_bytes(cluster, endpoint, scene, work):
    """request_bytes_ray and reply_bytes_ray."""
    def count():
        before = counted(cluster.statistics)
        client, random = sightline.connect(endpoint, token=""), np.random.default_rng(3)
        for _ in range(REQUESTS):
            client.scene(scene).cast(window_rays(random, work.rays, work.window), fields=("t", "node", "primitive"))
        client.close()
        return counted(cluster.statistics) - before

    request, reply = count() / (REQUESTS * work.rays)
    return {"request_bytes_ray": float(request), "reply_bytes_ray": float(reply)}
