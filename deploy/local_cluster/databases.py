"""PostgreSQL: one server that takes writes, and one that follows it and confirms every commit before it is acknowledged."""

import os
import secrets
import shutil
import signal
import subprocess
import time

from . import programs
from .processes import Process, as_user, postgres_user, wait_for
from .settings import DATABASES, Failure, say

USER = "sightline"
# A commit waits for the standby's disk. What is lost is noticed within seconds.
_SETTINGS = {
    "fsync": "on", "synchronous_commit": "on", "max_connections": "60", "shared_buffers": "64MB", "wal_level": "replica",
    "max_wal_senders": "8", "hot_standby": "on", "wal_sender_timeout": "5s", "wal_receiver_timeout": "5s",
    "wal_retrieve_retry_interval": "500ms", "listen_addresses": "127.0.0.1", "logging_collector": "off",
    "tcp_keepalives_idle": "5", "tcp_keepalives_interval": "2", "tcp_keepalives_count": "3",
    "wal_keep_size": "64MB", "password_encryption": "scram-sha-256",
}


def _sync(folder):
    """Its file system at once: PostgreSQL's programs do it file by file, which takes ten times as long."""
    subprocess.run(["sync", "--file-system", folder], check=True)


class Databases:
    """The two, of which Settings.primary takes writes."""

    def __init__(self, settings):
        self._settings = settings
        self._processes = {name: Process(settings.directory, name) for name in DATABASES}

    def process(self, name):
        return self._processes[name]

    @staticmethod
    def must_be_reachable(directory):
        """Failure: the user that PostgreSQL runs as cannot go there."""
        user = postgres_user()
        if user is not None and subprocess.run(["test", "-x", directory], check=False, **as_user(user)).returncode != 0:
            raise Failure(f"PostgreSQL runs as the user {user.pw_name}, who cannot enter {directory}: "
                          "name another directory in SIGHTLINE_CLUSTER_DIR")

    def up(self):
        """Starts both; makes the standby anew if it cannot follow the primary."""
        primary, standby = self._settings.primary, self._settings.standby
        if not (self._data(primary) / "PG_VERSION").exists():
            self._make(primary)
        self._start(primary)
        if self._query("SELECT count(*) FROM pg_database WHERE datname = 'sightline'") == "0":
            self._query("CREATE DATABASE sightline TEMPLATE template0 ENCODING 'UTF8'")
        if not self._follows(standby):
            self._make_standby(standby)
        self._query(f"ALTER SYSTEM SET synchronous_standby_names = 'ANY 1 ({standby})'")
        self._query("SELECT pg_reload_conf()")
        wait_for(self.is_synchronous, 30, "the standby did not become synchronous")

    def is_synchronous(self):
        """Whether commits wait for the standby, and it is there."""
        try:
            return self._query("SELECT sync_state FROM pg_stat_replication", seconds=3) in ("sync", "quorum")
        except Failure:
            return False

    def promote(self):
        """Makes the standby the primary. The old one is ended before, so that it takes no more writes."""
        old, new = self._settings.primary, self._settings.standby
        if self._processes[new].pid() is None:
            raise Failure(f"the standby, {new}, does not run: start the primary again with \"up\"")
        self._processes[old].send(signal.SIGKILL)
        wait_for(lambda: self._processes[old].pid() is None, 10, f"{old} did not end")
        # What the old one had acknowledged is here. Nothing confirms commits until "up" makes a standby.
        self._query("SELECT pg_promote(true, 60)", name=new, seconds=70)
        self._query("ALTER SYSTEM RESET synchronous_standby_names", name=new)
        self._query("SELECT pg_reload_conf()", name=new)
        self._settings.primary = new
        self._settings.save()

    def down(self):
        """The primary first, whose last commits the standby then has."""
        for name in (self._settings.primary, self._settings.standby):
            self._processes[name].stop(signal.SIGINT)

    def address(self):
        """For --store: both, of which the one that takes writes is used."""
        ports = self._settings.ports
        hosts = ",".join(f"127.0.0.1:{ports[name]}" for name in DATABASES)
        return f"postgresql://{USER}@{hosts}/sightline?passfile={self._settings.password_file}"

    # ---- one server

    def _data(self, name):
        return self._settings.directory / name / "data"

    def _password(self):
        """Of a line of pgpass; made when first asked for."""
        file = self._settings.password_file
        if not file.exists():
            self._write_private(file, f"*:*:*:{USER}:{secrets.token_hex(24)}\n")
        return file.read_text().strip().rpartition(":")[2]

    @staticmethod
    def _write_private(file, text):
        with open(os.open(file, os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o600), "w", encoding="ascii") as out:
            out.write(text)

    def _folder(self, name):
        """Of a server, and its own copy of the password file, which it follows the other with."""
        folder = self._settings.directory / name
        folder.mkdir(exist_ok=True)
        copy = folder / "pgpass"
        self._password()
        self._write_private(copy, self._settings.password_file.read_text())
        user = postgres_user()
        if user is not None:
            for path in (folder, copy):
                os.chown(path, user.pw_uid, user.pw_gid)
        return folder

    def _make(self, name):
        say(f"making {name}")
        folder = self._folder(name)
        secret = folder / "password"
        self._write_private(secret, self._password() + "\n")
        user = postgres_user()
        if user is not None:
            os.chown(secret, user.pw_uid, user.pw_gid)
        self._run(["initdb", "-D", self._data(name), "-U", USER, "-A", "scram-sha-256", f"--pwfile={secret}", "-E", "UTF8",
                   "--locale=C", "--data-checksums", "--no-instructions", "--no-sync"])
        secret.unlink()
        _sync(folder)

    def _start(self, name):
        """One that was killed recovers before it takes connections; a standby takes them when it has caught up enough."""
        settings = {**_SETTINGS, "port": self._settings.ports[name], "unix_socket_directories": "", "cluster_name": name}
        flags = [part for key, value in settings.items() for part in ("-c", f"{key}={value}")]
        for attempts_left in reversed(range(5)):
            try:
                self._processes[name].start([programs.postgres("postgres"), "-D", self._data(name), *flags], user=postgres_user())
                return self._processes[name].must_run_until(lambda: self._accepts(name), 60)
            except Failure:  # sessions of one that was killed may still be ending
                if attempts_left == 0:
                    raise
                time.sleep(1)

    def _accepts(self, name):
        done = subprocess.run([programs.postgres("pg_isready"), "-q", "-h", "127.0.0.1", "-p", str(self._settings.ports[name])],
                              check=False)
        return done.returncode == 0

    def _follows(self, name):
        """Whether this standby runs, or can be started, and streams from the primary."""
        if not (self._data(name) / "standby.signal").exists():
            return False  # there is none, or it was the primary before, and has what the new one does not know
        try:
            self._start(name)
            wait_for(self._streams, 10, f"{name} does not follow")
        except Failure as failure:
            say(f"{failure}; it is made anew")
            return False
        return True

    def _streams(self):
        return self._query("SELECT state FROM pg_stat_replication") == "streaming"

    def _make_standby(self, name):
        say(f"making {name}, the standby, from {self._settings.primary}")
        self._processes[name].stop(signal.SIGQUIT)
        folder = self._folder(name)
        shutil.rmtree(self._data(name), ignore_errors=True)
        source = f"host=127.0.0.1 port={self._settings.ports[self._settings.primary]} user={USER} passfile={folder / 'pgpass'}"
        self._run(["pg_basebackup", "-d", source, "-D", self._data(name), "-R", "-c", "fast", "-X", "stream", "--no-sync"])
        _sync(folder)
        self._start(name)

    @staticmethod
    def _run(command):
        done = subprocess.run([programs.postgres(command[0]), *map(os.fspath, command[1:])], cwd="/", check=False, text=True,
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT, **as_user(postgres_user()))
        if done.returncode != 0:
            raise Failure(f"{command[0]} failed: {done.stdout.strip()[-2000:]}")

    def _query(self, statement, name=None, seconds=60):
        """What psql prints for a statement: a line for each row."""
        port = self._settings.ports[name or self._settings.primary]
        address = f"host=127.0.0.1 port={port} dbname=postgres user={USER} connect_timeout=3 passfile={self._settings.password_file}"
        try:
            done = subprocess.run([programs.postgres("psql"), "-XAt", "-d", address, "-c", statement], check=False, text=True,
                                  stdout=subprocess.PIPE, stderr=subprocess.PIPE, timeout=seconds)
        except subprocess.TimeoutExpired:
            raise Failure(f"PostgreSQL did not answer {statement!r} within {seconds} s") from None
        if done.returncode != 0:
            raise Failure(f"{statement}: {done.stderr.strip()}")
        return done.stdout.strip()
