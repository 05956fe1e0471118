//! One fit.

use crate::question::Question;
use crate::work::{interruptible, raised};
use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyByteArray;
use std::path::PathBuf;
use std::sync::{Arc, OnceLock};
use std::time::Instant;
use tumble::campaign::{Campaign, Kind};
use tumble::document::{html, terminal};
use tumble::error::{Fault, Malformed};
use tumble::fit::{self as engine, Estimator, Remount, RobustMethod, Settings, Weighting};
use tumble::language::Language;
use tumble::report::{self, FitReport};

/// Readings times the square of the unknowns up to which a fit is done before anyone could press Ctrl-C.
const SMALL: usize = 200_000;

/// A fit, with everything that may be asked of it.
#[pyclass(frozen, module = "tumble._tumble")]
pub struct Fit {
    fit: Arc<engine::Fit>,
    monte_carlo: Option<(usize, u64)>,
    report: OnceLock<Arc<FitReport>>,
}

/// A parameter or derived quantity: id, kind, unit, value, u, U, dof, k, state; tilts in arcsec.
type Told =
    (String, &'static str, String, Option<f64>, Option<f64>, Option<f64>, Option<f64>, Option<f64>, &'static str);

#[pymethods]
impl Fit {
    /// Is the answer "rejected", or outside the limits?
    fn rejected(&self) -> bool {
        let fit = &self.fit;
        fit.is_rejected()
            || (!fit.campaign.limits.is_empty()
                && report::conformity(fit).is_some_and(|own| own.outcome == engine::Conformity::Fail))
    }

    /// Estimated parameters and derived quantities, in the campaign's order.
    fn parameters(&self) -> Vec<Told> {
        let told = |id: &str,
                    kind,
                    unit: &str,
                    is_angle,
                    value: Option<f64>,
                    own: Option<tumble::uncertainty::Combined>,
                    state| {
            let (unit, scale) = if is_angle { ("arcsec", report::ARCSEC) } else { (unit, 1.0) };
            let finite = |value: f64| value.is_finite().then_some(value);
            (
                id.to_string(),
                kind,
                unit.to_string(),
                value.map(|value| value * scale),
                own.map(|own| own.u * scale),
                own.map(|own| own.expanded * scale),
                own.and_then(|own| finite(own.dof)),
                own.and_then(|own| finite(own.coverage_factor)),
                state,
            )
        };
        let fit = &self.fit;
        let parameters = fit.parameters.iter().map(|p| {
            let tilt = p.kind == Kind::Tilt;
            told(&p.id, p.kind.name(), &p.unit, tilt, p.value, p.uncertainty, p.state.name())
        });
        let derived = fit
            .derived
            .iter()
            .zip(&fit.campaign.derived)
            .map(|(d, own)| told(&d.id, "derived", &own.unit, d.is_angle, d.value, d.uncertainty, "derived"));
        parameters.chain(derived).collect()
    }

    /// Names of the estimated parameters, in the order of the covariance.
    fn order(&self) -> Vec<&str> {
        self.fit.parameters.iter().map(|p| p.id.as_str()).collect()
    }

    /// The covariance, row by row; NaN where not estimable.
    fn covariance<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyByteArray>> {
        let covariance = &self.fit.covariance;
        let n = covariance.nrows();
        let known = |k: usize| self.fit.parameters.get(k).is_some_and(|p| p.uncertainty.is_some());
        numbers(py, n * n, |k| {
            let (i, j) = (k / n, k % n);
            if known(i) && known(j) { covariance[(i, j)] } else { f64::NAN }
        })
    }

