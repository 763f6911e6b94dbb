"""Draw the pictures of shape models of the documentation, from thirteen generated bodies.

    python scripts/draw_shapes.py [--out DIR]

features-shapes.png is a sheet of the first modes; shapes-viewer.png the viewer, while a curve is
pulled as a person would pull it. Registering the bodies takes half a minute. Needs no display.
"""

from __future__ import annotations

import argparse
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
from PIL import Image

from patterndb.core.polygonmesh import PolygonMesh
from patterndb.geometry.points import Points
from patterndb.geometry.surface import Surface
from patterndb_sketch.features.registration import Template, box_template, register
from patterndb_sketch.features.shapemodel import ShapeModel
from viewer import style
from viewer.camera import View, fit_view
from viewer.picture import save_drawn
from viewer.scene import Scene
from viewer.shapes import ShapesState
from viewer.shapes.commands import KEYS
from viewer.shapes.picture import compose_shape
from viewer.stage import Drawn, Layer, Marks

sys.path.insert(0, str(Path(__file__).parents[1] / "examples"))
from bodies import CARS, body

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT / "benchmarks"))


#: Resolution of the bodies, and vertices along the edges of the template's boxes.
FINE, R, ALONG = 2.0, 13, 25

#: Pixels of the picture of the viewer, and bytes that a picture may have.
VIEWER = (1200, 750)
LARGEST_PICTURE = 300_000

#: Steps of red, green and blue, of 255.
STEP = 3

#: The sheet: modes, how far they go in standard deviations, the size of a cell in points, the
#: width of the titles at the left, the height of those above, and pixels to a point.
MODES = 4
SIGMAS = (-2.0, 0.0, 2.0)
CELL = (600.0, 322.0)
LEFT, ABOVE = 176.0, 70.0
PIXELS = 0.65

#: From where the sheet's bodies are seen.
TOWARD, UP = (-0.75, -1.0, 0.42), (0.0, 0.0, 1.0)


def shape_model() -> tuple[ShapeModel, Template]:
    """The model of all bodies, and its template."""
    from feature_shapes import drawn

    template = box_template(R, ALONG)
    laid = []
    for name in CARS:
        shown = body(name, FINE, whole=True)
        model = Surface.from_soup(PolygonMesh.from_faces(shown.points, shown.triangles))
        laid.append(register(model, drawn(shown), template))
    names = tuple(CARS)
    return ShapeModel.from_registrations(laid, names=names, template=template.name), template


def sheet(shapes: ShapeModel, template: Template) -> Drawn:
    """A row for each mode: the mean in the middle, what the mode does to it on both sides."""
    width, height = LEFT + len(SIGMAS) * CELL[0], ABOVE + MODES * CELL[1]
    scene = Scene(width, height)
    layers: list[Layer] = []
    view = common_view(shapes)
    for row in range(MODES):
        y = height - ABOVE - (row + 0.5) * CELL[1]
        share = f"{100.0 * shapes.shares[row]:.2g} %"
        scene.text(30.0, y + 10.0, f"mode {row + 1}", 28.0, bold=True, align="left")
        for line, text in enumerate((share, "of the", "variance")):
            scene.text(
                30.0, y - 21.0 - 25.0 * line, text, 19.0, colour=style.FAINT_TEXT, align="left"
            )
        for column, sigmas in enumerate(SIGMAS):
            coefficients = np.zeros(shapes.n_modes)
            coefficients[row] = sigmas * shapes.deviations[row]
            state = ShapesState(shapes, template, coefficients)
            state.camera.aim(view)
            if sigmas:
                KEYS.press(state, "g")
            cell = compose_shape(state, *CELL)
            shift = np.array([LEFT + column * CELL[0], y - CELL[1] / 2.0])
            offset = shift @ view.axes[:2] / view.scale
            layers += [_move(layer, f"{row} {column}", offset) for layer in cell.layers]
    for column, sigmas in enumerate(SIGMAS):
        text = f"{sigmas:+.0f} σ".replace("-", "\u2212") if sigmas else "mean"
        x = LEFT + (column + 0.5) * CELL[0]
        scene.text(x, height - 50.0, text, 28.0, bold=True)
    scene.box(0.0, 0.0, 0.0, 0.0, style.PAPER, style.PAPER)
    return Drawn(scene, layers, view, (CELL[0] / 2.0, CELL[1] / 2.0))


def _move(layer: Layer, cell: str, offset: Points) -> Layer:
    """Move a layer of a cell to its place, under a name of its own."""
    name = f"{layer.name} {cell}"
    if isinstance(layer, Marks):
        return replace(layer, name=name, places=layer.places + offset)
    return replace(layer, name=name, points=layer.points + offset)


def common_view(shapes: ShapeModel) -> View:
    """In which all shapes of the sheet fit into their cells, and are as large as they are."""
    every = [shapes.mean]
    for mode in range(MODES):
        every += [shapes.mean + s * shapes.deviations[mode] * shapes.modes[mode] for s in SIGMAS]
    view = fit_view(np.concatenate(every), TOWARD, UP, *CELL)
    return view.zoomed(1.07)


def pulled(shapes: ShapeModel, template: Template) -> ShapesState:
    """The hatchback with its sill held, while the roof is pulled up; the ghost is as it was."""
    state = ShapesState(shapes, template, shapes.coefficients[shapes.names.index("hatchback")])
    compose_shape(state, float(VIEWER[0]), float(VIEWER[1]))
    for key in ("g", "g", "z"):
        KEYS.press(state, key)
    click(state, *middle(state, "sill"))
    x, y = middle(state, "roof_rail")
    state.move(x, y)
    state.press(x, y)
    for step in np.linspace(0.2, 1.0, 5):
        state.move(x, y + 50.0 * step)
    return state


def click(state: ShapesState, x: float, y: float) -> None:
    """Press and release there."""
    state.press(x, y)
    state.release(x, y)


def middle(state: ShapesState, name: str) -> tuple[float, float]:
    """Where the middle of a curve is seen."""
    numbers = [i for i, line in enumerate(state.skin.lines) if line.name == name]
    line = state.sight.lines[numbers[0]]
    x, y = line[len(line) // 2, :2].tolist()
    return x, y


def save(drawn: Drawn, path: Path, height: int) -> None:
    """Write a picture, its colours in coarser steps: nobody sees that, and it is smaller."""
    save_drawn(path, drawn, height)
    with Image.open(path) as image:
        pixels = np.asarray(image.convert("RGB"), np.int64)
    # White stays white.
    coarse = 255 - (255 - pixels + STEP // 2) // STEP * STEP
    Image.fromarray(np.clip(coarse, 0, 255).astype(np.uint8)).save(path, optimize=True)
    size = path.stat().st_size
    print(f"{path}: {size:,} bytes")
    if size > LARGEST_PICTURE:
        sys.exit(f"{path} has over {LARGEST_PICTURE:,} bytes; draw less in it")


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--out", type=Path, default=ROOT / "docs" / "images")
    out: Path = parser.parse_args().out
    shapes, template = shape_model()
    drawn = sheet(shapes, template)
    save(drawn, out / "features-shapes.png", round(PIXELS * drawn.scene.height))
    state = pulled(shapes, template)
    save(
        compose_shape(state, float(VIEWER[0]), float(VIEWER[1])),
        out / "shapes-viewer.png",
        VIEWER[1],
    )


if __name__ == "__main__":
    main()
