//! The devices of a table, or of many files: the campaign that is asked of each, and where its readings are (`--by`, `--readings FILE...`).

use super::files;
use super::files::Beside;
use crate::batch::{self, Device, Layout, Restart, Tables, Use};
use crate::bench::Bench;
use crate::campaign::{Campaign, Readings};
use crate::design::Model;
use crate::error::{Fault, Malformed, Result};
use crate::fit::Settings;
use crate::number;
use crate::record::{Column, Record};
use crate::report::Input;
use crate::wire::{self, CampaignFile, Folder, ReadingsRef, Source};
use clap::Args;
use std::cell::RefCell;
use std::io::IsTerminal;
use std::path::{Path, PathBuf};

/// Names of columns that a control chart is drawn over, where none is asked for.
const LOTS: [&str; 4] = ["lot", "batch", "date", "day"];

/// Many devices.
#[derive(Debug, Args)]
pub(super) struct Many {
    /// One fit for each value of this column of the readings: a serial number. It replaces the campaign's "by".
    #[arg(long, value_name = "COLUMN")]
    by: Option<String>,
    /// With many devices: write one row for each device to a file (.csv, .jsonl or .parquet). Without it: CSV to stdout, a table on a terminal.
    #[arg(long, value_name = "FILE")]
    pub(super) to: Option<PathBuf>,
    /// With many devices: the column of dates or lots for control charts; lot, batch, date or day unless given.
    #[arg(long, value_name = "COLUMN")]
    pub(super) chart: Option<String>,
}

impl Many {
    /// Errors: options that need many devices; `more` are further ones of the command, and whether they are given.
    pub(super) fn refuse_alone(&self, more: &[(&str, bool)]) -> Result<()> {
        let options = [("--to", self.to.is_some()), ("--chart", self.chart.is_some())];
        let expected = "--by COLUMN, \"by\" in the campaign, or several files of --readings";
        refuse([&options, more].concat(), (Fault::Missing, "applies to many devices, but there is one"), expected)
    }
}

/// Errors: options that are of one device, where there are many.
pub(super) fn refuse_many(options: Vec<(&str, bool)>, expected: &str) -> Result<()> {
    refuse(options, (Fault::Value, "applies to one device, but there are many"), expected)
}

fn refuse(options: Vec<(&str, bool)>, (fault, why): (Fault, &str), expected: &str) -> Result<()> {
    match options.into_iter().find(|(_, given)| *given) {
        None => Ok(()),
        Some((option, _)) => Err(Malformed::new(fault, format!("{option} {why}")).expected(expected)),
    }
}

/// The campaign and the files of readings, where the campaign may be the last of the files: `--readings FILE... CAMPAIGN`.
pub(super) fn behind<'a>(campaign: Option<&'a Path>, readings: &'a [PathBuf]) -> Result<(&'a Path, &'a [PathBuf])> {
    match (campaign, readings.split_last()) {
        (Some(campaign), _) => Ok((campaign, readings)),
        (None, Some((campaign, readings))) => Ok((campaign, readings)),
        (None, None) => {
            Err(Malformed::new(Fault::Missing, "there is no campaign").expected("the path of a campaign file"))
        }
    }
}

/// A campaign, and where its readings are.
pub(super) struct DeviceCampaign {
    path: PathBuf,
    /// The campaign file, for errors that come later.
    pub(super) source: Source,
    input: Input,
    file: CampaignFile,
    by: Option<String>,
    /// Files of readings, where they are not in the campaign.
    files: Vec<PathBuf>,
    /// Are they in place of the campaign's?
    replaced: bool,
}

impl DeviceCampaign {
    /// Read a campaign file; its readings stay where they are.
    pub(super) fn read(path: &Path, many: &Many, readings: &[PathBuf]) -> Result<Self> {
        let (source, input) = files::read_input(path)?;
        DeviceCampaign::asked(path, (source, input), many.by.clone(), readings)
    }

    /// A campaign from the text of its file, which need not be written yet.
    pub(super) fn of(path: &Path, source: Source) -> Result<Self> {
        let input = Input::new(&source.name, source.text.as_bytes());
        DeviceCampaign::asked(path, (source, input), None, &[])
    }