    /// Readings as columns of numbers: index (from 1), value, fitted, residual, redundancy, studentized; and the sensors.
    fn readings<'py>(&self, py: Python<'py>) -> PyResult<(usize, Bound<'py, PyByteArray>, Vec<String>, Vec<String>)> {
        let report = self.made()?;
        let columns: Vec<f64> = report
            .readings
            .iter()
            .flat_map(|own| {
                let or = |value: Option<f64>| value.unwrap_or(f64::NAN);
                [own.index as f64, own.value, own.fitted, own.residual, own.redundancy, or(own.studentized)]
            })
            .collect();
        let bytes = numbers(py, columns.len(), |k| columns.get(k).copied().unwrap_or(f64::NAN))?;
        let sensors = report.readings.iter().map(|own| own.sensor.clone()).collect();
        let positions = report.readings.iter().map(|own| own.position.clone()).collect();
        Ok((report.readings.len(), bytes, sensors, positions))
    }

    /// The report as JSON.
    fn report(&self) -> PyResult<String> {
        serde_json::to_string(&*self.made()?).map_err(|error| PyRuntimeError::new_err(error.to_string()))
    }

    /// The table of the terminal; `listed`: every reading as well.
    fn table(&self, listed: bool, lang: &str) -> PyResult<String> {
        let asked = report::Asked { fit: Some(&self.fit), readings: listed, ..report::Asked::default() };
        Ok(terminal::brief(&report::fit_document(&*self.made()?, &asked, language(lang)?)))
    }

    /// What the model says of further readings, rows of a schedule as JSON: for each sensor its value in every row.
    fn predict<'py>(&self, py: Python<'py>, rows: &str) -> PyResult<Vec<(String, Bound<'py, PyByteArray>)>> {
        let rows = serde_json::from_str(rows).map_err(|error| PyValueError::new_err(error.to_string()))?;
        let found = self.predicted(rows).map_err(|error| raised(py, &error, None))?;
        let sensors = &found.bench.sensors;
        let of = |k: usize| {
            let all = found.readings.rows.iter().flat_map(|row| &row.observations);
            all.filter(|own| own.sensor == k).map(|own| own.value).collect::<Vec<f64>>()
        };
        let bytes = |values: Vec<f64>| numbers(py, values.len(), |k| values.get(k).copied().unwrap_or(f64::NAN));
        sensors.iter().enumerate().map(|(k, sensor)| Ok((sensor.id.clone(), bytes(of(k))?))).collect()
    }

    /// The page.
    fn page(&self, py: Python<'_>, lang: &str) -> PyResult<String> {
        let lang = language(lang)?;
        let asked = report::Asked { fit: Some(&self.fit), ..report::Asked::default() };
        html::render(&report::fit_document(&*self.made()?, &asked, lang)).map_err(|error| raised(py, &error, None))
    }
}

impl Fit {
    /// A schedule with the values of the fitted model.
    fn predicted(&self, rows: Vec<tumble::wire::ReadingFile>) -> Result<Campaign, Malformed> {
        let campaign = &self.fit.campaign;
        let mut schedule = campaign.with_readings(tumble::wire::read_rows(&campaign.bench, rows)?);
        schedule.scatter.clear();
        let mut point = schedule.reference_point();
        for (place, own) in point.iter_mut().zip(&self.fit.parameters) {
            *place = own.value.ok_or_else(|| {
                Malformed::new(Fault::Value, format!("'{}' is not estimable, so nothing can be predicted", own.id))
                    .expected("a fit that determines every parameter")
            })?;
        }
        let noise = vec![tumble::simulate::DrawnNoise::default(); schedule.bench.sensors.len()];
        tumble::simulate(&schedule, &tumble::simulate::Truth { point, noise, effects: vec![], scatter: vec![] }, 0)
    }

    fn made(&self) -> PyResult<Arc<FitReport>> {
        self.reported().map_err(|error| PyValueError::new_err(error.to_string()))
    }

    /// The report, made once. Errors: a number of Monte Carlo trials that cannot be drawn.
    fn reported(&self) -> Result<Arc<FitReport>, Malformed> {
        if let Some(report) = self.report.get() {
            return Ok(report.clone());
        }
        let mut report = report::fit_report(&self.fit);
        if let Some((trials, seed)) = self.monte_carlo {
            let drawn = engine::draw(&self.fit, trials, seed, &|_| {})?;
            report.monte_carlo = drawn.map(|drawn| report::monte_carlo_report(drawn, &self.fit));
        }
        Ok(self.report.get_or_init(|| Arc::new(report)).clone())
    }
}

/// The table of the terminal, of a report as JSON.
#[pyfunction]
pub fn report_table(text: &str, listed: bool, lang: &str) -> PyResult<String> {
    let report: FitReport = serde_json::from_str(text).map_err(|error| PyValueError::new_err(error.to_string()))?;
    let asked = report::Asked { readings: listed, ..report::Asked::default() };
    Ok(terminal::brief(&report::fit_document(&report, &asked, language(lang)?)))
}

/// So many numbers as bytes that numpy takes without a copy.
pub fn numbers<'py>(py: Python<'py>, count: usize, value: impl Fn(usize) -> f64) -> PyResult<Bound<'py, PyByteArray>> {
    PyByteArray::new_with(py, count * size_of::<f64>(), |bytes| {
        for (k, place) in bytes.chunks_exact_mut(size_of::<f64>()).enumerate() {
            place.copy_from_slice(&value(k).to_ne_bytes());
        }
        Ok(())
    })
}

pub fn language(code: &str) -> PyResult<Language> {
    let codes = || Language::ALL.map(|own| format!("'{}'", own.code())).join(" or ");
    Language::of(code).ok_or_else(|| PyValueError::new_err(format!("no language '{code}': expected {}", codes())))
}

/// How to fit, from the arguments of Python.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct Asked {
    linear: bool,
    relative: bool,
    level: f64,
    robust: Option<String>,
    remount: Option<String>,
}

