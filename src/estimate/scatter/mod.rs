//! What scatters beyond the rows' own noise, and one way through all of it.
//!
//! ```text
//! y = A x + e + sum_k Z_k d_k,    V = R + sum_k Z_k D_k Z_k',    R = diag((s_g u)^2)
//! ```
//!
//! A [`ScatterLine`] says which rows feel which deviation, and how strongly. Each deviation is an unknown with a row of its own, "0 with this
//! standard deviation"; orthogonal transformations take these unknowns out again, front by front, and leave `m` independent rows of unit
//! variance (`elimination.rs`). No covariance is ever formed, a standard deviation may be as large or as small as it likes, and time and
//! memory are linear in the rows. Deviations with a memory, `exp(-|dt|/tau)`, are chains of such rows (a Markov process).
//!
//! **To whiten rows and columns with everything known:** `Whitening::new(&Pattern::new(m, &lines), &sd, &lines, &variance)`, then
//! `whitening.whiten(column)` for each column of the design, of candidates, and for the readings; their inner products are those with
//! `V^-1`. From a campaign, `fit::scatter_lines` makes the lines at a design's point and `fit::whitening` does all of it in one call.
//!
//! **To estimate:** [`adjust_scattered`]; it estimates by REML what is not stated, with what that costs the unknowns (`problem.rs`, `inference.rs`).
//!
//! | file | subject |
//! |---|---|
//! | `pattern.rs` | which rows share deviations, and the order in which fronts take them out |
//! | `elimination.rs` | the orthogonal transformations, forwards and backwards |
//! | `floor.rs` | rows made independent for others: a diagnosis, a plan |
//! | `inference.rs` | what whitened rows say of each component: the sums of the likelihood |
//! | `problem.rs` | components, the adjustment at given variances, and the way to the variances |
//! | `condense.rs` | the readings of a position as a few rows that say the same |
//! | `chain.rs` | a filter along time, with derivatives by the noise |
//! | `restricted.rs` | the likelihood and what it costs to estimate variances, from sums of either kind; the way to its top |
//! | `time.rs` | noise that is correlated in time |
//! | `mixture.rs` | the unknowns over the whole likelihood, where its top says nothing of some |
//! | `conclude.rs` | the adjustment with what was found; variances that no residual shows, though unknowns follow them |

pub(super) mod chain;
mod conclude;
mod condense;
mod elimination;
mod floor;
mod inference;
mod mixture;
mod pattern;
mod problem;
pub(super) mod restricted;
mod time;

pub(crate) use chain::{Chain, Part as NoisePart, TimeNoise};
pub use conclude::adjust_scattered;
pub(crate) use conclude::{Absorbed, satterthwaite, scattered, scattered_with, step_scattered};
pub use elimination::Whitening;
pub(crate) use floor::{Floor, Variances};
pub(crate) use mixture::{Mixture, Node};
pub use pattern::Pattern;
pub(crate) use restricted::{Likelihood, NEWTON_STEPS, NoiseModel, PartNoise, Slot};
pub(crate) use time::{deviation_range, white_range};

use crate::elements::Elements;
use crate::estimate::Estimate;
use faer::Mat;

/// A row that feels a deviation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Felt {
    /// The row.
    pub row: usize,
    /// Which of the line's deviations, counted from 0.
    pub level: usize,
    /// Derivative of the row by the deviation.
    pub by: f64,
}

/// One line of what scatters: independent deviations of one variance, or deviations with a memory.
#[derive(Debug, Clone, PartialEq)]
pub struct ScatterLine {
    /// Which rows feel which deviation.
    pub felt: Vec<Felt>,
    /// Variance of a deviation; `None` where it is to be estimated.
    pub variance: Option<f64>,
    /// How deviations are correlated in time, if they are.
    pub memory: Option<Memory>,
}

/// Deviations correlated as `exp(-|dt|/tau)`.
#[derive(Debug, Clone, PartialEq)]
pub struct Memory {
    /// Time of each level.
    pub time: Vec<f64>,
    /// Levels of different runs are independent.
    pub run: Vec<usize>,
    /// Correlation time; `None` where it is to be estimated.
    pub tau: Option<f64>,
}

