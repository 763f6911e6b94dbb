"""The keys by which the paper's authors store patterns, and the columns beside them.

A *key* lists the faces of a patch breadth-first from a start corner. For every face it names
the faces across three of its edges, counter-clockwise after the edge by which the face was
reached; face 0 is taken as reached by the border edge that leaves the start corner. Every
name is a hexadecimal number of the same width; ``#`` all through stands for the border. Among
all corners (all boundary vertices where there is no corner) the smallest key is the patch's.

A name tells the face and not its edge, and two faces may share several edges. Still a key
belongs to one disk. The edge by which a face was reached is known, and in a disk it leads to
the boundary without the other face: were it otherwise, that one would have been reached from
the other. So the edges by which both were reached lie on one side of the edges that they
share, and going round each from there one face meets these in reverse order of the other.

Source: the database of Marcias et al. 2015, as docs/database.md tells it.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from patterndb._native.core.code import is_disk_code
from patterndb._native.store.ddqkey import survey
from patterndb.core.code import MAX_QUADS
from patterndb.core.halfedge import Int32Array
from patterndb.errors import InvalidCodeError

#: Hexadecimal digits of a name in the authors' program, which keeps numbers of 64 bits.
AUTHORS_DIGITS = 16
#: Digits of a boundary label and of a valence (16 bits), and of a number of vertices (64).
_LABEL_DIGITS = 4
_COUNT_DIGITS = 16

_NAME = re.compile(r"[0-9a-fA-F]+")
#: A border: # all through, or once or more and padded with zeros or spaces.
_BORDER = re.compile(r"[0 ]*#+[0 ]*")


@dataclass(frozen=True, slots=True)
class Columns:
    """What stands beside the key. boundary_ids: for every edge of the boundary, from the start
    corner on, ``x`` and the number of its polychord in four digits, numbered as they come, with
    ``-`` between sides. singularities: for every valence of irregular vertices, ascending,
    ``v``, the valence in four digits, ``:``, their number in sixteen, with ``-`` between.
    """

    boundary_ids: str
    singularities: str
    n_singularities: int
    n_corners: int
    n_vertices: int
    n_concave: int


# Reading


def patch_of_key(topology: str, n_faces: int) -> Int32Array:
    """The disk that a key describes, as (4q,) int32 half-edges from the start corner on.

    Raises InvalidCodeError, saying what is wrong, if the text is no key of ``n_faces`` faces
    or its faces do not make a disk.
    """
    if not 1 <= n_faces <= MAX_QUADS:
        raise InvalidCodeError(f"nFaces is {n_faces}, not 1..{MAX_QUADS}")
    width, rest = divmod(len(topology), 3 * n_faces)
    if rest or not 1 <= width <= AUTHORS_DIGITS:
        raise InvalidCodeError(
            f"topology has {len(topology)} characters, which is not 1 to {AUTHORS_DIGITS} for "
            f"each of three neighbours of {n_faces} faces"
        )
    twin = _glued(_neighbours(topology, n_faces, width))
    if not is_disk_code(twin):
        raise InvalidCodeError("the faces of topology do not make a disk")
    return twin


def _neighbours(topology: str, n_faces: int, width: int) -> list[list[int]]:
    """For every face the faces across its edges 1 to 3, -1 at the border."""
    known: dict[str, int] = {}
    names: list[int] = []
    for at in range(0, len(topology), width):
        field = topology[at : at + width]
        number = known.get(field)
        if number is None:
            if _NAME.fullmatch(field):
                number = int(field, 16)
            elif _BORDER.fullmatch(field):
                number = -1
            else:
                raise InvalidCodeError(f"{field!r} at {at} of topology is no hexadecimal number")
            if number >= n_faces:
                raise InvalidCodeError(
                    f"topology names face {number}, but there are {n_faces}, from 0 on"
                )
            known[field] = number
        names.append(number)
    return [names[i : i + 3] for i in range(0, len(names), 3)]


def _glued(neighbours: list[list[int]]) -> Int32Array:
    """Half-edges of the faces, edges paired with those of the faces that they name."""
    twin = np.full(4 * len(neighbours), -1, np.int32)
    reached = 0
    # Edges by which no face was reached: of (face, other) those of face that name other.
    free: dict[tuple[int, int], list[int]] = {}
    for face, names in enumerate(neighbours):
        if face > reached:
            raise InvalidCodeError(f"face {face} of topology is not reached from those before it")
        for edge, other in enumerate(names, start=1):
            if other > reached + 1:
                raise InvalidCodeError(f"topology reaches face {other} before face {reached + 1}")
            if other == reached + 1:
                reached += 1
                twin[4 * face + edge] = 4 * other
                twin[4 * other] = 4 * face + edge
            elif other >= 0:
                free.setdefault((face, other), []).append(4 * face + edge)
    for (face, other), edges in free.items():
        back = free.get((other, face), [])
        if len(back) != len(edges):
            raise InvalidCodeError(
                f"face {face} of topology names face {other} {len(edges)} times and is named "
                f"back {len(back)} times, besides the edges by which faces are reached"
            )
        if face == other and len(edges) != 2:
            raise InvalidCodeError(f"face {face} of topology names itself {len(edges)} times")
        twin[edges] = back[::-1]
    return twin


# Writing


def key_text(faces: NDArray[np.int32], digits: int | None = None) -> str:
    """The key as text, every face in ``digits`` digits (default: the fewest that do).

    Raises ValueError if they are too few.
    """
    n = len(faces) // 3
    fewest = fewest_digits(n)
    width = fewest if digits is None else digits
    if width < fewest:
        raise ValueError(f"{n} faces need {fewest} hexadecimal digits each, not {width}")
    names: list[str] = [f"{i:0{width}x}" for i in range(n)] + ["#" * width]
    places: list[int] = faces.tolist()
    return "".join([names[i] for i in places])


def fewest_digits(n_faces: int) -> int:
    """Hexadecimal digits that name so many faces."""
    return len(f"{max(n_faces - 1, 0):x}")


def columns_of(twin: Int32Array) -> Columns:
    """The columns beside the key of a disk, given by its half-edges from the start corner on."""
    chords, corner, valences, n_vertices, n_concave = survey(twin)
    text: list[str] = []
    names: dict[int, int] = {}
    for edge, (chord, turns) in enumerate(zip(chords.tolist(), corner.tolist(), strict=True)):
        if turns and edge:
            text.append("-")
        text.append(f"x{names.setdefault(chord, len(names)):0{_LABEL_DIGITS}x}")
    found, counts = np.unique(valences, return_counts=True)
    return Columns(
        boundary_ids="".join(text),
        singularities="-".join(
            f"v{valence:0{_LABEL_DIGITS}x}:{count:0{_COUNT_DIGITS}x}"
            for valence, count in zip(found.tolist(), counts.tolist(), strict=True)
        ),
        n_singularities=len(valences),
        n_corners=int(corner.sum()),
        n_vertices=n_vertices,
        n_concave=n_concave,
    )
