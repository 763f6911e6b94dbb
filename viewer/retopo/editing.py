"""The editing of a network of quads: an editor at work in a thread, the lists of fills, and what is
asked of it, which makes a script."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from concurrent.futures import Executor, Future, ThreadPoolExecutor
from concurrent.futures import wait as wait_for
from dataclasses import dataclass, replace
from typing import Any, Protocol

from patterndb.errors import PatternDBError
from patterndb.geometry.surface import Surface
from patterndb_sketch.retopo.editor import Call, Outcome, Retopology, State
from patterndb_sketch.retopo.filling import FilledNetwork, RetopoMesh
from patterndb_sketch.retopo.filling.choice import Choice, Flow
from patterndb_sketch.retopo.filling.edgecounts import side_lengths
from patterndb_sketch.retopo.filling.fills import LISTED, filling_of, rank_fills
from patterndb_sketch.retopo.network import Network, Patch
from patterndb_sketch.retopo.sizes import Sizes
from patterndb_sketch.retopo.symmetry import Plane
from patterndb_sketch.retopo.tool import ToolWork
from query.engine import PatternSource
from viewer.background import Stoppable, StoppedError
from viewer.card import format_count
from viewer.retopo.body import NetworkBody


@dataclass(frozen=True, slots=True, eq=False)
class Shown:
    """What there is to see: curves as they are, and the quads that are known.

    work:   the state, and the surface that tools work on.
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

    def __init__(self, editor: Retopology) -> None:
        self._editor = editor
        self.worker = ThreadPoolExecutor(1, thread_name_prefix="retopology")
        self._asked: deque[tuple[Call, Future[Outcome]]] = deque()
        self._stoppable = Stoppable()
        self.lists = FillLists(self.worker)
        empty = FilledNetwork(editor.network, {})
        body = NetworkBody.made_of(empty, editor.surface, editor.mesh(empty))
        self.shown = self._now(empty, body, editor.state.plane, not editor.network.patches)
        self._first: Future[None] | None = None
        if editor.network.patches:
            self._first = self.worker.submit(self._fill)

    def ask(self, call: Call) -> None:
        """Have a call obeyed after those before it."""
        self._asked.append((call, self.worker.submit(self._obey, call)))

    def begin(self, state: State) -> None:
        """Begin from another state on the same surface; nothing can be undone."""
        self.wait()
        self._first = self.worker.submit(self._restore, state)

    def drop(self) -> int:
        """Drop the calls that were not begun; how many there were."""
        kept = [one for one in self._asked if not one[1].cancel()]
        dropped = len(self._asked) - len(kept)
        self._asked = deque(kept)
        return dropped

    def stop(self) -> bool:
        """Stop the call that is at work, as if it had not been; False if there is none."""
        return self._stoppable.stop()

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
        self.worker.shutdown(wait=True, cancel_futures=True)

    def _restore(self, state: State) -> None:
        before = self.shown
        self._editor.restore(state)
        self.shown = self._now(before.filled, before.body, before.plane, False)
        self._fill()

    def _obey(self, call: Call) -> Outcome:
        editor, before, kept = self._editor, self.shown, self._editor.keep_history()
        try:
            with self._stoppable.running():
                outcome = editor.do(call)
                if outcome.changed:
                    self.shown = self._now(before.filled, before.body, before.plane, False)
                    self._fill()
                return outcome
        except PatternDBError as error:
            return Outcome(False, str(error))
        except (StoppedError, SystemError):
            if not self._stoppable.stopped:
                raise
            editor.return_to(kept)
            self.shown = before
            return Outcome(False, f"{call.tool} was stopped; nothing is changed")

    def _fill(self) -> None:
        editor = self._editor
        found = editor.fill()
        body = NetworkBody.made_of(found, editor.surface, editor.mesh(found))
        self.shown = self._now(found, body, editor.state.plane, True)

    def _now(
        self, filled: FilledNetwork, body: NetworkBody, plane: Plane | None, fresh: bool
    ) -> Shown:
        """The editor as it is."""
        editor = self._editor
        work = ToolWork(editor.state, editor.surface_now, editor.source, editor.half)
        return Shown(work, filled, body, plane, fresh, editor.undoable, editor.redoable)


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
        self.worker = worker
        self._found: dict[Key, tuple[Choice, ...]] = {}
        self._wanted: tuple[Key, Future[tuple[Choice, ...]]] | None = None

    def want(self, network: Network, patch: Patch, source: PatternSource) -> None:
        """Have a patch's list found, if it is not known and no other is being found."""
        key = _key(network, patch)
        if key not in self._found and self._wanted is None:
            self._wanted = key, self.worker.submit(_listed, network, patch, source)

    @property
    def searching(self) -> bool:
        """Is a list wanted that is not there yet?"""
        return self._wanted is not None

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

    def choices(self, network: Network, patch: Patch) -> tuple[Choice, ...]:
        """The fills of a patch's list, () while they are not known."""
        return self._found.get(_key(network, patch), ())

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


