"""The pattern browser: its window, and pictures without one."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from viewer import saver
from viewer.browser_commands import COMMANDS, KEYS
from viewer.browser_picture import Meshes, compose_browser, compose_selected, describe_browser
from viewer.browser_state import BrowserSource, BrowserState, Expand
from viewer.facts import FactSheet
from viewer.picture import WINDOW, check_png, save_drawn
from viewer.stage import Drawn

#: Opens a database's file: what patterns come from, and names the meshes of a pattern.
OpenDatabase = Callable[[Path], tuple[BrowserSource, Meshes]]


def browse(
    source: BrowserSource,
    *,
    n_sides: int | None = None,
    expand: Expand | None = None,
    meshes: Meshes | None = None,
    open_file: OpenDatabase | None = None,
    off_screen: Path | str | None = None,
    keys: str = "",
    screenshots: Path | str = ".",
    window_size: tuple[int, int] = WINDOW,
) -> BrowserState:
    """Page through a database's patterns in a window, until it is closed.

    source: where patterns come from. n_sides: the class to begin with, otherwise the
    smallest. expand: the disk of a pattern at given polychord widths, for the keys that
    widen. meshes: names of the meshes a pattern occurs in. open_file: opens a database that is
    chosen or dropped, and gives it with what ``meshes`` is for it. off_screen: write one picture to
    this PNG instead of opening a window; it is drawn without OpenGL.
    keys: pressed first, with spaces between ("n n ] Up"). screenshots: folder for those that the
    key s saves. window_size: pixels.

    Returns the state at the end. Raises NotFoundError if there is no pattern to show,
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
    state = BrowserState(source, n_sides=n_sides, expand=expand)
    shell = BrowserSaver(state, meshes, Path(screenshots), window_size)
    if off_screen is not None:
        shell.play(pressed)
        save_drawn(off_screen, shell.drawn(), window_size[1])
        return state
    from viewer.browser_window import BrowserWindow
    from viewer.shell.opening import open_window

    def open_another(path: Path) -> BrowserSaver:
        assert open_file is not None
        other, known = open_file(path)
        other_state = BrowserState(other, expand=expand)
        return BrowserSaver(other_state, known, Path(screenshots), window_size)

    opener = None if open_file is None else open_another
    shown = open_window(shell, pressed, "Patterns", BrowserWindow, opener)
    return shown.state


class BrowserSaver(saver.Saver):
    """Draws the state, obeys keys, and writes pictures.

    meshes: names of the meshes a pattern occurs in.
    """

    kind = "browse"
    opens = "another database"
    commands = COMMANDS
    state: BrowserState

    def __init__(
        self,
        state: BrowserState,
        meshes: Meshes | None,
        folder: Path,
        size: tuple[int, int],
    ) -> None:
        super().__init__(state, KEYS, size)
        self._meshes, self._folder = meshes, folder

    def drawn(self) -> Drawn:
        width, height = float(self.size[0]), float(self.size[1])
        return Drawn.flat(compose_browser(self.state, width, height))

    def draw_live(self, width: float, height: float) -> Drawn:
        return Drawn.flat(compose_selected(self.state, width, height))

    def describe(self, sheet: FactSheet) -> None:
        describe_browser(sheet, self.state, self._meshes)

    def first_hint(self) -> str:
        return "" if len(self.state.rows) else "No pattern passes the filters."

    def hint(self) -> str:
        return f"page {self.state.page + 1} of {self.state.n_pages}"

    def ready(self) -> None:
        """Nothing is made in the background."""

    def picture_path(self) -> Path:
        pattern = self.state.selected
        name = "patterns" if pattern is None else f"pattern-{pattern.name}"
        return self._folder / f"{name}.png"
