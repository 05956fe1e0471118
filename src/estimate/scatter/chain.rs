//! Rows whose noise is correlated in time, made independent together with the derivatives of what they say by the noise.
//!
//! ```text
//! y_i = a_i x + d_i + e_i,   var e_i = w r_i^2,   cov(d_i, d_j) = q exp(-|t_i - t_j|/tau),   V = w V1(rho, phi),   rho = ln(q/w),  phi = ln tau
//! p_i = rho' + k^2 (P - rho'),  F_i = p_i + r_i^2,  g = p_i/F_i,  P = g r_i^2,     k = exp(-dt/tau),  rho' = q/w
//! a = k a,  e = y - a,  a = a + g e,  w_i = e/sqrt(F_i)
//! ```
//!
//! The Kalman filter of `estimate::Sequential` (A. C. Harvey 1989, section 3.4), in numbers that carry their first and second derivatives by `rho` and `phi`:
//! `log|V1|` and the products `C' V1^-1 C` of all columns come with theirs after one pass along time, exactly, whatever the number of rows.
#![allow(
    clippy::indexing_slicing,
    reason = "a jet has its six numbers, a part as many Gram matrices, and blocks have the columns for which the filter was made"
)]

use crate::error::Result;
use crate::estimate::{Sequential, backwards};
use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatRef, Par};

/// Rows that are taken at a time.
const BLOCK: usize = 256;

/// A number with its derivatives: value; by rho, phi; by rho rho, rho phi, phi phi.
#[derive(Debug, Clone, Copy)]
struct Jet([f64; 6]);

impl Jet {
    fn of(value: f64) -> Self {
        Jet([value, 0.0, 0.0, 0.0, 0.0, 0.0])
    }

    fn plus(self, other: Self) -> Self {
        Jet(std::array::from_fn(|k| self.0[k] + other.0[k]))
    }

    fn minus(self, other: Self) -> Self {
        Jet(std::array::from_fn(|k| self.0[k] - other.0[k]))
    }

    fn scaled(self, by: f64) -> Self {
        Jet(self.0.map(|x| x * by))
    }

    fn times(self, other: Self) -> Self {
        let (a, b) = (self.0, other.0);
        Jet([
            a[0] * b[0],
            a[0] * b[1] + a[1] * b[0],
            a[0] * b[2] + a[2] * b[0],
            a[0] * b[3] + 2.0 * a[1] * b[1] + a[3] * b[0],
            a[0] * b[4] + a[1] * b[2] + a[2] * b[1] + a[4] * b[0],
            a[0] * b[5] + 2.0 * a[2] * b[2] + a[5] * b[0],
        ])
    }

    /// A function of it, from its value and two derivatives there.
    fn through(self, [f, slope, bend]: [f64; 3]) -> Self {
        let a = self.0;
        Jet([
            f,
            slope * a[1],
            slope * a[2],
            slope * a[3] + bend * a[1] * a[1],
            slope * a[4] + bend * a[1] * a[2],
            slope * a[5] + bend * a[2] * a[2],
        ])
    }
}

/// Noise along time, as variances: the white part as a factor of the rows' own, the deviation that is correlated.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TimeNoise {
    /// Variance factor of the white noise.
    pub white: f64,
    /// Variance of the deviation.
    pub deviation: f64,
    /// Its correlation time.
    pub tau: f64,
}

/// What a part of the rows says at some noise, the white noise having the factor 1: `log|V1|` and `C' V1^-1 C` over all columns, observations last, with their
/// derivatives; those are empty where nothing is correlated or none were asked for.
#[derive(Debug, Clone)]
pub struct Part {
    pub(super) rows: f64,
    pub(super) log_determinant: [f64; 6],
    pub(super) gram: Vec<Mat<f64>>,
}

impl Part {
    /// Columns of the unknowns.
    pub(crate) fn columns(&self) -> usize {
        self.gram.first().map_or(0, |gram| gram.ncols().saturating_sub(1))
    }

    /// Rows of white noise alone: how many, `log|V1|` and `C' V1^-1 C`.
    pub(crate) fn white(rows: f64, log_determinant: f64, gram: Mat<f64>) -> Self {
        Part { rows, log_determinant: [log_determinant, 0.0, 0.0, 0.0, 0.0, 0.0], gram: vec![gram] }
    }
}

/// A part on its way: rows in the order of time.
#[derive(Debug, Clone)]
pub struct Chain {
    part: Part,
    filter: Filter,
}

#[derive(Debug, Clone)]
enum Filter {
    /// Values alone.
    Plain { filter: Sequential, noise: TimeNoise, columns: usize },
    /// With derivatives.
    Jets { ratio: f64, tau: f64, spread: Jet, mean: Vec<Jet>, last: Option<f64>, block: Vec<Mat<f64>> },
}

impl Chain {
    /// For so many columns, the observations included.
    pub fn new(columns: usize, noise: TimeNoise, derivatives: bool) -> Self {
        let ratio = noise.deviation / noise.white;
        let jets = derivatives && ratio > 0.0;
        let grams = if jets { 6 } else { 1 };
        let filter = if jets {
            let block = vec![Mat::zeros(BLOCK, columns); 6];
            let spread = Jet([ratio, ratio, 0.0, ratio, 0.0, 0.0]);
            Filter::Jets { ratio, tau: noise.tau, spread, mean: vec![Jet::of(0.0); columns], last: None, block }
        } else {
            Filter::Plain { filter: Sequential::new(columns, ratio, noise.tau), noise, columns }
        };
        let gram = vec![Mat::zeros(columns, columns); grams];
        Chain { part: Part { rows: 0.0, log_determinant: [0.0; 6], gram }, filter }
    }

