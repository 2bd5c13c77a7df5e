//! The Python package.

mod models;
mod package;
mod ros2;
mod sensed;
