//! Fills of patches.
