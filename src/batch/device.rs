//! The readings of one device, row by row.

use super::{Layout, Use};
use crate::mix::Mix;
use crate::record::UNREADABLE;
use std::hash::Hasher;

/// One device's rows of a table.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Device {
    /// Its serial number, or whatever the column says that tells devices apart.
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
    /// Text of the column that rows are ordered by on a control chart (a date, a lot); empty where there is none.
    pub lot: String,
}

impl Device {
    /// Is every cell a number or empty?
    pub fn is_plain(&self) -> bool {
        self.inputs
            .iter()
            .chain(&self.values)
            .all(|x| x.is_finite() || (x.is_nan() && x.to_bits() != UNREADABLE.to_bits()))
    }

    /// A row's inputs; none where whoever made the device gave fewer than it has rows.
    pub(super) fn input(&self, row: usize, width: usize) -> &[f64] {
        self.inputs.get(row * width..(row + 1) * width).unwrap_or_default()
    }

    /// A row's values; none likewise.
    pub(super) fn value(&self, row: usize, sensors: usize) -> &[f64] {
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
fn bits(x: f64) -> u64 {
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
        self.device.input(row, self.inputs).iter().map(|x| bits(*x)).chain(read)
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

    /// Are these the same rows in the same order, bit by bit? Quick, and what is not may yet be the same.
    pub(super) fn is_alike(&self, other: &Shape<'_>) -> bool {
        let (own, others) = (self.device, other.device);
        let same = |(a, b): (&f64, &f64)| a.to_bits() == b.to_bits();
        let read = |(a, b): (&f64, &f64)| a.is_nan() == b.is_nan();
        own.rows == others.rows
            && own.inputs.len() == others.inputs.len()
            && own.values.len() == others.values.len()
            && own.inputs.iter().zip(&others.inputs).fold(true, |all, pair| all & same(pair))
            && own.values.iter().zip(&others.values).fold(true, |all, pair| all & read(pair))
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
