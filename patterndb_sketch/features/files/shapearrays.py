"""Shape models as named arrays in one file (.npz, a zip of .npy).

mean (n, 3), modes (l, n, 3), deviations (l,), coefficients (k, l): float64. quads (q, 4): int32.
header: the bytes of JSON,

    {"format": "patterndb shape model", "version": 1, "variance": 0.42, "template": "box:car?r=11",
     "names": ["sedan", ...], "features": [{"name": "roof_rail", "vertices": [4, 9, 10]}, ...]}

Numbers and text alone: nothing in such a file is ever run.
"""

from __future__ import annotations

import io
import zipfile
import zlib
from pathlib import Path
from tokenize import TokenError
from typing import Annotated, Any

import numpy as np
from msgspec import Meta

from patterndb.system.documents import (
    JsonModel,
    JsonValue,
    Number,
    encode_json,
    name_file,
    parse_json,
    read_limited,
)
from patterndb.system.files import replace_file
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

#: Bytes that the arrays may have together: a hundred modes of a million vertices.
MAX_BYTES = 4_000_000_000

#: What zipfile, its decompressors and numpy raise for files that are damaged or of another kind,
#: encrypted, or packed by methods that are not known. Headers of arrays are read as Python.
_UNREADABLE = (
    zipfile.BadZipFile, zlib.error, EOFError, OSError, ValueError, LookupError, RuntimeError,
    NotImplementedError, OverflowError, MemoryError, TypeError, AttributeError, SyntaxError,
    TokenError,
)  # fmt: skip

#: How far modes may be from orthonormal: rounding alone moves them by some 1e-14.
ORTHONORMAL = 1e-9


class ShapeFeatureModel(JsonModel):
    """A named chain of vertices."""

    name: str
    vertices: list[Annotated[int, Meta(ge=0, le=2**31 - 1, description="the number of a vertex")]]


class HeaderModel(JsonModel):
    """What a file has beside its numbers."""

    format: str
    version: int
    variance: Number
    template: str
    names: list[str]
    features: list[ShapeFeatureModel]


def shape_bytes(model: ShapeModel) -> bytes:
    """The file of a shape model; :func:`shape_of` gives it back bit for bit."""
    header = HeaderModel(
        FORMAT,
        VERSION,
        model.variance,
        model.template,
        list(model.names),
        [ShapeFeatureModel(one.name, one.vertices.tolist()) for one in model.features],
    )
    file = io.BytesIO()
    np.savez(
        file,
        mean=model.mean.astype("<f8"),
        modes=model.modes.astype("<f8"),
        deviations=model.deviations.astype("<f8"),
        coefficients=model.coefficients.astype("<f8"),
        quads=model.quads.astype("<i4"),
        header=np.frombuffer(encode_json(header).rstrip(), np.uint8),
    )
    return file.getvalue()


def shape_of(data: bytes) -> ShapeModel:
    """The shape model in a file's bytes. Raises InvalidFeatureError for anything else."""
    arrays = _read_arrays(data)
    header = parse_json(arrays["header"].tobytes(), InvalidFeatureError, "a shape model's header")
    try:
        return _model(arrays, header)
    except InvalidFeatureError as error:
        raise InvalidFeatureError(f"the shape model: {error}") from None


def read_shapes(path: Path | str) -> ShapeModel:
    """Return the shape model in a file.

    Raises InvalidFeatureError with the file and what is wrong; OSError.
    """
    path = Path(path)
    with name_file(path, InvalidFeatureError):
        return shape_of(read_limited(path, MAX_BYTES, InvalidFeatureError, "keep fewer modes"))


def write_shapes(path: Path | str, model: ShapeModel) -> None:
    """Write a shape model; :func:`read_shapes` gives it back bit for bit. Raises OSError."""
    replace_file(Path(path), shape_bytes(model))


def _read_arrays(data: bytes) -> dict[str, Any]:
    try:
        with np.load(io.BytesIO(data), allow_pickle=False) as file:
            members = sum(one.file_size for one in file.zip.infolist())
            if members > MAX_BYTES:
                raise InvalidFeatureError(f"the shape model has more than {MAX_BYTES:,} bytes")
            if sorted(file) != sorted(ARRAYS):
                raise InvalidFeatureError(
                    f"a shape model has the arrays {', '.join(ARRAYS)}; the file has "
                    f"{', '.join(sorted(file))[:200] or 'none'}"
                )
            arrays = {name: file[name] for name in ARRAYS}
    except InvalidFeatureError:
        raise
    except _UNREADABLE as reason:
        raise InvalidFeatureError(f"this is not a shape model (.npz): {reason}") from None
    for name, (kind, axes) in ARRAYS.items():
        # A member that is no .npy file comes as its bytes.
        if not isinstance(arrays[name], np.ndarray):
            raise InvalidFeatureError(f"the shape model's {name} is not an array")
        if arrays[name].dtype.str != kind or arrays[name].ndim != axes:
            raise InvalidFeatureError(
                f"the shape model's {name} must be {kind} with {axes} axes, got "
                f"{arrays[name].dtype.str} {arrays[name].shape}"
            )
        if kind == "<f8" and not np.isfinite(arrays[name]).all():
            raise InvalidFeatureError(f"the shape model's {name} has numbers that are not finite")
    return arrays


def _model(arrays: dict[str, Any], header: JsonValue) -> ShapeModel:
    found = header.read(HeaderModel)
    if found.format != FORMAT or found.version != VERSION:
        header.fail(
            f"the format is {found.format!r} {found.version}; this reads {FORMAT!r} {VERSION}"
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
    if len(found.names) != k or len(set(found.names)) < k:
        header.at("names").fail(f"there must be {k} different names")
    if found.variance < float((deviations**2).sum()) * (1.0 - 1e-9):
        header.at("variance").fail("it is below that of the modes")
    features = tuple(Feature(one.name, np.array(one.vertices, np.int32)) for one in found.features)
    check_features(features, quads, n)
    return ShapeModel(
        mean, modes, deviations, coefficients, found.variance, quads, features,
        tuple(found.names), found.template,
    )  # fmt: skip
