"""The pattern browser's picture as filled polygons and lines of text: no window in here."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from patterndb.core.disk import Disk
from patterndb.core.pattern import Pattern
from patterndb.geometry.points import Points
from viewer import style
from viewer.browser_commands import KEY_HELP
from viewer.browser_state import COLUMNS, ROWS, BrowserState
from viewer.card import collect_facts, format_valences
from viewer.drawing import DiskDrawing, draw_disk, find_boundary_bundles, find_bundles
from viewer.facts import FactWriter
from viewer.painting import Text, measure_scale, paint_disk, paint_legend

Meshes = Callable[[Pattern], Sequence[str]]

#: The picture is laid out this high, in points, whatever the window's size.
HEIGHT = 860.0

HEADER = 56.0
MARGIN = 28.0
CAPTION = 30.0

#: Part of the width that thumbnails take.
GRID_PART = 0.6

HIGHLIGHT = "#e8f0fa"
HIGHLIGHT_LINE = "#7fa8d6"
RULE = "#e3e6ea"


@dataclass(slots=True)
class ScenePolygons:
    """Polygons of one layer: (n, c, 2) corners and (n, 3) colours, 0 to 1."""

    corners: Points
    colours: Points


class Scene:
    """A canvas that remembers what is painted on it, back to front."""

    def __init__(self, width: float, height: float) -> None:
        self.width, self.height = width, height
        self.patches: list[ScenePolygons] = []
        self.texts: list[Text] = []

    def polygons(
        self,
        corners: Points,
        *,
        face: str = "none",
        faces: Points | None = None,
        line: str = "none",
        width: float = 0.0,
        gid: str | None = None,
    ) -> None:
        """See viewer.painting.PaintTarget; outlines become polygons, too."""
        if faces is None and face != "none":
            faces = np.tile(style.parse_colour(face), (len(corners), 1))
        if faces is not None:
            self.patches.append(ScenePolygons(corners, faces))
        if line != "none" and width > 0.0:
            edges = _strokes(corners, width)
            self.patches.append(
                ScenePolygons(edges, np.tile(style.parse_colour(line), (len(edges), 1)))
            )

    def text(
        self,
        x: float,
        y: float,
        text: str,
        size: float,
        *,
        colour: str = style.TEXT,
        bold: bool = False,
        mono: bool = False,
        align: str = "center",
    ) -> None:
        """See viewer.painting.PaintTarget."""
        self.texts.append(Text(x, y, text, size, colour, bold, mono, align))

    def box(self, x: float, y: float, width: float, height: float, face: str, line: str) -> None:
        """Paint a rectangle, (x, y) its lower left."""
        right, top = x + width, y + height
        corners = np.array([[x, y], [right, y], [right, top], [x, top]])
        self.polygons(corners[None], face=face, line=line, width=1.2)


def compose_browser(state: BrowserState, aspect: float, meshes: Meshes | None = None) -> Scene:
    """Compose the whole picture for a window of this width to height.

    meshes: names of the meshes that a pattern occurs in.
    """
    scene = Scene(HEIGHT * aspect, HEIGHT)
    _header(scene, state)
    _thumbnails(scene, state)
    if state.helping:
        _help(scene)
    _panel(scene, state, meshes)
    return scene


def find_cell(scene: Scene, state: BrowserState, x: float, y: float) -> int | None:
    """Find the place of the thumbnail at (x, y) among the filtered patterns, None without."""
    width, height = _cell(scene)
    column, row = int((x - MARGIN) // width), int((scene.height - HEADER - y) // height)
    item = row * COLUMNS + column
    if 0 <= column < COLUMNS and 0 <= row < ROWS and item < len(state.page_rows()):
        return state.page * COLUMNS * ROWS + item
    return None


def _cell(scene: Scene) -> tuple[float, float]:
    width = (GRID_PART * scene.width - MARGIN) / COLUMNS
    return width, (scene.height - HEADER - 36.0) / ROWS


def _header(scene: Scene, state: BrowserState) -> None:
    y = scene.height - 34.0
    n = state.patterns.n_sides
    title = "1 side" if n == 1 else f"{n} sides"
    scene.text(MARGIN + 8.0, y, title, 19.0, bold=True, align="left")
    total, shown = len(state.patterns), len(state.rows)
    text = f"{total:,} pattern" + ("" if total == 1 else "s")
    if state.filters():
        text = f"{shown:,} of {text}: {state.filters()}"
    scene.text(MARGIN + 120.0, y, text, 13.0, align="left")
    right = GRID_PART * scene.width - 8.0
    page = f"page {state.page + 1} of {state.n_pages}"
    scene.text(right, y, page, 13.0, colour=style.FAINT_TEXT, align="right")
    keys = "h  keys      q  quit"
    scene.text(scene.width - MARGIN, y, keys, 12.0, colour=style.FAINT_TEXT, align="right")


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


def _panel(scene: Scene, state: BrowserState, meshes: Meshes | None) -> None:
    left = GRID_PART * scene.width + MARGIN
    width = scene.width - left - MARGIN
    scene.box(left - 14.0, 30.0, 0.0, HEIGHT - 80.0, RULE, RULE)
    pattern, disk = state.selected, state.selected_disk()
    if pattern is None or disk is None:
        return
    facts = collect_facts(pattern, disk, state.widths, meshes(pattern) if meshes else ())
    facts_height = 21.0 * len(facts) + 24.0 if state.inspecting else 0.0
    room = scene.height - HEADER - facts_height - 56.0
    x, y = left + width / 2.0, scene.height - HEADER - room / 2.0
    _selected(scene, state, pattern, disk, x, y, min(width, room))
    line = facts_height + 40.0
    if state.message:
        fits = width / (0.6 * len(state.message))
        scene.text(x, line, state.message, min(12.0, fits), colour=style.MESSAGE)
    elif state.chord is not None:
        text = f"polychord {state.chord}, width {state.widths[state.chord]}      [ ]  ↑ ↓  r"
        scene.text(x, line, text, 13.0, colour=style.MESSAGE)
    for i, (name, value) in enumerate(facts if state.inspecting else ()):
        at = facts_height + 8.0 - 21.0 * i
        scene.text(left + 4.0, at, name, 12.0, colour=style.FAINT_TEXT, align="left")
        fits = (width - 96.0) / (0.62 * max(len(value), 1))
        mono = name in ("name", "code")
        scene.text(left + 92.0, at, value, min(12.5, fits), mono=mono, align="left")


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


def describe_browser(writer: FactWriter, state: BrowserState, meshes: Meshes | None) -> None:
    """Write what there is to say of the selected pattern."""
    total, shown = len(state.patterns), len(state.rows)
    n = state.patterns.n_sides
    writer.heading("1 side" if n == 1 else f"{n} sides", 18.0)
    text = f"{total:,} pattern" + ("" if total == 1 else "s")
    if state.filters():
        text = f"{shown:,} of {text}: {state.filters()}"
    writer.paragraph(text, style.FAINT_TEXT)
    pattern, disk = state.selected, state.selected_disk()
    if pattern is None or disk is None:
        writer.paragraph("no pattern passes the filters", style.MESSAGE)
        return
    if state.inspecting:
        found = meshes(pattern) if meshes else ()
        for name, value in collect_facts(pattern, disk, state.widths, found):
            writer.fact(name, value, mono=name in ("name", "code"))
    if state.chord is not None:
        text = f"polychord {state.chord} is chosen, of width {state.widths[state.chord]}"
        writer.paragraph(text, style.TEXT)


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


def _help(scene: Scene) -> None:
    width, height = 430.0, 26.0 * len(KEY_HELP) + 60.0
    left = (MARGIN + GRID_PART * scene.width - width) / 2.0
    top = (scene.height + height) / 2.0
    # Text is painted over everything; what the list covers must go.
    covered = [
        t
        for t in scene.texts
        if left - 70.0 < t.x < left + width + 70.0 and top - height - 8.0 < t.y < top
    ]
    scene.texts = [t for t in scene.texts if t not in covered]
    scene.box(left, top - height, width, height, style.PAPER, HIGHLIGHT_LINE)
    scene.text(left + 24.0, top - 34.0, "Keys", 15.0, bold=True, align="left")
    for i, (keys, what) in enumerate(KEY_HELP):
        y = top - 64.0 - 26.0 * i
        scene.text(left + 24.0, y, keys, 12.5, bold=True, align="left")
        scene.text(left + 150.0, y, what, 12.5, align="left")


def _strokes(corners: Points, width: float) -> Points:
    """(n * c, 4, 2) a thin rectangle for every edge of (n, c, 2) polygons, ends lapping."""
    a = corners.reshape(-1, 2)
    b = np.roll(corners, -1, axis=1).reshape(-1, 2)
    length = np.linalg.norm(b - a, axis=1, keepdims=True)
    along = (b - a) / np.where(length > 0.0, length, 1.0) * width / 2.0
    across = np.stack([along[:, 1], -along[:, 0]], axis=1)
    a, b = a - 0.7 * along, b + 0.7 * along
    return np.stack([a + across, b + across, b - across, a - across], axis=1)
