//! Readings from a table of any format that a record may have, and from the rows of one device of a table of many.

use super::Named;
use super::columns::{Column, columns};
use super::readings_file::{Cell, CellRows, MOST_READINGS, ReadingFile, Says, Times, Written, from_cells, too_many};
use crate::batch::{Device, Layout, Use};
use crate::bench::Bench;
use crate::campaign::{Place, Readings, ScatterRequest};
use crate::elements::Elements;
use crate::error::{Fault, Malformed, Result};
use crate::record::{self, As, Block, RAGGED, Record, Said, UNREADABLE};
use crate::units::Conversion;
use std::sync::Arc;

/// The readings of a table; `map` has the titles of columns with names of their own, `scatter` says what is read beside the model lines. Empty cells are absent values, `position` is a text, every other cell
/// that looks like a number is one.
///
/// Errors: those of the record; a joint, sensor or uncertainty that is not a number, with its line (of other formats the row, from 1) and column.
pub fn read_readings(
    bench: &Bench,
    mut record: Record,
    map: &Named<String>,
    scatter: &[ScatterRequest],
) -> Result<Readings> {
    let (keys, blocks) = read_blocks(bench, &mut record, map, &|key| ScatterRequest::use_key(scatter, key))?;
    if blocks.iter().all(|block| block.rows() == 0) {
        return Err(Malformed::new(Fault::Missing, "the table has no readings")
            .expected("rows with values below its titles")
            .in_file(record.name()));
    }
    let rows = Rows::of(&keys, &blocks, &record);
    from_cells(bench, &rows).map_err(|error| match record.is_named() || error.fault() != Fault::Missing {
        true => error,
        false => error
            .expected("a line of titles (alpha_deg, V, ...) with as many cells as the rows; where commas separate the cells, numbers with decimal points")
            .found(format!("rows of {} cells, and no such line", keys.len())),
    })
}

/// The rows of a table under the keys of readings, those cells that are not empty; what they lack of a reading is for others to say.
///
/// Errors: those of the record.
pub(crate) fn table_cells(bench: &Bench, mut record: Record) -> Result<Vec<ReadingFile>> {
    let (keys, blocks) = read_blocks(bench, &mut record, &Named::default(), &|_| false)?;
    let rows = Rows::of(&keys, &blocks, &record);
    let mut found = Vec::new();
    rows.visit(&mut |_, cells| {
        let filled = cells.iter().filter_map(|(k, says)| {
            let cell = match says {
                Says::Number(value) => Cell::Number(*value),
                Says::Text(text) => Cell::Text(text.to_string()),
                Says::Nothing => return None,
            };
            Some((keys.get(*k)?.0.clone(), cell))
        });
        found.push(Named(filled.collect()));
        Ok(())
    })?;
    Ok(found)
}

/// The key of each column of a table, and how its numbers convert to the key's unit.
///
/// Errors: two columns for one key, a unit that does not convert.
pub(crate) fn table_keys(bench: &Bench, record: &Record) -> Result<Vec<(String, Option<Conversion>)>> {
    columns(bench, record.columns(), &Named::default(), &|_| false, record.name())
}

fn read_blocks(
    bench: &Bench,
    record: &mut Record,
    map: &Named<String>,
    others: &dyn Fn(&str) -> bool,
) -> Result<(Vec<Column>, Vec<Block>)> {
    let keys = columns(bench, record.columns(), map, &others, record.name())?;
    if keys.is_empty() {
        return Err(Malformed::new(Fault::Missing, "the table has no column").in_file(record.name()));
    }
    let kind = |(key, _): &Column| if key == "position" { As::Label } else { As::Mixed };
    record.select(&keys.iter().enumerate().map(|(k, key)| (k, kind(key))).collect::<Vec<_>>());
    let (mut blocks, mut count) = (Vec::new(), 0);
    loop {
        let mut block = Block::default();
        if !record.next(&mut block)? {
            break;
        }
        count += block.rows();
        if count as f64 > MOST_READINGS {
            return Err(too_many(count).in_file(record.name()));
        }
        for ((_, conversion), column) in keys.iter().zip(&mut block.columns) {
            if let Some(conversion) = conversion {
                column.iter_mut().filter(|v| !v.is_nan()).for_each(|v| *v = conversion.apply(*v));
            }
        }
        blocks.push(block);
    }
    Ok((keys, blocks))
}

/// The rows of a table that was read.
struct Rows<'a> {
    keys: &'a [Column],
    blocks: &'a [Block],
    labels: &'a [String],
    file: Arc<str>,
}

impl<'a> Rows<'a> {
    fn of(keys: &'a [Column], blocks: &'a [Block], record: &'a Record) -> Self {
        Rows { keys, blocks, labels: record.labels(), file: record.name().into() }
    }

    /// Where a row of a block stands.
    fn place(&self, block: usize, row: usize) -> Place {
        let line = self.blocks.get(block).and_then(|b| b.lines.get(row));
        let number = || {
            let before: usize = self.blocks.iter().take(block).map(Block::rows).sum();
            (before + row + 1) as u64
        };
        Place::Row { is_text: line.is_some(), number: line.copied().unwrap_or_else(number), file: self.file.clone() }
    }
}

