//! Drafts of quads over a surface.
