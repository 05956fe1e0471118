//! What a record is to a fit: blocks of rows, column by column, in the order in which they were taken, that can be read again from the first.

use crate::campaign::{Place, Reading, Readings};
use crate::error::Result;

/// Rows that were read together, column by column; what a row does not have is NaN.
#[derive(Debug, Clone, Default)]
pub struct Block {
    /// How many rows.
    pub rows: usize,
    /// Numeric columns, in the order of [`Rows::columns`]; a list without numbers where no row has any.
    pub columns: Vec<Vec<f64>>,
    /// What each sensor said, in the bench's order.
    pub sensors: Vec<Observed>,
}

/// What a sensor said in a block of rows; a list is empty where no row has such a number.
#[derive(Debug, Clone, Default)]
pub struct Observed {
    /// Values.
    pub values: Vec<f64>,
    /// Their standard uncertainties.
    pub u: Vec<f64>,
    /// Samples averaged into each; 1 where there is no list.
    pub samples: Vec<f64>,
}

impl Block {
    /// Makes it empty, for so many columns and sensors.
    pub(crate) fn clear(&mut self, columns: usize, sensors: usize) {
        self.rows = 0;
        self.columns.resize_with(columns, Vec::new);
        self.columns.iter_mut().for_each(Vec::clear);
        self.sensors.resize_with(sensors, Observed::default);
        for own in &mut self.sensors {
            for list in [&mut own.values, &mut own.u, &mut own.samples] {
                list.clear();
            }
        }
    }
}

/// A record that is read several times.
pub trait Rows {
    /// Names of the numeric columns that its blocks have, as in [`Readings::columns`].
    fn columns(&self) -> &[String];

    /// Begins again with the first row.
    fn rewind(&mut self) -> Result<()>;

    /// The next rows into `block` (what it held is gone); `false` at the end.
    fn next(&mut self, block: &mut Block) -> Result<bool>;

    /// Row `k` of the last block, which is given back, as a reading (what it held is gone); its place is left as it is.
    fn reading(&self, block: &Block, k: usize, into: &mut Reading) -> Result<()>;

    /// Where row `k` of the last block stands, for messages.
    fn place(&self, k: usize) -> Place;
}

/// Readings at hand, as a record.
#[derive(Debug, Clone)]
pub struct Held {
    readings: Readings,
    sensors: usize,
    /// Rows of the last block.
    block: std::ops::Range<usize>,
}

/// Rows that are given at once.
const BLOCK: usize = 1024;

impl Held {
    /// The record of these readings.
    pub fn new(readings: Readings) -> Self {
        let of = readings.rows.iter().flat_map(|row| &row.observations);
        Held { sensors: of.map(|own| own.sensor + 1).max().unwrap_or(0), block: 0..0, readings }
    }

    fn row(&self, k: usize) -> Option<&Reading> {
        self.readings.rows.get(self.block.start + k)
    }
}

impl Rows for Held {
    fn columns(&self) -> &[String] {
        &self.readings.columns
    }

    fn rewind(&mut self) -> Result<()> {
        self.block = 0..0;
        Ok(())
    }

    fn next(&mut self, block: &mut Block) -> Result<bool> {
        self.block = self.block.end..self.readings.rows.len().min(self.block.end + BLOCK);
        block.clear(self.readings.columns.len(), self.sensors);
        block.rows = self.block.len();
        for row in self.readings.rows.iter().skip(self.block.start).take(block.rows) {
            for (to, value) in block.columns.iter_mut().zip(&row.columns) {
                to.push(value.unwrap_or(f64::NAN));
            }
            for (s, to) in block.sensors.iter_mut().enumerate() {
                let own = row.observations.iter().find(|own| own.sensor == s);
                to.values.push(own.map_or(f64::NAN, |own| own.value));
                to.u.push(own.and_then(|own| own.u).unwrap_or(f64::NAN));
                to.samples.push(own.map_or(1.0, |own| own.samples));
            }
        }
        Ok(block.rows > 0)
    }

    fn reading(&self, _: &Block, k: usize, into: &mut Reading) -> Result<()> {
        if let Some(row) = self.row(k) {
            into.clone_from(row);
        }
        Ok(())
    }

    fn place(&self, k: usize) -> Place {
        self.row(k).map(|row| row.place.clone()).unwrap_or_default()
    }
}

/// Most rows of a sample, kept at steps of a power of two: 1000 to 2000 of a longer record are the readings that a report shows, and where a search begins.
const MOST: u64 = 2000;

/// What is known of a record after one pass.
#[derive(Debug, Clone, Default)]
pub struct Sample {
    /// Rows at equal steps, 1000 to 2000 of a longer record.
    pub readings: Readings,
    /// Number of each in the record, from 1.
    pub numbers: Vec<u64>,
    /// Rows of the record.
    pub rows: u64,
    /// Least and largest number of each column; infinite where it has none.
    pub ranges: Vec<(f64, f64)>,
    /// What the pass has folded already.
    pub(super) first: Option<super::First>,
}

/// Look at all rows of a record. Errors: those of reading it.
pub fn sample(rows: &mut dyn Rows) -> Result<Sample> {
    // nothing is asked of them yet
    super::sampled(rows, &mut |_| None)
}

impl Sample {
    pub(super) fn new(columns: &[String]) -> Self {
        Sample {
            readings: Readings { columns: columns.to_vec(), rows: Vec::new() },
            ranges: vec![(f64::INFINITY, f64::NEG_INFINITY); columns.len()],
            ..Sample::default()
        }
    }

    /// Takes the block that the record gave last.
    pub(super) fn take(&mut self, rows: &dyn Rows, block: &Block) -> Result<()> {
        for ((low, high), list) in self.ranges.iter_mut().zip(&block.columns) {
            let (least, most) = list.iter().fold((*low, *high), |(low, high), x| (low.min(*x), high.max(*x)));
            (*low, *high) = (least, most);
        }
        // rows are kept at steps of a power of two, doubled where they become too many
        let step = |rows: u64| rows.div_ceil(MOST).next_power_of_two();
        let (mut own, before) = (step(self.rows), self.rows);
        let end = before + block.rows as u64;
        let mut next = before.next_multiple_of(own);
        while next < end {
            let mut reading = Reading::default();
            let k = crate::number::index(next - before);
            rows.reading(block, k, &mut reading)?;
            reading.place = rows.place(k);
            self.readings.rows.push(reading);
            self.numbers.push(next + 1);
            if step(next + 1) > own {
                own = step(next + 1);
                let mut of = self.numbers.iter();
                self.readings.rows.retain(|_| of.next().is_some_and(|number| (number - 1).is_multiple_of(own)));
                self.numbers.retain(|number| (number - 1).is_multiple_of(own));
            }
            next = (next + 1).next_multiple_of(own);
        }
        self.rows = end;
        Ok(())
    }
}
