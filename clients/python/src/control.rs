//! Control requests to a running server, as `sim-server control` sends them.

use std::time::Duration;

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use rusty_contract::RunName;
use rusty_contract::control::ControlRequest;

use crate::errors::exception;

/// Sends a control request, in JSON, and returns the reply in JSON. It is signed with
/// the control key in the folder of the run, which a process in a sandbox cannot read.
#[pyfunction]
fn control(py: Python<'_>, run: &str, request: &str, timeout_s: f64) -> PyResult<String> {
    let argument = |error: &dyn std::fmt::Display| PyValueError::new_err(error.to_string());
    let run: RunName = run.parse().map_err(|e| argument(&e))?;
    let request: ControlRequest = serde_json::from_str(request).map_err(|e| argument(&e))?;
    let timeout = Duration::try_from_secs_f64(timeout_s).map_err(|e| argument(&e))?;
    let reply = py.detach(|| rusty_link::control(&run, request, timeout));
    let reply = reply.map_err(|e| exception(e.into()))?;
    serde_json::to_string(&reply).map_err(|e| argument(&e))
}

/// Adds what sends control requests to the module.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(control, module)?)
}
