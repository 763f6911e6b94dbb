"""Our methods as the benchmark calls them: loop and spacing in, triangles out."""

from __future__ import annotations

import math
import time
from collections.abc import Callable

import numpy as np
from filling import Filling

from patterndb_sketch.surfacing.chords import ALPHA, AREA_PRICE, decompose
from patterndb_sketch.surfacing.methods import SurfaceRequest, make_smooth
from patterndb_sketch.surfacing.sampling import Loop
from patterndb_sketch.surfacing.tessellation import minimal_area, tessellate_patch


def chords(
    loop: Loop, spacing: float, alpha: float = ALPHA, area_price: float = AREA_PRICE
) -> Filling:
    """Cut along chords that are worth the area they add, every piece relaxed.

    Where the search for chords runs out of its budget, the least area, as everywhere.
    """
    started = time.process_time()
    cut = decompose(loop, alpha, area_price=area_price)
    if cut.exhausted:
        triangles, _ = minimal_area(loop.points)
        seconds = time.process_time() - started
        return Filling(loop.points, triangles, seconds, "search for chords exhausted")
    mesh = tessellate_patch(loop, cut.chords, cut.pieces, spacing)
    seconds = time.process_time() - started
    return Filling(
        np.r_[loop.points, mesh.points], np.concatenate(mesh.faces), seconds, "; ".join(mesh.notes)
    )


def any_chords(loop: Loop, spacing: float) -> Filling:
    """Cut along chords whatever area they add: the paper's way."""
    return chords(loop, spacing, area_price=math.inf)


def whole(loop: Loop, spacing: float) -> Filling:
    """The whole loop as one piece: the linearised Laplacian of the paper's Fig. 2 (c)."""
    started = time.process_time()
    none = np.zeros((0, 2), np.int64)
    mesh = tessellate_patch(loop, none, (np.arange(len(loop.points)),), spacing)
    seconds = time.process_time() - started
    return Filling(np.r_[loop.points, mesh.points], np.concatenate(mesh.faces), seconds)


def area(loop: Loop, spacing: float) -> Filling:
    """The exact triangulation of least area; it needs no spacing."""
    started = time.process_time()
    triangles, _ = minimal_area(loop.points)
    return Filling(loop.points, triangles, time.process_time() - started)


def smooth(loop: Loop, spacing: float) -> Filling:
    """Lay a grid of near parallelograms into the loop; where it crosses itself, chords."""
    started = time.process_time()
    made = make_smooth(loop, SurfaceRequest(), spacing, None)
    seconds = time.process_time() - started
    points = np.r_[loop.points, made.points]
    return Filling(points, np.concatenate(made.faces), seconds, made.note)


#: Our methods by name.
OURS: dict[str, Callable[[Loop, float], Filling]] = {
    "chords": chords,
    "any chords": any_chords,
    "area": area,
    "one piece": whole,
    "smooth": smooth,
}
