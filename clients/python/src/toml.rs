//! What Python has as a dictionary, as TOML: for scenarios written in a script.

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

/// A JSON object as a TOML document.
#[pyfunction]
fn toml_document(json: &str) -> PyResult<String> {
    toml::to_string(&read(json)?).map_err(|e| PyValueError::new_err(e.to_string()))
}

/// A JSON value as TOML has it behind a `=`.
#[pyfunction]
fn toml_value(json: &str) -> PyResult<String> {
    Ok(read(json)?.to_string())
}

/// A TOML document as a JSON object.
#[pyfunction]
fn toml_json(toml: &str) -> PyResult<String> {
    let table: toml::Table =
        toml::from_str(toml).map_err(|e| PyValueError::new_err(format!("invalid TOML: {e}")))?;
    serde_json::to_string(&table).map_err(|e| PyValueError::new_err(e.to_string()))
}

fn read(json: &str) -> PyResult<toml::Value> {
    serde_json::from_str(json).map_err(|e| {
        let remedy = "TOML has no null and no integer beyond 64 bits with a sign";
        PyValueError::new_err(format!("cannot be written as TOML: {e}; {remedy}"))
    })
}

/// Adds what reads and writes TOML to the module.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(toml_document, module)?)?;
    module.add_function(wrap_pyfunction!(toml_value, module)?)?;
    module.add_function(wrap_pyfunction!(toml_json, module)?)
}
