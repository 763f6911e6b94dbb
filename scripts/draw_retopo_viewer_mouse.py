"""A mouse over the window of retopology, and pictures of what it does: for its documentation."""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from viewer import style
from viewer.picture import save_drawn
from viewer.retopo import RetopoState
from viewer.retopo.keys import KEYS
from viewer.retopo.marks import FLOW, INK, MARKED, PREVIEW, SIDES
from viewer.retopo.modes import ToolMode
from viewer.retopo.picture import RetopoPainter
from viewer.scene import HEIGHT

#: Bytes that a picture may have, and the pixels of the window and of a tool.
LARGEST_PICTURE = 300_000


WINDOW = (1400, 900)


TOOL = (336, 280)

#: Columns of the sheet of tools, the height of a caption, and the gap between before and after.
COLUMNS = 3


CAPTION = 30


GAP = 2

#: Colours that a picture keeps, however few of its pixels have them.
ACCENTS = (
    INK,
    PREVIEW,
    FLOW,
    style.SELECTED,
    MARKED,
    *style.VALENCE_COLOURS.values(),
    *SIDES.values(),
)


Place = Sequence[float]


class Hand:
    """Moves the mouse over a state: places are in the plane of the hand, or of space.

    tools: pictures by the names of tools, with their captions.
    """

    def __init__(self, state: RetopoState, tools: dict[str, tuple[str, Image.Image]]) -> None:
        self.state = state
        self.tools = tools
        self._painter = RetopoPainter()
        self._before: Image.Image | None = None

    def seen(self, place: Place) -> tuple[float, float]:
        x, y, _ = self.state.camera.view.seen(np.array([*place, 0.0][:3])).tolist()
        return x, y

    def keys(self, text: str) -> None:
        for key in text.split():
            self.state.settle()
            KEYS.press(self.state, key)
        self.state.settle()

    @contextmanager
    def for_now(self) -> Iterator[None]:
        """What is done within is undone after it."""
        self.state.settle()
        steps = self.state.shown.undoable
        yield
        self.state.settle()
        while self.state.shown.undoable > steps:
            self.keys("u")

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

    def on(self, place: Place) -> None:
        """Go on with what is held."""
        self.state.move(*self.seen(place))
        self.state.settle()

    def release(self, told: str = "") -> None:
        """Let go; told: what may be said then."""
        self.state.release(*(self.state.camera.pointer or (0.0, 0.0)))
        self.state.settle()
        if self.state.message and (not told or told not in self.state.message):
            sys.exit(f"{self.state.tool.mode.title}: {self.state.message}")

    def drag(self, *places: Place) -> None:
        """Draw through places; curves may end openly, for the next one goes on from there."""
        self.press(*places)
        self.release("open end")

    def click(self, place: Place, told: str = "") -> None:
        self.press(place)
        self.release(told)

    def closer(self, place: Place, scale: float) -> None:
        """Look at a place from nearer by."""
        self.keys("v 3")
        focus = np.array([*place, 0.0][:3])
        self.state.camera.view = replace(
            self.state.camera.view, focus=focus, scale=self.state.camera.view.scale * scale
        )

    def tool(self, caption: str) -> None:
        """Take a picture of the tool in use."""
        self.tools[self.state.tool.mode.tool] = caption, self.image(TOOL)

    def before(self) -> None:
        """Take the left half of a picture of the tool in use."""
        self._before = self.image(((TOOL[0] - GAP) // 2, TOOL[1]))

    def after(self, caption: str, tool: str = "") -> None:
        """Take the right half of it."""
        assert self._before is not None
        image = Image.new("RGB", TOOL, "#c9ced6")
        image.paste(self._before, (0, 0))
        right = self.image(self._before.size)
        image.paste(right, (TOOL[0] - right.width, 0))
        self.tools[tool or self.state.tool.mode.tool] = caption, image

    def image(self, size: tuple[int, int]) -> Image.Image:
        share = HEIGHT / WINDOW[1]
        drawn = self._painter.compose(self.state, share * size[0], share * size[1])
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "picture.png"
            save_drawn(path, drawn, size[1])
            with Image.open(path) as image:
                return image.convert("RGB").resize(size)


def sheet(tools: dict[str, tuple[str, Image.Image]], modes: Sequence[ToolMode]) -> Image.Image:
    """All pictures of tools with their keys and captions, in the order of the modes."""
    import matplotlib

    rows = -(-len(modes) // COLUMNS)
    width, height = TOOL[0] + 8, TOOL[1] + CAPTION
    image = Image.new("RGB", (COLUMNS * width, rows * height), "white")
    draw = ImageDraw.Draw(image)
    folder = Path(matplotlib.get_data_path()) / "fonts" / "ttf"
    bold, plain = (
        ImageFont.truetype(str(folder / f"{name}.ttf"), 14)
        for name in ("DejaVuSans-Bold", "DejaVuSans")
    )
    for k, mode in enumerate(modes):
        caption, picture = tools[mode.tool]
        x, y = k % COLUMNS * width + 4, k // COLUMNS * height
        image.paste(picture, (x, y + CAPTION))
        draw.text((x + 4, y + CAPTION / 2), mode.key, style.MESSAGE, bold, anchor="lm")
        draw.text((x + 24, y + CAPTION / 2), mode.title, "#1f2733", bold, anchor="lm")
        past = x + 32 + draw.textlength(mode.title, bold)
        draw.text((past, y + CAPTION / 2), caption, "#4a5361", plain, anchor="lm")
    return image


def few_colours(image: Image.Image, count: int) -> Image.Image:
    """The picture in so many colours. Few pixels have strong ones, and those must stay."""
    with_accents = image.copy()
    side = round((image.width * image.height / 2000.0) ** 0.5)
    for k, colour in enumerate(ACCENTS):
        with_accents.paste(colour, (k * side, 0, (k + 1) * side, 4 * side))
    palette = with_accents.quantize(count, dither=Image.Dither.NONE)
    colours = np.array(palette.getpalette()).reshape(-1, 3)
    # What is nearly white takes the paper along.
    colours[(255 - colours).max(axis=1).argmin()] = 255
    palette.putpalette(colours.ravel().tolist())
    # Dithering would hide the steps of grey that one hardly sees, and make files twice as large.
    return image.quantize(palette=palette, dither=Image.Dither.NONE)


def save(image: Image.Image, path: Path) -> None:
    """Write a picture in as many colours as it may have."""
    image.save(path, optimize=True)
    for count in (256, 192, 128):
        if path.stat().st_size > LARGEST_PICTURE:
            few_colours(image, count).save(path, optimize=True)
    size = path.stat().st_size
    print(f"{path}: {size:,} bytes")
    if size > LARGEST_PICTURE:
        sys.exit(f"{path} has over {LARGEST_PICTURE:,} bytes; draw less in it")
