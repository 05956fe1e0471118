//! Least-squares adjustment of plain matrices; this module knows nothing of benches.
//!
//! ```text
//! y = A x + e,   E(e) = 0,   V(e) = diag((s_g u)^2)
//! ```
//!
//! `A` are the rows, `y` the observed minus predicted readings, `u` their standard uncertainties, and `s_g` the scale of
//! the group that a row belongs to: 1 where `u` is known, estimated from the residuals where it is not.
//!
//! | file | subject |
//! |---|---|
//! | `adjust.rs` | one call from a [`System`] to an [`Estimate`] |
//! | `factor.rs` | weights, column scales, pivoted QR, rank; solutions refined with residuals in twice the working precision; what it says of the unknowns |
//! | `pivoted.rs` | the pivoted QR; back substitution |
//! | `compensated.rs` | sums of products in twice the working precision |
//! | `eight.rs` | eight small systems side by side |
//! | `basis.rs` | which columns depend on which, and the parameters' combinations that follow |
//! | `groups.rs` | each group's rows as a triangle that says the same; the scales `s_g` of several groups |
//! | `equalities.rs` | linear equations between unknowns, by elimination |
//! | `inequalities.rs` | bounds, ranges and norm cones: what is active, what it costs |
//! | `cone_program.rs` | the same question as clarabel takes it, and its answer to the last digit |
//! | `scatter/` | what scatters beyond the rows' own noise: whitening, REML, Kenward and Roger |
//! | `fold.rs` | the same estimate from rows that come in blocks; folds of parts of the rows, joined |
//! | `panel.rs` | blocks of rows folded into a triangle in the registers of the machine |
//! | `sequential.rs` | rows whose noise is correlated in time, made independent as they come |
//!
//! Deliberately absent: normal equations, priors that are not rows, damping, a pseudo-inverse that would choose
//! among solutions silently.

mod adjust;
mod basis;
mod compensated;
mod cone_program;
pub(crate) mod eight;
mod equalities;
mod factor;
mod fold;
mod groups;
mod inequalities;
mod panel;
mod pivoted;
pub mod scatter;
mod sequential;

pub(crate) use adjust::ScaleUncertainty;
pub use adjust::{Estimate, adjust, solve};
pub(crate) use basis::{Combination, Coupling};
pub(crate) use compensated::Sum;
pub(crate) use cone_program::{csc, solver_settings};
pub(crate) use equalities::{Elimination, adjust_on};
pub use equalities::{Equation, Equations};
pub(crate) use factor::{Factor, Unknowns, product_by_rows};
pub use fold::Fold;
pub(crate) use groups::{Block, Compressed, NO_REDUNDANCY, ScaleHints, Scaled};
pub(crate) use inequalities::Side;
pub use inequalities::{Bounds, Inequality, Restricted, restrict};
pub(crate) use scatter::{
    Absorbed, Chain, Floor, Likelihood, Mixture, NEWTON_STEPS, Node, NoiseModel, NoisePart, PartNoise, Slot, Stepped,
    TimeNoise, Variances, deviation_range, satterthwaite, scattered, scattered_with, step_scattered, time_range,
    white_range,
};
pub use scatter::{Felt, LineState, Memory, Pattern, ScatterLine, Scattered, Whitening, adjust_scattered};
pub use sequential::Sequential;
pub(crate) use sequential::backwards;

use crate::error::{Fault, Malformed, Result};
use faer::Mat;

/// Whether the standard uncertainty of a row is known, or only relative to its group.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Group {
    /// `u` is the standard uncertainty itself: a reading with a stated one, or a prior.
    #[default]
    Known,
    /// `u` is relative; the common scale of this group is estimated from its residuals. Groups count from 0.
    Estimated(usize),
}

impl Group {
    /// Its number, where its scale is estimated.
    pub(crate) fn estimated(self) -> Option<usize> {
        if let Group::Estimated(g) = self { Some(g) } else { None }
    }
}

/// The linear system to adjust: `m` rows in `n` unknowns, not yet weighted.
#[derive(Debug, Clone)]
pub struct System {
    /// Derivatives of the readings by the unknowns, `m x n`.
    pub rows: Mat<f64>,
    /// Readings minus predictions at the reference point, `m`.
    pub observed: Vec<f64>,
    /// Standard uncertainty of each row, absolute or relative according to its group, `m`; positive.
    pub u: Vec<f64>,
    /// The group of each row, `m`.
    pub group: Vec<Group>,
}

/// How [`adjust`] works; the default is right unless there is a reason.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// A column counts as dependent where `|R_kk| <= rank_tolerance * |R_11|` (columns scaled to unit norm);
    /// `None` is `32 eps sqrt(max(m, n))`.
    pub rank_tolerance: Option<f64>,
    /// Most steps of iterative refinement; it stops as soon as a step no longer matters, usually after one.
    pub refinements: usize,
    /// Most steps to the scales of several groups.
    pub group_iterations: usize,
}

