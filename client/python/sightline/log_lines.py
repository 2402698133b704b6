"""Lines of the server's log."""

from __future__ import annotations

from typing import NamedTuple, Tuple


class LogLines(NamedTuple):
    """The end of the server's log, oldest line first. `first` is the number of the first of `lines`; numbers go up by
    one, and `last`, for the next call, is the last of them."""

    first: int
    lines: Tuple[str, ...]

    @property
    def last(self) -> int:
        return self.first + len(self.lines) - 1 if self.lines else max(self.first - 1, 0)
