"""A class of patterns in a small block of bytes: :func:`dump_class` and :func:`parse_class`.

What a query asks of a class (:class:`patterndb.core.patternclass.PatternClass`) comes out of a
block in milliseconds, without a database and without the compiled core. A block is xz-compressed: a
line of JSON, the sizes of the columns, then columns of packed numbers. Rows are ordered by length
of code and code, so that neighbours are alike and compress well; ids, lengths, joins and the
default order follow from the rest.
"""

from __future__ import annotations

import itertools
import json
import lzma

import numpy as np
from numpy.typing import NDArray

from patterndb.core.code import pattern_id
from patterndb.core.label import join_matrices
from patterndb.core.packing import pack, take_stretches, unpack
from patterndb.core.patternclass import PatternClass, number_rows, shrink
from patterndb.errors import DatabaseError

#: Arrays of a class with a number a row, which are columns as they stand.
NUMBERS = (
    "frequency",
    "n_meshes",
    "origin",
    "n_irregular",
    "n_quads",
    "min_valence",
    "max_valence",
    "n_loops",
    "chiral",
    "rotations",
    "self_crossing",
    "rotation",
    "reflected",
)

#: Columns of a block, in this order.
COLUMNS = ("code_sizes", "codes", "corners", "word_sizes", "words", "signature", *NUMBERS)


def order_codes(codes: list[bytes]) -> NDArray[np.int64]:
    """(p,) the rows by length of code and code: the order of blocks."""
    return np.array(sorted(range(len(codes)), key=lambda i: (len(codes[i]), codes[i])), np.int64)


def dump_class(patterns: PatternClass) -> bytes:
    """The block of a class: its patterns that occur in meshes. Uses are left out."""
    met = np.flatnonzero(patterns.frequency > 0)
    rows = met[order_codes([patterns.codes[i] for i in met.tolist()])]
    codes: list[bytes] = [patterns.codes[i] for i in rows.tolist()]
    sizes = np.diff(patterns.word_start)[rows]
    held: dict[str, bytes] = {
        "code_sizes": pack([len(code) for code in codes]),
        "codes": b"".join(codes),
        "corners": pack(patterns.corners[rows].ravel()),
        "word_sizes": pack(sizes),
        "words": pack(take_stretches(patterns.words, patterns.word_start[rows], sizes)),
        "signature": pack(number_rows(patterns.signature[rows, None])[0]),
    }
    for name in NUMBERS:
        held[name] = pack(getattr(patterns, name)[rows].astype(np.int64))
    columns = [held[name] for name in COLUMNS]
    line = json.dumps([len(rows), *map(len, columns)]).encode() + b"\n"
    return lzma.compress(line + b"".join(columns), preset=9)


def parse_class(n_sides: int, block: bytes) -> PatternClass:
    """The class of a block, in default order, as :func:`patterndb.store.reading.load_class` loads
    it from a database of the same. Raises DatabaseError where it is damaged."""
    held = parse_columns(block)
    codes = split_codes(held)
    try:
        return _make_class(n_sides, codes, held)
    except (ValueError, IndexError, KeyError) as error:
        raise DatabaseError(f"the class of {n_sides} sides is damaged ({error})") from error


def parse_columns(block: bytes) -> dict[str, bytes]:
    """The columns of a block by name. Raises DatabaseError where it is damaged."""
    try:
        line, _, body = lzma.decompress(block).partition(b"\n")
        _, *sizes = json.loads(line)
        ends = np.cumsum([0, *sizes]).tolist()
        if len(sizes) != len(COLUMNS) or ends[-1] != len(body):
            raise ValueError("it is cut short")
    except (lzma.LZMAError, EOFError, ValueError, TypeError) as error:
        raise DatabaseError(f"a block of patterns is damaged ({error})") from error
    return {name: body[a:b] for name, a, b in zip(COLUMNS, ends[:-1], ends[1:], strict=True)}


