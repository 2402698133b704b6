"""Progress of long casts, by tqdm where it is installed."""

from __future__ import annotations

import contextlib
from typing import Any, Callable, Iterator, Optional, Union


@contextlib.contextmanager
def reporter(progress: "Union[bool, Callable[[int, Optional[int]], Any]]", total: Optional[int],
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
