//! Devices while their rows come: positions evaluated once, values kept until there are enough of them to be folded into a triangle.

use crate::answer;
use crate::question::{Bound, Quantities};
use datafusion::arrow::array::{
    Array, ArrayRef, AsArray, BooleanArray, ListBuilder, PrimitiveBuilder, StringArray, StringBuilder,
};
use datafusion::arrow::datatypes::{DataType, Float64Type};
use datafusion::common::{Result, ScalarValue, exec_datafusion_err};
use datafusion::logical_expr::{Accumulator, EmitTo, GroupsAccumulator};
use std::collections::HashMap;
use std::sync::Arc;
use tumble::batch::{Coverage, Device, Line, Part, Parts, Row, Use, Verdict};
use tumble::campaign::Observation;
use tumble::record::UNREADABLE;

/// Values of a device that are kept before they are folded.
const KEPT: usize = 64;
/// So few values are a state by themselves: nothing of them is rounded, and they take less than a triangle.
const FEW: usize = 32;
/// Positions that are kept; a table in which every row is another one begins anew.
const POSITIONS: usize = 1 << 16;

/// Every device of a partition.
#[derive(Debug)]
pub(crate) struct Groups {
    bound: Arc<Bound>,
    quantities: Arc<Quantities>,
    groups: Vec<Group>,
    positions: Positions,
    /// Values that are kept, and triangles that there are.
    kept: usize,
    triangles: usize,
}

/// A device.
#[derive(Debug, Default)]
struct Group {
    part: Option<Box<Part>>,
    kept: Vec<Value>,
    /// Why its rows are no readings; of several reasons the first in the alphabet, so that the order of rows does not matter.
    fault: Option<String>,
}

/// A value read.
#[derive(Debug, Clone, Copy)]
struct Value {
    position: u32,
    /// Among the sensors that are read.
    sensor: u32,
    observation: Observation,
}

/// What a row says of a value: nothing read, a value, or what is wrong.
type Lines = Vec<std::result::Result<Line, String>>;

/// Positions that were met, with the rows of the design that they have.
#[derive(Debug, Default)]
struct Positions {
    places: HashMap<Vec<u64>, u32>,
    /// Of each position, what identifies it, one after the other.
    keys: Vec<u64>,
    /// The position that followed the last time.
    next: Vec<u32>,
    /// A line for each sensor, or why a row at this position is no reading.
    lines: Vec<std::result::Result<Lines, String>>,
}

impl Groups {
    pub(crate) fn new(bound: Arc<Bound>, quantities: Arc<Quantities>) -> Self {
        Groups { bound, quantities, groups: Vec::new(), positions: Positions::default(), kept: 0, triangles: 0 }
    }

    fn parts(&self) -> Result<&Parts> {
        self.bound.parts.as_ref().ok_or_else(|| exec_datafusion_err!("the question was asked for whole devices"))
    }

    /// Begin anew with positions where they are many.
    fn make_room(&mut self) {
        if self.positions.lines.len() > POSITIONS {
            self.groups.iter_mut().for_each(|group| self.triangles += group.fold(&self.bound, &self.positions));
            self.kept = 0;
            self.positions = Positions::default();
        }
    }

    /// The position of each row; new ones are evaluated together.
    fn positions(&mut self, columns: &[Vec<f64>], rows: usize) -> Vec<u32> {
        let width = self.bound.position.len();
        self.make_room();
        let known = self.positions.lines.len();
        let (mut found, mut key, mut before) = (Vec::with_capacity(rows), vec![0_u64; width], None::<u32>);
        for row in 0..rows {
            for (slot, place) in key.iter_mut().zip(&self.bound.position) {
                let x = columns.get(*place).and_then(|column| column.get(row)).copied().unwrap_or(f64::NAN);
                // all that is absent is one, and so are both zeros
                *slot = if x.is_nan() { u64::MAX } else { (x + 0.0).to_bits() };
            }
            let place = self.positions.find(&key, before);
            before = Some(place);
            found.push(place);
        }
        if self.positions.next.len() > known {
            self.positions.evaluate(&self.bound, known);
        }
        found
    }

