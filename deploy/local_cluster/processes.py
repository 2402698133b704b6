"""Processes that go on after the command that started them, and are found again by number and start."""

import http.client
import os
import pathlib
import pwd
import signal
import subprocess
import time
import urllib.request

from .settings import Failure

PAUSE = 0.05  # seconds between two looks at something


def wait_for(condition, seconds, what):
    """Until `condition` holds, or a Failure that says what did not come."""
    end = time.monotonic() + seconds
    while not condition():
        if time.monotonic() > end:
            raise Failure(f"{what} within {seconds:g} s")
        time.sleep(PAUSE)


def _status(pid):
    """State and start of a process, in ticks since the machine started; None: there is none."""
    try:
        fields = pathlib.Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    except OSError:
        return None
    return fields[0], int(fields[19])


class Process:
    """One program of the cluster. Its number and start are in run/NAME, so that another process that gets the number later
    is not taken for it; its output is in log/NAME."""

    def __init__(self, directory, name):
        self.name = name
        self._record = directory / "run" / name
        self.log = directory / "log" / name

    def pid(self):
        """None: it does not run."""
        try:
            pid, start = map(int, self._record.read_text().split())
        except (OSError, ValueError):
            return None
        status = _status(pid)
        return pid if status is not None and status[0] not in "ZX" and status[1] == start else None

    def start(self, command, environment=None, user=None):
        """Starts it in a session of its own, unless it runs; one that was stopped by SIGSTOP goes on. `user`: a row of pwd, to
        run it as."""
        if self.pid() is not None:
            return self.send(signal.SIGCONT)
        for folder in (self._record.parent, self.log.parent):
            folder.mkdir(exist_ok=True)
        with self.log.open("a") as log:
            process = subprocess.Popen([os.fspath(part) for part in command], stdin=subprocess.DEVNULL, stdout=log, stderr=log,
                                       cwd="/", start_new_session=True, env={**os.environ, **(environment or {})},
                                       **as_user(user))
        status = _status(process.pid)
        self._record.write_text(f"{process.pid} {status[1] if status else 0}\n")
        process.returncode = 0  # it is not waited for: it outlives this command

    def send(self, number):
        pid = self.pid()
        if pid is not None:
            os.kill(pid, number)

    def ask_to_end(self, number=signal.SIGTERM):
        """Also where it was stopped by SIGSTOP."""
        self.send(number)
        self.send(signal.SIGCONT)

    def stop(self, number=signal.SIGTERM, seconds=20):
        """Asks it to end, and kills it if it does not."""
        if self.pid() is not None:
            self.ask_to_end(number)
            try:
                wait_for(lambda: self.pid() is None, seconds, f"{self.name} did not end")
            except Failure:
                self.kill()
        self._record.unlink(missing_ok=True)

    def kill(self):
        self.send(signal.SIGKILL)
        wait_for(lambda: self.pid() is None, 10, f"{self.name} did not end after SIGKILL")

    def last_words(self):
        """The end of its log, for a message."""
        return self.log.read_text(errors="replace")[-2000:].strip() if self.log.exists() else ""

    def must_run_until(self, condition, seconds):
        """Waits for `condition`. Failure, with the end of its log: it ended before, or is too slow."""
        def ready():
            if self.pid() is None:
                raise Failure(f"{self.name} ended: {self.last_words()}")
            return condition()
        wait_for(ready, seconds, f"{self.name} was not ready")


def as_user(user):
    """What subprocess needs to run a program as another user."""
    return {} if user is None else {"user": user.pw_uid, "group": user.pw_gid, "extra_groups": []}


def postgres_user():
    """PostgreSQL refuses to run as root: then it runs as Debian's user for it. None: as this user."""
    if os.geteuid() != 0:
        return None
    try:
        return pwd.getpwnam("postgres")
    except KeyError:
        raise Failure("PostgreSQL does not run as root, and there is no user \"postgres\"") from None


def answers(url):
    """Whether a page is there, with status 200."""
    try:
        with urllib.request.build_opener(urllib.request.ProxyHandler({})).open(url, timeout=2) as reply:
            return reply.status == 200
    except (OSError, http.client.HTTPException):  # a connection to a port that nobody has yet may be to itself, and answers itself
        return False
