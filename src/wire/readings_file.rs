//! Readings as JSON objects: joint keys, sensor keys, a position, and any further numeric column.

use super::Named;
use super::columns::{Meaning, from_title, key_unit, meaning};
use crate::bench::Bench;
use crate::campaign::is_axis_input;
use crate::campaign::{JointState, Label, Observation, Place, Pool, Reading, Readings, Shared};
use crate::design::indifferent_angles;
use crate::error::{Fault, Malformed, Result};
use crate::mix::Mix;
use crate::record::WrittenTimes;
use crate::units::Conversion;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::cell::OnceCell;
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

impl Cell {
    /// A number or a text as it is written; nothing for the others.
    pub(super) fn written(&self) -> String {
        match self {
            Cell::Number(x) => x.to_string(),
            Cell::Text(text) => text.clone(),
            Cell::List(_) | Cell::Nothing(()) => String::new(),
        }
    }

    /// What it says, once lists are expanded.
    pub(super) fn says(&self) -> Says<'_> {
        match self {
            Cell::Number(value) => Says::Number(*value),
            Cell::Text(text) => Says::Text(text),
            Cell::List(_) | Cell::Nothing(()) => Says::Nothing,
        }
    }
}

/// More readings than this are refused before their lists are expanded: each takes about a kilobyte.
pub(super) const MOST_READINGS: f64 = 2e6;

/// Readings of rows as a campaign file has them; lists of a schedule are expanded.
///
/// Errors: those of the readings of a campaign file, with the path from `readings[k]` on.
pub fn read_rows(bench: &Bench, rows: Vec<ReadingFile>) -> Result<Readings> {
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
                .at_path(Place::Entry(k)));
        }
    }
    for (k, row) in rows.into_iter().enumerate() {
        expand(bench, row, &Place::Entry(k), &mut expanded)?;
    }
    from_cells(bench, &Written::new(expanded))
}

/// The error for a table of so many readings.
pub(super) fn too_many(found: usize) -> Malformed {
    Malformed::new(Fault::Value, "there are too many readings")
        .expected(format!("at most {MOST_READINGS:.0}"))
        .found(format!("{found} up to here"))
}

