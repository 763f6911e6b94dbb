"""The window of the viewer of shape models, a thin shell on its state, and pictures without one."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from numpy.typing import ArrayLike

from sketch.features.registration import Template
from sketch.features.shapemodel import ShapeModel
from viewer.browse import WINDOW
from viewer.explorer_picture import check_png, save_drawn
from viewer.explorer_scene import Drawn
from viewer.keymap import Effect
from viewer.opengl import prepare_opengl
from viewer.scene import HEIGHT
from viewer.shapes.keys import KEYS
from viewer.shapes.objfile import write_obj
from viewer.shapes.picture import compose
from viewer.shapes.state import ShapesState
from viewer.window import Window


def show(
    shapes: ShapeModel,
    template: Template,
    *,
    title: str,
    output: Path | None,
    coefficients: ArrayLike | None = None,
    keys: str = "",
    window_size: tuple[int, int] = WINDOW,
) -> None:
    """Explore a shape model in a window, until it is closed.

    template: the one that the model's shapes were laid with. title: of the window. output: the
    OBJ file that the key o writes; pictures go beside it. Without it new files in the current
    folder are written, shape-1.obj and so on. coefficients: (l,) of the first shape, by default
    the mean. keys: pressed first, with spaces between ("n g"). window_size: pixels.

    Raises InvalidFeatureError for a template or coefficients of another model, ValueError for a
    key there is not, and DisplayError if no window can be opened here.
    """
    pressed = KEYS.check(keys)
    state = ShapesState(shapes, template, coefficients)
    prepare_opengl(off_screen=False)
    saver = Saver(state, output, window_size)
    if saver.play(pressed) is Effect.QUIT:
        return
    window = Window(state, saver, KEYS, window_size, title)
    try:
        window.run()
    finally:
        window.close()


def draw(
    shapes: ShapeModel,
    template: Template,
    path: Path | str,
    *,
    coefficients: ArrayLike | None = None,
    size: tuple[int, int] = (1200, 800),
    keys: str = "",
    bare: bool = True,
    caption: str = "",
) -> None:
    """Write a picture of a shape to a PNG, without a window and OpenGL.

    path: where to; size: its pixels. bare: without the panel. caption: a line below the shape.
    All else as for :func:`show`. The same input gives the same picture.

    Raises PictureFormatError if path is not a PNG, InvalidFeatureError for a template or
    coefficients of another model, and ValueError for a key there is not.
    """
    pressed = KEYS.check(keys)
    path = check_png(path)
    state = ShapesState(shapes, template, coefficients)
    Saver(state, path.with_suffix(".obj"), size).play(pressed)
    # As many points to a pixel as in a window: lines are as wide in small pictures.
    height = size[1] * HEIGHT / WINDOW[1]
    drawn = compose(state, size[0] / size[1], bare=bare, caption=caption, height=height)
    save_drawn(path, drawn, size[1])


class Saver:
    """Obeys keys, and writes what some of them save.

    output: as for :func:`show`.
    """

    def __init__(self, state: ShapesState, output: Path | None, size: tuple[int, int]) -> None:
        self.state = state
        self.size = size
        self._output = output

    def drawn(self) -> Drawn:
        """The picture of the state as it is now."""
        return compose(self.state, self.size[0] / self.size[1])

    def play(self, keys: Sequence[str]) -> Effect:
        """Press keys one after another; QUIT if one quits."""
        for key in keys:
            if self.obey(key) is Effect.QUIT:
                return Effect.QUIT
        return Effect.NOTHING

    def obey(self, key: str) -> Effect:
        """Press a key, and save what it asks to save."""
        effect = KEYS.press(self.state, key)
        if effect in (Effect.OBJ, Effect.PICTURE):
            try:
                self.state.message = f"saved {self._saved(effect)}"
            except OSError as error:
                self.state.message = f"not saved: {error}"
        return effect

    def _saved(self, effect: Effect) -> Path:
        if effect is Effect.OBJ:
            path = self._free(".obj") if self._output is None else self._output
            write_obj(path, self.state)
        else:
            path = self._free(".png")
            save_drawn(path, self.drawn(), self.size[1])
        return path

    def _free(self, suffix: str) -> Path:
        """A name that no file has, beside the output."""
        given = Path("shape") if self._output is None else self._output
        count = 1
        while (path := given.with_name(f"{given.stem}-{count}{suffix}")).exists():
            count += 1
        return path
