#!/usr/bin/env python3
"""Whether a page is there: yes with status 200 only, whatever else answers at the port."""

import socket
import sys
import threading

from operator_files import DEPLOY

sys.dont_write_bytecode = True
sys.path.insert(0, str(DEPLOY))
from local_cluster.processes import answers  # noqa: E402


def ask(reply):
    """What `answers` says of a server that replies to a request with reply(request)."""
    with socket.create_server(("127.0.0.1", 0)) as server:
        def serve():
            connection, _ = server.accept()
            with connection:
                connection.sendall(reply(connection.recv(65536)))
        thread = threading.Thread(target=serve)
        thread.start()
        found = answers(f"http://127.0.0.1:{server.getsockname()[1]}/ready")
        thread.join()
        return found


CASES = {
    "ready": (lambda _: b"HTTP/1.1 200 OK\r\nContent-Length: 0\r\n\r\n", True),
    "not ready": (lambda _: b"HTTP/1.1 503 Service Unavailable\r\nContent-Length: 0\r\n\r\n", False),
    "a connection to itself": (lambda request: request, False),
    "nothing": (lambda _: b"", False),
}
failed = [name for name, (reply, expected) in CASES.items() if ask(reply) != expected]
if failed:
    sys.exit(f"failed: {failed}")
