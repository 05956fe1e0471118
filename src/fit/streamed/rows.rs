//! What a record is to a fit: readings in the order in which they were taken, that can be read again from the first.

use crate::campaign::{Reading, Readings};
use crate::error::Result;

/// A record that is read several times.
pub trait Rows {
    /// Names of the numeric columns that its readings have, as in [`Readings::columns`].
    fn columns(&self) -> &[String];

    /// Begins again with the first row.
    fn rewind(&mut self) -> Result<()>;

    /// The next rows into `readings` (what they held is gone); `false` at the end.
    fn next(&mut self, readings: &mut Vec<Reading>) -> Result<bool>;
}

/// Readings at hand, as a record.
#[derive(Debug, Clone)]
pub struct Held {
    readings: Readings,
    next: usize,
}

/// Rows that are given at once.
const BLOCK: usize = 1024;

impl Held {
    /// The record of these readings.
    pub fn new(readings: Readings) -> Self {
        Held { readings, next: 0 }
    }
}

impl Rows for Held {
    fn columns(&self) -> &[String] {
        &self.readings.columns
    }

    fn rewind(&mut self) -> Result<()> {
        self.next = 0;
        Ok(())
    }

    fn next(&mut self, readings: &mut Vec<Reading>) -> Result<bool> {
        readings.clear();
        readings.extend(self.readings.rows.iter().skip(self.next).take(BLOCK).cloned());
        self.next += readings.len();
        Ok(!readings.is_empty())
    }
}
