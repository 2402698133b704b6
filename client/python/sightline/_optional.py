"""Packages that only some calls need."""

from __future__ import annotations

import importlib
from typing import Any


def optional_module(name: str, caller: str) -> Any:
    """A module. Error: ImportError, it is not installed, with what installs it."""
    try:
        return importlib.import_module(name)
    except ImportError as error:
        raise ImportError(f"{caller} needs {name}: pip install {name}, or on Debian apt install python3-{name} ({error})",
                          name=name) from None
