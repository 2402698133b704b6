"""Where the programs are: beside this package in a wheel that has them, else in PATH."""

from __future__ import annotations

import os
import pathlib
import shutil
from typing import Optional

# The wheel of deploy/wheel puts them there; other installations have no such folder.
_BUNDLED = pathlib.Path(__file__).resolve().parents[1] / "sightline_programs" / "bin"
_PACKAGES = {"sightlined": "sightline-server", "sightline": "sightline-client"}


def find_program(name: str, given: Optional[str], variable: str) -> str:
    """The path of `name`, which is sightlined or sightline: what was given, else what the environment's variable says,
    else the program of the wheel, else the one in PATH. Error: FileNotFoundError, there is none."""
    chosen = given or os.environ.get(variable)
    if chosen:
        found = shutil.which(chosen)
        if found is None:
            raise FileNotFoundError(f"{chosen} is not a program: set {variable} to the path of {name}")
        return found
    bundled = _BUNDLED / name
    if bundled.exists():
        if not os.access(bundled, os.X_OK):
            raise FileNotFoundError(f"{bundled} is not executable: install the wheel by pip, which keeps its modes")
        return str(bundled)
    found = shutil.which(name)
    if found is None:
        raise FileNotFoundError(
            f"there is no {name}: this package was installed without programs, and PATH has none. Install a wheel that "
            f"has them (its name has the platform in it; deploy/wheel makes one), or the Debian package "
            f"{_PACKAGES[name]}; or set {variable} to the path of {name}")
    return found
