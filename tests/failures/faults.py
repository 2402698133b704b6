"""What is done to the cluster. Each fault does its harm, holds it while clients go on, and mends it."""

import dataclasses
import grp
import signal
import subprocess
import time
from typing import Callable

import network

_DISK = "size=700m"  # of the primary's small disk


@dataclasses.dataclass(frozen=True)
class Fault:
    """`run(subject, hold)`: `hold()` lets clients go on for a while. `prepare(subject)`: before they start. `unnoticed`: no call may
    fail, as only a replica is lost, or nothing."""

    name: str
    run: Callable
    prepare: Callable = lambda subject: None
    unnoticed: bool = False


def _none(_, hold):
    hold()


def _kill_replica(subject, hold):
    subprocess.run(["kill", "-9", str(subject.replica()["pid"])], check=True)
    hold()
    subject.up()


def _stop_replica(subject, hold):
    pid = str(subject.replica()["pid"])
    subprocess.run(["kill", "-STOP", pid], check=True)
    hold()
    subprocess.run(["kill", "-CONT", pid], check=True)


def _kill(part):
    def run(subject, hold):
        subject.kill(part)
        hold()
        subject.up()
    return run


def _stop(part):
    def run(subject, hold):
        subject.signal(part, signal.SIGSTOP)
        hold()
        subject.signal(part, signal.SIGCONT)
    return run


def _lose_primary(number):
    """As the runbook says: a primary that does not answer is ended, and the standby promoted."""
    def run(subject, hold):
        subject.signal("primary", number)
        time.sleep(2)  # until an operator, or a program, has noticed
        subject.command("promote")
        hold()
        subject.up()
    return run


def _cut_replica_from_clients(subject, hold):
    replica = subject.replica()
    with network.dropping(*network.of_ports(replica["port"], replica["admin_port"])):
        hold()


def _cut_replica_from_databases(subject, hold):
    group = subject.replica()["port"]
    status = subject.status()
    with network.dropping(*(network.from_group(group, status[part]["port"]) for part in ("primary", "standby"))):
        hold()


def _cut_replica_from_all(subject, hold):
    replica, status = subject.replica(), subject.status()
    with network.dropping(*network.of_ports(replica["port"], replica["admin_port"]),
                          *(network.from_group(replica["port"], status[part]["port"]) for part in ("primary", "standby"))):
        hold()


def _cut_standby(subject, hold):
    group = grp.getgrnam("postgres").gr_gid
    with network.dropping(network.from_group(group, subject.status()["primary"]["port"])):
        hold()


def _cut_primary_from_all(subject, hold):
    with network.dropping(*network.of_ports(subject.status()["primary"]["port"])):
        time.sleep(2)
        subject.command("promote")
        hold()
    subject.up()


def _lose_packets(_, hold):
    with network.dropping(network.at_random(3)):
        hold()


def _slow_network(_, hold):
    with network.slow() as how:
        print(f"    packets go through {how}", flush=True)
        hold()


def _move_primary_to_small_disk(subject):
    """The standby is made anew there, and promoted."""
    subject.kill("standby")
    folder = subject.directory_of("standby")
    subprocess.run(["rm", "-rf", folder / "data"], check=True)
    subprocess.run(["mount", "-t", "tmpfs", "-o", _DISK, "small", folder], check=True)
    subject.up()
    subject.command("promote")
    subject.up()


def _fill_disk(subject, hold):
    filler = subject.directory_of("primary") / "filler"
    subprocess.run(["dd", "if=/dev/zero", f"of={filler}", "bs=64k"], check=False, capture_output=True)
    hold()
    filler.unlink()
    subject.up()


def _rolling_restart(subject, hold):
    hold()
    subject.restart()
    hold()


def _rolling_upgrade(subject, hold):
    hold()
    subject.restart("now")
    hold()


FAULTS = (
    Fault("none", _none, unnoticed=True),
    Fault("kill-replica", _kill_replica, unnoticed=True),
    Fault("stop-replica", _stop_replica, unnoticed=True),
    Fault("cut-replica-from-clients", _cut_replica_from_clients, unnoticed=True),
    Fault("cut-replica-from-databases", _cut_replica_from_databases, unnoticed=True),
    Fault("cut-replica-from-all", _cut_replica_from_all, unnoticed=True),
    Fault("rolling-restart", _rolling_restart, unnoticed=True),
    Fault("rolling-upgrade", _rolling_upgrade, lambda subject: subject.restart("previous"), unnoticed=True),
    Fault("kill-haproxy", _kill("haproxy")),
    Fault("stop-haproxy", _stop("haproxy")),
    Fault("kill-standby", _kill("standby")),
    Fault("stop-standby", _stop("standby")),
    Fault("cut-standby-from-primary", _cut_standby),
    Fault("kill-primary", _lose_primary(signal.SIGKILL)),
    Fault("stop-primary", _lose_primary(signal.SIGSTOP)),
    Fault("cut-primary-from-all", _cut_primary_from_all),
    Fault("lose-packets", _lose_packets),
    Fault("slow-network", _slow_network),
    Fault("full-disk-of-primary", _fill_disk, _move_primary_to_small_disk),
)
