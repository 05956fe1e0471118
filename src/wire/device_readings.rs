//! The readings of one device of a table of many: cells that were read as columns become the readings that a file of this device alone has.

use super::Named;
use super::readings_file::{Cell, ReadingFile, from_cells};
use crate::batch::{Device, Layout, Use};
use crate::bench::Bench;
use crate::campaign::Readings;
use crate::error::{Malformed, Result};
use crate::record::UNREADABLE;

/// The readings of a device, with the numeric columns of the whole table.
///
/// Errors: those of a file of readings; places are readings of the device, counted from 1.
pub fn device_readings(bench: &Bench, layout: &Layout, device: &Device) -> Result<Readings> {
    let rows: Vec<_> =
        (0..device.rows).map(|row| (format!("reading {}", row + 1), cells(layout, device, row))).collect();
    let mut readings = from_cells(bench, rows)?;
    // a column that this device has no number in is a column all the same
    let mut wanted = layout.numeric(bench);
    wanted.extend(readings.columns.iter().filter(|own| !wanted.contains(own)).cloned().collect::<Vec<_>>());
    if wanted != readings.columns {
        let from: Vec<Option<usize>> =
            wanted.iter().map(|name| readings.columns.iter().position(|own| own == name)).collect();
        for reading in &mut readings.rows {
            reading.columns = from.iter().map(|k| k.and_then(|k| reading.columns.get(k).copied().flatten())).collect();
        }
        readings.columns = wanted;
    }
    Ok(readings)
}

fn cells(layout: &Layout, device: &Device, row: usize) -> ReadingFile {
    let count = |of: &dyn Fn(&Use) -> bool| layout.uses.iter().filter(|kind| of(kind)).count();
    let [inputs, values, others] = [
        count(&|kind| *kind == Use::Input),
        count(&|kind| matches!(kind, Use::Value(_))),
        count(&|kind| *kind == Use::Other),
    ];
    let (mut next_input, mut next_value, mut next_other) = (0, 0, 0);
    let mut found = Vec::with_capacity(layout.keys.len());
    for (key, kind) in layout.keys.iter().zip(&layout.uses) {
        let (width, next) = match kind {
            Use::Input => (inputs, &mut next_input),
            Use::Value(_) => (values, &mut next_value),
            Use::Other => (others, &mut next_other),
        };
        let place = row * width + *next;
        *next += 1;
        let cell = match kind {
            Use::Input => number(device.inputs.get(place).copied()),
            Use::Value(_) => number(device.values.get(place).copied()),
            Use::Other => text(key, device.others.get(place).map_or("", String::as_str)),
        };
        found.push((key.clone(), cell));
    }
    Named(found)
}

pub(super) fn number(cell: Option<f64>) -> Cell {
    match cell {
        None => Cell::Nothing(()),
        Some(value) if value.to_bits() == UNREADABLE.to_bits() => Cell::Text("a cell that is no number".into()),
        Some(value) if value.is_nan() => Cell::Nothing(()),
        Some(value) => Cell::Number(value),
    }
}

pub(super) fn text(key: &str, cell: &str) -> Cell {
    match cell.parse::<f64>() {
        _ if cell.is_empty() => Cell::Nothing(()),
        Ok(value) if key != "position" => Cell::Number(value),
        _ => Cell::Text(cell.into()),
    }
}

/// A table of many devices from readings that stand in a campaign file itself.
///
/// Errors: lists (they belong to schedules).
pub fn inline_devices(
    bench: &Bench,
    rows: Vec<ReadingFile>,
    by: &str,
    others: impl Fn(&str) -> bool,
) -> Result<(Layout, Vec<Device>)> {
    use crate::error::Fault;
    use crate::record::Column;
    let mut columns: Vec<Column> = Vec::new();
    for (key, _) in rows.iter().flat_map(|row| &row.0) {
        if !columns.iter().any(|own| own.title == *key) {
            columns.push(Column { name: key.clone(), title: key.clone(), unit: None });
        }
    }
    let Some(by_column) = columns.iter().position(|own| own.title == by) else {
        return Err(Malformed::new(Fault::UnknownName, format!("the readings have no column '{by}'"))
            .expected(format!("one of {}", crate::record::listed(&columns)))
            .found(format!("'{by}'")));
    };
    let layout = Layout::of(bench, &columns, Some(by_column), others);
    let mut devices: Vec<Device> = Vec::new();
    let mut places = std::collections::HashMap::<String, usize>::new();
    for (k, row) in rows.iter().enumerate() {
        if let Some((key, _)) = row.0.iter().find(|(_, cell)| matches!(cell, Cell::List(_))) {
            return Err(Malformed::new(Fault::Value, "readings of many devices have no lists")
                .expected("one number")
                .at_path(format!("readings[{k}].{key}")));
        }
        let written = |cell: Option<&Cell>| match cell {
            Some(Cell::Number(x)) => x.to_string(),
            Some(Cell::Text(text)) => text.clone(),
            _ => String::new(),
        };
        let label = written(row.get(by));
        let place = *places.entry(label.clone()).or_insert_with(|| {
            devices.push(Device { label, first_row: k as u64 + 1, ..Device::default() });
            devices.len() - 1
        });
        let Some(device) = devices.get_mut(place) else { continue };
        device.rows += 1;
        for (key, kind) in layout.keys.iter().zip(&layout.uses) {
            let number = match row.get(key) {
                Some(Cell::Number(x)) => *x,
                Some(Cell::Text(_)) => UNREADABLE,
                _ => f64::NAN,
            };
            match kind {
                Use::Input => device.inputs.push(number),
                Use::Value(_) => device.values.push(number),
                Use::Other => device.others.push(written(row.get(key))),
            }
        }
    }
    Ok((layout, devices))
}
