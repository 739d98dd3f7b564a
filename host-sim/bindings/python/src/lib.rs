//! Palpate from Python: presses and haptic sessions, with arrays of `NumPy`.
//!
//! ```text
//! Python: Session.tick, session_many ─ session ─ palpate_loop::haptic_session ─ force
//!         press, press_many ─ press ─ palpate_tissue::press ─ arrays
//! ```

mod press;
mod session;

use std::fmt::Display;

use pyo3::create_exception;
use pyo3::exceptions::PyException;
use pyo3::prelude::{PyErr, pymodule};

create_exception!(palpate, PalpateError, PyException, "Bad input or a call out of order: what, where, and how to fix it.");

/// An error of the library as an exception of one line.
fn raised(error: &impl Display) -> PyErr {
    PalpateError::new_err(error.to_string().replace(char::is_control, " "))
}

/// The module `palpate._native`.
#[pymodule]
mod _native {
    #[pymodule_export]
    use crate::PalpateError;
    #[pymodule_export]
    use crate::press::{press, press_many};
    #[pymodule_export]
    use crate::session::{Session, session_many};
}