    /// The rows that follow are independent of those before.
    pub fn begin(&mut self) {
        match &mut self.filter {
            Filter::Plain { filter, noise, columns } => {
                self.part.log_determinant[0] += filter.log_determinant();
                *filter = Sequential::new(*columns, noise.deviation / noise.white, noise.tau);
            }
            Filter::Jets { mean, last, .. } => {
                *last = None;
                mean.fill(Jet::of(0.0));
            }
        }
    }

    /// Takes rows in the order of time; `sd` are the relative standard deviations of their white noise.
    ///
    /// Errors: times that do not rise; a row without any noise.
    pub fn push(&mut self, rows: MatRef<'_, f64>, time: &[f64], sd: &[f64]) -> Result<()> {
        let mut start = 0;
        while start < rows.nrows() {
            let count = BLOCK.min(rows.nrows() - start);
            let among = start..start + count;
            let (time, sd) = (time.get(among.clone()).unwrap_or_default(), sd.get(among).unwrap_or_default());
            self.block(rows.subrows(start, count), time, sd)?;
            start += count;
        }
        self.part.rows += rows.nrows() as f64;
        Ok(())
    }

    fn block(&mut self, rows: MatRef<'_, f64>, time: &[f64], sd: &[f64]) -> Result<()> {
        let gram = &mut self.part.gram;
        let (ratio, tau, spread, mean, last, block) = match &mut self.filter {
            Filter::Plain { filter, .. } => {
                let mut white = rows.to_owned();
                filter.whiten(&mut white, time, sd)?;
                matmul(&mut gram[0], Accum::Add, white.transpose(), white.as_ref(), 1.0, Par::Seq);
                return Ok(());
            }
            Filter::Jets { ratio, tau, spread, mean, last, block } => (*ratio, *tau, spread, mean, last, block),
        };
        let whole = Jet([ratio, ratio, 0.0, ratio, 0.0, 0.0]);
        let count = rows.nrows();
        let mut steps: Vec<[Jet; 3]> = Vec::with_capacity(count);
        let (mut known, mut keeps) = (f64::NAN, Jet::of(0.0));
        for (t, sd) in time.iter().zip(sd) {
            // before the first row nothing is known of the deviation
            let passed = last.map_or(f64::INFINITY, |last| (t - last) / tau);
            if !(passed >= 0.0) {
                return Err(backwards(*t, last.unwrap_or(f64::NAN)));
            }
            if passed != known {
                let k = (-passed).exp();
                let slope = if k > 0.0 { k * passed } else { 0.0 };
                let bend = if k > 0.0 { slope * (passed - 1.0) } else { 0.0 };
                (known, keeps) = (passed, Jet([k, 0.0, slope, 0.0, 0.0, bend]));
            }
            *last = Some(*t);
            let own = sd * sd;
            let before = whole.plus(keeps.times(keeps).times(spread.minus(whole)));
            let f = before.plus(Jet::of(own));
            let over = 1.0 / f.0[0];
            let gain = before.times(f.through([over, -over * over, 2.0 * over * over * over]));
            *spread = gain.scaled(own);
            let root = over.sqrt();
            let root = f.through([root, -0.5 * root * over, 0.75 * root * over * over]);
            let logarithm = f.through([-over.ln(), over, -over * over]);
            self.part.log_determinant.iter_mut().zip(logarithm.0).for_each(|(sum, l)| *sum += l);
            steps.push([keeps, gain, root]);
        }
        for (j, mean) in mean.iter_mut().enumerate() {
            let mut own = *mean;
            for (i, ([keeps, gain, root], y)) in steps.iter().zip(rows.col(j).iter()).enumerate() {
                own = keeps.times(own);
                let e = Jet::of(*y).minus(own);
                own = own.plus(gain.times(e));
                let white = root.times(e);
                block.iter_mut().zip(white.0).for_each(|(to, w)| to.col_as_slice_mut(j)[i] = w);
            }
            *mean = own;
        }
        let of = |k: usize| block[k].subrows(0, count);
        let mut add = |to: usize, a: usize, b: usize| {
            matmul(&mut gram[to], Accum::Add, of(a).transpose(), of(b), 1.0, Par::Seq);
        };
        add(0, 0, 0);
        // the other half of each is its transpose
        for (to, product) in [(1, None), (2, None), (3, Some([1, 1])), (4, Some([1, 2])), (5, Some([2, 2]))] {
            add(to, 0, to);
            if let Some([a, b]) = product {
                add(to, a, b);
            }
        }
        Ok(())
    }

    /// What the rows said.
    pub fn part(self) -> Part {
        let mut part = self.part;
        if let Filter::Plain { filter, .. } = &self.filter {
            part.log_determinant[0] += filter.log_determinant();
        }
        for gram in part.gram.iter_mut().skip(1) {
            let half = gram.clone();
            *gram += half.transpose();
        }
        part
    }
}
