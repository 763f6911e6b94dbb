"""The window that viewers share: a thin shell on their states."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from viewer import style
from viewer.keymap import Effect, KeyMap
from viewer.painting import Text
from viewer.saver import Saver
from viewer.scene import Scene
from viewer.solid import Solid

#: Distance between layers and from the camera to the first; any will do.
LAYER = 1e-3
CAMERA = 10.0

#: VTK's number (VTK_FONT_FILE) for a typeface that is read from a file.
FONT_FROM_FILE = 4


class WindowStage:
    """A scene in a pyvista window: polygons in layers, text, and shaded triangles behind them.

    Texts that stay are not made anew.
    """

    def __init__(self, plotter: Any) -> None:
        self._plotter = plotter
        self._written = 0
        self._texts: dict[tuple[Text, float], Any] = {}
        self._actors: list[Any] = []

    def show(self, scene: Scene, solid: Solid) -> None:
        """Replace what was there, and render."""
        plotter = self._plotter
        width, height = plotter.window_size
        for actor in self._actors:
            plotter.remove_actor(actor, reset_camera=False, render=False)
        self._actors = []
        depth = 0.0
        if len(solid.corners):
            near = solid.corners[..., 2]
            # All of it lies behind the layers.
            mesh = _triangles(solid, -float(near.max()) - 1.0)
            depth = float(np.ptp(near)) + 1.0
            self._add(mesh)
        self._add(layer_polygons(scene))
        self._write(scene, (width, height))
        x, y = scene.width / 2.0, scene.height / 2.0
        plotter.camera.position = (x, y, CAMERA)
        plotter.camera.focal_point = (x, y, 0.0)
        plotter.camera.up = (0.0, 1.0, 0.0)
        plotter.camera.parallel_scale = y
        plotter.camera.clipping_range = (0.5, CAMERA + depth + 1.0)
        plotter.render()

    def _add(self, mesh: Any) -> None:
        self._actors.append(
            self._plotter.add_mesh(
                mesh, scalars="colour", rgb=True, lighting=False, reset_camera=False, render=False
            )
        )

    def _write(self, scene: Scene, size: tuple[int, int]) -> None:
        unit = size[1] / scene.height
        kept: dict[tuple[Text, float], Any] = {}
        for t in scene.texts:
            # A text's place depends on the window's shape, too.
            key = (t, scene.width)
            kept[key] = self._texts.pop(key, None) or self._text(t, scene, unit)
        for actor in self._texts.values():
            self._plotter.remove_actor(actor, reset_camera=False, render=False)
        self._texts = kept

    def _text(self, t: Text, scene: Scene, unit: float) -> Any:
        text = make_text(t, scene, unit)
        # An actor takes the place of the one of its name, so no two may have one.
        self._written += 1
        name = f"text-{self._written}"
        self._plotter.add_actor(text, reset_camera=False, name=name, render=False)
        return text


def layer_polygons(scene: Scene) -> Any:
    """Layer all polygons of a scene into one surface, later ones nearer to the camera."""
    import pyvista as pv

    points, faces, colours = [], [], []
    count = 0
    for layer, patch in enumerate(scene.patches):
        n, c = patch.corners.shape[:2]
        z = np.full((n * c, 1), layer * LAYER)
        points.append(np.hstack([patch.corners.reshape(-1, 2), z]))
        corner = count + np.arange(n * c).reshape(n, c)
        faces.append(np.hstack([np.full((n, 1), c), corner]).ravel())
        colours.append(patch.colours)
        count += n * c
    mesh = pv.PolyData(np.vstack(points), np.concatenate(faces))
    mesh.cell_data["colour"] = np.round(np.vstack(colours) * 255.0).astype(np.uint8)
    # OpenGL fills a concave polygon wrongly; the triangulation fills it as it is.
    return mesh.triangulate()


def make_text(t: Text, scene: Scene, unit: float) -> Any:
    """Make a line of text; unit: pixels per point."""
    import pyvista as pv
    from matplotlib import get_data_path

    # VTK's own typefaces have no arrows; matplotlib brings one that has.
    fonts = Path(get_data_path()) / "fonts" / "ttf"
    text = pv.Text(t.text)
    text.GetPositionCoordinate().SetCoordinateSystemToNormalizedViewport()
    text.SetPosition(t.x / scene.width, t.y / scene.height)
    family = "DejaVuSansMono" if t.mono else "DejaVuSans"
    prop: Any = text.prop
    prop.SetFontFamily(FONT_FROM_FILE)
    prop.SetFontFile(str(fonts / f"{family}{'-Bold' if t.bold else ''}.ttf"))
    prop.font_size = max(1, round(t.size * unit))
    prop.color = t.colour
    prop.justification_horizontal = t.align
    return text


def _triangles(solid: Solid, shift: float) -> Any:
    """A solid as a surface with colours at its points."""
    import pyvista as pv

    n = len(solid.corners)
    points = solid.corners.reshape(-1, 3) + np.array([0.0, 0.0, shift])
    corner = np.arange(3 * n).reshape(n, 3)
    mesh = pv.PolyData(points, np.hstack([np.full((n, 1), 3), corner]).ravel())
    colours = np.round(solid.colours.reshape(-1, 3) * 255.0)
    mesh.point_data["colour"] = colours.astype(np.uint8)
    return mesh


#: Pixels of a new window.
WINDOW = (1400, 860)

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


class Shell(ABC):
    """A pyvista plotter on its own: flat, on paper, with VTK's events and nothing else.

    size: pixels. title: of the window. patience: milliseconds between events of the clock, 0 for
    no clock.
    """

    patience = 0

    def __init__(self, size: tuple[int, int], title: str, *, off_screen: bool) -> None:
        # pyvista takes half a second to import; most verbs draw nothing.
        import pyvista as pv

        self._plotter: Any = pv.Plotter(off_screen=off_screen, window_size=list(size), title=title)
        self._plotter.set_background(style.PAPER)
        self._plotter.enable_anti_aliasing("ssaa")
        self._plotter.enable_parallel_projection()
        self._size = size
        #: Was the window left by a key, as opposed to its close button?
        self.quit_by_key = False

    @abstractmethod
    def handlers(self) -> dict[str, Callable[[Any, str], None]]:
        """What is done at which event of VTK's interactor."""

    @abstractmethod
    def redraw(self) -> None:
        """Show the state as it is now."""

    @abstractmethod
    def obey(self, key: str) -> Effect:
        """Press a key, by its X name or as it is written, and show what comes of it."""

    @property
    @abstractmethod
    def keys(self) -> KeyMap[Any]:
        """The keys that there are."""

    def run(self) -> None:
        """Open the window and wait until it is closed."""
        plotter = self._plotter
        # Shown without pyvista's own loop, which would bring its keys and its mouse back.
        plotter.show(auto_close=False, interactive=False)
        interactor = plotter.iren.interactor
        self.listen(interactor)
        plotter.iren.initialize()
        if self.patience:
            interactor.CreateRepeatingTimer(self.patience)
        interactor.Start()

    def listen(self, interactor: Any) -> None:
        """Have an interactor's events, and none but those, change the state."""
        from vtkmodules.vtkInteractionStyle import vtkInteractorStyleUser

        interactor.SetInteractorStyle(vtkInteractorStyleUser())
        # pyvista's own keys would end the program, say.
        for event in ("CharEvent", "KeyPressEvent"):
            interactor.RemoveObservers(event)
        own = {"KeyPressEvent": self._on_key, "ConfigureEvent": self._on_resize}
        for event, handler in (own | self.handlers()).items():
            interactor.AddObserver(event, handler)

    def close(self) -> None:
        """Give the window back."""
        self._plotter.close()

    def save(self, path: Path) -> None:
        """Write what the window shows to a PNG."""
        self._plotter.screenshot(str(path))

    def _on_key(self, interactor: Any, _event: str) -> None:
        character = interactor.GetKeyCode()
        # "<" and the like have names of their own on every keyboard layout.
        key = character if self.keys.writes(character) else interactor.GetKeySym()
        if self.obey(key) is Effect.QUIT:
            self.quit_by_key = True
            interactor.TerminateApp()

    def _on_resize(self, _interactor: Any, _event: str) -> None:
        if tuple(self._plotter.window_size) != self._size:
            self.redraw()