/// Replace lists by one row for each of their values; the last list of a row runs fastest.
pub(super) fn expand(
    bench: &Bench,
    row: ReadingFile,
    place: &Place,
    out: &mut Vec<(Place, ReadingFile)>,
) -> Result<()> {
    let Some(at) = row.0.iter().position(|(_, cell)| matches!(cell, Cell::List(_))) else {
        out.push((place.clone(), row));
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

/// What a cell of a row says.
#[derive(Debug, Clone, Copy)]
pub(super) enum Says<'a> {
    Number(f64),
    Text(&'a str),
    Nothing,
}

/// Rows of cells that are gone through several times: at hand, or read anew from a table each time, so that they need not be held beside it.
pub(super) trait CellRows {
    /// The keys of all rows, in the order in which they come.
    fn keys(&self) -> Vec<&str>;

    /// Each row in order: its place (for messages), and its cells by the number of their key.
    fn visit(&self, see: &mut dyn FnMut(&dyn Fn() -> Place, &[(usize, Says<'_>)]) -> Result<()>) -> Result<()>;
}

/// Rows as JSON writes them, each with its place.
pub(super) struct Written {
    rows: Vec<(Place, ReadingFile)>,
    /// The number of each key.
    keys: HashMap<String, usize, BuildHasherDefault<Mix>>,
}

impl Written {
    pub fn new(rows: Vec<(Place, ReadingFile)>) -> Self {
        let mut keys = HashMap::default();
        for (key, _) in rows.iter().flat_map(|(_, row)| &row.0) {
            if !keys.contains_key(key) {
                keys.insert(key.clone(), keys.len());
            }
        }
        Written { rows, keys }
    }
}

impl CellRows for Written {
    fn keys(&self) -> Vec<&str> {
        let mut keys = vec![""; self.keys.len()];
        for (key, number) in &self.keys {
            set(&mut keys, *number, |slot| *slot = key);
        }
        keys
    }

    fn visit(&self, see: &mut dyn FnMut(&dyn Fn() -> Place, &[(usize, Says<'_>)]) -> Result<()>) -> Result<()> {
        let mut cells = Vec::new();
        for (place, row) in &self.rows {
            cells.clear();
            cells.extend(row.0.iter().filter_map(|(key, cell)| Some((*self.keys.get(key)?, cell.says()))));
            see(&|| place.clone(), &cells)?;
        }
        Ok(())
    }
}

/// Keys of times whose first cell is a written one (`2026-11-20T09:14:03`): they are times since that.
pub(super) struct Times(Vec<Option<TimesOf>>);

/// The key of a time: from seconds to its unit, and the times so far; `None` before a cell, or where the first one is none.
struct TimesOf {
    from_seconds: Option<Conversion>,
    clock: Option<WrittenTimes>,
    begun: bool,
}

impl Times {
    pub fn of<'a>(bench: &Bench, keys: impl Iterator<Item = &'a str>) -> Self {
        let used: HashSet<&str> = bench.sensors.iter().flat_map(|sensor| sensor.model.names()).collect();
        let of = |key: &str| {
            let from_seconds = match key_unit(bench, key) {
                Some(unit) => from_title(key, "s", &unit).ok()?,
                None => used.contains(key).then_some(None)?,
            };
            Some(TimesOf { from_seconds, clock: None, begun: false })
        };
        Times(keys.map(of).collect())
    }

    /// What a cell says in the place of a written time. Errors: `None` for a cell that is none below others that are.
    pub fn number<'a>(&mut self, key: usize, says: Says<'a>) -> Option<Says<'a>> {
        let Some(Some(own)) = self.0.get_mut(key) else { return Some(says) };
        let text = match says {
            Says::Nothing => return Some(says),
            Says::Text(text) => Some(text),
            Says::Number(_) => None,
        };
        if !std::mem::replace(&mut own.begun, true) {
            own.clock =
                text.and_then(|text| WrittenTimes::default().since_first(text)).map(|_| WrittenTimes::default());
        }
        let Some(clock) = &mut own.clock else { return Some(says) };
        let time = clock.since_first(text?)?;
        Some(Says::Number(own.from_seconds.map_or(time, |conversion| conversion.apply(time))))
    }
}

/// Rows whose written times are numbers.
struct InSeconds<'a, R> {
    bench: &'a Bench,
    rows: &'a R,
}

impl<R: CellRows> CellRows for InSeconds<'_, R> {
    fn keys(&self) -> Vec<&str> {
        self.rows.keys()
    }

    fn visit(&self, see: &mut dyn FnMut(&dyn Fn() -> Place, &[(usize, Says<'_>)]) -> Result<()>) -> Result<()> {
        let keys = self.rows.keys();
        let mut times = Times::of(self.bench, keys.iter().copied());
        if times.0.iter().all(Option::is_none) {
            return self.rows.visit(see);
        }
        self.rows.visit(&mut |place, cells| {
            let mut own: Vec<(usize, Says<'_>)> = Vec::with_capacity(cells.len());
            for (k, says) in cells {
                let number = times.number(*k, *says).ok_or_else(|| {
                    let key = keys.get(*k).copied().unwrap_or_default();
                    Malformed::new(Fault::Value, format!("{key} is not a time"))
                        .expected("a time as in the rows before; an empty cell where nothing was read")
                        .found(match says {
                            Says::Text(text) => format!("'{text}'"),
                            Says::Number(value) => value.to_string(),
                            Says::Nothing => "an empty cell".into(),
                        })
                        .at_path(format!("{}.{key}", place()))
                })?;
                own.push((*k, number));
            }
            see(place, &own)
        })
    }
}

/// A key of the readings: what it means, and its place among the numeric columns.
struct Key<'a> {
    name: &'a str,
    meaning: Meaning,
    column: Option<usize>,
}

/// The place of the first row that has a column.
fn place_of(rows: &impl CellRows, column: &str) -> Result<Place> {
    let key = rows.keys().iter().position(|key| *key == column);
    let mut found: Option<Place> = None;
    rows.visit(&mut |place, cells| {
        if found.is_none() && cells.iter().any(|(k, _)| Some(*k) == key) {
            found = Some(place());
        }
        Ok(())
    })?;
    Ok(found.unwrap_or_else(|| Place::Path("readings".into())))
}

/// Cells to readings, shared by all files.
pub(super) fn from_cells(bench: &Bench, rows: &impl CellRows) -> Result<Readings> {
    let rows = &InSeconds { bench, rows };
    let joints: Vec<&str> = bench.joints().collect();
    let names = rows.keys();
    let mut keys: Vec<Key<'_>> =
        names.iter().map(|name| Key { name, meaning: meaning(bench, name), column: None }).collect();
    // every key with a number somewhere is an input of that name, joint keys too (a term may say gamma_deg_s*cos(2*beta))
    let mut columns: Vec<String> = Vec::new();
    let mut count = 0_usize;
    // a text where a model line wants a number is a fault of its row, not a column that is not there
    let used: HashSet<&str> = bench.sensors.iter().flat_map(|sensor| sensor.model.names()).collect();
    rows.visit(&mut |_, cells| {
        count += 1;
        for (k, says) in cells {
            if let Some(key @ Key { column: None, .. }) = keys.get_mut(*k)
                && key.meaning.is_input()
                && match says {
                    Says::Number(_) => true,
                    Says::Text(_) => used.contains(key.name),
                    Says::Nothing => false,
                }
            {
                key.column = Some(columns.len());
                columns.push(key.name.to_string());
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
        let place = place_of(rows, column)?;
        return Err(Malformed::new(Fault::NameClash, format!("the column '{column}' has the name of something else"))
            .expected("a name that is not a joint, a tilt or an axis input")
            .found(format!("'{column}', {clash}"))
            .at_path(format!("{place}.{column}")));
    }
    for column in &columns {
        if let Some(axis) = undeclared_axis(bench, &name(column)) {
            let place = place_of(rows, column)?;
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
    let mut without: Option<(Place, usize)> = None;
    let mut maker = Maker {
        bench,
        used: &used,
        keys: &keys,
        joints: &joints,
        columns: columns.len(),
        indifferent: OnceCell::new(),
        labels: HashSet::default(),
        states: Pool::default(),
        numbers: Pool::default(),
        observed: Pool::default(),
        room: Room::default(),
    };
    rows.visit(&mut |place, cells| {
        let filled = maker.reading(place, cells)?;
        // an empty cell says that nothing was read there
        let lacks =
            |s: &usize| !cells.iter().any(|(k, _)| keys.get(*k).is_some_and(|key| key.meaning == Meaning::Sensor(*s)));
        if without.is_none() {
            without = filled.planned_u.iter().map(|(s, _)| *s).find(lacks).map(|s| (filled.place.clone(), s));
        }
        made.push(filled);
        Ok(())
    })?;
    // lists of the readings are there from now on
    drop(maker);
    let mut rows = made;
    // in a schedule an uncertainty stands for a value still to be read; among values, the value is missing
    if rows.iter().any(|row| !row.observations.is_empty()) {
        if let Some((place, k)) = without {
            let id = bench.sensors.get(k).map_or("", |sensor| sensor.id.as_str());
            return Err(Malformed::new(Fault::Missing, format!("{id}_u without {id}"))
                .expected(format!("the value that this uncertainty belongs to, as \"{id}\""))
                .at_path(format!("{place}.{id}_u")));
        }
        rows.iter_mut().for_each(|row| row.planned_u = Shared::default());
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

/// Makes readings of rows.
struct Maker<'a> {
    bench: &'a Bench,
    /// Names in the model lines.
    used: &'a HashSet<&'a str>,
    keys: &'a [Key<'a>],
    joints: &'a [&'a str],
    columns: usize,
    /// Angles of the joints on which no reading depends, once one is asked for.
    indifferent: OnceCell<Vec<Option<f64>>>,
    labels: HashSet<Label, BuildHasherDefault<Mix>>,
    states: Pool<JointState>,
    numbers: Pool<Option<f64>>,
    observed: Pool<Observation>,
    room: Room,
}

/// What is gathered of one row.
#[derive(Default)]
struct Room {
    /// Value and standard uncertainty of each sensor.
    values: Vec<(Option<f64>, Option<f64>)>,
    /// Angle, rate and turns of each joint.
    states: Vec<[Option<f64>; 3]>,
    joints: Vec<JointState>,
    numbers: Vec<Option<f64>>,
    observations: Vec<Observation>,
}

impl Maker<'_> {
    fn key(&self, number: usize) -> &str {
        self.keys.get(number).map_or("", |key| key.name)
    }

    fn label(&mut self, text: &str) -> Label {
        if let Some(known) = self.labels.get(text) {
            return known.clone();
        }
        let label = Label::from(text);
        self.labels.insert(label.clone());
        label
    }

    fn reading(&mut self, place: &dyn Fn() -> Place, cells: &[(usize, Says<'_>)]) -> Result<Reading> {
        let mut position = Label::default();
        let mut samples = 1.0;
        let mut remarks = Vec::new();
        let Room { mut values, mut states, mut joints, mut numbers, mut observations } = std::mem::take(&mut self.room);
        values.clear();
        values.resize(self.bench.sensors.len(), (None, None));
        states.clear();
        states.resize(self.joints.len(), [None; 3]);
        numbers.clear();
        numbers.resize(self.columns, None);
        joints.clear();
        observations.clear();
        for (k, says) in cells {
            let Some(Key { name, meaning, column }) = self.keys.get(*k) else { continue };
            let number = match (*says, meaning) {
                (Says::Nothing, _) => continue,
                (Says::Text(text), Meaning::Position) => {
                    position = self.label(text);
                    continue;
                }
                (Says::Number(value), Meaning::Position) => {
                    position = self.label(&value.to_string());
                    continue;
                }
                (Says::Text(text), Meaning::Column) if column.is_none() => {
                    remarks.push((name.to_string(), text.to_string()));
                    continue;
                }
                (Says::Text(text), _) => return Err(not_a_number(&place(), name, &format!("'{text}'"))),
                // what nothing reads may be infinite
                (Says::Number(value), Meaning::Column) if !value.is_finite() && !self.used.contains(name) => continue,
                (Says::Number(value), _) if !value.is_finite() => {
                    return Err(not_a_number(&place(), name, &value.to_string()));
                }
                (Says::Number(value), _) => value,
            };
            if let Some(slot) = column.and_then(|k| numbers.get_mut(k)) {
                *slot = Some(number);
            }
            match *meaning {
                Meaning::Samples if !(number > 0.0) => {
                    return Err(Malformed::new(Fault::Value, "n is not a number of samples")
                        .expected("a positive number")
                        .found(number.to_string())
                        .at_path(format!("{}.{name}", place())));
                }
                Meaning::Samples => samples = number,
                Meaning::SensorU(_) if !(number > 0.0) => {
                    return Err(Malformed::new(Fault::Value, format!("{name} cannot be a standard uncertainty"))
                        .expected("a positive number (leave it out where it is not known)")
                        .found(number.to_string())
                        .at_path(format!("{}.{name}", place())));
                }
                Meaning::Sensor(k) => set(&mut values, k, |v| v.0 = Some(number)),
                Meaning::SensorU(k) => set(&mut values, k, |v| v.1 = Some(number)),
                Meaning::Angle(k) => set(&mut states, k, |s| s[0] = Some(number)),
                Meaning::Rate(k) => set(&mut states, k, |s| s[1] = Some(number)),
                Meaning::Turns(k) => set(&mut states, k, |s| s[2] = Some(number)),
                Meaning::Position | Meaning::Column => {}
            }
        }
        for (k, (joint, [deg, deg_s, turns])) in self.joints.iter().zip(&states).enumerate() {
            let indifferent =
                || self.indifferent.get_or_init(|| indifferent_angles(self.bench)).get(k).copied().flatten();
            let deg = match (deg, deg_s) {
                (None, Some(0.0)) => indifferent(),
                (deg, _) => *deg,
            };
            let state = JointState::from_keys(joint, deg, *deg_s, *turns);
            joints.push(state.map_err(|error| self.without_state(error, joint, cells).under(&place().to_string()))?);
        }
        // the rate of a joint at rest is zero, written or not
        for key in self.keys {
            if let (Meaning::Rate(joint), Some(column)) = (key.meaning, key.column)
                && matches!(joints.get(joint), Some(JointState::Held { .. }))
            {
                set(&mut numbers, column, |slot| *slot = slot.or(Some(0.0)));
            }
        }
        Reading::check_turning(&joints, self.joints).map_err(|e| e.under(&place().to_string()))?;
        let mut planned_u = Vec::new();
        for (k, (value, u)) in values.iter().enumerate() {
            match (value, u) {
                (Some(value), u) => observations.push(Observation { sensor: k, value: *value, u: *u, samples }),
                (None, Some(u)) => planned_u.push((k, *u)),
                (None, None) => {}
            }
        }
        let reading = Reading {
            position,
            joints: self.states.share(&joints, joints.iter().flat_map(JointState::bits)),
            columns: self.numbers.share(&numbers, numbers.iter().map(|x| x.map_or(u64::MAX, f64::to_bits))),
            observations: self.observed.keep(&observations),
            samples,
            planned_u: planned_u.into(),
            remarks: remarks.into(),
            place: place(),
        };
        self.room = Room { values, states, joints, numbers, observations };
        Ok(reading)
    }

    /// What a row has in the place of a joint's state.
    fn without_state(&self, error: Malformed, joint: &str, cells: &[(usize, Says<'_>)]) -> Malformed {
        if error.finding() != Some("neither") {
            return error;
        }
        let keys = || cells.iter().map(|(k, _)| self.key(*k)).take(30);
        let is_blank = |(k, says): &&(usize, Says<'_>)| {
            let of_joint = self.key(*k).strip_prefix(joint).is_some_and(|end| ["_deg", "_deg_s"].contains(&end));
            of_joint && matches!(says, Says::Nothing)
        };
        match cells.iter().find(is_blank) {
            Some((k, _)) => error.found(format!("an empty cell for {}: fill it in, or delete the row", self.key(*k))),
            None if keys().all(is_plain) => {
                error.found(format!("neither among {}", keys().collect::<Vec<_>>().join(", ")))
            }
            None => error,
        }
    }
}

fn set<T>(list: &mut [T], k: usize, change: impl FnOnce(&mut T)) {
    if let Some(item) = list.get_mut(k) {
        change(item);
    }
}

fn not_a_number(place: &Place, key: &str, found: &str) -> Malformed {
    let comma = found.trim_matches('\'');
    let comma = comma.matches(',').count() == 1 && comma.replace(',', ".").parse::<f64>().is_ok();
    Malformed::new(Fault::Value, format!("{key} is not a number"))
        .expected(match comma {
            true => "a number with a decimal point; decimal commas are read in a file whose cells are separated by semicolons or tabs, if all its numbers have them",
            false => "a finite number; leave the cell empty, or omit the key, if nothing was read",
        })
        .found(found.to_string())
        .at_path(format!("{place}.{key}"))
}

/// Is this what a person would call a column? What is not may be a line of a file that is no table, and is not quoted.
fn is_plain(key: &str) -> bool {
    key.chars().all(|c| c.is_alphanumeric() || " _-.()[]/°%²".contains(c)) && key.chars().count() <= 60
}