impl Asked {
    pub fn settings(&self) -> Result<Settings, Malformed> {
        let robust = match self.robust.as_deref() {
            None => None,
            Some("huber") => Some(RobustMethod::Huber),
            Some("tukey") => Some(RobustMethod::Tukey),
            Some("l1") => Some(RobustMethod::L1),
            Some(other) => {
                return Err(Malformed::new(Fault::Value, "there is no such robust estimator")
                    .expected("'huber', 'tukey' or 'l1'")
                    .found(format!("'{other}'"))
                    .at_path("robust"));
            }
        };
        let remount = match self.remount.as_deref() {
            None => Remount::No,
            Some("estimate") => Remount::Estimate,
            Some(u) => Remount::Stated(u.parse().map_err(|_| {
                Malformed::new(Fault::Value, "the standard uncertainty of remounting cannot be used")
                    .expected("a positive number in the sensor's unit, or 'estimate'")
                    .found(format!("'{u}'"))
                    .at_path("remount")
            })?),
        };
        Ok(Settings {
            estimator: if self.linear { Estimator::Linear } else { Estimator::Exact },
            weighting: if self.relative { Weighting::Relative } else { Weighting::AsStated },
            level: self.level,
            robust,
            remount,
            ..Settings::default()
        })
    }
}

/// Is this done before anyone could press Ctrl-C?
fn is_small(campaign: &Campaign, settings: &Settings) -> bool {
    let values: usize = campaign.readings.rows.iter().map(|row| row.observations.len()).sum();
    campaign.scatter.is_empty()
        && settings.robust.is_none()
        && matches!(settings.remount, Remount::No)
        && values.saturating_mul(campaign.parameters.len().pow(2)) < SMALL
}

/// Fit one device; `table` takes the place of the campaign's readings, `monte_carlo` is the number of trials and the seed.
#[pyfunction]
#[pyo3(signature = (campaign, name, folder, dumps, table, asked, monte_carlo))]
#[allow(clippy::too_many_arguments)]
pub fn fit<'py>(
    py: Python<'py>,
    campaign: Bound<'py, PyAny>,
    name: String,
    folder: PathBuf,
    dumps: Bound<'py, PyAny>,
    table: Option<Bound<'py, PyAny>>,
    asked: Asked,
    monte_carlo: Option<(usize, u64)>,
) -> PyResult<Fit> {
    let settings = asked.settings().map_err(|error| raised(py, &error, None))?;
    let question = Question::new(campaign, name, folder, dumps);
    let table = table.map(|table| crate::table::columns(&table)).transpose()?;
    if table.is_none()
        && let Some(source) = question.of_rows()?
    {
        let (folder, text) = (question.folder().to_path_buf(), source.clone());
        let fitted = interruptible(py, move || {
            let fit = made(tumble::wire::fit_rows_beside(&text, &folder, &settings)?, monte_carlo);
            if monte_carlo.is_some() {
                fit.reported()?;
            }
            Ok(fit)
        })?;
        return fitted.map_err(|error| question.raised(py, error, Some(&source)));
    }
    let (campaign, source) = question.campaign(table)?;
    let fitted = match is_small(&campaign, &settings) && monte_carlo.is_none() {
        true => py.detach(|| engine::fit_owned(campaign, &settings).map(|fit| made(fit, None))),
        false => interruptible(py, move || {
            let fit = made(engine::fit_owned(campaign, &settings)?, monte_carlo);
            if monte_carlo.is_some() {
                // the trials are drawn here, where they can be stopped
                fit.reported()?;
            }
            Ok(fit)
        })?,
    };
    fitted.map_err(|error| question.raised(py, error, source.as_ref()))
}

fn made(fit: engine::Fit, monte_carlo: Option<(usize, u64)>) -> Fit {
    Fit { fit: Arc::new(fit), monte_carlo, report: OnceLock::new() }
}

/// Seconds that the engine alone takes for a fit of a campaign, the least of so many rounds of ten: for benchmarks.
#[pyfunction]
pub fn engine_seconds(
    py: Python<'_>,
    campaign: Bound<'_, PyAny>,
    folder: PathBuf,
    dumps: Bound<'_, PyAny>,
    rounds: usize,
) -> PyResult<f64> {
    let (campaign, _) = Question::new(campaign, "campaign".into(), folder, dumps).campaign(None)?;
    let settings = Settings::default();
    let mut least = f64::INFINITY;
    for _ in 0..rounds {
        let begun = Instant::now();
        for _ in 0..10 {
            let fit = tumble::fit(&campaign, &settings).map_err(|error| raised(py, &error, None))?;
            std::hint::black_box(fit);
        }
        least = least.min(begun.elapsed().as_secs_f64() / 10.0);
    }
    Ok(least)
}
