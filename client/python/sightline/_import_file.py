"""Scene files, which the command `sightline` imports: a confined process of it reads them."""

from __future__ import annotations

import json
import os
import subprocess
from typing import Any, Dict, List, Optional, Tuple

from . import errors
from ._connection import Connection
from ._scope import scope
from ._types import Path
from ._warnings import FileWarning, warn

_USAGE = 2  # the exit code of a command that was called in a wrong way


class _Running:
    """The command, as a call that a task of sightline.aio may cancel."""

    def __init__(self, process: "subprocess.Popen[str]"):
        self._process = process

    def cancel(self) -> None:
        self._process.terminate()


def import_file(connection: Connection, program: str, scene: str, file: Path, *, replace: bool, allow_empty: bool,
                up_axis: Optional[str], meters_per_unit: Optional[float], mobility: Optional[str],
                timeout: Optional[float]) -> None:
    """See Client.import_file."""
    path = os.path.abspath(os.fspath(file))
    with open(path, "rb"):  # OSError, as of other files of this process
        pass
    flags = ["--replace"] * replace + ["--allow-empty"] * allow_empty
    for flag, value in (("--up", up_axis), ("--meters-per-unit", meters_per_unit), ("--mobility", mobility)):
        flags += [] if value is None else [flag, str(value)]
    options, variables = connection.command_options(timeout)
    arguments = [program, *options, "--json", "scene", "import", *flags, "--", scene, path]
    out, told, status = _run(arguments, {**os.environ, **variables})
    if status != 0:
        error = _error(told, status)
        if isinstance(error, errors.AlreadyExists):
            error = errors.AlreadyExists(f"scene {scene} exists: replace=True imports in its place", "SCENE_EXISTS")
        raise error
    for warning in json.loads(out).get("warnings", ()):
        warn(str(warning.get("message", warning) if isinstance(warning, dict) else warning), FileWarning)


def _run(arguments: "List[str]", environment: "Dict[str, str]") -> "Tuple[str, str, int]":
    with subprocess.Popen(arguments, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                          text=True, errors="replace", env=environment) as process:
        running, current = _Running(process), scope.get()
        if current is not None:
            current.add(running)
        try:
            out, told = process.communicate()
        except BaseException:
            process.kill()
            raise
        finally:
            if current is not None:
                current.remove(running)
    if current is not None and current.cancelled:
        raise errors.Cancelled("the import was cancelled")
    return out, told, process.returncode


def _error(told: str, status: int) -> Exception:
    """What the command says on standard error: its last line is the error."""
    for line in reversed(told.splitlines()):
        try:
            error: "Dict[str, Any]" = json.loads(line)["error"]
        except (ValueError, KeyError, TypeError):
            continue
        message = ": ".join(filter(None, (error.get("message", ""), error.get("hint", ""))))
        if status == _USAGE:
            return ValueError(message)
        return errors.of_name(error.get("code", ""), message, error.get("reason", ""))
    return errors.Unknown(f"the command ended with exit code {status}: {told.strip()[-2000:]}")
