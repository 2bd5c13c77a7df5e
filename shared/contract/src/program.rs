//! `Program`: a program that the one binary of the laboratory contains.

use crate::Exit;

/// A program as its package gives it to the binary.
#[derive(Clone, Copy, Debug)]
pub struct Program {
    /// Name by which the binary is started as this program.
    pub name: &'static str,
    /// Purpose, as a line of a list.
    pub purpose: &'static str,
    /// Its `main`.
    pub main: fn() -> Exit,
}

impl Program {
    /// Creates the entry of a program.
    #[must_use]
    pub const fn new(name: &'static str, purpose: &'static str, main: fn() -> Exit) -> Self {
        Self { name, purpose, main }
    }
}
