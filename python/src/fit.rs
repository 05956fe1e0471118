//! One fit.

use crate::question::Question;
use crate::table::{self, Columns};
use crate::work::{interruptible, raised};
use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyByteArray;
use std::collections::{BTreeMap, HashSet};
use std::path::PathBuf;
use std::sync::{Arc, OnceLock};
use std::time::Instant;
use tumble::campaign::{Campaign, Kind};
use tumble::document::{html, terminal};
use tumble::error::{Fault, Malformed};
use tumble::fit::{self as engine, Estimator, Remount, RobustMethod, Settings, Weighting};
use tumble::language::Language;
use tumble::record::{Cells, Record};
use tumble::report::{self, FitReport};
use tumble::wire::{self, Named};

/// Readings times the square of the unknowns up to which a fit is done before anyone could press Ctrl-C.
const SMALL: usize = 200_000;

/// The title of a column that no model line reads.
const NO_COLUMN: &str = "row #";

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
        let report = self.made(py)?;
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
    fn report(&self, py: Python<'_>) -> PyResult<String> {
        let report = self.made(py)?;
        py.detach(|| json(&report))
    }

    /// The report as JSON without its readings.
    fn summary(&self, py: Python<'_>) -> PyResult<String> {
        py.detach(|| json(&report::fit_summary(&self.fit)))
    }

    /// The table of the terminal; `listed`: every reading as well.
    fn table(&self, py: Python<'_>, listed: bool, lang: &str) -> PyResult<String> {
        let (lang, report) = (language(lang)?, self.made(py)?);
        let asked = report::Asked { fit: Some(&self.fit), readings: listed, ..report::Asked::default() };
        Ok(py.detach(|| terminal::brief(&report::fit_document(&report, &asked, lang))))
    }

    /// What the model says of further readings, a table with the columns that the model reads, some under the titles of the
    /// campaign's map: for each sensor its value in every row, NaN where a
    /// cell that it needs is empty.
    fn predict<'py>(
        &self,
        py: Python<'py>,
        table: Bound<'py, PyAny>,
        titles: BTreeMap<String, String>,
    ) -> PyResult<Vec<(String, Bound<'py, PyByteArray>)>> {
        let columns = table::columns(&table)?;
        let rows = columns.first().map_or(0, |(_, cells)| table::length(cells));
        let (found, lacking) =
            py.detach(|| self.predicted(columns, titles, rows)).map_err(|error| raised(py, &error, None))?;
        let sensors = self.fit.campaign.bench.sensors.iter().enumerate();
        let values = |sensor: usize| {
            let all = found.iter().flat_map(|found| &found.readings.rows).flat_map(|row| &row.observations);
            let known = all.filter(|own| own.sensor == sensor).map(|own| own.value).enumerate();
            known.map(|(row, value)| if lacking.contains(&row) { f64::NAN } else { value }).collect::<Vec<f64>>()
        };
        let bytes = |values: Vec<f64>| numbers(py, rows, |k| values.get(k).copied().unwrap_or(f64::NAN));
        sensors.map(|(k, sensor)| Ok((sensor.id.clone(), bytes(values(k))?))).collect()
    }

    /// The page.
    fn page(&self, py: Python<'_>, lang: &str) -> PyResult<String> {
        let lang = language(lang)?;
        let (asked, report) = (report::Asked { fit: Some(&self.fit), ..report::Asked::default() }, self.made(py)?);
        let page = py.detach(|| html::render(&report::fit_document(&report, &asked, lang)));
        page.map_err(|error| raised(py, &error, None))
    }
}

