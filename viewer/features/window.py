"""The window of the viewer of feature curves, a thin shell on its state; pictures without one."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

from patterndb.geometry.points import Points
from patterndb.geometry.surface import Surface
from patterndb.system.files import replace_file
from patterndb.system.knownfiles import KnownFiles
from patterndb_sketch.features.edits import FeatureEdits
from patterndb_sketch.features.errors import InvalidFeatureError
from patterndb_sketch.features.files.networkjson import write_network
from patterndb_sketch.features.registration import FeatureCurves
from patterndb_sketch.features.session import FEATURE_SESSION, FeatureSession
from patterndb_sketch.features.snap import SnapSettings
from patterndb_sketch.recovery import Autosave, SessionWriter
from viewer import saver
from viewer.facts import FactSheet
from viewer.features.facts import describe_features, tell_hint
from viewer.features.keys import COMMANDS, KEYS
from viewer.features.picture import FeaturePainter
from viewer.features.state import FeatureState
from viewer.picture import WINDOW, Drawn, check_png, save_drawn


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
        files = FeatureWriter(Path(folder), path, None, known)
        state = FeatureState(on, session=begun, settings=settings, files=files)
        state.message = files.watch(state, begun.mesh)
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
    """Write a picture of a model and the curves of a session to a PNG, without a window and
    OpenGL: the same everywhere.

    size: pixels. keys: pressed first, such as "Tab r" for the ribs of the first curve.
    All else as for :func:`show`.

    Returns the state, closed. Raises PictureFormatError if path is not a PNG, and else as
    :func:`show` does.
    """
    pressed = KEYS.check(keys)
    path = check_png(path)
    files = FeatureWriter(path.parent, None)
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


class FeatureWriter(SessionWriter[FeatureEdits, FeatureSession]):
    """Writes files into a folder under names that are free; the session always into one."""

    unnamed = "unnamed-features"

    def watch(self, state: FeatureState, mesh: str) -> str:
        """Keep what is drawn on a model from now on in case of a crash, and read what one left.

        mesh: the name of the model's file. Says that there is something; "" if there is not.
        """
        editing = state.editing
        self.autosave = Autosave(
            lambda edits: FEATURE_SESSION.encode(editing.session(edits)),
            editing.edits,
            session=self.session_path,
            base="" if self.session_path is None else self.known.digest(self.session_path),
            folder=self._folder,
            unnamed=self.unnamed,
        )

        def read(path: Path) -> FeatureSession | str:
            kept = FEATURE_SESSION.read(path)
            return kept if kept.mesh == mesh else (
                f"of another model, {kept.mesh or 'unnamed'}; rename it to end in .session, and "
                "give it as --session with that model to go on from it"
            )  # fmt: skip

        return self.find_recovery(read)

    def read_again(self) -> FeatureSession:
        """Read the session that is in the file by now."""
        if self.session_path is None:
            raise InvalidFeatureError("there is no session to be read: none was saved yet")
        self.known.note(self.session_path)
        return FEATURE_SESSION.read(self.session_path)

    def save_session(self, session: FeatureSession, edits: FeatureEdits) -> str:
        """Replace the session's file, whole or not at all."""
        path = self.session_path or self.free("features", ".session")
        self.replace_session(path, lambda: FEATURE_SESSION.write(path, session))
        self.note_saved(edits, path)
        return f"saved {path}"

    def save_network(self, network: FeatureCurves) -> str:
        """Write a network of curves."""
        if not network.curves:
            return "there is no curve to save"
        path = self.free("curves", ".json")
        write_network(path, network)
        return f"saved {path}"

    def save_lines(self, lines: Mapping[str, Points]) -> str:
        """Write polylines (k, 3) by name to an OBJ file."""
        if not lines:
            return "there is no curve to save"
        path = self.free("curves", ".obj")
        replace_file(path, format_obj_lines(lines))
        return f"saved {path}"


def format_obj_lines(lines: Mapping[str, Points]) -> str:
    """Format polylines by name as an OBJ file; blanks in names become underscores."""
    text: list[str] = []
    count = 0
    for name, points in lines.items():
        text.append(f"o {'_'.join(name.split())}")
        text += [f"v {x!r} {y!r} {z!r}" for x, y, z in points.tolist()]
        numbers = range(count + 1, count + len(points) + 1)
        text.append("l " + " ".join(map(str, numbers)))
        count += len(points)
    return "\n".join(text) + "\n"


class FeatureSaver(saver.SessionSaver):
    """Draws the state, obeys keys, and writes pictures."""

    kind = "features"
    opens = "another model"
    commands = COMMANDS
    state: FeatureState

    def __init__(self, state: FeatureState, files: FeatureWriter, size: tuple[int, int]) -> None:
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
