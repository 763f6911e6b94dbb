//! Chords that split cycles.
