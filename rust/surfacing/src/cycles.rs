//! Cycles of curves that bound patches.
