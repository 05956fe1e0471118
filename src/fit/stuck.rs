//! Channels that are stuck: every reading the same, whatever the inputs were.

use super::Fit;
use crate::design::{DesignMatrix, RowOrigin};
use crate::elements::Elements;
use crate::quality;

/// The rows of a sensor whose readings cannot all be the same: more of them than there are unknowns in its line, at inputs for which the line is not the same.
#[derive(Debug, Clone)]
pub(crate) struct Channel {
    /// The sensor, by its index in the bench.
    pub sensor: usize,
    /// Its rows of the design.
    pub rows: Vec<usize>,
}

impl Channel {
    /// The channels of a design with `unknowns` columns of unknowns.
    pub(crate) fn of(design: &DesignMatrix, unknowns: usize, sensors: usize) -> Vec<Channel> {
        let at = |i: usize, j: usize| if j < unknowns { design.jacobian[(i, j)] } else { design.predicted.at(i) };
        (0..sensors).filter_map(|sensor| Channel::among(sensor, &design.rows, unknowns, at)).collect()
    }

    /// A sensor's channel; `at` has the columns of the unknowns, and behind them the prediction.
    pub(crate) fn among(
        sensor: usize,
        rows: &[RowOrigin],
        unknowns: usize,
        at: impl Fn(usize, usize) -> f64,
    ) -> Option<Channel> {
        let rows: Vec<usize> =
            rows.iter().enumerate().filter(|(_, own)| own.sensor == sensor).map(|(i, _)| i).collect();
        changes(&rows, unknowns, at).then_some(Channel { sensor, rows })
    }

    /// The value that all its readings have, where that is one and the fit leaves nothing of it.
    pub(crate) fn stuck(&self, value: impl Fn(usize) -> f64, residual: impl Fn(usize) -> f64) -> Option<f64> {
        let own = same(self.rows.iter().map(|row| value(*row)))?;
        is_all(own, self.rows.iter().map(|row| residual(*row))).then_some(own)
    }
}

/// Do readings in these rows say more than one thing: are they more than the unknowns that they have a part in, and not all alike?
pub(crate) fn changes(rows: &[usize], unknowns: usize, at: impl Fn(usize, usize) -> f64) -> bool {
    let Some((first, others)) = rows.split_first() else { return false };
    let touched = (0..unknowns).filter(|j| rows.iter().any(|i| at(*i, *j) != 0.0)).count();
    rows.len() > touched && (0..=unknowns).any(|j| others.iter().any(|i| at(*i, j) != at(*first, j)))
}

/// The value that all of several have.
pub(crate) fn same(mut values: impl Iterator<Item = f64>) -> Option<f64> {
    let first = values.next()?;
    values.all(|value| value == first).then_some(first)
}

/// Are these residuals of readings of one value no more than rounding? A value that is stated as a reference (the norm of gravity) leaves the
/// noise of what is compared with it; a channel that is stuck has none.
pub(crate) fn is_all(value: f64, residuals: impl Iterator<Item = f64>) -> bool {
    let (squares, count) = residuals.fold((0.0, 0), |(sum, count), v| (sum + v * v, count + 1));
    // of readings of zero a solution of other rows leaves the rounding of its rounding
    quality::is_rounding(squares, count, value.abs().max(f64::EPSILON))
}

impl Fit {
    /// Sensors (with the value) whose readings are all the same to the last digit and are met to rounding, though their line is not the same for all: a
    /// channel that is stuck, or a resolution that shows nothing.
    pub fn stuck(&self) -> Vec<(&str, f64)> {
        let value = |row: usize| {
            let origin = self.design.rows.get(row)?;
            let reading = self.campaign.readings.rows.get(origin.reading)?;
            reading.observations.iter().find(|own| own.sensor == origin.sensor).map(|own| own.value)
        };
        let of = |sensor: usize| self.design.rows.iter().enumerate().filter(move |(_, own)| own.sensor == sensor);
        let sensors = 0..self.campaign.bench.sensors.len();
        // what reads more than one value is not looked at further
        let candidates: Vec<usize> =
            sensors.filter(|s| same(of(*s).filter_map(|(row, _)| value(row))).is_some()).collect();
        if candidates.is_empty() {
            return Vec::new();
        }
        let channels = Channel::of(&self.design, self.campaign.unknowns(), self.campaign.bench.sensors.len());
        let found = channels.iter().filter(|own| candidates.contains(&own.sensor));
        found
            .filter_map(|own| {
                let residual = |row: usize| self.estimate.residuals.get(row).copied().unwrap_or(f64::NAN);
                let value = own.stuck(|row| value(row).unwrap_or(f64::NAN), residual)?;
                Some((self.campaign.sensor_id(own.sensor), value))
            })
            .collect()
    }
}
