"""The window of the viewer of surfaces, a thin shell on its state, and pictures without one."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from numpy.typing import ArrayLike

from patterndb.store import Database
from sketch.surfacing.drawing import Drawing
from sketch.surfacing.network import Cycle, Network
from sketch.surfacing.patch import Surfacing
from sketch.surfacing.surfaceloop import Settings
from viewer.browse import WINDOW
from viewer.explorer_picture import check_png, save_drawn
from viewer.explorer_scene import Drawn
from viewer.keymap import Effect
from viewer.opengl import prepare_opengl
from viewer.scene import HEIGHT
from viewer.surfacing.finding import Find, found
from viewer.surfacing.keys import KEYS
from viewer.surfacing.picture import compose
from viewer.surfacing.state import TOWARD, UP, SurfacingState
from viewer.window import Window

#: Writes a surface to a file.
WriteObj = Callable[[Path, Surfacing], None]


def show(
    source: Drawing | Network,
    *,
    settings: Settings | None = None,
    spacing: float | None = None,
    db: Database | None = None,
    afresh: bool = False,
    added: Sequence[Cycle] = (),
    banned: Sequence[Cycle] = (),
    find: Find = found,
    toward: ArrayLike = TOWARD,
    up: ArrayLike = UP,
    write_obj: WriteObj | None = None,
    keys: str = "",
    folder: Path | str = ".",
    window_size: tuple[int, int] = WINDOW,
) -> SurfacingState:
    """Look at the surface of a network in a window, until it is closed.

    source to up: as for :class:`viewer.surfacing.state.SurfacingState`. write_obj: for the key
    that saves the surface. keys: pressed first, with spaces between ("m Left"), each once the
    surface before is there. folder: for what keys save. window_size: pixels.

    Returns the state at the end. Raises ValueError for a key there is not, DisplayError if no
    window can be opened here, and what making the first surfaces raises.
    """
    pressed = KEYS.check(keys)
    prepare_opengl(off_screen=False)
    state = SurfacingState(
        source, settings=settings, spacing=spacing, db=db, afresh=afresh, added=added,
        banned=banned, find=find, toward=toward, up=up,
    )  # fmt: skip
    try:
        saver = Saver(state, Path(folder), write_obj, window_size)
        if saver.play(pressed) is Effect.QUIT:
            return state
        window = Window(state, saver, KEYS, window_size, "Surface")
        try:
            window.run()
        finally:
            window.close()
    finally:
        state.close()
    return state


def draw(
    source: Drawing | Network,
    path: Path | str,
    size: tuple[int, int] = WINDOW,
    *,
    settings: Settings | None = None,
    spacing: float | None = None,
    db: Database | None = None,
    afresh: bool = False,
    added: Sequence[Cycle] = (),
    banned: Sequence[Cycle] = (),
    find: Find = found,
    toward: ArrayLike = TOWARD,
    up: ArrayLike = UP,
    write_obj: WriteObj | None = None,
    keys: str = "",
    bare: bool = True,
    caption: str = "",
) -> SurfacingState:
    """Write a picture of the surface of a network to a PNG, without a window and OpenGL.

    path: where to; size: its pixels. bare: without the panel. caption: a line below the
    network. All else as for :func:`show`. The same input gives the same picture, but for the
    times that the panel tells.

    Returns the state, closed. Raises PictureFormatError if path is not a PNG, ValueError for a
    key there is not, and what making the surface raises.
    """
    pressed = KEYS.check(keys)
    path = check_png(path)
    state = SurfacingState(
        source, settings=settings, spacing=spacing, db=db, afresh=afresh, added=added,
        banned=banned, find=find, toward=toward, up=up,
    )  # fmt: skip
    try:
        saver = Saver(state, path.parent, write_obj, size)
        saver.play(pressed)
        state.settle()
        # As many points to a pixel as in a window: lines are as wide in small pictures.
        height = size[1] * HEIGHT / WINDOW[1]
        drawn = compose(state, size[0] / size[1], bare=bare, caption=caption, height=height)
        save_drawn(path, drawn, size[1])
    finally:
        state.close()
    return state


class Saver:
    """Obeys keys, and writes what some of them save."""

    def __init__(
        self,
        state: SurfacingState,
        folder: Path,
        write_obj: WriteObj | None,
        size: tuple[int, int],
    ) -> None:
        self.state = state
        self.size = size
        self._folder = folder
        self._write_obj = write_obj

    def drawn(self) -> Drawn:
        """The picture of the state as it is now."""
        return compose(self.state, self.size[0] / self.size[1])

    def play(self, keys: Sequence[str]) -> Effect:
        """Press keys one after another, each once the surface is there; QUIT if one quits."""
        for key in keys:
            self.state.settle()
            if self.obey(key) is Effect.QUIT:
                return Effect.QUIT
        return Effect.NOTHING

    def obey(self, key: str) -> Effect:
        """Press a key, and save what it asks to save."""
        effect = KEYS.press(self.state, key)
        if effect in (Effect.OBJ, Effect.PICTURE):
            self.state.message = self._saved(effect)
        return effect

    def _saved(self, effect: Effect) -> str:
        try:
            if effect is Effect.PICTURE:
                path = self._free(".png")
                save_drawn(path, self.drawn(), self.size[1])
                return f"saved {path}"
            made = self.state.made
            if made is None or made.surfacing is None:
                return "there is no surface to save"
            if self._write_obj is None:
                return "surfaces cannot be saved here: no way to write them was given"
            path = self._free(".obj")
            self._write_obj(path, made.surfacing)
        except OSError as error:
            return f"not saved: {error}"
        return f"saved {path}"

    def _free(self, suffix: str) -> Path:
        """A name that no file in the folder has."""
        count = 1
        while (path := self._folder / f"surface-{count}{suffix}").exists():
            count += 1
        return path
