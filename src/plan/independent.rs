//! Rows of a schedule made independent of each other, as they are judged.
#![allow(
    clippy::indexing_slicing,
    reason = "a design has one row of its derivatives for each of its readings, and priors follow"
)]

use super::effort::Noise;
use super::whitened::lines;
use super::whitened::{own_noise, priors};
use crate::campaign::Campaign;
use crate::design::DesignMatrix;
use crate::error::Result;
use crate::estimate::{Estimate, Group, Pattern, System, Whitening, product_by_rows};
use crate::fit;
use faer::Mat;

/// Rows of readings and priors with what scatters taken out: no column for any deviation, whatever their number.
pub(crate) struct Independent {
    /// The rows; of unit variance where anything scatters.
    pub system: System,
    /// Standard deviation of each row's own noise.
    pub u: Vec<f64>,
    whitening: Option<Whitening>,
}

impl Independent {
    /// The rows of a design.
    pub fn new(campaign: &Campaign, design: &DesignMatrix, noise: &Noise) -> Self {
        let n = campaign.unknowns();
        let (m, priors) = (design.rows.len(), priors(campaign));
        let (stated, mut u) = own_noise(campaign, design, noise);
        let (lines, variance) = lines(campaign, design, noise, &stated);
        u.extend(priors.iter().map(|(_, u)| *u));
        let total = m + priors.len();
        let mut rows = Mat::zeros(total, n);
        for j in 0..n {
            rows.col_as_slice_mut(j)[..m].copy_from_slice(&design.jacobian.col_as_slice(j)[..m]);
        }
        for (p, (k, _)) in priors.iter().enumerate() {
            rows[(m + p, *k)] = 1.0;
        }
        let felt = lines.iter().any(|line| !line.felt.is_empty());
        let whitening = felt.then(|| Whitening::new(&Pattern::new(total, &lines), &u, &lines, &variance));
        let (rows, weights) = match &whitening {
            Some(whitening) => (whitening.whiten_columns(&rows), vec![1.0; total]),
            None => (rows, u.clone()),
        };
        let system = System { rows, observed: vec![0.0; total], u: weights, group: vec![Group::Known; total] };
        Independent { system, u, whitening }
    }

    /// The adjustment, meeting the campaign's equations.
    pub fn adjust(&self, campaign: &Campaign, design: &DesignMatrix) -> Result<Estimate> {
        fit::adjust_with_equations(campaign, design, &self.system)
    }

    /// A column of the readings (as long as all rows) as the adjusted rows have it.
    pub fn column(&self, column: Vec<f64>) -> Vec<f64> {
        match &self.whitening {
            Some(whitening) => whitening.whiten(&column),
            None => column,
        }
    }

    /// A column of the readings (a shorter one: zero beyond) as independent values of unit variance.
    pub fn white(&self, column: &[f64]) -> Vec<f64> {
        let mut column = column.to_vec();
        column.resize(self.u.len(), 0.0);
        let column = self.column(column);
        column.iter().zip(&self.system.u).map(|(v, u)| v / u).collect()
    }

    /// `d x / d y` by the rows as they are read.
    pub fn sensitivities(&self, estimate: &Estimate) -> Mat<f64> {
        let Some(whitening) = &self.whitening else { return estimate.factor.sensitivities() };
        let (q, directions) = (estimate.factor.thin_q(), estimate.factor.whitened_directions());
        let mut back = Mat::zeros(q.nrows(), q.ncols());
        for k in 0..q.ncols() {
            let column: Vec<f64> = q.col(k).iter().copied().collect();
            back.col_as_slice_mut(k).copy_from_slice(&whitening.carry_back(&column));
        }
        product_by_rows(directions.as_ref(), back.as_ref())
    }

    /// Redundancy number of each row, deviations being unknowns with a row of their own.
    pub fn redundancies(&self, estimate: &Estimate) -> Vec<f64> {
        match &self.whitening {
            Some(whitening) => whitening.redundancies(estimate.factor.thin_q()),
            None => estimate.redundancy.clone(),
        }
    }
}
