//! One linear step from a point: weights, covariance, constraints and robustness as asked for.

use super::Settings;
use super::noise::ScatterSources;
use super::robust::{self, RobustRecord};
use super::rules::{self, ActiveConstraint, Constraints, Cost, Rules};
use super::scatter::{own_system, scatter_lines};
use super::system::{known_inputs, rounding, weigh};
use crate::campaign::Campaign;
use crate::design::DesignMatrix;
use crate::elements::Elements;
use crate::error::Result;
use crate::estimate::{
    self, Elimination, Equation, Equations, Estimate, Group, NO_REDUNDANCY, Restricted, ScaleHints, Scattered, Stepped,
    System, Whitening, adjust_on, adjust_scattered, restrict, scattered_with,
};
use crate::quality::Tested;
use faer::Mat;

/// What one step found.
pub(super) struct Step {
    /// The weighted system.
    pub system: System,
    /// The estimate that equations and active bounds restrict, these as equations of their own; what scatters is that of the estimate that equations restrict but
    /// inequalities do not.
    pub own: Adjusted,
    /// The step of the estimated parameters, constraints included.
    pub change: Vec<f64>,
    /// `d x / d y` of the estimate with active bounds, where there are such.
    pub on_face: Option<Mat<f64>>,
    /// What became of the constraints.
    pub constraints: Constraints,
}

/// The rows of a step adjusted with some equations.
pub(super) struct Adjusted {
    /// The estimate.
    pub estimate: Estimate,
    /// What scatters, and what it makes of the estimate.
    pub noise: ScatterSources,
    /// What the robust estimator did.
    pub robust: Option<RobustRecord>,
    /// The rows as they were adjusted, where something scatters beyond their own noise; their sensitivities are in `noise`.
    pub scattered: Option<Scattered>,
    /// Did inner iterations (scales, components, weights) settle?
    pub settled: bool,
    /// The rows beside known inputs that have an uncertainty, where there are such.
    extended: Option<Extended>,
}

/// The rows of a step beside its known inputs ([`System::with_inputs`]): what scatter and tests of residuals come from. Estimates do not: there the
/// inputs are as stated, and their uncertainty is a part of the budget.
struct Extended {
    system: System,
    estimate: Estimate,
    scattered: Option<Scattered>,
}

impl Step {
    /// What the tests of residuals are about: the system, its adjustment, and what it shares.
    pub(crate) fn tested(&self) -> (&System, &Estimate, Option<&Scattered>) {
        self.own.tested(&self.system)
    }

    /// What these tests have of each row that its estimate has not.
    pub(crate) fn tested_beside(&self) -> Option<Tested> {
        let (redundancy, standardized, alone) = match (self.tested(), &self.own.extended) {
            ((.., Some(found)), _) => (found.redundancy.clone(), found.standardized.clone(), found.alone.clone()),
            ((system, estimate, None), Some(_)) => {
                let over = |(v, u): (&f64, f64)| v / u;
                let u = estimate.row_u(system);
                (estimate.redundancy.clone(), estimate.residuals.iter().zip(u).map(over).collect(), Vec::new())
            }
            _ => return None,
        };
        Some(Tested { redundancy, standardized, alone })
    }

    /// `d x / d y` of the constrained estimate.
    pub(crate) fn sensitivities(&self) -> &Mat<f64> {
        self.on_face.as_ref().unwrap_or(&self.own.noise.sensitivities)
    }
}

impl Adjusted {
    fn tested<'a>(&'a self, system: &'a System) -> (&'a System, &'a Estimate, Option<&'a Scattered>) {
        match &self.extended {
            Some(own) => (&own.system, &own.estimate, own.scattered.as_ref()),
            None => (system, &self.estimate, self.scattered.as_ref()),
        }
    }
}

