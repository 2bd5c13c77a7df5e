//! The Python module `rusty._rusty`: the SDK's session, frames as numpy arrays
//! where they lie, and the plane for models: poses, walls, rays.

mod arrays;
mod beams;
mod control;
mod errors;
mod gate;
mod log;
mod meanwhile;
mod se2;
mod session;
mod start;
mod tick;
mod toml;
mod world;

use pyo3::prelude::*;

/// What the package `rusty` is made of; use that.
#[pymodule]
fn _rusty(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add("PROTOCOL_VERSION", rusty_contract::PROTOCOL_VERSION)?;
    module.add("LAYOUT_HASH", rusty_contract::layout::layout_hash())?;
    errors::register(module)?;
    start::register(module)?;
    session::register(module)?;
    se2::register(module)?;
    world::register(module)?;
    log::register(module)?;
    toml::register(module)?;
    control::register(module)
}
