//! The readings of one device, row by row.

use super::{Layout, Use};
use crate::mix::Mix;
use crate::quality::{Repeated, repeated};
use crate::record::{RAGGED, UNREADABLE};
use std::hash::Hasher;
use std::sync::Arc;

/// One device's rows of a table.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Device {
    /// Its serial number, or another label of the column that identifies the device.
    pub label: String,
    /// Input columns of each row, one row after the other; NaN where a cell is empty.
    pub inputs: Vec<f64>,
    /// Values of each row, one row after the other, in the order of the layout's sensors; NaN where nothing was read.
    pub values: Vec<f64>,
    /// Further cells of each row, as they are written.
    pub others: Vec<String>,
    /// Number of its rows.
    pub rows: usize,
    /// Where its first row stands in the table, counted from 1.
    pub first_row: u64,
    /// Where its rows stand, one run after the other; none where that is not known.
    pub runs: Vec<Run>,
    /// The position of each row, by its place among `positions`, where the table has labels of positions; a row without one has a place behind
    /// them. None where it has no labels.
    pub groups: Vec<u32>,
    /// Labels of the positions, in ascending order.
    pub positions: Vec<Arc<str>>,
    /// Are these rows without a label: no device at all?
    pub nameless: bool,
    /// Text of the column that rows are ordered by on a control chart (a date, a lot); empty where there is none.
    pub lot: String,
}

/// Rows that stand one after the other in a file, or at equal distances.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Run {
    /// The file.
    pub file: Arc<str>,
    /// The line in which the first of them begins, or its number among the rows, counted from 1.
    pub first: u64,
    /// From one to the next.
    pub step: u64,
    /// How many.
    pub rows: usize,
    /// Is that a line of a text?
    pub is_line: bool,
}

impl Device {
    /// Further rows stand here: one, or several one after the other.
    pub(crate) fn push_run(&mut self, file: &Arc<str>, (first, rows): (u64, usize), is_line: bool) {
        if let Some(last) = self.runs.last_mut()
            && Arc::ptr_eq(&last.file, file)
            && last.is_line == is_line
        {
            if last.rows == 1 && rows == 1 && first > last.first {
                (last.step, last.rows) = (first - last.first, 2);
                return;
            }
            if first == last.first + last.step * last.rows as u64 && (rows == 1 || last.step == 1) {
                last.rows += rows;
                return;
            }
        }
        self.runs.push(Run { file: file.clone(), first, step: 1, rows, is_line });
    }

    /// A row more of a position; no row has one behind that lacks it.
    pub(crate) fn push_position(&mut self, label: &Arc<str>) {
        let is_same = |there: &Arc<str>| Arc::ptr_eq(there, label) || there == label;
        // most rows have the position of the row before
        let last = self.groups.last().filter(|last| self.positions.get(**last as usize).is_some_and(is_same));
        let group = last.map(|last| *last as usize).or_else(|| self.positions.iter().position(is_same));
        let group = group.unwrap_or_else(|| {
            self.positions.push(label.clone());
            self.positions.len() - 1
        });
        self.groups.push(u32::try_from(group).unwrap_or(u32::MAX));
    }

    /// Positions in ascending order, once all rows are there: devices with the same positions agree in it, whatever the order of their rows.
    pub(crate) fn order_positions(&mut self) {
        if self.positions.is_sorted() {
            return;
        }
        let mut order: Vec<usize> = (0..self.positions.len()).collect();
        order.sort_by_key(|k| self.positions.get(*k));
        let mut rank = vec![0_u32; order.len()];
        for (place, k) in order.iter().enumerate() {
            rank.get_mut(*k).into_iter().for_each(|slot| *slot = u32::try_from(place).unwrap_or(u32::MAX));
        }
        for group in &mut self.groups {
            *group = rank.get(*group as usize).copied().unwrap_or(*group);
        }
        self.positions.sort();
    }

    /// The label of a row's position; empty where it has none.
    pub fn position(&self, row: usize) -> &str {
        let position = self.groups.get(row).and_then(|group| self.positions.get(*group as usize));
        position.map_or("", |label| label)
    }

    /// Where a row (from 0) stands: the file, the line or row, and whether it is a line.
    pub(crate) fn origin(&self, row: usize) -> Option<(&str, u64, bool)> {
        let mut before = 0;
        let run = self.runs.iter().find(|run| {
            before += run.rows;
            row < before
        })?;
        Some((&run.file, run.first + run.step * (row + run.rows - before) as u64, run.is_line))
    }

    /// The same in words.
    pub(super) fn place(&self, row: usize) -> Option<String> {
        let (file, number, is_line) = self.origin(row)?;
        if file.is_empty() {
            // in the campaign itself
            return Some(format!("readings[{}]", number.saturating_sub(1)));
        }
        Some(format!("{} {number} of {file}", if is_line { "line" } else { "row" }))
    }