    fn asked(path: &Path, (source, input): (Source, Input), by: Option<String>, readings: &[PathBuf]) -> Result<Self> {
        let file = wire::campaign_of(&source)?;
        let by = by.or_else(|| file.by.clone());
        let folder: PathBuf = path.parent().map(Path::to_path_buf).unwrap_or_default();
        let files = match (&file.readings, readings) {
            (_, [_, ..]) => files::expand(readings)?,
            (ReadingsRef::Path(path), _) => vec![folder.join(path)],
            (ReadingsRef::Inline(_) | ReadingsRef::Samples(_), _) => Vec::new(),
        };
        Ok(DeviceCampaign { path: path.to_path_buf(), source, input, file, by, files, replaced: !readings.is_empty() })
    }

    pub(super) fn is_of_many(&self) -> bool {
        self.by.is_some() || self.files.len() > 1
    }

    /// Are the readings the rows of a record, which is streamed?
    pub(super) fn is_streamed(&self) -> bool {
        self.file.has_rows() && !self.replaced
    }

    /// The fit of a record whose rows are the readings.
    pub(super) fn stream(&self, settings: &Settings) -> Result<(crate::fit::Fit, Vec<Input>)> {
        let mut folder = Beside::new(&self.path);
        let (campaign, mut rows, sample) = wire::read_rows_of(&self.file, &self.source, &mut folder, Some(settings))?;
        let fit = crate::fit::streamed::fit(campaign, &mut rows, &sample, settings);
        let fit = fit.map_err(|error| wire::locate(error, &self.source))?;
        Ok((fit, self.inputs(folder)))
    }

    pub(super) fn single(&self) -> Result<(Campaign, Vec<Input>)> {
        let mut folder = Beside::new(&self.path);
        let campaign = match self.files.first().filter(|_| self.replaced) {
            None => wire::campaign_from(self.file.clone(), &self.source, &mut folder)?,
            Some(path) => {
                let bench = self.bench(&mut folder)?;
                let table = folder.table_at(path)?;
                let readings = wire::read_readings(&bench, table, &self.file.columns, &self.file.scatter);
                let campaign = readings.and_then(|readings| self.file.clone().with(bench, readings));
                campaign.map_err(|error| wire::locate(error, &self.source))?
            }
        };
        Ok((campaign, self.inputs(folder)))
    }

    fn bench(&self, folder: &mut Beside) -> Result<Bench> {
        let bench = self.file.resolved_bench(&mut |name| folder.text(name));
        bench.map_err(|error| wire::locate(error, &self.source))
    }

    /// The campaign's file, and what was read of its folder.
    fn inputs(&self, folder: Beside) -> Vec<Input> {
        [vec![self.input.clone()], folder.inputs].concat()
    }

    /// Every device once: is it well-formed?
    ///
    /// Errors: those of the table; that of the first device where none is well-formed.
    pub(super) fn survey(&self) -> Result<Survey> {
        let table = self.table(false, None)?;
        let (mut first, mut devices, mut malformed) = (None, 0, Vec::new());
        table.read(&mut |passed| {
            let Passed::Devices(read, layout) = passed else {
                (first, devices, malformed) = (None, 0, Vec::new());
                return Ok(true);
            };
            devices += read.len();
            for device in &read {
                let campaign = table.campaign(layout, device);
                match campaign.and_then(|campaign| Model::new(&campaign).map(|_| campaign)) {
                    Ok(campaign) => first = first.take().or(Some(campaign)),
                    Err(error) => malformed.push((device.label.clone(), error)),
                }
            }
            Ok(true)
        })?;
        let none = || Malformed::new(Fault::Missing, "the table has no device").expected("a row for each reading");
        match first {
            Some(first) => Ok(Survey { first, devices, malformed }),
            None => Err(wire::locate(malformed.into_iter().next().map_or_else(none, |(_, error)| error), &self.source)),
        }
    }

    /// The title of a column that the campaign calls by a key.
    fn title(&self, key: &str) -> String {
        self.file.columns.get(key).map_or(key, String::as_str).to_string()
    }

