"""The verb that recovers feature curves from strokes: features."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from math import radians
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Any

import click
from click.core import ParameterSource

from patterndb.errors import NotFoundError
from patterndb.system.knownfiles import KnownFiles
from patterndb_app.cli.failure import EXIT_NOTHING
from patterndb_app.cli.options import (
    Count,
    FileName,
    FileToWrite,
    MeshName,
    Parsed,
    as_json,
    may_overwrite,
    output_option,
    parse_vector,
    picture_option,
    read_model,
    view_option,
)
from patterndb_app.cli.program import SectionedCommand
from patterndb_app.cli.progressline import hushed
from patterndb_app.cli.text import plural, say, shorten, table, write, write_json
from patterndb_sketch.features.defaults import (
    ALPHA,
    AXIS,
    BETA,
    DEGREE,
    RADIUS,
    SNAP_ROUNDS,
    STIFFNESS,
)

if TYPE_CHECKING:
    from patterndb.geometry.surface import Surface
    from patterndb_sketch.features.session import FeatureSession
    from patterndb_sketch.features.snap import SnapSettings
    from patterndb_sketch.features.splines import Constraint
    from patterndb_sketch.features.strokes import FeatureStroke, RecoveredCurve


#: Directions by the names of axes.
AXES = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}


def _parse_direction(text: str) -> tuple[float, float, float]:
    found = AXES.get(text) or parse_vector(text)
    if found is None or not any(found):
        raise ValueError(f"{text!r} is no direction like z or 1,0,0.5")
    return found


#: A direction: x, y, z or three numbers, 1,0,0.5.
DIRECTION = Parsed("direction", _parse_direction, has_commas=True)


@click.command(
    cls=SectionedCommand,
    sections={
        "Strokes": ("--strokes", "--session"),
        "How curves are found": (
            "--alpha",
            "--beta",
            "--axis",
            "--stiffness",
            "--degree",
            "--reach",
            "--rounds",
            "--strict",
        ),
        "Output": ("-o", "--picture", "--overwrite", "--view", "--json"),
    },
)
@click.argument("model", type=MeshName())
@click.option("--strokes", type=FileName(), metavar="FILE", help="The strokes, JSON.")
@output_option(FileToWrite(".json"), "The curves, JSON.")
@click.option(
    "--alpha",
    type=click.FloatRange(0, 1),
    default=ALPHA,
    show_default=True,
    help="1: curves go where the surface bends; 0: where its normals have the angle --beta.",
)
@click.option(
    "--beta",
    type=click.FloatRange(0, 180),
    default=BETA,
    show_default=True,
    help="The angle of normals to the axis, in degrees, where alpha is below 1.",
)
@click.option(
    "--axis",
    type=DIRECTION,
    default=AXIS,
    show_default=True,
    help="The direction that normals are measured from: x, y, z or three numbers.",
)
@click.option(
    "--stiffness",
    type=click.FloatRange(1, 1e6),
    default=STIFFNESS,
    show_default=True,
    help="More makes curves go straighter on.",
)
@click.option(
    "--degree", type=Count(1, 9), default=DEGREE, show_default=True, help="Of the splines."
)
@click.option(
    "--reach",
    type=click.FloatRange(0.000001, 1),
    default=RADIUS,
    show_default=True,
    help="How far from the stroke to look, as a share of the model's diagonal.",
)
@click.option(
    "--rounds",
    type=Count(1, 100),
    default=SNAP_ROUNDS,
    show_default=True,
    help="How often the ribs are built about the curve.",
)
@click.option("--strict", is_flag=True, help="Price steps across ribs as the paper does.")
@click.option(
    "--session",
    type=FileToWrite(reads=True),
    metavar="FILE",
    help="A session to go on with, if it is there, and to keep the curves in.",
)
@view_option("Draw in a window; F1 lists commands and keys.")
@picture_option("Draw the model and the curves into a PNG, without a window.")
@may_overwrite
@as_json
def features(
    model: Path,
    strokes: Path | None,
    output: Path | None,
    session: Path | None,
    view: bool,
    picture: Path | None,
    as_json: bool,
    **chosen: Any,
) -> int:
    """Recover the feature curves along which strokes were roughly drawn.

    MODEL is a mesh file of any quality (OBJ, PLY, VTK, VTP, USD, OFF): open, torn,
    self-intersecting, turned inside out. STROKES is a JSON file; only points must be given:

    \b
    {"strokes": [{"name": "roof", "points": [[1.3,-0.6,1.1], [2.4,-0.6,1.0], ...],
                  "closed": true,                               goes on to its first point
                  "constraints": [{"at": [1.8,-0.6,1.1]}],      the curve passes here
                  "settings": {"alpha": 0, "beta": 60}}, ...]}  in place of the options

    A stroke whose last point is its first again is closed, too.

    Across every stroke ribs are laid, the model's outline in planes; a minimum cut through them
    is the curve, a smooth B-spline. The curves written are a network for the verb register. A
    table tells for every curve its length, samples, ribs that were mended or lost, and how far
    the stroke was from it.

    Without --strokes the curves of the session are found again; with --view alone they are shown
    as they are, and new ones drawn.

    Exit code 1 where a stroke has no curve, 3 for a file that is not what it must be.

    \b
    patterndb features sedan.obj --strokes sedan.strokes.json -o sedan.curves.json
    patterndb features sedan.obj --strokes rough.json --alpha 0.5 --beta 60 --stiffness 4 --json
    patterndb features sedan.obj --session sedan.session --view
    """
    looking = strokes is None and view and output is None
    if strokes is None and session is None:
        if not view:
            raise click.UsageError("there is nothing to do; give --strokes, --session or --view")
        if not looking:
            raise click.UsageError("without --strokes or --session there are no curves to write")
    if looking and as_json:
        raise click.UsageError("--view alone finds no curves for --json to describe; leave one out")
    # Imported here because --help need not wait for it.
    from patterndb_sketch.features.session import FEATURE_SESSION, FeatureSession

    known = KnownFiles()
    if session is not None:
        known.note(session)
    there = session is not None and (session.exists() or (strokes is None and not view))
    kept = (
        FEATURE_SESSION.read(session)
        if session is not None and there
        else FeatureSession(model.name)
    )
    given = _collect_settings(chosen)
    settings = replace(kept.settings, **given)
    surface = read_model(model)
    _say_model(model, surface, kept)
    found: list[RecoveredCurve] = []
    if not looking:
        found, lost, seconds = _recover_curves(
            surface, _read_strokes(strokes, kept, settings, given)
        )
        if not found:
            raise NotFoundError(f"{strokes or session}: there is no curve; see above")
        if output is not None:
            from patterndb_sketch.features.files.networkjson import write_curves

            write_curves(output, found, model.name)
        if as_json:
            write_json(_document(model, surface, found, lost, seconds, output, session))
        else:
            write(table(HEADS, [_row(one) for one in found]))
        _say_found(found, seconds)
        if output is not None:
            say(f"written: {output}")
    else:
        lost = {}
    kept = kept.with_curves(found, settings) if found else kept
    if session is not None and found:
        changed = kept
        known.save(session, lambda: FEATURE_SESSION.write(session, changed))
        say(f"written: {session}")
    if picture is not None or view:
        from viewer.features import draw, show

        if picture is not None:
            draw(surface, picture, session=kept)
            say(f"drawn: {picture}")
        if view:
            with hushed():
                show(
                    surface,
                    title=model.name,
                    session=kept,
                    session_path=session,
                    settings=settings,
                    open_file=read_model,
                    known=known,
                )
    return EXIT_NOTHING if lost else 0


#: Columns that a table leaves for the names of curves.
NAME_WIDTH = 32

HEADS = ("curve", "length", "samples", "mended", "failed", "moved", "at most")

#: Settings by the names of their options, where they differ.
SETTINGS = {"reach": "radius"}


def _collect_settings(chosen: Mapping[str, Any]) -> dict[str, Any]:
    """The settings that options were given for."""
    context = click.get_current_context()
    return {
        SETTINGS.get(name, name): radians(value) if name == "beta" else value
        for name, value in chosen.items()
        if context.get_parameter_source(name) != ParameterSource.DEFAULT
    }


def _read_strokes(
    strokes: Path | None, session: FeatureSession, usual: SnapSettings, given: Mapping[str, Any]
) -> list[tuple[FeatureStroke, tuple[Constraint, ...]]]:
    """The strokes of the file, else those of the session with what was dragged there."""

    from patterndb_sketch.features.files.strokesjson import read_strokes

    if strokes is not None:
        return [(stroke, ()) for stroke in read_strokes(strokes, usual)]
    return [
        (replace(one.stroke, settings=replace(one.settings, **given)), one.constraints)
        for one in session.curves
    ]


def _recover_curves(
    model: Surface, asked: Sequence[tuple[FeatureStroke, tuple[Constraint, ...]]]
) -> tuple[list[RecoveredCurve], dict[str, str], float]:
    """The curves, why strokes have none, by name, and how many seconds it took."""
    from patterndb_sketch.features.errors import InvalidFeatureError
    from patterndb_sketch.features.strokes import recover_curve

    found: list[RecoveredCurve] = []
    lost: dict[str, str] = {}
    started = perf_counter()
    for stroke, constraints in asked:
        try:
            found.append(recover_curve(model, stroke, constraints))
        except InvalidFeatureError as error:
            lost[stroke.name] = str(error)
            say(str(error))
    return found, lost, perf_counter() - started


def _document(
    model: Path, surface: Surface, found: Sequence[RecoveredCurve], lost: dict[str, str],
    seconds: float, output: Path | None, session: Path | None,
) -> dict[str, object]:  # fmt: skip
    from msgspec import to_builtins

    from patterndb_sketch.features.files.networkjson import model_of_curve

    return {
        "model": str(model),
        "triangles": len(surface.triangles),
        "components": surface.n_components,
        "diagonal": surface.diagonal,
        "curves": {one.name: to_builtins(model_of_curve(one)) for one in found},
        "lost": lost,
        "seconds": round(seconds, 6),
        "output": None if output is None else str(output),
        "session": None if session is None else str(session),
    }


def _row(one: RecoveredCurve) -> tuple[object, ...]:
    curve, figures = one.curve, one.figures
    return (
        shorten(one.name, NAME_WIDTH),
        f"{figures.length:.4g}",
        len(curve.samples),
        len(curve.repaired),
        len(curve.failed),
        f"{figures.moved.mean:.3g}",
        f"{figures.moved.most:.3g}",
    )


def _say_model(path: Path, model: Surface, session: FeatureSession) -> None:
    parts = f"{plural(len(model.triangles), 'triangle')}, {plural(model.n_components, 'component')}"
    left_out = [
        f"{count:,} {what}"
        for count, what in (
            (model.repairs.dropped, "without area"),
            (model.repairs.repeated, "there twice"),
        )
        if count
    ]
    say(f"{path.name}: {parts}" + (f"; left out: {', '.join(left_out)}" if left_out else ""))
    if session.mesh and session.mesh != path.name:
        say(f"the session was drawn on {session.mesh}; its curves may not fit {path.name}")


def _say_found(found: Sequence[RecoveredCurve], seconds: float) -> None:
    for one in found:
        for note in one.curve.notes:
            say(f"{one.name}: {note}")
        if one.curve.ended:
            say(
                f"{one.name}: {len(one.curve.ended)} of {len(one.curve.samples)} ribs were cut at "
                "their ends; the feature may be farther from the stroke: see --reach"
            )
    say(f"{plural(len(found), 'curve')} recovered in {seconds:.2f} s")
