//! A table of many devices, device by device, in memory bound by a chunk as long as each device's rows stand together.

use super::{Device, Layout, Use};
use crate::elements::{Elements, Parts};
use crate::error::{Fault, Malformed, Result};
use crate::number;
use crate::record::{As, Block, Record};
use std::collections::{HashMap, HashSet};
use std::sync::Arc;

/// Cells of the devices that are handed on together.
const CELLS: usize = 1 << 20;
/// Devices that are handed on together; and first, until it is clear that their rows stand together.
const DEVICES: usize = 1 << 13;
const FIRST: usize = 1 << 8;

/// Tables of devices: files that have the same columns.
pub struct Tables<'a> {
    /// Their names.
    pub files: &'a [String],
    /// Opens one of them by its place.
    pub open: &'a dyn Fn(usize) -> Result<Record>,
    /// The column that tells devices apart; `None` where each file is a device, under its name.
    pub by: Option<&'a str>,
    /// The column of dates or lots.
    pub lot: Option<&'a str>,
    /// The layout of a table and of its column that tells devices apart.
    pub layout: &'a dyn Fn(&Record, Option<usize>) -> Result<Layout>,
}

/// Why what was handed on has to be forgotten.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Restart {
    /// A device that had been handed on came back: rows of devices do not stand together.
    CameBack {
        /// The device.
        label: String,
        /// The row (counted from 1, over all files).
        row: u64,
    },
    /// Most of the first devices were of no use, as they are where only some of their rows stand together.
    OfNoUse,
}

/// What was read.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Read {
    /// Rows.
    pub rows: u64,
    /// Labels that stand with different blanks around them and were taken as one.
    pub blanks_differ: Vec<String>,
}

/// Rows of each device in all the files.
type Counts = HashMap<String, u64>;

/// Hand on every device of the files once, in chunks; `sink` says whether the devices of a chunk are of use.
///
/// Rows without a label are one [`Device`] that is [nameless](Device::nameless). Where the rows of a device do not stand together, `restart` is called, and all devices are handed on anew:
/// then devices are kept until they are whole. Errors: those of the record, files with other columns than the first.
pub fn stream(
    tables: &Tables<'_>,
    sink: &mut dyn FnMut(Vec<Device>, &Layout) -> Result<bool>,
    restart: &mut dyn FnMut(&Restart) -> Result<()>,
) -> Result<Read> {
    let again = match pass(tables, None, sink)? {
        Ended::Whole(read) => return Ok(read),
        Ended::Early(again) => again,
    };
    restart(&again)?;
    // without a column that tells devices apart each file is one
    let counts = count(tables, tables.by.unwrap_or_default())?;
    match pass(tables, Some(&counts), sink)? {
        Ended::Whole(read) => Ok(read),
        // not reached: with counts no device is handed on early
        Ended::Early(_) => Ok(Read::default()),
    }
}

enum Ended {
    Whole(Read),
    Early(Restart),
}

/// Count the rows of each device.
fn count(tables: &Tables<'_>, by: &str) -> Result<Counts> {
    let mut counts = Counts::new();
    for file in 0..tables.files.len() {
        let mut record = (tables.open)(file)?;
        let column = record.find(by)?;
        record.select(&[(column, As::Label)]);
        let mut block = Block::default();
        while record.next(&mut block)? {
            // one column is read
            for number in block.columns.first().map(Vec::as_slice).unwrap_or_default() {
                let label = label(&record, place(*number));
                match counts.get_mut(label) {
                    Some(count) => *count += 1,
                    None => drop(counts.insert(label.to_string(), 1)),
                }
            }
        }
    }
    Ok(counts)
}

/// The place of a label in the record's list, plus one; 0 for a row without one.
fn place(number: f64) -> usize {
    if number.is_nan() { 0 } else { number::count(number) + 1 }
}

/// The label; empty for a row without one.
fn label(record: &Record, place: usize) -> &str {
    place.checked_sub(1).and_then(|k| record.labels().get(k)).map_or("", String::as_str)
}

