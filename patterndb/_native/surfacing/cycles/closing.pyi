# Bound by rust/python/src/surfacing.rs.
import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Int64Array
from patterndb.geometry.points import Points

def measure_ways(
    end: Int64Array,
    length: NDArray[np.float64],
    first: Int64Array,
    leaving: Int64Array,
    target: int,
    distance: NDArray[np.float64],
    near: Int64Array,
) -> tuple[int, float]:
    """Write the lengths of the shortest ways to a node from the nodes near it, by Dijkstra.

    distance: (n,), inf on entry; written for the nodes that are met, which are listed in near (n,).
    Returns how many were met, and ``farther``: what is longer is not known to be the shortest,
    and no way that is not known is shorter; inf where all that can be reached are known.
    """

def find_closing_paths(
    start: Int64Array,
    end: Int64Array,
    length: NDArray[np.float64],
    first: Int64Array,
    leaving: Int64Array,
    distance: NDArray[np.float64],
    farther: float,
    out: int,
    back: int,
    paths: Int64Array,
    sizes: Int64Array,
    most: int,
) -> tuple[int, bool]:
    """The shortest simple cycles that leave a node by ``out`` and come back along ``back``.

    Both half-curves leave the node, are of two curves and end at two other nodes. Half-curves
    of cycle i in order are written to paths[i, : sizes[i]], shortest first, as many as ``paths``
    has rows. distance, farther: as :func:`measure_ways` has them for the end of ``back``. Returns
    how many there are, and whether ``most`` paths were tried before.

    The remaining distance bounds a path's length from below (A*), so paths come out by length.
    """

def find_flat_polygon(
    start: Int64Array,
    end: Int64Array,
    first: Int64Array,
    leaving: Int64Array,
    tangents: Points,
    out: int,
    back: int,
    path: Int64Array,
) -> int:
    """The polygon in the plane of two half-curves that leave a node, of which ``back`` closes it.

    tangents: (2m, 3) unit vectors along which half-curves leave their nodes. At every node the
    path takes, of those that leave nearly in the plane, the one that turns most to the polygon's
    inside. Half-curves in order are written to path; returns how many there are, 0 if it does not
    close, passes a node twice, is longer than ``path`` or has corners at less than half of its
    nodes: where curves mostly go straight on past others that end there, it is as likely the rim
    of an opening as a lid, such as the ground of a car.
    """
