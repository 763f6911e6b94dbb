"""What the window of retopology says beside its picture: tools, options, facts."""

from __future__ import annotations

import numpy as np

from patterndb_sketch.retopo.filling.choice import Choice
from patterndb_sketch.retopo.filling.edgecounts import side_lengths
from patterndb_sketch.retopo.filling.fills import filling_of
from patterndb_sketch.retopo.filling.placing import fill_of
from viewer import style
from viewer.card import format_count
from viewer.facts import FactWriter
from viewer.panel import LINE, MARGIN, PANEL, PanelWriter, begin_panel, draw_hint
from viewer.retopo.layout import OPTION, place_mode, place_options
from viewer.retopo.marks import choose_side_colour, choose_valence_colour
from viewer.retopo.state import RetopoState
from viewer.scene import HIGHLIGHT, HIGHLIGHT_LINE, Scene

#: Calls that are named while they wait.
WAITING = 3

#: Letters of the title that there is room for.
LONGEST = 26


def draw_panel(scene: Scene, state: RetopoState) -> None:
    """Write the panel, and above the picture what is to be done now."""
    left = scene.width - PANEL
    writer = begin_panel(scene, names=92.0)
    title = state.title or "Retopology"
    writer.heading(title if len(title) <= LONGEST else title[: LONGEST - 1] + "…", 17.0)
    _modes(scene, state, left)
    _options(scene, state, left)
    writer.y = place_options(len(state.tool.modes)) - OPTION * len(state.tool.mode.options) - 22.0
    _facts(writer, scene, state)
    _patch(writer, state)
    if state.message:
        writer.skip(0.3)
        writer.paragraph(state.message, style.MESSAGE)
    if not state.helping:
        draw_hint(scene, tell_hint(state))


def tell_hint(state: RetopoState) -> str:
    """Tell why a click would be refused, or else what the tool in use is for."""
    preview = state.tool.preview
    refused = "" if preview is None else preview.refused
    return refused or state.tool.mode.hint


def describe_network(writer: FactWriter, state: RetopoState) -> None:
    """Write what there is to say of patches, quads, and the patch at the pointer."""
    _facts(writer, None, state)
    _patch(writer, state)


def _modes(scene: Scene, state: RetopoState, left: float) -> None:
    """The tools with their keys; the one in use stands out."""
    for number, mode in enumerate(state.tool.modes):
        x, y, width, height = place_mode(left, number, len(state.tool.modes))
        on = mode is state.tool.mode
        if on:
            scene.box(x, y, width - 6.0, height, HIGHLIGHT, HIGHLIGHT_LINE)
        base = y + height / 2.0 - 4.5
        grey = style.TEXT if on else style.FAINT_TEXT
        scene.text(x + 19.0, base, mode.key or "·", 12.5, colour=grey, bold=True, mono=True)
        scene.text(x + 36.0, base, mode.title, 12.5, bold=on, align="left")


def _options(scene: Scene, state: RetopoState, left: float) -> None:
    """The brush of the tool, and its options, with their values."""
    top = place_options(len(state.tool.modes))
    right = scene.width - MARGIN
    y = top + OPTION + 2.0
    mode, grey = state.tool.mode, style.FAINT_TEXT
    name = "target edge" if mode.brush == "edge" else "radius of snapping"
    name = "brush" if mode.given_as else name
    if mode.brush:
        value = state.sizes.edge if mode.brush == "edge" else state.tool.brush
        share = 100.0 * value / state.ground.diagonal
        scene.text(left + MARGIN, y - 4.5, name, 12.5, align="left")
        scene.text(right, y - 4.5, f"{share:.1f} %   [ ]", 12.5, align="right")
    else:
        scene.text(left + MARGIN, y - 4.5, "no brush", 12.5, colour=grey, align="left")
    first = True
    for row, option in enumerate(mode.options):
        y = top - row * OPTION
        value = state.tool.option(mode, option)
        said = {None: "by itself", True: "yes", False: "no"}.get(value, str(value))  # type: ignore[call-overload]
        key = "- +" if option.number else "." if first else ""
        first = first and option.number
        scene.text(left + MARGIN, y - 4.5, option.name, 12.5, align="left")
        changed = value != option.values[0]
        scene.text(right, y - 4.5, f"{said}   {key:>3}", 12.5, bold=changed, align="right")


