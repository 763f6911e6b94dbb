"""What a PLY body says of vertices and faces, whether in text or in binary."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from ingest.read.plyheader import Element


@dataclass(frozen=True, slots=True)
class FaceRows:
    """The faces of a PLY file.

    corners: (c,) int64, as written. arities: (f,) int64.
    place:   the line of face i (None in a binary file), and words that say where it is.
    """

    corners: NDArray[np.int64]
    arities: NDArray[np.int64]
    place: Callable[[int], tuple[int | None, str]]


class Body(Protocol):
    """Reads the elements of a body, one after another, in the order of the header."""

    def points(self, element: Element, xyz: tuple[int, int, int]) -> NDArray[np.float64]:
        """(v, 3) the properties at the three positions, of every row; all finite."""
        ...

    def faces(self, element: Element, indices: int) -> FaceRows:
        """The lists of the property at the position, of every row; all of allowed length."""
        ...

    def skip(self, element: Element) -> None:
        """Pass over all rows."""
        ...

    def finish(self) -> None:
        """Fail if anything follows the last element."""
        ...
