"""Warnings that point at the line of the user's program."""

from __future__ import annotations

import os
import sys
import warnings
from typing import Type

from ._scope import CallScope, scope

_PACKAGE = os.path.dirname(os.path.abspath(__file__)) + os.sep


class PrecisionWarning(UserWarning):
    """Coordinates are float32 and lie so far from the origin that this moves them noticeably: vertices, the origins of
    rays, or points."""


class FileWarning(UserWarning):
    """What a scene file may have that was not imported, or was changed."""


def warn(message: str, category: "Type[Warning]" = UserWarning) -> None:
    """Names the line that called the package. In a task of sightline.aio the warning waits until the task goes on."""
    calls = scope.get()
    if calls is not None:
        calls.warnings.append((message, category))
    else:
        warnings.warn(message, category, stacklevel=2 + _own_frames())


def give(calls: CallScope) -> None:
    """The warnings of a task's calls, in that task."""
    told, calls.warnings = calls.warnings, []
    for message, category in told:
        warnings.warn(message, category, stacklevel=2 + _own_frames())


def _own_frames() -> int:
    """How many of the callers' frames, from the caller of this one's on, belong to the package."""
    count, frame = 0, sys._getframe(1).f_back
    while frame is not None and os.path.abspath(frame.f_code.co_filename).startswith(_PACKAGE):
        count, frame = count + 1, frame.f_back
    return count