/// Solve the linear problem at the design's point.
pub(super) fn solve(campaign: &Campaign, design: &DesignMatrix, settings: &Settings) -> Result<Step> {
    let system = weigh(campaign, design, settings.weighting)?;
    let mut rules = Rules::at(campaign, &design.point);
    let contradiction = rules::contradiction(campaign).or_else(|| rules.eliminate(&system, campaign.unknowns()).1);
    if contradiction.is_some() {
        rules.equations.clear();
    }
    let of = |rules: &Rules, before: Option<&Adjusted>| adjusted(campaign, design, settings, &system, rules, before);
    let free = of(&rules, None)?;
    let change = free.estimate.unknowns.solution.clone();
    let found = match contradiction {
        Some(named) => (Constraints::Contradictory(named), None),
        None if campaign.constraints.is_empty() => (Constraints::None, None),
        None => {
            let without = match rules.equations.is_empty() {
                true => None,
                false => Some(of(&Rules { equations: Vec::new(), ..rules.clone() }, Some(&free))?),
            };
            let equations = without.map(|without| cost(&system, &free, &without));
            // whitened rows have unit variance, whatever was estimated on the way
            let weighed = if free.scattered.is_some() { system.with_u(system.u.clone()) } else { system.clone() };
            inequalities(&weighed, &free.estimate, &rules, design, equations)
        }
    };
    let (constraints, (change, mut own, noise)) = match found {
        (constraints, None) => (constraints, (change, free, None)),
        (constraints, Some((change, active))) => {
            rules.equations.extend(active);
            let face = of(&rules, Some(&free))?;
            (constraints, (change, Adjusted { settled: face.settled && free.settled, ..face }, Some(free.noise)))
        }
    };
    let on_face = noise.map(|free| std::mem::replace(&mut own.noise, free).sensitivities);
    Ok(Step { system, own, change, on_face, constraints })
}

/// What equations cost: the squares with them and without, in the variances without them.
fn cost(system: &System, with: &Adjusted, without: &Adjusted) -> Cost {
    let (rows, free, _) = without.tested(system);
    let u = free.row_u(rows);
    let squares = |own: &Adjusted| match own.tested(system) {
        (.., Some(found)) => found.estimate.sum_of_squares,
        (_, estimate, None) => estimate.residuals.iter().zip(&u).map(|(v, u)| (v / u).powi(2)).sum(),
    };
    let count = with.estimate.dof.saturating_sub(without.estimate.dof);
    Cost { chi_square: (squares(with) - squares(without)).max(0.0), count, dof: without.estimate.dof }
}

