//! Triangle surfaces and points on them.
