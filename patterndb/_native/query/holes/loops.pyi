# Bound by rust/python/src/query/holes.rs.
import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Int32Array

def turn_alike(
    face: Int32Array, partner: Int32Array, same: NDArray[np.bool_], start: NDArray[np.int64]
) -> tuple[NDArray[np.bool_], int]:
    """(f,) which faces to read backwards so that neighbours agree; a half-edge where none can."""

def walk_borders(
    border: Int32Array, twin: Int32Array, previous: Int32Array, crowded: NDArray[np.bool_]
) -> tuple[Int32Array, NDArray[np.int64]]:
    """Loops of border half-edges, each with the hole on its right, in the order of the hole.

    Returns the half-edges, loop after loop, and where each begins. Loop vertex i is the head of
    half-edge i. A loop that reaches an edge of more than two faces ends with -1.
    """

def flood(
    root: int, face: Int32Array, twin: Int32Array, start: NDArray[np.int64]
) -> NDArray[np.int64]:
    """The faces of a component."""
