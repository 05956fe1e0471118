//! Devices while their rows come: positions evaluated once, values kept until there are enough of them to be folded into a triangle.

use crate::answer;
use crate::positions::{Positions, numbers, refused, said};
use crate::question::{Bound, Quantities};
use datafusion::arrow::array::{Array, ArrayRef, AsArray, BooleanArray, ListBuilder, PrimitiveBuilder, StringBuilder};
use datafusion::arrow::datatypes::{DataType, Float64Type};
use datafusion::common::{Result, ScalarValue, exec_datafusion_err};
use datafusion::logical_expr::{Accumulator, EmitTo, GroupsAccumulator};
use std::sync::Arc;
use tumble::batch::{Coverage, DesignRow, Part, Parts, Row, Verdict};
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
                // a reading that was not made, whatever its u says
                if value.is_nan() {
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
        let mut values: Vec<(&DesignRow, Observation)> = Vec::with_capacity(self.kept.len());
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
