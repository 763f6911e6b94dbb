//! The fishbone of strokes.
