//! Campaigns from dicts without a detour over text, and templates of those that come again with other readings.
//!
//! The quick way takes what it understands; whatever it does not, and every error, is left to the campaign's text, which can be quoted.

use crate::table::{self, Columns};
use crate::work::{interruptible, raised};
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyFloat, PyInt, PyList, PyString, PyTuple};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use tumble::bench::{Bench, built_in};
use tumble::campaign::{Campaign, Readings};
use tumble::error::{Fault, Malformed};
use tumble::record::Record;
use tumble::wire::{self, BenchRef, CampaignFile, Cell, Named, ReadingFile, ReadingsRef, Source};

/// Questions that are kept.
const KEPT: usize = 8;
/// Rows of a table that are read at once.
const FEW: usize = 2000;
/// A question whose fingerprint is longer than this is not kept.
const LONGEST: usize = 1 << 16;

/// A campaign without its readings.
pub struct Template {
    /// As the file has it.
    pub file: CampaignFile,
    /// Its bench, checked.
    pub bench: Bench,
    /// The campaign of readings with certain columns, which serves all readings with these.
    made: Mutex<Option<Arc<Campaign>>>,
}

static TEMPLATES: Mutex<Vec<(Vec<u8>, Arc<Template>)>> = Mutex::new(Vec::new());

impl Template {
    /// The campaign with these readings.
    pub fn with(&self, readings: Readings) -> tumble::Result<Campaign> {
        let mut made = self.made.lock().unwrap_or_else(PoisonError::into_inner);
        // lines of scatter, uncertainties of columns and numbers of samples are looked at together with the readings
        let plain = self.file.scatter.is_empty() && !readings.columns.iter().any(|column| column.ends_with("_u"));
        if let Some(made) = made.as_ref().filter(|made| plain && made.readings.columns == readings.columns) {
            return Ok(made.with_readings(readings));
        }
        if !plain {
            return self.file.clone().with(self.bench.clone(), readings);
        }
        let empty = Readings { columns: readings.columns.clone(), rows: Vec::new() };
        let campaign = self.file.clone().with(self.bench.clone(), readings)?;
        *made = Some(Arc::new(campaign.with_readings(empty)));
        Ok(campaign)
    }

    /// The campaign of no readings yet, for tables of many devices with these numeric columns.
    pub fn without_readings(&self, columns: Vec<String>) -> tumble::Result<Campaign> {
        let file = CampaignFile { scatter: Vec::new(), ..self.file.clone() };
        file.with(self.bench.clone(), Readings { columns, rows: Vec::new() })
    }
}

/// A question as it comes from Python.
pub struct Question<'py> {
    /// A dict, or the text of a file.
    content: Bound<'py, PyAny>,
    /// What errors call it.
    name: String,
    /// Where what it names is looked for.
    folder: PathBuf,
    /// Makes the text of a dict (`json.dumps`).
    dumps: Bound<'py, PyAny>,
}

impl<'py> Question<'py> {
    pub fn new(content: Bound<'py, PyAny>, name: String, folder: PathBuf, dumps: Bound<'py, PyAny>) -> Self {
        Question { content, name, folder, dumps }
    }

    /// The campaign of one device; `table` takes the place of its readings.
    pub fn campaign(&self, table: Option<Columns>) -> PyResult<(Campaign, Option<Source>)> {
        let py = self.content.py();
        if let Some(columns) = table {
            let (template, source) = self.template()?;
            let few = columns.first().is_none_or(|(_, cells)| table::length(cells) < FEW);
            let make = move || of_columns(&template, columns).and_then(|readings| template.with(readings));
            let made = if few { make() } else { interruptible(py, make)? };
            return made.map(|campaign| (campaign, None)).map_err(|error| self.raised(py, error, source.as_ref()));
        }
        if let Ok(dict) = self.content.cast::<PyDict>()
            && let Some(campaign) = self.quickly(dict)
        {
            return Ok((campaign, None));
        }
        let source = self.source()?;
        let many = |file: CampaignFile| match file.by {
            Some(by) => Err(Malformed::new(Fault::Value, "the campaign is of many devices")
                .expected("tumble.fit_devices, or a campaign without \"by\"")
                .found(format!("\"by\": \"{by}\""))
                .at_path("by")),
            None => Ok(()),
        };
        let folder = self.folder.clone();
        let (source, made) = interruptible(py, move || {
            // looked at first, for the readings of many devices are no readings of one
            let one = if source.text.contains("\"by\"") { wire::campaign_of(&source).and_then(many) } else { Ok(()) };
            let made = one.and_then(|()| wire::read_campaign_beside(&source, &folder));
            (source, made)
        })?;
        match made {
            Ok(campaign) => Ok((campaign, Some(source))),
            Err(error) => Err(self.raised(py, error, Some(&source))),
        }
    }

