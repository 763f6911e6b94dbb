//! Joints of curves that nearly meet.