impl Default for Settings {
    fn default() -> Self {
        Settings { rank_tolerance: None, refinements: 5, group_iterations: 100 }
    }
}

impl System {
    /// A system whose standard uncertainties are all known.
    pub(crate) fn known(rows: Mat<f64>, observed: Vec<f64>, u: Vec<f64>) -> Self {
        System { rows, observed, group: vec![Group::Known; u.len()], u }
    }

    /// The same rows with other standard uncertainties, all known.
    pub(crate) fn with_u(&self, u: Vec<f64>) -> Self {
        System { group: vec![Group::Known; u.len()], u, ..self.clone() }
    }

    /// Standard uncertainty of each row with the scale of its group; known ones as they are.
    pub(crate) fn scaled_u(&self, scale: impl Fn(usize) -> f64) -> Vec<f64> {
        self.u.iter().zip(&self.group).map(|(u, group)| u * group.estimated().map_or(1.0, &scale)).collect()
    }

    /// Are all rows of one group, whose common variance is estimated after the adjustment? Its scale changes no weight relative to another.
    pub(crate) fn is_of_one_scale(&self) -> bool {
        self.group.iter().all(|group| *group == Group::Estimated(0))
    }

    /// Rows and columns.
    pub(crate) fn shape(&self) -> (usize, usize) {
        (self.rows.nrows(), self.rows.ncols())
    }

    /// The system beside inputs that are known only to their uncertainty: each an unknown whose value is stated as a row, `p = 0` with unit variance.
    ///
    /// `columns` is how the first rows follow inputs of unit variance, `c`. Residuals of the system have the covariance of `V + c c'`, not of `V`
    /// alone, where the inputs were taken as known; what is left here has that of independent rows, and
    /// `r' (V + c c')^-1 r = min_p |V^-1/2 (r - c p)|^2 + p'p`: tests of the residuals are those of this system, with the same degrees of freedom.
    pub(crate) fn with_inputs(&self, columns: &Mat<f64>) -> System {
        let ((m, n), k) = (self.shape(), columns.ncols());
        let mut rows = Mat::zeros(m + k, n + k);
        for j in 0..n {
            rows.subcols_mut(j, 1).subrows_mut(0, m).copy_from(self.rows.subcols(j, 1));
        }
        for j in 0..k {
            rows.subcols_mut(n + j, 1).subrows_mut(0, columns.nrows()).copy_from(columns.subcols(j, 1));
            rows[(m + j, n + j)] = 1.0;
        }
        let longer = |list: &[f64], value: f64| [list, &vec![value; k]].concat();
        let group = [self.group.as_slice(), &vec![Group::Known; k]].concat();
        System { rows, observed: longer(&self.observed, 0.0), u: longer(&self.u, 1.0), group }
    }

    /// What a solution leaves of the observed values.
    pub(crate) fn residuals(&self, solution: &[f64]) -> Vec<f64> {
        let mut rest = self.observed.clone();
        crate::linear::subtract(&mut rest, &self.rows, solution);
        rest
    }

    /// The system as a question: sizes agree, everything is finite, uncertainties are positive, groups count from 0.
    pub(crate) fn check(&self) -> Result<()> {
        let (m, n) = self.shape();
        for (name, len) in [("observed", self.observed.len()), ("u", self.u.len()), ("group", self.group.len())] {
            if len != m {
                let what = format!("the system's '{name}' has the wrong length");
                return Err(refused(what, name.into(), format!("{m}, one per row"), len));
            }
        }
        for j in 0..n {
            if let Some(i) = self.rows.col_as_slice(j).iter().position(|a| !a.is_finite()) {
                return Err(not_finite("a row's derivative", format!("rows[{i}][{j}]"), self.rows[(i, j)]));
            }
        }
        if let Some((i, y)) = self.observed.iter().enumerate().find(|(_, y)| !y.is_finite()) {
            return Err(not_finite("an observed value", format!("observed[{i}]"), *y));
        }
        if let Some((i, u)) = self.u.iter().enumerate().find(|(_, u)| !(u.is_finite() && **u > 0.0)) {
            let what = "a standard uncertainty is not positive".into();
            return Err(refused(what, format!("u[{i}]"), "a positive, finite number".into(), u));
        }
        for (i, group) in self.group.iter().enumerate() {
            if let Some(g) = group.estimated().filter(|g| *g >= m) {
                let what = "a group's number is larger than the number of rows".into();
                return Err(refused(what, format!("group[{i}]"), format!("a number from 0 to {}", m - 1), g));
            }
        }
        Ok(())
    }
}

fn not_finite(what: &str, path: String, found: f64) -> Malformed {
    refused(format!("{what} is not finite"), path, "a finite number".into(), found)
}

fn refused(what: String, path: String, expected: String, found: impl ToString) -> Malformed {
    Malformed::new(Fault::Value, what).at_path(path).expected(expected).found(found.to_string())
}
