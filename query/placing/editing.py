"""Laplacian editing: strands are pulled onto their strokes, and the fill follows softly.

Source: Sorkine et al. 2004, "Laplacian Surface Editing", as Marcias et al. 2015 use it
(section 4, "Deformation"). Differs from the paper: Laplacian coordinates are kept as they
are, without local similarity transforms. A fill at rest has none along its surface, so
that there is nothing to turn, and those across it come back with the projection; it is done
in rounds, each keeping the coordinates of the one before.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from scipy.sparse import csc_array, vstack
from scipy.sparse.linalg import splu

from patterndb.geometry.neighbours import Neighbours
from patterndb.geometry.points import Points
from query.placing.flow import Following

#: What a midpoint's distance from its target weighs against a vertex's distance from the mean
#: of its neighbours: so much that strands lie on their strokes, and bend softly beside them.
PULL = 3.0

#: Rounds of pulling and projecting, at most.
ROUNDS = 12

#: A round that moves nothing further than this part of the diagonal is the last.
AT_REST = 1e-4


def pulled(
    beside: Neighbours,
    vertices: Points,
    perimeter: int,
    followed: Sequence[Following],
    project: Callable[[Points, Points], Points],
) -> Points:
    """(v, 3) the vertices with every strand's midpoints near their targets.

    followed: strands and targets; boundary vertices, and so the ends of open strands, stay.
    project: takes (v, 3) vertices before and after a round to the surface; the boundary's
    are put back anyway.
    """
    p, v = perimeter, len(vertices)
    edges = np.concatenate([one.edges for one in followed])
    targets = np.concatenate([one.targets for one in followed])
    held = (edges >= p).any(axis=1)
    edges, targets = edges[held], targets[held]
    if v == p or len(edges) == 0:
        return vertices
    degree = np.diff(beside.start)
    row = np.repeat(np.arange(v), degree)
    laplacian = csc_array(
        (
            np.r_[np.ones(v), -1.0 / degree[row]],
            (np.r_[np.arange(v), row], np.r_[np.arange(v), beside.neighbour]),
        ),
        shape=(v, v),
    )[p:, p:]
    count = np.arange(len(edges))
    middle = csc_array(
        (np.full(2 * len(edges), 0.5), (np.r_[count, count], edges.T.ravel())),
        shape=(len(edges), v),
    )
    system: Any = vstack([laplacian, PULL * middle[:, p:]], format="csc")
    factor = splu((system.T @ system).tocsc())
    diagonal = float(np.linalg.norm(np.ptp(vertices, axis=0)))
    at = vertices
    for _ in range(ROUNDS):
        wanted = PULL * (targets - at[edges].mean(axis=1))
        right = np.concatenate([np.zeros((v - p, 3)), wanted])
        moved = at.copy()
        moved[p:] += factor.solve(system.T @ right)
        moved = project(at, moved)
        moved[:p] = vertices[:p]
        largest = float(np.linalg.norm(moved - at, axis=1).max())
        at = moved
        if largest < AT_REST * diagonal:
            break
    return at
