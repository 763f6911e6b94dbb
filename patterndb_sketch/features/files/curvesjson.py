"""Recovered curves as plain JSON: a drawn network with all that is known of its curves.

    {"model": "sedan.obj",
     "curves": {"roof_rail": {"degree": 3, "knots": [0, 0, 0, 0, 1, 1, 1, 1],
                              "control_points": [[1.28, -0.64, 1.06], ...],
                              "samples": [[...], ...], "parameters": [0, ...],
                              "stroke": [[...], ...],
                              "constraints": [{"sample": 4, "point": [1.3, -0.6, 1.1]}],
                              "settings": {"alpha": 1, "beta": 90, ...},
                              "mended": [], "failed": [3], "ended": [], "notes": ["..."],
                              "figures": {"length": 1.2, "moved": {"mean": 0.01, "most": 0.03},
                                          "fit": {...}, "off": {...}}}}}

samples: where the curve was found, on the model, of a closed curve the first not repeated;
parameters: theirs on the spline. mended, failed,
ended: numbers of samples, see :class:`patterndb_sketch.features.snap.FeatureCurve`. figures: see
:class:`patterndb_sketch.features.strokes.Figures`. The file is a network too: meet, near and
tolerance may be added, see :mod:`patterndb_sketch.features.files.networkjson`.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from patterndb.system.documents import JsonValue, Number, name_file, parse_json, read_limited
from patterndb.system.files import replace_file
from patterndb_sketch.features.errors import InvalidFeatureError
from patterndb_sketch.features.files.networkjson import FOUND_KEYS, KEYS, SPLINE_KEYS, curve_of
from patterndb_sketch.features.files.strokesjson import (
    MAX_BYTES,
    settings_document,
    settings_of,
)
from patterndb_sketch.features.snap import FeatureCurve, SnapSettings
from patterndb_sketch.features.splines import Constraint
from patterndb_sketch.features.strokes import Figures, RecoveredCurve, Spread

SPREADS = ("moved", "fit", "off")


def read_curves(path: Path | str) -> tuple[RecoveredCurve, ...]:
    """The curves in a file that :func:`write_curves` made, all their numbers as they were.

    Raises InvalidFeatureError that names the file and the place in it; OSError as reading does.
    """
    with name_file(Path(path), InvalidFeatureError):
        return curves_of(_read(Path(path)))


def write_curves(path: Path | str, curves: Sequence[RecoveredCurve], model: str = "") -> None:
    """Write curves; model: the name of the file that they are on. OSError as writing does."""
    text = json.dumps(curves_document(curves, model), separators=(",", ":"), allow_nan=False)
    replace_file(Path(path), text + "\n")


def curves_of(document: JsonValue) -> tuple[RecoveredCurve, ...]:
    """The curves in a document. Raises InvalidFeatureError that names the place in it."""
    entries = document.entries(KEYS, 'an object such as {"curves": {...}}')
    if "curves" not in entries:
        document.fail('"curves" is missing: an object with every curve')
    return tuple(_curve(name, one) for name, one in entries["curves"].entries().items())


def curves_document(curves: Sequence[RecoveredCurve], model: str = "") -> dict[str, object]:
    """Curves as plain JSON has them; :func:`curves_of` gives them back."""
    if len({one.name for one in curves}) < len(curves):
        raise InvalidFeatureError("two curves have one name; give each a name of its own")
    document: dict[str, object] = {"model": model} if model else {}
    return document | {"curves": {one.name: curve_document(one) for one in curves}}


def curve_document(one: RecoveredCurve) -> dict[str, object]:
    """One curve with all that is known of it."""
    curve, figures = one.curve, one.figures
    return curve.spline.as_document() | {
        "samples": curve.samples.tolist(),
        "parameters": curve.parameters.tolist(),
        "stroke": one.stroke.tolist(),
        "constraints": [
            {"sample": int(number), "point": np.asarray(point, np.float64).tolist()}
            for number, point in curve.constraints
        ],
        "settings": settings_document(curve.settings),
        "mended": list(curve.repaired),
        "failed": list(curve.failed),
        "ended": list(curve.ended),
        "notes": list(curve.notes),
        "figures": figures_document(figures),
    }


def figures_document(figures: Figures) -> dict[str, object]:
    """The figures of a curve as plain JSON has them."""
    document: dict[str, object] = {"length": figures.length}
    for name in SPREADS:
        spread: Spread = getattr(figures, name)
        document[name] = {"mean": spread.mean, "most": spread.most}
    return document


def _read(path: Path) -> JsonValue:
    data = read_limited(path, MAX_BYTES, InvalidFeatureError, "write fewer curves to a file")
    return parse_json(data, InvalidFeatureError, "a network of curves")


def _curve(name: str, value: JsonValue) -> RecoveredCurve:
    if not value.is_object:
        value.fail("this is a polyline, and not a curve that was recovered from a stroke")
    entries = value.entries((*SPLINE_KEYS, *FOUND_KEYS))
    for key in FOUND_KEYS:
        if key not in entries:
            value.fail(f'"{key}" is missing; this curve was not recovered from a stroke')
    spline = curve_of(value)
    samples = np.array(entries["samples"].polyline())
    parameters = np.array(entries["parameters"].read(list[Number]))
    m = len(samples)
    if len(parameters) != m:
        entries["parameters"].fail(f"there are {len(parameters)}, and {m} samples")
    low, high = spline.domain
    if spline.closed:
        # A closed curve goes on beyond its period, wherever that begins.
        low, high = parameters[0], parameters[0] + (high - low)
    if (np.diff(parameters) < 0.0).any() or parameters[0] < low or parameters[-1] > high:
        entries["parameters"].fail(f"they must ascend within the curve's {low:g} to {high:g}")
    constraints = constraints_of(entries["constraints"], m)
    mended, failed, ended = (
        tuple(_sample(number, m) for number in entries[key].items())
        for key in ("mended", "failed", "ended")
    )
    settings = settings_of(entries["settings"], SnapSettings())
    curve = FeatureCurve(
        spline, samples, parameters, constraints, settings, mended, failed, ended,
        tuple(entries["notes"].read(list[str])),
    )  # fmt: skip
    stroke = np.array(entries["stroke"].polyline())
    return RecoveredCurve(name, stroke, curve, _figures(entries["figures"]))


def constraints_of(value: JsonValue, m: int) -> tuple[Constraint, ...]:
    """Return the constraints in a list, of a curve with m samples."""
    constraints: list[Constraint] = []
    for one in value.items():
        parts = one.entries(("sample", "point"))
        if len(parts) < 2:
            one.fail("a constraint has the number of a sample and a point")
        constraints.append((_sample(parts["sample"], m), np.array(parts["point"].point())))
    return tuple(constraints)


def _sample(value: JsonValue, m: int) -> int:
    number = value.whole("the number of a sample")
    if not 0 <= number < m:
        value.fail(f"there is no sample {number}; there are {m}, from 0")
    return number


def _figures(value: JsonValue) -> Figures:
    keys = ("length", *SPREADS)
    entries = value.entries(keys)
    for key in keys:
        if key not in entries:
            value.fail(f'"{key}" is missing; figures are {", ".join(keys)}')
    spreads: list[Spread] = []
    for key in SPREADS:
        parts = entries[key].entries(("mean", "most"))
        if len(parts) < 2:
            entries[key].fail("give mean and most")
        spreads.append(Spread(parts["mean"].number(), parts["most"].number()))
    return Figures(entries["length"].number(), *spreads)
