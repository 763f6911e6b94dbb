//! Fills of boundaries and holes: solving, expansion, ranking.

pub mod expand;
pub mod identity;
