//! Model lines that follow the columns of the readings and nothing of the bench: rows of the design for many readings at once.

use super::Model;
use super::line::Slot;
use crate::algebra::{Scratch, Tape};
use pulp::{Arch, Simd, WithSimd};

/// A sensor's line over columns and parameters alone.
#[derive(Debug, Clone)]
pub(crate) struct ColumnLine {
    tape: Tape,
    reads: Vec<Read>,
}

/// Where a list of inputs comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Read {
    /// Numeric column of the readings.
    Column(usize),
    /// Parameter of the campaign.
    Parameter(usize),
}

impl Model {
    /// The line of a sensor that follows columns and parameters alone; `None` for one of rates, forces or joints.
    pub(crate) fn column_line(&self, sensor: usize) -> Option<ColumnLine> {
        let line = self.sensor(sensor)?;
        let read = |k: &usize| match line.slots.get(*k)? {
            Slot::Column(k) => Some(Read::Column(*k)),
            Slot::Parameter(k) => Some(Read::Parameter(*k)),
            Slot::Rate(_) | Slot::Force(_) | Slot::Joint(_) => None,
        };
        let reads = line.tape.reads().iter().map(read).collect::<Option<_>>()?;
        Some(ColumnLine { tape: line.tape.clone(), reads })
    }
}

impl ColumnLine {
    /// What it reads, in the order of its lists.
    pub(crate) fn reads(&self) -> &[Read] {
        &self.reads
    }

    /// Values at so many places, and derivatives by everything that it reads; a list of `places` numbers for each. By the widest instructions that there are.
    ///
    /// The numbers of [`Model::predict`] at single instants, to the last bit: each derivative has one term, which nothing cancels.
    pub(crate) fn gradient(
        &self,
        arch: Arch,
        places: usize,
        inputs: &[f64],
        lists: &mut Scratch,
        (values, gradient): (&mut [f64], &mut [f64]),
    ) {
        arch.dispatch(Gradient { tape: &self.tape, places, inputs, lists, values, gradient });
    }
}

/// What [`ColumnLine::gradient`] is asked.
struct Gradient<'a> {
    tape: &'a Tape,
    places: usize,
    inputs: &'a [f64],
    lists: &'a mut Scratch,
    values: &'a mut [f64],
    gradient: &'a mut [f64],
}

impl WithSimd for Gradient<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        self.tape.gradient_of_many(self.places, self.inputs, self.lists, self.values, self.gradient);
    }
}
