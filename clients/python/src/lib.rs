//! The Python module `rusty._rusty`: the SDK's session, frames as numpy arrays
//! where they lie.

mod errors;
mod gate;
mod session;
mod start;
mod tick;

use pyo3::prelude::*;

/// What the package `rusty` is made of; use that.
#[pymodule]
fn _rusty(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add("PROTOCOL_VERSION", rusty_contract::PROTOCOL_VERSION)?;
    module.add("LAYOUT_HASH", rusty_contract::layout::layout_hash())?;
    errors::register(module)?;
    start::register(module)?;
    session::register(module)
}
