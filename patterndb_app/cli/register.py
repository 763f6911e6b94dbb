"""The verb that lays a template of quads onto a model: register."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING

import click
import numpy as np

from patterndb_app.cli.obj import write_faces
from patterndb_app.cli.options import (
    OBJ,
    Count,
    FileName,
    MeshName,
    as_json,
    may_overwrite,
    output_option,
    picture_option,
    read_model,
)
from patterndb_app.cli.text import plural, printable, say, shorten, table, write, write_json
from patterndb_sketch.features.defaults import DELTA, MAPPING_ROUNDS

if TYPE_CHECKING:
    from patterndb.geometry.surface import Surface
    from patterndb_sketch.features.registration import FeatureCurves, Registration, Template

template_option = click.option(
    "--template",
    required=True,
    metavar="TEMPLATE",
    help="The template: box:car?r=11&along=21, or a JSON file.",
)

delta_option = click.option(
    "--delta",
    type=click.FloatRange(0, min_open=True),
    default=DELTA,
    show_default=True,
    help="How far vertices may leave the membrane, in their shortest edges.",
)

rounds_option = click.option(
    "--rounds",
    type=Count(1, 20),
    default=MAPPING_ROUNDS,
    show_default=True,
    help="Rounds of mapping, each from the surface of the one before.",
)

turn_option = click.option(
    "--turn",
    metavar="AXES",
    help="Turn the model first: its axes that become x, y, z, as y,-x,z; find: as the curves lie.",
)

tolerance_option = click.option(
    "--tolerance",
    type=click.FloatRange(0, min_open=True),
    help="How far curves may pass each other and still meet, in the model's unit.",
)


@click.command()
@click.argument("model", type=MeshName())
@click.option(
    "--network",
    type=FileName(),
    required=True,
    metavar="FILE",
    help="The model's feature curves, JSON: what the verb features writes, or polylines.",
)
@template_option
@output_option(OBJ, "The quads, OBJ.", required=True)
@delta_option
@rounds_option
@tolerance_option
@turn_option
@picture_option("Draw the quads and their features into a PNG.")
@may_overwrite
@as_json
def register(
    model: Path,
    network: Path,
    template: str,
    output: Path,
    delta: float,
    rounds: int,
    tolerance: float | None,
    turn: str | None,
    picture: Path | None,
    as_json: bool,
) -> int:
    """Lay a template of quads onto a model along its feature curves.

    NETWORK has the curves by the names that the template asks for. A template is the same quads
    for every model: box:car?r=11 is a car's roof, body and wheelhouses with 11 vertices along
    every edge, along=21 has more lengthwise, and box:roof or box:roof+body are parts of it. It is
    the driver's half, mirrored in the plane y = 0: x to the tail, z up. A JSON file has any other.

    Feature vertices are on the curves at equal distances; a membrane spans the rest, which is
    then drawn to the outermost surface of the model. A table tells for every part how many
    vertices are on curves, drawn to the model, hidden by other parts, or have no hit nearby.

    Exit code 3 for curves that are missing, do not meet or do not lie on the model: if it has to be
    turned by right angles, the message says how, and --turn does it.

    \b
    patterndb register sedan.obj --network sedan.curves.json --template box:car -o sedan.quads.obj
    patterndb register sedan.obj --network n.json --template dome.json -o dome.obj --delta 3 --json
    """
    # Imported here because --help need not wait for it.
    from patterndb_sketch.features.registration import register as lay

    laid_out = read_any_template(template)
    drawn = read_drawn(network, tolerance)
    surface = read_model(model)
    turned = None
    if turn is not None:
        turned, surface = turn_model(surface, drawn, turn)
        say(f"the model is turned: its {turned.replace(',', ', ')} are x, y, z")
    started = perf_counter()
    made = lay(surface, drawn, laid_out, delta=delta, rounds=rounds)
    seconds = perf_counter() - started
    write_registration(output, made, laid_out)
    rows = part_rows(made, laid_out)
    gaps = {name: gap for name, gap in made.network.gaps.items() if gap > 0.0}
    if as_json:
        write_json(
            {
                "model": str(model),
                "network": str(network),
                "template": laid_out.name,
                "turn": turned,
                "vertices": len(made.points),
                "quads": len(made.quads),
                "parts": [dict(zip(HEADS, row, strict=True)) for row in rows],
                "gaps": gaps,
                "notes": list(made.notes),
                "seconds": round(seconds, 6),
                "output": str(output),
            }
        )
    else:
        write(table(HEADS, [(shorten(str(name), 40), *rest) for name, *rest in rows]))
    for note in made.notes:
        say(note)
    if gaps:
        widest = max(gaps, key=lambda name: gaps[name])
        say(f"curves pass each other by up to {gaps[widest]:.3g}, at {widest}; they meet midway")
    say(f"{plural(len(made.quads), 'quad')} of {laid_out.name} laid in {seconds:.2f} s")
    say(f"written: {output}")
    if picture is not None:
        _draw(made, laid_out, picture)
        say(f"drawn: {picture}")
    return 0


HEADS = ("part", "quads", "vertices", "on curves", "drawn to it", "hidden", "no hit")


def read_any_template(name: str) -> Template:
    """The template of a name such as box:car?r=11, else that in a JSON file."""
    from ingest.formats import read_mesh
    from patterndb_sketch.features.files.templatejson import read_template

    return read_template(name, read_mesh)


def read_drawn(network: Path, tolerance: float | None) -> FeatureCurves:
    """The network in a file, with the tolerance if one is given, else with the file's own."""
    from patterndb_sketch.features.files.networkjson import read_network

    drawn = read_network(network)
    return drawn if tolerance is None else replace(drawn, tolerance=tolerance)


