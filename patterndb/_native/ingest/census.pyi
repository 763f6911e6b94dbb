# Bound by rust/python/src/ingest.rs.
from ingest.census import Bench, KernelMesh, UInt64Array
from patterndb.core.halfedge import Int32Array

def new_bench(n_quads: int, n_vertices: int, limit: int) -> Bench:
    """Scratch for patches of at most ``limit`` quads."""

def kernel_mesh(
    twin: Int32Array, vertex: Int32Array, n_vertices: int, zobrist: UInt64Array
) -> KernelMesh:
    """Return what the search reads of a mesh."""