impl Fit {
    /// A schedule with the values of the fitted model (none where no row is whole), and the rows that lack something that the model reads, whose values
    /// mean nothing.
    fn predicted(
        &self,
        columns: Columns,
        map: BTreeMap<String, String>,
        rows: usize,
    ) -> Result<(Option<Campaign>, HashSet<usize>), Malformed> {
        let campaign = &self.fit.campaign;
        let bench = &campaign.bench;
        let nothing = columns.iter().map(|(title, _)| (title.clone(), Cells::Numbers(Vec::new()))).collect();
        let titles = Record::from(table::held("readings", nothing)?);
        // the sensors' columns need not be there
        let there = |wanted: &String| titles.columns().iter().any(|own| own.title == *wanted || own.name == *wanted);
        let map = Named(map.into_iter().filter(|(_, wanted)| there(wanted)).collect());
        let layout = wire::table_layout(bench, &titles, None, &map, |_| false)?;
        let read = layout.numeric(bench);
        let (keys, mut used): (Vec<&String>, Columns) = layout
            .keys
            .iter()
            .zip(&layout.columns)
            .filter(|(key, _)| read.contains(key))
            .filter_map(|(key, place)| Some((key, columns.get(*place)?.clone())))
            .unzip();
        // an angle may be missing beside a rate: a joint lacks what it needs where all of its columns are empty
        let is_of = |key: &str, joint: &str| matches!(key.strip_prefix(joint), Some("_deg" | "_deg_s" | "_turns"));
        let mut groups: BTreeMap<&str, Vec<usize>> = BTreeMap::new();
        for (k, key) in keys.iter().enumerate() {
            groups.entry(bench.joints().find(|joint| is_of(key, joint)).unwrap_or(key)).or_default().push(k);
        }
        let is_gap = |row: usize, group: &[usize]| {
            group.iter().all(|k| used.get(*k).is_none_or(|(_, cells)| table::is_empty(cells, row)))
        };
        let gaps: Vec<(usize, &Vec<usize>)> = (0..rows)
            .flat_map(|row| groups.values().map(move |group| (row, group)))
            .filter(|(row, group)| is_gap(*row, group))
            .collect();
        let lacking: HashSet<usize> = gaps.iter().map(|(row, _)| *row).collect();
        let Some(whole) = (0..rows).find(|row| !lacking.contains(row)) else { return Ok((None, lacking)) };
        // a gap is filled, so that times count from the first row
        for (row, k) in gaps.into_iter().flat_map(|(row, group)| group.iter().map(move |k| (row, *k))) {
            used.iter_mut().skip(k).take(1).for_each(|(_, cells)| table::copy(cells, whole, row));
        }
        // a model may read no column at all
        used.push((NO_COLUMN.into(), Cells::Numbers(vec![0.0; rows])));
        let map = Named(map.0.into_iter().filter(|(key, _)| read.contains(key)).collect());
        let readings = wire::read_readings(bench, Record::from(table::held("readings", used)?), &map, &[])?;
        let mut schedule = campaign.with_readings(readings);
        schedule.scatter.clear();
        let mut point = schedule.reference_point();
        for (place, own) in point.iter_mut().zip(&self.fit.parameters) {
            *place = own.value.ok_or_else(|| {
                Malformed::new(Fault::Value, format!("'{}' is not estimable, so nothing can be predicted", own.id))
                    .expected("a fit that determines every parameter")
            })?;
        }
        let noise = vec![tumble::simulate::DrawnNoise::default(); schedule.bench.sensors.len()];
        let truth = tumble::simulate::Truth { point, noise, effects: vec![], scatter: vec![] };
        Ok((Some(tumble::simulate(&schedule, &truth, 0)?), lacking))
    }

    fn made(&self, py: Python<'_>) -> PyResult<Arc<FitReport>> {
        py.detach(|| self.reported()).map_err(|error| PyValueError::new_err(error.to_string()))
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

fn json(report: &FitReport) -> PyResult<String> {
    serde_json::to_string(report).map_err(|error| PyRuntimeError::new_err(error.to_string()))
}

/// The document of a report as JSON.
fn document(text: &str, readings: bool, lang: &str) -> PyResult<tumble::document::Document> {
    let report: FitReport = serde_json::from_str(text).map_err(|error| PyValueError::new_err(error.to_string()))?;
    Ok(report::fit_document(&report, &report::Asked { readings, ..report::Asked::default() }, language(lang)?))
}

/// The table of the terminal, of a report as JSON.
#[pyfunction]
pub fn report_table(text: &str, listed: bool, lang: &str) -> PyResult<String> {
    Ok(terminal::brief(&document(text, listed, lang)?))
}

/// The page of a report as JSON.
#[pyfunction]
pub fn report_page(py: Python<'_>, text: &str, lang: &str) -> PyResult<String> {
    html::render(&document(text, false, lang)?).map_err(|error| raised(py, &error, None))
}

/// Student's two-sided quantile at a level.
#[pyfunction]
pub fn coverage_factor(level: f64, dof: f64) -> Option<f64> {
    tumble::uncertainty::quantiles::coverage_factor(level, dof)
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
