//! One effect that might be missing: a column, its coefficient, and what is said of it.

use crate::simulate::Regressor;

/// One effect that might be missing.
#[derive(Debug, Clone)]
pub struct Candidate {
    /// The appended term without its coefficient, as reports write it.
    pub regressor: String,
    /// Name in the field's words.
    pub name: String,
    /// Name of the coefficient in the repaired model line; for a tilt or a known parameter its own.
    pub coefficient: String,
    /// What the column is made from.
    pub kind: Regressor,
    /// The sensor that has it; `None` for what is common to all.
    pub sensor: Option<usize>,
    /// The catalogue's term with its placeholders.
    pub family: String,
    /// Order of a harmonic; 0 for what is none.
    pub harmonic: usize,
    /// Order among what cannot be told apart, 0 first.
    pub rank: u8,
    /// Do all members of its family together have the odds of one effect?
    pub one_of_many: bool,
    /// Why it happens.
    pub why: String,
    /// How to confirm it.
    pub confirm: String,
    /// A coefficient that the model line has already, assumed zero.
    pub existing: Option<usize>,
    /// Is it small at every reading against what its inputs could make of it, so that only small tilts leave anything of it?
    pub vanishing: bool,
    /// Share of its column's weighted norm that the model leaves; 1 until an evidence has looked.
    pub visible: f64,
    /// Its largest value here over what its inputs could make of it; 1 for what is no term.
    pub size: f64,
    /// Its value at each row, `m`, zero at the rows of priors.
    pub column: Vec<f64>,
}
