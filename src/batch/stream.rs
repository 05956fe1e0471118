//! A table of many devices, device by device, in memory bound by a chunk as long as each device's rows stand together.

use super::{Device, Layout, Use};
use crate::elements::{Elements, Parts};
use crate::error::{Fault, Malformed, Result};
use crate::number;
use crate::record::{As, Block, Record};
use std::collections::{HashMap, HashSet};

/// Cells of the devices that are handed on together.
const CELLS: usize = 1 << 20;
/// Devices that are handed on together.
const DEVICES: usize = 1 << 13;

/// How many rows each device has in all the files.
pub type Counts = HashMap<String, u64>;

/// How a pass over the files ended.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Ended {
    /// Every device was handed on once.
    Whole {
        /// Rows read.
        rows: u64,
    },
    /// A device that had been handed on came back: rows of devices do not stand together, and [`count`] is needed before.
    CameBack {
        /// The device.
        label: String,
        /// The row (counted from 1, over all files).
        row: u64,
    },
}

/// The column that tells devices apart.
///
/// Errors: `UnknownName` where the table has no such column.
fn by_column(record: &Record, by: &str) -> Result<usize> {
    record.find(by)
}

/// Count the rows of each device: what a table needs in which rows of devices do not stand together.
pub fn count(files: usize, open: &dyn Fn(usize) -> Result<Record>, by: &str) -> Result<Counts> {
    let mut counts = Counts::new();
    for file in 0..files {
        let mut record = open(file)?;
        let column = by_column(&record, by)?;
        record.select(&[(column, As::Label)]);
        let (mut block, mut of_label) = (Block::default(), Vec::<u64>::new());
        while record.next(&mut block)? {
            // one column is read
            for number in block.columns.first().map(Vec::as_slice).unwrap_or_default() {
                let k = place(*number);
                if k >= of_label.len() {
                    of_label.resize(k + 1, 0);
                }
                of_label.get_mut(k).into_iter().for_each(|n| *n += 1);
            }
        }
        for (k, n) in of_label.into_iter().enumerate().filter(|(_, n)| *n > 0) {
            *counts.entry(label(&record, k)).or_default() += n;
        }
    }
    Ok(counts)
}

/// The place of a label in the record's list, plus one; 0 for a row without one.
fn place(number: f64) -> usize {
    if number.is_nan() { 0 } else { number::count(number) + 1 }
}

fn label(record: &Record, place: usize) -> String {
    // place 0: a cell that is empty
    place.checked_sub(1).and_then(|k| record.labels().get(k)).cloned().unwrap_or_default()
}

/// Hand on every device of the files, in chunks; `layout` is the table's, by its columns.
///
/// Without `by` each file is a device, under the name that `names` gives it. Without `counts` a device is whole where the next one begins.
/// Errors: those of the record, files with other columns than the first.
pub fn stream(
    files: &[String],
    open: &dyn Fn(usize) -> Result<Record>,
    by: Option<&str>,
    lot: Option<&str>,
    layout: &dyn Fn(&Record, Option<usize>) -> Result<Layout>,
    counts: Option<&Counts>,
    sink: &mut dyn FnMut(Vec<Device>, &Layout) -> Result<()>,
) -> Result<Ended> {
    let mut gathering = Gathering { counts, ..Gathering::default() };
    let mut first: Option<Layout> = None;
    for (file, name) in files.iter().enumerate() {
        let mut record = open(file)?;
        let column = by.map(|by| by_column(&record, by)).transpose()?;
        let lot = lot.map(|lot| record.find(lot)).transpose()?;
        let own = layout(&record, column)?;
        let own = match &first {
            None => first.insert(own).clone(),
            Some(before) => own.in_the_order_of(before).ok_or_else(|| {
                Malformed::new(Fault::Missing, format!("'{name}' has other columns than the first file"))
                    .expected(before.keys.join(", "))
                    .found(own.keys.join(", "))
                    .in_file(name)
            })?,
        };
        let mut selection = own.selection();
        selection.extend(column.map(|k| (k, As::Label)));
        selection.extend(lot.map(|k| (k, As::Label)));
        // a column that is asked for twice is read once
        let lot_place = lot.map(|k| match column {
            Some(by) if by == k => own.keys.len(),
            _ => own.keys.len() + usize::from(column.is_some()),
        });
        if lot.is_some() && lot == column {
            selection.pop();
        }
        record.select(&selection);
        let places = Places {
            inputs: own.places(|kind| kind == Use::Input),
            values: own.places(|kind| matches!(kind, Use::Value(_))),
            others: own.places(|kind| kind == Use::Other),
            by: column.map(|_| own.keys.len()),
            lot: lot_place,
        };
        if by.is_none() {
            gathering.begin(name.clone())?;
        }
        let mut block = Block::default();
        let mut current = None;
        while record.next(&mut block)? {
            own.convert(&mut block);
            if let Some(back) = gathering.block(&record, &block, &places, &mut current)? {
                return Ok(back);
            }
            if gathering.cells >= CELLS || gathering.whole.len() >= DEVICES {
                sink(gathering.take(), &own)?;
            }
        }
        if by.is_none() {
            gathering.end();
        }
    }
    gathering.finish();
    let rows = gathering.rows;
    while !gathering.whole.is_empty() {
        sink(gathering.take(), first.as_ref().unwrap_or(&Layout::default()))?;
    }
    Ok(Ended::Whole { rows })
}