/// One pass over the files; without `counts` a device is whole where the next one begins.
fn pass(
    tables: &Tables<'_>,
    counts: Option<&Counts>,
    sink: &mut dyn FnMut(Vec<Device>, &Layout) -> Result<bool>,
) -> Result<Ended> {
    let mut gathering = Gathering { counts, ..Gathering::default() };
    let mut first: Option<Layout> = None;
    let mut handed_on = 0;
    for (file, name) in tables.files.iter().enumerate() {
        let mut record = (tables.open)(file)?;
        let column = tables.by.map(|by| record.find(by)).transpose()?;
        let lot = tables.lot.map(|lot| record.find(lot)).transpose()?;
        let layout = (tables.layout)(&record, column)?;
        let layout = match &first {
            None => first.insert(layout).clone(),
            Some(before) => layout.in_the_order_of(before).ok_or_else(|| {
                Malformed::new(Fault::Missing, format!("'{name}' has other columns than the first file"))
                    .expected(before.keys.join(", "))
                    .found(layout.keys.join(", "))
                    .in_file(name)
            })?,
        };
        let mut selection = layout.selection();
        selection.extend(column.map(|k| (k, As::Label)));
        // a column that is asked for twice is read once
        let lot = lot.map(|k| match selection.iter().position(|(other, _)| *other == k) {
            Some(place) => (place, selection.get(place).is_some_and(|(_, kind)| *kind == As::Label)),
            None => {
                selection.push((k, As::Label));
                (selection.len() - 1, true)
            }
        });
        let position = layout.position.filter(|k| !selection.iter().any(|(other, _)| other == k));
        selection.extend(position.map(|k| (k, As::Label)));
        record.select(&selection);
        let places = Places {
            inputs: layout.places(|kind| kind == Use::Input),
            values: layout.places(|kind| matches!(kind, Use::Value(_))),
            others: layout.places(|kind| kind == Use::Other),
            by: column.map(|_| layout.keys.len()),
            lot,
            position: position.map(|_| selection.len() - 1),
        };
        gathering.file = Arc::from(name.as_str());
        gathering.of_file = 0;
        if tables.by.is_none() && gathering.begin(name).is_err() {
            return Err(Malformed::new(Fault::NameClash, format!("the file '{name}' is given twice"))
                .expected("each file, which is a device, once")
                .in_file(name));
        }
        let mut block = Block::default();
        while record.next(&mut block)? {
            layout.convert(&mut block);
            if let Some(again) = gathering.block(&record, &block, &places) {
                return Ok(Ended::Early(again));
            }
            let enough = if handed_on == 0 { FIRST } else { DEVICES };
            if gathering.cells >= CELLS || gathering.whole.len() >= enough {
                let mut chunk = gathering.take();
                if handed_on == 0 && counts.is_none() && tables.by.is_some() && chunk.len() > FIRST {
                    // a first look costs little, should they be of no use
                    let rest = chunk.split_off(FIRST);
                    if !sink(chunk, &layout)? {
                        return Ok(Ended::Early(Restart::OfNoUse));
                    }
                    chunk = rest;
                }
                handed_on += chunk.len();
                sink(chunk, &layout)?;
            }
            if counts.is_none() {
                record.forget_labels();
                gathering.number = None;
            }
        }
        gathering.number = None;
        if tables.by.is_none() {
            gathering.end();
        }
    }
    gathering.finish();
    let read = Read { rows: gathering.rows, blanks_differ: std::mem::take(&mut gathering.blanks_differ) };
    let chunk = gathering.take();
    if !chunk.is_empty() {
        sink(chunk, first.as_ref().unwrap_or(&Layout::default()))?;
    }
    Ok(Ended::Whole(read))
}

/// Where a block has what.
struct Places {
    inputs: Vec<usize>,
    values: Vec<usize>,
    others: Vec<usize>,
    by: Option<usize>,
    /// And whether it has labels, not numbers.
    lot: Option<(usize, bool)>,
    position: Option<usize>,
}

/// A row without a label.
const NONE: usize = usize::MAX;

/// Devices that are whole, and those that are not yet.
#[derive(Default)]
struct Gathering<'a> {
    counts: Option<&'a Counts>,
    /// Devices that are not whole, and how many rows each has; what was whole left an empty one.
    open: Vec<(Device, u64)>,
    /// The one that is being gathered, and its label's number where that is known.
    current: Option<usize>,
    number: Option<usize>,
    /// With counts: the open device of each label.
    of_label: HashMap<String, usize>,
    whole: Vec<Device>,
    /// Digests of devices that were handed on; two that agree by chance cost a second pass, and nothing else.
    done: HashSet<u64>,
    /// Rows without a label.
    nameless: Device,
    blanks_differ: Vec<String>,
    cells: usize,
    file: Arc<str>,
    of_file: u64,
    rows: u64,
}

