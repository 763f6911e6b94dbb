"""Writes car-like bodies with strokes along their features, to try the verbs on.

    python examples/car_bodies.py sedan wagon coupe --out cars
    python examples/car_bodies.py sedan --gaps 0.001 --flips 0.5 --clutter --soup --out cars

For every NAME it writes

    NAME.obj             the body: clean quads, or triangles with the faults that were asked for
    NAME.strokes.json    rough strokes along its features (patterndb features)
    NAME.network.json    where the features really are (patterndb register)

The files are the same, byte for byte, on every run.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from bodies import CARS, Body, NamedCurve, body, degrade, stroke

from patterndb_sketch.features.errors import InvalidFeatureError
from patterndb_sketch.features.files.networkjson import spline_through, write_network
from patterndb_sketch.features.files.strokesjson import write_strokes
from patterndb_sketch.features.registration import FeatureCurves
from patterndb_sketch.features.snap import SnapSettings
from patterndb_sketch.features.strokes import FeatureStroke

#: Decimals of what is written: tenths of a millimetre.
DIGITS = 4

#: Of the points of a feature, every eighth: fifty say where it runs.
STEP = 8


def main(arguments: Sequence[str] | None = None) -> None:
    """Writes the files of every body that is named."""
    parser = argparse.ArgumentParser(
        description="Writes car-like bodies with strokes along their features."
    )
    parser.add_argument("names", nargs="+", metavar="NAME", help=f"one of {', '.join(CARS)}")
    parser.add_argument("--out", type=Path, default=Path(), help="the folder, made if need be")
    parser.add_argument("--resolution", type=float, default=1.0, help="a factor on the edges: 1")
    parser.add_argument("--seed", type=int, default=0, help="of strokes and faults: 0")
    parser.add_argument(
        "--error", type=float, default=0.01, help="how rough strokes are, share of the diagonal"
    )
    faults = parser.add_argument_group("faults")
    faults.add_argument("--gaps", type=float, default=0.0, help="width, share of the diagonal")
    faults.add_argument("--crossings", type=float, default=0.0, help="overlap, share of the same")
    faults.add_argument("--flips", type=float, default=0.0, help="share of patches inside out")
    faults.add_argument("--uneven", action="store_true", help="every patch meshed on its own")
    faults.add_argument("--clutter", action="store_true", help="seats, engine, mirrors, wheels")
    faults.add_argument("--soup", action="store_true", help="triangles in random order, not joined")
    given = parser.parse_args(arguments)
    given.out.mkdir(parents=True, exist_ok=True)
    try:
        for name in given.names:
            say(f"{name}: modelling the body")
            write(body(name, given.resolution, whole=True), name, given)
    except InvalidFeatureError as error:
        parser.error(str(error))


def write(car: Body, name: str, given: argparse.Namespace) -> None:
    """Writes the three files of one body."""
    base = given.out / name
    drawable = [curve for curve in car.features if curve.kind != "hidden"]
    say(f"{name}: drawing along {len(drawable)} features")
    strokes = [drawn(car, curve, given.error, given.seed + i) for i, curve in enumerate(drawable)]
    curves = {curve.name: spline_through(curve.smooth[::STEP]) for curve in drawable}
    faulty = given.gaps or given.crossings or given.flips or given.uneven
    if faulty or given.clutter or given.soup:
        say(f"{name}: making faults")
        mess = degrade(
            car,
            given.seed,
            uneven=given.uneven,
            gaps=given.gaps,
            crossings=given.crossings,
            flips=given.flips,
            interior=given.clutter,
            exterior=given.clutter,
            shuffle=given.soup,
        )
        points, faces = mess.points, mess.triangles
    else:
        points, faces = car.points, car.faces
    write_obj(base.with_suffix(".obj"), points, faces, f"{name}, made by examples/car_bodies.py")
    write_strokes(base.with_suffix(".strokes.json"), strokes)
    write_network(base.with_suffix(".network.json"), FeatureCurves(curves))
    print(f"{base}: {len(faces):,} faces, {len(strokes)} strokes")


def say(words: str) -> None:
    """Tells what is being made, beside what was."""
    print(words, file=sys.stderr, flush=True)


def drawn(car: Body, curve: NamedCurve, error: float, seed: int) -> FeatureStroke:
    """A rough stroke along a feature.

    The surface does not bend where the middle plane cuts it: such strokes are drawn in that
    plane, and go where the normals lie in it.
    """
    points = stroke(car, curve.name, error, seed).round(DIGITS)
    if curve.kind != "profile":
        return FeatureStroke(curve.name, points)
    points[:, 1] = 0.0
    return FeatureStroke(curve.name, points, settings=SnapSettings(alpha=0.0, axis=(0.0, 1.0, 0.0)))


def write_obj(path: Path, points: np.ndarray, faces: np.ndarray, title: str) -> None:
    """Writes points (v, 3) and faces of one arity (f, k)."""
    lines = [f"# {title}"]
    lines += [f"v {x:.{DIGITS + 2}f} {y:.{DIGITS + 2}f} {z:.{DIGITS + 2}f}" for x, y, z in points]
    lines += ["f " + " ".join(map(str, face)) for face in (faces + 1).tolist()]
    path.write_text("\n".join(lines) + "\n", encoding="ascii")


if __name__ == "__main__":
    main()