    fn update(
        &mut self,
        values: &[ArrayRef],
        groups: &[usize],
        filter: Option<&BooleanArray>,
        total: usize,
    ) -> Result<()> {
        self.groups.resize_with(total.max(self.groups.len()), Group::default);
        let columns = values.iter().map(numbers).collect::<Result<Vec<_>>>()?;
        let rows = groups.len();
        let texts = values.iter().any(|column| *column.data_type() == DataType::Utf8);
        let positions = self.positions(&columns, rows);
        let bound = Arc::clone(&self.bound);
        let cell = |place: usize, row: usize| columns.get(place).and_then(|c| c.get(row)).copied().unwrap_or(f64::NAN);
        for (row, (place, position)) in groups.iter().zip(&positions).enumerate() {
            if filter.is_some_and(|filter| !filter.is_valid(row) || !filter.value(row)) {
                continue;
            }
            let Some(group) = self.groups.get_mut(*place) else { continue };
            if texts && columns.iter().any(|c| c.get(row).is_some_and(|x| x.to_bits() == UNREADABLE.to_bits())) {
                group.blame(&refused(&bound, &columns, row));
                continue;
            }
            let Some(Ok(lines)) = self.positions.lines.get(*position as usize) else {
                if let Some(Err(fault)) = self.positions.lines.get(*position as usize) {
                    group.blame(fault);
                }
                continue;
            };
            let samples = bound.samples.map_or(f64::NAN, |place| cell(place, row));
            for (sensor, (index, place, u)) in bound.sensors.iter().enumerate() {
                let value = cell(*place, row);
                let u = u.map_or(f64::NAN, |place| cell(place, row));
                if value.is_nan() && u.is_nan() {
                    continue;
                }
                let plain = value.abs() <= 1e70 && (u.is_nan() || (1e-70..=1e70).contains(&u));
                let counted = samples.is_nan() || (samples > 0.0 && samples <= 1e70);
                if !(plain && counted) {
                    group.blame(&refused(&bound, &columns, row));
                    continue;
                }
                match lines.get(sensor) {
                    Some(Ok(_)) => {}
                    Some(Err(fault)) => {
                        group.blame(fault);
                        continue;
                    }
                    None => continue,
                }
                let observation = Observation {
                    sensor: *index,
                    value,
                    u: Some(u).filter(|u| !u.is_nan()),
                    samples: if samples.is_nan() { 1.0 } else { samples },
                };
                group.kept.push(Value { position: *position, sensor: sensor as u32, observation });
                self.kept += 1;
            }
            if group.kept.len() >= KEPT {
                self.kept -= group.kept.len();
                self.triangles += group.fold(&bound, &self.positions);
            }
        }
        Ok(())
    }

    /// The first groups, or all; those with more values than `few` are folded.
    fn take(&mut self, emit: EmitTo, few: usize) -> Vec<Group> {
        let mut taken = emit.take_needed(&mut self.groups);
        for group in &mut taken {
            self.kept = self.kept.saturating_sub(group.kept.len());
            if group.part.is_some() || group.kept.len() > few {
                group.fold(&self.bound, &self.positions);
            }
        }
        self.triangles = self.triangles.min(self.groups.len());
        taken
    }

    /// Values that were a state, each with its group.
    fn merge_values(&mut self, values: &[(usize, Vec<f64>)]) {
        self.make_room();
        let bound = Arc::clone(&self.bound);
        let (width, known) = (bound.position.len(), self.positions.next.len());
        let (mut found, mut before) = (Vec::new(), None);
        for (place, cells) in values {
            for own in cells.chunks_exact(width + 4) {
                let (key, own) = own.split_at(width);
                let [sensor, value, u, samples] = *own else { continue };
                let key: Vec<u64> = key.iter().map(|x| if x.is_nan() { u64::MAX } else { x.to_bits() }).collect();
                let position = self.positions.find(&key, before);
                before = Some(position);
                let Some((index, ..)) = bound.sensors.get(sensor as usize) else { continue };
                let observation = Observation { sensor: *index, value, u: Some(u).filter(|u| !u.is_nan()), samples };
                found.push((*place, Value { position, sensor: sensor as u32, observation }));
            }
        }
        if self.positions.next.len() > known {
            self.positions.evaluate(&bound, known);
        }
        for (place, value) in found {
            let Some(group) = self.groups.get_mut(place) else { continue };
            group.kept.push(value);
            self.kept += 1;
            if group.kept.len() >= KEPT {
                self.kept -= group.kept.len();
                self.triangles += group.fold(&bound, &self.positions);
            }
        }
    }
}