    /// The devices among the campaign's own rows.
    fn inline(&self, bench: &Bench, all: bool) -> Result<(Layout, Vec<Device>)> {
        let rows = if let ReadingsRef::Inline(rows) = &self.file.readings { rows.clone() } else { Vec::new() };
        let by = self.by.as_deref().unwrap_or_default();
        wire::inline_devices(bench, rows, by, |key| self.wants(key, all))
            .map_err(|error| wire::locate(error.at_path("readings"), &self.source))
    }

    /// Is a column a device's? Those that the campaign's scatter names; `all`: every one, as a diagnosis looks at them.
    fn wants(&self, key: &str, all: bool) -> bool {
        let scatter = &self.file.scatter;
        match all {
            true => Some(key) != self.by.as_deref(),
            false if crate::campaign::ScatterRequest::use_key(scatter, key) => true,
            false => (key == "position" && !scatter.is_empty()) || key.ends_with("_u"),
        }
    }

    /// The table of devices, with all columns or those of a fit: files, or the campaign's own readings.
    pub(super) fn table(&self, all: bool, chart: Option<&str>) -> Result<DeviceTable<'_>> {
        let located = |error| wire::locate(error, &self.source);
        if let (ReadingsRef::Samples(_), true) = (&self.file.readings, self.files.is_empty()) {
            return Err(located(
                Malformed::new(Fault::Value, "a record of samples is of one device")
                    .expected("a table of readings of many devices (tumble reduce makes readings of each record)")
                    .at_path("readings"),
            ));
        }
        let mut folder = Beside::new(&self.path);
        let bench = self.bench(&mut folder)?;
        let (mut lot, mut numeric, mut titles) = (None, Vec::new(), Vec::new());
        match (self.files.first(), &self.file.readings) {
            (Some(first), _) => {
                let record = Record::at(first)?;
                titles.extend(record.columns().iter().map(|column| column.title.clone()));
                let by = self.by.as_deref().map(|by| record.find(&self.title(by))).transpose()?;
                lot = match chart {
                    Some(column) => {
                        let found = record.find(&self.title(column))?;
                        Some(record.columns().get(found).map_or(column.into(), |c| c.title.clone()))
                    }
                    None => self::lot(record.columns()),
                };
                // a diagnosis has every column for itself
                lot = lot.filter(|lot| !all && Some(lot) != self.by.as_ref());
                self.files.iter().for_each(|path| super::session::reads(path));
                let wants = |key: &str| self.wants(key, all);
                numeric = wire::table_layout(&bench, &record, by, &self.file.columns, wants)?.numeric(&bench);
            }
            (None, ReadingsRef::Inline(rows)) => {
                titles.extend(rows.iter().take(1).flat_map(|row| &row.0).map(|(key, _)| key.clone()));
                numeric = self.inline(&bench, all)?.0.numeric(&bench);
            }
            (None, ReadingsRef::Path(_) | ReadingsRef::Samples(_)) => {}
        }
        // the campaign of no device yet: everything but the readings is checked here
        let readings = Readings { columns: numeric, rows: Vec::new() };
        let file = CampaignFile { scatter: Vec::new(), ..self.file.clone() };
        let template = file.with(bench, readings).map_err(located)?;
        template.refuse_unread(titles.iter().map(String::as_str)).map_err(located)?;
        Ok(DeviceTable { question: self, lot, all, template, inputs: self.inputs(folder) })
    }
}

/// What a table of devices holds.
pub(super) struct Survey {
    /// The first device that is well-formed.
    pub(super) first: Campaign,
    pub(super) devices: usize,
    /// Those that are not, by their label.
    pub(super) malformed: Vec<(String, Malformed)>,
}

/// A table of devices that is about to be read.
pub(super) struct DeviceTable<'a> {
    question: &'a DeviceCampaign,
    pub(super) lot: Option<String>,
    all: bool,
    /// The campaign without readings.
    pub(super) template: Campaign,
    inputs: Vec<Input>,
}

/// What a pass over a table of devices brings.
pub(super) enum Passed<'a> {
    Devices(Vec<Device>, &'a Layout),
    /// What was handed on is to be forgotten: the rows of a device are not contiguous, and all devices come anew.
    Anew,
}

