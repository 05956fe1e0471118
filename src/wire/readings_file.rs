//! Readings as JSON objects: joint keys, sensor keys, a position, and any further numeric column.

use super::Named;
use crate::bench::Bench;
use crate::campaign::is_axis_input;
use crate::campaign::{JointState, Observation, Reading, Readings};
use crate::design::indifferent_angles;
use crate::error::{Fault, Malformed, Result};
use crate::mix::Mix;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::cell::LazyCell;
use std::collections::{HashMap, HashSet};
use std::hash::BuildHasherDefault;

/// One reading: keys `<joint>_deg`, `<joint>_deg_s`, `<joint>_turns`, `<sensor>`, `<sensor>_u`, `n`, `position`, and any further column.
pub type ReadingFile = Named<Cell>;

/// A value of a reading.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged, expecting = "a number, a text, null, or (in a schedule) a list of numbers")]
pub enum Cell {
    /// A number.
    Number(f64),
    /// A text: the position's label, or a remark.
    Text(String),
    /// A schedule's list, which stands for one reading each.
    List(Vec<f64>),
    /// Nothing was read here.
    Nothing(()),
}

/// More readings than this are refused before their lists are expanded: each takes about a kilobyte.
pub(super) const MOST_READINGS: f64 = 2e6;

/// JSON readings to domain readings; lists of a schedule are expanded.
pub(super) fn into_readings(bench: &Bench, rows: Vec<ReadingFile>) -> Result<Readings> {
    let mut expanded = Vec::with_capacity(rows.len());
    let mut total = 0.0_f64;
    for (k, row) in rows.iter().enumerate() {
        let lists =
            row.0.iter().filter_map(|(_, cell)| if let Cell::List(list) = cell { Some(list.len()) } else { None });
        total += lists.map(|count| count as f64).product::<f64>();
        if total > MOST_READINGS {
            return Err(Malformed::new(Fault::Value, "the lists of this schedule give too many readings")
                .expected(format!(
                    "at most {MOST_READINGS:.0} readings in all; a line with several lists gives all their combinations"
                ))
                .found(format!("{total:.0} up to here"))
                .at_path(format!("readings[{k}]")));
        }
    }
    for (k, row) in rows.into_iter().enumerate() {
        let place = format!("readings[{k}]");
        expand(bench, row, &place, &mut expanded)?;
    }
    from_cells(bench, expanded)
}

/// The error for a table of so many readings.
pub(super) fn too_many(found: usize) -> Malformed {
    Malformed::new(Fault::Value, "there are too many readings")
        .expected(format!("at most {MOST_READINGS:.0}"))
        .found(format!("{found} up to here"))
}

/// Replace lists by one row for each of their values; the last list of a row runs fastest.
pub(super) fn expand(bench: &Bench, row: ReadingFile, place: &str, out: &mut Vec<(String, ReadingFile)>) -> Result<()> {
    let Some(at) = row.0.iter().position(|(_, cell)| matches!(cell, Cell::List(_))) else {
        out.push((place.to_string(), row));
        return Ok(());
    };
    let Some((key, Cell::List(values))) = row.0.get(at).cloned() else { return Ok(()) };
    if let Some(sensor) = bench.sensors.iter().find(|sensor| row.get(&sensor.id).is_some()) {
        return Err(Malformed::new(Fault::Value, format!("a measured reading has a list for {key}"))
            .expected(format!("one number; lists belong to schedules, and here {} was read", sensor.id))
            .at_path(format!("{place}.{key}")));
    }
    if values.is_empty() {
        return Err(Malformed::new(Fault::Value, format!("the list for {key} is empty"))
            .expected("at least one value")
            .at_path(format!("{place}.{key}")));
    }
    for value in values {
        let mut single = row.clone();
        if let Some(entry) = single.0.get_mut(at) {
            entry.1 = Cell::Number(value);
        }
        expand(bench, single, place, out)?;
    }
    Ok(())
}

/// What a key of a reading means on this bench.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Meaning {
    Position,
    Samples,
    Sensor(usize),
    SensorU(usize),
    Angle(usize),
    Rate(usize),
    Turns(usize),
    Column,
}

impl Meaning {
    /// Is a number under it an input of that name?
    pub fn is_input(self) -> bool {
        matches!(self, Meaning::Column | Meaning::Angle(_) | Meaning::Rate(_) | Meaning::Turns(_))
    }
}

