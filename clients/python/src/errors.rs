//! What can go wrong, as Python exceptions.

use pyo3::create_exception;
use pyo3::exceptions::{PyException, PyOSError, PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use rusty_clients::ClientError;
use rusty_contract::output::visible;
use rusty_link::LinkError;

create_exception!(rusty, RustyError, PyException, "What can go wrong with a run or a log.");
create_exception!(rusty, Refused, RustyError, "The server said no, in its own words.");
create_exception!(
    rusty,
    ServerGone,
    RustyError,
    "The server ended without announcing the end of the run."
);
create_exception!(
    rusty,
    Dropped,
    RustyError,
    "The run goes on without this participant, which was too slow or answered what is no answer."
);

/// The exception for an error of the SDK. `OSError` and `ValueError` are
/// Python's own.
pub fn exception(error: ClientError) -> PyErr {
    // An interpreter prints it as it is.
    let text = visible(&error.to_string()).into_owned();
    match error {
        ClientError::Link(LinkError::Refused(_)) => Refused::new_err(text),
        ClientError::Link(LinkError::ServerGone { .. }) => ServerGone::new_err(text),
        ClientError::Link(LinkError::Dropped { .. }) => Dropped::new_err(text),
        ClientError::Answer { .. } | ClientError::Argument(_) => PyValueError::new_err(text),
        ClientError::Io { .. } => PyOSError::new_err(text),
        _ => RustyError::new_err(text),
    }
}

/// The error of a session that another thread uses, or that has ended.
pub fn misused(text: String) -> PyErr {
    PyRuntimeError::new_err(text)
}

/// Adds the exceptions to the module.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    let py = module.py();
    module.add("RustyError", py.get_type::<RustyError>())?;
    module.add("Refused", py.get_type::<Refused>())?;
    module.add("ServerGone", py.get_type::<ServerGone>())?;
    module.add("Dropped", py.get_type::<Dropped>())
}