class Window(Shell):
    """A window that shows the state of a viewer.

    state: what mouse and clock change. saver: draws it, and obeys keys. keys: the viewer's.
    size: pixels. title: of the window.
    """

    patience = PATIENCE

    def __init__(
        self,
        state: Watched,
        saver: Saver,
        keys: KeyMap[Any],
        size: tuple[int, int],
        title: str,
        *,
        off_screen: bool = False,
    ) -> None:
        super().__init__(size, title, off_screen=off_screen)
        self.state = state
        self._saver = saver
        self._keys = keys
        self._stage = WindowStage(self._plotter)
        self._shifting: tuple[int, int] | None = None
        self._drawn = saver.drawn()
        self.redraw()

    @property
    def keys(self) -> KeyMap[Any]:
        return self._keys

    def handlers(self) -> dict[str, Callable[[Any, str], None]]:
        """What is done at which event of VTK's interactor."""
        state = self.state
        return {
            "MouseMoveEvent": self._on_move,
            "LeftButtonPressEvent": lambda i, _: self._after(state.press(*self._at(i))),
            "LeftButtonReleaseEvent": lambda i, _: self._after(state.release(*self._at(i))),
            "RightButtonPressEvent": lambda i, _: self._after(state.press(*self._at(i), turn=True)),
            "RightButtonReleaseEvent": lambda i, _: self._after(state.release(*self._at(i))),
            "MiddleButtonPressEvent": self._on_middle,
            "MiddleButtonReleaseEvent": self._on_middle_up,
            "MouseWheelForwardEvent": lambda _i, _e: self._after(state.wheel(1.0)),
            "MouseWheelBackwardEvent": lambda _i, _e: self._after(state.wheel(-1.0)),
            "TimerEvent": lambda _i, _e: self._after(state.poll()),
        }

    def redraw(self) -> None:
        """Show the state as it is now."""
        width, height = self._plotter.window_size
        self._size = self._saver.size = (width, height)
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

    def obey(self, key: str) -> Effect:
        effect = self._saver.obey(key)
        self._after(effect not in (Effect.NOTHING, Effect.QUIT))
        return effect

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


def open_window(
    saver: Saver, pressed: Sequence[str], title: str, kind: type[Window] = Window
) -> bool:
    """Press keys first, then show the saver's state in a window until it is closed.

    pressed: as :meth:`viewer.keymap.KeyMap.check` gives them; if one of them quits no window is
    opened. kind: of window. Returns whether it was left by a key, not by its close button.
    """
    if saver.play(pressed) is Effect.QUIT:
        return True
    window = kind(saver.state, saver, saver.keys, saver.size, title)
    try:
        window.run()
        return window.quit_by_key
    finally:
        window.close()
