"""The window of the viewer of shape models, a thin shell on its state, and pictures without one."""

from __future__ import annotations

from collections.abc import Collection
from importlib import import_module
from pathlib import Path
from threading import Thread
from typing import Any

from numpy.typing import ArrayLike

from patterndb.system.files import replace_file
from patterndb.system.obj import format_obj
from patterndb_sketch.features.registration import Template
from patterndb_sketch.features.shapemodel import ShapeModel
from patterndb_sketch.features.shapemodel.shaping import SHAPE_SESSION, ShapeChoice, Shaping
from patterndb_sketch.recovery import WorkKeeper, find_free_name
from patterndb_sketch.sessions import digest_arrays
from viewer import saver
from viewer.commands import Command
from viewer.facts import FactSheet
from viewer.picture import WINDOW, check_png, save_drawn
from viewer.saver import SaveWay
from viewer.shapes.commands import COMMANDS, KEYS
from viewer.shapes.picture import compose_shape, describe_shape
from viewer.shapes.state import ShapesState
from viewer.stage import Drawn, LayerCache


def write_shape(path: Path, shaping: Shaping) -> None:
    """Write the shape that is shown; every number reads back as it was.

    The vertices are in the model's order, so that files of one model can be compared, and laid
    on each other. Raises OSError as writing does.
    """
    sigmas = " ".join(f"{value:.4g}" for value in shaping.sigmas.tolist())
    comments = (
        f"a shape of a model of {len(shaping.shapes.names)} shapes",
        f"modes in standard deviations: {sigmas}",
    )
    replace_file(path, format_obj(shaping.points, shaping.shapes.quads.tolist(), comments=comments))


def show(
    shapes: ShapeModel,
    template: Template,
    *,
    title: str,
    output: Path | None,
    coefficients: ArrayLike | None = None,
    held: Collection[str] = (),
    keys: str = "",
    window_size: tuple[int, int] = WINDOW,
) -> None:
    """Explore a shape model in a window, until it is closed.

    template: the one that the model's shapes were laid with. title: of the window. output: the
    OBJ file that the key o writes; pictures go beside it. Without it new files in the current
    folder are written, shape-1.obj and so on. coefficients: (l,) of the first shape, by default
    the mean. held: names of the curves that are held at first. keys: pressed first, with spaces
    between ("n g"). window_size: pixels.

    Raises InvalidFeatureError for a template or coefficients of another model, ValueError for a
    key there is not, and DisplayError if no window can be opened here.
    """
    pressed = KEYS.check(keys)
    # Qt is imported for windows alone: pictures need none.
    from viewer.shell.probe import check_display

    check_display()
    state = ShapesState(shapes, template, coefficients, held)
    shell = ShapesSaver(state, output, window_size)
    shell.watch()
    # Random shapes need it; imported with the first of them it stops the window for a second.
    Thread(target=import_module, args=("scipy.stats",), daemon=True).start()
    from viewer.shapes.docks import ShapesWindow
    from viewer.shell.opening import open_window

    open_window(shell, pressed, title, ShapesWindow)


def draw(
    shapes: ShapeModel,
    template: Template,
    path: Path | str,
    *,
    coefficients: ArrayLike | None = None,
    size: tuple[int, int] = (1200, 800),
    keys: str = "",
    caption: str = "",
) -> None:
    """Write a picture of a shape to a PNG, without a window.

    path: where to; size: its pixels. caption: a line below the shape.
    All else as for :func:`show`. The same input gives the same picture.

    Raises PictureFormatError if path is not a PNG, InvalidFeatureError for a template or
    coefficients of another model, and ValueError for a key there is not.
    """
    pressed = KEYS.check(keys)
    path = check_png(path)
    state = ShapesState(shapes, template, coefficients)
    ShapesSaver(state, path.with_suffix(".obj"), size).play(pressed)
    save_drawn(path, compose_shape(state, float(size[0]), float(size[1]), caption), size[1])


class ShapesSaver(saver.Saver):
    """Obeys keys, and writes what some of them save.

    output: as for :func:`show`.
    """

    kind = "shape-model"
    commands = COMMANDS
    state: ShapesState

    def __init__(self, state: ShapesState, output: Path | None, size: tuple[int, int]) -> None:
        super().__init__(state, KEYS, size)
        self._cache = LayerCache()
        self._output = output
        if output is not None:
            self.known.note(output)

    def watch(self) -> None:
        """Keep the shape from now on in case of a crash, beside the output, and read what one
        left."""
        shapes = self.state.shaping.shapes
        of = digest_arrays(shapes.mean, shapes.deviations, shapes.quads)
        folder = Path() if self._output is None else self._output.parent

        def is_usable(choice: ShapeChoice) -> bool:
            return choice.coefficients.shape == (shapes.n_modes,)

        self.keep_by(
            WorkKeeper(SHAPE_SESSION, of, self.kept_work(), folder, ShapeChoice.is_like, is_usable)
        )

    def kept_work(self) -> ShapeChoice:
        return self.state.shaping.choice

    def draw_live(self, width: float, height: float) -> Drawn:
        return compose_shape(self.state, width, height, cache=self._cache)

    def describe(self, sheet: FactSheet) -> None:
        describe_shape(sheet, self.state)

    def hint(self) -> str:
        if self.state.dragging:
            return "Esc: as if it had not been pulled    x y z: along an axis"
        under = self.state.under()
        if under is None:
            return "drag a curve: the shape follows    beside it: turn"
        held = under.name in self.state.shaping.choice.held
        click = "let it go" if held else "hold it"
        return f"drag {under.title}: the shape follows    click: {click}"

    def ready(self) -> None:
        """Nothing is made in the background."""

    def picture_path(self) -> Path:
        return self._free(".png")

    def refuse(self, command: Command[Any]) -> str:
        idle = self.state.dragging and command.menu == "File"
        return "let go first, or press Esc" if idle else ""

    def would_lose(self) -> str:
        return "The shape is not saved." if self.state.shaping.unsaved else ""

    def save_ways(self) -> tuple[SaveWay, ...]:
        return (
            SaveWay("save-shape", "Save shape", ".obj", self.write, self._object_path,
                    lambda: self._output),
        )  # fmt: skip

    def write(self, path: Path) -> str:
        """Write the shape to a file."""
        self.known.save(path, lambda: write_shape(path, self.state.shaping))
        self.state.shaping.mark_saved()
        self.note_saved()
        return f"saved {path}"

    def _object_path(self) -> Path:
        return self._free(".obj")

    def _free(self, suffix: str) -> Path:
        """A name that no file has, beside the output."""
        given = Path("shape") if self._output is None else self._output
        return find_free_name(given.parent, given.stem, suffix)