/// Where a block has what.
struct Places {
    inputs: Vec<usize>,
    values: Vec<usize>,
    others: Vec<usize>,
    by: Option<usize>,
    lot: Option<usize>,
}

/// Devices that are whole, and those that are not yet.
#[derive(Default)]
struct Gathering<'a> {
    counts: Option<&'a Counts>,
    /// Devices that are not whole, the last one being gathered.
    open: HashMap<String, Device>,
    current: Option<Device>,
    whole: Vec<Device>,
    /// Digests of devices that were handed on; two that agree by chance cost a second pass, and nothing else.
    done: HashSet<u64>,
    cells: usize,
    rows: u64,
}

impl Gathering<'_> {
    fn begin(&mut self, label: String) -> Result<Option<Ended>> {
        if self.current.as_ref().is_some_and(|device| device.label == label) {
            // a device that goes on in the next file
            return Ok(None);
        }
        self.end();
        let first_row = self.rows + 1;
        if self.counts.is_none() && self.done.contains(&digest(&label)) {
            return Ok(Some(Ended::CameBack { label, row: first_row }));
        }
        let new = || Device { label: label.clone(), first_row, ..Device::default() };
        self.current = Some(self.open.remove(&label).unwrap_or_else(new));
        Ok(None)
    }

    /// No more rows of the current device follow here.
    fn end(&mut self) {
        let Some(device) = self.current.take() else { return };
        let whole = self.counts.is_none_or(|counts| counts.get(&device.label).is_none_or(|n| *n <= device.rows as u64));
        if !whole {
            self.open.insert(device.label.clone(), device);
            return;
        }
        self.cells += device.inputs.len() + device.values.len() + 4 * device.others.len();
        if self.counts.is_none() {
            self.done.insert(digest(&device.label));
        }
        self.whole.push(device);
    }

    fn finish(&mut self) {
        self.end();
        let mut rest: Vec<Device> = std::mem::take(&mut self.open).into_values().collect();
        rest.sort_by_key(|device| device.first_row);
        self.whole.extend(rest);
    }

    fn take(&mut self) -> Vec<Device> {
        self.cells = 0;
        std::mem::take(&mut self.whole)
    }

    /// The rows of a block, run by run.
    fn block(
        &mut self,
        record: &Record,
        block: &Block,
        places: &Places,
        current: &mut Option<usize>,
    ) -> Result<Option<Ended>> {
        let column = |k: usize| block.columns.at(k);
        let select = |of: &[usize]| of.iter().map(|k| column(*k)).collect::<Vec<&[f64]>>();
        let (inputs, values, others) = (select(&places.inputs), select(&places.values), select(&places.others));
        let mut row = 0;
        while row < block.rows() {
            let mut end = block.rows();
            if let Some(by) = places.by.map(column) {
                let of = |row: usize| by.get(row).copied().map_or(0, place);
                let own = of(row);
                end = (row..block.rows()).find(|k| of(*k) != own).unwrap_or(block.rows());
                if *current != Some(own) {
                    *current = Some(own);
                    if let Some(back) = self.begin(label(record, own))? {
                        return Ok(Some(back));
                    }
                }
            }
            let Some(device) = &mut self.current else { break };
            interleave(&inputs, row, end, &mut device.inputs);
            interleave(&values, row, end, &mut device.values);
            if !others.is_empty() {
                for k in row..end {
                    let text = |of: &&[f64]| label(record, of.get(k).copied().map_or(0, place));
                    device.others.extend(others.iter().map(text));
                }
            }
            if let Some(lot) = places.lot.map(column).filter(|_| device.rows == 0) {
                device.lot = label(record, lot.get(row).copied().map_or(0, place));
            }
            device.rows += end - row;
            self.rows += (end - row) as u64;
            row = end;
        }
        Ok(None)
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
        (ordered.keys.len() == self.keys.len()).then_some(ordered)
    }
}
