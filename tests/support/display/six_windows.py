"""The six windows, each on something small, for what opens all of them."""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from functools import cache, partial
from pathlib import Path
from typing import Any

sys.path.append(str(Path(__file__).resolve().parents[3] / "examples"))

import patterndb
from patterndb.core.disk import Disk
from patterndb.core.pattern import Pattern
from query.expand import expand_pattern
from viewer.shell.settings import ShellSettings
from viewer.shell.window import Opener, ShellWindow

SIZE = (900, 600)


@cache
def starter() -> Any:
    """Open the starter database, once in a process."""
    return patterndb.open()


def make_browser(
    settings: ShellSettings, folder: Path, opener: Opener | None = None
) -> ShellWindow:
    """Make the window of patterns."""
    from viewer.browser import BrowserSaver
    from viewer.browser_state import BrowserState
    from viewer.browser_window import BrowserWindow

    def widen(pattern: Pattern, widths: Sequence[int]) -> Disk:
        return expand_pattern(pattern, widths).disk()

    saver = BrowserSaver(BrowserState(starter(), n_sides=3, expand=widen), None, folder, SIZE)
    return BrowserWindow(saver, "browse", settings, opener)


def make_explorer(
    settings: ShellSettings, folder: Path, opener: Opener | None = None
) -> ShellWindow:
    """Make the window of fills, on a plane where nothing is drawn yet."""
    from viewer.explore import ExplorerSaver
    from viewer.explorer_state import ExplorerState
    from viewer.explorer_window import ExplorerWindow

    def write(path: Path, fill: Any, points: Any) -> None:
        path.write_text(f"{fill.n_quads} {len(points)}")

    saver = ExplorerSaver(ExplorerState(starter()), folder, write, SIZE)
    return ExplorerWindow(saver, "explore", settings, opener)


def make_retopo(settings: ShellSettings, folder: Path, surface: Any = None) -> ShellWindow:
    """Make the window of retopology, on a flat sheet unless another surface is given."""
    from patterndb_sketch.retopo.editor import Retopology
    from patterndb_sketch.retopo.files import RetopoFiles
    from patterndb_sketch.retopo.script import Script
    from tests.support.viewer.sheets import sheet
    from viewer.retopo.docks import RetopoWindow
    from viewer.retopo.state import RetopoState
    from viewer.retopo.window import RetopoSaver

    files = RetopoFiles(folder, folder / "sheet.retopo", None, Script("sheet.obj", ()), None)
    state = RetopoState(Retopology(sheet() if surface is None else surface, starter()), files=files)
    state.camera.look_along((0.0, 0.0, 1.0))
    return RetopoWindow(RetopoSaver(state, files, SIZE), "retopo", settings)


def make_surfacing(
    settings: ShellSettings, folder: Path, opener: Opener | None = None
) -> ShellWindow:
    """Make the window of surfaces, on a dome."""
    from tests.support.viewer.domes import FROM_ABOVE, Finder, growing_dome
    from viewer.surfacing.docks import SurfacingWindow
    from viewer.surfacing.state import SurfacingState
    from viewer.surfacing.window import SurfacingSaver

    state = SurfacingState(growing_dome(), find=Finder(), **FROM_ABOVE)
    state.settle()
    saver = SurfacingSaver(state, folder, lambda path, _: path.write_text("surface"), SIZE)
    return SurfacingWindow(saver, "surface", settings, opener)


def make_features(
    settings: ShellSettings, folder: Path, model: Any = None, opener: Opener | None = None
) -> ShellWindow:
    """Make the window of feature curves, on a roof unless another model is given."""
    from patterndb_sketch.features.files.curvefiles import FeatureFiles
    from tests.support.viewer.tents import tent
    from viewer.features.docks import FeatureWindow
    from viewer.features.state import FeatureState
    from viewer.features.window import FeatureSaver

    files = FeatureFiles(folder, folder / "roof.session")
    state = FeatureState(tent() if model is None else model, files=files)
    state.camera.look_along((0.0, 0.0, 1.0))
    return FeatureWindow(FeatureSaver(state, files, SIZE), "features", settings, opener)


def make_shapes(settings: ShellSettings, folder: Path) -> ShellWindow:
    """Make the window of shape models, on bent cars."""
    from tests.support.viewer.shapes import car_shapes, car_template
    from viewer.shapes.docks import ShapesWindow
    from viewer.shapes.state import ShapesState
    from viewer.shapes.window import ShapesSaver

    state = ShapesState(car_shapes(), car_template())
    return ShapesWindow(ShapesSaver(state, folder / "car.obj", SIZE), "shape-model", settings)


#: What makes each of the six.
MAKERS: dict[str, Callable[..., ShellWindow]] = {
    "browse": make_browser,
    "explore": make_explorer,
    "retopo": make_retopo,
    "surface": make_surfacing,
    "features": make_features,
    "shape-model": make_shapes,
}

#: Those in which another file can be opened, with ``opener``.
OPENING = ("browse", "explore", "surface", "features")


#: Seconds after which what was changed is kept: a test does not wait for half a minute.
SOON = 0.1


def keep_retopo(folder: Path) -> None:
    """Show the window of retopology as the command line does, until it is closed."""
    from patterndb_sketch.retopo.editor import Retopology
    from tests.support.viewer.sheets import sheet
    from viewer.retopo import window

    window.autosave_session = partial(window.autosave_session, every=SOON)
    window.show(Retopology(sheet(), starter()), title="sheet.obj", keys="3", folder=folder)


def keep_soon() -> None:
    """Have work that is in no session kept as soon as it changes."""
    from patterndb_sketch.recovery import Autosave

    Autosave.__init__.__kwdefaults__["every"] = SOON


def keep_explorer(folder: Path) -> None:
    """Show the window of fills as the command line does, until it is closed."""
    from viewer.explore import explore

    keep_soon()
    explore(starter(), write_obj=lambda path, *_: path.write_text("fill"), folder=folder)


def keep_surface(folder: Path) -> None:
    """Show the window of surfaces as the command line does, until it is closed."""
    from tests.support.viewer.domes import FROM_ABOVE, Finder, growing_dome
    from viewer.surfacing.state import SurfacingState
    from viewer.surfacing.window import show

    keep_soon()
    state = SurfacingState(growing_dome(), find=Finder(), **FROM_ABOVE)
    show(state, write_obj=lambda path, _: path.write_text("surface"), folder=folder)


def keep_shapes(folder: Path) -> None:
    """Show the window of shape models as the command line does, until it is closed."""
    from tests.support.viewer.shapes import car_shapes, car_template
    from viewer.shapes.window import show

    keep_soon()
    show(car_shapes(), car_template(), title="cars", output=folder / "car.obj")


def keep_features(folder: Path) -> None:
    """Show the window of feature curves as the command line does, until it is closed."""
    from patterndb_sketch.features.session import FeatureSession
    from patterndb_sketch.features.snap import SnapSettings
    from tests.support.viewer.tents import tent
    from viewer.features import window

    keep_soon()
    window.show(
        tent(), title="roof.obj", session=FeatureSession("roof.obj"), session_path=None,
        settings=SnapSettings(), keys="3", folder=folder,
    )  # fmt: skip


#: What shows each of those that keep what is not saved in case of a crash.
KEEPERS: dict[str, Callable[[Path], None]] = {
    "retopo": keep_retopo,
    "features": keep_features,
    "explore": keep_explorer,
    "surface": keep_surface,
    "shape-model": keep_shapes,
}