    /// Rows that repeat others, value by value to the last digit.
    pub(super) fn repeated(&self) -> Option<Repeated> {
        let (inputs, sensors) = (self.inputs.len() / self.rows.max(1), self.values.len() / self.rows.max(1));
        let hash = |cells: &[f64]| {
            let mut state = Mix::default();
            cells.iter().for_each(|x| state.write_u64(bits(*x)));
            state.finish()
        };
        let of = |row: usize| {
            let values = self.value(row, sensors);
            // a row without a value repeats nothing
            let read = if values.iter().any(|x| x.is_finite()) { hash(values) } else { row as u64 };
            (hash(self.input(row, inputs)), read)
        };
        let rows: Vec<(u64, u64)> = (0..self.rows).map(of).collect();
        repeated(&rows, sensors, |row, sensor| self.value(row, sensors).get(sensor).copied())
    }
    /// Is it a device, and every cell a number or empty?
    pub(crate) fn is_plain(&self) -> bool {
        let unread = |x: &f64| [UNREADABLE, RAGGED].iter().any(|special| special.to_bits() == x.to_bits());
        let cells = self.inputs.iter().chain(&self.values);
        !self.nameless && cells.copied().all(|x| x.is_finite() || (x.is_nan() && !unread(&x)))
    }

    /// A row's inputs; none where whoever made the device gave fewer than it has rows.
    pub(crate) fn input(&self, row: usize, width: usize) -> &[f64] {
        self.inputs.get(row * width..(row + 1) * width).unwrap_or_default()
    }

    /// Rows in which the sensor of this place among so many was read, with its values.
    pub(super) fn read(&self, slot: usize, sensors: usize) -> impl Iterator<Item = (usize, f64)> + '_ {
        let values = self.values.iter().copied().skip(slot).step_by(sensors.max(1));
        values.take(self.rows).enumerate().filter(|(_, value)| !value.is_nan())
    }

    /// A row's values; none likewise.
    pub(crate) fn value(&self, row: usize, sensors: usize) -> &[f64] {
        self.values.get(row * sensors..(row + 1) * sensors).unwrap_or_default()
    }
}

/// A schedule: inputs of every row and which values were read there, in some order of the rows.
#[derive(Debug, Clone, Copy)]
pub(super) struct Shape<'a> {
    pub device: &'a Device,
    pub inputs: usize,
    pub sensors: usize,
}

/// Bits of a number in which both zeros, and all that is absent, are one.
pub(super) fn bits(x: f64) -> u64 {
    if x.is_nan() { u64::MAX } else { (x + 0.0).to_bits() }
}

impl<'a> Shape<'a> {
    pub(super) fn of(device: &'a Device, layout: &Layout) -> Self {
        let inputs = layout.uses.iter().filter(|kind| **kind == Use::Input).count();
        let sensors = layout.uses.iter().filter(|kind| matches!(kind, Use::Value(_))).count();
        Shape { device, inputs, sensors }
    }

    fn key(&self, row: usize) -> impl Iterator<Item = u64> + use<'a> {
        let read = self.device.value(row, self.sensors).iter().map(|x| u64::from(!x.is_nan()));
        let group = self.device.groups.get(row).map(|group| u64::from(*group));
        self.device.input(row, self.inputs).iter().map(|x| bits(*x)).chain(read).chain(group)
    }

    /// Rows in an order that does not depend on the file's; rows that are alike stay in the file's order.
    pub(super) fn order(&self) -> Vec<usize> {
        let mut order: Vec<usize> = (0..self.device.rows).collect();
        order.sort_by(|a, b| self.key(*a).cmp(self.key(*b)));
        order
    }

    /// A number for the rows, whatever their order.
    pub(super) fn hash_of_rows(&self) -> u64 {
        let mut sum = self.device.rows as u64;
        for row in 0..self.device.rows {
            let mut state = Mix::default();
            self.key(row).for_each(|word| state.write_u64(word));
            // mixed once more, so that sums of rows tell schedules apart
            state.write_u64(0);
            sum = sum.wrapping_add(state.finish());
        }
        sum
    }

    /// A number for the rows in their order.
    pub(super) fn hash_in_order(&self) -> u64 {
        let mut state = Mix::default();
        (0..self.device.rows).for_each(|row| self.key(row).for_each(|word| state.write_u64(word)));
        state.finish()
    }

    /// Are these the same rows in the same order, bit by bit? Quick, and what is not may yet be the same.
    pub(super) fn is_alike(&self, other: &Shape<'_>) -> bool {
        let (this, others) = (self.device, other.device);
        let same = |(a, b): (&f64, &f64)| a.to_bits() == b.to_bits();
        let read = |(a, b): (&f64, &f64)| a.is_nan() == b.is_nan();
        this.rows == others.rows
            && this.inputs.len() == others.inputs.len()
            && this.values.len() == others.values.len()
            && this.groups == others.groups
            && this.inputs.iter().zip(&others.inputs).fold(true, |all, pair| all & same(pair))
            && this.values.iter().zip(&others.values).fold(true, |all, pair| all & read(pair))
    }

    /// Are these the same rows?
    pub(super) fn same(
        &self,
        order: impl Iterator<Item = usize>,
        other: &Shape<'_>,
        others: impl Iterator<Item = usize>,
    ) -> bool {
        self.device.rows == other.device.rows && order.zip(others).all(|(a, b)| self.key(a).eq(other.key(b)))
    }
}
