"""Letters as outlines: what a picture made of pixels is lettered with.

The file holds, for each style, the outlines of DejaVu's letters as lines, as
scripts/build_letters.py writes them: ``characters`` (n,) code points, ascending, the first, 0, for
those that are not there; ``advances`` (n,); ``letters`` (n + 1,) where each letter's contours
begin; ``contours`` where each contour's points begin; ``points`` (m, 2), y upward. Lengths are in
parts of :data:`EM`.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from importlib.resources import files

import numpy as np
from numpy.typing import NDArray

from patterndb.geometry.points import Points

#: Units of an em, the size of a type.
EM = 2048.0


@dataclass(frozen=True, slots=True)
class Typeface:
    """One style of letters, as the head of this module says."""

    characters: NDArray[np.int32]
    advances: NDArray[np.int16]
    letters: NDArray[np.int32]
    contours: NDArray[np.int32]
    points: NDArray[np.int16]

    def find_letters(self, text: str) -> NDArray[np.intp]:
        """Find (len(text),) the numbers of a text's letters; 0, an empty box, for one not there."""
        asked = np.array([ord(c) for c in text], np.int32)
        at = np.minimum(np.searchsorted(self.characters, asked), len(self.characters) - 1)
        return np.where(self.characters[at] == asked, at, 0)


@cache
def load_typeface(*, bold: bool, mono: bool) -> Typeface:
    """Load one of the four styles."""
    style = ("mono" if mono else "sans") + ("-bold" if bold else "")
    with (
        (files("viewer") / "letters" / "dejavu.npz").open("rb") as file,
        np.load(file, allow_pickle=False) as arrays,
    ):
        return Typeface(
            arrays[f"{style}/characters"],
            arrays[f"{style}/advances"],
            arrays[f"{style}/letters"],
            arrays[f"{style}/contours"],
            arrays[f"{style}/points"],
        )


def outline_text(
    text: str, size: float, *, bold: bool = False, mono: bool = False
) -> tuple[list[Points], float]:
    """Outline a line of text whose baseline begins at the origin, y upward.

    size: of the em. Returns the contours, (k, 2) each, holes the other way round, and the
    width of the line, both in the unit of ``size``.
    """
    face = load_typeface(bold=bold, mono=mono)
    contours: list[Points] = []
    at = 0.0
    for letter in face.find_letters(text).tolist():
        for contour in range(face.letters[letter], face.letters[letter + 1]):
            points = face.points[face.contours[contour] : face.contours[contour + 1]]
            contours.append(np.add(points, [at, 0.0], dtype=np.float64) * (size / EM))
        at += float(face.advances[letter])
    return contours, at * size / EM
