//! The Python package.

mod gym;
mod models;
mod package;
mod ros2;
mod ros2_bytes;
mod sensed;
mod sweeps;
