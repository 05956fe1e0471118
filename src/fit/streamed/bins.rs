//! Lack of fit over the ranges of the inputs: would a step in each part of an input's range explain more than noise?
//!
//! A step for each bin but the first is a column `b` beside the unknowns; what these columns explain together of the independent rows is `chi^2` with as many degrees
//! of freedom as they have columns that the model does not have itself:
//!
//! ```text
//! G = B'B - B'Q (Q'Q)^-1 Q'B,   s = B'y - B'Q (Q'Q)^-1 Q'y,   chi^2 = s' G^+ s        Q: the rows in directions that are nearly orthonormal
//! ```
//!
//! Of white rows a step is one number in one bin; of rows whose noise is correlated in time the filter that makes them independent has a mean for each bin.
#![allow(
    clippy::indexing_slicing,
    reason = "bins are counted when they are made; matrices have a row or a column for each"
)]

use super::noise::Together;
use super::question::{Chunk, Folding};
use super::residuals::{Bin, BinnedResiduals};
use crate::elements::Elements;
use crate::estimate::Sum;
use crate::linear::{dot, turned};
use crate::number;
use crate::uncertainty::quantiles;
use faer::linalg::solvers::Solve;
use faer::{Mat, Side};

/// Parts of a range.
const BINS: usize = 8;
/// Numbers of a register: products are summed up a whole one at a time, and behind the last of them stand zeros.
const LANES: usize = 4;
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
    /// Where a value lies in the range, in bins.
    fn share(&self, value: f64) -> f64 {
        BINS as f64 * (value - self.low) / (self.high - self.low)
    }
}

/// Rows of one sensor in the bins of every input.
pub(super) struct Binned {
    inputs: Vec<Steps>,
    /// The last block, row by row: directions, observation.
    rows: Vec<f64>,
    /// Where the values of an input lie in its range.
    shares: Vec<f64>,
}

/// Sums of one input.
struct Steps {
    counts: [u64; BINS],
    /// Of the residuals as they were read.
    sums: [Sum; BINS],
    /// Mean that the filter has of each bin's ones.
    means: [f64; BINS],
    /// `B'B`
    squares: [[f64; BINS]; BINS],
    /// `B'[Q y]`, bin by bin
    products: Vec<f64>,
}

impl Binned {
    /// For rows in so many directions.
    pub(super) fn new(inputs: usize, directions: usize) -> Self {
        let steps = || Steps {
            counts: [0; BINS],
            sums: [Sum::default(); BINS],
            means: [0.0; BINS],
            squares: [[0.0; BINS]; BINS],
            products: vec![0.0; BINS * (directions + 1).next_multiple_of(LANES)],
        };
        Binned { inputs: (0..inputs).map(|_| steps()).collect(), rows: Vec::new(), shares: Vec::new() }
    }

    /// Takes a block that was folded: `turned` are its independent rows in the directions, observations behind them, and `residuals` those of the rows as they were
    /// read.
    pub(super) fn push(
        &mut self,
        inputs: &[Input],
        chunk: &Chunk<'_>,
        residuals: &[f64],
        (turned, folding): (&Mat<f64>, &Folding),
    ) {
        let width = turned.ncols().next_multiple_of(LANES);
        self.rows.resize(turned.nrows() * width, 0.0);
        for j in 0..turned.ncols() {
            let column = turned.col_as_slice(j).iter();
            self.rows.iter_mut().skip(j).step_by(width).zip(column).for_each(|(to, value)| *to = *value);
        }
        let filter = folding.filter();
        let correlated = filter.is_correlated();
        for ((steps, input), values) in self.inputs.iter_mut().zip(inputs).zip(chunk.inputs) {
            self.shares.clear();
            self.shares.extend(values.iter().map(|value| input.share(*value)));
            for (i, (share, row)) in self.shares.iter().zip(self.rows.chunks_exact(width)).enumerate() {
                let bin = share.is_finite().then(|| number::count(*share).min(BINS - 1));
                if let Some(bin) = bin {
                    steps.counts[bin] += 1;
                    steps.sums[bin].add(residuals[i]);
                }
                let touched = if correlated { 0..BINS } else { bin.map_or(0..0, |bin| bin..bin + 1) };
                let [keeps, gain, over] = filter.gain(i);
                let mut ones = [0.0; BINS];
                for b in touched.clone() {
                    let mean = keeps * steps.means[b];
                    let innovation = f64::from(u8::from(bin == Some(b))) - mean;
                    steps.means[b] = mean + gain * innovation;
                    ones[b] = innovation * over;
                    let products = steps.products[b * width..(b + 1) * width].as_chunks_mut::<LANES>().0;
                    for (sums, parts) in products.iter_mut().zip(row.as_chunks::<LANES>().0) {
                        sums.iter_mut().zip(parts).for_each(|(sum, part)| *sum += ones[b] * part);
                    }
                }
                for a in touched.clone() {
                    touched.clone().for_each(|b| steps.squares[a][b] += ones[a] * ones[b]);
                }
            }
        }
    }

