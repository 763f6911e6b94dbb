"""The fill explorer's commands and keys: which there are, and what they do to its state."""

from __future__ import annotations

from collections.abc import Callable

from viewer.commands import Command
from viewer.explorer_state import ExplorerState
from viewer.keymap import Effect, KeyMap
from viewer.modelcommands import LOOKS, RECOVER
from viewer.pointerstroke import PointerMode

#: By how much the keys [ and ] scale edge counts.
FINER = 1.25


def _change(do: Callable[[ExplorerState], object]) -> Callable[[ExplorerState], None]:
    """What changes the question is a step that can be taken back."""

    def run(state: ExplorerState) -> None:
        do(state)
        state.exploration.keep_step()

    return run


def _has_fills(state: ExplorerState) -> bool:
    return bool(state.finder.fills)


def _has_boundary(state: ExplorerState) -> bool:
    return state.contour is not None


def _has_strokes(state: ExplorerState) -> bool:
    return bool(state.finder.strokes)


def _drawing(mode: PointerMode) -> Callable[[ExplorerState], bool]:
    return lambda e: e.mode is mode


def _can_draw_stroke(state: ExplorerState) -> bool:
    return state.finder.boundary is not None


def _enter(state: ExplorerState, mode: PointerMode) -> None:
    """The key that entered a mode leaves it, too."""
    if state.mode is mode:
        state.leave()
    else:
        state.begin(mode)


def _leave(state: ExplorerState) -> None:
    """Leave a mode; where there is none to leave, stop looking for fills."""
    if state.mode is PointerMode.LOOK:
        state.finder.stop()
    state.leave()


