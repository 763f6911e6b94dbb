"""The commands and keys of the viewer of surfaces, and what they do to its state."""

from __future__ import annotations

from patterndb_sketch.surfacing.methods import METHODS
from viewer.commands import Command
from viewer.keymap import Effect, KeyMap
from viewer.modelcommands import LOOKS, RECOVER
from viewer.surfacing.state import ALPHA, SurfacingState

#: How far the keys - and + move the slider, as a part of it.
SLIDE = 0.04


def slide_alpha(state: SurfacingState, by: float) -> None:
    """Move the slider of alpha by a part of its length."""
    state.surfaces.change_alpha(ALPHA.value(ALPHA.share(state.surfaces.settings.alpha) + by))


def _has_patches(state: SurfacingState) -> bool:
    return bool(state.surfaces.patches)


def _has_stages(state: SurfacingState) -> bool:
    return bool(state.surfaces.n_stages)


COMMANDS: tuple[Command[SurfacingState], ...] = (
    Command("undo", "Undo", "Edit", ("u", "Ctrl+Z"), lambda s: s.surfaces.undo(),
            "Take back the last stroke, curve, click on a patch or change of method",
            enabled=lambda s: bool(s.surfaces.steps.undoable), bar=True),
    Command("redo", "Redo", "Edit", ("U", "Ctrl+Shift+Z"), lambda s: s.surfaces.redo(),
            "Do again what was taken back last",
            enabled=lambda s: bool(s.surfaces.steps.redoable), bar=True),
    Command("draw-strokes", "Draw strokes", "Draw", ("d",), lambda s: s.begin_drawing(),
            "Drag strokes on the surface, which can become curves",
            checked=lambda s: s.drawing_mode,
            enabled=lambda s: s.drawing_mode or _has_patches(s), bar=True),
    Command("add-curve", "Make stroke a curve", "Draw", ("Enter",), lambda s: s.add_curves(),
            "Make the last stroke curves of the network; its ends move onto the curves nearby",
            enabled=lambda s: bool(s.surfaces.edits.inks), bar=True),
    Command("leave", "Leave drawing", "Draw", ("Escape",), lambda s: s.leave(),
            "Back to looking; what was not finished is forgotten"),
    Command("toggle-patch", "Patch on or off", "Patch", ("x",), lambda s: s.toggle_patch(),
            "Switch the patch at the pointer off, or on again; a click does the same"),
    Command("all-patches", "All patches on", "Patch", ("a",), lambda s: s.surfaces.all_on(),
            "Switch on whatever was switched off",
            enabled=lambda s: bool(s.surfaces.edits.banned)),
    Command("next-method", "Next method", "Patch", ("m",), lambda s: s.surfaces.next_method(),
            f"Make all patches by the next method of {', '.join(METHODS)}"),
    Command("next-method-here", "Next method here", "Patch", ("n",),
            lambda s: s.next_method_here(), "Make the patch at the pointer by the next method"),
    Command("fair", "Fair across curves", "Patch", ("f",), lambda s: s.surfaces.toggle_fair(),
            "Smooth patches share normals across curves where the surface goes on smoothly",
            checked=lambda s: s.surfaces.settings.fair),
    Command("more-chords", "More chords", "Patch", ("-",), lambda s: slide_alpha(s, -SLIDE),
            "A lower price of chords: more of them"),
    Command("fewer-chords", "Fewer chords", "Patch", ("+",), lambda s: slide_alpha(s, SLIDE),
            "A higher price of chords: fewer of them"),
    Command("stage-back", "Stage back", "Stage", ("Left",), lambda s: s.surfaces.step(-1),
            "The drawing as it was a stage before", enabled=_has_stages),
    Command("stage-on", "Stage on", "Stage", ("Right",), lambda s: s.surfaces.step(1),
            "The drawing as it was a stage later", enabled=_has_stages),
    Command("first-stage", "Before the first stage", "Stage", ("Ctrl+Home",),
            lambda s: s.go_to_stage(0), enabled=_has_stages),
    Command("last-stage", "After the last stage", "Stage", ("Ctrl+End", "End"),
            lambda s: s.go_to_stage(-1), enabled=_has_stages),
    Command("show-surface", "Surface", "View", ("w",), lambda s: s.toggle("surface_shown"),
            "Show the surface, or hide it", checked=lambda s: s.surface_shown),
    Command("show-chords", "Chords", "View", ("e",), lambda s: s.toggle("chords_shown"),
            "Show chords, or hide them", checked=lambda s: s.chords_shown),
    Command("show-curves", "Curves", "View", ("r",), lambda s: s.toggle("curves_shown"),
            "Show curves, or hide them", checked=lambda s: s.curves_shown),
    Command("show-edges", "Edges of faces", "View", ("t",), lambda s: s.toggle("edges_shown"),
            "Show the edges of faces, or hide them", checked=lambda s: s.edges_shown),
    Command("show-off", "Patches that are off", "View", ("c",), lambda s: s.toggle("off_shown"),
            "Show the outlines of patches that are off, or hide them",
            checked=lambda s: s.off_shown),
    Command("show-open", "What is open", "View", ("b",), lambda s: s.toggle("openings_shown"),
            "Mark open rims and the curves that bound no patch, or draw them as the others",
            checked=lambda s: s.openings_shown),
    RECOVER,
    *LOOKS,
    Command("frame-all", "Frame all", "View", ("v", "Home"), lambda s: s.camera.fit(),
            "All into the middle, as seen at first", bar=True),
    Command("roll", "Roll the view", "View", ("z",), lambda s: s.camera.roll(),
            "A quarter turn about the line of sight"),
)  # fmt: skip

KEYS: KeyMap[SurfacingState] = KeyMap(
    COMMANDS, {"s": Effect.PICTURE, "o": Effect.OBJ, "q": Effect.QUIT}
)