impl Gathering<'_> {
    /// The place of a device that begins, or goes on; `Err` for one that has been handed on.
    fn begin(&mut self, label: &str) -> std::result::Result<usize, Restart> {
        if let Some(current) = self.current
            && self.open.get(current).is_some_and(|(device, _)| device.label == label)
        {
            // a device that goes on in the next block or file
            return Ok(current);
        }
        let expected = match self.counts {
            // every label was counted
            Some(counts) => counts.get(label).copied().unwrap_or_default(),
            None => {
                self.end();
                let digest = digest(label);
                if !self.done.insert(digest) {
                    return Err(Restart::CameBack { label: label.to_string(), row: self.rows + 1 });
                }
                u64::MAX
            }
        };
        let device = Device { label: label.to_string(), first_row: self.rows + 1, ..Device::default() };
        if self.counts.is_none() {
            self.open.clear();
        }
        self.open.push((device, expected));
        Ok(*self.current.insert(self.open.len() - 1))
    }

    /// No more rows of the current device follow.
    fn end(&mut self) {
        if let Some(current) = self.current.take() {
            self.is_whole(current);
        }
    }

    fn is_whole(&mut self, place: usize) {
        let Some((device, _)) = self.open.get_mut(place) else { return };
        let mut device = std::mem::take(device);
        device.order_positions();
        self.cells += device.inputs.len() + device.values.len() + 4 * device.others.len();
        self.whole.push(device);
    }

    fn finish(&mut self) {
        if self.counts.is_none() {
            self.end();
        }
        // fewer rows than were counted: the file has changed meanwhile
        let rest = std::mem::take(&mut self.open).into_iter().map(|(device, _)| device);
        self.whole.extend(rest.filter(|device| device.rows > 0));
        if self.nameless.rows > 0 {
            self.whole.push(std::mem::take(&mut self.nameless));
        }
    }

    fn take(&mut self) -> Vec<Device> {
        self.cells = 0;
        std::mem::take(&mut self.whole)
    }

    /// The place of the device of a label's number; `NONE` for a row without one.
    fn device_of(&mut self, record: &Record, number: usize) -> std::result::Result<usize, Restart> {
        if let (Some(current), true) = (self.current, self.number == Some(number)) {
            return Ok(current);
        }
        let label = label(record, number);
        if let Some(there) = self.of_label.get(label) {
            return Ok(*there);
        }
        if label.trim().is_empty() {
            return Ok(NONE);
        }
        let found = self.begin(label);
        match (self.counts, &found) {
            (Some(_), Ok(there)) => {
                self.of_label.insert(label.to_string(), *there);
                self.current = None;
            }
            _ => self.number = Some(number),
        }
        found
    }

    /// The rows of a block, run by run.
    fn block(&mut self, record: &Record, block: &Block, places: &Places) -> Option<Restart> {
        let column = |k: usize| block.columns.at(k);
        let select = |of: &[usize]| of.iter().map(|k| column(*k)).collect::<Vec<&[f64]>>();
        let (inputs, values, others) = (select(&places.inputs), select(&places.values), select(&places.others));
        let by = places.by.map(column);
        let of = |by: &[f64], row: usize| by.get(row).copied().map_or(0, place);
        let positions = places.position.map(column).unwrap_or_default();
        // labels of positions by their number in the record
        let mut labels: Vec<Option<Arc<str>>> = Vec::new();
        self.say_blanks(record, by.unwrap_or_default());
        let mut row = 0;
        while row < block.rows() {
            let number = by.map(|by| of(by, row));
            let end = match (by, number) {
                (Some(by), Some(label)) => (row..block.rows()).find(|k| of(by, *k) != label).unwrap_or(block.rows()),
                _ => block.rows(),
            };
            let there = match number.map(|number| self.device_of(record, number)) {
                Some(Ok(there)) => there,
                Some(Err(again)) => return Some(again),
                // there is one: begun with the file
                None => self.current.unwrap_or_default(),
            };
            let lines = block.lines.get(row..end);
            let first = self.of_file + row as u64 + 1;
            let file = self.file.clone();
            self.rows += (end - row) as u64;
            if there == NONE {
                self.nameless.nameless = true;
                self.nameless.rows += end - row;
                if self.nameless.runs.is_empty() {
                    push_runs(&mut self.nameless, &file, lines, (first, end - row));
                }
                row = end;
                continue;
            }
            let Some((device, expected)) = self.open.get_mut(there) else { break };
            if device.rows == 0 && *expected < u64::MAX {
                let more = number::index(*expected);
                device.inputs.reserve_exact(more * inputs.len());
                device.values.reserve_exact(more * values.len());
            }
            interleave(&inputs, row, end, &mut device.inputs);
            interleave(&values, row, end, &mut device.values);
            if !others.is_empty() {
                for k in row..end {
                    let text = |of: &&[f64]| label(record, of.get(k).copied().map_or(0, place)).to_string();
                    device.others.extend(others.iter().map(text));
                }
            }
            for cell in positions.iter().take(end).skip(row) {
                let number = place(*cell);
                if labels.len() <= number {
                    labels.resize(number + 1, None);
                }
                let position = labels
                    .get_mut(number)
                    .map(|position| position.get_or_insert_with(|| label(record, number).into()).clone());
                position.iter().for_each(|position| device.push_position(position));
            }
            if let Some((lot, labelled)) = places.lot.filter(|_| device.rows == 0) {
                let cell = column(lot).get(row).copied();
                device.lot = match labelled {
                    true => label(record, cell.map_or(0, place)).to_string(),
                    false => cell.filter(|x| x.is_finite()).map_or_else(String::new, |x| x.to_string()),
                };
            }
            push_runs(device, &file, lines, (first, end - row));
            device.rows += end - row;
            if device.rows as u64 >= *expected {
                self.is_whole(there);
                number.and_then(|number| self.of_label.remove(label(record, number)));
            }
            row = end;
        }
        self.of_file += block.rows() as u64;
        None
    }

    /// Note labels of devices that the record found with different blanks.
    fn say_blanks(&mut self, record: &Record, by: &[f64]) {
        for number in record.blanks_differ() {
            let label = label(record, number + 1);
            if !self.blanks_differ.iter().any(|other| other == label)
                && by.iter().any(|cell| place(*cell) == number + 1)
            {
                self.blanks_differ.push(label.to_string());
            }
        }
    }
}

