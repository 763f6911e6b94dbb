"""The window that viewers share: a thin shell on their states."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any, Protocol

from viewer import style
from viewer.explorer_scene import Drawn
from viewer.keymap import Effect, KeyMap
from viewer.stage import Stage

#: Milliseconds between two looks at what has been made in the background.
PATIENCE = 40


class Watched(Protocol):
    """The state of a viewer. Places are points from the middle of the view; what returns a
    bool tells whether the window has to be drawn again."""

    def press(self, x: float, y: float, *, turn: bool = False) -> bool: ...
    def release(self, x: float, y: float) -> bool: ...
    def move(self, x: float, y: float) -> bool: ...
    def wheel(self, steps: float) -> bool: ...
    def drag_view(self, dx: float, dy: float) -> bool: ...
    def poll(self) -> bool: ...


class Drawing(Protocol):
    """What draws a state at a size in pixels, and obeys keys."""

    size: tuple[int, int]

    def drawn(self) -> Drawn: ...
    def obey(self, key: str) -> Effect: ...


class Window:
    """A pyvista plotter that shows the state of a viewer.

    state: what mouse and clock change. saver: draws it, and obeys keys. keys: the viewer's.
    size: pixels. title: of the window.
    """

    def __init__(
        self,
        state: Watched,
        saver: Drawing,
        keys: KeyMap[Any],
        size: tuple[int, int],
        title: str,
        *,
        off_screen: bool = False,
    ) -> None:
        # pyvista takes half a second to import; most verbs draw nothing.
        import pyvista as pv

        self.state = state
        self._saver = saver
        self._keys = keys
        self._plotter: Any = pv.Plotter(off_screen=off_screen, window_size=list(size), title=title)
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
        written = self._keys.writes(character)
        effect = self._saver.obey(character if written else interactor.GetKeySym())
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
