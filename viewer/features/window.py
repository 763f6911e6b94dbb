"""The window of the viewer of feature curves, a thin shell on its state; pictures without one."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from patterndb.geometry.surface import Surface
from patterndb.system.knownfiles import KnownFiles
from patterndb_sketch.features.edits import FeatureEdits
from patterndb_sketch.features.files.curvefiles import FeatureFiles
from patterndb_sketch.features.session import FeatureSession
from patterndb_sketch.features.snap import SnapSettings
from viewer import saver
from viewer.facts import FactSheet
from viewer.features.facts import describe_features, tell_hint
from viewer.features.keys import COMMANDS, KEYS
from viewer.features.picture import FeaturePainter
from viewer.features.state import FeatureState
from viewer.picture import WINDOW, check_png, save_drawn
from viewer.stage import Drawn


def show(
    model: Surface,
    *,
    title: str,
    session: FeatureSession,
    session_path: Path | None,
    settings: SnapSettings,
    open_file: Callable[[Path], Surface] | None = None,
    known: KnownFiles | None = None,
    keys: str = "",
    folder: Path | str = ".",
    window_size: tuple[int, int] = WINDOW,
) -> FeatureState:
    """Draw feature curves on a model in a window, until it is closed.

    title: of the window. session: what has been worked on before. session_path:
    where it is saved; None for a new file in the folder. settings: of the next curve, see
    :func:`patterndb_sketch.features.edits.open_session_curves`. open_file: reads another model, on
    which curves are drawn from then on. known: what the session was when it was read; by default
    as it is now. keys: pressed first, with spaces between. folder: for
    what keys save. window_size: pixels.

    Returns the state at the end. Raises ValueError for a key there is not, InvalidFeatureError
    for a session whose settings are out of range, and DisplayError if no window can be opened
    here.
    """
    pressed = KEYS.check(keys)
    # Qt is imported for windows alone: pictures need none.
    from viewer.shell.probe import check_display

    check_display()

    def make_saver(on: Surface, begun: FeatureSession, path: Path | None) -> FeatureSaver:
        files = FeatureFiles(Path(folder), path, None, known)
        state = FeatureState(on, session=begun, settings=settings, files=files)
        state.editing.watch(begun.mesh)
        return FeatureSaver(state, files, window_size)

    def open_another(path: Path) -> FeatureSaver:
        assert open_file is not None
        return make_saver(open_file(path), FeatureSession(path.name), None)

    from viewer.features.docks import FeatureWindow
    from viewer.shell.opening import open_window

    opener = None if open_file is None else open_another
    shown = make_saver(model, session, session_path)
    return open_window(shown, pressed, title or "Feature curves", FeatureWindow, opener).state


def draw(
    model: Surface,
    path: Path | str,
    *,
    session: FeatureSession,
    size: tuple[int, int] = (1200, 800),
    keys: str = "",
) -> FeatureState:
    """Write a picture of a model and the curves of a session to a PNG, without a window.

    size: pixels. keys: pressed first, such as "Tab r" for the ribs of the first curve.
    All else as for :func:`show`.

    Returns the state, closed. Raises PictureFormatError if path is not a PNG, and else as
    :func:`show` does.
    """
    pressed = KEYS.check(keys)
    path = check_png(path)
    files = FeatureFiles(path.parent, None)
    state = FeatureState(model, session=session, files=files)
    try:
        shell = FeatureSaver(state, files, size)
        shell.drawn()
        shell.play(pressed)
        state.settle()
        save_drawn(path, shell.drawn(), size[1])
    finally:
        state.close()
    return state


class FeatureSaver(saver.SessionSaver):
    """Draws the state, obeys keys, and writes pictures."""

    kind = "features"
    opens = "another model"
    commands = COMMANDS
    state: FeatureState

    def __init__(self, state: FeatureState, files: FeatureFiles, size: tuple[int, int]) -> None:
        super().__init__(state, KEYS, files, size)
        self._painter = FeaturePainter()

    def draw_live(self, width: float, height: float) -> Drawn:
        return self._painter.compose(self.state, width, height)

    def describe(self, sheet: FactSheet) -> None:
        describe_features(sheet, self.state)

    def first_hint(self) -> str:
        editing = self.state.editing
        empty = not editing.edits.curves and editing.clicks is None
        return "Press C and click along a feature of the model." if empty else ""

    def hint(self) -> str:
        return tell_hint(self.state)

    def is_held(self) -> bool:
        return self.state.holding

    def kept_work(self) -> FeatureEdits:
        return self.state.editing.edits

    def end(self, *, discarded: bool) -> None:
        # A curve that is still being made would be left out of what is kept.
        self.state.settle()
        super().end(discarded=discarded)

    def would_lose(self) -> str:
        drawing = bool(self.state.editing.clicks)
        if drawing:
            return "A curve is being drawn, and nothing of it is saved."
        return "The curves are not saved." if self.state.editing.unsaved else ""