/// Say where rows of a device stand: in lines of a table of text, or from a row on.
fn push_runs(device: &mut Device, file: &Arc<str>, lines: Option<&[u64]>, (first, rows): (u64, usize)) {
    match lines {
        None | Some([]) => device.push_run(file, (first, rows), false),
        Some([first, .., last]) if last - first == rows as u64 - 1 => device.push_run(file, (*first, rows), true),
        Some(lines) => lines.iter().for_each(|line| device.push_run(file, (*line, 1), true)),
    }
}

/// Columns to rows.
fn interleave(columns: &[&[f64]], start: usize, end: usize, to: &mut Vec<f64>) {
    let width = columns.len();
    let begin = to.len();
    to.resize(begin + width * (end - start), 0.0);
    for (place, column) in columns.iter().enumerate() {
        let from = column.part(start..end);
        let cells = to.iter_mut().skip(begin + place).step_by(width.max(1));
        cells.zip(from).for_each(|(cell, x)| *cell = *x);
    }
}

fn digest(label: &str) -> u64 {
    use std::hash::{BuildHasher, BuildHasherDefault, DefaultHasher};
    BuildHasherDefault::<DefaultHasher>::default().hash_one(label)
}

impl Layout {
    fn places(&self, of: impl Fn(Use) -> bool) -> Vec<usize> {
        self.uses.iter().enumerate().filter(|(_, kind)| of(**kind)).map(|(k, _)| k).collect()
    }

    /// The same columns in the order of another table's; `None` where they are others.
    fn in_the_order_of(&self, other: &Layout) -> Option<Layout> {
        let mut ordered = Layout::default();
        for key in &other.keys {
            let k = self.keys.iter().position(|own| own == key)?;
            ordered.keys.push(key.clone());
            ordered.columns.push(*self.columns.get(k)?);
            ordered.uses.push(*self.uses.get(k)?);
            ordered.conversions.push(*self.conversions.get(k)?);
        }
        ordered.position = self.position;
        (ordered.keys.len() == self.keys.len()).then_some(ordered)
    }
}
