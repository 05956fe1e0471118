//! Rows made independent, where something scatters beyond the noise of each.

use super::elimination::Whitening;
use super::{Pattern, ScatterLine, Scattered};
use crate::elements::Elements;
use crate::estimate::System;

/// Variances of all that scatters, stated and estimated.
#[derive(Debug, Clone)]
pub struct Variances {
    /// Variance factor of each estimated group of rows.
    pub groups: Vec<f64>,
    /// Variance of each line, as rows are weighed with it: below zero where an estimate without bound is.
    pub lines: Vec<f64>,
    /// Correlation time of each line that has one.
    pub tau: Vec<Option<f64>>,
}

impl Variances {
    /// Nothing estimated: a factor for each group of rows (none where all are known) and the variance of each line.
    pub(crate) fn known(groups: Vec<f64>, lines: Vec<f64>) -> Self {
        let count = lines.len();
        Variances { groups, lines, tau: vec![None; count] }
    }
}

impl From<&Scattered> for Variances {
    fn from(found: &Scattered) -> Self {
        Variances {
            groups: found.weighed_with.clone(),
            lines: found.weighed_lines.clone(),
            tau: found.tau.iter().map(|tau| tau.map(|(tau, _)| tau)).collect(),
        }
    }
}

/// The noise floor of a system: its rows made independent.
#[derive(Debug, Clone)]
pub struct Floor {
    whitening: Whitening,
    total: Vec<f64>,
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
        for (k, line) in lines.iter().enumerate() {
            let variance = variances.lines.at(k);
            for felt in &line.felt {
                if let Some(slot) = total.get_mut(felt.row) {
                    *slot += felt.by * felt.by * variance;
                }
            }
        }
        // a variance below zero may leave a single row nothing
        let total = total.iter().zip(&sd).map(|(v, sd)| if *v > 0.0 { v.sqrt() } else { *sd }).collect();
        let whitening = Whitening::new(&pattern, &sd, &lines, &variances.lines);
        Floor { whitening, total }
    }

    /// The whitening.
    pub(crate) fn whitening(&self) -> &Whitening {
        &self.whitening
    }

    /// Standard deviation of each row by itself, all that scatters together.
    pub(crate) fn total_sd(&self) -> &[f64] {
        &self.total
    }
}
