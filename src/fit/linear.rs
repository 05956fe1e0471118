//! A linear step as Gauss-Newton needs it on its way: where to go, and how far from the readings that is.

use super::Settings;
use super::scatter::{own_system, scatter_lines};
use super::step::{self, Step};
use super::system::{known_inputs, rounding, weigh};
use crate::campaign::Campaign;
use crate::design::DesignMatrix;
use crate::error::Result;
use crate::estimate::{self, Group, ScaleHints, Stepped, System, Whitening};

/// The solution of one linear problem.
pub(super) struct Linear {
    /// The weighted system.
    pub system: System,
    /// The step of the estimated parameters, constraints included.
    pub change: Vec<f64>,
    /// Residuals after the whole step, in the units of the readings.
    pub residuals: Vec<f64>,
    /// Number of independent columns.
    pub rank: usize,
    /// Scales of the groups, for the next step to begin with.
    scales: Vec<f64>,
    /// The scales that the rounding of the readings alone would have, the same at every point; empty where nothing asked for them.
    least: Vec<f64>,
    weights: Weights,
}

/// How the step weighs what it makes smaller.
enum Weights {
    /// One weight for each row; robust ones included.
    Rows(Vec<f64>),
    /// What scatters beyond the rows' own noise.
    Whitened(Box<Whitening>),
    /// The same, from a step that goes no further than where it leads.
    Stepped(Box<Stepped>),
}

impl Linear {
    /// Solve at a design's point, after the solution at another point if there is one. Errors: those of [`step::solve`].
    pub fn at(
        campaign: &Campaign,
        design: &DesignMatrix,
        before: Option<&Linear>,
        settings: &Settings,
    ) -> Result<Self> {
        if !campaign.constraints.is_empty() || settings.robust.is_some() {
            return Ok(Linear::from(step::solve(campaign, design, settings)?));
        }
        let system = weigh(campaign, design, settings.weighting)?;
        let least = before.map_or_else(|| rounding(campaign, design, &system), |step| step.least.clone());
        if !campaign.scatter.is_empty() {
            let lines = scatter_lines(campaign, design, &system.u);
            let own = own_system(campaign, design, &system);
            let before =
                before.and_then(|step| if let Weights::Stepped(own) = &step.weights { Some(&**own) } else { None });
            let found = estimate::step_scattered(&own, &lines, &least, before, &settings.adjust)?;
            let (change, rank) = (found.solution.clone(), found.rank);
            let residuals = system.residuals(&change);
            let weights = Weights::Stepped(Box::new(found));
            return Ok(Linear { system, change, residuals, rank, scales: Vec::new(), least, weights });
        }
        // on the way the scales need not settle: they go on from step to step, and the last step settles them
        let own = estimate::Settings { group_iterations: settings.adjust.group_iterations.min(2), ..settings.adjust };
        let start = before.map_or(&[][..], |step| &step.scales);
        let several = system.group.iter().any(|group| system.group.first() != Some(group));
        let given: Vec<Option<f64>> = match known_inputs(campaign, design).filter(|_| several) {
            Some(inputs) => {
                let hints = ScaleHints { start, least: &least, given: &[] };
                let found = estimate::solve(&system.with_inputs(&inputs), &hints, &own)?;
                found.group_scale.into_iter().map(Some).collect()
            }
            None => Vec::new(),
        };
        let found = estimate::solve(&system, &ScaleHints { start, least: &least, given: &given }, &own)?;
        let weights = weights(&system, |g| found.group_scale.get(g).copied());
        let (change, residuals, rank) = (found.solution, found.residuals, found.rank);
        Ok(Linear {
            system,
            change,
            residuals,
            rank,
            scales: found.group_scale,
            least,
            weights: Weights::Rows(weights),
        })
    }

    /// What a step at this design was, to go on from it.
    pub fn after(campaign: &Campaign, design: &DesignMatrix, step: Step) -> Self {
        let least = rounding(campaign, design, &step.system);
        let scales = step.estimate.group_scale.iter().map(|scale| scale.unwrap_or(1.0)).collect();
        Linear { least, scales, ..Linear::from(step) }
    }

    /// Norm of the step's effect on the weighted predictions, `|J dx / u|`.
    pub fn length(&self) -> f64 {
        let moved: Vec<f64> = self.system.observed.iter().zip(&self.residuals).map(|(y, v)| y - v).collect();
        self.merit(&moved).sqrt()
    }

    /// What the step makes smaller: the weighted sum of squares, with the whitened rows' covariance or the robust weights of this step.
    pub fn merit(&self, values: &[f64]) -> f64 {
        match &self.weights {
            Weights::Rows(weights) => values.iter().zip(weights).map(|(v, w)| (v * w).powi(2)).sum(),
            Weights::Whitened(whitening) => squares(whitening, values),
            Weights::Stepped(step) => squares(&step.whitening, values),
        }
    }
}

impl From<Step> for Linear {
    fn from(step: Step) -> Self {
        let estimate = &step.estimate;
        let weights = match step.scattered {
            Some(found) => Weights::Whitened(Box::new(found.whitening)),
            None => {
                // the scale of one group alone changes nothing
                let scale = |g: usize| {
                    (estimate.group_iterations > 0).then(|| estimate.group_scale.get(g).copied().flatten()).flatten()
                };
                let mut weights = weights(&step.system, scale);
                for (w, robust) in weights.iter_mut().zip(step.robust.iter().flat_map(|record| &record.weights)) {
                    *w *= robust.sqrt();
                }
                Weights::Rows(weights)
            }
        };
        let (residuals, rank) = (step.estimate.residuals, step.estimate.unknowns.rank);
        Linear {
            system: step.system,
            change: step.change,
            residuals,
            rank,
            scales: Vec::new(),
            least: Vec::new(),
            weights,
        }
    }
}

fn squares(whitening: &Whitening, values: &[f64]) -> f64 {
    whitening.whiten(values).iter().map(|v| v * v).sum()
}

/// `1 / (s_g u)` with the estimated scale where there are several.
fn weights(system: &System, scale: impl Fn(usize) -> Option<f64>) -> Vec<f64> {
    let scale_of = |group: &Group| match group {
        // a scale that is not determined, or zero, leaves the weights as they are
        Group::Estimated(g) => scale(*g).filter(|s| *s > 0.0).unwrap_or(1.0),
        Group::Known => 1.0,
    };
    system.u.iter().zip(&system.group).map(|(u, group)| 1.0 / (u * scale_of(group))).collect()
}
