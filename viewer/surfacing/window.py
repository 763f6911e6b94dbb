"""The window of the viewer of surfaces, a thin shell on its state, and pictures without one."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from numpy.typing import ArrayLike

from patterndb.store import Database
from patterndb_sketch.surfacing.network import CurveNetwork, Cycle, Drawing
from patterndb_sketch.surfacing.patch import Surfacing
from patterndb_sketch.surfacing.surfaces import Settings
from viewer import saver
from viewer.facts import FactWriter
from viewer.picture import WINDOW, Drawn, check_png, save_drawn
from viewer.saver import SaveWay, find_free_name
from viewer.scene import HEIGHT
from viewer.surfacing.commands import COMMANDS, KEYS
from viewer.surfacing.maker import Find, find_network_cycles
from viewer.surfacing.picture import DRAWING_HINT, compose_surface, describe_surface
from viewer.surfacing.state import TOWARD, UP, SurfacingState

#: Writes a surface to a file.
WriteObj = Callable[[Path, Surfacing], None]

#: Reads a network's file.
OpenDrawing = Callable[[Path], Drawing | CurveNetwork]


def show(
    source: Drawing | CurveNetwork,
    *,
    settings: Settings | None = None,
    spacing: float | None = None,
    db: Database | None = None,
    afresh: bool = False,
    added: Sequence[Cycle] = (),
    banned: Sequence[Cycle] = (),
    find: Find = find_network_cycles,
    toward: ArrayLike = TOWARD,
    up: ArrayLike = UP,
    write_obj: WriteObj | None = None,
    open_file: OpenDrawing | None = None,
    keys: str = "",
    folder: Path | str = ".",
    window_size: tuple[int, int] = WINDOW,
) -> SurfacingState:
    """Look at the surface of a network in a window, until it is closed.

    source to up: as for :class:`viewer.surfacing.state.SurfacingState`. write_obj: for the key
    that saves the surface. open_file: reads another network, which is shown from then on with its
    own cycles. keys: pressed first, with spaces between ("m Left"), each once the
    surface before is there. folder: for what keys save. window_size: pixels.

    Returns the state at the end. Raises ValueError for a key there is not, DisplayError if no
    window can be opened here, and what making the first surfaces raises.
    """
    pressed = KEYS.check(keys)
    # Qt is imported for windows alone: pictures need none.
    from viewer.shell.probe import check_display

    check_display()
    state = SurfacingState(
        source, settings=settings, spacing=spacing, db=db, afresh=afresh, added=added,
        banned=banned, find=find, toward=toward, up=up,
    )  # fmt: skip
    try:
        shell = SurfacingSaver(state, Path(folder), write_obj, window_size)
        from viewer.shell.opening import open_window
        from viewer.surfacing.docks import SurfacingWindow

        def open_another(path: Path) -> SurfacingSaver:
            assert open_file is not None
            other = SurfacingState(
                open_file(path), settings=settings, spacing=spacing, db=db, afresh=afresh,
                find=find, toward=toward, up=up,
            )  # fmt: skip
            return SurfacingSaver(other, Path(folder), write_obj, window_size)

        opener = None if open_file is None else open_another
        state = open_window(shell, pressed, "Surface", SurfacingWindow, opener).state
    finally:
        state.close()
    return state


def draw(
    source: Drawing | CurveNetwork,
    path: Path | str,
    size: tuple[int, int] = WINDOW,
    *,
    settings: Settings | None = None,
    spacing: float | None = None,
    db: Database | None = None,
    afresh: bool = False,
    added: Sequence[Cycle] = (),
    banned: Sequence[Cycle] = (),
    find: Find = find_network_cycles,
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
        shell = SurfacingSaver(state, path.parent, write_obj, size)
        shell.play(pressed)
        state.settle()
        # As many points to a pixel as in a window: lines are as wide in small pictures.
        height = size[1] * HEIGHT / WINDOW[1]
        drawn = compose_surface(state, size[0] / size[1], bare=bare, caption=caption, height=height)
        save_drawn(path, drawn, size[1])
    finally:
        state.close()
    return state


class SurfacingSaver(saver.Saver):
    """Obeys keys, and writes what some of them save."""

    kind = "surface"
    commands = COMMANDS
    state: SurfacingState

    def __init__(
        self,
        state: SurfacingState,
        folder: Path,
        write_obj: WriteObj | None,
        size: tuple[int, int],
    ) -> None:
        super().__init__(state, KEYS, size)
        self._folder = folder
        self._write_obj = write_obj

    def drawn(self) -> Drawn:
        return compose_surface(self.state, self.size[0] / self.size[1])

    def draw_live(self, width: float, height: float) -> Drawn:
        return compose_surface(self.state, width / height, bare=True, height=height)

    def describe(self, writer: FactWriter) -> None:
        describe_surface(writer, self.state)

    def hint(self) -> str:
        return DRAWING_HINT if self.state.drawing_mode else ""

    def ready(self) -> None:
        self.state.settle()

    def picture_path(self) -> Path:
        return find_free_name(self._folder, "surface", ".png")

    def would_lose(self) -> str:
        lost = self.state.unsaved and self._write_obj is not None
        return "The surface was changed here, and is not saved." if lost else ""

    def save_ways(self) -> tuple[SaveWay, ...]:
        return (SaveWay("save-surface", "Save surface", ".obj", self.write, self._object_path),)

    def saved_object(self) -> str:
        return self.write(self._object_path())

    def write(self, path: Path) -> str:
        """Write the surface to a file."""
        made = self.state.surfaces.made
        if made is None or made.surfacing is None:
            return "there is no surface to save"
        if self._write_obj is None:
            return "surfaces cannot be saved here: no way to write them was given"
        self._write_obj(path, made.surfacing)
        self.state.mark_saved()
        return f"saved {path}"

    def _object_path(self) -> Path:
        return find_free_name(self._folder, "surface", ".obj")
