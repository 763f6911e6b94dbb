"""Wavefront OBJ files.

Polygons keep their arity and the file's own vertex numbers: texture coordinates and
normals are not looked at, so no vertex is split at a seam.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ingest.read import grammar
from ingest.read.assemble import assemble
from ingest.read.grammar import Fail, failing
from ingest.read.limits import MIB, ReadLimits
from ingest.read.objchunk import parse_chunk
from ingest.read.objlines import face_tokens, parse_lines
from ingest.read.objrecords import ObjRecords
from patterndb.core.polygonmesh import PolygonMesh

# Large enough that the work per chunk is in numpy, small enough for its arrays to stay in
# the cache, and for one extraordinary line to cost little.
CHUNK_BYTES = 2 * MIB


def parse_obj(data: bytes, path: str | Path, limits: ReadLimits) -> PolygonMesh:
    """The mesh an OBJ file holds.

    data: the whole file; path: its name, for messages only.

    A face may name a vertex that is defined further down, as long as the file defines it;
    a negative index counts back from the vertices read so far, as the specification says.
    Of a vertex with a weight (x y z w) the position is x y z as written: the weight
    concerns rational curves alone.

    Raises MeshFileError with the line and the token at fault.
    """
    fail = failing(path)
    if data.startswith((b"\xff\xfe", b"\xfe\xff")):
        fail("the text is UTF-16; save it as UTF-8", line=1)
    text = grammar.unix_newlines(data.removeprefix(b"\xef\xbb\xbf"))
    grammar.refuse_nul(text, fail)

    begins: list[int] = []
    runs: list[ObjRecords] = []
    line, counted = 1, 0  # the line that starts at byte `counted`
    for begin, end in _chunks(text):
        chunk = text[begin:end]
        records = parse_chunk(chunk, limits)
        if records is None:
            line, counted = line + text.count(b"\n", counted, begin), begin
            records = parse_lines(chunk, line, limits, fail)
        begins.append(begin)
        runs.append(records)

    points = np.concatenate([run.points for run in runs])
    written = np.concatenate([run.indices for run in runs])
    arities = np.concatenate([run.arities for run in runs])
    counts = [len(run.points) for run in runs]
    seen = np.concatenate(
        [run.seen + before for run, before in zip(runs, _before(counts), strict=True)]
    )
    starts = np.concatenate([run.starts + at for run, at in zip(runs, begins, strict=True)])
    corners = np.where(written > 0, written - 1, written + np.repeat(seen, arities))
    _check_range(corners, written, arities, seen, starts, len(points), text, limits, fail)
    return assemble(points, corners, arities, path, limits)


def _chunks(text: bytes) -> Iterator[tuple[int, int]]:
    """Byte ranges of whole lines, no line parted from the one that continues it."""
    begin = 0
    while begin < len(text):
        newline = text.find(b"\n", begin + CHUNK_BYTES)
        while newline >= 0 and text[newline - 1 : newline] == b"\\":
            newline = text.find(b"\n", newline + 1)
        end = len(text) if newline < 0 else newline + 1
        yield begin, end
        begin = end


def _before(counts: list[int]) -> list[int]:
    return [0, *np.cumsum(counts, dtype=np.int64)[:-1].tolist()]


def _check_range(
    corners: NDArray[np.int64],
    written: NDArray[np.int64],
    arities: NDArray[np.int64],
    seen: NDArray[np.int64],
    starts: NDArray[np.int64],
    n_points: int,
    text: bytes,
    limits: ReadLimits,
    fail: Fail,
) -> None:
    """Fail at the first corner that names no vertex."""
    wrong = (corners < 0) | (corners >= n_points)
    if not wrong.any():
        return
    corner = int(wrong.argmax())
    ends = np.cumsum(arities)
    face = int(np.searchsorted(ends, corner, side="right"))
    start = int(starts[face])
    token = face_tokens(text, start, limits, fail)[corner - int(ends[face] - arities[face])]
    line = 1 + text.count(b"\n", 0, start)
    if written[corner] < 0:
        fail(
            f"the index reaches back before the first vertex: {seen[face]} were read so far",
            line=line,
            token=token,
        )
    fail(
        f"the face names a vertex that the file does not define: it has {n_points}",
        line=line,
        token=token,
    )