impl GroupsAccumulator for Groups {
    fn update_batch(
        &mut self,
        values: &[ArrayRef],
        group_indices: &[usize],
        opt_filter: Option<&BooleanArray>,
        total_num_groups: usize,
    ) -> Result<()> {
        self.update(values, group_indices, opt_filter, total_num_groups)
    }

    fn evaluate(&mut self, emit_to: EmitTo) -> Result<ArrayRef> {
        let groups = self.take(emit_to, 0);
        let parts = self.parts()?;
        let (mut coverage, mut nothing) = (Coverage::default(), None);
        let rows: Vec<Row> = groups
            .iter()
            .map(|group| {
                let part = match &group.part {
                    Some(part) => part,
                    None => &**nothing.get_or_insert_with(|| Box::new(parts.nothing())),
                };
                let row = parts.finish("", part, &mut coverage);
                match &group.fault {
                    None => row,
                    Some(fault) => malformed(row, fault),
                }
            })
            .collect();
        Ok(Arc::new(answer::array(&rows, &self.quantities, false)))
    }

    fn state(&mut self, emit_to: EmitTo) -> Result<Vec<ArrayRef>> {
        let groups = self.take(emit_to, FEW);
        let mut triangles = ListBuilder::new(PrimitiveBuilder::<Float64Type>::new());
        let mut values = ListBuilder::new(PrimitiveBuilder::<Float64Type>::new());
        let mut faults = StringBuilder::new();
        for group in groups {
            if let Some(part) = &group.part {
                triangles.values().append_slice(&part.pack());
            }
            triangles.append(group.part.is_some());
            for own in &group.kept {
                values.values().append_slice(&self.positions.key(own.position, self.bound.position.len()));
                let Observation { value, u, samples, .. } = own.observation;
                values.values().append_slice(&[f64::from(own.sensor), value, u.unwrap_or(f64::NAN), samples]);
            }
            values.append(!group.kept.is_empty());
            faults.append_option(group.fault);
        }
        Ok(vec![Arc::new(triangles.finish()), Arc::new(values.finish()), Arc::new(faults.finish())])
    }

    fn merge_batch(&mut self, values: &[ArrayRef], group_indices: &[usize], total_num_groups: usize) -> Result<()> {
        self.groups.resize_with(total_num_groups.max(self.groups.len()), Group::default);
        let [triangles, few, faults] = values else {
            return Err(exec_datafusion_err!("a state has three columns, and here are {}", values.len()));
        };
        let (triangles, few, faults) = (triangles.as_list::<i32>(), few.as_list::<i32>(), faults.as_string::<i32>());
        let few: Vec<(usize, Vec<f64>)> = group_indices
            .iter()
            .enumerate()
            .filter(|(k, _)| few.is_valid(*k))
            .map(|(k, place)| (*place, few.value(k).as_primitive::<Float64Type>().values().to_vec()))
            .collect();
        self.merge_values(&few);
        for (k, place) in group_indices.iter().enumerate() {
            let bound = Arc::clone(&self.bound);
            let Some(group) = self.groups.get_mut(*place) else { continue };
            if faults.is_valid(k) {
                group.blame(faults.value(k));
            }
            if !triangles.is_valid(k) {
                continue;
            }
            let packed = triangles.value(k);
            let parts = bound.parts.as_ref().ok_or_else(|| exec_datafusion_err!("a state without a question"))?;
            let other = parts
                .unpack(packed.as_primitive::<Float64Type>().values())
                .map_err(|error| exec_datafusion_err!("{error}"))?;
            match &mut group.part {
                Some(part) => part.merge(&other).map_err(|error| exec_datafusion_err!("{error}"))?,
                None => {
                    group.part = Some(Box::new(other));
                    self.triangles += 1;
                }
            }
        }
        Ok(())
    }

    fn convert_to_state(&self, _: &[ArrayRef], _: Option<&BooleanArray>) -> Result<Vec<ArrayRef>> {
        Err(exec_datafusion_err!("a row alone has no triangle"))
    }

