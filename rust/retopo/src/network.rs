//! Networks of drawn curves.