impl DeviceTable<'_> {
    /// Every file that was read, with digests.
    pub(super) fn inputs(&self) -> Result<Vec<Input>> {
        let mut inputs = self.inputs.clone();
        for path in &self.question.files {
            inputs.push(files::input(path)?);
        }
        Ok(inputs)
    }

    pub(super) fn by(&self) -> &str {
        self.question.by.as_deref().unwrap_or("file")
    }

    pub(super) fn campaign(&self, layout: &Layout, device: &Device) -> Result<Campaign> {
        let (template, file) = (&self.template, &self.question.file);
        let readings = wire::device_readings(&template.bench, layout, device)?;
        let plain = file.scatter.is_empty() && layout.uses.iter().all(|kind| *kind != Use::Other);
        let own_lines = readings.columns.iter().any(|column| column.ends_with("_u"));
        match plain && !own_lines && readings.columns == template.readings.columns {
            true => Ok(template.with_readings(readings)),
            false => file.clone().with(template.bench.clone(), readings),
        }
    }

    /// Hand on the devices, in chunks; `sink` says whether those of a chunk were of use.
    pub(super) fn read(&self, sink: &mut dyn FnMut(Passed<'_>) -> Result<bool>) -> Result<()> {
        let (question, bench) = (self.question, &self.template.bench);
        if question.files.is_empty() {
            let (layout, devices) = question.inline(bench, self.all)?;
            return sink(Passed::Devices(devices, &layout)).map(drop);
        }
        let open = |k: usize| match question.files.get(k) {
            Some(path) => Record::at(path),
            None => Err(Malformed::new(Fault::File, "there is no such file")),
        };
        let layout = |record: &Record, by: Option<usize>| {
            wire::table_layout(bench, record, by, &question.file.columns, |key| question.wants(key, self.all))
        };
        let by = question.by.as_deref().map(|by| question.title(by));
        let files: Vec<String> = question.files.iter().map(|path| path.display().to_string()).collect();
        let tables =
            Tables { files: &files, open: &open, by: by.as_deref(), lot: self.lot.as_deref(), layout: &layout };
        let sink = RefCell::new(sink);
        let devices = &mut |devices: Vec<Device>, layout: &Layout| sink.borrow_mut()(Passed::Devices(devices, layout));
        let read = batch::stream(&tables, devices, &mut |again| {
            if let Restart::CameBack { label, row } = again {
                super::note(&format!(
                    "note: '{label}' occurs again in row {row}: the rows of a device are not contiguous, so the table is read again, and each device is \
                     held in memory until it is complete"
                ));
            }
            sink.borrow_mut()(Passed::Anew).map(drop)
        })?;
        if let Some((first, others)) = read.blanks_differ.split_first() {
            let more = if others.is_empty() { String::new() } else { format!(" and {} others", others.len()) };
            super::note(&format!("note: '{first}'{more} differ only in blanks, and each is taken as one device"));
        }
        Ok(())
    }

    /// A bar of rows on stderr with rate and time left; for tables of text their number is guessed from the first lines.
    pub(super) fn bar(&self) -> indicatif::ProgressBar {
        let rows = |path: &PathBuf| match Record::at(path).ok().and_then(|record| record.rows()) {
            Some(rows) => rows,
            None => guessed(path),
        };
        let shown = std::io::stderr().is_terminal();
        let rows = if shown { self.question.files.iter().map(rows).sum() } else { 0 };
        super::bar(rows, "{wide_bar} {human_pos} of about {human_len} rows, {per_sec}, {eta} left")
    }
}

/// Rows of a table of text, from its size and the length of its first lines.
fn guessed(path: &Path) -> u64 {
    use std::io::Read;
    let mut head = Vec::new();
    let read = std::fs::File::open(path).and_then(|file| file.take(1 << 16).read_to_end(&mut head));
    let (lines, size) =
        (head.iter().filter(|b| **b == b'\n').count(), std::fs::metadata(path).map_or(0, |metadata| metadata.len()));
    match read {
        Ok(length) if lines > 0 => number::count_u64(size as f64 / length as f64 * lines as f64),
        _ => 0,
    }
}

/// The column of dates or lots.
fn lot(columns: &[Column]) -> Option<String> {
    let named = |name: &&str| columns.iter().find(|column| column.name.eq_ignore_ascii_case(name));
    LOTS.iter().find_map(named).map(|column| column.title.clone())
}