COMMANDS: tuple[Command[ExplorerState], ...] = (
    Command("undo", "Undo", "Edit", ("z", "Ctrl+Z"), lambda e: e.undo(),
            "Take back the last change of boundary, strokes or wishes",
            enabled=lambda e: bool(e.exploration.steps.undoable or e.pen.clicked), bar=True),
    Command("redo", "Redo", "Edit", ("Z", "Ctrl+Shift+Z"), lambda e: e.redo(),
            "Do again what was taken back last",
            enabled=lambda e: bool(e.exploration.steps.redoable), bar=True),
    Command("draw-boundary", "Draw boundary", "Draw", ("b",),
            _change(lambda e: _enter(e, PointerMode.CORNERS)),
            "Click the corners of a boundary one after another",
            checked=_drawing(PointerMode.CORNERS), bar=True),
    Command("close-boundary", "Close boundary", "Draw", ("Enter",),
            _change(lambda e: e.close_boundary()), "Join the last corner to the first",
            enabled=lambda e: len(e.pen.clicked) > 2),
    Command("undo-corner", "Take corner back", "Draw", ("BackSpace",), lambda e: e.undo_corner(),
            "Take the corner back that was clicked last", enabled=lambda e: bool(e.pen.clicked)),
    Command("draw-stroke", "Draw stroke", "Draw", ("s",), lambda e: _enter(e, PointerMode.STROKE),
            "Drag from boundary edge to boundary edge: every fill has a strand along it",
            checked=_drawing(PointerMode.STROKE), enabled=_can_draw_stroke, bar=True),
    Command("draw-loop", "Draw loop", "Draw", ("l",), lambda e: _enter(e, PointerMode.LOOP),
            "Drag a closed stroke: every fill has a closed strand along it",
            checked=_drawing(PointerMode.LOOP), enabled=_can_draw_stroke, bar=True),
    Command("drop-stroke", "Forget last stroke", "Draw", ("x",),
            _change(lambda e: e.finder.drop_stroke()), enabled=_has_strokes),
    Command("leave", "Leave the tool", "Draw", ("Escape",), _leave,
            "Back to looking; what was not finished is forgotten. Else: stop looking for fills"),
    Command("fewer-edges", "Fewer edges on side", "Boundary", ("-",),
            _change(lambda e: e.change_length(-1)),
            "One edge fewer on the side at the pointer", enabled=_has_boundary),
    Command("more-edges", "More edges on side", "Boundary", ("+",),
            _change(lambda e: e.change_length(1)),
            "One edge more on the side at the pointer", enabled=_has_boundary),
    Command("coarser", "Coarser", "Boundary", ("[",),
            _change(lambda e: e.exploration.scale_lengths(1.0 / FINER)),
            "Fewer edges on all sides", enabled=_has_boundary, bar=True),
    Command("finer", "Finer", "Boundary", ("]",),
            _change(lambda e: e.exploration.scale_lengths(FINER)),
            "More edges on all sides", enabled=_has_boundary, bar=True),
    Command("toggle-corner", "Convex or reflex corner", "Boundary", ("c",),
            _change(lambda e: e.toggle_corner()),
            "Make the corner at the pointer reflex, or convex", enabled=_has_boundary),
    Command("other-side", "Fill the other side", "Boundary", ("k",),
            _change(lambda e: e.exploration.reverse()),
            "Fill what is on the other side of the boundary", enabled=_has_boundary),
    Command("previous-fill", "Previous fill", "Fill", ("Left",), lambda e: e.finder.step(-1),
            enabled=lambda e: e.finder.rank > 0, bar=True),
    Command("next-fill", "Next fill", "Fill", ("Right",), lambda e: e.finder.step(1),
            enabled=lambda e: e.finder.rank + 1 < len(e.finder.fills), bar=True),
    Command("ten-back", "Ten fills back", "Fill", ("Prior",), lambda e: e.finder.step(-10),
            enabled=_has_fills),
    Command("ten-on", "Ten fills on", "Fill", ("Next",), lambda e: e.finder.step(10),
            enabled=_has_fills),
    Command("first-fill", "First fill", "Fill", ("Ctrl+Home",), lambda e: e.finder.look_at(0),
            enabled=_has_fills),
    Command("last-fill", "Last fill so far", "Fill", ("Ctrl+End", "End"),
            lambda e: e.finder.look_at(-1), enabled=_has_fills),
    Command("previous-variant", "Previous variant", "Fill", ("Up",),
            lambda e: e.finder.step_variant(-1),
            "The fill of the same pattern before this one", enabled=_has_fills),
    Command("next-variant", "Next variant", "Fill", ("Down",),
            lambda e: e.finder.step_variant(1),
            "The next fill of the same pattern", enabled=_has_fills),
    Command("more-fills", "Look for more", "Fill", ("m",), lambda e: e.finder.more(),
            "Look for twice as many fills", enabled=lambda e: e.finder.truncated),
    Command("one-per-pattern", "One fill of each pattern", "Wishes", ("a",),
            _change(lambda e: e.finder.toggle_folded()),
            "List one fill of each pattern, its variants under it; or every fill",
            checked=lambda e: e.finder.folded),
    Command("strict", "Strict corners", "Wishes", ("r",),
            _change(lambda e: e.finder.toggle_strict()),
            "Only fills whose corners are where the boundary's are",
            checked=lambda e: e.finder.strict),
    Command("follow", "Strands follow strokes", "Wishes", ("f",),
            _change(lambda e: e.finder.toggle_following()),
            "Pull strands onto their strokes", checked=lambda e: e.finder.following),
    Command("next-order", "Next order", "Wishes", ("o",),
            _change(lambda e: e.finder.change_order()), "Sort the fills another way"),
    Command("less-tolerance", "Nearer to strokes", "Wishes", (",",),
            _change(lambda e: e.finder.change_tolerance(-1)),
            "Strands end within fewer edges of their strokes", enabled=_has_strokes),
    Command("more-tolerance", "Farther from strokes", "Wishes", (".",),
            _change(lambda e: e.finder.change_tolerance(1)),
            "Strands may end more edges off their strokes", enabled=_has_strokes),
    RECOVER,
    *LOOKS,
    Command("frame-all", "Frame all", "View", ("v", "Home"), lambda e: e.camera.fit(),
            "All back into the middle", bar=True),
    Command("roll", "Roll the view", "View", ("u",), lambda e: e.camera.roll(),
            "A quarter turn about the line of sight"),
    Command("hide-fill", "Boundary alone", "View", ("n",), lambda e: e.toggle("hiding"),
            "Hide the fill, or show it again", checked=lambda e: e.hiding),
    Command("strands", "Strands at the pointer", "View", ("t",),
            lambda e: e.toggle("strips_shown"),
            "Show the two strands of quads that cross under the pointer",
            checked=lambda e: e.strips_shown),
)  # fmt: skip

KEYS: KeyMap[ExplorerState] = KeyMap(
    COMMANDS, {"w": Effect.OBJ, "p": Effect.PICTURE, "q": Effect.QUIT}
)
