//! The first look at a record: how many rows it has, the ranges of its inputs, and a sample of its rows.

use super::{Block, Rows};
use crate::campaign::{Reading, Readings};
use crate::error::Result;

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
