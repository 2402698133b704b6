"""A private server, for notebooks and tests, that ends with this process."""

from __future__ import annotations

import atexit
import os
import pathlib
import subprocess
import tempfile
import time
from typing import Any, Iterable, Optional

from . import errors
from ._programs import find_program
from .client import Client, connect

# The shell starts the server and stops it when its own standard input ends, however this process ends.
_GUARD = 'exec 3<&0; "$@" 3<&- & server=$!; (cat <&3 >/dev/null; kill "$server" 2>/dev/null) & wait "$server"'
_PAUSE = 0.01  # seconds


class Server:
    """Listens on a Unix socket that only this user can reach. Leaving `with`, close(), and the end of this process, also
    by a signal, stop it."""

    def __init__(self, program: str, options: "Iterable[str]", start_timeout: float):
        self._folder = tempfile.TemporaryDirectory(prefix="sightline-")
        folder = pathlib.Path(self._folder.name)
        self.endpoint = f"unix:{folder / 'socket'}"  #: for connect()
        self._log = folder / "log"
        self._client: Optional[Client] = None
        ready = folder / "port"
        command = [program, "--listen", self.endpoint, "--port-file", str(ready), *options]
        with self._log.open("w") as log:
            self._guard = subprocess.Popen(["/bin/sh", "-c", _GUARD, "sh", *command], stdin=subprocess.PIPE,
                                           stdout=log, stderr=log, start_new_session=True)
        atexit.register(self.close)
        try:
            self._wait(ready, start_timeout)
        except BaseException:
            self.close()
            raise

    def _wait(self, ready: pathlib.Path, seconds: float) -> None:
        end = time.monotonic() + seconds
        while not (ready.exists() and ready.stat().st_size):
            if self._guard.poll() is not None:
                raise errors.Unavailable(f"the server did not start: {self.log().strip()[-2000:]}")
            if time.monotonic() > end:
                raise errors.DeadlineExceeded(f"the server did not start within {seconds:g} s")
            time.sleep(_PAUSE)

    @property
    def client(self) -> Client:
        """A client of it, made when first asked for."""
        if self._client is None:
            self._client = connect(self.endpoint, token="")
        return self._client

    def log(self) -> str:
        """What the server has printed."""
        return self._log.read_text(errors="replace")

    def close(self) -> None:
        """Stops the server. Its scenes are gone, unless it has a data directory."""
        atexit.unregister(self.close)
        if self._client is not None:
            self._client.close()
            self._client = None
        if self._guard.stdin is not None:
            self._guard.stdin.close()
        self._guard.wait()
        self._folder.cleanup()

    def __enter__(self) -> "Server":
        return self

    def __exit__(self, *_: Any) -> None:
        self.close()

    def __repr__(self) -> str:
        return f"<sightlined at {self.endpoint}>"


def serve(program: Optional[str] = None, *, threads: Optional[int] = None, data_dir: "str | os.PathLike[str] | None" = None,
          options: "Iterable[str]" = (), start_timeout: float = 30) -> Server:
    """Starts a server of one's own; `serve().client` is connected to it.

    program: the path of sightlined; default: SIGHTLINED, else the one that this package was installed with, else it is looked
    for in PATH. threads, data_dir: its flags; without data_dir, scenes are in memory only. options: further flags. Errors:
    FileNotFoundError, there is no such program; Unavailable, it ended at once, with what it printed; DeadlineExceeded, in
    seconds.
    """
    found = find_program("sightlined", program, "SIGHTLINED")
    flags = list(options)
    if threads is not None:
        flags += ["--threads", str(threads)]
    if data_dir is not None:
        flags += ["--data-dir", os.fspath(data_dir)]
    return Server(found, flags, start_timeout)
