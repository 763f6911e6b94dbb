//! Drawing tools.