impl CellRows for Rows<'_> {
    fn keys(&self) -> Vec<&str> {
        self.keys.iter().map(|(key, _)| key.as_str()).collect()
    }

    fn visit(&self, see: &mut dyn FnMut(&dyn Fn() -> Place, &[(usize, Says<'_>)]) -> Result<()>) -> Result<()> {
        let text = |label: usize| self.labels.get(label).map_or("", String::as_str);
        let is_label: Vec<bool> = self.keys.iter().map(|(key, _)| key == "position").collect();
        let mut cells = Vec::with_capacity(self.keys.len());
        for (b, block) in self.blocks.iter().enumerate() {
            for k in 0..block.rows() {
                cells.clear();
                cells.extend(
                    block
                        .columns
                        .iter()
                        .zip(&is_label)
                        .map(|(column, is_label)| match record::said(column.at(k)) {
                            Said::Number(label) if *is_label => match text(crate::number::count(label)) {
                                "" => Says::Nothing,
                                label => Says::Text(label),
                            },
                            Said::Number(value) => Says::Number(value),
                            Said::Nothing => Says::Nothing,
                            Said::Text(label) => Says::Text(text(label)),
                        })
                        .enumerate(),
                );
                // a spreadsheet has empty rows below its table, too
                if cells.iter().all(|(_, says)| matches!(says, Says::Nothing)) {
                    continue;
                }
                see(&|| self.place(b, k), &cells)?;
            }
        }
        Ok(())
    }
}

/// The columns of a table that matter to a campaign, under the keys that `map` gives them.
///
/// Errors: a column that the map names and the table has not, two columns for one key, a unit that does not convert.
pub fn table_layout(
    bench: &Bench,
    record: &Record,
    by: Option<usize>,
    map: &Named<String>,
    others: impl Fn(&str) -> bool,
) -> Result<Layout> {
    let keys = columns(bench, record.columns(), map, &others, record.name())?;
    Ok(Layout::keyed(bench, &keys, by, others))
}

/// The readings of a device, with the numeric columns of the whole table.
///
/// Errors: those of a file of readings, rows without a label; places are rows of the table, or readings of the device (counted from 1) where these are not known.
pub fn device_readings(bench: &Bench, layout: &Layout, device: &Device) -> Result<Readings> {
    let place = |row: usize| match device.origin(row) {
        Some(("", number, false)) => Place::Entry(crate::number::index(number.saturating_sub(1))),
        Some((file, number, is_text)) => Place::Row { is_text, number, file: file.into() },
        None => Place::Path(format!("reading {}", row + 1).into()),
    };
    if device.nameless {
        let what = match device.rows {
            1 => "a row has no label of a device".to_string(),
            several => format!("{several} rows have no label of a device"),
        };
        return Err(Malformed::new(Fault::Missing, what)
            .expected("a label in every row, in the column that identifies the device")
            .found(if device.rows == 1 { "an empty cell" } else { "empty cells, the first of them here" })
            .at_path(place(0)));
    }
    let [inputs, values] = [|kind: &Use| *kind == Use::Input, |kind: &Use| matches!(kind, Use::Value(_))]
        .map(|of| layout.uses.iter().filter(|kind| of(kind)).count());
    let is_ragged = |row: &usize| {
        let cells = device.input(*row, inputs).iter().chain(device.value(*row, values));
        cells.into_iter().any(|cell| cell.to_bits() == RAGGED.to_bits())
    };
    if let Some(row) = (0..device.rows).find(is_ragged) {
        return Err(Malformed::new(Fault::Syntax, "a row has too few or too many cells")
            .expected("a cell for each title")
            .at_path(place(row)));
    }
    let rows: Vec<_> = (0..device.rows).map(|row| (place(row), cells(layout, device, row))).collect();
    let mut readings = from_cells(bench, &Written::new(rows))?;
    // a column that this device has no number in is a column all the same
    let mut wanted = layout.numeric(bench);
    wanted.extend(readings.columns.iter().filter(|name_read| !wanted.contains(name_read)).cloned().collect::<Vec<_>>());
    if wanted != readings.columns {
        let from: Vec<Option<usize>> =
            wanted.iter().map(|name| readings.columns.iter().position(|name_read| name_read == name)).collect();
        for reading in &mut readings.rows {
            reading.columns = from.iter().map(|k| k.and_then(|k| reading.columns.get(k).copied().flatten())).collect();
        }
        readings.columns = wanted;
    }
    Ok(readings)
}

/// A row of a device. What it holds is ordered by use: each list is walked on its own.
fn cells(layout: &Layout, device: &Device, row: usize) -> ReadingFile {
    let width = |of: &dyn Fn(&Use) -> bool| layout.uses.iter().filter(|kind| of(kind)).count();
    let from = |all: usize| row * all;
    let mut inputs = device.inputs.iter().skip(from(width(&|kind| *kind == Use::Input)));
    let mut values = device.values.iter().skip(from(width(&|kind| matches!(kind, Use::Value(_)))));
    let mut others = device.others.iter().skip(from(width(&|kind| *kind == Use::Other)));
    let cell = |((key, kind), conversion): ((&String, &Use), &Option<Conversion>)| {
        let cell = match kind {
            Use::Input => number(inputs.next()),
            Use::Value(_) => number(values.next()),
            // a label is converted here: the others are when they are read
            Use::Other => match (text(key, others.next().map_or("", String::as_str)), conversion) {
                (Cell::Number(value), Some(conversion)) => Cell::Number(conversion.apply(value)),
                (cell, _) => cell,
            },
        };
        (key.clone(), cell)
    };
    let position = Some(device.position(row)).filter(|label| !label.is_empty());
    let position = position.map(|label| ("position".to_string(), Cell::Text(label.to_string())));
    Named(layout.keys.iter().zip(&layout.uses).zip(&layout.conversions).map(cell).chain(position).collect())
}

fn number(cell: Option<&f64>) -> Cell {
    match cell {
        None => Cell::Nothing(()),
        Some(value) if value.to_bits() == UNREADABLE.to_bits() => Cell::Text("a cell that is not a number".into()),
        Some(value) if value.is_nan() => Cell::Nothing(()),
        Some(value) => Cell::Number(*value),
    }
}

fn text(key: &str, cell: &str) -> Cell {
    match cell.parse::<f64>() {
        _ if cell.is_empty() => Cell::Nothing(()),
        Ok(value) if key != "position" => Cell::Number(value),
        _ => Cell::Text(cell.into()),
    }
}

/// From here on not every whole number is a number of 64 bits.
const WHOLE: f64 = 9_007_199_254_740_992.0;

/// A table of many devices from readings that stand in a campaign file itself.
///
/// Errors: lists (they belong to schedules), labels that are numbers of more than 15 digits.
pub fn inline_devices(
    bench: &Bench,
    rows: Vec<ReadingFile>,
    by: &str,
    others: impl Fn(&str) -> bool,
) -> Result<(Layout, Vec<Device>)> {
    let mut keys: Vec<Column> = Vec::new();
    for (key, _) in rows.iter().flat_map(|row| &row.0) {
        if !keys.iter().any(|(other, _)| other == key) {
            keys.push((key.clone(), None));
        }
    }
    let Some(by_column) = keys.iter().position(|(key, _)| key == by) else {
        let titled = |(key, _): &Column| record::Column { name: key.clone(), title: key.clone(), unit: None };
        let titles: Vec<_> = keys.iter().map(titled).collect();
        return Err(Malformed::new(Fault::UnknownName, format!("the readings have no column '{by}'"))
            .expected(format!("one of {}", record::listed(&titles)))
            .found(format!("'{by}'")));
    };
    let layout = Layout::keyed(bench, &keys, Some(by_column), others);
    let mut devices: Vec<Device> = Vec::new();
    // rows of the campaign itself
    let campaign: Arc<str> = Arc::from("");
    let mut places = std::collections::HashMap::<String, usize>::new();
    let mut times = Times::of(bench, layout.keys.iter().map(String::as_str));
    for (k, row) in rows.iter().enumerate() {
        if let Some((key, _)) = row.0.iter().find(|(_, cell)| matches!(cell, Cell::List(_))) {
            return Err(Malformed::new(Fault::Value, "readings of many devices have no lists")
                .expected("one number")
                .at_path(format!("readings[{k}].{key}")));
        }
        let written = |key: &str| row.get(key).map_or(String::new(), Cell::written);
        if let Some(Cell::Number(x)) = row.get(by).filter(|cell| matches!(cell, Cell::Number(x) if x.abs() >= WHOLE)) {
            return Err(Malformed::new(Fault::Value, "a label has more digits than a number keeps")
                .expected("the label as a text, in quotes")
                .found(x.to_string())
                .at_path(format!("readings[{k}].{by}")));
        }
        let label = written(by).trim().to_string();
        let place = *places.entry(label.clone()).or_insert_with(|| {
            devices.push(Device { nameless: label.is_empty(), label, first_row: k as u64 + 1, ..Device::default() });
            devices.len() - 1
        });
        let Some(device) = devices.get_mut(place) else { continue };
        device.rows += 1;
        if layout.position.is_some() {
            device.push_position(&written("position").as_str().into());
        }
        device.push_run(&campaign, (k as u64 + 1, 1), false);
        for (k, (key, kind)) in layout.keys.iter().zip(&layout.uses).enumerate() {
            let number = match row.get(key).map(|cell| times.number(k, cell.says())) {
                Some(Some(Says::Number(x))) => x,
                Some(None | Some(Says::Text(_))) => UNREADABLE,
                _ => f64::NAN,
            };
            match kind {
                Use::Input => device.inputs.push(number),
                Use::Value(_) => device.values.push(number),
                Use::Other => device.others.push(written(key)),
            }
        }
    }
    devices.iter_mut().for_each(Device::order_positions);
    Ok((layout, devices))
}