    /// The question as text, where its readings are the rows of a record.
    pub fn of_rows(&self) -> PyResult<Option<Source>> {
        if let Ok(dict) = self.content.cast::<PyDict>() {
            let readings = dict.get_item("readings")?;
            if readings.is_none_or(|own| own.cast::<PyDict>().is_err()) {
                return Ok(None);
            }
        }
        let source = self.source()?;
        let has_rows = source.text.contains("\"as\"") && wire::campaign_of(&source).is_ok_and(|file| file.has_rows());
        Ok(has_rows.then_some(source))
    }

    /// The exception of an error about this question.
    pub fn raised(&self, py: Python<'_>, error: Malformed, source: Option<&Source>) -> PyErr {
        let source = source.cloned().or_else(|| self.source().ok());
        let Some(source) = source else { return raised(py, &error, None) };
        let error = wire::locate(error, &source);
        let own = error.place().file == self.name || error.place().file.is_empty();
        raised(py, &error, own.then_some(source.text.as_str()))
    }

    /// The question as text.
    pub fn source(&self) -> PyResult<Source> {
        let text = match self.content.cast::<PyString>() {
            Ok(text) => text.to_string(),
            Err(_) => self.dumps.call1((&self.content,))?.extract::<String>()?,
        };
        Ok(Source { name: self.name.clone(), text })
    }

    /// The interpreter.
    pub fn py(&self) -> Python<'py> {
        self.content.py()
    }

    /// The readings of a dict, where they stand in it.
    pub fn inline_rows(&self) -> PyResult<Option<Vec<ReadingFile>>> {
        let Ok(dict) = self.content.cast::<PyDict>() else { return Ok(None) };
        let Some(list) = dict.get_item("readings")? else { return Ok(None) };
        if let Some(rows) = list.cast::<PyList>().ok().and_then(|list| rows(list)) {
            return Ok(Some(rows));
        }
        let source = self.source()?;
        match wire::campaign_of(&source) {
            Ok(CampaignFile { readings: ReadingsRef::Inline(rows), .. }) => Ok(Some(rows)),
            Ok(_) => Ok(None),
            Err(error) => Err(self.raised(self.py(), error, Some(&source))),
        }
    }

    /// The folder of the question.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// The campaign without its readings, and its text where that was made.
    pub fn template(&self) -> PyResult<(Arc<Template>, Option<Source>)> {
        if let Ok(dict) = self.content.cast::<PyDict>()
            && let Some((template, _)) = self.kept(dict)
        {
            return Ok((template, None));
        }
        let source = self.source()?;
        let made = wire::campaign_of(&source).and_then(|file| {
            let folder = &self.folder;
            let bench = file.resolved_bench(&mut |name| {
                let path = folder.join(name);
                let bytes = std::fs::read(&path).map_err(|error| {
                    Malformed::new(Fault::File, format!("cannot read '{}': {error}", path.display()))
                })?;
                Source::from_bytes(path.display().to_string(), bytes)
            })?;
            Ok(Template { file, bench, made: Mutex::new(None) })
        });
        match made {
            Ok(template) => Ok((Arc::new(template), Some(source))),
            Err(error) => Err(self.raised(self.content.py(), error, Some(&source))),
        }
    }

    /// The quick way; `None` where it does not lead there.
    fn quickly(&self, dict: &Bound<'py, PyDict>) -> Option<Campaign> {
        let (template, readings) = self.kept(dict)?;
        let file = &template.file;
        if file.by.is_some() || !file.columns.is_empty() {
            return None;
        }
        let rows = rows(readings?.cast::<PyList>().ok()?)?;
        template.with(wire::read_rows(&template.bench, rows).ok()?).ok()
    }

    /// The template of a dict that refers to no file, kept or made, and its readings.
    #[allow(clippy::type_complexity)]
    fn kept(&self, dict: &Bound<'py, PyDict>) -> Option<(Arc<Template>, Option<Bound<'py, PyAny>>)> {
        let (mut fingerprint, mut readings) = (Vec::with_capacity(512), None);
        for (key, value) in dict.iter() {
            let key = key.cast_into::<PyString>().ok()?;
            let name = key.to_str().ok()?;
            if name == "readings" {
                readings = Some(value);
                continue;
            }
            if name == "bench" {
                // a file may change
                let named = value.cast::<PyString>().ok().map(|id| id.to_str().map(|id| built_in(id).is_none()));
                if let Some(Ok(true) | Err(_)) = named {
                    return None;
                }
            }
            text_into(name, &mut fingerprint);
            known(&value, &mut fingerprint)?;
        }
        if fingerprint.len() > LONGEST {
            return None;
        }
        let mut kept = TEMPLATES.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(at) = kept.iter().position(|(own, _)| *own == fingerprint) {
            // the one that was asked for last is first
            kept[..=at].rotate_right(1);
            return Some((kept[0].1.clone(), readings));
        }
        drop(kept);
        let template = Arc::new(self.made(dict)?);
        let mut kept = TEMPLATES.lock().unwrap_or_else(PoisonError::into_inner);
        kept.truncate(KEPT - 1);
        kept.insert(0, (fingerprint, template.clone()));
        Some((template, readings))
    }

    /// The template of a dict; `None` where something is wrong with it.
    fn made(&self, dict: &Bound<'py, PyDict>) -> Option<Template> {
        let rest = dict.copy().ok()?;
        rest.set_item("readings", PyList::empty(dict.py())).ok()?;
        let text = self.dumps.call1((rest,)).ok()?.extract::<String>().ok()?;
        let mut file = wire::campaign_of(&Source { name: self.name.clone(), text }).ok()?;
        file.readings = ReadingsRef::Inline(Vec::new());
        if let BenchRef::Named(id) = &file.bench {
            built_in(id)?;
        }
        let nothing = |name: &str| Err(Malformed::new(Fault::File, format!("'{name}' is a file")));
        let bench = file.resolved_bench(&mut { nothing }).ok()?;
        Some(Template { file, bench, made: Mutex::new(None) })
    }
}

