//! What scatters beyond the rows' own noise, and one way through all of it.
//!
//! ```text
//! y = A x + e + sum_k Z_k d_k,    V = R + sum_k Z_k D_k Z_k',    R = diag((s_g u)^2)
//! ```
//!
//! A [`Line`] says which rows feel which deviation, and how strongly. Each deviation is an unknown with a row of its own, "0 with this
//! standard deviation"; orthogonal transformations take these unknowns out again, front by front, and leave `m` independent rows of unit
//! variance (`elimination.rs`). No covariance is ever formed, a standard deviation may be as large or as small as it likes, and time and
//! memory are linear in the rows. Deviations with a memory, `exp(-|dt|/tau)`, are chains of such rows (a Markov process).
//!
//! **To whiten rows and columns with everything known:** `Whitening::new(&Pattern::new(m, &lines), &sd, &lines, &variance)`, then
//! `whitening.whiten(column)` for each column of the design, of candidates, and for the readings; their inner products are those with
//! `V^-1`. From a campaign, `fit::scatter_lines` makes the lines at a design's point and `fit::whitening` does all of it in one call.
//!
//! **To estimate:** [`adjust_scattered`]; it estimates by REML what is not stated, with what that costs the unknowns (`reml.rs`, `cost.rs`).
//!
//! | file | subject |
//! |---|---|
//! | `pattern.rs` | which rows share deviations, and the order in which fronts take them out |
//! | `elimination.rs` | the orthogonal transformations, forwards and backwards |
//! | `inference.rs` | what each component contributes: squares, redundancy, information |
//! | `reml.rs` | the steps to the variances |
//! | `cost.rs` | spread of the variances, Kenward and Roger's correction |

mod cost;
mod elimination;
mod inference;
mod pattern;
mod reml;

pub(super) use cost::{correction, spread};
pub use elimination::Whitening;
pub use pattern::Pattern;
pub use reml::{LineState, Scattered, adjust_scattered};

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
pub struct Line {
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

impl Line {
    /// Number of levels.
    pub fn levels(&self) -> usize {
        self.felt.iter().map(|felt| felt.level + 1).max().unwrap_or(0)
    }
}
