//! What Python calls: questions as JSON text in, reports as JSON text out. `tumble/__init__.py` makes objects of them.
//!
//! Every call works in a thread of its own without the interpreter's lock, and this thread looks for signals meanwhile, so that Ctrl-C is
//! answered within a tenth of a second. What was begun goes on in the background until it is done, and its result is dropped.

use pyo3::create_exception;
use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::time::Duration;
use tumble::cli;
use tumble::error::{Fault, Malformed};
use tumble::fit::{Estimator, Remount, RobustMethod, Settings, Weighting};
use tumble::report::html;
use tumble::wire::{self, Source};
use tumble::{Campaign, report};

create_exception!(_tumble, MalformedError, PyValueError, "The question is malformed: what, where, what was expected and what was found.");

/// Between two looks for signals.
const LOOK: Duration = Duration::from_millis(40);
/// What ends sooner than this is not worth a look.
const AT_ONCE: Duration = Duration::from_millis(1);

fn raised(error: Malformed) -> PyErr {
    MalformedError::new_err(error.to_string())
}

/// Work without the lock, looking for signals.
fn interruptible<T: Send + 'static>(
    py: Python<'_>,
    work: impl FnOnce() -> Result<T, Malformed> + Send + 'static,
) -> PyResult<T> {
    let (sender, receiver) = mpsc::channel();
    let spawned = std::thread::Builder::new().name("tumble".into()).stack_size(16 << 20).spawn(move || {
        let _ = sender.send(work());
    });
    spawned.map_err(|error| PyRuntimeError::new_err(format!("no thread to work in: {error}")))?;
    let receiver = std::sync::Mutex::new(receiver);
    let mut wait = AT_ONCE;
    loop {
        let found = py.detach(|| match receiver.lock() {
            Ok(receiver) => receiver.recv_timeout(wait),
            Err(_) => Err(RecvTimeoutError::Disconnected),
        });
        match found {
            Ok(result) => return result.map_err(raised),
            Err(RecvTimeoutError::Timeout) => {
                py.check_signals()?;
                wait = LOOK;
            }
            Err(RecvTimeoutError::Disconnected) => {
                return Err(PyRuntimeError::new_err("the work ended without a result"));
            }
        }
    }
}

/// A campaign from text; what it names is looked for in `folder`.
fn campaign(name: &str, text: String, folder: &Path) -> Result<Campaign, Malformed> {
    let source = Source { name: name.into(), text };
    wire::read_campaign_beside(&source, folder)
}

fn json(value: &impl serde::Serialize) -> Result<String, Malformed> {
    serde_json::to_string(value)
        .map_err(|error| Malformed::new(Fault::Value, format!("the report cannot be written as JSON: {error}")))
}

fn settings(linear: bool, relative: bool, level: f64, robust: Option<&str>, remount: Option<&str>) -> Result<Settings, Malformed> {
    let robust = match robust {
        None => None,
        Some("huber") => Some(RobustMethod::Huber),
        Some("tukey") => Some(RobustMethod::Tukey),
        Some("l1") => Some(RobustMethod::L1),
        Some(other) => {
            return Err(Malformed::new(Fault::Value, "there is no such robust estimator")
                .expected("'huber', 'tukey' or 'l1'")
                .found(other.to_string()));
        }
    };
    let remount = match remount {
        None => Remount::No,
        Some("estimate") => Remount::Estimate,
        Some(u) => Remount::Stated(u.parse().map_err(|_| {
            Malformed::new(Fault::Value, "the standard uncertainty of remounting cannot be used")
                .expected("a positive number in the sensor's unit, or 'estimate'")
                .found(u.to_string())
        })?),
    };
    Ok(Settings {
        estimator: if linear { Estimator::Linear } else { Estimator::Exact },
        weighting: if relative { Weighting::Relative } else { Weighting::AsStated },
        level,
        robust,
        remount,
        ..Settings::default()
    })
}

/// A fit in one form, `report` (JSON), `page` (HTML) or `table` (as the terminal shows it), and whether it is rejected.
#[pyfunction]
#[pyo3(signature = (name, text, folder, linear, relative, level, robust, remount, form))]
#[allow(clippy::too_many_arguments)]
fn fit(
    py: Python<'_>,
    name: String,
    text: String,
    folder: PathBuf,
    linear: bool,
    relative: bool,
    level: f64,
    robust: Option<String>,
    remount: Option<String>,
    form: String,
) -> PyResult<(String, bool)> {
    interruptible(py, move || {
        let campaign = campaign(&name, text.clone(), &folder)?;
        let settings = settings(linear, relative, level, robust.as_deref(), remount.as_deref())?;
        let source = Source { name, text };
        let fit = tumble::fit(&campaign, &settings).map_err(|error| wire::locate(error, &source))?;
        let report = report::fit_report(&fit);
        let fails = report.conformity.as_ref().is_some_and(|conformity| conformity.outcome == tumble::fit::Conformity::Fail);
        let text = match form.as_str() {
            "page" => html::render(&html::fit_page(&fit, &report, None, &[], tumble::language::Language::English)?)?,
            "table" => report::table::fit(&report, false, tumble::language::Language::English),
            _ => json(&report)?,
        };
        Ok((text, fails || fit.is_rejected()))
    })
}

/// The readings of a schedule from a truth, as a campaign.
#[pyfunction]
fn simulate(py: Python<'_>, name: String, text: String, folder: PathBuf, truth: String, seed: u64) -> PyResult<String> {
    interruptible(py, move || {
        let schedule = campaign(&name, text.clone(), &folder)?;
        let source = Source { name, text };
        let truth = wire::read_truth(&Source { name: "truth".into(), text: truth }, &schedule)?;
        let found = tumble::simulate(&schedule, &truth, seed).map_err(|error| wire::locate(error, &source))?;
        json(&wire::campaign_file(&found, wire::bench_ref(&found)))
    })
}

/// A command of the program, as in a shell: exit code, stdout, stderr.
#[pyfunction]
fn run<'py>(py: Python<'py>, arguments: Vec<String>) -> PyResult<(u8, Bound<'py, PyBytes>, String)> {
    let printed = interruptible(py, move || Ok(cli::run_embedded(arguments)))?;
    Ok((printed.exit_code, PyBytes::new(py, &printed.stdout), printed.stderr))
}

#[pymodule]
fn _tumble(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", report::VERSION)?;
    module.add("MalformedError", module.py().get_type::<MalformedError>())?;
    module.add_function(wrap_pyfunction!(fit, module)?)?;
    module.add_function(wrap_pyfunction!(simulate, module)?)?;
    module.add_function(wrap_pyfunction!(run, module)?)
}
