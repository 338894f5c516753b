//! Exceptions with the program's error messages.

use std::error::Error;

use pyo3::exceptions::PyException;
use pyo3::{PyErr, create_exception};

create_exception!(robofin, RoboFinError, PyException, "Work that failed; the message says what was found.");
create_exception!(
    robofin,
    WrongUse,
    RoboFinError,
    "A call or a file that is refused; the message says what is accepted."
);

/// Returns the exception for an error of the program, with its causes in one line.
pub fn failed(error: &anyhow::Error) -> PyErr {
    let message = robofin::in_full(error);
    if robofin::is_wrong_use(error) { WrongUse::new_err(message) } else { RoboFinError::new_err(message) }
}

/// Returns the exception for an error of a library.
pub fn of(error: impl Error + Send + Sync + 'static) -> PyErr {
    failed(&anyhow::Error::new(error))
}

/// Returns the exception for a refused call.
pub fn refused(message: impl Into<String>) -> PyErr {
    WrongUse::new_err(message.into())
}
