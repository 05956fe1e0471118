//! Positions that were met, each evaluated once; what rows say that are no readings.

use crate::question::Bound;
use datafusion::arrow::array::{Array, ArrayRef, AsArray, StringArray};
use datafusion::arrow::datatypes::Float64Type;
use datafusion::common::{Result, exec_datafusion_err};
use std::collections::HashMap;
use tumble::batch::{DesignRow, Device, Use};
use tumble::record::UNREADABLE;

/// What a row says of a value: nothing read, a value, or what is wrong.
pub(crate) type Lines = Vec<std::result::Result<DesignRow, String>>;

/// Positions that were met, with the rows of the design that they have.
#[derive(Debug, Default)]
pub(crate) struct Positions {
    pub(crate) places: HashMap<Vec<u64>, u32>,
    /// Of each position, what identifies it, one after the other.
    pub(crate) keys: Vec<u64>,
    /// The position that followed the last time.
    pub(crate) next: Vec<u32>,
    /// A line for each sensor, or why a row at this position is no reading.
    pub(crate) lines: Vec<std::result::Result<Lines, String>>,
}

impl Positions {
    /// The cells of a position.
    pub(crate) fn key(&self, position: u32, width: usize) -> Vec<f64> {
        let place = position as usize * width;
        let key = self.keys.get(place..place + width).unwrap_or_default();
        key.iter().map(|bits| if *bits == u64::MAX { f64::NAN } else { f64::from_bits(*bits) }).collect()
    }

    /// The place of a position; a new one gets one.
    pub(crate) fn find(&mut self, key: &[u64], before: Option<u32>) -> u32 {
        let width = key.len();
        if let Some(next) = before.and_then(|place| self.next.get(place as usize)).copied()
            && self.keys.get(next as usize * width..(next as usize + 1) * width) == Some(key)
        {
            return next;
        }
        let place = match self.places.get(key) {
            Some(place) => *place,
            None => {
                let place = self.next.len() as u32;
                self.places.insert(key.to_vec(), place);
                self.keys.extend_from_slice(key);
                self.next.push(0);
                place
            }
        };
        if let Some(next) = before.and_then(|place| self.next.get_mut(place as usize)) {
            *next = place;
        }
        place
    }

    /// Lines of the positions from here on.
    pub(crate) fn evaluate(&mut self, bound: &Bound, from: usize) {
        let width = bound.position.len();
        let count = self.next.len() - from;
        let keys = self.keys.get(from * width..).unwrap_or_default();
        let key = |k: usize| keys.get(k * width..(k + 1) * width).unwrap_or_default();
        let all: Vec<usize> = (0..bound.sensors.len()).collect();
        let several: Vec<&[u64]> = (0..count).map(key).collect();
        match lines(bound, &several, &all) {
            Ok(found) => {
                let found = found.into_iter().map(|own| Ok(own.into_iter().map(Ok).collect()));
                self.lines.extend(found);
            }
            // which of them is wrong, and in which sensor
            Err(_) => self.lines.extend(several.iter().map(|key| {
                lines(bound, &[key], &[]).map_err(|error| said(&error))?;
                let of = |sensor: &usize| {
                    let own = lines(bound, &[key], &[*sensor]).map_err(|error| said(&error))?;
                    own.into_iter().flatten().next().ok_or_else(|| "no line".to_string())
                };
                Ok(all.iter().map(of).collect())
            })),
        }
    }
}

/// The lines of some positions, for some of the sensors that are read; without any, only whether these are positions.
fn lines(bound: &Bound, keys: &[&[u64]], sensors: &[usize]) -> tumble::Result<Vec<Vec<DesignRow>>> {
    let mut device = Device { rows: keys.len(), ..Device::default() };
    for key in keys {
        for (place, kind) in bound.layout.uses.iter().enumerate() {
            if *kind == Use::Input {
                let own = bound.position.iter().position(|own| *own == place).and_then(|k| key.get(k));
                device.inputs.push(
                    own.map_or(f64::NAN, |bits| if *bits == u64::MAX { f64::NAN } else { f64::from_bits(*bits) }),
                );
            }
        }
        let values = bound.sensors.iter().enumerate();
        device.values.extend(values.map(|(k, _)| if sensors.contains(&k) { 0.0 } else { f64::NAN }));
    }
    let readings = tumble::wire::device_readings(&bound.template.bench, &bound.layout, &device)?;
    let mut found: Vec<Vec<DesignRow>> = keys.iter().map(|_| Vec::with_capacity(sensors.len())).collect();
    let Some(parts) = bound.parts.as_ref().filter(|_| !sensors.is_empty()) else { return Ok(found) };
    for line in parts.lines(readings)? {
        if let Some(own) = found.get_mut(line.reading) {
            own.push(line);
        }
    }
    // in the order of the sensors that are read
    let place = |sensor: usize| bound.sensors.iter().position(|(own, ..)| *own == sensor);
    found.iter_mut().for_each(|own| own.sort_by_key(|line| place(line.sensor)));
    Ok(found)
}

/// Why a row with such numbers is no reading, in the words of a fit.
pub(crate) fn refused(bound: &Bound, columns: &[Vec<f64>], row: usize) -> String {
    let cells = |of: &dyn Fn(&Use) -> bool| -> Vec<f64> {
        let places = bound.layout.uses.iter().enumerate().filter(|(_, kind)| of(kind));
        places.map(|(k, _)| columns.get(k).and_then(|column| column.get(row)).copied().unwrap_or(f64::NAN)).collect()
    };
    let inputs = cells(&|kind| *kind == Use::Input);
    let values = cells(&|kind| matches!(kind, Use::Value(_)));
    let device = Device { rows: 1, inputs, values, ..Device::default() };
    let own = bound.campaign(&device).and_then(|campaign| tumble::fit(&campaign, &bound.settings));
    own.err().map_or_else(|| "a reading beyond the numbers that a fit can square".to_string(), |error| said(&error))
}

/// An error without its place: a row of a table has none.
pub(crate) fn said(error: &tumble::Malformed) -> String {
    let mut text = error.what().to_string();
    if let Some(expected) = error.expectation() {
        text += &format!("; expected: {expected}");
    }
    if let Some(found) = error.finding() {
        text += &format!("; found: {found}");
    }
    text
}

/// A column of numbers; what is absent is NaN, and a text that is no number is marked as such: it is the answer of its device.
pub(crate) fn numbers(array: &ArrayRef) -> Result<Vec<f64>> {
    if let Some(column) = array.as_primitive_opt::<Float64Type>() {
        return Ok(match column.null_count() {
            0 => column.values().to_vec(),
            _ => column.iter().map(|x| x.unwrap_or(f64::NAN)).collect(),
        });
    }
    let number = |text: Option<&str>| match text.map(str::trim) {
        None | Some("") => f64::NAN,
        Some(text) => text.parse().unwrap_or(UNREADABLE),
    };
    let texts: &StringArray = array
        .as_string_opt::<i32>()
        .ok_or_else(|| exec_datafusion_err!("a column of {} where numbers are expected", array.data_type()))?;
    Ok(texts.iter().map(number).collect())
}
