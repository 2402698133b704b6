#!/usr/bin/env python3
"""Servers that share a scene call each other with TLS and the token of the caller, and answer as one; when one is stopped or lost, a cast
fails or is partial, as the caller chose.

secured_shards_test.py SIGHTLINED SIGHTLINE
"""

import contextlib
import pathlib
import shlex
import signal
import socket
import subprocess
import sys
import tempfile
import time

from operator_files import SKIPPED, needs
from own_credentials import make_credentials, shell
from own_postgres import CannotRun, own_postgres, wait_for

QUADS = 12
SERVERS = 3
LONG_S = 30  # far more than the few seconds that it takes, and less than one connection needs to be found dead for each cast


def row_of_quads():
    """An OBJ with a mesh for each, side by side."""
    lines = []
    for i in range(QUADS):
        lines += [f"o quad{i}", *(f"v {3 * i + x} {y} {i % 2}" for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1)))]
        lines += [f"f {4 * i + 1} {4 * i + 2} {4 * i + 3}", f"f {4 * i + 1} {4 * i + 3} {4 * i + 4}"]
    return "\n".join(lines) + "\n"


RAYS = "".join(f"{x / 5},0.3,10,0,0,-1\n" for x in range(15 * QUADS))


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


def listens(port):
    with socket.socket() as probe:
        return probe.connect_ex(("127.0.0.1", port)) == 0


@contextlib.contextmanager
def server(program, folder, store, port, *flags):
    """Of these rights and certificates; killed at the end."""
    command = [program, "--listen", f"127.0.0.1:{port}", "--store", store, "--threads", "1", "--log-level", "warn", "--tls-cert", "server.pem",
               "--tls-key", "server.key", "--tokens", "tokens.toml", *flags]
    with subprocess.Popen(command, cwd=folder) as process:
        try:
            wait_for(lambda: listens(port), process, "sightlined")
            yield process
        finally:
            process.kill()


def freeze(process, cast_without, is_whole):
    """Casts end soon while the process is stopped, and are whole soon after it goes on."""
    process.send_signal(signal.SIGSTOP)
    begun = time.monotonic()
    for flags in ("--allow-partial --time-budget 300", "", "--allow-partial", "--allow-partial --time-budget 300"):
        cast_without(flags)
    process.send_signal(signal.SIGCONT)
    if time.monotonic() - begun > LONG_S:
        sys.exit("failed: a server that is stopped held up casts")
    wait_for(is_whole, process, "the server that was stopped")


def tour(folder, sightlined, sightline):
    make_credentials(folder)
    (folder / "quads.obj").write_text(row_of_quads())
    ports = [free_port() for _ in range(SERVERS + 1)]
    peers = ",".join(f"127.0.0.1:{port}" for port in ports[:SERVERS])
    with own_postgres(folder) as store, contextlib.ExitStack() as servers:
        shards = [servers.enter_context(server(sightlined, folder, store, port, "--shard-peers", peers, "--shard-ca", "ca.pem"))
                  for port in ports[:SERVERS]]
        servers.enter_context(server(sightlined, folder, store, ports[SERVERS]))

        def client(port, token="reader"):
            return f"{shlex.quote(sightline)} --endpoint 127.0.0.1:{port} --tls-ca ca.pem" + (f" --token-file {token}.token" if token else "")

        def cast(port, flags="", ends="", **options):
            return shell(folder, f"{client(port)} cast row {flags} --fields t,node,primitive {ends}", RAYS, **options)

        shell(folder, f"{client(ports[0], 'operator')} scene import row quads.obj --up z --quiet")
        alone = cast(ports[SERVERS])
        if any(cast(port) != alone for port in ports[:SERVERS]):
            sys.exit("failed: servers that share the scene answer in another way")
        shell(folder, f"{client(ports[0], None)} cast row", RAYS, fails=True)  # no token

        freeze(shards[2], lambda flags="": cast(ports[0], flags, fails=True), lambda: cast(ports[0], "", ends="|| true") == alone)
        shards[2].kill()
        shards[2].wait()
        cast(ports[0], fails=True)
        partial = cast(ports[0], "--allow-partial", fails=True)
        rows = list(zip(partial.splitlines(), alone.splitlines()))
        missing = [row for row, whole in rows if row != whole]
        if len(partial.splitlines()) != len(alone.splitlines()) or not 0 < len(missing) < len(rows) / 2:
            sys.exit(f"failed: {len(missing)} of {len(rows)} rows are not as before")
        if any(not row.startswith("-inf,") for row in missing):
            sys.exit("failed: a ray that is not answered is not marked")


def main():
    needs("openssl")
    with tempfile.TemporaryDirectory() as folder:
        pathlib.Path(folder).chmod(0o711)  # PostgreSQL may run as another user
        try:
            tour(pathlib.Path(folder), *sys.argv[1:3])
        except CannotRun as missing:
            print(f"skipped: {missing}")
            sys.exit(SKIPPED)


main()
