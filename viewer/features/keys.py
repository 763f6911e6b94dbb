"""The keys of the viewer of feature curves: which there are, and what they do to its state."""

from __future__ import annotations

from viewer.commands import Command, list_actions
from viewer.features.layout import name_axis
from viewer.features.state import FeatureState
from viewer.keymap import ALIASES, Effect, KeyMap
from viewer.modelcommands import model_commands

#: (keys, what they do), as the help lists them.
KEY_HELP = (
    ("c", "draw a curve: click points on the model"),
    ("Enter  ⌫", "finish it; take the last click back"),
    ("l", "close it, or open it again; so does a click on its first point"),
    ("drag", "pull a curve: a pin holds it where it is dropped"),
    ("d", "take the pin at the pointer away"),
    ("click  Tab", "select a curve; the next one"),
    ("Del  e", "delete the selected curve; name it"),
    ("a", "snap it again, from where it is now"),
    ("- +   , .", "alpha; stiffness: less, more"),
    ("[ ]", "isophote angle: less, more"),
    ("x y z", "the axis that the angle is measured from"),
    ("↓ ↑", "degree of the spline: less, more"),
    ("u   U", "take back; do again"),
    ("r   m", "ribs; model solid, see-through, hidden"),
    ("1 2 3   v", "from the front, the side, above; as at first"),
    ("g   f", "which axis is upright; roll the view"),
    ("s", "save the session"),
    ("o   n", "save curves as OBJ; as a network of JSON"),
    ("p", "save the picture"),
    ("h ?   Esc   q", "this list; leave; quit"),
)

#: Under the list of keys.
MOUSE_HELP = "drag beside curves: turn    right drag: turn    middle drag: shift    wheel: zoom"

#: How far keys move a slider, as a part of it.
SLIDE = 0.04

#: Other names of keys: X's, and capitals.
ALIASES = (
    {name: key for name, key in ALIASES.items() if key in {*"+-,.[]"} or key == "h"}
    | {"Return": "Enter", "KP_Enter": "Enter", "space": "Tab", "ISO_Left_Tab": "BackTab"}
    | {c.upper(): c for c in "cdelaxyzrmvgfsonphq"}
    | {f"KP_{i}": str(i) for i in (1, 2, 3)}
)


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
        lambda s: s.editing.slide(name, by),
        tip,
    )


COMMANDS: tuple[Command[FeatureState], ...] = (
    Command("undo", "Undo", "Edit", ("u", "Ctrl+Z"), lambda s: s.editing.take_back(),
            "Take back the last click, or else the last change",
            enabled=lambda s: bool(s.editing.clicks or s.editing.undoable), bar=True),
    Command("redo", "Redo", "Edit", ("U", "Ctrl+Shift+Z"), lambda s: s.editing.redo(),
            "Do again what was taken back last",
            enabled=lambda s: bool(s.editing.redoable), bar=True),
    Command("draw-curve", "Draw curve", "Curve", ("c",), lambda s: s.editing.begin_curve(),
            "Click along a feature of the model; the curve snaps to it",
            checked=lambda s: s.editing.clicks is not None, bar=True),
    Command("finish-curve", "Finish curve", "Curve", ("Enter",),
            lambda s: s.editing.finish_curve(), "Make a curve of the clicks",
            enabled=lambda s: s.editing.preview is not None, bar=True),
    Command("undo-click", "Take click back", "Curve", ("BackSpace",),
            lambda s: s.editing.take_back(), "Take the last click back",
            enabled=lambda s: bool(s.editing.clicks or s.editing.undoable)),
    Command("leave", "Leave drawing", "Curve", ("Escape",), lambda s: s.editing.leave(),
            "Leave drawing, or the selection; what was not finished is forgotten"),
    Command("next-curve", "Next curve", "Curve", ("Tab",), lambda s: s.editing.select_next(1),
            "Select the next curve", enabled=_has_curves),
    Command("previous-curve", "Previous curve", "Curve", ("BackTab",),
            lambda s: s.editing.select_next(-1), "Select the curve before", enabled=_has_curves),
    Command("delete-curve", "Delete curve", "Curve", ("Delete",), lambda s: s.editing.delete(),
            "Delete the selected curve, or forget the one that is drawn"),
    Command("name-curve", "Name curve…", "Curve", ("e",), lambda s: s.editing.begin_name(),
            "Give the selected curve another name", enabled=_has_selected, bar=True),
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
                lambda s, name=name: s.editing.choose_axis(name),
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
    Command("save-network", "Save network", "File", ("n",), lambda s: s.editing.save_network(),
            "Save the curves as a network, which templates are laid on", enabled=_has_curves),
    Command("save-lines", "Save curves as OBJ", "File", ("o",), lambda s: s.editing.save_lines(),
            "Save the curves as lines, for other programs", enabled=_has_curves),
)  # fmt: skip

#: The key of the list of keys, which a picture can have; windows have menus.
ACTIONS = list_actions(COMMANDS) | {"h": lambda s: s.editing.toggle("helping")}

#: What the window does itself.
EFFECTS = {"p": Effect.PICTURE, "q": Effect.QUIT}

KEYS = KeyMap(ALIASES, ACTIONS, EFFECTS, lambda s: s.editing.leave())