impl ScatterLine {
    /// Number of levels.
    pub(crate) fn levels(&self) -> usize {
        self.felt.iter().map(|felt| felt.level.saturating_add(1)).max().unwrap_or(0)
    }

    /// `Z' y`: what the rows make of each deviation.
    fn gathered(&self, values: &[f64]) -> Vec<f64> {
        let mut felt = vec![0.0; self.levels()];
        for (own, value) in self.felt.iter().filter_map(|own| Some((own, values.get(own.row)?))) {
            felt.get_mut(own.level).into_iter().for_each(|slot| *slot += own.by * value);
        }
        felt
    }

    /// Logarithms of the shortest and longest correlation time that its times could show.
    fn tau_range(&self) -> (f64, f64) {
        let mut times = self.memory.as_ref().map_or(Vec::new(), |memory| memory.time.clone());
        times.sort_by(f64::total_cmp);
        let whole = times.last().zip(times.first()).map_or(1.0, |(b, a)| b - a);
        let mut gaps: Vec<f64> = times.windows(2).map(|p| p.at(1) - p.at(0)).filter(|g| *g > 0.0).collect();
        // all at one time: any correlation time will do
        time_range(crate::number::median(&mut gaps).unwrap_or(1.0), whole)
    }

    /// What deviations of unit variance, correlated over `tau` where they are in time, make of `along . y`: `sum f_a f_b exp(-|t_a - t_b|/tau)`.
    pub(crate) fn variance_of(&self, along: &[f64], tau: Option<f64>) -> f64 {
        let felt = self.gathered(along);
        let own: f64 = felt.iter().map(|own| own * own).sum();
        let Some((memory, tau)) = self.memory.as_ref().zip(tau) else { return own };
        let before = memory.carried(&felt, tau, memory.order(felt.len()).iter());
        own + 2.0 * before.iter().zip(&felt).map(|((sum, _), own)| sum * own).sum::<f64>()
    }
}

/// Logarithms of the shortest and longest correlation time that shows, from the middling step between times and their whole length.
pub(crate) fn time_range(step: f64, whole: f64) -> (f64, f64) {
    ((step / 5.0).ln(), (whole.max(step) * 2.0).ln())
}

/// A line has this correlation time.
fn remember(lines: &mut [ScatterLine], line: usize, tau: f64) {
    if let Some(memory) = lines.get_mut(line).and_then(|line| line.memory.as_mut()) {
        memory.tau = Some(tau);
    }
}

impl Memory {
    /// The run of a level: one where none are told apart.
    fn run_of(&self, level: usize) -> usize {
        self.run.get(level).copied().unwrap_or(0)
    }

    /// Levels run by run, in the order of time.
    fn order(&self, levels: usize) -> Vec<usize> {
        let mut order: Vec<usize> = (0..levels).collect();
        let at = |level: &usize| (self.run_of(*level), self.time.at(*level));
        order.sort_by(|a, b| at(a).0.cmp(&at(b).0).then(at(a).1.total_cmp(&at(b).1)));
        order
    }

    /// At each level `S = sum f_a exp(-dt/tau)` over those before it in an order, and `tau dS/dtau`: from one level to the next `S = k (S + f)`,
    /// `S' = k (S' + dt/tau (S + f))`, `k = exp(-dt/tau)`.
    fn carried<'a>(&self, felt: &[f64], tau: f64, order: impl Iterator<Item = &'a usize>) -> Vec<(f64, f64)> {
        let mut all = vec![(0.0, 0.0); felt.len()];
        let (mut sums, mut last) = ((0.0, 0.0), None);
        for level in order {
            let near = last.filter(|last| self.run_of(*last) == self.run_of(*level));
            sums = near.map_or((0.0, 0.0), |last| {
                let passed = (self.time.at(*level) - self.time.at(last)).abs() / tau;
                let (keeps, whole) = ((-passed).exp(), sums.0 + felt.at(last));
                (keeps * whole, keeps * (sums.1 + passed * whole))
            });
            all.get_mut(*level).into_iter().for_each(|slot| *slot = sums);
            last = Some(*level);
        }
        all
    }
}

