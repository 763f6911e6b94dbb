"""The fill explorer's window: a thin shell on its state and its scene."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from query import Boundary, Fill, Stroke
from query.engine import PatternSource
from query.placing import Surface
from viewer import saver
from viewer.explorer_picture import compose_explorer
from viewer.explorer_state import KEYS, ExplorerState
from viewer.opengl import prepare_opengl
from viewer.picture import Drawn, check_png, save_drawn
from viewer.window import WINDOW, open_window

#: Writes a placed fill, vertices (v, 3), to a file.
WriteObj = Callable[[Path, Fill, NDArray[np.float64]], None]


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
    the key that saves a fill. off_screen: write one picture to this PNG instead of opening a
    window; it is drawn without OpenGL, and is the same everywhere. keys: pressed first, with
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
        prepare_opengl(off_screen=False)
    state = ExplorerState(
        source, boundary, surface=surface, strokes=strokes, tolerance=tolerance, folded=folded
    )
    try:
        shell = ExplorerSaver(state, Path(folder), write_obj, window_size)
        if off_screen is not None:
            state.settle(rank - 1)
            shell.play(pressed)
            if state.finder.boundary is not None:
                state.settle()
            save_drawn(off_screen, shell.drawn(), window_size[1])
            return state
        if rank > 1:
            state.settle(rank - 1)
        open_window(shell, pressed, "Fills")
    finally:
        state.close()
    return state


class ExplorerSaver(saver.Saver):
    """Obeys keys, and writes what some of them save."""

    state: ExplorerState

    def __init__(
        self,
        state: ExplorerState,
        folder: Path,
        write_obj: WriteObj | None,
        size: tuple[int, int],
    ) -> None:
        super().__init__(state, KEYS, size)
        self._folder = folder
        self._write_obj = write_obj

    def drawn(self) -> Drawn:
        return compose_explorer(self.state, self.size[0] / self.size[1])

    def ready(self) -> None:
        if self.state.finder.boundary is not None:
            self.state.settle()

    def picture_path(self) -> Path:
        return self._folder / f"{self._name()}.png"

    def saved_object(self) -> str:
        placed = self.state.finder.placed
        if placed is None:
            return "there is no placed fill to save"
        if self._write_obj is None:
            return "fills cannot be saved here: no way to write them was given"
        path = self._folder / f"{self._name()}.obj"
        self._write_obj(path, placed.fill, placed.placement.vertices)
        return f"saved {path}"

    def _name(self) -> str:
        fill = self.state.finder.fill
        if fill is None:
            return "boundary"
        finder = self.state.finder
        variant = f"-{finder.variant}" if finder.variant else ""
        return f"fill-{fill.pattern.name}-{finder.rank + 1}{variant}"
