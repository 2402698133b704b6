"""Where the programs are."""

from __future__ import annotations

import os
import shutil
from typing import Optional


def find_program(name: str, given: Optional[str], variable: str) -> str:
    """The path of `name`, which is sightlined or sightline: what was given, else what the environment's variable says,
    else the one in PATH. Error: FileNotFoundError, there is none."""
    chosen = given or os.environ.get(variable) or name
    found = shutil.which(chosen)
    if found is None:
        raise FileNotFoundError(f"{chosen} is not a program: set {variable} to the path of {name}")
    return found
