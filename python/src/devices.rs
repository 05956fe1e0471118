//! Many devices: arrays or tables in, arrays out.

use crate::fit::{Asked, language, numbers};
use crate::question::Question;
use crate::table::{self, Columns};
use crate::work::{interruptible, raised};
use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyByteArray, PyBytes};
use std::path::PathBuf;
use std::time::Instant;
use tumble::batch::{self, Device, Fleet, Layout, Row, Schedules, Summary, Tables, Use};
use tumble::bench::Bench;
use tumble::campaign::{Campaign, Kind, Readings};
use tumble::document::{html, terminal};
use tumble::error::{Fault, Malformed};
use tumble::fit::{Conformity, Settings};
use tumble::record::{Column, Record};
use tumble::report;
use tumble::wire::{self, CampaignFile, Cell, ReadingFile, ReadingsRef};

/// Devices that are fitted between two looks for a request to stop.
const TOGETHER: usize = 1 << 13;
/// The key of a column that tells devices apart where nobody gave one; no model line can have it.
const NOBODY: &str = "device #";

/// Rows of many devices.
#[pyclass(frozen, module = "tumble._tumble")]
pub struct Devices {
    rows: Vec<Row>,
    template: Campaign,
    settings: Settings,
    by: String,
}

#[pymethods]
impl Devices {
    fn __len__(&self) -> usize {
        self.rows.len()
    }

    /// Name and unit of each quantity: estimated parameters, then derived quantities; tilts in arcsec.
    fn quantities(&self) -> Vec<(String, String)> {
        let angle = self.angles();
        let named = report::batch_quantities(&self.template).into_iter().zip(angle);
        named.map(|((id, unit), angle)| (id, if angle { "arcsec".into() } else { unit })).collect()
    }

    /// A matrix, a row for each device: `value`, `u`, `U` or `type_a`.
    fn matrix<'py>(&self, py: Python<'py>, of: &str) -> PyResult<Bound<'py, PyByteArray>> {
        let scale: Vec<f64> = self.angles().iter().map(|angle| if *angle { report::ARCSEC } else { 1.0 }).collect();
        let own: fn(&Row) -> &[f64] = match of {
            "value" => |row| &row.value,
            "u" => |row| &row.u,
            "U" => |row| &row.expanded,
            "type_a" => |row| &row.type_a,
            _ => return Err(PyValueError::new_err(format!("there is no matrix '{of}'"))),
        };
        let count = scale.len();
        PyByteArray::new_with(py, self.rows.len() * count * size_of::<f64>(), |bytes| {
            for (row, places) in self.rows.iter().zip(bytes.chunks_exact_mut(count.max(1) * size_of::<f64>())) {
                for ((place, value), scale) in places.chunks_exact_mut(size_of::<f64>()).zip(own(row)).zip(&scale) {
                    place.copy_from_slice(&(value * scale).to_ne_bytes());
                }
            }
            Ok(())
        })
    }

    /// A number for each device: `residual_sd`, `chi_square_p`, `lack_of_fit_p`, `runs_p`, `normality_p`, `dof`, `rank`, `readings`.
    fn column<'py>(&self, py: Python<'py>, of: &str) -> PyResult<Bound<'py, PyByteArray>> {
        let own: fn(&Row) -> f64 = match of {
            "residual_sd" => |row| row.residual_sd,
            "chi_square_p" => |row| row.chi_square_p,
            "lack_of_fit_p" => |row| row.lack_of_fit_p,
            "runs_p" => |row| row.runs_p,
            "normality_p" => |row| row.normality_p,
            "dof" => |row| row.dof as f64,
            "rank" => |row| row.rank as f64,
            "readings" => |row| row.readings as f64,
            _ => return Err(PyValueError::new_err(format!("there is no column '{of}'"))),
        };
        numbers(py, self.rows.len(), |k| self.rows.get(k).map_or(f64::NAN, own))
    }

    /// The verdict of each device: 0 accepted, 1 rejected, 2 malformed; then its conformity: 0 pass, 1 undecided, 2 fail, 255 no limits.
    fn verdicts<'py>(&self, py: Python<'py>) -> (Bound<'py, PyBytes>, Bound<'py, PyBytes>) {
        let verdicts: Vec<u8> = self
            .rows
            .iter()
            .map(|row| match row.verdict {
                batch::Verdict::Accepted => 0,
                batch::Verdict::Rejected => 1,
                _ => 2,
            })
            .collect();
        let conformity: Vec<u8> = self
            .rows
            .iter()
            .map(|row| match row.conformity {
                Some(Conformity::Pass) => 0,
                Some(Conformity::Undecided) => 1,
                Some(_) => 2,
                None => u8::MAX,
            })
            .collect();
        (PyBytes::new(py, &verdicts), PyBytes::new(py, &conformity))
    }

    /// Labels in order.
    fn labels(&self) -> Vec<&str> {
        self.rows.iter().map(|row| row.label.as_str()).collect()
    }

    /// What is wrong or suspicious, in words, of the devices of which there is something to say.
    fn why(&self) -> Vec<(usize, &str)> {
        let rows = self.rows.iter().enumerate().filter(|(_, row)| !row.why.is_empty());
        rows.map(|(k, row)| (k, row.why.as_str())).collect()
    }

    /// The summary as JSON.
    fn report(&self, py: Python<'_>) -> PyResult<String> {
        let report = py.detach(|| serde_json::to_string(&self.summed()));
        report.map_err(|error| PyRuntimeError::new_err(error.to_string()))
    }

    /// The summary as the program prints it; `rows`: so many devices as well.
    fn table(&self, py: Python<'_>, rows: usize, lang: &str) -> PyResult<String> {
        let lang = language(lang)?;
        let shown = self.rows.get(..rows.min(self.rows.len())).unwrap_or_default();
        let rows = match shown {
            [] => String::new(),
            shown => report::batch_rows(&self.template, &self.by, shown, lang) + "\n",
        };
        let document = py.detach(|| report::batch_document(&self.summed(), None, &Default::default(), lang));
        Ok(rows + &terminal::brief(&document))
    }

    /// The page.
    fn page(&self, py: Python<'_>, lang: &str) -> PyResult<String> {
        let lang = language(lang)?;
        let page = py.detach(|| {
            let fitted = Some((&self.template, &self.summary()));
            html::render(&report::batch_document(&self.summed(), fitted, &Default::default(), lang))
        });
        page.map_err(|error| raised(py, &error, None))
    }
}

