"""A PostgreSQL server for a test, as a process of the test. It listens at a Unix socket in a folder of its own, and at no port."""
import contextlib
import os
import pathlib
import pwd
import subprocess
import time

PROGRAMS = pathlib.Path("/usr/lib/postgresql/15/bin")
_WAIT_S = 60


class CannotRun(Exception):
    """A program is missing, or does not start."""


def wait_for(holds, process, what):
    end = time.monotonic() + _WAIT_S
    while not holds():
        if process.poll() is not None or time.monotonic() > end:
            raise CannotRun(f"{what} does not start")
        time.sleep(0.02)


@contextlib.contextmanager
def own_postgres(folder):
    """Yields its address for --store, and ends it at last. The server refuses to run as root, and runs as the user postgres then,
    who must be able to enter the folder."""
    if not (PROGRAMS / "initdb").exists():
        raise CannotRun(f"there is no {PROGRAMS / 'initdb'}")
    data, user = pathlib.Path(folder) / "postgres", {}
    data.mkdir(mode=0o700)
    if os.geteuid() == 0:
        entry = pwd.getpwnam("postgres")
        user = {"user": entry.pw_uid, "group": entry.pw_gid, "extra_groups": []}
        os.chown(data, entry.pw_uid, entry.pw_gid)
    subprocess.run([PROGRAMS / "initdb", "-D", data, "-U", "sightline", "-A", "trust", "-E", "UTF8", "--locale=C"],
                   check=True, stdout=subprocess.DEVNULL, cwd="/", **user)
    command = [PROGRAMS / "postgres", "-D", data, "-k", data, "-h", "", "-c", "max_connections=80"]
    with subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, cwd="/", **user) as process:
        try:
            ready = [PROGRAMS / "pg_isready", "-q", "-h", data]
            wait_for(lambda: subprocess.run(ready, check=False).returncode == 0, process, "PostgreSQL")
            yield f"postgresql://sightline@/postgres?host={data}"
        finally:
            process.terminate()
