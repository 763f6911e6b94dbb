"""The fill explorer's window: a thin shell on its state and its scene."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from query import Boundary, Fill, Stroke
from query.engine import PatternSource
from query.placing import Surface
from viewer import style
from viewer.browse import WINDOW
from viewer.explorer_keys import ACTIONS, ALIASES, EFFECTS, Effect, check_keys, press
from viewer.explorer_picture import check_png, save_drawn
from viewer.explorer_scene import Drawn, compose
from viewer.explorer_state import ExplorerState
from viewer.opengl import prepare_opengl
from viewer.stage import Stage

#: Writes a placed fill, vertices (v, 3), to a file.
WriteObj = Callable[[Path, Fill, NDArray[np.float64]], None]

#: Milliseconds between two looks at what has come in.
PATIENCE = 60


def explore(
    source: PatternSource,
    boundary: Boundary | None = None,
    *,
    surface: Surface | None = None,
    strokes: Sequence[Stroke] = (),
    tolerance: int = 1,
    rank: int = 1,
    write_obj: WriteObj | None = None,
    off_screen: Path | str | None = None,
    keys: str = "",
    folder: Path | str = ".",
    window_size: tuple[int, int] = WINDOW,
) -> ExplorerState:
    """Look through the fills of a boundary in a window, until it is closed.

    source: where patterns come from. boundary: its vertices placed; None to draw one in the
    window. surface: what it lies on, and fills are placed on; None is a plane. strokes,
    tolerance: as for :func:`query.fills`. rank: the fill to begin with, from 1. write_obj: for
    the key that saves a fill. off_screen: write one picture to this PNG instead of opening a
    window; it is drawn without OpenGL, and is the same everywhere. keys: pressed first, with
    spaces between ("o Right"), each once the query before has ended. folder: for what keys
    save. window_size: pixels.

    Returns the state at the end. Raises NotFoundError off screen if there is no such fill,
    ValueError for a key there is not, PictureFormatError if off_screen is not a PNG, and
    DisplayError if no window can be opened here.
    """
    pressed = check_keys(keys)
    if off_screen is not None:
        check_png(off_screen)
    else:
        prepare_opengl(off_screen=False)
    state = ExplorerState(source, boundary, surface=surface, strokes=strokes, tolerance=tolerance)
    try:
        saver = Saver(state, Path(folder), write_obj, window_size)
        if off_screen is not None:
            state.settle(rank - 1)
            saver.play(pressed)
            if state.boundary is not None:
                state.settle()
            save_drawn(off_screen, saver.drawn(), window_size[1])
            return state
        if rank > 1:
            state.settle(rank - 1)
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


class Saver:
    """Obeys keys, and writes what some of them save."""

    def __init__(
        self,
        state: ExplorerState,
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
        """Press keys one after another, each once all is found; QUIT if one of them quits."""
        for key in keys:
            if self.state.boundary is not None:
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
        fill = self.state.fill
        name = "boundary" if fill is None else f"fill-{fill.pattern.name}-{self.state.rank + 1}"
        try:
            if effect is Effect.PICTURE:
                path = self._folder / f"{name}.png"
                save_drawn(path, self.drawn(), self.size[1])
                return f"saved {path}"
            placed = self.state.placed
            if placed is None:
                return "there is no placed fill to save"
            if self._write_obj is None:
                return "fills cannot be saved here: no way to write them was given"
            path = self._folder / f"{name}.obj"
            self._write_obj(path, placed.fill, placed.placement.vertices)
        except OSError as error:
            return f"not saved: {error}"
        return f"saved {path}"


class Window:
    """A pyvista plotter that shows an explorer's state."""

    def __init__(
        self,
        state: ExplorerState,
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
            off_screen=off_screen, window_size=list(size), title="Fills"
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
        return {
            "KeyPressEvent": self._on_key,
            "MouseMoveEvent": self._on_move,
            "LeftButtonPressEvent": lambda i, _: self._after(self.state.press(*self._at(i))),
            "LeftButtonReleaseEvent": lambda i, _: self._after(self.state.release(*self._at(i))),
            "RightButtonPressEvent": lambda i, _: self._after(
                self.state.press(*self._at(i), turn=True)
            ),
            "RightButtonReleaseEvent": lambda i, _: self._after(self.state.release(*self._at(i))),
            "MiddleButtonPressEvent": self._on_middle,
            "MiddleButtonReleaseEvent": self._on_middle_up,
            "MouseWheelForwardEvent": lambda _i, _e: self._after(self.state.wheel(1.0)),
            "MouseWheelBackwardEvent": lambda _i, _e: self._after(self.state.wheel(-1.0)),
            "ConfigureEvent": self._on_resize,
            "TimerEvent": lambda _i, _e: self._after(self.state.poll()),
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
