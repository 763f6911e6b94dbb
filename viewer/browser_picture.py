"""The pattern browser's pictures: a page of thumbnails, the selected pattern, and its facts."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from patterndb.core.bundles import find_boundary_bundles, find_bundles
from patterndb.core.disk import Disk
from patterndb.core.pattern import Pattern
from patterndb.geometry.points import Points
from viewer import style
from viewer.browser_state import COLUMNS, ROWS, BrowserState
from viewer.card import collect_facts, format_count, format_valences
from viewer.drawing import DiskDrawing, draw_disk
from viewer.facts import FactSheet
from viewer.painting import measure_scale, paint_disk, paint_legend
from viewer.scene import HIGHLIGHT_LINE, Scene

Meshes = Callable[[Pattern], Sequence[str]]

RULE = "#e3e6ea"

HEADER = 56.0
MARGIN = 28.0
CAPTION = 30.0

#: Part of the width that thumbnails take.
GRID_PART = 0.6

HIGHLIGHT = "#e8f0fa"


def compose_browser(state: BrowserState, width: float, height: float) -> Scene:
    """Compose the page and the selected pattern, in a picture of this size."""
    scene = Scene(width, height)
    _header(scene, state)
    _thumbnails(scene, state)
    left = GRID_PART * width + MARGIN
    scene.box(left - 14.0, 30.0, 0.0, height - 80.0, RULE, RULE)
    pattern, disk = state.selected, state.selected_disk()
    if pattern is None or disk is None:
        return scene
    room, free = width - left - MARGIN, height - HEADER - 2.0 * CAPTION
    x, y = left + room / 2.0, height - HEADER - free / 2.0
    _selected(scene, state, pattern, disk, x, y, min(room, free))
    caption = f"{pattern.name}   {format_valences(pattern.valences)}   {_seen(pattern)}"
    if state.chord is not None:
        caption += f"   polychord {state.chord}: {state.widths[state.chord]} wide"
    scene.text(x, CAPTION, caption, min(12.0, room / (0.6 * len(caption))))
    return scene


def _seen(pattern: Pattern) -> str:
    return f"{pattern.frequency:,}×" if pattern.frequency else ""


def _cell(scene: Scene) -> tuple[float, float]:
    width = (GRID_PART * scene.width - MARGIN) / COLUMNS
    return width, (scene.height - HEADER - 36.0) / ROWS


def _title(state: BrowserState) -> tuple[str, str]:
    """The number of sides, and how many of the patterns are listed."""
    text = format_count(len(state.patterns), "pattern")
    if state.filters():
        text = f"{len(state.rows):,} of {text}: {state.filters()}"
    return format_count(state.patterns.n_sides, "side"), text


def _header(scene: Scene, state: BrowserState) -> None:
    y = scene.height - 34.0
    title, text = _title(state)
    scene.text(MARGIN + 8.0, y, title, 19.0, bold=True, align="left")
    scene.text(MARGIN + 120.0, y, text, 13.0, align="left")
    right = GRID_PART * scene.width - 8.0
    page = f"page {state.page + 1} of {state.n_pages}"
    scene.text(right, y, page, 13.0, colour=style.FAINT_TEXT, align="right")


def _thumbnails(scene: Scene, state: BrowserState) -> None:
    width, height = _cell(scene)
    size = min(width, height - CAPTION) - 18.0
    first = state.page * COLUMNS * ROWS
    drawings: list[DiskDrawing] = []
    for i, r in enumerate(state.page_rows().tolist()):
        row, column = divmod(i, COLUMNS)
        left = MARGIN + column * width
        bottom = scene.height - HEADER - (row + 1) * height
        if first + i == state.position:
            box = (left + 3.0, bottom + 2.0, width - 6.0, height - 4.0)
            scene.box(*box, HIGHLIGHT, HIGHLIGHT_LINE)
        p = state.patterns
        code = p.code(r).tobytes()
        drawing, valences = _thumbnail(code, state.mirrored, state.tinted)
        drawings.append(drawing)
        middle = left + width / 2.0
        paint_disk(scene, drawing, middle, bottom + CAPTION + (height - CAPTION) / 2.0, size)
        seen = f"{int(p.frequency[r]):,}×" if p.frequency[r] else ""
        caption = "   ".join(t for t in (f"{first + i + 1}", valences, seen) if t)
        fits = (width - 12.0) / (0.6 * len(caption))
        scene.text(middle, bottom + 12.0, caption, min(11.0, fits))
    if not drawings:
        middle, y = (MARGIN + GRID_PART * scene.width) / 2.0, scene.height / 2.0
        scene.text(middle, y, "no pattern passes the filters", 16.0, colour=style.FAINT_TEXT)
    paint_legend(scene, drawings, (MARGIN + GRID_PART * scene.width) / 2.0, 14.0, 11.0)


@lru_cache(maxsize=2000)
def _thumbnail(code: bytes, mirrored: bool, tinted: bool) -> tuple[DiskDrawing, str]:
    pattern = Pattern.from_trusted_code(np.frombuffer(code, np.uint16))
    drawing = draw_disk(pattern.disk(), mirrored=mirrored, tinted=tinted)
    return drawing, format_valences(pattern.valences)


def _selected(
    scene: Scene, state: BrowserState, pattern: Pattern, disk: Disk, x: float, y: float, size: float
) -> None:
    """Draw the selected pattern about (x, y) in a square of this size, with its labels."""
    around = 50.0 if state.labelled else 8.0
    chosen = None
    if state.chord is not None:
        chosen = _bundle_of(pattern, state.widths, disk, state.chord)
    drawing = draw_disk(disk, mirrored=state.mirrored, tinted=state.tinted, choose=chosen)
    paint_disk(scene, drawing, x, y, size - 2.0 * around)
    if state.labelled:
        _labels(scene, disk, drawing, x, y, size - 2.0 * around)


def compose_selected(state: BrowserState, width: float, height: float) -> Scene:
    """Compose the selected pattern alone, in a picture of this size."""
    scene = Scene(width, height)
    pattern, disk = state.selected, state.selected_disk()
    if pattern is not None and disk is not None:
        x, y = width / 2.0, height / 2.0
        _selected(scene, state, pattern, disk, x, y, min(width, height) - 16.0)
    return scene


def describe_browser(sheet: FactSheet, state: BrowserState, meshes: Meshes | None) -> None:
    """Write what there is to say of the selected pattern."""
    title, text = _title(state)
    sheet.heading(title, 18.0)
    sheet.paragraph(text, style.FAINT_TEXT)
    pattern, disk = state.selected, state.selected_disk()
    if pattern is None or disk is None:
        sheet.paragraph("no pattern passes the filters", style.MESSAGE)
        return
    if state.inspecting:
        found = meshes(pattern) if meshes else ()
        for name, value in collect_facts(pattern, disk, state.widths, found):
            sheet.fact(name, value, mono=name in ("name", "code"))
    if state.chord is not None:
        text = f"polychord {state.chord} is chosen, of width {state.widths[state.chord]}"
        sheet.paragraph(text, style.TEXT)


def _bundle_of(pattern: Pattern, widths: Sequence[int], disk: Disk, chord: int) -> int:
    """The bundle that a pattern's polychord has become at these widths.

    Nearly always its own number; two self-crossing ones may share a bundle.
    """
    number = find_boundary_bundles(disk, find_bundles(disk))
    label = [c for side in pattern.label for c in side for _ in range(widths[c])]
    if chord in label and len(label) == disk.perimeter:
        return int(number[label.index(chord)])
    return int(number.max()) + 1 + chord - pattern.n_chords


def _labels(
    scene: Scene, disk: Disk, drawing: DiskDrawing, x: float, y: float, size: float
) -> None:
    """Number the sides, and every run of boundary edges that one bundle meets."""
    points = drawing.points[: disk.perimeter] * measure_scale(size) + (x, y)
    after = np.roll(points, -1, axis=0)
    along = after - points
    outward = np.stack([along[:, 1], -along[:, 0]], axis=1)
    # A mirror image runs clockwise.
    turn = np.sum(points[:, 0] * after[:, 1] - points[:, 1] * after[:, 0])
    outward *= np.sign(turn) / np.linalg.norm(outward, axis=1, keepdims=True)

    def halfway(edges: NDArray[np.int32]) -> tuple[Points, Points]:
        k = edges[len(edges) // 2]
        place = points[k] if len(edges) % 2 == 0 else (points[k] + after[k]) / 2.0
        return place, outward[k]

    number = find_boundary_bundles(disk, find_bundles(disk))
    for s, side in enumerate(disk.sides()):
        edges = side[:-1]
        cuts = np.flatnonzero(np.diff(number[edges])) + 1
        for run in np.split(edges, cuts):
            place, normal = halfway(run)
            at = place + normal * 11.0
            scene.text(at[0], at[1] - 4.0, str(number[run[0]]), 11.0, colour=style.FAINT_TEXT)
        if disk.n_sides:
            # Beyond the bundles' numbers; a text is wider than high.
            place, normal = halfway(edges)
            at = place + normal * (25.0 + 16.0 * abs(normal[0]))
            scene.text(at[0], at[1] - 4.0, f"side {s}", 11.0, bold=True)
