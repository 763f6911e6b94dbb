# Bound by rust/python/src/query/holes/assignments.rs.
from patterndb.core.halfedge import Int32Array
from patterndb.geometry.points import Floats

def measure(logs: Floats, due: Int32Array, assignments: Int32Array) -> Floats:
    """"""
