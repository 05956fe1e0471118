//! The first look at a record: how many rows it has, the ranges of its inputs, and a sample of its rows.

use super::Rows;
use crate::campaign::{Reading, Readings};
use crate::error::Result;

/// Most rows of a sample.
const MOST: usize = 2000;

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
}

/// Look at all rows of a record. Errors: those of reading it.
pub fn sample(rows: &mut dyn Rows) -> Result<Sample> {
    rows.rewind()?;
    let columns = rows.columns().to_vec();
    let mut found = Sample { ranges: vec![(f64::INFINITY, f64::NEG_INFINITY); columns.len()], ..Sample::default() };
    let mut kept: Vec<Reading> = Vec::new();
    let (mut step, mut block) = (1_u64, Vec::new());
    while rows.next(&mut block)? {
        for reading in &block {
            for ((low, high), value) in found.ranges.iter_mut().zip(&reading.columns) {
                if let Some(value) = value {
                    (*low, *high) = (low.min(*value), high.max(*value));
                }
            }
            if found.rows.is_multiple_of(step) {
                kept.push(reading.clone());
                found.numbers.push(found.rows + 1);
            }
            found.rows += 1;
            if kept.len() > MOST {
                step *= 2;
                let mut of = found.numbers.iter();
                kept.retain(|_| of.next().is_some_and(|number| (number - 1).is_multiple_of(step)));
                found.numbers.retain(|number| (number - 1).is_multiple_of(step));
            }
        }
    }
    found.readings = Readings { columns, rows: kept };
    Ok(found)
}
