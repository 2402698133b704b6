"""Where servers listen: one address, or those of several replicas."""

from __future__ import annotations

import ipaddress
import socket
from typing import List, Optional, Tuple

from . import errors


class Endpoint:
    """HOST:PORT, several of these with commas between, or unix:PATH; ValueError for other texts."""

    def __init__(self, text: str):
        self.text = text
        self._addresses: "List[Tuple[str, str]]" = []
        if text.startswith("unix:") and len(text) > len("unix:"):
            return
        for address in text.split(","):
            host, _, port = address.rpartition(":")
            if not (host and port.isdigit() and int(port) < 65536):
                raise ValueError(f"an endpoint is HOST:PORT[,HOST:PORT...] or unix:PATH, not {text!r}")
            self._addresses.append((host.strip("[]"), port))

    def is_local(self) -> bool:
        """Whether what is sent stays on this machine."""
        return all(_is_loopback(host) for host, _ in self._addresses)

    def is_balanced(self) -> bool:
        """Whether there are several servers, or may be: a name can have several addresses."""
        if len(self._addresses) != 1:
            return len(self._addresses) > 1
        host = self._addresses[0][0]
        return not _is_loopback(host) and not _is_address(host)

    def target(self) -> str:
        """What gRPC connects to. The names of a list are resolved here, once."""
        if len(self._addresses) <= 1:
            return self.text
        for scheme, family, form in (("ipv4", socket.AF_INET, "{}:{}"), ("ipv6", socket.AF_INET6, "[{}]:{}")):
            hosts = [_resolve(host, family) for host, _ in self._addresses]
            if None not in hosts:
                return scheme + ":" + ",".join(form.format(host, port) for host, (_, port) in zip(hosts, self._addresses))
        raise errors.Unavailable(f"the hosts of {self.text!r} do not all have an address of one family")

    def authority(self) -> str:
        """The name that servers of a list must have in their certificates: the first host. Empty: the target's."""
        return self._addresses[0][0] if len(self._addresses) > 1 else ""


def _is_address(host: str) -> bool:
    try:
        ipaddress.ip_address(host)
        return True
    except ValueError:
        return False


def _is_loopback(host: str) -> bool:
    return ipaddress.ip_address(host).is_loopback if _is_address(host) else host == "localhost"


def _resolve(host: str, family: int) -> "Optional[str]":
    try:
        return str(socket.getaddrinfo(host, None, family, socket.SOCK_STREAM)[0][4][0])
    except OSError:
        return None