def split_codes(held: dict[str, bytes]) -> list[bytes]:
    """The packed codes of a block's columns, in its order."""
    cuts = np.cumsum(np.r_[0, unpack(held["code_sizes"])]).tolist()
    return [held["codes"][a:b] for a, b in itertools.pairwise(cuts)]


def _make_class(n_sides: int, codes: list[bytes], held: dict[str, bytes]) -> PatternClass:
    numbers = {name: unpack(held[name]) for name in NUMBERS}
    ids = np.array([pattern_id(code, n_sides) for code in codes], np.int64)
    frequency = numbers["frequency"].astype(np.int64)
    order = np.lexsort((ids, -frequency, numbers["n_irregular"]))
    codes = [codes[i] for i in order.tolist()]
    corners = unpack(held["corners"]).astype(np.uint8).reshape(len(codes), n_sides)[order]
    sizes = unpack(held["word_sizes"]).astype(np.int64)
    starts = np.cumsum(sizes) - sizes
    words = take_stretches(unpack(held["words"]).astype(np.int16), starts[order], sizes[order])
    word_start = np.cumsum(np.r_[0, sizes[order]])
    signature, first = number_rows(unpack(held["signature"])[order, None])
    rotation = numbers["rotation"][order]
    reflected = numbers["reflected"][order].astype(np.bool_)
    lengths, joins = _join_sides(
        n_sides,
        take_stretches(words, word_start[first], sizes[order][first]),
        np.cumsum(np.r_[0, sizes[order][first]]),
        rotation[first],
        reflected[first],
    )
    return PatternClass(
        n_sides=n_sides,
        ids=ids[order],
        frequency=frequency[order],
        n_meshes=numbers["n_meshes"][order],
        uses=np.zeros(len(codes), np.int64),
        origin=numbers["origin"][order].astype(np.int8),
        n_irregular=numbers["n_irregular"][order],
        n_quads=numbers["n_quads"][order],
        min_valence=numbers["min_valence"][order],
        max_valence=numbers["max_valence"][order],
        n_reflex=(corners > 2).sum(axis=1, dtype=np.int32),
        corners=corners,
        n_loops=numbers["n_loops"][order],
        chiral=numbers["chiral"][order].astype(np.bool_),
        rotations=numbers["rotations"][order],
        self_crossing=numbers["self_crossing"][order].astype(np.bool_),
        words=words,
        word_start=word_start,
        signature=signature,
        rotation=rotation,
        reflected=reflected,
        codes=codes,
        lengths=shrink(lengths),
        joins=shrink(joins),
    )


def _join_sides(
    n_sides: int,
    words: NDArray[np.int16],
    starts: NDArray[np.int64],
    rotation: NDArray[np.int32],
    reflected: NDArray[np.bool_],
) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
    """Lengths and n_ij of signatures, of labels (words) that read as these from the side
    ``rotation``, backwards where ``reflected``."""
    n = len(rotation)
    width = max(n_sides, 1)
    sizes = np.empty((n, width), np.int32)
    is_edge = np.ones(len(words), np.bool_)
    at = starts[:-1].copy()
    for k in range(width):
        is_edge[at] = False
        sizes[:, k] = words[at]
        at += 1 + sizes[:, k]
    # Side s of a label is this side of its signature.
    label_sides = np.arange(width)
    turned = np.where(reflected, -1, 1)[:, None] * (label_sides - rotation[:, None])
    side = turned % width
    lengths = np.empty_like(sizes)
    np.put_along_axis(lengths, side, sizes, axis=1)
    # The two edges that a polychord crosses have one number: sorted by it, they are neighbours.
    owner = np.repeat(np.arange(n), sizes.sum(axis=1))
    sides = np.repeat(side.ravel(), sizes.ravel())
    both = np.lexsort((words[is_edge], owner)).reshape(-1, 2)
    return lengths, join_matrices(n_sides, sides[both], owner[both[:, 0]], n)
