# Bound by rust/python/src/retopo.rs.
from patterndb.core.halfedge import Int32Array
from patterndb_sketch.retopo.counts.cycles import CycleGraph

def judge_patches(graph: CycleGraph, lengths: Int32Array, patches: Int32Array) -> None:
    """Write what patches are, and would be, by :func:`~.problem.has_regular_fill`.

    lengths: (s,) int32 of all sides; left as they are.
    """

def find_walk(
    graph: CycleGraph,
    starts: Int32Array,
    begin: int,
    most_steps: int,
    regularity: float,
    walk: Int32Array,
) -> tuple[int, int, float]:
    """Find the first walk that gains, from any of the halves ``starts``, from place begin on.

    walk: (w, 2) int32 with w > most_steps + 1, gets chains and their changes. Returns how many
    there are, 0 where no walk gains; the place of the start looked at last; and the gain.
    """