impl Devices {
    /// Which quantities are angles, which people want in arcseconds.
    fn angles(&self) -> Vec<bool> {
        let parameters = self.template.estimated().iter().map(|p| p.kind == Kind::Tilt).collect::<Vec<_>>();
        let derived = self.template.derived.iter().map(|d| d.unit == "rad");
        parameters.into_iter().chain(derived).chain(self.template.limited_errors().iter().map(|_| false)).collect()
    }

    fn summary(&self) -> Summary {
        let mut summary = Summary::new(self.angles().len());
        self.rows.iter().for_each(|row| summary.add(row));
        summary
    }

    fn summed(&self) -> report::BatchReport {
        report::batch_report(&self.template, &self.settings, &self.by, &self.summary())
    }
}

/// What is asked of each device: the campaign but its readings.
struct Asking {
    file: CampaignFile,
    template: Campaign,
    settings: Settings,
    quantities: usize,
}

impl Asking {
    fn new(file: CampaignFile, template: Campaign, settings: Settings) -> tumble::Result<Self> {
        if !(settings.level > 0.0 && settings.level < 1.0) {
            return Err(Malformed::new(Fault::Value, "the level is not a probability")
                .expected("a number between 0 and 1, for example 0.95")
                .found(settings.level.to_string()));
        }
        let quantities = report::batch_quantities(&template).len();
        Ok(Asking { file, template, settings, quantities })
    }

    /// The campaign of a device.
    fn of(&self, layout: &Layout, device: &Device) -> tumble::Result<Campaign> {
        let readings = wire::device_readings(&self.template.bench, layout, device)?;
        let plain = self.file.scatter.is_empty() && layout.uses.iter().all(|kind| *kind != Use::Other);
        let own_lines = readings.columns.iter().any(|column| column.ends_with("_u"));
        match plain && !own_lines && readings.columns == self.template.readings.columns {
            true => Ok(self.template.with_readings(readings)),
            false => self.file.clone().with(self.template.bench.clone(), readings),
        }
    }

    fn fit(&self, devices: &[Device], layout: &Layout, known: &mut Schedules) -> Vec<Row> {
        let of = |device: &Device| self.of(layout, device);
        let mut fleet = Fleet::with(&of, self.settings, self.quantities, std::mem::take(known));
        let rows = fleet.fit(devices, layout);
        *known = fleet.into_schedules();
        rows
    }

    fn answered(self, rows: Vec<Row>, by: &str) -> Devices {
        Devices { rows, template: self.template, settings: self.settings, by: by.into() }
    }
}

