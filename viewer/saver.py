"""What stands between a viewer's state and its window: keys are obeyed, and files written."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from patterndb.system.knownfiles import KnownFiles
from patterndb_sketch.recovery import SessionWriter, WorkKeeper
from viewer.commands import Command
from viewer.facts import FactSheet
from viewer.keymap import Effect, KeyMap
from viewer.picture import save_drawn
from viewer.stage import Drawn


@dataclass(frozen=True, slots=True)
class SaveWay:
    """One thing that a window can save.

    name:   of the command ("save-session"). title: in the menu. suffix: of files, ".obj".
    write:  writes it to a file, and says so; OSError as writing does.
    suggest: a file that is not there yet. known: the file that it is saved to without asking.
    """

    name: str
    title: str
    suffix: str
    write: Callable[[Path], str]
    suggest: Callable[[], Path]
    known: Callable[[], Path | None] = lambda: None


@dataclass(frozen=True, slots=True)
class LostWork:
    """Work that a crash left. what: a sentence. open, discard: what can be done with it."""

    what: str
    open: Callable[[], object]
    discard: Callable[[], object]


#: What is said to commands that come while a button holds something.
LET_GO = "let go of the button first"


class Saver(ABC):
    """Draws a state, obeys keys, and writes what some of them save.

    state: the viewer's, with a ``message``. keys: the viewer's. size: pixels of the picture.
    known: what files were when they were opened or saved last. kind: of window, which settings go
    by. opens: what can be opened or dropped. commands: what
    can be done, for menus. A viewer says in a class of its own how it is drawn, and what its files
    are.
    """

    kind = "window"
    opens = "a file"
    commands: Sequence[Command[Any]] = ()
    #: The SessionWriter that keeps work in case of a crash; None where nothing is kept.
    files: Any = None

    def __init__(self, state: Any, keys: KeyMap[Any], size: tuple[int, int]) -> None:
        self.state = state
        self.size = size
        self.keys = keys
        self.known = KnownFiles()

    def drawn(self) -> Drawn:
        """The picture of the state as it is now, for a file: a point to a pixel."""
        return self.draw_live(float(self.size[0]), float(self.size[1]))

    @abstractmethod
    def draw_live(self, width: float, height: float) -> Drawn:
        """The picture of so many points."""

    @abstractmethod
    def describe(self, sheet: FactSheet) -> None:
        """Write what is said beside the picture."""

    def hint(self) -> str:
        """What is to be done now, in a line; "" for nothing in particular."""
        return ""

    def first_hint(self) -> str:
        """What to begin with, where there is nothing to see yet; "" where there is."""
        return ""

    def save_ways(self) -> tuple[SaveWay, ...]:
        """What can be saved; the first is the work itself, which closing asks about."""
        return ()

    def refuse(self, command: Command[Any]) -> str:
        """Why a command cannot be obeyed just now; "" if it can."""
        return ""

    def kept_work(self) -> Any:
        """The work as it is now, which is kept in case of a crash; None while it cannot be."""
        return None

    def keep(self) -> None:
        """Keep the work in case of a crash, if it is time; called often."""
        work = None if self.files is None else self.kept_work()
        if self.files is not None and work is not None:
            self.state.message = self.files.tick(work) or self.state.message

    def keep_by(self, files: WorkKeeper[Any]) -> None:
        """Keep the work in these files from now on, and say what a crash left of it."""
        self.files = self.state.files = files
        self.state.message = files.find_lost() or self.state.message

    def note_saved(self) -> None:
        """The work was saved as it is: nothing of it need be kept any more."""
        if self.files is not None:
            self.files.note_saved(self.kept_work(), None)

    def reload(self, path: Path) -> Callable[[], object] | None:
        """What shows what a file holds by now in place of the work; None where the window cannot
        read what it writes there."""
        return None

    def find_lost_work(self) -> LostWork | None:
        """Work that a crash left, None for none."""
        if self.files is None or self.files.lost is None:
            return None
        return LostWork(
            "A crash, or a window that was closed by force, left work on this. "
            "Open it in place of what is here?",
            self.recover,
            self.files.discard_lost,
        )

    def recover(self) -> None:
        """Take what a crash left in place of what is here."""
        self.state.recover()

    def end(self, *, discarded: bool) -> None:
        """End: nothing is kept any more, unless the window was ended without being asked."""
        close = getattr(self.state, "close", None)
        if close is not None:
            close()
        if self.files is not None:
            self.files.end(None if discarded else self.kept_work())

    def dismiss(self) -> None:
        """Let go of the state: something else is shown, and whoever works has agreed."""
        self.end(discarded=True)

    @abstractmethod
    def picture_path(self) -> Path:
        """Where the next picture is written."""

    @abstractmethod
    def ready(self) -> None:
        """Wait until the next key can be pressed as if a user did."""

    def would_lose(self) -> str:
        """What quitting now would lose, and how to keep it; "" for nothing."""
        return ""

    def play(self, keys: Sequence[str]) -> Effect:
        """Press keys one after another, each once all is there; QUIT if one of them quits."""
        for key in keys:
            self.ready()
            if self.obey(key) is Effect.QUIT:
                return Effect.QUIT
        return Effect.NOTHING

    def obey(self, key: str) -> Effect:
        """Press a key, by its X name or as it is written, and save what it asks to save.

        Returns what the window has to do.
        """
        effect = self.keys.press(self.state, key)
        if effect in (Effect.OBJ, Effect.PICTURE):
            try:
                if effect is Effect.PICTURE:
                    self.state.message = self.save_picture(self.picture_path())
                else:
                    way = self.save_ways()[0]
                    self.state.message = way.write(way.known() or way.suggest())
            except OSError as error:
                self.state.message = f"not saved: {error}"
        return effect

    def save_picture(self, path: Path) -> str:
        """Write the picture to a PNG, and say so."""
        save_drawn(path, self.drawn(), self.size[1])
        return f"saved {path}"


class SessionSaver(Saver):
    """A saver of work that is kept in sessions, and done with a button held down.

    files: where it is saved. suffix: of sessions; names that are made up begin with ``kind``.
    """

    suffix = ".session"

    def __init__(
        self,
        state: Any,
        keys: KeyMap[Any],
        files: SessionWriter[Any, Any],
        size: tuple[int, int],
    ) -> None:
        super().__init__(state, keys, size)
        self.files = files
        self.known = files.known

    @abstractmethod
    def is_held(self) -> bool:
        """Does a button hold something just now?"""

    def ready(self) -> None:
        self.state.settle()

    def picture_path(self) -> Path:
        return self.files.free(self.kind, ".png")

    def refuse(self, command: Command[Any]) -> str:
        held = self.is_held() and command.name != "leave"
        return LET_GO if held else ""

    def save_ways(self) -> tuple[SaveWay, ...]:
        return (
            SaveWay("save-session", "Save session", self.suffix, self._write_session,
                    lambda: self.files.free(self.kind, self.suffix),
                    lambda: self.files.session_path),
        )  # fmt: skip

    def keep(self) -> None:
        """The editing does, whenever it is asked for what is new."""

    def recover(self) -> None:
        self.state.editing.recover()

    def reload(self, path: Path) -> Callable[[], object] | None:
        return self.state.editing.reload if path == self.files.session_path else None

    def _write_session(self, path: Path) -> str:
        before, self.files.session_path = self.files.session_path, path
        if not self.state.editing.save_session():
            # The next time is asked again, rather than fails again.
            self.files.session_path = before
        return str(self.state.message)
