"""Curve networks from files, and back.

read_network tells by the content what a file is:

- plain JSON, see :mod:`patterndb_sketch.surfacing.files.networkjson`;
- a stroke graph of CASSIE, see :mod:`patterndb_sketch.surfacing.files.cassie`;
- lines of a Wavefront OBJ file, see :mod:`patterndb_sketch.surfacing.files.objlines`;
- polylines as drawn (.curves), see :mod:`patterndb_sketch.surfacing.files.plaintext`;
- a loop of B-splines (.lop) or patches with quadratic boundaries (.sdm), see
  :mod:`patterndb_sketch.surfacing.files.plaintext`.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path

from patterndb.system.documents import parse_json, read_limited
from patterndb.system.files import explain_compression, replace_file
from patterndb_sketch.curvenetwork.drawing import Drawing
from patterndb_sketch.curvenetwork.network import CurveNetwork, InvalidNetworkError
from patterndb_sketch.surfacing.files.cassie import (
    RecordedPatch,
    is_stroke_graph,
    recorded_patches,
    stroke_graph_drawing,
)
from patterndb_sketch.surfacing.files.networkjson import drawing_of, network_document
from patterndb_sketch.surfacing.files.objlines import is_obj, obj_drawing
from patterndb_sketch.surfacing.files.plaintext import (
    NumberWords,
    loop_network,
    patches_network,
    polylines_drawing,
)

#: Bytes that a file may have: the largest sketches of the CASSIE data set have some 110,000.
MAX_BYTES = 32_000_000


def read_network(path: Path | str, tolerance: float | None = None) -> CurveNetwork:
    """The network in a file, with the cycles that the file gives.

    tolerance: how far apart curves may pass and still meet, in the network's unit; by default
    what the file says, else it follows from by how much the curves miss each other (see
    :func:`patterndb_sketch.curvenetwork.joining.join_polylines`). Only for files that leave
    it open where curves meet.

    Raises InvalidNetworkError that names the file and the place in it, says what is wrong there
    and what would mend it; OSError as reading does.
    """
    return read_drawing(path, tolerance).network


def read_drawing(path: Path | str, tolerance: float | None = None) -> Drawing:
    """As :func:`read_network`, with the stages of the drawing and notes on what was left out."""
    path = Path(path)
    try:
        return parse_drawing(_content(path), tolerance)
    except InvalidNetworkError as error:
        raise InvalidNetworkError(f"{path}: {error}") from None


def parse_drawing(data: bytes, tolerance: float | None = None) -> Drawing:
    """As :func:`read_drawing`, of a file's content; messages do not name a file."""
    packed = explain_compression(data)
    if packed is not None:
        raise InvalidNetworkError(packed)
    if is_obj(data):
        return obj_drawing(data, tolerance)
    if not _is_text_of_numbers(data):
        document = parse_json(data, InvalidNetworkError, "a network")
        if not is_stroke_graph(document):
            return drawing_of(document, tolerance)
        return stroke_graph_drawing(document, tolerance)
    words = NumberWords(data)
    if words.peek() == "v":
        return polylines_drawing(words, tolerance)
    _refuse_tolerance(tolerance)
    # After the number of patches and of corners, the first corner stands in a line of its own.
    if len(words.line(2)) == 3:
        return Drawing(patches_network(words))
    return Drawing(loop_network(words))


def read_recorded_patches(path: Path | str) -> tuple[RecordedPatch, ...]:
    """The patches that were made while a CASSIE sketch was drawn, in their order.

    Raises as :func:`read_network` does, also for other files.
    """
    path = Path(path)
    try:
        document = parse_json(_content(path), InvalidNetworkError, "a network")
        return recorded_patches(document)
    except InvalidNetworkError as error:
        raise InvalidNetworkError(f"{path}: {error}") from None


def write_network(
    path: Path | str, network: CurveNetwork, stages: Sequence[Sequence[int]] = ()
) -> None:
    """Write the network, its cycles and maybe stages as plain JSON; reading gives them back.

    Raises as :func:`patterndb_sketch.surfacing.files.networkjson.network_document` does; OSError as
    writing does.
    """
    document = network_document(network, stages)
    replace_file(Path(path), json.dumps(document, separators=(",", ":"), allow_nan=False) + "\n")


def _content(path: Path) -> bytes:
    return read_limited(path, MAX_BYTES, InvalidNetworkError, "give fewer points")


def _is_text_of_numbers(data: bytes) -> bool:
    beginning = data[:1000].lstrip()[:1]
    return beginning == b"v" or beginning.isdigit()


def _refuse_tolerance(tolerance: float | None) -> None:
    if tolerance is not None:
        raise InvalidNetworkError(
            "a tolerance has nothing to do here: the file says itself where curves meet; leave "
            "it out"
        )
