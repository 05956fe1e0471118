//! Rows made independent, and what estimated variances make of evidence against them.
//!
//! ```text
//! l = a unit direction of whitened rows,   l'l = sum_k g_k(l),    g_k = the share of component k in the variance of l . y
//! dof of that variance = 2 / (g' S g),     S = relative covariance of the estimated variances      F. E. Satterthwaite, Biometrics Bulletin 2 (1946), 110
//! ```
#![allow(
    clippy::indexing_slicing,
    reason = "`Pattern::new` gives each line a start, and as many deviations after it as the line has levels"
)]

use super::elimination::Whitening;
use super::{Pattern, ScatterLine, Scattered};
use crate::elements::Elements;
use crate::estimate::System;
use faer::Mat;

/// Variances of all that scatters, stated and estimated, and what the estimates are worth.
#[derive(Debug, Clone)]
pub struct Variances {
    /// Variance factor of each estimated group of rows.
    pub groups: Vec<f64>,
    /// Variance of each line, as rows are weighed with it: below zero where an estimate without bound is.
    pub lines: Vec<f64>,
    /// Correlation time of each line that has one.
    pub tau: Vec<Option<f64>>,
    /// Covariance of the estimated variances relative to them: groups first, then lines.
    pub spread: Mat<f64>,
    /// Where each line stands in `spread`.
    pub component: Vec<Option<usize>>,
}

impl Variances {
    /// Nothing estimated: a factor for each group of rows (none where all are known) and the variance of each line.
    pub(crate) fn known(groups: Vec<f64>, lines: Vec<f64>) -> Self {
        let count = lines.len();
        Variances { groups, lines, tau: vec![None; count], spread: Mat::new(), component: vec![None; count] }
    }
}

impl From<&Scattered> for Variances {
    fn from(found: &Scattered) -> Self {
        Variances {
            groups: found.weighed_with.clone(),
            lines: found.weighed_lines.clone(),
            tau: found.tau.iter().map(|tau| tau.map(|(tau, _)| tau)).collect(),
            spread: found.spread.clone(),
            component: found.component.clone(),
        }
    }
}

/// The noise floor of a system: its rows made independent, and how well that is known.
#[derive(Debug, Clone)]
pub struct Floor {
    whitening: Whitening,
    rows: Vec<Option<usize>>,
    deviations: Vec<Option<usize>>,
    spread: Mat<f64>,
    total: Vec<f64>,
    groups: usize,
}

impl Floor {
    /// Of a system whose `u` are those of the rows' own noise.
    pub(crate) fn new(system: &System, lines: &[ScatterLine], variances: &Variances) -> Self {
        let mut lines = lines.to_vec();
        for (line, tau) in lines.iter_mut().zip(&variances.tau) {
            if let (Some(memory), Some(tau)) = (&mut line.memory, tau) {
                memory.tau = Some(*tau);
            }
        }
        let sd = system.scaled_u(|g| variances.groups.at(g).sqrt());
        let pattern = Pattern::new(sd.len(), &lines);
        let mut total: Vec<f64> = sd.iter().map(|sd| sd * sd).collect();
        let mut deviations = vec![None; pattern.deviations];
        for (k, (line, start)) in lines.iter().zip(&pattern.first).enumerate() {
            let own = variances.component.get(k).copied().flatten();
            deviations[*start..start + line.levels()].fill(own);
            let variance = variances.lines.at(k);
            for felt in &line.felt {
                if let Some(slot) = total.get_mut(felt.row) {
                    *slot += felt.by * felt.by * variance;
                }
            }
        }
        // a variance below zero may leave a single row nothing
        let total = total.iter().zip(&sd).map(|(v, sd)| if *v > 0.0 { v.sqrt() } else { *sd }).collect();
        let counted = variances.spread.nrows();
        let rows = system.group.iter().map(|group| group.estimated().filter(|g| *g < counted)).collect();
        let whitening = Whitening::new(&pattern, &sd, &lines, &variances.lines);
        Floor { whitening, rows, deviations, spread: variances.spread.clone(), total, groups: variances.groups.len() }
    }

    /// The whitening.
    pub(crate) fn whitening(&self) -> &Whitening {
        &self.whitening
    }

    /// Standard deviation of each row by itself, all that scatters together.
    pub(crate) fn total_sd(&self) -> &[f64] {
        &self.total
    }

    /// Relative covariance of the estimated variances; empty where all are stated.
    pub(crate) fn spread(&self) -> &Mat<f64> {
        &self.spread
    }

    /// How many of the estimated variances are factors of groups of rows; they come first.
    pub fn groups(&self) -> usize {
        self.groups
    }

    /// `g_k`: the share of each estimated variance in that of a direction of whitened rows; what is left of 1 is stated.
    pub(crate) fn shares(&self, white: &[f64]) -> Vec<f64> {
        let mut shares = vec![0.0; self.spread.nrows()];
        let back = self.whitening.backward(self.whitening.of_rows(white.to_vec()));
        for (own, v) in self.rows.iter().zip(&back.rows) {
            if let Some(slot) = own.and_then(|g| shares.get_mut(g)) {
                *slot += v * v;
            }
        }
        for (d, (own, v)) in self.deviations.iter().zip(&back.deviations).enumerate() {
            if let Some(slot) = own.and_then(|g| shares.get_mut(g)) {
                *slot += self.whitening.sign(d) * v * v;
            }
        }
        shares
    }
}