/// The sensors of a campaign's bench.
#[pyfunction]
pub fn sensors<'py>(
    campaign: Bound<'py, PyAny>,
    name: String,
    folder: PathBuf,
    dumps: Bound<'py, PyAny>,
) -> PyResult<Vec<String>> {
    let (template, _) = Question::new(campaign, name, folder, dumps).template()?;
    Ok(template.bench.sensors.iter().map(|sensor| sensor.id.clone()).collect())
}

/// Readings of a table.
fn of_columns(template: &Template, columns: Columns) -> tumble::Result<Readings> {
    let table = table::held("readings", columns)?;
    wire::read_readings(&template.bench, Record::from(table), &template.file.columns, &template.file.scatter)
}

/// What a value of JSON is, so that equal ones are equal in bytes; `None` for what JSON has not.
fn known(value: &Bound<'_, PyAny>, into: &mut Vec<u8>) -> Option<()> {
    if let Ok(text) = value.cast::<PyString>() {
        text_into(text.to_str().ok()?, into);
    } else if let Ok(dict) = value.cast::<PyDict>() {
        into.push(b'{');
        for (key, value) in dict.iter() {
            text_into(key.cast::<PyString>().ok()?.to_str().ok()?, into);
            known(&value, into)?;
        }
        into.push(b'}');
    } else if let Ok(list) = value.cast::<PyList>() {
        into.push(b'[');
        for value in list.iter() {
            known(&value, into)?;
        }
        into.push(b']');
    } else if let Ok(truth) = value.cast::<PyBool>() {
        into.push(if truth.is_true() { b't' } else { b'f' });
    } else if value.is_none() {
        into.push(b'n');
    } else if value.is_instance_of::<PyInt>() {
        // an integer is not the number that it is written as
        into.push(b'i');
        into.extend(value.extract::<i64>().ok()?.to_le_bytes());
    } else {
        into.push(b'd');
        into.extend(value.cast::<PyFloat>().ok()?.value().to_bits().to_le_bytes());
    }
    Some(())
}

fn text_into(text: &str, into: &mut Vec<u8>) {
    into.push(b'"');
    into.extend((text.len() as u64).to_le_bytes());
    into.extend_from_slice(text.as_bytes());
}

/// Readings as a file has them; `None` where the text would say more.
pub fn rows(list: &Bound<'_, PyList>) -> Option<Vec<ReadingFile>> {
    let mut rows = Vec::with_capacity(list.len());
    for row in list.iter() {
        let row = row.cast_into::<PyDict>().ok()?;
        let mut cells = Vec::with_capacity(row.len());
        for (key, value) in row.iter() {
            cells.push((key.cast::<PyString>().ok()?.to_str().ok()?.to_string(), cell(&value)?));
        }
        rows.push(Named(cells));
    }
    Some(rows)
}

fn cell(value: &Bound<'_, PyAny>) -> Option<Cell> {
    let number = |value: &Bound<'_, PyAny>| {
        let number = match value.cast::<PyFloat>() {
            Ok(number) => number.value(),
            Err(_) if value.is_instance_of::<PyBool>() => return None,
            Err(_) => value.extract::<f64>().ok()?,
        };
        number.is_finite().then_some(number)
    };
    if let Ok(float) = value.cast::<PyFloat>() {
        // not a number: nothing was read, as in a table
        return if float.value().is_nan() { Some(Cell::Nothing(())) } else { number(value).map(Cell::Number) };
    }
    if let Ok(text) = value.cast::<PyString>() {
        return Some(Cell::Text(text.to_str().ok()?.to_string()));
    }
    if value.is_none() {
        return Some(Cell::Nothing(()));
    }
    if value.is_instance_of::<PyList>() || value.is_instance_of::<PyTuple>() {
        let list: Option<Vec<f64>> = value.try_iter().ok()?.map(|own| number(&own.ok()?)).collect();
        return list.map(Cell::List);
    }
    number(value).map(Cell::Number)
}