/// What became of a line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LineState {
    /// Its variance is stated.
    Stated,
    /// Estimated, and above zero.
    Estimated,
    /// Estimated: zero.
    AtZero,
    /// No row feels it.
    NotFelt,
    /// The rows do not separate it from the rows' own noise or from lines before it, which hold the sum.
    Inseparable,
    /// The unknowns take up its deviations: the rows do not tell its variance, and some unknowns follow it.
    Absorbed,
}

/// A system adjusted with what scatters.
///
/// Where a variance is estimated as zero, the weights, `u` and dof are those of the estimate without that bound (`problem.rs`): the line's share is
/// then negative, and the groups' factors in it are `weighed_with`, while `group_variance` and `variance` are the restricted estimates.
#[derive(Debug, Clone)]
pub struct Scattered {
    /// The adjustment of the whitened rows: residuals are those of whitened rows.
    pub estimate: Estimate,
    /// The whitening, for other columns.
    pub whitening: Whitening,
    /// Variance factor of each estimated group of rows; `None` without redundancy of its own.
    pub group_variance: Vec<Option<f64>>,
    /// For each group at zero, beside lines that scatter in time: the factor of the standard deviation that it could have, one standard uncertainty above zero.
    pub group_could_be: Vec<Option<f64>>,
    /// Variance factor of each estimated group with which the rows were weighed.
    pub weighed_with: Vec<f64>,
    /// Variance of each line.
    pub variance: Vec<f64>,
    /// Variance of each line with which the rows were weighed.
    pub weighed_lines: Vec<f64>,
    /// For each line at zero, the standard deviation that its variance could have, one standard uncertainty above zero.
    pub could_be: Vec<Option<f64>>,
    /// Correlation time of each line that has one, and where estimated its standard uncertainty.
    pub tau: Vec<Option<(f64, Option<f64>)>>,
    /// What became of each line.
    pub state: Vec<LineState>,
    /// Covariance of the estimated variances relative to them: groups first, then lines (see `component`), then correlation times (`leans`).
    pub spread: Mat<f64>,
    /// Where each line stands in `spread`; `None` where its variance is stated, is held at zero or nothing feels it.
    pub component: Vec<Option<usize>>,
    /// For each line whose correlation time was estimated, where that stands in `spread`, and the derivative of the covariance of the unknowns
    /// by its logarithm.
    pub leans: Vec<Option<(usize, Mat<f64>)>>,
    /// For each line, what is not known of the covariance of the unknowns for want of its variance.
    pub absorbed: Vec<Option<Absorbed>>,
    /// What the small-sample correction adds to the covariance of the unknowns, `n x n`.
    pub correction: Mat<f64>,
    /// The unknowns over the whole likelihood of the variances, where its top leaves one of them less than one degree of freedom.
    pub mixture: Option<Mixture>,
    /// Each line's part of the covariance of the unknowns, `n x n`.
    pub shares: Vec<Mat<f64>>,
    /// `d x / d y`, `n x m`.
    pub sensitivities: Mat<f64>,
    /// Residual of each row over the standard deviation of its own noise, deviations taken out; then each deviation over its own.
    pub standardized: Vec<f64>,
    /// Redundancy number of each row; then of each deviation.
    pub redundancy: Vec<f64>,
    /// For each row, where the larger of its own noise and of the deviations that no other row feels stands in these two lists, and its standard deviation in the
    /// row, negative where an error there has the other sign: a fault of the row alone is a fault of that.
    pub alone: Vec<(usize, f64)>,
    /// `-2` times the logarithm of the restricted likelihood, without constants.
    pub deviance: f64,
    /// Steps that the variances took.
    pub iterations: usize,
    /// Did they settle?
    pub converged: bool,
}

/// A step with what scatters, as an iteration needs it on its way.
#[derive(Debug, Clone)]
pub(crate) struct Stepped {
    /// Estimate of the unknowns, `n`; those outside the basis are zero.
    pub solution: Vec<f64>,
    /// Number of independent columns.
    pub rank: usize,
    /// The whitening.
    pub whitening: Whitening,
    theta: Vec<f64>,
    times: Vec<f64>,
}
