"""What the window of retopology says beside its picture: what to do now, and facts."""

from __future__ import annotations

import numpy as np

from patterndb_sketch.retopo.filling.choice import Choice
from patterndb_sketch.retopo.filling.edgecounts import side_lengths
from patterndb_sketch.retopo.filling.fills import filling_of
from patterndb_sketch.retopo.filling.placing import fill_of
from viewer import style
from viewer.card import format_count
from viewer.facts import FactSheet
from viewer.retopo.marks import choose_side_colour
from viewer.retopo.state import RetopoState

#: Calls that are named while they wait.
WAITING = 3


def tell_hint(state: RetopoState) -> str:
    """Tell why a click would be refused, or else what the tool in use is for."""
    preview = state.tool.preview
    refused = "" if preview is None else preview.refused
    return refused or state.tool.mode.hint


def describe_network(sheet: FactSheet, state: RetopoState) -> None:
    """Write what there is to say of patches, quads, and the patch at the pointer."""
    _facts(sheet, state)
    _patch(sheet, state)


def _facts(sheet: FactSheet, state: RetopoState) -> None:
    """Patches by their sides, quads, and irregular vertices."""
    shown = state.shown
    patches = shown.state.network.patches
    sides: dict[int, int] = {}
    for patch in patches.values():
        sides[len(patch.corners)] = sides.get(len(patch.corners), 0) + 1
    sheet.fact("patches", f"{len(patches):,}")
    sheet.legend(
        [
            (style.make_diamond(), choose_side_colour(n), "none", f"{n} sides ×{sides[n]}")
            for n in sorted(sides)
        ]
    )
    body, stale = shown.body, shown.stale()
    empty = len(patches) - (len(shown.filled.placed) - len(stale))
    if state.editing.waiting or not shown.fresh:
        sheet.fact("quads", "working …")
        _waiting(sheet, state)
    else:
        quads = f"{len(body.mesh.quads):,}"
        without = f", {empty} {'patch' if empty == 1 else 'patches'} without" if empty else ""
        sheet.fact("quads", quads + without)
    if body.mesh.kept:
        sheet.fact("as given", format_count(len(body.mesh.kept), "face"))
    if shown.fresh:
        counts = np.unique(body.valences, return_counts=True)
        sheet.fact("irregular", f"{len(body.irregular):,}")
        sheet.legend(
            [
                (style.choose_valence_shape(valence), style.choose_valence_colour(valence), "none",
                 f"valence {valence} ×{count}")
                for valence, count in zip(counts[0].tolist(), counts[1].tolist(), strict=True)
            ]
        )  # fmt: skip
        flipped = sum(len(placed.flipped) for placed in shown.filled.placed.values())
        if flipped:
            sheet.fact("flipped", f"{format_count(flipped, 'quad')}, in red")
    sheet.fact("steps", f"{shown.undoable} back, {shown.redoable} on")
    if shown.state.plane is not None:
        sheet.fact("mirror", "on; quads are of both halves")
    if state.tool.preview is not None and state.tool.preview.count:
        preview = state.tool.preview
        sheet.fact("completion", f"{preview.number + 1} of {preview.count}   - +")
    for note in shown.filled.notes[:2] if shown.fresh else ():
        sheet.paragraph(note, style.FAINT_TEXT)


def _waiting(sheet: FactSheet, state: RetopoState) -> None:
    """What is at work, and what waits for it."""
    titles = {mode.tool: mode.title for mode in state.tool.modes}
    names = [titles.get(tool, tool) for tool in state.editing.working]
    if names:
        sheet.fact("at work", names[0] + ("" if len(names) > 1 else "; Esc stops it"))
    if len(names) > 1:
        waits = ", ".join(names[1 : 1 + WAITING]) + (" …" if len(names) > 1 + WAITING else "")
        sheet.fact("waiting", waits)
        sheet.fact("", f"Esc drops {'it' if len(names) == 2 else f'these {len(names) - 1}'}")


def _patch(sheet: FactSheet, state: RetopoState) -> None:
    """The patch under the pointer, if one is looked for."""
    number = state.tool.patch_under() if state.tool.mode.target == "patch" else None
    patch = None if number is None else state.network.patches.get(number)
    if patch is None:
        return
    choice: Choice | None = filling_of(patch).choice
    sheet.heading(f"patch of {format_count(len(patch.corners), 'side')}")
    sheet.fact("edges", " ".join(map(str, side_lengths(state.network, patch))))
    if choice is not None:
        place = state.editing.place_in_list(patch.id)
        if place is None:
            sheet.fact("fill", "…")
        elif place.number is None:
            sheet.fact("fill", f"not one of the list of {place.count}   n b")
        else:
            of = f"the first {place.count}" if place.more else f"{place.count}"
            sheet.fact("fill", f"{place.number + 1} of {of}   n b")
        sheet.fact("pattern", fill_of(choice).pattern.name)
        sheet.fact("quads", f"{len(choice.faces)}, {choice.n_irregular} irregular")
        sheet.fact("taken", "by you" if choice.by == "user" else "by itself")
    if filling_of(patch).flows:
        sheet.fact("follows", format_count(len(filling_of(patch).flows), "flow line"))
