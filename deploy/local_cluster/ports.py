"""Ports that a cluster takes, while others may start on this machine."""

import contextlib
import socket


class Claims:
    """Ports that this command has found free, and that no other command finds free until this one ends. By then the cluster's
    programs listen on them. Without a claim, a second cluster that starts before they do would choose the same ports."""

    def __init__(self):
        self._held = contextlib.ExitStack()

    def take(self, ports):
        """Whether all are free, and this command's now; else it has none of them."""
        with contextlib.ExitStack() as held:
            for port in ports:
                # A name that is no file: it goes with the process, and belongs to the network namespace, as ports do.
                claim = held.enter_context(socket.socket(socket.AF_UNIX))
                if not (_binds(claim, f"\0sightline-cluster-port-{port}") and _is_free(port)):
                    return False
            self._held.push(held.pop_all())
            return True


def _binds(taker, address):
    try:
        taker.bind(address)
    except OSError:
        return False
    return True


def _is_free(port):
    with socket.socket() as probe:
        probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        return _binds(probe, ("127.0.0.1", port))
