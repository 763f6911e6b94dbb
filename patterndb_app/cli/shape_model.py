"""The verbs on statistical shape models: shape-model, with build, sample and edit."""

from __future__ import annotations

import math
import re
from collections.abc import Collection, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
import numpy as np

from patterndb.system.numbers import MOST_COUNT
from patterndb_app.cli.obj import write_faces
from patterndb_app.cli.options import (
    OBJ,
    Count,
    FileName,
    FileToWrite,
    MeshName,
    ParamType,
    Parsed,
    as_json,
    may_overwrite,
    output_option,
    parse_vector,
    picture_option,
    read_model,
    view_option,
)
from patterndb_app.cli.program import SectionedCommand, VerbGroup
from patterndb_app.cli.progressline import hushed
from patterndb_app.cli.register import (
    delta_option,
    read_any_template,
    read_drawn,
    rounds_option,
    template_option,
    tolerance_option,
    turn_model,
    turn_option,
)
from patterndb_app.cli.text import plural, say, table, write, write_json

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from patterndb_sketch.features.registration import FeatureCurves, Template
    from patterndb_sketch.features.shapemodel import ErrorTable, ShapeModel

    Floats = NDArray[np.float64]


class Source(ParamType):
    """A shape to learn: MODEL=NETWORK, or a mesh that has the template's quads."""

    name = "source"

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> tuple[Path, Path | None]:
        if isinstance(value, tuple):
            return value  # pyright: ignore[reportUnknownVariableType]
        # A file whose name has a = is that file.
        model, equals, network = (str(value), "", "")
        if not Path(str(value)).exists():
            model, equals, network = str(value).rpartition("=")
            if not equals:
                model, network = network, ""
        mesh = MeshName().convert(model, param, ctx)
        return mesh, FileName().convert(network, param, ctx) if equals else None


def _parse_mode(text: str) -> tuple[int, float]:
    match = re.fullmatch(r"([0-9]{1,9})=(.+)", text)
    number, sigmas = (int(match[1]), _parse_float(match[2])) if match else (0, math.nan)
    if number < 1 or not math.isfinite(sigmas):
        raise ValueError(f"{text!r} is not a mode and its deviations like 1=2.0")
    return number, sigmas


def _parse_drag(text: str) -> tuple[str, tuple[float, float, float]]:
    feature, _, numbers = text.rpartition("=")
    by = parse_vector(numbers)
    if not feature or by is None:
        raise ValueError(f"{text!r} is not like roof_rail=0,0,0.1")
    return feature, by


def _parse_hold(text: str) -> tuple[str, float]:
    feature, equals, number = text.partition("=")
    weight = _parse_float(number) if equals else 1.0
    if not feature or not (math.isfinite(weight) and weight >= 0.0):
        raise ValueError(f"{text!r} is not a feature and a weight like sill=0.5")
    return feature, weight


def _parse_float(text: str) -> float:
    """Parse a number; nan for what is none."""
    try:
        return float(text)
    except ValueError:
        return math.nan


#: A mode and its standard deviations: 1=2.0.
MODE = Parsed("k=sigmas", _parse_mode)

#: A feature and how it is displaced: roof_rail=0,0,0.1.
DRAG = Parsed("feature=dx,dy,dz", _parse_drag)

#: A feature and the weight that holds it: sill=0.5; 1 if only the feature is given.
HOLD = Parsed("feature[=weight]", _parse_hold)


@click.group(name="shape-model", cls=VerbGroup)
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


@click.command()
@click.argument("sources", nargs=-1, required=True, type=Source(), metavar="SOURCE...")
@template_option
@output_option(FileToWrite(".npz"), "The shape model, NPZ.", required=True)
@click.option("--modes", type=Count(1), metavar="L", help="Keep only the first L modes.")
@delta_option
@rounds_option
@tolerance_option
@turn_option
@may_overwrite
@as_json
def build(
    sources: tuple[tuple[Path, Path | None], ...],
    template: str,
    output: Path,
    modes: int | None,
    delta: float,
    rounds: int,
    tolerance: float | None,
    turn: str | None,
    as_json: bool,
) -> int:
    """Build a shape model from two shapes or more.

    A SOURCE is a model and its network of feature curves, sedan.obj=sedan.curves.json, onto which
    the template is laid as the verb register does; or a mesh that register wrote with the same
    template, sedan.quads.obj. --turn is for models alone; with find each is turned as its curves
    lie.

    A table tells for every number of modes the share of the variance that they have, and how far
    vertices are off: of the shapes that were learned, and, from three shapes on, of shapes left
    out, each made of what all the others teach. Distances are the root of the mean square, and
    the greatest.

    \b
    patterndb shape-model build --template box:car -o cars.npz a.obj=a.json b.obj=b.json
    patterndb shape-model build --template box:car -o cars.npz --modes 4 a.quads.obj b.quads.obj
    """
    # Imported here because --help need not wait for it.
    from patterndb_sketch.features.errors import InvalidFeatureError
    from patterndb_sketch.features.files.shapearrays import write_shapes
    from patterndb_sketch.features.shapemodel import ShapeModel, measure_errors

    laid_out = read_any_template(template)
    names = _names([path for path, _ in sources])
    shapes: list[Floats] = []
    notes: dict[str, list[str]] = {}
    for (path, network), name in zip(sources, names, strict=True):
        drawn = None if network is None else read_drawn(network, tolerance)
        points, notes[name] = _shape_of(path, drawn, laid_out, delta, rounds, turn)
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
        errors = measure_errors(whole)
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
    path: Path,
    drawn: FeatureCurves | None,
    template: Template,
    delta: float,
    rounds: int,
    turn: str | None,
) -> tuple[Floats, list[str]]:
    """The places of the template's vertices on a model, or in a mesh; and notes."""
    from ingest.formats import read_mesh
    from patterndb_sketch.features.errors import InvalidFeatureError
    from patterndb_sketch.features.registration import register

    if drawn is not None:
        surface = read_model(path)
        turned: list[str] = []
        if turn is not None:
            axes, surface = turn_model(surface, drawn, turn)
            turned = [f"the model is turned: its {axes.replace(',', ', ')} are x, y, z"]
        try:
            made = register(surface, drawn, template, delta=delta, rounds=rounds)
        except InvalidFeatureError as error:
            raise InvalidFeatureError(f"{path} and its network: {error}") from None
        return made.points, [*turned, *made.notes]
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
    from patterndb_sketch.features.registration.register import prepare_template

    features = tuple(Feature(chain.name, chain.vertices) for chain in template.chains)
    return prepare_template(template)[1].quads, features


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