#: Seconds that a call is waited for: what is done at once is shown at once.
AT_ONCE = 0.05


class RetopoFiles(Protocol):
    """Writes what is worked on, and says where it is; ``tick`` is called often, and may write
    what is to be found after a crash, or says why it cannot. Else OSError as writing does.

    lost: what a crash left, on the same surface; None if it left nothing."""

    lost: State | None

    def save_session(self, surface: Surface, state: State) -> str: ...
    def read_again(self, surface: Surface) -> State: ...
    def save_mesh(self, mesh: RetopoMesh) -> str: ...
    def save_script(self, calls: tuple[Call, ...]) -> str: ...
    def tick(self, state: State) -> str: ...


class RetopoEditing:
    """An editor, and calls of its tools.

    message: what was refused last and why, or what should be known. calls: those that changed
    something, in order; None if they do not begin from the bare surface, and are no script of
    what there is. files: for keys that save.
    """

    def __init__(self, editor: Retopology, files: RetopoFiles | None) -> None:
        self.surface = editor.surface
        self.message = ""
        self.files = files
        bare = all(chain.marked for chain in editor.network.chains.values())
        self.calls: tuple[Call, ...] | None = () if bare and not editor.undoable else None
        self.work = EditorWorker(editor)
        self._seen = self.work.shown
        self._saved = self._seen.state
        self._patches = len(self.network.patches)

    def close(self) -> None:
        """Wait until nothing is being made any more."""
        self.work.close()

    @property
    def shown(self) -> Shown:
        """What there is to see."""
        return self.work.shown

    @property
    def network(self) -> Network:
        return self.shown.state.network

    @property
    def sizes(self) -> Sizes:
        return self.shown.state.sizes

    @property
    def waiting(self) -> int:
        """Calls that are not done with."""
        return self.work.waiting

    @property
    def working(self) -> tuple[str, ...]:
        """Their tools, in order; the first is at work."""
        return self.work.tools

    @property
    def unsaved(self) -> bool:
        """Has anything changed since the session was saved?"""
        return not self.shown.state.same(self._saved)

    def list_empty(self) -> tuple[int, ...]:
        """The patches that have no quads, none of them while quads are made."""
        shown = self.shown
        if not shown.fresh:
            return ()
        return tuple(sorted(shown.state.network.patches.keys() - shown.filled.placed.keys()))

    def want_list(self, patch: int) -> None:
        """Have the list of a patch's fills found, if it is not known."""
        found = self.network.patches.get(patch)
        if found is not None:
            self.work.lists.want(self.network, found, self.shown.work.source)

    def list_choices(self, patch: int) -> tuple[Choice, ...]:
        """The fills that a patch can have, () while they are not known."""
        found = self.network.patches.get(patch)
        return () if found is None else self.work.lists.choices(self.network, found)

    def place_in_list(self, patch: int) -> ListPlace | None:
        """Which of its fills a patch has; None while that is not known."""
        return self.work.lists.place(self.network, self.network.patches[patch])

    def do(self, tool: str, **arguments: object) -> None:
        """Call a tool; what it comes to is shown as soon as it is there."""
        self.work.ask(Call(tool, arguments))
        self.work.wait(AT_ONCE)
        self.take()

    def take(self) -> bool:
        """Take what has been done since this was asked last; True if there is something new."""
        done = self.work.done()
        for call, outcome in done:
            self._told(call, outcome)
        shown = self.work.shown
        new, self._seen = shown is not self._seen, shown
        return self.work.lists.take() or new or bool(done)

    def tick(self) -> bool:
        """Time goes on: what a crash would lose may be written. True if that cannot be."""
        said = "" if self.files is None else self.files.tick(self.shown.state)
        self.message = said or self.message
        return bool(said)

    def undo(self) -> None:
        """One step back."""
        self.do("undo")

    def redo(self) -> None:
        """One step forward again."""
        self.do("redo")

    def save_session(self) -> bool:
        """Save the session; False if that cannot be."""
        state = self.shown.state
        done = self._save("sessions", lambda files: files.save_session(self.surface, state))
        if done:
            self._saved = state
        return done

    def reload(self) -> None:
        """Go on from what the session's file holds by now; PatternDBError or OSError if it cannot
        be read."""
        if self.files is None:
            self.message = "sessions cannot be read here"
            return
        found = self.files.read_again(self.surface)
        self.work.begin(found)
        self._saved = found
        self.calls = None
        self.message = "this is what the file holds; what was done here is gone"

    def save_mesh(self) -> None:
        """Save the quads."""
        shown = self.shown
        if self.files is not None and not shown.fresh:
            self.message = "the quads are still being made; save them in a moment"
        elif self.files is not None and not shown.filled.placed:
            self.message = "there are no quads to save; close a loop of curves"
        else:
            self._save("meshes", lambda files: files.save_mesh(shown.body.mesh))

    def save_script(self) -> None:
        """Save all calls since the window was opened."""
        calls = self.calls
        if self.files is not None and calls is None:
            self.message = "this did not begin from the bare surface: a script would not make it"
        elif self.files is not None and not calls:
            self.message = "nothing has been done that a script could do again"
        else:
            self._save("scripts", lambda files: files.save_script(calls or ()))

    def recover(self) -> None:
        """Go on from what a crash left; only before anything else is done."""
        found = None if self.files is None else self.files.lost
        if self.files is None or found is None:
            self.message = "there is nothing that a crash left"
        elif self.shown.undoable or self.waiting:
            self.message = "undo what has been done first: the recovered session replaces it"
        else:
            self.work.begin(found)
            self.files.lost = None
            self.calls = None
            self.message = (
                "this is what the crash left; s saves it, and its file goes then. A script would "
                "not make it: none is recorded"
            )

    def drop_waiting(self) -> bool:
        """Drop what was asked for and has not begun, or else stop what has; False if nothing is
        being made."""
        if not self.waiting:
            return False
        dropped = self.work.drop()
        if dropped:
            self.message = f"dropped: {format_count(dropped, 'step')} that had not begun"
        elif self.work.stop():
            self.message = "stopping …"
        else:
            self.message = "the first quads are made; that is not stopped"
        return True

    def _save(self, what: str, save: Callable[[RetopoFiles], str]) -> bool:
        """Save something, and say where or why not; True if it is saved."""
        if self.files is None:
            self.message = f"{what} cannot be saved here"
            return False
        try:
            self.message = save(self.files)
        except OSError as error:
            self.message = f"not saved: {error}"
            return False
        return True

    def _told(self, call: Call, outcome: Outcome) -> None:
        # Open ends are seen as such, and every first curve of a patch has some.
        notes = [note for note in outcome.notes if note not in outcome.ends]
        if outcome.refused is not None:
            self.message = outcome.refused
        elif notes:
            self.message = "; ".join(notes)
        elif not outcome.changed:
            self.message = f"{call.tool}: nothing changed"
        elif call.tool == "symmetry":
            self.message = self._tell_symmetry()
        if outcome.changed and self.calls is not None:
            self.calls = (*self.calls, call)
        self._patches = len(self.network.patches)

    def _tell_symmetry(self) -> str:
        """Tell what became of the patches when symmetry was switched."""
        on = self.shown.state.plane is not None
        now, before = len(self.network.patches), self._patches
        said = "symmetry is on: one half is worked on" if on else "symmetry is off"
        if now == before:
            return said
        return f"{said}; {before} patches became {now}: undo takes it back"
