"""The commands and keys of the viewer of shape models, and what they do to its state."""

from __future__ import annotations

from collections.abc import Callable

from viewer.commands import Command
from viewer.keymap import Effect, KeyMap
from viewer.modelcommands import LOOKS, RECOVER
from viewer.shapes.state import ShapesState

#: Standard deviations that an arrow key changes a mode by.
NUDGE = 0.1

Action = Callable[[ShapesState], object]


def _idle(action: Action) -> Action:
    """An action that waits until nothing is dragged: what is, goes on from where it began."""

    def press(state: ShapesState) -> None:
        if state.dragging:
            state.message = "let go first, or press Esc"
        else:
            action(state)

    return press


def _has_curve(state: ShapesState) -> bool:
    return state.line_under() is not None


COMMANDS: tuple[Command[ShapesState], ...] = (
    Command("undo", "Undo", "Edit", ("u", "Ctrl+Z"), _idle(lambda s: s.shaping.undo()),
            "Take back the last change of the shape",
            enabled=lambda s: bool(s.shaping.steps.undoable), bar=True),
    Command("redo", "Redo", "Edit", ("U", "Ctrl+Shift+Z"), _idle(lambda s: s.shaping.redo()),
            "Do again what was taken back last",
            enabled=lambda s: bool(s.shaping.steps.redoable), bar=True),
    Command("hold", "Hold curve", "Pull", ("c",), _idle(lambda s: s.hold_here()),
            "Hold the curve at the pointer where it is, or let it go; a click does the same"),
    Command("let-go", "Let all curves go", "Pull", ("a",), _idle(lambda s: s.shaping.let_go()),
            enabled=lambda s: bool(s.shaping.choice.held)),
    Command("bend", "Pull one vertex", "Pull", ("m",), lambda s: s.toggle_bending(),
            "Pull one vertex with those around it, or the whole curve",
            checked=lambda s: s.bending, bar=True),
    *(
        Command(f"along-{name}", f"Pull along {name}", "Pull", (name,),
                lambda s, axis=axis: s.choose_axis(axis),
                f"Pull along {name}; again: in the plane of the screen",
                checked=lambda s, axis=axis: s.axis == axis, bar=True)
        for axis, name in enumerate("xyz")
    ),
    Command("leave", "Drop the pull", "Pull", ("Escape",), lambda s: s.leave(),
            "Let go of what is dragged, as if it had not been"),
    Command("mode-up", "Mode before", "Shape", ("Up",), _idle(lambda s: s.choose_mode(-1)),
            "The mode before is the one that the arrow keys change"),
    Command("mode-down", "Mode after", "Shape", ("Down",), _idle(lambda s: s.choose_mode(1)),
            "The next mode is the one that the arrow keys change"),
    Command("less", "Less of the mode", "Shape", ("Left",),
            _idle(lambda s: s.shaping.nudge(s.chosen, -NUDGE))),
    Command("more", "More of the mode", "Shape", ("Right",),
            _idle(lambda s: s.shaping.nudge(s.chosen, NUDGE))),
    Command("mean", "Mean shape", "Shape", ("0",), _idle(lambda s: s.shaping.reset()), bar=True),
    Command("previous-shape", "Previous training shape", "Shape", ("b",),
            _idle(lambda s: s.shaping.step(-1))),
    Command("next-shape", "Next training shape", "Shape", ("n",),
            _idle(lambda s: s.shaping.step(1))),
    Command("random", "Random shape", "Shape", ("r",), _idle(lambda s: s.shaping.sample()),
            "A shape as likely as the training shapes", bar=True),
    RECOVER,
    *LOOKS,
    Command("ghost", "Next ghost", "View", ("g",), lambda s: s.shaping.next_ghost(),
            "Show no other shape behind this one, the mean, or a training shape"),
    Command("show-curves", "Curves", "View", ("w",), lambda s: s.toggle("curves_shown"),
            "Show curves, or hide them", checked=lambda s: s.curves_shown),
    Command("show-edges", "Edges of faces", "View", ("e",), lambda s: s.toggle("edges_shown"),
            "Show the edges of faces, or hide them", checked=lambda s: s.edges_shown),
    Command("frame-all", "Frame all", "View", ("v", "Home"), _idle(lambda s: s.camera.look(0)),
            "All into the middle, as seen at first", bar=True),
    *(
        Command(f"view-{name}", f"Along {name}", "View", (str(way),),
                _idle(lambda s, way=way: s.camera.look(way)), f"Look along {name}")
        for way, name in enumerate("xyz", 1)
    ),
)  # fmt: skip

KEYS: KeyMap[ShapesState] = KeyMap(
    COMMANDS, {"p": Effect.PICTURE, "o": Effect.OBJ, "q": Effect.QUIT}
)
