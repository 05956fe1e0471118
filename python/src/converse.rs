//! A command that is spoken with line by line.

use crate::work::raised;
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use std::sync::Mutex;
use std::sync::mpsc::{self, Receiver, RecvTimeoutError, Sender};
use std::thread::JoinHandle;
use std::time::Duration;
use tumble::cli::{self, Printed};
use tumble::report::GuideReport;
use tumble::stop::Stop;

/// Between two looks for signals.
const LOOK: Duration = Duration::from_millis(20);

/// A command in a thread of its own, which reads the lines that it is told, and whose lines of standard output are answers. It ends with this.
#[pyclass]
pub struct Conversation {
    input: Option<Sender<String>>,
    output: Mutex<Receiver<String>>,
    rest: String,
    thread: Option<JoinHandle<Option<Printed>>>,
    stop: Stop,
    exit_code: Option<u8>,
}

impl Drop for Conversation {
    fn drop(&mut self) {
        self.stop.ask();
    }
}

#[pymethods]
impl Conversation {
    #[new]
    fn new(arguments: Vec<String>) -> PyResult<Self> {
        let (input, heard) = mpsc::channel();
        let (said, output) = mpsc::channel();
        let stop = Stop::default();
        let obeyed = stop.clone();
        let spawned = std::thread::Builder::new().name("tumble".into());
        let thread = spawned
            .spawn(move || obeyed.run(|| cli::converse(arguments, heard, said)))
            .map_err(|error| PyRuntimeError::new_err(format!("no thread to work in: {error}")))?;
        let (output, thread) = (Mutex::new(output), Some(thread));
        Ok(Conversation { input: Some(input), output, rest: String::new(), thread, stop, exit_code: None })
    }

    /// A line for the command; it is lost where the command has ended.
    fn say(&self, line: String) {
        if let Some(input) = &self.input {
            let _ = input.send(line);
        }
    }

    /// No more lines follow.
    fn close(&mut self) {
        self.input = None;
    }

    /// Stop it where it is: no line that it has not said yet follows.
    fn stop(&self) {
        self.stop.ask();
    }

    /// The next line of the command; None at its end. A malformed question is an exception.
    fn next_line(&mut self, py: Python<'_>) -> PyResult<Option<String>> {
        loop {
            if let Some((line, rest)) = self.rest.split_once('\n') {
                let line = line.to_string();
                self.rest = rest.to_string();
                return Ok(Some(line));
            }
            let output = &self.output;
            let found = py.detach(|| match output.lock() {
                Ok(output) => output.recv_timeout(LOOK),
                Err(_) => Err(RecvTimeoutError::Disconnected),
            });
            match found {
                Ok(text) => self.rest.push_str(&text),
                Err(RecvTimeoutError::Timeout) => py.check_signals()?,
                Err(RecvTimeoutError::Disconnected) => break,
            }
        }
        let Some(thread) = self.thread.take() else { return Ok(None) };
        let printed =
            py.detach(|| thread.join()).map_err(|_| PyRuntimeError::new_err("the work ended without a result"))?;
        let Some(printed) = printed else { return Ok(None) };
        self.exit_code = Some(printed.exit_code);
        match (&printed.error, printed.exit_code) {
            (Some(error), _) => Err(raised(py, error, None)),
            // a wrong option
            (None, 1) => Err(crate::work::MalformedError::new_err(printed.stderr.trim_end().to_string())),
            _ => Ok(None),
        }
    }

    /// How it ended, once it has.
    #[getter]
    fn exit_code(&self) -> Option<u8> {
        self.exit_code
    }
}

/// What a line of a guide says to a person.
#[pyfunction]
pub fn guide_text(line: &str) -> PyResult<String> {
    let report: GuideReport = serde_json::from_str(line).map_err(|error| PyRuntimeError::new_err(error.to_string()))?;
    Ok(cli::guide_text(&report))
}
