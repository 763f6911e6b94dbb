"""A retopology at work in a thread, with what a user looks at and does meanwhile.

:class:`RetopoEditing` is what a window drives, and a script can: calls wait in a queue and can be
dropped or stopped, the quads of the state before stay to be seen (:class:`Snapshot`) until new ones
are made, patches have lists of fills to page through, and a call can be previewed. What a crash
would lose is kept by its :class:`~patterndb_sketch.retopo.files.RetopoFiles`.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from concurrent.futures import wait as wait_for
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

from patterndb.errors import PatternDBError
from patterndb_sketch.background import Latest, Stoppable, StoppedError
from patterndb_sketch.retopo.editor import Call, Outcome, Retopology, State
from patterndb_sketch.retopo.files import RetopoFiles
from patterndb_sketch.retopo.filling import FilledNetwork
from patterndb_sketch.retopo.filling.choice import Choice, Flow
from patterndb_sketch.retopo.filling.edgecounts import side_lengths
from patterndb_sketch.retopo.filling.fills import LISTED, filling_of, rank_fills
from patterndb_sketch.retopo.filling.surface import FilledSurface
from patterndb_sketch.retopo.network import Network, Patch
from patterndb_sketch.retopo.previews import CURVE_PREVIEWS, Preview, preview_call
from patterndb_sketch.retopo.sizes import Sizes
from patterndb_sketch.retopo.symmetry import Plane
from patterndb_sketch.retopo.tool import ToolWork
from query.engine import PatternSource

#: Seconds that a call is waited for: what is done at once is shown at once.
AT_ONCE = 0.05

#: Seconds that a preview is waited for.
LIVE = 0.03

#: Lists of fills that are kept: stepping through one asks for it again and again.
KEPT_LISTS = 16


@dataclass(frozen=True, slots=True, eq=False)
class Snapshot:
    """Curves as they are, and the quads that are known.

    work:   the state, and the surface that tools work on.
    filled: of this state, or of one before while new quads are made (``fresh`` is False).
    body:   the quads of ``filled`` as a surface; plane: of symmetry, that they were made for.
    undoable, redoable: steps.
    """

    work: ToolWork
    filled: FilledNetwork
    body: FilledSurface
    plane: Plane | None
    fresh: bool
    undoable: int = 0
    redoable: int = 0

    @property
    def state(self) -> State:
        return self.work.state

    def stale(self) -> frozenset[int]:
        """Return the patches of ``filled`` that are not as they were: their quads are gone."""
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


#: What a list depends on: the patch, the edges of its sides, and its flow lines.
ListKey = tuple[int, tuple[int, ...], tuple[Flow, ...]]


@dataclass(frozen=True, slots=True)
class ListPlace:
    """number: of the patch's fill in its list, from 0 on; None if it is not in it, as those that
    were split or imported are not. count: of the list. more: does it go on after that?"""

    number: int | None
    count: int
    more: bool


class RetopoEditing:
    """A retopology whose tools are called, in a thread; one for each window.

    message: why the last call was rejected, or what should be known. calls: those that changed
    something, in order; None if they do not begin from the bare surface, and so are no script of
    the state. shown: the snapshot to be seen; another object as soon as something has changed.
    files: where work is saved, None for nowhere.
    """

    def __init__(self, editor: Retopology, files: RetopoFiles | None = None) -> None:
        self.surface = editor.surface
        self.message = ""
        self.files = files
        bare = all(chain.marked for chain in editor.network.chains.values())
        self.calls: tuple[Call, ...] | None = () if bare and not editor.undoable else None
        self._editor = editor
        # It alone asks the database: lists of fills are found between two calls.
        self._worker = ThreadPoolExecutor(1, thread_name_prefix="retopology")
        self._asked: deque[tuple[Call, Future[Outcome]]] = deque()
        self._stoppable = Stoppable()
        self._lists: dict[ListKey, tuple[Choice, ...]] = {}
        self._list: tuple[ListKey, Future[tuple[Choice, ...]]] | None = None
        self._previews: Latest[Preview] = Latest("previewing")
        self._preview: Preview | None = None
        empty = FilledNetwork(editor.network, {})
        body = FilledSurface.from_filled(empty, editor.surface, editor.mesh(empty))
        self.shown = self._now(empty, body, editor.state.plane, not editor.network.patches)
        self._seen = self.shown
        self._saved = self.shown.state
        self._patches = len(self.network.patches)
        self._first: Future[None] | None = None
        if editor.network.patches:
            self._first = self._worker.submit(self._fill)

    def close(self) -> None:
        """Drop what was not begun, and wait for what was."""
        self._previews.close()
        self._worker.shutdown(wait=True, cancel_futures=True)

    @property
    def network(self) -> Network:
        return self.shown.state.network

    @property
    def sizes(self) -> Sizes:
        return self.shown.state.sizes

    @property
    def waiting(self) -> int:
        """Return how many calls are not done with."""
        return len(self._asked) + (self._first is not None)

    @property
    def working(self) -> tuple[str, ...]:
        """Return their tools, in order; the first is at work."""
        return tuple(call.tool for call, _ in self._asked)

    @property
    def unsaved(self) -> bool:
        """Has anything changed since the session was saved?"""
        return not self.shown.state.same(self._saved)

    def list_empty(self) -> tuple[int, ...]:
        """Return the patches that have no quads, none of them while quads are made."""
        shown = self.shown
        if not shown.fresh:
            return ()
        return tuple(sorted(shown.state.network.patches.keys() - shown.filled.placed.keys()))

    # Calls

    def do(self, tool: str, **arguments: object) -> None:
        """Call a tool after the calls before; its result is shown as soon as it is there."""
        call = Call(tool, arguments)
        self._asked.append((call, self._worker.submit(self._obey, call)))
        self.wait(AT_ONCE)
        self.take()

    def undo(self) -> None:
        """Take one step back."""
        self.do("undo")

    def redo(self) -> None:
        """Take one step forward again."""
        self.do("redo")

    def wait(self, seconds: float | None = None) -> bool:
        """Wait until all calls are done; False if time ran out before."""
        futures: list[Future[Any]] = [future for _, future in self._asked]
        if self._first is not None:
            futures.append(self._first)
        return not wait_for(futures, seconds).not_done

    def settle(self) -> None:
        """Wait for all calls, and the list and the preview that were wanted; take them."""
        self.wait()
        if self._list is not None:
            wait_for([self._list[1]])
        self.take()
        self._previews.wait()

    def take(self) -> bool:
        """Take what has been done since this was asked last; True if there is something new."""
        done = self._take_done()
        for call, outcome in done:
            self._note(call, outcome)
        shown = self.shown
        new, self._seen = shown is not self._seen, shown
        return self._take_list() or new or bool(done)

    def drop_waiting(self) -> bool:
        """Drop the calls that have not begun, or else stop the one that has; False if nothing is
        being made."""
        if not self.waiting:
            return False
        kept = [one for one in self._asked if not one[1].cancel()]
        dropped = len(self._asked) - len(kept)
        self._asked = deque(kept)
        if dropped:
            steps = "1 step" if dropped == 1 else f"{dropped} steps"
            self.message = f"dropped: {steps} that had not begun"
        elif self._stoppable.stop():
            self.message = "stopping …"
        else:
            self.message = "the first quads are made; that is not stopped"
        return True

    # Fills of a patch

    def want_list(self, patch: int) -> None:
        """Have the list of a patch's fills found, if it is not known and no other is wanted."""
        found = self.network.patches.get(patch)
        if found is None:
            return
        key = _list_key(self.network, found)
        if key not in self._lists and self._list is None:
            source = self.shown.work.source
            self._list = key, self._worker.submit(_list_fills, self.network, found, source)

    @property
    def listing(self) -> bool:
        """Is a list of fills wanted that is not there yet?"""
        return self._list is not None

    def list_choices(self, patch: int) -> tuple[Choice, ...]:
        """Return the fills that a patch can have, () while they are not known."""
        found = self.network.patches.get(patch)
        return () if found is None else self._lists.get(_list_key(self.network, found), ())

    def place_in_list(self, patch: int) -> ListPlace | None:
        """Return which of its fills a patch has; None while that is not known."""
        at = self.network.patches[patch]
        found, choice = self._lists.get(_list_key(self.network, at)), filling_of(at).choice
        if found is None or choice is None:
            return None
        plain = replace(choice, by="program")
        number = found.index(plain) if plain in found else None
        return ListPlace(number, len(found), len(found) == LISTED)

    def choose_fill(self, patch: int, number: int) -> None:
        """Give a patch the fill of a number from 0 in its list."""
        at = self.shown.body.point_in(patch)
        if at is None:
            self.message = "that patch is not there any more"
        else:
            self.do("choose", at=at.tolist(), number=number)

    # Previews

    def want_preview(self, call: Call | None) -> None:
        """Have a call previewed in place of that wanted before, and wait a moment for it; None for
        no preview. Quads are not previewed while others are made."""
        shown = self.shown
        if call is None or not (shown.fresh or call.tool in CURVE_PREVIEWS):
            self._previews.drop()
            self._preview = None
            return
        make = partial(preview_call, shown.work, shown.body.mesh, call)
        self._previews.want(make, (shown, call))
        self._previews.wait(LIVE)

    @property
    def preview(self) -> Preview | None:
        """Return the preview found last, while the network is the one it was found for."""
        found = self._previews.found
        if found is not None:
            self._preview = found.result()
        if self._preview is not None and self._preview.network is not self.network:
            self._preview = None
        return self._preview

    # Files

    def tick(self) -> bool:
        """Keep what a crash would lose, if it is time; True if that cannot be."""
        said = "" if self.files is None else self.files.tick(self.shown.state)
        self.message = said or self.message
        return bool(said)

    def save_session(self) -> bool:
        """Save the session; False if that cannot be."""
        state = self.shown.state
        done = self._save("sessions", lambda files: files.save_session(self.surface, state))
        if done:
            self._saved = state
        return done

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
        """Save all calls since the beginning."""
        calls = self.calls
        if self.files is not None and calls is None:
            self.message = "this did not begin from the bare surface: a script would not make it"
        elif self.files is not None and not calls:
            self.message = "nothing has been done that a script could do again"
        else:
            self._save("scripts", lambda files: files.save_script(calls or ()))

    def reload(self) -> None:
        """Go on from what the session's file holds by now; PatternDBError or OSError if it cannot
        be read."""
        if self.files is None:
            self.message = "sessions cannot be read here"
            return
        found = self.files.read_again(self.surface)
        self._begin(found)
        self._saved = found
        self.message = "this is what the file holds; what was done here is gone"

    def recover(self) -> None:
        """Go on from what a crash left; only before anything else is done."""
        found = None if self.files is None else self.files.lost
        if self.files is None or found is None:
            self.message = "there is nothing that a crash left"
        elif self.shown.undoable or self.waiting:
            self.message = "undo what has been done first: the recovered session replaces it"
        else:
            self._begin(found)
            self.files.lost = None
            self.message = (
                "this is what the crash left; s saves it, and its file goes then. A script would "
                "not make it: none is recorded"
            )

    def _save(self, what: str, save: Callable[[RetopoFiles], str]) -> bool:
        """Save something, and report where or why not; True if it is saved."""
        if self.files is None:
            self.message = f"{what} cannot be saved here"
            return False
        try:
            self.message = save(self.files)
        except OSError as error:
            self.message = f"not saved: {error}"
            return False
        return True

    # What was done, in the thread that asks

    def _begin(self, state: State) -> None:
        """Begin from another state on the same surface; nothing can be undone."""
        self.wait()
        self.calls = None
        self._first = self._worker.submit(self._restore, state)

    def _take_done(self) -> list[tuple[Call, Outcome]]:
        """Return the calls done since this was asked last; what went wrong is raised."""
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

    def _take_list(self) -> bool:
        """Take the list that was wanted; True if there is a new one."""
        if self._list is None or not self._list[1].done():
            return False
        key, future = self._list
        self._list = None
        if future.cancelled():
            return False
        while len(self._lists) >= KEPT_LISTS:
            del self._lists[next(iter(self._lists))]
        self._lists[key] = future.result()
        return True

    def _note(self, call: Call, outcome: Outcome) -> None:
        # Open ends are seen as such, and every first curve of a patch has some.
        notes = [note for note in outcome.notes if note not in outcome.ends]
        if outcome.refused is not None:
            self.message = outcome.refused
        elif notes:
            self.message = "; ".join(notes)
        elif not outcome.changed:
            self.message = f"{call.tool}: nothing changed"
        elif call.tool == "symmetry":
            self.message = self._describe_symmetry()
        if outcome.changed and self.calls is not None:
            self.calls = (*self.calls, call)
        self._patches = len(self.network.patches)

    def _describe_symmetry(self) -> str:
        """Describe what became of the patches when symmetry was switched."""
        on = self.shown.state.plane is not None
        now, before = len(self.network.patches), self._patches
        said = "symmetry is on: one half is worked on" if on else "symmetry is off"
        if now == before:
            return said
        return f"{said}; {before} patches became {now}: undo takes it back"

    # What is done, in the worker's thread

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
        body = FilledSurface.from_filled(found, editor.surface, editor.mesh(found))
        self.shown = self._now(found, body, editor.state.plane, True)

    def _now(
        self, filled: FilledNetwork, body: FilledSurface, plane: Plane | None, fresh: bool
    ) -> Snapshot:
        """Return the editor as it is."""
        editor = self._editor
        work = ToolWork(editor.state, editor.surface_now, editor.source, editor.half)
        return Snapshot(work, filled, body, plane, fresh, editor.undoable, editor.redoable)


def _list_key(network: Network, patch: Patch) -> ListKey:
    return patch.id, side_lengths(network, patch), filling_of(patch).flows


def _list_fills(network: Network, patch: Patch, source: PatternSource) -> tuple[Choice, ...]:
    try:
        return tuple(Choice.of(fill) for fill in rank_fills(network, patch, source))
    except PatternDBError:
        return ()