def turn_model(model: Surface, drawn: FeatureCurves, turn: str) -> tuple[str, Surface]:
    """The turn that was asked for, or found by the curves of a network, and the model in it."""
    from patterndb_sketch.features.registration.frame import Turn, find_turn

    chosen = find_turn(model, drawn.curves.values())[0] if turn == "find" else Turn.parse(turn)
    return str(chosen), chosen.turn_model(model)


def part_rows(made: Registration, template: Template) -> list[tuple[object, ...]]:
    """For every part of a template what has become of its vertices."""
    from patterndb_sketch.features.registration.register import prepare_template

    of_part = template.of_part[prepare_template(template)[1].source]
    rows: list[tuple[object, ...]] = []
    for number, part in enumerate(template.parts):
        here = of_part == number
        counts = [
            (of_part[made.quads[:, 0]] == number).sum(),
            here.sum(),
            (here & made.fixed).sum(),
            (here & made.projected).sum(),
            (here & made.occluded).sum(),
            (here & ~made.fixed & ~made.projected & ~made.occluded).sum(),
        ]
        rows.append((part.name, *map(int, counts)))
    return rows


def write_registration(path: Path, made: Registration, template: Template) -> None:
    """Write a template that was laid onto a model, a group per part."""
    from patterndb_sketch.features.registration.register import prepare_template

    of_part = template.of_part[prepare_template(template)[1].source]
    names = ["_".join(printable(part.name).split()) or "part" for part in template.parts]
    groups: list[str] = [names[i] for i in of_part[made.quads[:, 0]].tolist()]
    write_faces(
        path, made.points, made.quads.tolist(), f"{template.name}, laid onto a model", groups
    )


def _draw(made: Registration, template: Template, picture: Path) -> None:
    """Draw the quads, with their edges and the curves that they follow."""
    from patterndb_sketch.features.shapemodel import ShapeModel
    from viewer.shapes import draw

    # One shape as a model of shapes: it is the mean, and the mode is not looked at.
    n = len(made.points)
    mode = np.full((1, n, 3), 1.0 / np.sqrt(3 * n))
    alone = ShapeModel(
        made.points, mode, np.ones(1), np.array([[-1.0], [1.0]]), 1.0, made.quads, made.features,
        ("", ""), template.name,
    )  # fmt: skip
    draw(alone, template, picture, keys="e")
