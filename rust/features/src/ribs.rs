//! Ribs: the curves in which planes cut a surface.
