//! Enumeration of the patches of quad meshes.
//!
//! Modules have the names of the Python modules that call them; nothing here reads files, starts
//! threads or looks at a clock.

pub mod basic;
pub mod census;
pub mod collapse;
pub mod growth;
pub mod hashing;
pub mod learning;
pub mod prepare;
pub mod pulse;
pub mod shards;
#[cfg(test)]
mod testing;