shape_model.add_command(build)


#: The section of options that both write with.
_OUTPUT = ("-o", "--picture", "--template", "--overwrite", "--view", "--json")


def _add_edit_options(command: Any) -> Any:
    """The options that sample and edit share."""
    for option in reversed(
        (
            click.argument("shapes", type=FileName()),
            output_option(OBJ, "The new shape, OBJ."),
            click.option(
                "--like",
                metavar="NAME",
                help="Begin with the learned shape of this name, not with the mean.",
            ),
            click.option(
                "--modes", type=Count(1), metavar="L", help="Use the first L modes alone."
            ),
            picture_option("Draw the shape into a PNG."),
            view_option("Explore the shapes in a window; F1 lists commands and keys."),
            click.option(
                "--template",
                metavar="TEMPLATE",
                help="The template for --picture and --view, where its file has moved.",
            ),
            may_overwrite,
            as_json,
        )
    ):
        command = option(command)
    return command


@shape_model.command(
    cls=SectionedCommand,
    sections={
        "Shape": ("--like", "--modes", "--mode", "--random", "--seed"),
        "Output": _OUTPUT,
    },
)
@_add_edit_options
@click.option(
    "--mode",
    "chosen",
    type=MODE,
    multiple=True,
    help="Move along mode K, from 1, by this many standard deviations. May be repeated.",
)
@click.option("--random", is_flag=True, help="A shape at random, as likely as the learned ones.")
@click.option("--seed", type=Count(), default=0, show_default=True, help="For --random.")
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
    return _report_shape(shapes, model, coefficients, {}, notes, **wanted)


@shape_model.command(
    cls=SectionedCommand,
    sections={"Shape": ("--like", "--modes", "--drag", "--vertex", "--hold"), "Output": _OUTPUT},
)
@_add_edit_options
@click.option(
    "--drag",
    "drags",
    type=DRAG,
    multiple=True,
    help="Displace a feature by so much. May be repeated; with --view none is needed.",
)
@click.option(
    "--vertex",
    type=Count(-MOST_COUNT),
    metavar="K",
    help="Pull vertex K of the dragged feature, from 0; -1 is its last. Its ends stay.",
)
@click.option(
    "--hold",
    "holds",
    type=HOLD,
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
    beyond the learned shapes. The remaining distance between a feature and its target is printed.

    \b
    patterndb shape-model edit cars.npz --drag roof_rail=0,0,0.1 -o tall.obj
    patterndb shape-model edit cars.npz --like sedan --drag shoulder=0,0,0.05 --vertex 5 -o new.obj
    patterndb shape-model edit cars.npz --drag belt_line=0,0,-0.1 --hold sill --hold roof_rail=0.5
    """
    if not drags and not wanted["view"]:
        raise click.UsageError("there is nothing to do; give a --drag, or --view to pull by hand")
    if vertex is not None and len(drags) != 1:
        raise click.UsageError("--vertex goes with one --drag")
    for option, given in (("--drag", drags), ("--hold", holds)):
        names = [name for name, _ in given]
        if len(set(names)) < len(names):
            raise click.UsageError(f"{option} names a feature twice")
    from patterndb_sketch.features.shapemodel import edit as edited
    from patterndb_sketch.features.shapemodel import pull_feature

    model = _read(shapes, modes)
    start = _begin(model, like)
    if not drags:
        for name, _ in holds:
            model.feature(name)
        return _report_shape(shapes, model, start, {}, [], held=dict(holds), **wanted)
    targets: dict[str, Any] = {}
    for name, by in drags:
        targets |= pull_feature(model, name, by, start=start, vertex=vertex)
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
    return _report_shape(
        shapes, model, found.coefficients, found.misses, notes, held=dict(holds), **wanted
    )


def _read(shapes: Path, modes: int | None) -> ShapeModel:
    from patterndb_sketch.features.files.shapearrays import read_shapes

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


def _report_shape(
    path: Path, model: ShapeModel, coefficients: Floats, misses: Mapping[str, float],
    notes: Sequence[str], *, output: Path | None, picture: Path | None, view: bool,
    template: str | None, as_json: bool, held: Collection[str] = (),
) -> int:  # fmt: skip
    """Tell of a shape, write it and show it; held: the curves that a window holds at first."""
    points = model.shape(coefficients)
    if output is not None:
        write_faces(output, points, model.quads.tolist(), f"a shape of {path.name}")
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
            with hushed():
                show(
                    model, laid_out, title=path.name, output=output, coefficients=coefficients,
                    held=held,
                )  # fmt: skip
    return 0
