"""The verb that builds a statistical shape model: shape-model build."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
import numpy as np

from patterndb_app.cli.options import FileToWrite, as_json, read_model
from patterndb_app.cli.registering import (
    delta_option,
    read_any_template,
    read_drawn,
    rounds_option,
    template_option,
    tolerance_option,
)
from patterndb_app.cli.text import plural, say, table, write, write_json
from patterndb_app.cli.values import Source

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from patterndb_sketch.features.registration import DrawnNetwork, Template
    from patterndb_sketch.features.shapemodel import ErrorTable, ShapeModel

    Floats = NDArray[np.float64]


@click.command()
@click.argument("sources", nargs=-1, required=True, type=Source(), metavar="SOURCE...")
@template_option
@click.option(
    "-o",
    "--output",
    type=FileToWrite(".npz"),
    required=True,
    metavar="FILE",
    help="The shape model, NPZ.",
)
@click.option("--modes", type=click.IntRange(1), metavar="L", help="Keep only the first L modes.")
@delta_option
@rounds_option
@tolerance_option
@as_json
def build(
    sources: tuple[tuple[Path, Path | None], ...],
    template: str,
    output: Path,
    modes: int | None,
    delta: float,
    rounds: int,
    tolerance: float | None,
    as_json: bool,
) -> int:
    """Build a shape model from two shapes or more.

    A SOURCE is a model and its network of feature curves, sedan.obj=sedan.curves.json, onto which
    the template is laid as the verb register does; or a mesh that register wrote with the same
    template, sedan.quads.obj.

    A table tells for every number of modes the share of the variance that they have, and how far
    vertices are off: of the shapes that were learned, and, from three shapes on, of shapes left
    out, each made of what all the others teach. Distances are the root of the mean square, and
    the greatest.

    \b
    patterndb shape-model build --template box:car -o cars.npz a.obj=a.json b.obj=b.json
    patterndb shape-model build --template box:car -o cars.npz --modes 4 a.quads.obj b.quads.obj
    """
    # Imported here because compiled kernels take a moment that --help need not wait for.
    from patterndb_sketch.features.errors import InvalidFeatureError
    from patterndb_sketch.features.sessionfile import write_shapes
    from patterndb_sketch.features.shapemodel import ShapeModel, error_table

    laid_out = read_any_template(template)
    names = _names([path for path, _ in sources])
    shapes: list[Floats] = []
    notes: dict[str, list[str]] = {}
    for (path, network), name in zip(sources, names, strict=True):
        drawn = None if network is None else read_drawn(network, tolerance)
        points, notes[name] = _shape_of(path, drawn, laid_out, delta, rounds)
        shapes.append(points)
        for note in notes[name]:
            say(f"{name}: {note}")
    quads, features = _whole(laid_out)
    whole = ShapeModel.build(
        shapes, quads, features, names=names,
        template=laid_out.name if template.startswith("box:") else template,
    )  # fmt: skip
    errors: ErrorTable | None = None
    if len(shapes) > 2:
        errors = error_table(whole)
    else:
        say("two shapes: there is one mode, and none to leave out; the table needs three")
    if modes is not None and modes > whole.n_modes:
        raise InvalidFeatureError(
            f"--modes is {modes}; {plural(len(shapes), 'shape')} have {whole.n_modes} modes"
        )
    made = whole if modes is None else whole.kept(modes)
    write_shapes(output, made)
    rows = _error_rows(whole, errors)
    if as_json:
        write_json(
            {
                "template": made.template,
                "shapes": list(made.names),
                "vertices": len(made.mean),
                "quads": len(made.quads),
                "modes": made.n_modes,
                "deviations": made.deviations.tolist(),
                "features": {one.name: len(one.vertices) for one in made.features},
                "errors": [dict(zip(ERROR_KEYS, row, strict=True)) for row in rows],
                "notes": notes,
                "output": str(output),
            }
        )
    else:
        # Rounding is nothing: with all modes the learned shapes are given back.
        least = ROUNDING * float(np.abs(whole.mean).max())
        shown = [(row[0], *(_short(value, least) for value in row[1:])) for row in rows]
        write(table(ERROR_HEADS, shown))
    say(f"{plural(len(shapes), 'shape')}, {plural(made.n_modes, 'mode')} kept")
    say(f"written: {output}")
    return 0


#: Distances below this share of the greatest coordinate are rounding.
ROUNDING = 1e-12

ERROR_KEYS = ("modes", "variance", "learned", "learned_most", "left_out", "left_out_most")
ERROR_HEADS = ("modes", "variance", "learned", "at most", "left out", "at most")


def _names(paths: Sequence[Path]) -> list[str]:
    """Names of shapes: of their files, up to the first dot where that tells them apart."""
    short = [path.name.lstrip(".").partition(".")[0] for path in paths]
    names = short if len(set(short)) == len(short) else [path.stem for path in paths]
    for name in names:
        if names.count(name) > 1:
            raise click.UsageError(f"two shapes would be named {name}; rename one of the files")
    return names


def _shape_of(
    path: Path, drawn: DrawnNetwork | None, template: Template, delta: float, rounds: int
) -> tuple[Floats, list[str]]:
    """The places of the template's vertices on a model, or in a mesh; and notes."""
    from ingest.formats import read_mesh
    from patterndb_sketch.features.errors import InvalidFeatureError
    from patterndb_sketch.features.registration import register

    if drawn is not None:
        ground = read_model(path)
        try:
            made = register(ground, drawn, template, delta=delta, rounds=rounds)
        except InvalidFeatureError as error:
            raise InvalidFeatureError(f"{path} and its network: {error}") from None
        return made.points, list(made.notes)
    mesh = read_mesh(path)
    quads, _ = _whole(template)
    same = set(mesh.arities().tolist()) == {4} and np.array_equal(mesh.corners, quads.ravel())
    if not same or len(mesh.points) != quads.max() + 1:
        raise InvalidFeatureError(
            f"{path} has not the quads of {template.name}; give the mesh that register wrote with "
            "this template, or MODEL=NETWORK to lay the template onto a model"
        )
    return mesh.points, []


def _whole(template: Template) -> tuple[NDArray[np.int32], tuple[Any, ...]]:
    """The quads of a template, mirrored if it is half of something, and its features."""
    from patterndb_sketch.features.registration import Feature
    from patterndb_sketch.features.registration.register import prepared

    features = tuple(Feature(chain.name, chain.vertices) for chain in template.chains)
    return prepared(template)[1].quads, features


def _error_rows(
    model: ShapeModel, errors: ErrorTable | None
) -> list[tuple[int | float | None, ...]]:
    """By number of modes from 0; None for what is not known."""
    if errors is None:
        shares = np.r_[0.0, np.cumsum(model.shares)].tolist()
        return [(count, share, *[None] * 4) for count, share in enumerate(shares)]
    columns = (
        errors.share, errors.known, errors.known_most, errors.unseen, errors.unseen_most
    )  # fmt: skip
    rows = [[None if x != x else x for x in row] for row in np.stack(columns, axis=1).tolist()]
    return [(count, *row) for count, row in enumerate(rows)]


def _short(value: float | None, least: float) -> str:
    if value is None:
        return ""
    return f"{value:.4g}" if value > least else "0"
