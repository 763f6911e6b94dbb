"""Progress of long work in this process, for the line that a command draws."""

from __future__ import annotations

from collections.abc import Callable, Generator
from contextlib import contextmanager

#: Names and finished shares (0 to 1) of what runs, the innermost last.
_RUNNING: list[list[tuple[str, float]]] = []


@contextmanager
def report_progress(name: str) -> Generator[Callable[[float], None]]:
    """Report work of this name while the block runs; yields a function that takes its share."""
    own = [(name, 0.0)]
    _RUNNING.append(own)

    def set_share(share: float) -> None:
        own[0] = (name, share)

    try:
        yield set_share
    finally:
        _RUNNING.remove(own)


def describe_progress() -> str | None:
    """Return what runs and how far it is, or None where nothing does."""
    try:
        name, share = _RUNNING[-1][0]
    except IndexError:  # it ended in between
        return None
    return f"{name}: {share:.0%}"
