"""The programs sightline and sightlined, in the folder bin beside this file, and in lib the libraries that they need.

This package imports little, and nothing of `sightline`: the imports there take longer than most commands.
"""

import os
import sys

_BIN = os.path.join(os.path.dirname(os.path.realpath(__file__)), "bin")


def _become(name: str) -> None:
    """Replaces this process, so that signals and the exit code are the program's own."""
    program = os.path.join(_BIN, name)
    if not os.access(program, os.X_OK):
        sys.exit(f"{name}: {program} is missing or not executable: install the wheel by pip, which keeps modes")
    os.execv(program, [name, *sys.argv[1:]])


def sightline() -> None:
    _become("sightline")


def sightlined() -> None:
    _become("sightlined")
