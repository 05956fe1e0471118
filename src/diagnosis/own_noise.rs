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

use super::bank::bank_of;
use super::common::NoiseFrom;
use super::noise::{self, FEWEST_REPLICATES, Finished, Weighted};
use super::score::{Kernel, Priors, Problem, Score};
use crate::campaign::Campaign;
use crate::design::DesignMatrix;
use crate::error::Result;
use crate::estimate::{self, System};
use crate::uncertainty::quantiles::fisher_f_survival;
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
    let kernels = bank_of(campaign, design, &weighted, |_, sensor| sensor.is_some());
    let mut share = vec![1.0; sensors];
    for (s, of_sensor) in rows.iter().enumerate().filter(|(_, of_sensor)| !of_sensor.is_empty()) {
        share[s] = of_noise(campaign, design, &weighted, (s, of_sensor), effects, &kernels, priors)?;
    }
    if share.iter().all(|s| *s == 1.0) { Ok(weighted) } else { noise::weigh(campaign, design, finished, &share) }
}

/// Probability, over all readings, of so large a deviation by chance, below which a reading says nothing of the noise of its sensor: a tenth of the significance at
/// which effects are named by default.
const CONTRADICTED: f64 = 1e-3;

/// The row that the others contradict, what it adds being no noise: `t_i^2 = v_i^2/(1 - h_i)`, `F = t_i^2/s_(i)^2`, `s_(i)^2 = (sum v^2 - t_i^2)/(dof - 1)` (R. D. Cook,
/// S. Weisberg, Residuals and Influence in Regression, 1982, 2.2.2); `readings` are all that are looked at.
fn contradicted(alone: &estimate::Estimate, readings: usize) -> Option<usize> {
    let left = alone.dof.checked_sub(1).filter(|left| *left >= FEWEST_REPLICATES)? as f64;
    let q = alone.factor.thin_q();
    let free = |i: usize| 1.0 - (0..q.ncols()).map(|j| q[(i, j)] * q[(i, j)]).sum::<f64>();
    // a reading that no other checks has a residual of rounding
    let squares = alone.residuals.iter().enumerate().filter(|(i, _)| free(*i) > 1e-9);
    let (t, i) = squares.map(|(i, v)| (v * v / free(i), i)).max_by(|a, b| a.0.total_cmp(&b.0))?;
    let sum: f64 = alone.residuals.iter().map(|v| v * v).sum();
    // the difference is rounding below a few hundred epsilons: residuals that are zero but for one say nothing of the noise either
    let others = Some(sum - t).filter(|others| *others > 1e-13 * sum)?;
    let p = fisher_f_survival(t * left / others, 1.0, left)?;
    (p * (readings as f64) < CONTRADICTED).then_some(i)
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
    let of_rows = |rows: &[usize]| {
        let of = Mat::from_fn(rows.len(), n + effects.len(), |i, j| {
            let entry = match j.checked_sub(n) {
                None => design.jacobian[(rows[i], j)],
                // columns end with the readings
                Some(k) => effects[k].get(rows[i]).copied().unwrap_or_default(),
            };
            entry * weighted.weight[rows[i]]
        });
        System::known(of, rows.iter().map(|i| weighted.residual[*i]).collect(), vec![1.0; rows.len()])
    };
    let mut rows = rows.to_vec();
    let (system, alone) = loop {
        let system = of_rows(&rows);
        let alone = estimate::adjust(&system, &estimate::Settings::default())?;
        match contradicted(&alone, weighted.weight.len()) {
            Some(i) => rows.remove(i),
            None => break (system, alone),
        };
    };
    let is_of_sensor = |kernel: &&Kernel| kernel.sensor == Some(sensor);
    let part = |kernel: &Kernel| Kernel {
        follows: None,
        per_mounting: kernel.per_mounting,
        one_of: kernel.one_of,
        factor: kernel.factor.of_rows(&rows),
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