/// The meaning of a key of a reading.
pub(super) fn meaning(bench: &Bench, key: &str) -> Meaning {
    match key {
        "position" => return Meaning::Position,
        "n" => return Meaning::Samples,
        _ => {}
    }
    for (k, sensor) in bench.sensors.iter().enumerate() {
        match key.strip_prefix(sensor.id.as_str()) {
            Some("") => return Meaning::Sensor(k),
            Some("_u") => return Meaning::SensorU(k),
            _ => {}
        }
    }
    for (k, joint) in bench.joints().enumerate() {
        match key.strip_prefix(joint) {
            Some("_deg") => return Meaning::Angle(k),
            Some("_deg_s") => return Meaning::Rate(k),
            Some("_turns") => return Meaning::Turns(k),
            _ => {}
        }
    }
    Meaning::Column
}

/// What each key of the readings means, and its place among the numeric columns.
type Meanings = HashMap<String, (Meaning, Option<usize>), BuildHasherDefault<Mix>>;

/// Rows of cells that are gone through several times: at hand, or read anew from a text each time, so that they need not be held beside it.
pub(super) trait CellRows {
    /// Each row in order: its place (for messages) and its cells.
    fn visit(&self, see: &mut dyn FnMut(&dyn Fn() -> String, &ReadingFile) -> Result<()>) -> Result<()>;
}

impl CellRows for Vec<(String, ReadingFile)> {
    fn visit(&self, see: &mut dyn FnMut(&dyn Fn() -> String, &ReadingFile) -> Result<()>) -> Result<()> {
        self.iter().try_for_each(|(place, row)| see(&|| place.clone(), row))
    }
}

/// The place of the first row that has a column.
fn place_of(rows: &impl CellRows, column: &str) -> Result<String> {
    let mut found: Option<String> = None;
    rows.visit(&mut |place, row| {
        if found.is_none() && row.get(column).is_some() {
            found = Some(place());
        }
        Ok(())
    })?;
    Ok(found.unwrap_or_else(|| "readings".into()))
}

/// Cells to readings, shared by JSON and CSV.
pub(super) fn from_cells(bench: &Bench, rows: impl CellRows) -> Result<Readings> {
    let joints: Vec<&str> = bench.joints().collect();
    let indifferent = LazyCell::new(|| indifferent_angles(bench));
    // every key with a number somewhere is an input of that name, joint keys too (a term may say gamma_deg_s*cos(2*beta))
    let mut columns: Vec<String> = Vec::new();
    let mut meanings = Meanings::default();
    let mut count = 0_usize;
    // a text where a model line wants a number is a fault of its row, not a column that is not there
    let used: HashSet<&str> = bench.sensors.iter().flat_map(|sensor| sensor.model.names()).collect();
    let is_read = |key: &String, cell: &Cell| match cell {
        Cell::Number(_) => true,
        Cell::Text(_) => used.contains(key.as_str()),
        _ => false,
    };
    rows.visit(&mut |_, row| {
        count += 1;
        for (key, cell) in &row.0 {
            if !meanings.contains_key(key) {
                meanings.insert(key.clone(), (meaning(bench, key), None));
            }
            if let Some((meaning, slot @ None)) = meanings.get_mut(key)
                && meaning.is_input()
                && is_read(key, cell)
            {
                *slot = Some(columns.len());
                columns.push(key.clone());
            }
        }
        Ok(())
    })?;
    // a unit behind a name makes it no other name
    let name = |column: &str| crate::record::title(column).0;
    for column in &columns {
        let named = &name(column);
        let clash = if bench.chain.iter().any(|link| link.name() == named) {
            format!("a link of the chain; expected {named}_deg or {named}_deg_s for a joint")
        } else if is_axis_input(bench, named) {
            "an input along an axis, which comes from the chain".to_string()
        } else {
            continue;
        };
        let place = place_of(&rows, column)?;
        return Err(Malformed::new(Fault::NameClash, format!("the column '{column}' has the name of something else"))
            .expected("a name that is not a joint, a tilt or an axis input")
            .found(format!("'{column}', {clash}"))
            .at_path(format!("{place}.{column}")));
    }
    for column in &columns {
        if let Some(axis) = undeclared_axis(bench, &name(column)) {
            let place = place_of(&rows, column)?;
            let axes: Vec<&str> =
                bench.sensors.iter().flat_map(|s| s.axes.iter().map(|(axis, _)| axis.as_str())).collect();
            return Err(Malformed::new(
                Fault::UnknownName,
                format!("'{column}' is called like an input along an axis, but no axis is called '{axis}' and no model line uses it"),
            )
            .expected(format!("another name for the column (inputs along the axes {} come from the chain)", axes.join(", ")))
            .at_path(format!("{place}.{column}")));
        }
    }
    let mut made: Vec<Reading> = Vec::with_capacity(count);
    let mut without: Option<(String, usize)> = None;
    rows.visit(&mut |place, row| {
        let filled = reading(bench, &meanings, (&joints, &indifferent), columns.len(), place(), row)?;
        // an empty cell says that nothing was read there
        let lacks = |k: &usize| bench.sensors.get(*k).is_some_and(|sensor| row.get(&sensor.id).is_none());
        if without.is_none() {
            without = filled.planned_u.iter().map(|(k, _)| *k).find(lacks).map(|k| (filled.place.clone(), k));
        }
        made.push(filled);
        Ok(())
    })?;
    let mut rows = made;
    // in a schedule an uncertainty stands for a value still to be read; among values, the value is missing
    if rows.iter().any(|row| !row.observations.is_empty()) {
        if let Some((place, k)) = without {
            let id = bench.sensors.get(k).map_or("", |sensor| sensor.id.as_str());
            return Err(Malformed::new(Fault::Missing, format!("{id}_u without {id}"))
                .expected(format!("the value that this uncertainty belongs to, as \"{id}\""))
                .at_path(format!("{place}.{id}_u")));
        }
        rows.iter_mut().for_each(|row| row.planned_u.clear());
    }
    Ok(Readings { columns, rows })
}

