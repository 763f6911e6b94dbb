"""The verbs on statistical shape models: shape-model, with build, sample and edit."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
import numpy as np

from patterndb_app.cli.obj import write_quads
from patterndb_app.cli.options import OBJ, FileName, as_json, picture_path
from patterndb_app.cli.registering import read_any_template
from patterndb_app.cli.shapebuilding import build
from patterndb_app.cli.text import plural, say, table, write, write_json
from patterndb_app.cli.values import Drag, Hold, Mode

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from patterndb_sketch.features.shapemodel import ShapeModel

    Floats = NDArray[np.float64]


@click.group(name="shape-model")
def shape_model() -> None:
    """Learn how shapes of one kind differ, and make new ones.

    The same template laid onto several models gives as many shapes with the same vertices: a
    mean and the modes in which they differ, by falling variance. New shapes are made of modes,
    at random, or by dragging feature curves.

    \b
    patterndb shape-model build --template box:car -o cars.npz a.obj=a.json b.obj=b.json
    patterndb shape-model sample cars.npz --mode 1=2.0 -o long.obj
    patterndb shape-model edit cars.npz --drag roof_rail=0,0,0.1 -o tall.obj
    """


shape_model.add_command(build)


def _changing(command: Any) -> Any:
    """The options that sample and edit share."""
    for option in reversed(
        (
            click.argument("shapes", type=FileName()),
            click.option("-o", "--output", type=OBJ, metavar="FILE", help="The new shape, OBJ."),
            click.option(
                "--like",
                metavar="NAME",
                help="Begin with the learned shape of this name, not with the mean.",
            ),
            click.option(
                "--modes", type=click.IntRange(1), metavar="L", help="Use the first L modes alone."
            ),
            click.option(
                "--picture",
                type=picture_path(".png"),
                metavar="FILE",
                help="Draw the shape into a PNG.",
            ),
            click.option(
                "--view",
                is_flag=True,
                help="Explore the shapes in a window; the key h lists the keys.",
            ),
            click.option(
                "--template",
                metavar="TEMPLATE",
                help="The template for --picture and --view, where its file has moved.",
            ),
            as_json,
        )
    ):
        command = option(command)
    return command


@shape_model.command()
@_changing
@click.option(
    "--mode",
    "chosen",
    type=Mode(),
    multiple=True,
    help="Move along mode K, from 1, by so many standard deviations. May be repeated.",
)
@click.option("--random", is_flag=True, help="A shape at random, as likely as the learned ones.")
@click.option("--seed", type=click.IntRange(0), default=0, show_default=True, help="For --random.")
def sample(
    shapes: Path, like: str | None, modes: int | None, chosen: tuple[tuple[int, float], ...],
    random: bool, seed: int, **wanted: Any,
) -> int:  # fmt: skip
    """Make a shape of a shape model: of modes, at random, or one that was learned.

    Without --mode, --random and --like it is the mean. A table tells each mode's coefficient in
    standard deviations, with the least and the greatest among the learned shapes.

    \b
    patterndb shape-model sample cars.npz --mode 1=2.0 --mode 3=-1 -o new.obj
    patterndb shape-model sample cars.npz --random --seed 7 -o new.obj --json
    patterndb shape-model sample cars.npz --view
    """
    if random and (chosen or like):
        raise click.UsageError("--random is a shape by itself; leave --mode and --like out")
    model = _read(shapes, modes)
    coefficients = model.sample(seed) if random else _begin(model, like)
    for number, sigmas in chosen:
        if number > model.n_modes:
            raise click.UsageError(f"--mode {number}: there are {plural(model.n_modes, 'mode')}")
        coefficients[number - 1] = sigmas * model.deviations[number - 1]
    low, high = model.box
    beyond = np.flatnonzero((coefficients < low) | (coefficients > high)) + 1
    notes = [f"mode {number} is beyond all learned shapes" for number in beyond.tolist()]
    return _told(shapes, model, coefficients, {}, notes, **wanted)


@shape_model.command()
@_changing
@click.option(
    "--drag",
    "drags",
    type=Drag(),
    multiple=True,
    required=True,
    help="Displace a feature by so much. May be repeated.",
)
@click.option(
    "--vertex",
    type=int,
    metavar="K",
    help="Pull vertex K of the dragged feature, from 0; -1 is its last. Its ends stay.",
)
@click.option(
    "--hold",
    "holds",
    type=Hold(),
    multiple=True,
    help="Hold a feature, as strongly as a drag (1) or by another weight. May be repeated.",
)
def edit(
    shapes: Path, like: str | None, modes: int | None,
    drags: tuple[tuple[str, tuple[float, float, float]], ...], vertex: int | None,
    holds: tuple[tuple[str, float], ...], **wanted: Any,
) -> int:  # fmt: skip
    """Drag feature curves of a shape, and let the rest follow as the learned shapes do.

    The new shape is the one whose features come nearest to where they were dragged, no mode
    beyond the learned shapes. What is left between a feature and its target is told.

    \b
    patterndb shape-model edit cars.npz --drag roof_rail=0,0,0.1 -o tall.obj
    patterndb shape-model edit cars.npz --like sedan --drag shoulder=0,0,0.05 --vertex 5 -o new.obj
    patterndb shape-model edit cars.npz --drag belt_line=0,0,-0.1 --hold sill --hold roof_rail=0.5
    """
    if vertex is not None and len(drags) > 1:
        raise click.UsageError("--vertex goes with one --drag")
    for option, given in (("--drag", drags), ("--hold", holds)):
        names = [name for name, _ in given]
        if len(set(names)) < len(names):
            raise click.UsageError(f"{option} names a feature twice")
    from patterndb_sketch.features.shapemodel import edit as edited
    from patterndb_sketch.features.shapemodel import moved

    model = _read(shapes, modes)
    start = _begin(model, like)
    targets: dict[str, Any] = {}
    for name, by in drags:
        targets |= moved(model, name, by, start=start, vertex=vertex)
    found = edited(model, targets, held=dict(holds), start=start)
    sides = {-1: "least", 1: "greatest"}
    notes = [
        f"mode {k + 1} is at its {sides[side]} among the learned shapes: the drag wants more"
        for k, side in enumerate(found.at_bound.tolist())
        if side
    ]
    notes += [
        f"{name} is off its target by {miss:.3g} at most" for name, miss in found.misses.items()
    ]
    return _told(shapes, model, found.coefficients, found.misses, notes, **wanted)


def _read(shapes: Path, modes: int | None) -> ShapeModel:
    from patterndb_sketch.features.sessionfile import read_shapes

    model = read_shapes(shapes)
    return model if modes is None else model.kept(modes)


def _begin(model: ShapeModel, like: str | None) -> Floats:
    """The coefficients of a learned shape, or of the mean."""
    if like is None:
        return np.zeros(model.n_modes)
    if like not in model.names:
        raise click.UsageError(f"--like {like}: the learned shapes are {', '.join(model.names)}")
    return model.coefficients[model.names.index(like)].copy()


HEADS = ("mode", "sigmas", "least", "greatest", "variance")


def _told(
    path: Path, model: ShapeModel, coefficients: Floats, misses: Mapping[str, float],
    notes: Sequence[str], *, output: Path | None, picture: Path | None, view: bool,
    template: str | None, as_json: bool,
) -> int:  # fmt: skip
    """Tell of a shape, write it and show it."""
    points = model.shape(coefficients)
    if output is not None:
        write_quads(output, points, model.quads, f"a shape of {path.name}")
    low, high = model.box
    columns = np.stack([coefficients, low, high], axis=1) / model.deviations[:, None]
    if as_json:
        document: dict[str, object] = {
            "shapes": str(path),
            "coefficients": coefficients.tolist(),
            "sigmas": columns[:, 0].tolist(),
            "least": columns[:, 1].tolist(),
            "greatest": columns[:, 2].tolist(),
            "vertices": len(points),
            "notes": list(notes),
            "output": None if output is None else str(output),
        }
        write_json(document | ({"misses": dict(misses)} if misses else {}))
    else:
        rows = zip(columns.tolist(), model.shares.tolist(), strict=True)
        cells = [
            (k, *(f"{value:.2f}" for value in row), f"{share:.1%}")
            for k, (row, share) in enumerate(rows, 1)
        ]
        write(table(HEADS, cells))
    for note in notes:
        say(note)
    if output is not None:
        say(f"written: {output}")
    if picture is not None or view:
        from viewer.shapes import draw, show

        laid_out = read_any_template(template or model.template)
        if picture is not None:
            draw(model, laid_out, picture, coefficients=coefficients)
            say(f"drawn: {picture}")
        if view:
            show(model, laid_out, title=path.name, output=output, coefficients=coefficients)
    return 0


COMMANDS = (shape_model,)
