//! Joints of curves that nearly meet.

pub mod meetings;
pub mod survey;
