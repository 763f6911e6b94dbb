"""The window of the viewer of surfaces, a thin shell on its state, and pictures without one."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from numpy.typing import ArrayLike

from patterndb.store import Database
from sketch.surfacing.drawing import Drawing
from sketch.surfacing.network import Cycle, Network
from sketch.surfacing.patch import Surfacing
from sketch.surfacing.surfaceloop import Settings
from viewer import style
from viewer.browse import WINDOW
from viewer.explorer_picture import check_png, save_drawn
from viewer.explorer_scene import Drawn
from viewer.opengl import prepare_opengl
from viewer.scene import HEIGHT
from viewer.stage import Stage
from viewer.surfacing.finding import Find, found
from viewer.surfacing.keys import ACTIONS, ALIASES, EFFECTS, Effect, check_keys, press
from viewer.surfacing.picture import compose
from viewer.surfacing.state import TOWARD, UP, SurfacingState

#: Writes a surface to a file.
WriteObj = Callable[[Path, Surfacing], None]

#: Milliseconds between two looks at what has been made.
PATIENCE = 40


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
    pressed = check_keys(keys)
    prepare_opengl(off_screen=False)
    state = SurfacingState(
        source, settings=settings, spacing=spacing, db=db, afresh=afresh, added=added,
        banned=banned, find=find, toward=toward, up=up,
    )  # fmt: skip
    try:
        saver = Saver(state, Path(folder), write_obj, window_size)
        if saver.play(pressed) is Effect.QUIT:
            return state
        window = Window(state, saver, window_size)
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
    pressed = check_keys(keys)
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
        effect = press(self.state, key)
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


class Window:
    """A pyvista plotter that shows the state of a viewer."""

    def __init__(
        self,
        state: SurfacingState,
        saver: Saver,
        size: tuple[int, int],
        *,
        off_screen: bool = False,
    ) -> None:
        # pyvista takes half a second to import; most verbs draw nothing.
        import pyvista as pv

        self.state = state
        self._saver = saver
        self._plotter: Any = pv.Plotter(
            off_screen=off_screen, window_size=list(size), title="Surface"
        )
        self._plotter.set_background(style.PAPER)
        self._plotter.enable_anti_aliasing("ssaa")
        self._plotter.enable_parallel_projection()
        self._stage = Stage(self._plotter)
        self._shifting: tuple[int, int] | None = None
        self._drawn = saver.drawn()
        self.redraw()

    def run(self) -> None:
        """Open the window and wait until it is closed."""
        plotter = self._plotter
        # Shown without pyvista's own loop, which would bring its keys and its mouse back.
        plotter.show(auto_close=False, interactive=False)
        interactor = plotter.iren.interactor
        self.listen(interactor)
        plotter.iren.initialize()
        interactor.CreateRepeatingTimer(PATIENCE)
        interactor.Start()

    def listen(self, interactor: Any) -> None:
        """Have an interactor's events, and none but those, change the state."""
        from vtkmodules.vtkInteractionStyle import vtkInteractorStyleUser

        interactor.SetInteractorStyle(vtkInteractorStyleUser())
        for event, handler in self.handlers().items():
            if event == "KeyPressEvent":
                # pyvista's own keys would end the program, say.
                interactor.RemoveObservers("CharEvent")
                interactor.RemoveObservers(event)
            interactor.AddObserver(event, handler)

    def handlers(self) -> dict[str, Callable[[Any, str], None]]:
        """What is done at which event of VTK's interactor."""
        state = self.state
        return {
            "KeyPressEvent": self._on_key,
            "MouseMoveEvent": self._on_move,
            "LeftButtonPressEvent": lambda i, _: self._after(state.press(*self._at(i))),
            "LeftButtonReleaseEvent": lambda i, _: self._after(state.release(*self._at(i))),
            "RightButtonPressEvent": lambda i, _: self._after(state.press(*self._at(i), turn=True)),
            "RightButtonReleaseEvent": lambda i, _: self._after(state.release(*self._at(i))),
            "MiddleButtonPressEvent": self._on_middle,
            "MiddleButtonReleaseEvent": self._on_middle_up,
            "MouseWheelForwardEvent": lambda _i, _e: self._after(state.wheel(1.0)),
            "MouseWheelBackwardEvent": lambda _i, _e: self._after(state.wheel(-1.0)),
            "ConfigureEvent": self._on_resize,
            "TimerEvent": lambda _i, _e: self._after(state.poll()),
        }

    def close(self) -> None:
        """Give the window back."""
        self._plotter.close()

    def save(self, path: Path) -> None:
        """Write what the window shows to a PNG."""
        self._plotter.screenshot(str(path))

    def redraw(self) -> None:
        """Show the state as it is now."""
        width, height = self._plotter.window_size
        self._saver.size = (width, height)
        self._drawn = self._saver.drawn()
        self._stage.show(self._drawn.scene, self._drawn.solid)

    def _after(self, changed: bool) -> None:
        if changed:
            self.redraw()

    def _at(self, interactor: Any) -> tuple[float, float]:
        """Where the pointer is, in points from the middle of the view."""
        x, y = interactor.GetEventPosition()
        unit = self._drawn.scene.height / self._saver.size[1]
        middle = self._drawn.middle
        return x * unit - middle[0], y * unit - middle[1]

    def _on_key(self, interactor: Any, _event: str) -> None:
        character = interactor.GetKeyCode()
        # "<" and the like have names of their own on every keyboard layout.
        known = character in ALIASES or character in ACTIONS or character in EFFECTS
        effect = self._saver.obey(character if known else interactor.GetKeySym())
        if effect is Effect.QUIT:
            interactor.TerminateApp()
        else:
            self._after(effect is not Effect.NOTHING)

    def _on_move(self, interactor: Any, _event: str) -> None:
        at = interactor.GetEventPosition()
        if self._shifting is not None:
            unit = self._drawn.scene.height / self._saver.size[1]
            dx, dy = at[0] - self._shifting[0], at[1] - self._shifting[1]
            self._shifting = at
            self._after(self.state.drag_view(dx * unit, dy * unit))
        else:
            self._after(self.state.move(*self._at(interactor)))

    def _on_middle(self, interactor: Any, _event: str) -> None:
        self._shifting = interactor.GetEventPosition()

    def _on_middle_up(self, _interactor: Any, _event: str) -> None:
        self._shifting = None

    def _on_resize(self, _interactor: Any, _event: str) -> None:
        if tuple(self._plotter.window_size) != self._saver.size:
            self.redraw()
