#!/usr/bin/env python3
"""HAProxy as deploy/haproxy/public.cfg has it: it passes calls on, bounds an address's connections, and floods do not get far.

public_proxy_test.py SIGHTLINED
"""

import os
import pathlib
import re
import socket
import subprocess
import sys
import tempfile
import time

from operator_files import DEPLOY, needs, run

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "server/floods"))
from frames import DATA, EMPTY_MESSAGE, END_HEADERS, END_STREAM, FLOODS, GREETING, HEADERS, INFO, PATIENCE, Peer, frame  # noqa: E402

MOST_CONNECTIONS = 64
MOST_KEPT = 96 << 20


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


def resident(process):
    return int(re.search(r"VmRSS:\s+(\d+)", pathlib.Path(f"/proc/{process.pid}/status").read_text())[1]) << 10


def connected(port):
    """A connection with TLS, or nothing where it is refused."""
    try:
        return Peer(port, tls=True)
    except OSError:
        return None


# The proxy refuses an address that connects more than 200 times in 10 s: who asks again at once is never let in.
BETWEEN_CALLS = 0.5


def wait_for(what, holds, pause=0.02):
    until = time.monotonic() + PATIENCE
    while not holds():
        if time.monotonic() > until:
            sys.exit(f"failed: {what}")
        time.sleep(pause)


def check_call(port):
    peer = connected(port)
    if peer is None:
        return False
    peer.send(GREETING + frame(HEADERS, END_HEADERS, 1, INFO) + frame(DATA, END_STREAM, 1, EMPTY_MESSAGE))
    answered = peer.wait(lambda: 1 in peer.answered)
    peer.close()
    return answered


def check_flood(port, name, processes):
    before = [resident(process) for process in processes]
    peer = connected(port)
    until = time.monotonic() + 3
    taken = peer.send(GREETING)
    for piece in FLOODS[name]():
        if not taken or time.monotonic() > until:
            break
        taken = peer.send(piece)
    peer.close()

    def kept():
        return max(resident(process) - size for process, size in zip(processes, before))

    # A busy server still works on what was sent when the flood ends; then it must give the memory back.
    at_end = kept()
    wait_for(f"{name}: {at_end} bytes are kept", lambda: kept() <= MOST_KEPT)
    print(f"{name}: {peer.sent / 1e6:.1f} MB sent, {at_end / 1e6:.0f} MB held at its end, {kept() / 1e6:.0f} MB kept", flush=True)


def is_closed(peer):
    try:
        return peer.recv(1) == b""
    except BlockingIOError:
        return False
    except OSError:
        return True


def check_connections(port):
    """Of so many at once, the proxy closes those beyond the limit."""
    peers = [socket.create_connection(("127.0.0.1", port)) for _ in range(MOST_CONNECTIONS + 36)]
    for peer in peers:
        peer.setblocking(False)
    wait_for("an address has too many connections", lambda: sum(is_closed(peer) for peer in peers) >= 36)
    for peer in peers:
        peer.close()


def main():
    needs("haproxy")
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        run("openssl", "req", "-x509", "-newkey", "ed25519", "-nodes", "-subj", "/CN=localhost", "-days", "2",
            "-keyout", folder / "key.pem", "-out", folder / "certificate.pem")
        (folder / "both.pem").write_text((folder / "certificate.pem").read_text() + (folder / "key.pem").read_text())
        port_file = folder / "port"
        with subprocess.Popen([sys.argv[1], "--listen", "127.0.0.1:0", "--threads", "1", "--port-file", port_file],
                              stderr=subprocess.DEVNULL) as server:
            wait_for("the server did not start", lambda: port_file.exists() and port_file.read_text().strip())
            port = free_port()
            environment = os.environ | {"SIGHTLINE_BIND": f"127.0.0.1:{port}", "SIGHTLINE_PEM": str(folder / "both.pem"),
                                        "SIGHTLINE_SERVER": f"127.0.0.1:{port_file.read_text().strip()}"}
            with subprocess.Popen(["haproxy", "-f", DEPLOY / "haproxy/public.cfg"], env=environment) as proxy:
                try:
                    wait_for("no call through the proxy", lambda: check_call(port), BETWEEN_CALLS)
                    for flood in ("rapid_reset", "streams", "continuation", "settings"):
                        check_flood(port, flood, (server, proxy))
                    check_connections(port)
                    wait_for("no call after the floods", lambda: check_call(port), BETWEEN_CALLS)
                finally:
                    proxy.kill()
                    server.kill()


if __name__ == "__main__":
    main()
