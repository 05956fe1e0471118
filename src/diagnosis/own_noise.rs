//! The noise of each of several sensors where it is not stated: what remains in that sensor given all other random effects there.
//!
//! ```text
//! s_g^2 = E(s^2 | y_g),      over the kernels of the bank and their sizes, the rows of sensor g alone, the effects that are in the model taken out
//! ```
//!
//! One variance of unit weight for all sensors could not see a deviation in one of them: the scale of its residuals contains it. A few replicates of one sensor tell its
//! noise worse than all of its rows.
#![allow(
    clippy::indexing_slicing,
    reason = "rows are those of the design, of which the weighted system and the kernels have as many or more"
)]

use super::bank::bank;
use super::common::NoiseFrom;
use super::noise::{self, Finished, Weighted};
use super::score::{Kernel, Priors, Problem, Score};
use crate::campaign::Campaign;
use crate::design::DesignMatrix;
use crate::error::Result;
use crate::estimate::{self, Group, System};
use faer::Mat;

/// The system of a design, weighed by the best noise there is; `effects` are columns of the readings that are in the finished model and not in the design.
pub(super) fn weigh(
    campaign: &Campaign,
    design: &DesignMatrix,
    finished: Option<&Finished>,
    effects: &[&Vec<f64>],
    priors: Priors,
) -> Result<Weighted> {
    let weighted = noise::weigh(campaign, design, finished, &[])?;
    let sensors = design.rows.iter().map(|row| row.sensor).max().map_or(0, |s| s + 1);
    let mut rows: Vec<Vec<usize>> = vec![Vec::new(); sensors];
    design.rows.iter().enumerate().for_each(|(i, row)| rows[row.sensor].push(i));
    let read = rows.iter().filter(|of_sensor| !of_sensor.is_empty()).count();
    if weighted.from == NoiseFrom::Stated || weighted.floor.is_some() || read < 2 {
        return Ok(weighted);
    }
    let kernels = bank(campaign, design, &weighted);
    let mut share = vec![1.0; sensors];
    for (s, of_sensor) in rows.iter().enumerate().filter(|(_, of_sensor)| !of_sensor.is_empty()) {
        share[s] = of_noise(campaign, design, &weighted, (s, of_sensor), effects, &kernels, priors)?;
    }
    if share.iter().all(|s| *s == 1.0) { Ok(weighted) } else { noise::weigh(campaign, design, finished, &share) }
}

/// The standard deviation of one sensor's noise in that with which it was weighed: of the mean of the variance over all kernels.
fn of_noise(
    campaign: &Campaign,
    design: &DesignMatrix,
    weighted: &Weighted,
    (sensor, rows): (usize, &[usize]),
    effects: &[&Vec<f64>],
    kernels: &[Kernel],
    priors: Priors,
) -> Result<f64> {
    let n = campaign.unknowns();
    let system = System {
        rows: Mat::from_fn(rows.len(), n + effects.len(), |i, j| {
            let entry = match j.checked_sub(n) {
                None => design.jacobian[(rows[i], j)],
                // columns end with the readings
                Some(k) => effects[k].get(rows[i]).copied().unwrap_or_default(),
            };
            entry * weighted.weight[rows[i]]
        }),
        observed: rows.iter().map(|i| weighted.residual[*i]).collect(),
        u: vec![1.0; rows.len()],
        group: vec![Group::Known; rows.len()],
    };
    let alone = estimate::adjust(&system, &estimate::Settings::default())?;
    let is_of_sensor = |kernel: &&Kernel| kernel.sensor == Some(sensor);
    let part = |kernel: &Kernel| Kernel {
        follows: None,
        per_mounting: kernel.per_mounting,
        one_of: kernel.one_of,
        factor: Mat::from_fn(rows.len(), kernel.factor.ncols(), |i, j| kernel.factor[(rows[i], j)]),
        sensor: kernel.sensor,
    };
    let kernels: Vec<Kernel> = kernels.iter().filter(is_of_sensor).map(part).collect();
    let none = Mat::zeros(rows.len(), 0);
    let problem = Problem {
        residual: &system.observed,
        basis: alone.factor.thin_q(),
        columns: none.as_ref(),
        prior: &[],
        plain: &[],
        fixed: &[],
        kinds: &[],
        known: false,
        kernels: &kernels,
        sharing: None,
    };
    let deviations = Score::new(&problem, priors).deviations(&[]);
    let mean: f64 = deviations.iter().map(|d| d.probability * d.variance).sum();
    // the mean of an inverse gamma distribution is larger than the variance of the residuals; with two degrees of freedom or fewer it is not determined
    let dof = alone.dof as f64;
    let share = (mean * (dof - 2.0) / dof).sqrt();
    Ok(if share > 0.0 && share.is_finite() { share } else { 1.0 })
}
