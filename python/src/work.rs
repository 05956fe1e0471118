//! Work without the interpreter's lock, which Ctrl-C stops; errors.

use pyo3::create_exception;
use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyType;
use std::sync::Mutex;
use std::sync::mpsc::{self, RecvTimeoutError};
use std::time::Duration;
use tumble::cli;
use tumble::error::Malformed;
use tumble::stop::Stop;

create_exception!(
    tumble,
    MalformedError,
    PyValueError,
    "The question is malformed: what, where, what was expected and what was found."
);

/// Between two looks for signals.
const LOOK: Duration = Duration::from_millis(20);

/// The exception of an error; `text` is what the error is about, where that is no file.
pub fn raised(py: Python<'_>, error: &Malformed, text: Option<&str>) -> PyErr {
    let told = MalformedError::new_err(cli::explain(error, text).trim_end().to_string());
    match describe(py, &told, error) {
        Ok(()) => told,
        Err(other) => other,
    }
}

/// The type of the exception; what an error does not say is None.
pub fn malformed(py: Python<'_>) -> PyResult<Bound<'_, PyType>> {
    let kind = py.get_type::<MalformedError>();
    kind.setattr("what", "")?;
    for part in ["expected", "found", "file", "path", "line", "column"] {
        kind.setattr(part, py.None())?;
    }
    Ok(kind)
}

/// The parts of an error as attributes of its exception.
fn describe(py: Python<'_>, told: &PyErr, error: &Malformed) -> PyResult<()> {
    let place = error.place();
    let known = |number: usize| (number > 0).then_some(number);
    let value = told.value(py);
    value.setattr("what", error.what())?;
    value.setattr("expected", error.expectation())?;
    value.setattr("found", error.finding())?;
    value.setattr("file", Some(&place.file).filter(|name| !name.is_empty()))?;
    value.setattr("path", Some(&place.path).filter(|path| !path.is_empty()))?;
    value.setattr("line", known(place.line))?;
    value.setattr("column", known(place.column))
}

/// Long work in threads of its own, without the lock; this thread looks for signals meanwhile, and stops the work where one raises.
pub fn interruptible<T: Send + 'static>(py: Python<'_>, work: impl FnOnce() -> T + Send + 'static) -> PyResult<T> {
    let (sender, receiver) = mpsc::channel();
    let stop = Stop::default();
    let obeyed = stop.clone();
    let spawned = std::thread::Builder::new().name("tumble".into()).spawn(move || {
        let _ = sender.send(obeyed.run(work));
    });
    spawned.map_err(|error| PyRuntimeError::new_err(format!("no thread to work in: {error}")))?;
    let receiver = Mutex::new(receiver);
    loop {
        let found = py.detach(|| match receiver.lock() {
            Ok(receiver) => receiver.recv_timeout(LOOK),
            Err(_) => Err(RecvTimeoutError::Disconnected),
        });
        match found {
            Ok(Some(result)) => return Ok(result),
            Err(RecvTimeoutError::Timeout) => {
                if let Err(signal) = py.check_signals() {
                    stop.ask();
                    return Err(signal);
                }
            }
            Ok(None) | Err(RecvTimeoutError::Disconnected) => {
                return Err(PyRuntimeError::new_err("the work ended without a result"));
            }
        }
    }
}