/// Is a column that the model does not use needed for what scatters?
fn is_wanted(file: &CampaignFile, key: &str) -> bool {
    tumble::campaign::ScatterRequest::use_key(&file.scatter, key)
        || (key == "position" && !file.scatter.is_empty())
        || key.ends_with("_u")
}

/// One schedule, and the values of many devices on it.
struct Arrays {
    asking: Asking,
    layout: Layout,
    /// The schedule's own row.
    device: Device,
    /// For each sensor of the layout: values, device after device.
    values: Vec<Vec<f64>>,
    devices: usize,
    labels: Option<Vec<String>>,
}

impl Arrays {
    fn device(&self, k: usize) -> Device {
        let rows = self.device.rows;
        let values = match self.values.as_slice() {
            [own] => own.get(k * rows..(k + 1) * rows).unwrap_or_default().to_vec(),
            several => (0..rows)
                .flat_map(|row| several.iter().map(move |own| own.get(k * rows + row).copied().unwrap_or(f64::NAN)))
                .collect(),
        };
        let label = self.labels.as_ref().and_then(|labels| labels.get(k).cloned());
        Device {
            label: label.unwrap_or_else(|| k.to_string()),
            inputs: self.device.inputs.clone(),
            values,
            others: self.device.others.clone(),
            rows,
            first_row: (k * rows) as u64 + 1,
            ..Device::default()
        }
    }

