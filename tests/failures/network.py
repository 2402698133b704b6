"""Faults of the network, in a network namespace of the suite's own: packets that are dropped (nftables) or late (tc)."""

import contextlib
import subprocess

_LATE = ("netem", "delay", "20ms", "5ms")
# Where the kernel has no netem: a line so slow that packets wait for each other.
_NARROW = ("tbf", "rate", "8mbit", "burst", "32kb", "latency", "300ms")


def _run(*command):
    subprocess.run(command, check=True, capture_output=True, text=True)


def start():
    _run("ip", "link", "set", "lo", "up")
    _run("nft", "add", "table", "inet", "faults")
    _run("nft", "add", "chain", "inet", "faults", "out", "{ type filter hook output priority 0; }")


@contextlib.contextmanager
def dropping(*rules):
    """Packets that match one of the rules are dropped. Connections stay, and hear nothing."""
    for rule in rules:
        _run("nft", "add", "rule", "inet", "faults", "out", *rule.split(), "drop")
    try:
        yield
    finally:
        _run("nft", "flush", "chain", "inet", "faults", "out")


def of_ports(*ports):
    """To and from these."""
    return [f"tcp {side} {port}" for port in ports for side in ("sport", "dport")]


def from_group(group, port):
    """From processes of a group to a port."""
    return f"meta skgid {group} tcp dport {port}"


def at_random(percent):
    return f"numgen random mod 100 < {percent}"


@contextlib.contextmanager
def slow():
    """Every packet is late. Yields how."""
    try:
        how = _LATE
        _run("tc", "qdisc", "add", "dev", "lo", "root", *how)
    except subprocess.CalledProcessError:
        how = _NARROW
        _run("tc", "qdisc", "add", "dev", "lo", "root", *how)
    try:
        yield " ".join(how)
    finally:
        _run("tc", "qdisc", "del", "dev", "lo", "root")