    fn size(&self) -> usize {
        let n = self.quantities.names.len() + 2;
        self.groups.capacity() * size_of::<Group>()
            + self.kept * size_of::<Value>()
            + self.triangles * (size_of::<Part>() + 8 * n * n)
            + self.positions.lines.len() * (64 + 16 * n)
    }
}

impl Accumulator for Groups {
    fn update_batch(&mut self, values: &[ArrayRef]) -> Result<()> {
        let rows = values.first().map_or(0, |column| column.len());
        self.update(values, &vec![0; rows], None, 1)
    }

    fn evaluate(&mut self) -> Result<ScalarValue> {
        self.groups.resize_with(1, Group::default);
        ScalarValue::try_from_array(&GroupsAccumulator::evaluate(self, EmitTo::All)?, 0)
    }

    fn size(&self) -> usize {
        GroupsAccumulator::size(self)
    }

    fn state(&mut self) -> Result<Vec<ScalarValue>> {
        self.groups.resize_with(1, Group::default);
        let columns = GroupsAccumulator::state(self, EmitTo::All)?;
        columns.iter().map(|column| ScalarValue::try_from_array(column, 0)).collect()
    }

    fn merge_batch(&mut self, states: &[ArrayRef]) -> Result<()> {
        let rows = states.first().map_or(0, |column| column.len());
        GroupsAccumulator::merge_batch(self, states, &vec![0; rows], 1)
    }
}

impl Group {
    fn blame(&mut self, fault: &str) {
        if self.fault.as_deref().is_none_or(|own| fault < own) {
            self.fault = Some(fault.into());
        }
    }

    /// Fold the values that are kept; how many triangles are new (0 or 1).
    fn fold(&mut self, bound: &Bound, positions: &Positions) -> usize {
        if self.kept.is_empty() {
            return 0;
        }
        let Some(parts) = &bound.parts else { return 0 };
        let mut values: Vec<(&Line, Observation)> = Vec::with_capacity(self.kept.len());
        for value in &self.kept {
            if let Some(Ok(lines)) = positions.lines.get(value.position as usize)
                && let Some(Ok(line)) = lines.get(value.sensor as usize)
            {
                values.push((line, value.observation));
            }
        }
        let is_new = self.part.is_none();
        let part = self.part.get_or_insert_with(|| Box::new(parts.nothing()));
        let pushed = parts.push(part, &values);
        self.kept = Vec::new();
        if let Err(error) = pushed {
            self.blame(&said(&error));
        }
        usize::from(is_new)
    }
}

impl Positions {
    /// The cells of a position.
    fn key(&self, position: u32, width: usize) -> Vec<f64> {
        let place = position as usize * width;
        let key = self.keys.get(place..place + width).unwrap_or_default();
        key.iter().map(|bits| if *bits == u64::MAX { f64::NAN } else { f64::from_bits(*bits) }).collect()
    }

    /// The place of a position; a new one gets one.
    fn find(&mut self, key: &[u64], before: Option<u32>) -> u32 {
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
    fn evaluate(&mut self, bound: &Bound, from: usize) {
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
fn lines(bound: &Bound, keys: &[&[u64]], sensors: &[usize]) -> tumble::Result<Vec<Vec<Line>>> {
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
    let mut found: Vec<Vec<Line>> = keys.iter().map(|_| Vec::with_capacity(sensors.len())).collect();
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
fn refused(bound: &Bound, columns: &[Vec<f64>], row: usize) -> String {
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
fn said(error: &tumble::Malformed) -> String {
    let mut text = error.what().to_string();
    if let Some(expected) = error.expectation() {
        text += &format!("; expected: {expected}");
    }
    if let Some(found) = error.finding() {
        text += &format!("; found: {found}");
    }
    text
}

/// The row of a device with a row that is no reading.
fn malformed(row: Row, fault: &str) -> Row {
    let nothing = vec![f64::NAN; row.value.len()];
    Row {
        verdict: Verdict::Malformed,
        conformity: None,
        why: fault.into(),
        readings: 0,
        rank: 0,
        dof: 0,
        value: nothing.clone(),
        u: nothing.clone(),
        expanded: nothing.clone(),
        type_a: nothing,
        residual_sd: f64::NAN,
        chi_square_p: f64::NAN,
        ..row
    }
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
