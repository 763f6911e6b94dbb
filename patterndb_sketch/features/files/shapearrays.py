"""Shape models as named arrays in one file (.npz, a zip of .npy).

mean (n, 3), modes (l, n, 3), deviations (l,), coefficients (k, l): float64. quads (q, 4): int32.
header: the bytes of JSON,

    {"format": "patterndb shape model", "version": 1, "variance": 0.42, "template": "box:car?r=11",
     "names": ["sedan", ...], "features": [{"name": "roof_rail", "vertices": [4, 9, 10]}, ...]}

Numbers and text alone: nothing in such a file is ever run.
"""

from __future__ import annotations

import io
import json
from typing import Any

import numpy as np

from patterndb.system.archives import read_array, read_members
from patterndb.system.documents import JsonValue, parse_json
from patterndb_sketch.features.errors import InvalidFeatureError
from patterndb_sketch.features.registration import Feature
from patterndb_sketch.features.shapemodel.model import ShapeModel, check_features

FORMAT, VERSION = "patterndb shape model", 1

#: The arrays by name: their types and numbers of axes.
ARRAYS: dict[str, tuple[str, int]] = {
    "mean": ("<f8", 2),
    "modes": ("<f8", 3),
    "deviations": ("<f8", 1),
    "coefficients": ("<f8", 2),
    "quads": ("<i4", 2),
    "header": ("|u1", 1),
}

HEADER_KEYS = ("format", "version", "variance", "template", "names", "features")
FEATURE_KEYS = ("name", "vertices")

#: Bytes that the arrays may have together: a hundred modes of a million vertices.
MAX_BYTES = 4_000_000_000

#: How far modes may be from orthonormal: rounding alone moves them by some 1e-14.
ORTHONORMAL = 1e-9


def shape_bytes(model: ShapeModel) -> bytes:
    """The file of a shape model; :func:`shape_of` gives it back bit for bit."""
    header = {
        "format": FORMAT,
        "version": VERSION,
        "variance": model.variance,
        "template": model.template,
        "names": list(model.names),
        "features": [
            {"name": one.name, "vertices": one.vertices.tolist()} for one in model.features
        ],
    }
    text = json.dumps(header, separators=(",", ":"), allow_nan=False).encode()
    file = io.BytesIO()
    np.savez(
        file,
        mean=model.mean.astype("<f8"),
        modes=model.modes.astype("<f8"),
        deviations=model.deviations.astype("<f8"),
        coefficients=model.coefficients.astype("<f8"),
        quads=model.quads.astype("<i4"),
        header=np.frombuffer(text, np.uint8),
    )
    return file.getvalue()


def shape_of(data: bytes) -> ShapeModel:
    """The shape model in a file's bytes. Raises InvalidFeatureError for anything else."""
    arrays = _arrays(data)
    header = parse_json(arrays["header"].tobytes(), InvalidFeatureError, "a shape model's header")
    try:
        return _model(arrays, header)
    except InvalidFeatureError as error:
        raise InvalidFeatureError(f"the shape model: {error}") from None


def _arrays(data: bytes) -> dict[str, Any]:
    members = read_members(data, InvalidFeatureError, "a shape model", max_bytes=MAX_BYTES)
    if sorted(members) != sorted(f"{name}.npy" for name in ARRAYS):
        raise InvalidFeatureError(
            f"a shape model has the arrays {', '.join(ARRAYS)}; the file has "
            f"{', '.join(sorted(members))[:200] or 'none'}"
        )
    arrays = {
        name: read_array(members[f"{name}.npy"], InvalidFeatureError, f"the shape model's {name}")
        for name in ARRAYS
    }
    for name, (kind, axes) in ARRAYS.items():
        if arrays[name].dtype.str != kind or arrays[name].ndim != axes:
            raise InvalidFeatureError(
                f"the shape model's {name} must be {kind} with {axes} axes, got "
                f"{arrays[name].dtype.str} {arrays[name].shape}"
            )
        if kind == "<f8" and not np.isfinite(arrays[name]).all():
            raise InvalidFeatureError(f"the shape model's {name} has numbers that are not finite")
    return arrays


def _model(arrays: dict[str, Any], header: JsonValue) -> ShapeModel:
    entries = header.entries(HEADER_KEYS)
    for key in HEADER_KEYS:
        if key not in entries:
            header.fail(f'"{key}" is missing in the header')
    if entries["format"].text() != FORMAT or entries["version"].whole() != VERSION:
        header.fail(
            f"the format is {entries['format'].value!r} {entries['version'].value}; this reads "
            f"{FORMAT!r} {VERSION}"
        )
    mean, modes, deviations, coefficients, quads = (
        np.ascontiguousarray(arrays[name])
        for name in ("mean", "modes", "deviations", "coefficients", "quads")
    )
    n, (k, count) = len(mean), coefficients.shape
    if mean.shape != (n, 3) or modes.shape != (count, n, 3) or deviations.shape != (count,):
        header.fail(
            f"mean {mean.shape}, modes {modes.shape}, deviations {deviations.shape} and "
            f"coefficients {coefficients.shape} do not fit together"
        )
    if not 1 <= count <= k - 1 or not (deviations > 0.0).all():
        header.fail(f"{k} shapes have 1 to {k - 1} modes, all with a deviation above 0")
    flat = modes.reshape(count, -1)
    if np.abs(flat @ flat.T - np.eye(count)).max() > ORTHONORMAL:
        header.fail("the modes are not orthonormal")
    low, high = coefficients.min(axis=0), coefficients.max(axis=0)
    if not ((low < high) & (low <= 0.0) & (high >= 0.0)).all():
        header.fail("a mode's coefficients must be about 0 and differ")
    names = [one.text() for one in entries["names"].items()]
    if len(names) != k or len(set(names)) < k:
        entries["names"].fail(f"there must be {k} different names")
    variance = entries["variance"].number()
    if variance < float((deviations**2).sum()) * (1.0 - 1e-9):
        entries["variance"].fail("it is below that of the modes")
    features: list[Feature] = []
    for one in entries["features"].items():
        parts = one.entries(FEATURE_KEYS)
        if len(parts) < len(FEATURE_KEYS):
            one.fail("a feature has a name and vertices")
        vertices = [vertex.whole("the number of a vertex") for vertex in parts["vertices"].items()]
        if any(not 0 <= vertex < n for vertex in vertices):
            parts["vertices"].fail(f"vertices are 0..{n - 1}")
        features.append(Feature(parts["name"].text(), np.array(vertices, np.int32)))
    check_features(features, quads, n)
    return ShapeModel(
        mean, modes, deviations, coefficients, variance, quads, tuple(features), tuple(names),
        entries["template"].text(),
    )  # fmt: skip
