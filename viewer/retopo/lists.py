"""Lists: which of the fills that a patch can have it has, found when there is time."""

from __future__ import annotations

from concurrent.futures import Executor, Future
from concurrent.futures import wait as wait_for
from dataclasses import dataclass, replace

from patterndb.errors import PatternDBError
from patterndb_sketch.retopo.filling.choice import Choice, Flow
from patterndb_sketch.retopo.filling.edgecounts import side_lengths
from patterndb_sketch.retopo.filling.fills import LISTED, filling_of, rank_fills
from patterndb_sketch.retopo.network import Network, Patch
from query.engine import PatternSource

#: What a list depends on: the patch, the edges of its sides, and its flow lines.
Key = tuple[int, tuple[int, ...], tuple[Flow, ...]]

#: Lists that are kept: stepping through one asks for it again and again.
KEPT = 16


@dataclass(frozen=True, slots=True)
class Place:
    """number: of the patch's fill in its list, from 0 on; None if it is not in it, as those that
    were split or imported are not. count: of the list. more: does it go on after that?"""

    number: int | None
    count: int
    more: bool


class Lists:
    """Lists of patches, each found in a thread that also does all else with the database."""

    def __init__(self, worker: Executor) -> None:
        self._worker = worker
        self._found: dict[Key, tuple[Choice, ...]] = {}
        self._wanted: tuple[Key, Future[tuple[Choice, ...]]] | None = None

    def want(self, network: Network, patch: Patch, source: PatternSource) -> None:
        """Have a patch's list found, if it is not known and no other is being found."""
        key = _key(network, patch)
        if key not in self._found and self._wanted is None:
            self._wanted = key, self._worker.submit(_listed, network, patch, source)

    def take(self) -> bool:
        """Take the list that was wanted; True if there is a new one."""
        if self._wanted is None or not self._wanted[1].done():
            return False
        key, future = self._wanted
        self._wanted = None
        if future.cancelled():
            return False
        while len(self._found) >= KEPT:
            del self._found[next(iter(self._found))]
        self._found[key] = future.result()
        return True

    def wait(self) -> None:
        """Until the list that was wanted is found."""
        if self._wanted is not None:
            wait_for([self._wanted[1]])

    def place(self, network: Network, patch: Patch) -> Place | None:
        """Where a patch's fill is in its list; None while that is not known."""
        found, choice = self._found.get(_key(network, patch)), filling_of(patch).choice
        if found is None or choice is None:
            return None
        plain = replace(choice, by="program")
        number = found.index(plain) if plain in found else None
        return Place(number, len(found), len(found) == LISTED)


def _key(network: Network, patch: Patch) -> Key:
    return patch.id, side_lengths(network, patch), filling_of(patch).flows


def _listed(network: Network, patch: Patch, source: PatternSource) -> tuple[Choice, ...]:
    try:
        return tuple(Choice.of(fill) for fill in rank_fills(network, patch, source))
    except PatternDBError:
        return ()
