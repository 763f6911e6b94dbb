"""Draw the pictures of the window of retopology of the documentation.

    python scripts/draw_retopo_viewer.py [--out DIR]

A hand is drawn on, tool by tool, by the moves of a mouse: what each shows while it is used is a
picture of retopo-tools.png; retopo-viewer.png is the whole window. The hand is that of the
examples, made smooth. Needs no display.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import trimesh
from PIL import Image, ImageDraw, ImageFont

import patterndb
from ingest.read import read_mesh
from query.placing import Surface
from sketch.retopo.editor import Editor
from sketch.retopo.ground import Ground
from viewer import style
from viewer.explorer_picture import save_drawn
from viewer.retopo import RetopoState
from viewer.retopo.keys import KEYS
from viewer.retopo.palette import FLOW, INK, MARKED, PREVIEW, SIDES, VALENCES
from viewer.retopo.picture import Painter
from viewer.scene import HEIGHT

ROOT = Path(__file__).parents[1]

#: Bytes that a picture may have, and the pixels of the window and of a tool.
LARGEST_PICTURE = 300_000
WINDOW = (1400, 900)
TOOL = (340, 290)

#: Columns of the sheet of tools, and the height of a caption.
COLUMNS = 4
CAPTION = 30

#: Colours that a picture keeps, however few of its pixels have them.
ACCENTS = (INK, PREVIEW, FLOW, style.SELECTED, MARKED, *VALENCES.values(), *SIDES.values())

#: Rounds of subdivision that make the hand smooth.
ROUNDS = 3

#: Fingers: the middles of their first and last loops in the plane of the hand, half the length of
#: the line that cuts them, and how many patches go around.
FINGERS = {
    "pinky": ((-3.45, 0.2), (-4.35, 3.72), 1.1),
    "ring": ((-1.25, 0.9), (-1.64, 6.15), 1.05),
    "middle": ((1.24, 0.9), (1.24, 7.25), 1.05),
    "index": ((3.3, 0.9), (4.17, 6.05), 1.0),
    "thumb": ((5.0, -5.1), (7.55, -3.05), 1.25),
}

Place = Sequence[float]


class Hand:
    """Moves the mouse over a state: places are in the plane of the hand."""

    def __init__(self, state: RetopoState) -> None:
        self.state = state
        self._painter = Painter()
        self._tools: list[tuple[str, Image.Image]] = []

    def seen(self, place: Place) -> tuple[float, float]:
        x, y, _ = self.state.view.seen(np.array([*place, 0.0][:3])).tolist()
        return x, y

    def keys(self, text: str) -> None:
        for key in text.split():
            self.state.settle()
            KEYS.press(self.state, key)
        self.state.settle()

    def hover(self, place: Place) -> None:
        self.state.move(*self.seen(place))
        self.state.settle()

    def press(self, *places: Place) -> None:
        """Draw through places, and do not let go."""
        ways = [np.array(self.seen(place)) for place in places]
        self.state.move(*ways[0].tolist())
        self.state.press(*ways[0].tolist())
        for k in range(1, len(ways)):
            for share in np.linspace(0.0, 1.0, 13)[1:].tolist():
                self.state.move(*(ways[k - 1] + share * (ways[k] - ways[k - 1])).tolist())
        self.state.settle()

    def release(self) -> None:
        self.state.release(*(self.state.pointer or (0.0, 0.0)))
        self.state.settle()
        if self.state.message:
            sys.exit(f"{self.state.mode.title}: {self.state.message}")

    def drag(self, *places: Place) -> None:
        self.press(*places)
        self.release()

    def click(self, place: Place) -> None:
        self.drag(place)

    def closer(self, place: Place, scale: float) -> None:
        """Look at a place from nearer by."""
        self.keys("v 3")
        focus = np.array([*place, 0.0][:3])
        self.state.view = replace(self.state.view, focus=focus, scale=self.state.view.scale * scale)

    def tool(self, caption: str) -> None:
        """Take a picture of the tool in use."""
        image = self.image(TOOL, bare=True)
        self._tools.append((caption, image))

    def image(self, size: tuple[int, int], *, bare: bool) -> Image.Image:
        height = size[1] * HEIGHT / WINDOW[1]
        drawn = self._painter.compose(self.state, size[0] / size[1], bare=bare, height=height)
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "picture.png"
            save_drawn(path, drawn, size[1])
            with Image.open(path) as image:
                return image.convert("RGB")

    def sheet(self) -> Image.Image:
        """All pictures of tools with their captions."""
        import matplotlib

        rows = -(-len(self._tools) // COLUMNS)
        width, height = TOOL[0], TOOL[1] + CAPTION
        sheet = Image.new("RGB", (COLUMNS * width, rows * height), "white")
        draw = ImageDraw.Draw(sheet)
        folder = Path(matplotlib.get_data_path()) / "fonts" / "ttf"
        font = ImageFont.truetype(str(folder / "DejaVuSans.ttf"), 14)
        for k, (caption, image) in enumerate(self._tools):
            x, y = k % COLUMNS * width, k // COLUMNS * height
            sheet.paste(image.resize(TOOL), (x, y + CAPTION))
            draw.text((x + width / 2, y + CAPTION / 2), caption, "#1f2733", font, anchor="mm")
        return sheet


def smooth_hand() -> Ground:
    """The hand of the examples, subdivided."""
    coarse = Surface.from_polygons(read_mesh(ROOT / "examples" / "hand.obj"))
    mesh = trimesh.Trimesh(coarse.vertices, coarse.triangles).subdivide_loop(ROUNDS)
    return Ground.of(mesh.vertices, mesh.faces)


def across(middle: Place, other: Place, half: float) -> tuple[Place, Place]:
    """A line across a finger at the middle of a loop of it."""
    along = np.subtract(other, middle)
    side = np.array([along[1], -along[0]]) / np.linalg.norm(along)
    return (np.add(middle, half * side).tolist(), np.subtract(middle, half * side).tolist())


def fingers(hand: Hand) -> None:
    """Loops around fingers, and cylinders between them."""
    for name, (low, high, half) in FINGERS.items():
        shown = name == "middle"
        if shown:
            hand.closer((1.2, 4.0), 2.0)
        hand.keys("l")
        hand.drag(*across(low, high, half))
        hand.press(*across(high, low, half))
        if shown:
            hand.tool("loop: a line across cuts it")
        hand.release()
        hand.keys("c")
        hand.press(low, high)
        if shown:
            hand.tool("cylinder: from loop to loop")
        hand.release()
        if shown:
            hand.keys("v 3")


def palm(hand: Hand) -> None:
    """A patch about a spine, completions beside it, and curves drawn freely."""
    hand.closer((0.4, -4.0), 2.1)
    hand.keys("i ] ]")
    hand.press((0.3, -1.7), (0.35, -3.5), (0.45, -5.0), (0.6, -6.4))
    hand.tool("spine: a patch about its midline")
    hand.release()
    hand.keys("a")
    hand.hover((1.45, -4.0))
    hand.tool("complete: what would close here …")
    hand.keys("-")
    hand.tool("… or something smaller")
    hand.keys("+")
    hand.click((1.45, -4.0))
    hand.click((-0.75, -4.0))


def curves(hand: Hand) -> None:
    """Curves that make patches of three, four and five sides around."""
    hand.closer((0.4, -5.0), 1.6)
    hand.keys("d")
    (low_left, low_right), (top_left, top_right), (left_top, left_low, right_top, right_low) = (
        corners(hand)
    )
    hand.drag(top_left, beside(left_top, 0.6, 0.7), left_top)
    hand.drag(top_right, beside(right_top, -0.6, 0.6), right_top)
    hand.drag(low_left, (-0.5, -8.3))
    hand.drag((-0.5, -8.3), (-2.3, -7.9))
    hand.press((-2.3, -7.9), (-2.7, -6.6), beside(left_low, 0.1, -0.1))
    hand.tool("draw: ends snap, as rings show")
    hand.release()
    hand.drag(low_right, (1.7, -8.3))
    hand.drag((1.7, -8.3), (2.9, -6.9), right_low)


def beside(place: Place, x: float, y: float) -> Place:
    """A place so far to the right of another, and above it."""
    return (place[0] + x, place[1] + y)


def corners(hand: Hand) -> tuple[list[Place], list[Place], list[Place]]:
    """Of the patches on the palm: the lower ones of the middle one, its upper ones, and those
    at the far sides of its neighbours, left and right, the upper first."""
    nodes = [node.point[:2] for node in hand.state.network.nodes.values() if node.valence == 2]
    palm = [at for at in nodes if at[1] < -1.0 and at[0] < 4.4]
    palm.sort(key=lambda at: at[1])
    middle = sorted(palm[:2], key=lambda at: at[0]), sorted(palm[-2:], key=lambda at: at[0])
    beside = sorted(palm[2:-2], key=lambda at: (at[0] > 0.0, -at[1]))
    low, top = ([at.tolist() for at in pair] for pair in middle)
    return low, top, [at.tolist() for at in beside]


def shaping(hand: Hand) -> None:
    """Curves that are there get another course."""
    hand.closer((0.4, -5.0), 1.9)
    hand.keys("g")
    hand.press((-2.3, -7.9), (-3.0, -8.3))
    hand.tool("pull: curves follow a corner")
    hand.release()
    hand.keys("u r")
    hand.press((-2.4, -7.5), (-3.4, -6.9), (-3.3, -6.2), (-2.68, -5.7))
    hand.tool("redraw: a part of a curve anew")
    hand.release()
    hand.keys("u f")
    hand.hover((2.85, -7.0))
    hand.tool("smooth: a click on a curve")
    hand.click((2.85, -7.0))


def details(hand: Hand) -> None:
    """Counts, flow, other fills, corners, and erasing."""
    hand.keys("t")
    hand.hover((-1.4, -8.1))
    hand.tool("count: the wheel over a curve")
    hand.keys("y")
    hand.hover((-1.3, -6.8))
    hand.tool("fill: the next for a patch")
    hand.keys("w")
    hand.press((-0.55, -2.6), (0.3, -2.9), (0.6, -3.8), (0.7, -5.2), (1.1, -6.0))
    hand.tool("flow: where edges are to run")
    hand.release()
    hand.hover((4.2, -8.0))
    hand.tool("… and they do")
    hand.keys("u j")
    hand.hover((-0.5, -8.3))
    hand.tool("corner: add or delete one")
    hand.keys("e")
    hand.press((2.2, -6.2), (3.4, -7.2))
    hand.tool("erase: what a scribble crosses")
    hand.release()
    hand.keys("u m m")
    hand.closer((1.8, -1.5), 1.15)
    hand.hover((9.0, 0.0))
    hand.tool("the quads alone")
    hand.keys("m")


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--out", type=Path, default=ROOT / "docs" / "images")
    out = parser.parse_args().out
    with patterndb.open() as source:
        state = RetopoState(Editor(smooth_hand(), source), title="hand.obj")
        hand = Hand(state)
        try:
            hand.image(TOOL, bare=True)
            # Fingers want finer quads than what is usual.
            hand.keys("3 t [ [ [ [ [")
            fingers(hand)
            palm(hand)
            curves(hand)
            shaping(hand)
            details(hand)
            save(hand.sheet(), out / "retopo-tools.png")
            hand.image(WINDOW, bare=False)
            hand.keys("v 3 a")
            hand.hover((0.6, -6.7))
            save(hand.image(WINDOW, bare=False), out / "retopo-viewer.png")
        finally:
            state.close()


def few_colours(image: Image.Image) -> Image.Image:
    """The picture in 256 colours. Few pixels have strong ones, and those must stay."""
    with_accents = image.copy()
    side = round((image.width * image.height / 2000.0) ** 0.5)
    for k, colour in enumerate(ACCENTS):
        with_accents.paste(colour, (k * side, 0, (k + 1) * side, 4 * side))
    palette = with_accents.quantize(256, dither=Image.Dither.NONE)
    return image.quantize(palette=palette, dither=Image.Dither.FLOYDSTEINBERG)


def save(image: Image.Image, path: Path) -> None:
    """Write a picture in as many colours as it may have."""
    image.save(path, optimize=True)
    if path.stat().st_size > LARGEST_PICTURE:
        few_colours(image).save(path, optimize=True)
    size = path.stat().st_size
    print(f"{path}: {size:,} bytes")
    if size > LARGEST_PICTURE:
        sys.exit(f"{path} has over {LARGEST_PICTURE:,} bytes; draw less in it")


if __name__ == "__main__":
    main()