    /// The tests of all inputs; `of_all` is what the rows of all sensors say in the directions, `scale` the variance of the independent rows.
    pub(super) fn conclude(self, inputs: &[Input], id: &str, of_all: &Directed, scale: f64) -> Vec<BinnedResiduals> {
        let mut found = Vec::with_capacity(inputs.len());
        for (steps, input) in self.inputs.iter().zip(inputs) {
            let (chi_square, dof) = steps.test(of_all, scale);
            if dof == 0 {
                continue;
            }
            let width = (input.high - input.low) / BINS as f64;
            let bins = (0..BINS)
                .map(|k| Bin {
                    low: input.low + width * k as f64,
                    high: input.low + width * (k + 1) as f64,
                    rows: steps.counts[k],
                    mean: (steps.counts[k] > 0).then(|| steps.sums[k].value() / steps.counts[k] as f64),
                })
                .collect();
            // no degrees of freedom: no probability
            let p = quantiles::chi_square_survival(chi_square, dof as f64).unwrap_or(f64::NAN);
            // how many are tested is not known here
            let (sensor, rejected) = (id.to_string(), false);
            found.push(BinnedResiduals { sensor, column: input.name.clone(), chi_square, dof, p, rejected, bins });
        }
        found
    }
}

impl Steps {
    /// `chi^2` and its degrees of freedom.
    fn test(&self, of_all: &Directed, scale: f64) -> (f64, usize) {
        let directions = of_all.unit.nrows();
        let width = (directions + 1).next_multiple_of(LANES);
        let along = |b: usize| &self.products[b * width..b * width + directions];
        let across: Vec<Vec<f64>> = (0..BINS)
            .map(|b| {
                let own = &of_all.unit * Mat::from_fn(directions, 1, |k, _| along(b)[k]);
                own.col_as_slice(0).to_vec()
            })
            .collect();
        let mut s: Vec<f64> = (0..BINS)
            .map(|b| (self.products[b * width + directions] - dot(&across[b], &of_all.observed)) / scale)
            .collect();
        let mut g =
            Mat::from_fn(BINS, BINS, |a, b| self.squares[a][b] / scale - dot(along(a), &across[b]) / (scale * scale));
        let (mut chi_square, mut dof) = (0.0, 0);
        for k in 1..BINS {
            let (pivot, own) = (g[(k, k)], s[k]);
            if !(pivot > SAME * SAME * self.squares[k][k] / scale) {
                continue;
            }
            chi_square += own * own / pivot;
            dof += 1;
            for a in k + 1..BINS {
                let share = g[(a, k)] / pivot;
                s[a] -= share * own;
                (k + 1..BINS).for_each(|b| g[(a, b)] -= share * g[(k, b)]);
            }
        }
        (chi_square, dof)
    }
}

/// What all rows together say in some directions of the unknowns: `(Q'Q)^-1` and `Q'y`.
pub(super) struct Directed {
    unit: Mat<f64>,
    observed: Vec<f64>,
}

impl Directed {
    /// `None` where the directions are not independent.
    pub(super) fn new(solved: &Together, directions: &Mat<f64>) -> Option<Self> {
        let r = directions.ncols();
        let mut all = Mat::<f64>::zeros(r + 1, r + 1);
        let rows = solved.extended.as_ref().map_or(&solved.rows, |(_, rows)| rows);
        for (k, block) in rows.blocks.iter().enumerate() {
            let scale = solved.order.get(k).map_or(1.0, |s| solved.scale.at(*s));
            let own = turned(&block.rows, &block.observed, directions, &[]);
            all += own.transpose() * &own * faer::Scale(1.0 / scale);
        }
        let unit = all.submatrix(0, 0, r, r).llt(Side::Lower).ok()?.solve(&Mat::<f64>::identity(r, r));
        Some(Directed { unit, observed: (0..r).map(|k| all[(k, r)]).collect() })
    }
}
