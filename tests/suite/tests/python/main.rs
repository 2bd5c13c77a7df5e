//! The Python package.

mod models;
mod package;
mod sensed;
