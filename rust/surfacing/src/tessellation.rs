//! Triangles and quads of patches.
