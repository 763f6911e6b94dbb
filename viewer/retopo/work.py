"""Work: calls of tools, one after another in a thread, so that whoever looks on need not wait.

After every call all patches are filled, as scripts do: what is recorded gives the same mesh. A
call that is made while another is obeyed waits its turn.
"""

from __future__ import annotations

from collections import deque
from concurrent.futures import Executor, Future, ThreadPoolExecutor
from concurrent.futures import wait as wait_for
from dataclasses import dataclass, replace
from typing import Any

from patterndb.errors import PatternDBError
from patterndb_sketch.retopo.editor import Call, Editor, Outcome, State
from patterndb_sketch.retopo.filling import FilledNetwork
from patterndb_sketch.retopo.filling.choice import Choice, Flow
from patterndb_sketch.retopo.filling.edgecounts import side_lengths
from patterndb_sketch.retopo.filling.fills import LISTED, filling_of, rank_fills
from patterndb_sketch.retopo.network import Network, Patch
from patterndb_sketch.retopo.symmetry import Plane
from patterndb_sketch.retopo.tool import ToolWork
from query.engine import PatternSource
from viewer.retopo.body import NetworkBody


@dataclass(frozen=True, slots=True, eq=False)
class Shown:
    """What there is to see: curves as they are, and the quads that are known.

    work:   the state, and the ground that tools work on.
    filled: of this state, or of one before while new quads are made (``fresh`` is False).
    body:   the quads of ``filled``, to be drawn; plane: of symmetry, that they were made for.
    undoable, redoable: steps.
    """

    work: ToolWork
    filled: FilledNetwork
    body: NetworkBody
    plane: Plane | None
    fresh: bool
    undoable: int = 0
    redoable: int = 0

    @property
    def state(self) -> State:
        return self.work.state

    def stale(self) -> frozenset[int]:
        """Patches of ``filled`` that are not as they were: their quads are not to be seen."""
        if self.fresh:
            return frozenset()
        if self.plane != self.state.plane:
            return frozenset(self.filled.placed)
        now, then = self.state.network, self.filled.network
        gone: set[int] = set()
        for number in self.filled.placed:
            patch, former = now.patches.get(number), then.patches[number]
            if (
                patch is None
                or patch.loop != former.loop
                or patch.corners != former.corners
                or patch.choice != former.choice
                or any(
                    now.chains[half >> 1].count != then.chains[half >> 1].count
                    or now.chains[half >> 1].points is not then.chains[half >> 1].points
                    for half in patch.loop
                )
            ):
                gone.add(number)
        return frozenset(gone)


class EditorWorker:
    """Obeys calls in a thread.

    shown: what there is to see now; another object as soon as something has changed. lists: of the
    fills of patches.
    """

    def __init__(self, editor: Editor) -> None:
        self._editor = editor
        self._worker = ThreadPoolExecutor(1, thread_name_prefix="retopology")
        self._asked: deque[tuple[Call, Future[Outcome]]] = deque()
        self.lists = FillLists(self._worker)
        empty = FilledNetwork(editor.network, {})
        body = NetworkBody.made_of(empty, editor.ground, editor.mesh(empty))
        self.shown = self._now(empty, body, editor.state.plane, not editor.network.patches)
        self._first: Future[None] | None = None
        if editor.network.patches:
            self._first = self._worker.submit(self._fill)

    def ask(self, call: Call) -> None:
        """Have a call obeyed after those before it."""
        self._asked.append((call, self._worker.submit(self._obey, call)))

    def begin(self, state: State) -> None:
        """Begin from another state on the same ground; nothing can be undone."""
        self.wait()
        self._first = self._worker.submit(self._restore, state)

    def drop(self) -> int:
        """Drop the calls that were not begun; how many there were."""
        kept = [one for one in self._asked if not one[1].cancel()]
        dropped = len(self._asked) - len(kept)
        self._asked = deque(kept)
        return dropped

    @property
    def waiting(self) -> int:
        """Calls that are not done with."""
        return len(self._asked) + (self._first is not None)

    @property
    def tools(self) -> tuple[str, ...]:
        """Their tools, in order; the first is at work."""
        return tuple(call.tool for call, _ in self._asked)

    def wait(self, seconds: float | None = None) -> bool:
        """Until all is done; False if time ran out before."""
        futures: list[Future[Any]] = [future for _, future in self._asked]
        if self._first is not None:
            futures.append(self._first)
        return not wait_for(futures, seconds).not_done

    def done(self) -> list[tuple[Call, Outcome]]:
        """The calls that were obeyed since this was asked last; what went wrong is raised."""
        if self._first is not None and self._first.done():
            if not self._first.cancelled():
                self._first.result()
            self._first = None
        found: list[tuple[Call, Outcome]] = []
        while self._asked and self._asked[0][1].done():
            call, future = self._asked.popleft()
            # At the end what was not begun is dropped.
            if not future.cancelled():
                found.append((call, future.result()))
        return found

    def close(self) -> None:
        """Drop what was not begun, and wait for what was."""
        self._worker.shutdown(wait=True, cancel_futures=True)

    def _restore(self, state: State) -> None:
        before = self.shown
        self._editor.restore(state)
        self.shown = self._now(before.filled, before.body, before.plane, False)
        self._fill()

    def _obey(self, call: Call) -> Outcome:
        editor, before = self._editor, self.shown
        try:
            outcome = editor.do(call)
        except PatternDBError as error:
            return Outcome(False, str(error))
        if not outcome.changed:
            return outcome
        self.shown = self._now(before.filled, before.body, before.plane, False)
        self._fill()
        return outcome

    def _fill(self) -> None:
        editor = self._editor
        found = editor.fill()
        body = NetworkBody.made_of(found, editor.ground, editor.mesh(found))
        self.shown = self._now(found, body, editor.state.plane, True)

    def _now(
        self, filled: FilledNetwork, body: NetworkBody, plane: Plane | None, fresh: bool
    ) -> Shown:
        """The editor as it is."""
        editor = self._editor
        work = ToolWork(editor.state, editor.ground_now, editor.source, editor.half)
        return Shown(work, filled, body, plane, fresh, editor.undoable, editor.redoable)


# == Lists: which of the fills that a patch can have it has, found when there is time.

#: What a list depends on: the patch, the edges of its sides, and its flow lines.
Key = tuple[int, tuple[int, ...], tuple[Flow, ...]]

#: Lists that are kept: stepping through one asks for it again and again.
KEPT = 16


@dataclass(frozen=True, slots=True)
class ListPlace:
    """number: of the patch's fill in its list, from 0 on; None if it is not in it, as those that
    were split or imported are not. count: of the list. more: does it go on after that?"""

    number: int | None
    count: int
    more: bool


class FillLists:
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

    def place(self, network: Network, patch: Patch) -> ListPlace | None:
        """Where a patch's fill is in its list; None while that is not known."""
        found, choice = self._found.get(_key(network, patch)), filling_of(patch).choice
        if found is None or choice is None:
            return None
        plain = replace(choice, by="program")
        number = found.index(plain) if plain in found else None
        return ListPlace(number, len(found), len(found) == LISTED)


def _key(network: Network, patch: Patch) -> Key:
    return patch.id, side_lengths(network, patch), filling_of(patch).flows


def _listed(network: Network, patch: Patch, source: PatternSource) -> tuple[Choice, ...]:
    try:
        return tuple(Choice.of(fill) for fill in rank_fills(network, patch, source))
    except PatternDBError:
        return ()
