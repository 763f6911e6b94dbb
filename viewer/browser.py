"""The pattern browser's window: a thin shell on its state and its scene."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from viewer.browser_state import KEYS, BrowserSource, BrowserState, Expand
from viewer.keymap import Effect, KeyMap
from viewer.opengl import prepare_opengl
from viewer.paper import PictureFormatError
from viewer.scene import Meshes, compose_browser, find_cell
from viewer.window import CAMERA, WINDOW, Shell, layer_polygons, make_text


def browse(
    source: BrowserSource,
    *,
    n_sides: int | None = None,
    expand: Expand | None = None,
    meshes: Meshes | None = None,
    off_screen: Path | str | None = None,
    keys: str = "",
    screenshots: Path | str = ".",
    window_size: tuple[int, int] = WINDOW,
) -> BrowserState:
    """Page through a database's patterns in a window, until it is closed.

    source: where patterns come from. n_sides: the class to begin with, otherwise the
    smallest. expand: the disk of a pattern at given polychord widths, for the keys that
    widen. meshes: names of the meshes a pattern occurs in. off_screen: write one picture to
    this PNG instead of opening a window. keys: pressed first, with spaces between
    ("n n ] Up"). screenshots: folder for those that the key s saves. window_size: pixels.

    Returns the state at the end. Raises NotFoundError if there is no pattern to show,
    ValueError for a key there is not, PictureFormatError if off_screen is not a PNG, and
    DisplayError if nothing can be drawn here.
    """
    strokes = KEYS.check(keys)
    if off_screen is not None and Path(off_screen).suffix.lower() != ".png":
        raise PictureFormatError(f"{off_screen}: an off-screen picture's name ends in .png")
    state = BrowserState(source, n_sides=n_sides, expand=expand)
    prepare_opengl(off_screen=off_screen is not None)
    window = BrowserWindow(state, meshes, Path(screenshots), window_size, off_screen is not None)
    try:
        if window.play(strokes) is not Effect.QUIT and off_screen is None:
            window.run()
        elif off_screen is not None:
            window.save(Path(off_screen))
    finally:
        window.close()
    return state


class BrowserWindow(Shell):
    """A window that shows a browser's state."""

    def __init__(
        self,
        state: BrowserState,
        meshes: Meshes | None,
        screenshots: Path,
        size: tuple[int, int],
        off_screen: bool,
    ) -> None:
        super().__init__(size, "Patterns", off_screen=off_screen)
        self.state = state
        self._meshes = meshes
        self._screenshots = screenshots
        self.redraw()

    @property
    def keys(self) -> KeyMap[Any]:
        return KEYS

    def handlers(self) -> dict[str, Callable[[Any, str], None]]:
        return {"LeftButtonPressEvent": self._on_click}

    def play(self, keys: Sequence[str]) -> Effect:
        """Press keys one after another; QUIT if one of them quits."""
        for key in keys:
            if self.obey(key) is Effect.QUIT:
                return Effect.QUIT
        return Effect.NOTHING

    def redraw(self) -> None:
        """Show the state as it is now."""
        width, height = self._plotter.window_size
        self._size = (width, height)
        scene = self._scene = compose_browser(self.state, width / height, self._meshes)
        plotter = self._plotter
        plotter.clear_actors()
        plotter.add_mesh(
            layer_polygons(scene), scalars="colour", rgb=True, lighting=False, reset_camera=False
        )
        for number, line in enumerate(scene.texts):
            text = make_text(line, scene, height / scene.height)
            # An actor takes the place of the one of its name.
            plotter.add_actor(text, reset_camera=False, name=f"text-{number}", render=False)
        x, y = scene.width / 2.0, scene.height / 2.0
        plotter.camera.position = (x, y, CAMERA)
        plotter.camera.focal_point = (x, y, 0.0)
        plotter.camera.up = (0.0, 1.0, 0.0)
        plotter.camera.parallel_scale = y
        plotter.camera.clipping_range = (0.5, CAMERA + 1.0)
        plotter.render()

    def obey(self, key: str) -> Effect:
        effect = KEYS.press(self.state, key)
        if effect is Effect.PICTURE:
            pattern = self.state.selected
            name = "patterns" if pattern is None else f"pattern-{pattern.name}"
            path = self._screenshots / f"{name}.png"
            try:
                self.save(path)
                self.state.message = f"saved {path}"
            except OSError as error:
                self.state.message = f"not saved: {error}"
            self.redraw()
        elif effect is Effect.REDRAW:
            self.redraw()
        return effect

    def _on_click(self, interactor: Any, _event: str) -> None:
        x, y = interactor.GetEventPosition()
        unit = self._scene.height / self._size[1]
        place = find_cell(self._scene, self.state, x * unit, y * unit)
        if place is not None:
            self.state.message = ""
            self.state.select(place)
            self.redraw()
