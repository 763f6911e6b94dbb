"""The keys of the window of retopology: which there are, and what they do to its state."""

from __future__ import annotations

from viewer.commands import Command
from viewer.keymap import Effect, KeyMap
from viewer.modelcommands import model_commands
from viewer.retopo.modes import ToolMode, list_modes
from viewer.retopo.state import RetopoState


def _take_tool(mode: ToolMode) -> Command[RetopoState]:
    """The command that takes a tool, or has it act at once."""
    symmetry = mode.tool == "symmetry"

    def is_on(state: RetopoState) -> bool:
        return (
            state.shown.state.plane is not None if symmetry else state.tool.mode.tool == mode.tool
        )

    return Command(
        f"tool-{mode.tool}",
        mode.title[:1].upper() + mode.title[1:],
        "Tools",
        (mode.key,) if mode.key else (),
        lambda s: s.choose_mode(mode.tool),
        mode.hint,
        checked=is_on if symmetry or mode.gesture != "act" else None,
        group="" if symmetry or mode.gesture == "act" else "tools",
    )


def _has_network(state: RetopoState) -> bool:
    return bool(state.network.chains)


def _has_quads(state: RetopoState) -> bool:
    return bool(state.shown.filled.placed)


COMMANDS: tuple[Command[RetopoState], ...] = (
    Command("undo", "Undo", "Edit", ("u", "Ctrl+Z"), lambda s: s.editing.undo(),
            "Take the last step back", enabled=lambda s: bool(s.shown.undoable), bar=True),
    Command("redo", "Redo", "Edit", ("U", "Ctrl+Shift+Z"), lambda s: s.editing.redo(),
            "Do again what was taken back last",
            enabled=lambda s: bool(s.shown.redoable), bar=True),
    *(_take_tool(mode) for mode in list_modes()),
    Command("next-tool", "Next tool", "Tools", ("Tab",), lambda s: s.next_mode(1)),
    Command("previous-tool", "Previous tool", "Tools", ("BackTab",), lambda s: s.next_mode(-1)),
    Command("accept", "Click here", "Tools", ("Enter",), lambda s: s.accept(),
            "Do what a click at the pointer does"),
    Command("leave", "Drop or stop", "Tools", ("Escape",), lambda s: s.leave(),
            "Let go of what is drawn, drop steps that have not begun, or stop the one that has"),
    Command("brush-smaller", "Smaller brush", "Tools", ("[",), lambda s: s.wider(-1),
            "A smaller brush; for counts, more edges"),
    Command("brush-larger", "Larger brush", "Tools", ("]",), lambda s: s.wider(1),
            "A larger brush; for counts, fewer edges"),
    Command("less", "Less", "Tools", ("-",), lambda s: s.more(-1),
            "Less of what the tool has: completions, divisions, edges"),
    Command("more", "More", "Tools", ("+",), lambda s: s.more(1),
            "More of what the tool has: completions, divisions, edges"),
    Command("next-option", "Next option", "Tools", (".",), lambda s: s.next_option(),
            "The next value of the tool's option"),
    Command("next-fill", "Next fill", "Patch", ("n",), lambda s: s.next_fill(1),
            "The next fill of the patch at the pointer", enabled=_has_quads),
    Command("previous-fill", "Previous fill", "Patch", ("b",), lambda s: s.next_fill(-1),
            "The fill before of the patch at the pointer", enabled=_has_quads),
    Command("erase", "Erase curve", "Patch", ("Delete",), lambda s: s.erase_under(),
            "Erase the curve at the pointer", enabled=_has_network),
    Command("erase-open", "Erase open ends", "Patch", ("E",),
            lambda s: s.editing.do("erase", open=True),
            "Erase all curves that end where nothing goes on", enabled=_has_network),
    Command("recount", "Choose all counts again", "Patch", ("C",),
            lambda s: s.editing.do("recount"),
            "Choose the edges of all curves again, except pinned ones", enabled=_has_network),
    *model_commands(("1", "2", "3"), ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)),
                    ("m", "v", "Z", "F")),
    Command("next-seen", "Quads and curves", "View", ("x",), lambda s: s.next_seen(),
            "See quads and curves, curves alone, or quads alone"),
    Command("strips", "Strands at the pointer", "View", ("T",), lambda s: s.toggle_strips(),
            "Show the two strands of quads that cross under the pointer",
            checked=lambda s: s.tool.strips_shown),
    Command("save", "Save session now", "File", ("s",), lambda s: s.editing.save_session(),
            "Save the session in its file, or in a new one", bar=True),
    Command("save-mesh", "Save quads as OBJ", "File", ("o",), lambda s: s.editing.save_mesh(),
            enabled=_has_quads),
    Command("save-script", "Save script", "File", ("S",), lambda s: s.editing.save_script(),
            "Save what was done as a script, which another surface can be tried with"),
    Command("recover", "Open what a crash left", "File", ("R",), lambda s: s.editing.recover(),
            enabled=lambda s: s.editing.files is not None and s.editing.files.lost is not None),
)  # fmt: skip

KEYS: KeyMap[RetopoState] = KeyMap(COMMANDS, {"p": Effect.PICTURE, "q": Effect.QUIT})