    /// The question of Python: a schedule, and `(sensor, array)` for each sensor that is read.
    fn read(
        question: &Question<'_>,
        values: &[(String, Bound<'_, PyAny>)],
        labels: Option<Vec<String>>,
        settings: Settings,
    ) -> PyResult<Self> {
        let (campaign, _) = question.campaign(None)?;
        let bench = campaign.bench.clone();
        let mut file = wire::campaign_file(&campaign, wire::bench_ref(&campaign));
        let ReadingsRef::Inline(rows) = std::mem::replace(&mut file.readings, ReadingsRef::Inline(Vec::new())) else {
            return Err(PyValueError::new_err("the schedule has no readings"));
        };
        let mut given: Vec<(usize, Vec<f64>)> = Vec::new();
        let mut devices = None;
        for (sensor, array) in values {
            let place = bench.sensors.iter().position(|own| own.id == *sensor).ok_or_else(|| {
                let ids: Vec<&str> = bench.sensors.iter().map(|own| own.id.as_str()).collect();
                PyValueError::new_err(format!("the bench has no sensor '{sensor}': expected one of {}", ids.join(", ")))
            })?;
            let (numbers, shape) = table::array(array)?;
            let count = match shape.as_slice() {
                [count, readings] if *readings == rows.len() => *count,
                _ => {
                    return Err(PyValueError::new_err(format!(
                        "the values of '{sensor}' have the shape {shape:?}: expected (devices, {}), a column for each reading of the schedule",
                        rows.len()
                    )));
                }
            };
            if devices.is_some_and(|own| own != count) {
                return Err(PyValueError::new_err("the sensors have different numbers of devices"));
            }
            devices = Some(count);
            given.push((place, numbers));
        }
        let devices = devices.unwrap_or(0);
        if labels.as_ref().is_some_and(|labels| labels.len() != devices) {
            return Err(PyValueError::new_err(format!("expected a label for each of the {devices} devices")));
        }
        let rows = schedule(rows, &bench, &given);
        let question_of = |error: Malformed| question.raised(question.py(), error, None);
        let (layout, own) =
            wire::inline_devices(&bench, rows, NOBODY, |key| is_wanted(&file, key)).map_err(question_of)?;
        let template = campaign.with_readings(Readings { columns: layout.numeric(&bench), rows: Vec::new() });
        let asking = Asking::new(file, template, settings).map_err(question_of)?;
        let device = own.into_iter().next().unwrap_or_default();
        let values = layout
            .sensors()
            .filter_map(|sensor| {
                let at = given.iter().position(|(own, _)| *own == sensor)?;
                Some(std::mem::take(&mut given.get_mut(at)?.1))
            })
            .collect();
        Ok(Arrays { asking, layout, device, values, devices, labels })
    }
}

/// Rows of a schedule with a cell for each sensor that is read, and none for others; all of one device.
fn schedule(rows: Vec<ReadingFile>, bench: &Bench, given: &[(usize, Vec<f64>)]) -> Vec<ReadingFile> {
    let is_sensor = |key: &str| bench.sensors.iter().any(|own| own.id == key);
    rows.into_iter()
        .map(|mut row| {
            row.0.retain(|(key, _)| !is_sensor(key));
            let sensors = bench.sensors.iter().enumerate().filter(|(k, _)| given.iter().any(|(own, _)| own == k));
            row.0.extend(sensors.map(|(_, own)| (own.id.clone(), Cell::Number(0.0))));
            row.0.push((NOBODY.into(), Cell::Text(String::new())));
            row
        })
        .collect()
}

/// Fit devices on one schedule: `values` are pairs of a sensor and its array, (devices, readings).
#[pyfunction]
#[allow(clippy::too_many_arguments)]
pub fn fit_array<'py>(
    py: Python<'py>,
    campaign: Bound<'py, PyAny>,
    name: String,
    folder: PathBuf,
    dumps: Bound<'py, PyAny>,
    values: Vec<(String, Bound<'py, PyAny>)>,
    labels: Option<Vec<String>>,
    asked: Asked,
) -> PyResult<Devices> {
    let settings = asked.settings().map_err(|error| raised(py, &error, None))?;
    let arrays = Arrays::read(&Question::new(campaign, name, folder, dumps), &values, labels, settings)?;
    interruptible(py, move || {
        let (mut known, mut rows) = (Schedules::default(), Vec::with_capacity(arrays.devices));
        for first in (0..arrays.devices).step_by(TOGETHER) {
            tumble::stop::poll();
            let devices: Vec<Device> =
                (first..arrays.devices.min(first + TOGETHER)).map(|k| arrays.device(k)).collect();
            rows.extend(arrays.asking.fit(&devices, &arrays.layout, &mut known));
        }
        arrays.asking.answered(rows, "device")
    })
}

/// Seconds that the library alone takes for the same devices, which are there already, the least of so many rounds: for benchmarks.
#[pyfunction]
pub fn batch_seconds<'py>(
    py: Python<'py>,
    campaign: Bound<'py, PyAny>,
    folder: PathBuf,
    dumps: Bound<'py, PyAny>,
    values: Vec<(String, Bound<'py, PyAny>)>,
    asked: Asked,
    rounds: usize,
) -> PyResult<f64> {
    let settings = asked.settings().map_err(|error| raised(py, &error, None))?;
    let arrays = Arrays::read(&Question::new(campaign, "campaign".into(), folder, dumps), &values, None, settings)?;
    interruptible(py, move || {
        let devices: Vec<Device> = (0..arrays.devices).map(|k| arrays.device(k)).collect();
        let mut least = f64::INFINITY;
        for _ in 0..rounds {
            let begun = Instant::now();
            let rows = arrays.asking.fit(&devices, &arrays.layout, &mut Schedules::default());
            least = least.min(begun.elapsed().as_secs_f64());
            std::hint::black_box(rows);
        }
        least
    })
}

/// Fit the devices of a table (columns, or files), told apart by a column, or by the files.
#[pyfunction]
#[allow(clippy::too_many_arguments)]
pub fn fit_table<'py>(
    py: Python<'py>,
    campaign: Bound<'py, PyAny>,
    name: String,
    folder: PathBuf,
    dumps: Bound<'py, PyAny>,
    table: Option<Bound<'py, PyAny>>,
    files: Vec<PathBuf>,
    by: Option<String>,
    asked: Asked,
) -> PyResult<Devices> {
    let settings = asked.settings().map_err(|error| raised(py, &error, None))?;
    let question = Question::new(campaign, name, folder, dumps);
    let (template, source) = question.template()?;
    let columns = table.map(|table| table::columns(&table)).transpose()?;
    let mut file = template.file.clone();
    let by = by.or_else(|| file.by.clone());
    let inline = match std::mem::replace(&mut file.readings, ReadingsRef::Inline(Vec::new())) {
        ReadingsRef::Inline(rows) if columns.is_none() && files.is_empty() => match question.inline_rows()? {
            Some(own) => Some(own),
            None => Some(rows),
        },
        ReadingsRef::Path(path) if columns.is_none() && files.is_empty() => {
            return fit_files(py, &question, &template, file, vec![question.folder().join(path)], by, settings, source);
        }
        _ => None,
    };
    if let Some(columns) = columns {
        let held = held(columns).map_err(|error| question.raised(py, error, source.as_ref()))?;
        let open = move |_: usize| Ok(Record::from(held.clone()));
        return fit_records(py, &question, &template, file, vec!["readings".into()], open, by, settings, source);
    }
    if let Some(rows) = inline {
        let told = |error| question.raised(py, error, source.as_ref());
        let key = by.clone().ok_or_else(|| told(nobody()))?;
        let bench = template.bench.clone();
        let keys: Vec<String> = rows.iter().take(1).flat_map(|row| &row.0).map(|(key, _)| key.clone()).collect();
        let (layout, devices) = wire::inline_devices(&bench, rows, &key, |own| is_wanted(&file, own)).map_err(told)?;
        let empty = template.without_readings(layout.numeric(&bench)).map_err(told)?;
        empty.refuse_unread(keys.iter().map(String::as_str)).map_err(told)?;
        let asking = Asking::new(file, empty, settings).map_err(told)?;
        return interruptible(py, move || {
            let rows = asking.fit(&devices, &layout, &mut Schedules::default());
            asking.answered(rows, &key)
        });
    }
    fit_files(py, &question, &template, file, files, by, settings, source)
}

fn held(columns: Columns) -> tumble::Result<tumble::record::Held> {
    table::held("readings", columns)
}

fn nobody() -> Malformed {
    Malformed::new(Fault::Missing, "nothing tells the devices apart")
        .expected("by=, the column of the serial number, or \"by\" in the campaign")
        .at_path("by")
}

#[allow(clippy::too_many_arguments)]
fn fit_files(
    py: Python<'_>,
    question: &Question<'_>,
    template: &crate::question::Template,
    file: CampaignFile,
    files: Vec<PathBuf>,
    by: Option<String>,
    settings: Settings,
    source: Option<wire::Source>,
) -> PyResult<Devices> {
    let names = files.iter().map(|path| path.display().to_string()).collect();
    let open = move |k: usize| {
        let path = files.get(k).ok_or_else(|| Malformed::new(Fault::File, "there is no such file"))?;
        Record::at(path)
    };
    fit_records(py, question, template, file, names, open, by, settings, source)
}

#[allow(clippy::too_many_arguments)]
fn fit_records(
    py: Python<'_>,
    question: &Question<'_>,
    template: &crate::question::Template,
    file: CampaignFile,
    names: Vec<String>,
    open: impl Fn(usize) -> tumble::Result<Record> + Send + 'static,
    by: Option<String>,
    settings: Settings,
    source: Option<wire::Source>,
) -> PyResult<Devices> {
    let told = |error| question.raised(py, error, source.as_ref());
    if by.is_none() && names.len() < 2 {
        return Err(told(nobody()));
    }
    let bench = template.bench.clone();
    let title = |key: &str| file.columns.get(key).map_or(key, String::as_str).to_string();
    let by_title = by.as_deref().map(title);
    let first = open(0).map_err(told)?;
    let lot = lot(first.columns()).filter(|lot| Some(lot) != by_title.as_ref());
    let layout = {
        let (bench, file) = (bench.clone(), file.clone());
        move |record: &Record, by: Option<usize>| {
            wire::table_layout(&bench, record, by, &file.columns, |key| is_wanted(&file, key))
        }
    };
    let place = by_title.as_deref().map(|by| first.find(by)).transpose().map_err(told)?;
    let numeric = layout(&first, place).map_err(told)?.numeric(&bench);
    let empty = template.without_readings(numeric).map_err(told)?;
    empty.refuse_unread(first.columns().iter().map(|column| column.title.as_str())).map_err(told)?;
    drop(first);
    let asking = Asking::new(file, empty, settings).map_err(told)?;
    let answered = interruptible(py, move || {
        let mut known = Schedules::default();
        // rows of a table may be handed on twice, where those of a device do not stand together
        let rows = std::cell::RefCell::new(Vec::new());
        let tables =
            Tables { files: &names, open: &open, by: by_title.as_deref(), lot: lot.as_deref(), layout: &layout };
        let mut sink = |devices: Vec<Device>, layout: &Layout| {
            rows.borrow_mut().extend(asking.fit(&devices, layout, &mut known));
            Ok(true)
        };
        batch::stream(&tables, &mut sink, &mut |_| {
            rows.borrow_mut().clear();
            Ok(())
        })?;
        let rows: Vec<Row> = rows.into_inner();
        Ok(asking.answered(rows, by.as_deref().unwrap_or("file")))
    })?;
    answered.map_err(told)
}

/// The column of dates or lots, by its name.
fn lot(columns: &[Column]) -> Option<String> {
    let named = |name: &&str| columns.iter().find(|own| own.name.eq_ignore_ascii_case(name));
    ["lot", "batch", "date", "day"].iter().find_map(named).map(|column| column.title.clone())
}
