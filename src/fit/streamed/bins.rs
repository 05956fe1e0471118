//! Lack of fit over the ranges of the inputs: would a step in each part of an input's range explain more than noise?
//!
//! A step for each bin but the first is a column beside the unknowns; what these columns explain together of the independent rows is `chi^2` with as many degrees
//! of freedom as they have columns that the model does not have itself.
#![allow(
    clippy::indexing_slicing,
    reason = "a fold's triangle is square: unknowns, steps, observations; bins are counted when they are made"
)]

use super::octaves::Noise;
use super::question::{Chunk, Folding, Question};
use super::residuals::{Bin, BinnedResiduals};
use super::together::Together;
use crate::elements::Elements;
use crate::error::Result;
use crate::estimate::{Fold, Sum};
use crate::number;
use crate::uncertainty::quantiles;
use faer::Mat;
use std::borrow::Cow;

/// Parts of a range.
const BINS: usize = 8;
/// Most inputs that are looked at.
pub(super) const MOST: usize = 6;
/// A column that is nearly one of those before it has so small a rest.
const SAME: f64 = 1e-6;

/// An input whose range is parted.
#[derive(Debug, Clone)]
pub(super) struct Input {
    /// Its column in the readings, and name.
    pub column: usize,
    pub name: String,
    pub low: f64,
    pub high: f64,
}

impl Input {
    fn bin(&self, value: f64) -> usize {
        number::count(BINS as f64 * (value - self.low) / (self.high - self.low)).min(BINS - 1)
    }
}

/// Rows of one sensor, with the steps of every input.
pub(super) struct Binned {
    folding: Folding,
    counts: Vec<[u64; BINS]>,
    sums: Vec<[Sum; BINS]>,
    /// Unknowns, steps, observations of the last block, and the places of its ones among the steps.
    rows: Mat<f64>,
    ones: Vec<(usize, usize)>,
}

impl Binned {
    pub(super) fn new(question: &Question, inputs: &[Input], noise: Noise) -> Self {
        Binned {
            folding: Folding::new(question.unknowns + question.carried.len(), inputs.len() * (BINS - 1), noise),
            counts: vec![[0; BINS]; inputs.len()],
            sums: vec![[Sum::default(); BINS]; inputs.len()],
            rows: Mat::new(),
            ones: Vec::new(),
        }
    }

    /// Takes a block; `residuals` are those of the rows as they were read. Gives the rows back made independent: unknowns, steps, observations.
    pub(super) fn push(
        &mut self,
        unknowns: usize,
        inputs: &[Input],
        chunk: &Chunk<'_>,
        residuals: &[f64],
    ) -> Result<Cow<'_, Mat<f64>>> {
        let (k, steps) = (chunk.rows.nrows(), inputs.len() * (BINS - 1));
        let rows = &mut self.rows;
        if rows.shape() == (k, unknowns + steps + 1) {
            self.ones.drain(..).for_each(|place| rows[place] = 0.0);
        } else {
            *rows = Mat::zeros(k, unknowns + steps + 1);
            self.ones.clear();
        }
        for j in 0..unknowns {
            rows.col_as_slice_mut(j).copy_from_slice(chunk.rows.col_as_slice(j));
        }
        rows.col_as_slice_mut(unknowns + steps).copy_from_slice(chunk.observed());
        for (place, (input, values)) in inputs.iter().zip(chunk.inputs).enumerate() {
            for (i, value) in values.iter().enumerate().filter(|(_, value)| value.is_finite()) {
                let bin = input.bin(*value);
                self.counts[place][bin] += 1;
                self.sums[place][bin].add(residuals[i]);
                if bin > 0 {
                    let one = (i, unknowns + place * (BINS - 1) + bin - 1);
                    rows[one] = 1.0;
                    self.ones.push(one);
                }
            }
        }
        self.folding.push(&self.rows, chunk.time, chunk.relative)
    }

    /// The tests of all inputs; `solved` has the rows of the other sensors, and the scales of all.
    pub(super) fn conclude(
        self,
        question: &Question,
        inputs: &[Input],
        (sensor, id): (usize, &str),
        solved: &Together,
    ) -> Result<Vec<BinnedResiduals>> {
        // beside the known inputs, too
        let n = question.unknowns + question.carried.len();
        let Binned { folding, counts, sums, .. } = self;
        let part = folding.part();
        let triangle = question.extended(&part.fold.triangle().to_owned());
        let z = part.block(n).observed;
        let sd = |s: Option<&usize>| s.map_or(1.0, |s| solved.scale.at(*s).sqrt());
        let rows = solved.extended.as_ref().map_or(&solved.rows, |(_, rows)| rows);
        let others = || rows.blocks.iter().enumerate().map(|(k, own)| (solved.order.get(k), own));
        let mut found = Vec::with_capacity(inputs.len());
        for (place, input) in inputs.iter().enumerate() {
            let mut fold = Fold::carrying(n, BINS - 1);
            let first = n + place * (BINS - 1);
            let of = |j: usize| if j < n { j } else { first + j - n };
            let rows = Mat::from_fn(triangle.nrows(), n + BINS - 1, |i, j| triangle[(i, of(j))]);
            fold.push(rows.as_ref(), &z, &vec![sd(Some(&sensor)); triangle.nrows()])?;
            for (s, own) in others().filter(|(s, own)| *s != Some(&sensor) && !own.observed.is_empty()) {
                let row = |i: usize, j: usize| if j < n { own.rows[(i, j)] } else { 0.0 };
                let rows = Mat::from_fn(own.observed.len(), n + BINS - 1, row);
                fold.push(rows.as_ref(), &own.observed, &vec![sd(s); own.observed.len()])?;
            }
            let whole = fold.triangle();
            let last = whole.ncols() - 1;
            let (mut chi_square, mut dof) = (0.0, 0);
            for k in n..last {
                let norm = (0..=k).map(|i| whole[(i, k)] * whole[(i, k)]).sum::<f64>().sqrt();
                if norm > 0.0 && whole[(k, k)].abs() > SAME * norm {
                    chi_square += whole[(k, last)] * whole[(k, last)];
                    dof += 1;
                }
            }
            if dof == 0 {
                continue;
            }
            let width = (input.high - input.low) / BINS as f64;
            let bins = (0..BINS)
                .map(|k| Bin {
                    low: input.low + width * k as f64,
                    high: input.low + width * (k + 1) as f64,
                    rows: counts[place][k],
                    mean: (counts[place][k] > 0).then(|| sums[place][k].value() / counts[place][k] as f64),
                })
                .collect();
            // no degrees of freedom: no probability
            let p = quantiles::chi_square_survival(chi_square, dof as f64).unwrap_or(f64::NAN);
            // how many are tested is not known here
            let (sensor, rejected) = (id.to_string(), false);
            found.push(BinnedResiduals { sensor, column: input.name.clone(), chi_square, dof, p, rejected, bins });
        }
        Ok(found)
    }
}
