"""The keys of the viewer of feature curves: which there are, and what they do to its state."""

from __future__ import annotations

from viewer.commands import Command
from viewer.features.sliders import AXIS_OF, name_axis
from viewer.features.state import FeatureState
from viewer.keymap import Effect, KeyMap
from viewer.modelcommands import model_commands

#: How far keys move a slider, as a part of it.
SLIDE = 0.04


def _has_curves(state: FeatureState) -> bool:
    return bool(state.editing.edits.curves)


def _has_selected(state: FeatureState) -> bool:
    return state.editing.curve is not None and state.editing.clicks is None


def _is_closed(state: FeatureState) -> bool:
    editing = state.editing
    curve = editing.preview if editing.clicks is not None else editing.curve
    return curve is not None and curve.closed


def _slide(name: str, title: str, key: str, by: float, tip: str) -> Command[FeatureState]:
    what = "less" if by < 0.0 else "more"
    return Command(
        f"{what}-{name}",
        f"{what.capitalize()} {title}",
        "Fit",
        (key,),
        lambda s: s.slide(name, by),
        tip,
    )


COMMANDS: tuple[Command[FeatureState], ...] = (
    Command("undo", "Undo", "Edit", ("u", "Ctrl+Z"), lambda s: s.editing.take_back(),
            "Take back the last click, or else the last change",
            enabled=lambda s: bool(s.editing.clicks or s.editing.steps.undoable), bar=True),
    Command("redo", "Redo", "Edit", ("U", "Ctrl+Shift+Z"), lambda s: s.editing.redo(),
            "Do again what was taken back last",
            enabled=lambda s: bool(s.editing.steps.redoable), bar=True),
    Command("draw-curve", "Draw curve", "Curve", ("c",), lambda s: s.editing.begin_curve(),
            "Click along a feature of the model; the curve snaps to it",
            checked=lambda s: s.editing.clicks is not None, bar=True),
    Command("finish-curve", "Finish curve", "Curve", ("Enter",),
            lambda s: s.editing.finish_curve(), "Make a curve of the clicks",
            enabled=lambda s: s.editing.preview is not None, bar=True),
    Command("undo-click", "Take click back", "Curve", ("BackSpace",),
            lambda s: s.editing.take_back(), "Take the last click back",
            enabled=lambda s: bool(s.editing.clicks or s.editing.steps.undoable)),
    Command("leave", "Leave drawing", "Curve", ("Escape",), lambda s: s.editing.leave(),
            "Leave drawing, or the selection; what was not finished is forgotten"),
    Command("next-curve", "Next curve", "Curve", ("Tab",), lambda s: s.editing.select_next(1),
            "Select the next curve", enabled=_has_curves),
    Command("previous-curve", "Previous curve", "Curve", ("BackTab",),
            lambda s: s.editing.select_next(-1), "Select the curve before", enabled=_has_curves),
    Command("delete-curve", "Delete curve", "Curve", ("Delete",), lambda s: s.editing.delete(),
            "Delete the selected curve, or forget the one that is drawn"),
    Command("name-curve", "Name curve…", "Curve", ("e",), lambda s: None,
            "Give the selected curve another name, in the list of curves",
            enabled=_has_selected, bar=True),
    Command("snap-again", "Snap again", "Curve", ("a",), lambda s: s.editing.snap_again(),
            "One more round: from where the selected curve is now", enabled=_has_selected),
    Command("close-curve", "Close curve", "Curve", ("l",), lambda s: s.editing.turn_closed(),
            "Go on from the last click to the first, or open the curve again",
            checked=_is_closed),
    Command("unpin", "Take pin away", "Curve", ("d",), lambda s: s.unpin(),
            "Take the pin at the pointer away"),
    _slide("alpha", "alpha", "-", -SLIDE, "Follow the angle of normals rather than bends"),
    _slide("alpha", "alpha", "+", SLIDE, "Follow bends rather than the angle of normals"),
    _slide("stiffness", "stiffness", ",", -SLIDE, "Follow the feature more closely"),
    _slide("stiffness", "stiffness", ".", SLIDE, "Go straighter"),
    _slide("angle", "isophote angle", "[", -SLIDE, "Follow a smaller angle to the axis"),
    _slide("angle", "isophote angle", "]", SLIDE, "Follow a greater angle to the axis"),
    *(
        Command(f"axis-{name}", f"Axis {name}", "Fit", (name,),
                lambda s, name=name: s.editing.choose_axis(AXIS_OF[name]),
                f"Measure the isophote angle from {name}",
                checked=lambda s, name=name: name_axis(s.editing.shown_settings) == name)
        for name in "xyz"
    ),
    Command("degree-up", "Higher degree", "Fit", ("Up",), lambda s: s.editing.change_degree(1),
            "A higher degree of the spline"),
    Command("degree-down", "Lower degree", "Fit", ("Down",),
            lambda s: s.editing.change_degree(-1), "A lower degree of the spline"),
    Command("show-ribs", "Ribs", "View", ("r",), lambda s: s.editing.toggle("ribs_shown"),
            "Show the ribs that the selected curve was found across",
            checked=lambda s: s.editing.ribs_shown),
    *model_commands(("1", "2", "3"), ((-1.0, 0.0, 0.0), (0.0, -1.0, 0.0), (0.0, 0.0, 1.0)),
                    ("m", "v", "g", "f")),
    Command("save", "Save session now", "File", ("s",), lambda s: s.editing.save_session(),
            "Save all curves in the session's file, or in a new one beside it", bar=True),
    Command("recover", "Open what a crash left", "File", ("R",), lambda s: s.editing.recover(),
            "Take the curves that a crash left in place of these",
            enabled=lambda s: s.editing.files is not None and s.editing.files.lost is not None),
    Command("save-network", "Save network", "File", ("n",), lambda s: s.editing.save_network(),
            "Save the curves as a network, which templates are laid on", enabled=_has_curves),
    Command("save-lines", "Save curves as OBJ", "File", ("o",), lambda s: s.editing.save_lines(),
            "Save the curves as lines, for other programs", enabled=_has_curves),
)  # fmt: skip

KEYS: KeyMap[FeatureState] = KeyMap(COMMANDS, {"p": Effect.PICTURE, "q": Effect.QUIT})