/// The axis of a column `w_<axis>` or `a_<axis>` that the bench does not have, unless a model line uses that name.
fn undeclared_axis<'a>(bench: &Bench, column: &'a str) -> Option<&'a str> {
    let axis = column.strip_prefix("w_").or_else(|| column.strip_prefix("a_"))?;
    let has_axes = bench.sensors.iter().any(|sensor| !sensor.axes.is_empty());
    let used = bench.sensors.iter().any(|sensor| sensor.model.names().contains(&column));
    (has_axes && axis.chars().count() <= 2 && !used).then_some(axis)
}

fn reading(
    bench: &Bench,
    meanings: &Meanings,
    (joints, indifferent): (&[&str], &LazyCell<Vec<Option<f64>>, impl FnOnce() -> Vec<Option<f64>>>),
    columns: usize,
    place: String,
    row: &ReadingFile,
) -> Result<Reading> {
    let mut position = String::new();
    let mut samples = 1.0;
    let mut remarks = Vec::new();
    let mut values: Vec<(Option<f64>, Option<f64>)> = vec![(None, None); bench.sensors.len()];
    let mut states: Vec<[Option<f64>; 3]> = vec![[None; 3]; joints.len()];
    let mut numbers: Vec<Option<f64>> = vec![None; columns];
    for (key, cell) in &row.0 {
        // every key was seen before
        let (meaning, slot) = meanings.get(key).copied().unwrap_or((Meaning::Column, None));
        let number = match (cell, &meaning) {
            (Cell::Nothing(()), _) => continue,
            (Cell::Text(text), Meaning::Position) => {
                position.clone_from(text);
                continue;
            }
            (Cell::Number(value), Meaning::Position) => {
                position = value.to_string();
                continue;
            }
            (Cell::Text(text), Meaning::Column) if slot.is_none() => {
                remarks.push((key.clone(), text.clone()));
                continue;
            }
            (Cell::Text(text), _) => return Err(not_a_number(&place, key, &format!("'{text}'"))),
            (Cell::List(_), _) => return Err(not_a_number(&place, key, "a list")),
            (Cell::Number(value), _) if !value.is_finite() => {
                return Err(not_a_number(&place, key, &value.to_string()));
            }
            (Cell::Number(value), _) => *value,
        };
        if let Some(slot) = slot.and_then(|k| numbers.get_mut(k)) {
            *slot = Some(number);
        }
        let path = || format!("{place}.{key}");
        match meaning {
            Meaning::Samples if !(number > 0.0) => {
                return Err(Malformed::new(Fault::Value, "n is not a number of samples")
                    .expected("a positive number")
                    .found(number.to_string())
                    .at_path(path()));
            }
            Meaning::Samples => samples = number,
            Meaning::SensorU(_) if !(number > 0.0) => {
                return Err(Malformed::new(Fault::Value, format!("{key} cannot be a standard uncertainty"))
                    .expected("a positive number (leave it out where it is not known)")
                    .found(number.to_string())
                    .at_path(path()));
            }
            Meaning::Sensor(k) => set(&mut values, k, |v| v.0 = Some(number)),
            Meaning::SensorU(k) => set(&mut values, k, |v| v.1 = Some(number)),
            Meaning::Angle(k) => set(&mut states, k, |s| s[0] = Some(number)),
            Meaning::Rate(k) => set(&mut states, k, |s| s[1] = Some(number)),
            Meaning::Turns(k) => set(&mut states, k, |s| s[2] = Some(number)),
            Meaning::Position | Meaning::Column => {}
        }
    }
    let keys = || row.0.iter().map(|(key, _)| key.as_str()).take(30);
    // lists as long as what is in them: a campaign may have a million readings
    let mut joint_states = Vec::with_capacity(joints.len());
    for (k, (joint, [deg, deg_s, turns])) in joints.iter().zip(&states).enumerate() {
        let deg = match (deg, deg_s) {
            (None, Some(0.0)) => indifferent.get(k).copied().flatten(),
            (deg, _) => *deg,
        };
        joint_states.push(JointState::from_keys(joint, deg, *deg_s, *turns).map_err(|error| {
            let error = match error.finding() {
                Some("neither") => {
                    let is_blank = |(key, cell): &&(String, Cell)| {
                        let of_joint = key.strip_prefix(joint).is_some_and(|end| ["_deg", "_deg_s"].contains(&end));
                        of_joint && matches!(cell, Cell::Nothing(()))
                    };
                    match row.0.iter().find(is_blank) {
                        Some((key, _)) => {
                            error.found(format!("an empty cell for {key}: fill it in, or delete the row"))
                        }
                        None if keys().all(is_plain) => {
                            error.found(format!("neither among {}", keys().collect::<Vec<_>>().join(", ")))
                        }
                        None => error,
                    }
                }
                _ => error,
            };
            error.under(&place)
        })?);
    }
    let read = values.iter().filter(|(value, _)| value.is_some()).count();
    let (mut observations, mut planned_u) = (Vec::with_capacity(read), Vec::new());
    for (k, (value, u)) in values.iter().enumerate() {
        match (value, u) {
            (Some(value), u) => observations.push(Observation { sensor: k, value: *value, u: *u, samples }),
            (None, Some(u)) => planned_u.push((k, *u)),
            (None, None) => {}
        }
    }
    let reading =
        Reading { position, joints: joint_states, columns: numbers, observations, samples, planned_u, remarks, place };
    reading.check_turning(joints).map_err(|e| e.under(&reading.place))?;
    Ok(reading)
}

fn set<T>(list: &mut [T], k: usize, change: impl FnOnce(&mut T)) {
    if let Some(item) = list.get_mut(k) {
        change(item);
    }
}

fn not_a_number(place: &str, key: &str, found: &str) -> Malformed {
    let comma = found.trim_matches('\'');
    let comma = comma.matches(',').count() == 1 && comma.replace(',', ".").parse::<f64>().is_ok();
    Malformed::new(Fault::Value, format!("{key} is not a number"))
        .expected(match comma {
            true => "a number with a decimal point; decimal commas are read in a file whose cells are separated by semicolons or tabs, if all its numbers have them",
            false => "a finite number; leave the cell empty, or the key out, where nothing was read",
        })
        .found(found.to_string())
        .at_path(format!("{place}.{key}"))
}

/// Is this what a person would call a column? What is not may be a line of a file that is no table, and is not quoted.
fn is_plain(key: &str) -> bool {
    key.chars().all(|c| c.is_alphanumeric() || " _-.()[]/°%²".contains(c)) && key.chars().count() <= 60
}