/// Adjust; the variances are those of an adjustment `before`, where there was one and they decide the weights.
fn adjusted(
    campaign: &Campaign,
    design: &DesignMatrix,
    settings: &Settings,
    system: &System,
    rules: &Rules,
    before: Option<&Adjusted>,
) -> Result<Adjusted> {
    let elimination = rules.eliminate(system, campaign.unknowns()).0;
    let mut robust_record = None;
    let mut settled = true;
    let mut scattered = None;
    let inputs = known_inputs(campaign, design).filter(|_| settings.robust.is_none());
    let with_inputs = |system: &System| {
        let own = system.with_inputs(inputs.as_ref()?);
        let elimination = elimination.as_ref().and_then(|_| rules.eliminate(&own, own.rows.ncols()).0);
        Some((own, elimination))
    };
    let mut extended = None;
    let (estimate, noise) = if let Some(method) = settings.robust {
        let found = robust::estimate(system, design.rows.len(), method, &settings.adjust)?;
        let covariance = robust::covariance(&found, system);
        let factor = |group: Option<usize>| {
            // rows with a stated u have the scale 1
            group.and_then(|g| found.scale.get(g)).copied().unwrap_or(1.0).powi(2) * found.inflation
        };
        let noise = ScatterSources::robust(campaign, design, system, &found.plain, factor, covariance.clone());
        let mut estimate = found.plain.clone();
        estimate.unknowns.solution = found.weighted.unknowns.solution;
        estimate.residuals = found.weighted.residuals;
        estimate.factor = found.weighted.factor;
        estimate.group_scale = estimate.group_scale.iter().zip(&found.scale).map(|(old, s)| old.map(|_| *s)).collect();
        estimate.unknowns.covariance = covariance;
        settled = found.record.converged;
        robust_record = Some(found.record);
        (estimate, noise)
    } else if !campaign.scatter.is_empty() {
        let lines = scatter_lines(campaign, design, &system.u);
        let own = own_system(campaign, design, system);
        let least = rounding(campaign, design, system);
        let solve = |system: &System, elimination: Option<&Elimination>, told: Option<&Scattered>| match told {
            Some(told) => scattered_with((system, &lines), elimination, told, &settings.adjust),
            None => adjust_scattered(system, &lines, elimination, &least, &settings.adjust),
        };
        let mut found = match with_inputs(&own) {
            None => solve(&own, elimination.as_ref(), before.and_then(|own| own.scattered.as_ref()))?,
            Some((system, own_elimination)) => {
                let told = before.and_then(|own| own.extended.as_ref()?.scattered.as_ref());
                let found = solve(&system, own_elimination.as_ref(), told)?;
                let plain = scattered_with((&own, &lines), elimination.as_ref(), &found, &settings.adjust)?;
                let residuals = system.residuals(&found.estimate.unknowns.solution);
                let estimate = Estimate { residuals, ..found.estimate.clone() };
                extended = Some(Extended { system, estimate, scattered: Some(found) });
                plain
            }
        };
        settled = found.converged;
        let levels: Vec<usize> = campaign
            .scatter
            .iter()
            .zip(&lines)
            .map(|(own, line)| if own.over.is_some() { line.levels() } else { own.per.levels(campaign).1 })
            .collect();
        let noise = ScatterSources::scattered(campaign, design, &own, &mut found, &levels);
        let estimate = as_read(system, &noise, &found);
        scattered = Some(found);
        (estimate, noise)
    } else {
        let least = if elimination.is_some() { Vec::new() } else { rounding(campaign, design, system) };
        let solve = |system: &System, elimination: Option<&Elimination>, given: &[Option<f64>]| {
            let hints = ScaleHints { start: &[], least: &least, given };
            adjust_on(system, elimination, &hints, &settings.adjust)
        };
        // the scale of one group alone decides no weights
        let several = system.group.iter().any(|group| system.group.first() != Some(group));
        let before = before.filter(|_| several);
        if let Some((system, elimination)) = with_inputs(system) {
            let told = before.and_then(|own| Some(&own.extended.as_ref()?.estimate));
            let estimate = solve(&system, elimination.as_ref(), told.map_or(&[], |own| &own.group_scale))?;
            extended = Some(Extended { system, estimate, scattered: None });
        }
        let told = extended.as_ref().map(|own| &own.estimate);
        let given = told.or(before.map(|own| &own.estimate)).map_or(&[][..], |own| &own.group_scale);
        let mut estimate = solve(system, elimination.as_ref(), given)?;
        if let Some(told) = told {
            estimate.group_redundancy = told.group_redundancy.iter().map(|own| own.max(NO_REDUNDANCY)).collect();
            estimate.group_converged = told.group_converged;
        }
        settled = settled && estimate.group_converged;
        let variances = extended.as_ref().map_or((system, &estimate), |own| (&own.system, &own.estimate));
        let noise = ScatterSources::independent(campaign, design, (system, &estimate), variances);
        (estimate, noise)
    };
    Ok(Adjusted { estimate, noise, robust: robust_record, scattered, settled, extended })
}

/// Adjust a system of this campaign at a design's point, meeting the campaign's equations; where they contradict each other, without them.
pub(crate) fn adjust_with_equations(campaign: &Campaign, design: &DesignMatrix, system: &System) -> Result<Estimate> {
    adjust_meeting_equations(campaign, &design.point, system, &crate::estimate::Settings::default())
}

/// The same for any system whose first columns are the estimated parameters; further columns take part in no equation.
pub(crate) fn adjust_meeting_equations(
    campaign: &Campaign,
    point: &[f64],
    system: &System,
    settings: &crate::estimate::Settings,
) -> Result<Estimate> {
    let (elimination, _) = Rules::at(campaign, point).eliminate(system, system.rows.ncols());
    adjust_on(system, elimination.as_ref(), &ScaleHints::default(), settings)
}

/// Equations of the campaign that contradict each other, by index of the constraint.
pub(crate) fn contradicting_equations(campaign: &Campaign) -> Option<Vec<usize>> {
    let rules = Rules::at(campaign, &campaign.reference_point());
    match Equations::new(campaign.unknowns(), &vec![1.0; campaign.unknowns()], &rules.equations) {
        Equations::Consistent(_) => None,
        Equations::Contradictory(which) => Some(rules.equations_named(&which)),
    }
}

