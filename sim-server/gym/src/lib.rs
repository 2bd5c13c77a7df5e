//! The Python module `rusty._gym`: worlds in the process of a Python program, stepped
//! together, with the bits of a run that has the same seed and commands.
//!
//! In reading order:
//!
//! * `layout`: the numbers of an observation;
//! * `lane`: one world, and what was seen of it last;
//! * `worlds`: many worlds, and the arrays that they are written to.

mod lane;
mod layout;
mod worlds;

use pyo3::prelude::*;

/// The native half of the package `rusty.gym`; use that.
#[pymodule]
fn _gym(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<worlds::Worlds>()
}
