"""The window of the viewer of surfaces, a thin shell on its state, and pictures without one."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from patterndb_sketch.recovery import WorkKeeper, find_free_name
from patterndb_sketch.sessions import digest_arrays
from patterndb_sketch.surfacing.patch import Surfacing
from patterndb_sketch.surfacing.session import SURFACING_SESSION, SurfacingWork
from viewer import saver
from viewer.facts import FactSheet
from viewer.picture import WINDOW, check_png, save_drawn
from viewer.saver import SaveWay
from viewer.stage import Drawn, LayerCache
from viewer.surfacing.commands import COMMANDS, KEYS
from viewer.surfacing.picture import DRAWING_HINT, LOOKING_HINT, compose_surface, describe_surface
from viewer.surfacing.state import SurfacingState

#: Writes a surface to a file.
WriteObj = Callable[[Path, Surfacing], None]

#: Makes the state of another network of its file.
OpenState = Callable[[Path], SurfacingState]


def show(
    state: SurfacingState,
    *,
    write_obj: WriteObj | None = None,
    open_file: OpenState | None = None,
    keys: str = "",
    folder: Path | str = ".",
    window_size: tuple[int, int] = WINDOW,
) -> SurfacingState:
    """Look at the surface of a network in a window, until it is closed.

    write_obj: for the key that saves the surface. open_file: makes the state of another network,
    which is shown from then on. keys: pressed first, with spaces between ("m Left"), each once the
    surface before is there. folder: for what keys save. window_size: pixels.

    Returns the state at the end, closed. Raises ValueError for a key there is not, DisplayError
    if no window can be opened here, and what making the first surfaces raises.
    """
    try:
        pressed = KEYS.check(keys)
        # Qt is imported for windows alone: pictures need none.
        from viewer.shell.probe import check_display

        check_display()
        from viewer.shell.opening import open_window
        from viewer.surfacing.docks import SurfacingWindow

        def make_saver(shown: SurfacingState) -> SurfacingSaver:
            made = SurfacingSaver(shown, Path(folder), write_obj, window_size)
            made.watch()
            return made

        opener = None if open_file is None else lambda path: make_saver(open_file(path))
        state = open_window(make_saver(state), pressed, "Surface", SurfacingWindow, opener).state
    finally:
        state.close()
    return state


def draw(
    state: SurfacingState,
    path: Path | str,
    size: tuple[int, int] = WINDOW,
    *,
    write_obj: WriteObj | None = None,
    keys: str = "",
    caption: str = "",
) -> SurfacingState:
    """Write a picture of the surface of a network to a PNG, without a window.

    path: where to; size: its pixels. caption: a line below the network. All else as for
    :func:`show`. The same input gives the same picture.

    Returns the state, closed. Raises PictureFormatError if path is not a PNG, ValueError for a
    key there is not, and what making the surface raises.
    """
    try:
        pressed, path = KEYS.check(keys), check_png(path)
        SurfacingSaver(state, path.parent, write_obj, size).play(pressed)
        state.settle()
        drawn = compose_surface(state, float(size[0]), float(size[1]), caption)
        save_drawn(path, drawn, size[1])
    finally:
        state.close()
    return state


class SurfacingSaver(saver.Saver):
    """Obeys keys, and writes what some of them save."""

    kind = "surface"
    opens = "another network"
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
        self._cache = LayerCache()
        self._folder = folder
        self._write_obj = write_obj

    def watch(self) -> None:
        """Keep what is edited from now on in case of a crash, and read what one left."""
        network = self.state.surfaces.edits.drawing.network
        of = digest_arrays(network.nodes, *(curve.points for curve in network.curves))
        self.keep_by(
            WorkKeeper(SURFACING_SESSION, of, self.kept_work(), self._folder, SurfacingWork.is_like)
        )

    def kept_work(self) -> SurfacingWork:
        settings = self.state.surfaces.settings
        return SurfacingWork(self.state.surfaces.edits, settings.alpha, settings.fair)

    def draw_live(self, width: float, height: float) -> Drawn:
        return compose_surface(self.state, width, height, cache=self._cache)

    def describe(self, sheet: FactSheet) -> None:
        describe_surface(sheet, self.state)

    def first_hint(self) -> str:
        surfaces = self.state.surfaces
        empty = not (surfaces.patches or surfaces.making or surfaces.trouble)
        if not empty:
            return ""
        if surfaces.off:
            return "All patches are off: click a ring, or press A for all of them."
        return "There is no patch: no curves close a cycle at this stage."

    def hint(self) -> str:
        return DRAWING_HINT if self.state.drawing_mode else LOOKING_HINT

    def ready(self) -> None:
        self.state.settle()

    def picture_path(self) -> Path:
        return find_free_name(self._folder, "surface", ".png")

    def would_lose(self) -> str:
        lost = self.state.surfaces.unsaved and self._write_obj is not None
        return "The surface was changed here, and is not saved." if lost else ""

    def save_ways(self) -> tuple[SaveWay, ...]:
        return (SaveWay("save-surface", "Save surface", ".obj", self.write, self._object_path),)

    def write(self, path: Path) -> str:
        """Write the surface to a file."""
        made = self.state.surfaces.made
        if made is None or made.surfacing is None:
            return "there is no surface to save"
        if self._write_obj is None:
            return "surfaces cannot be saved here: no way to write them was given"
        write, surfacing = self._write_obj, made.surfacing
        self.known.save(path, lambda: write(path, surfacing))
        self.state.surfaces.mark_saved()
        self.note_saved()
        return f"saved {path}"

    def _object_path(self) -> Path:
        return find_free_name(self._folder, "surface", ".obj")