/// Apply the inequalities: what became of the constraints, and if they changed the step, the restricted one and the equations that hold on its face.
fn inequalities(
    system: &System,
    estimate: &Estimate,
    rules: &Rules,
    design: &DesignMatrix,
    equations: Option<Cost>,
) -> (Constraints, Option<(Vec<f64>, Vec<Equation>)>) {
    let free: Vec<f64> = design.point.iter().zip(&estimate.unknowns.solution).map(|(x, dx)| x + dx).collect();
    let along = estimate.factor.whitened_directions();
    match restrict(system, estimate, &rules.inequalities) {
        Restricted::NotApplied => (Constraints::NotApplied, None),
        Restricted::Infeasible(which) => {
            let mut named = rules.inequalities_named(&which);
            // the equations decided what was free; they may have a part in it
            named.extend(&rules.equation_of);
            named.sort_unstable();
            (Constraints::Contradictory(named), None)
        }
        Restricted::Found { active, .. } if active.is_empty() => {
            (Constraints::Met { active: Vec::new(), cost: 0.0, on_face: None, free, along, equations }, None)
        }
        Restricted::Found { solution, active, cost, covariance } => {
            let common = match (system.group.first(), estimate.group_scale.as_slice()) {
                (Some(Group::Estimated(_)), [Some(s)]) if !system.group.contains(&Group::Known) && *s > 0.0 => s * s,
                _ => 1.0,
            };
            let faces =
                active.iter().filter_map(|a| Some(rules.inequalities.get(a.inequality)?.face(a.side, &solution)));
            let faces = faces.collect();
            let active = active
                .iter()
                .map(|a| ActiveConstraint {
                    constraint: rules.inequality_of.at(a.inequality),
                    side: a.side,
                    multiplier: a.multiplier / common,
                    cost: a.cost / common,
                })
                .collect();
            let met =
                Constraints::Met { active, cost: cost / common, on_face: Some(covariance), free, along, equations };
            (met, Some((solution, faces)))
        }
    }
}

/// An estimate from whitened rows, with residuals, leverages and redundancies of the readings as they were read.
fn as_read(system: &System, noise: &ScatterSources, found: &Scattered) -> Estimate {
    let mut estimate = found.estimate.clone();
    estimate.residuals = system.residuals(&estimate.unknowns.solution);
    let m = system.observed.len();
    estimate.leverage = (0..m)
        .map(|i| {
            let own: f64 = (0..system.rows.ncols()).map(|j| system.rows[(i, j)] * noise.sensitivities[(j, i)]).sum();
            own.clamp(0.0, 1.0)
        })
        .collect();
    estimate.redundancy = estimate.leverage.iter().map(|h| 1.0 - h).collect();
    estimate.group_scale = found.group_variance.iter().map(|v| v.map(f64::sqrt)).collect();
    estimate.group_redundancy = vec![estimate.dof as f64; estimate.group_scale.len()];
    estimate.unknowns.covariance = noise.covariance.clone();
    estimate.group_iterations = found.iterations;
    estimate.group_converged = found.converged;
    estimate
}

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
    /// Solve at a design's point, after the solution at another point if there is one. Errors: those of [`solve`].
    pub fn at(
        campaign: &Campaign,
        design: &DesignMatrix,
        before: Option<&Linear>,
        settings: &Settings,
    ) -> Result<Self> {
        if !campaign.constraints.is_empty() || settings.robust.is_some() {
            return Ok(Linear::from(solve(campaign, design, settings)?));
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
        let scales = step.own.estimate.group_scale.iter().map(|scale| scale.unwrap_or(1.0)).collect();
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
        let estimate = &step.own.estimate;
        let weights = match step.own.scattered {
            Some(found) => Weights::Whitened(Box::new(found.whitening)),
            None => {
                // the scale of one group alone changes nothing
                let scale = |g: usize| {
                    (estimate.group_iterations > 0).then(|| estimate.group_scale.get(g).copied().flatten()).flatten()
                };
                let mut weights = weights(&step.system, scale);
                for (w, robust) in weights.iter_mut().zip(step.own.robust.iter().flat_map(|record| &record.weights)) {
                    *w *= robust.sqrt();
                }
                Weights::Rows(weights)
            }
        };
        let (residuals, rank) = (step.own.estimate.residuals, step.own.estimate.unknowns.rank);
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
    // a scale that is not determined, or zero, leaves the weights as they are
    let entering = |g: usize| scale(g).filter(|s| *s > 0.0).unwrap_or(1.0);
    system.scaled_u(entering).into_iter().map(f64::recip).collect()
}
