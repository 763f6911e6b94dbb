//! Drawing tools.

pub mod salience;
