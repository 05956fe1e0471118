//! What is tried at a state: all causes with their columns.

use super::cause::Cause;
use super::products::{Products, Solved};

/// The linear model of all causes at a state.
pub(super) struct Linear {
    pub causes: Vec<Cause>,
    pub products: Products,
    pub norms: Vec<f64>,
}

impl Linear {
    /// The values, SI, of a set that was solved in columns of unit norm.
    pub fn values(&self, set: &[usize], solved: &Solved) -> Vec<f64> {
        let sized = |(j, x): (&usize, &f64)| self.norms.get(*j).map_or(0.0, |norm| x / norm);
        set.iter().zip(&solved.values).map(sized).collect()
    }

    pub fn places(&self, set: &[Cause]) -> Vec<usize> {
        set.iter().filter_map(|cause| self.causes.iter().position(|other| other == cause)).collect()
    }
}
