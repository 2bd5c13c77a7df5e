//! The Python module `rusty._rusty`: the SDK's session, frames as numpy arrays
//! where they lie.

mod arrays;
mod log;
mod se2;
mod toml;
mod world;

use pyo3::prelude::*;

/// What the package `rusty` is made of; use that.
#[pymodule]
fn _rusty(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add("PROTOCOL_VERSION", rusty_contract::PROTOCOL_VERSION)?;
    module.add("LAYOUT_HASH", rusty_contract::layout::layout_hash())?;
    module.add_class::<se2::PySe2>()?;
    module.add_class::<world::PyWorld>()?;
    module.add_function(wrap_pyfunction!(se2::wrap_angle, module)?)?;
    module.add_function(wrap_pyfunction!(se2::odometry_delta, module)?)?;
    module.add_function(wrap_pyfunction!(log::read_columns, module)?)?;
    module.add_function(wrap_pyfunction!(toml::toml_document, module)?)?;
    module.add_function(wrap_pyfunction!(toml::toml_value, module)?)?;
    Ok(())
}
