//! Counts of edges.
