"""The fill explorer's window: a thin shell on its state and its scene."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from patterndb.errors import PatternDBError
from patterndb_sketch.exploration import EXPLORATION_SESSION, ExplorationStep
from patterndb_sketch.recovery import WorkKeeper
from patterndb_sketch.sessions import digest_arrays
from query import Boundary, Fill, Stroke
from query.engine import PatternSource
from query.placing import Surface
from viewer import saver, style
from viewer.explorer_commands import COMMANDS, KEYS
from viewer.explorer_picture import HINTS, compose_explorer, describe_explorer
from viewer.explorer_state import ExplorerState
from viewer.facts import FactSheet
from viewer.picture import WINDOW, check_png, save_drawn
from viewer.pointerstroke import PointerMode
from viewer.saver import SaveWay
from viewer.stage import Drawn, LayerCache

#: Writes a placed fill, vertices (v, 3), to a file.
WriteObj = Callable[[Path, Fill, NDArray[np.float64]], None]

#: Told of a fill that was saved, as one that was chosen; says what came of it.
Accept = Callable[[Fill], str]

#: Reads a boundary with its strokes, or a surface to draw on, of a file.
OpenQuestion = Callable[[Path], tuple[Boundary | None, Sequence[Stroke], Surface | None]]


def explore(
    source: PatternSource,
    boundary: Boundary | None = None,
    *,
    surface: Surface | None = None,
    strokes: Sequence[Stroke] = (),
    tolerance: int = 1,
    rank: int = 1,
    folded: bool = True,
    write_obj: WriteObj | None = None,
    accept: Accept | None = None,
    open_file: OpenQuestion | None = None,
    off_screen: Path | str | None = None,
    keys: str = "",
    folder: Path | str = ".",
    window_size: tuple[int, int] = WINDOW,
) -> ExplorerState:
    """Look through the fills of a boundary in a window, until it is closed.

    source: where patterns come from. boundary: its vertices placed; None to draw one in the
    window. surface: what it lies on, and fills are placed on; None is a plane. strokes,
    tolerance: as for :func:`query.fills`. rank: the fill to begin with, from 1. folded: list one
    fill of each pattern, with its variants under it, not every fill. write_obj: for
    the key that saves a fill. accept: called with every fill that is saved. open_file: reads a
    file that is opened or dropped. off_screen: write one picture to this PNG instead of opening a
    window; that needs no display. keys: pressed first, with
    spaces between ("o Right"), each once the query before has ended. folder: for what keys
    save. window_size: pixels.

    Returns the state at the end. Raises NotFoundError off screen if there is no such fill,
    ValueError for a key there is not, PictureFormatError if off_screen is not a PNG, and
    DisplayError if no window can be opened here.
    """
    pressed = KEYS.check(keys)
    if off_screen is not None:
        check_png(off_screen)
    else:
        # Qt is imported for windows alone: pictures need none.
        from viewer.shell.probe import check_display

        check_display()
    state = ExplorerState(
        source, boundary, surface=surface, strokes=strokes, tolerance=tolerance, folded=folded
    )
    try:
        shell = ExplorerSaver(state, Path(folder), write_obj, window_size, accept)
        if off_screen is not None:
            state.settle(rank - 1)
            shell.play(pressed)
            if state.finder.boundary is not None:
                state.settle()
            save_drawn(off_screen, shell.drawn(), window_size[1])
            return state
        if rank > 1:
            state.settle(rank - 1)
        from viewer.explorer_window import ExplorerWindow
        from viewer.shell.opening import open_window

        def open_another(path: Path) -> ExplorerSaver:
            assert open_file is not None
            found, drawn, base = open_file(path)
            # A boundary lies on the surface that there is.
            base = state.surface if base is None else base
            other = ExplorerState(
                source,
                found,
                surface=base,
                strokes=drawn,
                tolerance=tolerance,
                folded=folded,
            )
            another = ExplorerSaver(other, Path(folder), write_obj, window_size, accept)
            another.watch()
            return another

        shell.watch()
        opener = None if open_file is None else open_another
        shown = open_window(shell, pressed, "Fills", ExplorerWindow, opener)
        state = shown.state
    finally:
        state.close()
    return state


class ExplorerSaver(saver.Saver):
    """Obeys keys, and writes what some of them save."""

    kind = "explore"
    opens = "a boundary or a mesh"
    commands = COMMANDS
    state: ExplorerState

    def __init__(
        self,
        state: ExplorerState,
        folder: Path,
        write_obj: WriteObj | None,
        size: tuple[int, int],
        accept: Accept | None = None,
    ) -> None:
        super().__init__(state, KEYS, size)
        self._cache = LayerCache()
        self._folder = folder
        self._write_obj = write_obj
        self._accept = accept

    def watch(self) -> None:
        """Keep what is asked from now on in case of a crash, and read what one left."""
        surface = self.state.surface
        of = "a plane" if surface is None else digest_arrays(surface.vertices, surface.triangles)
        self.keep_by(
            WorkKeeper(
                EXPLORATION_SESSION, of, self.kept_work(), self._folder, ExplorationStep.is_like
            )
        )

    def kept_work(self) -> ExplorationStep:
        return self.state.exploration.steps.now

    def draw_live(self, width: float, height: float) -> Drawn:
        return compose_explorer(self.state, width, height, cache=self._cache)

    def describe(self, sheet: FactSheet) -> None:
        describe_explorer(sheet, self.state)
        if self.state.finder.trouble:
            sheet.paragraph(self.state.finder.trouble, style.MESSAGE)

    def first_hint(self) -> str:
        begun = self.state.contour is not None or self.state.mode is not PointerMode.LOOK
        return "" if begun else "Press B and click the corners of a boundary."

    def hint(self) -> str:
        if self.state.mode is PointerMode.LOOK and self.state.contour is not None:
            return "← →: other fills    + −: edges of the side at the pointer    S: draw a stroke"
        return HINTS[self.state.mode]

    def would_lose(self) -> str:
        lost = self.state.exploration.drawn_here and self._write_obj is not None
        return "What was drawn here is not saved: no fill of it was." if lost else ""

    def save_ways(self) -> tuple[SaveWay, ...]:
        return (SaveWay("save-fill", "Save fill", ".obj", self.write_fill, self._object_path),)

    def ready(self) -> None:
        if self.state.finder.boundary is not None:
            self.state.settle()

    def picture_path(self) -> Path:
        return self._folder / f"{self._name()}.png"

    def write_fill(self, path: Path) -> str:
        """Write the fill that is looked at, and count it as used."""
        placed = self.state.finder.placed
        if placed is None:
            return "there is no placed fill to save"
        if self._write_obj is None:
            return "fills cannot be saved here: no way to write them was given"
        write = self._write_obj
        self.known.save(path, lambda: write(path, placed.fill, placed.placement.vertices))
        self.state.exploration.drawn_here = False
        self.note_saved()
        if self._accept is None:
            return f"saved {path}"
        try:
            return f"saved {path}; {self._accept(placed.fill)}"
        except PatternDBError as error:
            return f"saved {path}, but not counted as used: {error}"

    def _object_path(self) -> Path:
        return self._folder / f"{self._name()}.obj"

    def _name(self) -> str:
        fill = self.state.finder.fill
        if fill is None:
            return "boundary"
        finder = self.state.finder
        variant = f"-{finder.variant}" if finder.variant else ""
        return f"fill-{fill.pattern.name}-{finder.rank + 1}{variant}"