def _facts(writer: FactWriter, scene: Scene | None, state: RetopoState) -> None:
    """Patches by their sides, quads, and irregular vertices."""
    shown = state.shown
    patches = shown.state.network.patches
    if scene is not None and isinstance(writer, PanelWriter):
        _rule(writer, scene)
    sides: dict[int, int] = {}
    for patch in patches.values():
        sides[len(patch.corners)] = sides.get(len(patch.corners), 0) + 1
    writer.fact("patches", f"{len(patches):,}")
    _row(writer, scene, [(choose_side_colour(n), f"{sides[n]}", f"{n}") for n in sorted(sides)])
    body, stale = shown.body, shown.stale()
    empty = len(patches) - (len(shown.filled.placed) - len(stale))
    if state.editing.waiting or not shown.fresh:
        writer.fact("quads", "working …")
        _waiting(writer, state)
    else:
        quads = f"{len(body.mesh.quads):,}"
        without = f", {empty} {'patch' if empty == 1 else 'patches'} without" if empty else ""
        writer.fact("quads", quads + without)
    if body.mesh.kept:
        writer.fact("as given", format_count(len(body.mesh.kept), "face"))
    if shown.fresh:
        counts = np.unique(body.valences, return_counts=True)
        pairs = list(zip(counts[0].tolist(), counts[1].tolist(), strict=True))
        writer.fact("irregular", f"{len(body.irregular):,}")
        _row(
            writer,
            scene,
            [(choose_valence_colour(v), f"{n}", f"{v}") for v, n in pairs],
            shape=True,
        )
        flipped = sum(len(placed.flipped) for placed in shown.filled.placed.values())
        if flipped:
            writer.fact("flipped", f"{format_count(flipped, 'quad')}, in red")
    writer.fact("steps", f"{shown.undoable} back, {shown.redoable} on")
    if shown.state.plane is not None:
        writer.fact("mirror", "on; quads are of both halves")
    if state.tool.preview is not None and state.tool.preview.count:
        preview = state.tool.preview
        writer.fact("completion", f"{preview.number + 1} of {preview.count}   - +")
    for note in shown.filled.notes[:2] if shown.fresh else ():
        writer.paragraph(note, style.FAINT_TEXT)


def _waiting(writer: FactWriter, state: RetopoState) -> None:
    """What is at work, and what waits for it."""
    titles = {mode.tool: mode.title for mode in state.tool.modes}
    names = [titles.get(tool, tool) for tool in state.editing.working]
    if names:
        writer.fact("at work", names[0])
    if len(names) > 1:
        waits = ", ".join(names[1 : 1 + WAITING]) + (" …" if len(names) > 1 + WAITING else "")
        writer.fact("waiting", waits)
        writer.fact("", f"Esc drops {'it' if len(names) == 2 else f'these {len(names) - 1}'}")


def _row(
    writer: FactWriter,
    scene: Scene | None,
    entries: list[tuple[str, str, str]],
    *,
    shape: bool = False,
) -> None:
    """Small marks in colours, each with how many of them there are."""
    if not entries:
        return
    if scene is None or not isinstance(writer, PanelWriter):
        square = style.make_diamond()
        outlines = [style.choose_valence_shape(int(n)) if shape else square for _, _, n in entries]
        noun = "valence" if shape else "sides"
        said = [f"{n} {noun} ×{count}" if noun == "sides" else f"{noun} {n} ×{count}"
                for _, count, n in entries]  # fmt: skip
        colours = [colour for colour, _, _ in entries]
        writer.legend(
            [
                (outline, colour, "none", text)
                for outline, colour, text in zip(outlines, colours, said, strict=True)
            ]
        )
        return
    x = writer.left + writer.names
    y = writer.y + 4.0
    for colour, count, name in entries[:5]:
        if shape:
            outline = style.choose_valence_shape(int(name))
            scene.polygons((outline * 5.0 + (x + 6.0, y))[None], face=colour)
        else:
            scene.box(x, y - 6.5, 13.0, 13.0, colour, "#aab3bf")
            scene.text(x + 6.5, y - 3.6, name, 9.5)
        scene.text(x + 17.0, y - 4.0, count, 11.5, align="left")
        x += 24.0 + 7.2 * len(count)
    writer.y -= LINE


def _rule(writer: PanelWriter, scene: Scene) -> None:
    scene.box(writer.left, writer.y + LINE, writer.room, 0.0, "#e3e6ea", "#e3e6ea")


def _patch(writer: FactWriter, state: RetopoState) -> None:
    """The patch under the pointer, if one is looked for."""
    number = state.tool.patch_under() if state.tool.mode.target == "patch" else None
    patch = None if number is None else state.network.patches.get(number)
    if patch is None:
        return
    choice: Choice | None = filling_of(patch).choice
    writer.skip(0.3)
    writer.heading(f"patch of {format_count(len(patch.corners), 'side')}")
    writer.fact("edges", " ".join(map(str, side_lengths(state.network, patch))))
    if choice is not None:
        place = state.editing.place_in_list(patch.id)
        if place is None:
            writer.fact("fill", "…")
        elif place.number is None:
            writer.fact("fill", f"not one of the list of {place.count}   n b")
        else:
            of = f"the first {place.count}" if place.more else f"{place.count}"
            writer.fact("fill", f"{place.number + 1} of {of}   n b")
        writer.fact("pattern", fill_of(choice).pattern.name)
        writer.fact("quads", f"{len(choice.faces)}, {choice.n_irregular} irregular")
        writer.fact("taken", "by you" if choice.by == "user" else "by itself")
    if filling_of(patch).flows:
        writer.fact("follows", format_count(len(filling_of(patch).flows), "flow line"))
