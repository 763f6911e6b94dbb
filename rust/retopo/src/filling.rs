//! Fills of patches.

pub mod edgecounts;
