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

    /// The share of the residual sum of squares of a set that more causes would remove; columns that depend on those of the set remove nothing.
    pub fn share_of(&self, set: &[usize], more: &[usize]) -> f64 {
        let with: Vec<usize> = set.iter().chain(more).copied().collect();
        let rss = |set: &[usize]| self.products.solve(set).map(|solved| solved.rss);
        rss(&with).zip(rss(set)).map_or(0.0, |(with, set)| 1.0 - with / set.max(f64::MIN_POSITIVE))
    }

    pub fn places(&self, set: &[Cause]) -> Vec<usize> {
        set.iter().filter_map(|cause| self.causes.iter().position(|other| other == cause)).collect()
    }
}
