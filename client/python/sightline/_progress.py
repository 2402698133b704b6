"""Progress of long casts, by tqdm where it is installed."""

from __future__ import annotations

import contextlib
from typing import Any, Callable, Iterator, Optional

from ._types import Progress


@contextlib.contextmanager
def reporter(progress: Progress, total: Optional[int],
             unit: str = "rays") -> "Iterator[Callable[[int], None]]":
    """A function to call with each part that is done. `progress`: a function of (done, total), where total is None if
    it is not known; or True, a bar by tqdm that counts in `unit`, nothing without tqdm."""
    if not isinstance(progress, bool):
        done, tell = 0, progress

        def report(more: int) -> None:
            nonlocal done
            done += more
            tell(done, total)

        yield report
        return
    bar = _bar(total, unit) if progress else None
    try:
        yield bar.update if bar is not None else lambda _: None
    finally:
        if bar is not None:
            bar.close()


def _bar(total: Optional[int], unit: str) -> Any:
    try:
        from tqdm.auto import tqdm
    except ImportError:
        return None
    return tqdm(total=total, unit=f" {unit}", unit_scale=True)


class Amount:
    """How much is done of what may grow, for `with`. `progress`: as of reporter()."""

    def __init__(self, progress: Progress, unit: str):
        self._tell = None if isinstance(progress, bool) else progress
        self._bar = _bar(None, unit) if progress is True else None

    def report(self, done: int, total: int) -> None:
        if self._tell is not None:
            self._tell(done, total)
        if self._bar is not None:
            self._bar.total = total
            self._bar.update(done - self._bar.n)

    def __enter__(self) -> "Amount":
        return self

    def __exit__(self, *_: Any) -> None:
        if self._bar is not None:
            self._bar.close()
