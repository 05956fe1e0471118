//! What is tried at a state: all causes with their columns.

use super::cause::Cause;
use super::products::Products;

/// The linear model of all causes at a state.
pub(super) struct Linear {
    pub causes: Vec<Cause>,
    pub products: Products,
    pub norms: Vec<f64>,
}

impl Linear {
    pub fn places(&self, set: &[Cause]) -> Vec<usize> {
        set.iter().filter_map(|cause| self.causes.iter().position(|own| own == cause)).collect()
    }
}
