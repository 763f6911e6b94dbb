"""What this process is at, for whoever shows it: work of seconds says its name and share."""

from __future__ import annotations

from collections.abc import Callable, Generator
from contextlib import contextmanager

#: What is underway, the innermost last: its name, and the share of it that is done, 0..1.
_UNDERWAY: list[list[tuple[str, float]]] = []


@contextmanager
def told_underway(name: str) -> Generator[Callable[[float], None]]:
    """Tell, within the block, that work of this name is underway; yields what is told its share."""
    own = [(name, 0.0)]
    _UNDERWAY.append(own)

    def tell(share: float) -> None:
        own[0] = (name, share)

    try:
        yield tell
    finally:
        _UNDERWAY.remove(own)


def describe_underway() -> str | None:
    """Say what is underway and how far it is, or None where nothing is."""
    try:
        name, share = _UNDERWAY[-1][0]
    except IndexError:  # it ended in between
        return None
    return f"{name}: {share:.0%}"
