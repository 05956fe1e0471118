//! Value, standard uncertainty, budget and expanded uncertainty of every estimated parameter and derived quantity.

use crate::algebra::{Scratch, Tape};
use crate::campaign::{Campaign, Kind, Known, Role};
use crate::design::DesignMatrix;
use crate::error::Result;
use crate::estimate::{Estimate, Group, System};
use crate::uncertainty::{Combined, Contribution, Evaluation, combine};
use faer::Mat;

/// What the fit can say about a parameter.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum State {
    /// Determined by the readings.
    Free,
    /// On a bound.
    AtBound,
    /// Only a combination with others is determined.
    NotEstimable,
}

impl State {
    /// As reports write it.
    pub fn name(self) -> &'static str {
        match self {
            State::Free => "free",
            State::AtBound => "at-bound",
            State::NotEstimable => "not-estimable",
        }
    }
}

/// An estimated parameter.
#[derive(Debug, Clone)]
pub struct ParameterResult {
    /// Its name.
    pub id: String,
    /// Tilt or coefficient.
    pub kind: Kind,
    /// Unit of value and uncertainty (`rad` for tilts).
    pub unit: String,
    /// What it means, for a person.
    pub meaning: String,
    /// Estimate; `None` where it is not estimable.
    pub value: Option<f64>,
    /// Combined uncertainty; `None` where it cannot be known (not estimable, or no degree of freedom to estimate the scatter).
    pub uncertainty: Option<Combined>,
    /// Where the uncertainty comes from.
    pub budget: Vec<Contribution>,
    /// Free, at a bound, or not estimable.
    pub state: State,
}

/// A derived quantity.
#[derive(Debug, Clone)]
pub struct DerivedResult {
    /// Its name.
    pub id: String,
    /// The line of algebra.
    pub line: String,
    /// Is it an angle (so that a person wants arcseconds)?
    pub is_angle: bool,
    /// Value; `None` where it needs a parameter that is not estimable, or is no finite number.
    pub value: Option<f64>,
    /// First-order combined uncertainty.
    pub uncertainty: Option<Combined>,
    /// Where the uncertainty comes from.
    pub budget: Vec<Contribution>,
}

/// Known parameters with an uncertainty, and how the solution follows each: `d x / d p = -A^+ df/dp`, priors untouched.
fn known_inputs<'a>(
    campaign: &'a Campaign,
    design: &DesignMatrix,
    estimate: &Estimate,
) -> Vec<(&'a str, Known, Vec<f64>)> {
    let mut inputs = Vec::new();
    for (k, parameter) in campaign.parameters.iter().enumerate() {
        let Role::Known(known) = parameter.role else { continue };
        if known.u == 0.0 {
            continue;
        }
        let mut shift = vec![0.0; estimate.residuals.len()];
        for (i, value) in shift.iter_mut().enumerate().take(design.rows.len()) {
            *value = -design.jacobian[(i, k)];
        }
        let sensitivity = estimate.factor.solve(&shift).unwrap_or_else(|_| vec![0.0; campaign.unknowns()]);
        inputs.push((parameter.id.as_str(), known, sensitivity));
    }
    inputs
}

/// Uncertainty of a linear function `c . x` of the unknowns from the readings: one contribution for each group of rows.
fn from_readings(
    campaign: &Campaign,
    design: &DesignMatrix,
    system: &System,
    estimate: &Estimate,
    sensitivities: &Mat<f64>,
    along: &[f64],
) -> Vec<Contribution> {
    let weights = row_weights(sensitivities, along);
    // sensors in bench order, then priors
    let sensors = campaign.bench.sensors.len();
    let mut square = vec![0.0; sensors + 1];
    let mut group_of = vec![Group::Known; sensors + 1];
    for (i, weight) in weights.iter().enumerate() {
        let source = design.rows.get(i).map_or(sensors, |origin| origin.sensor);
        let group = system.group.get(i).copied().unwrap_or_default();
        let scale = match group {
            Group::Estimated(g) => estimate.group_scale.get(g).copied().flatten().unwrap_or(1.0),
            Group::Known => 1.0,
        };
        if let (Some(sum), Some(own)) = (square.get_mut(source), group_of.get_mut(source)) {
            *sum += (weight * scale * system.u.get(i).copied().unwrap_or_default()).powi(2);
            *own = group;
        }
    }
    let mut contributions = Vec::new();
    for (source, (square, group)) in square.iter().zip(&group_of).enumerate() {
        if *square == 0.0 {
            continue;
        }
        let (evaluation, dof) = match group {
            Group::Estimated(g) => (Evaluation::TypeA, estimate.group_redundancy.get(*g).copied().unwrap_or_default()),
            Group::Known if source == sensors => (Evaluation::TypeB, f64::INFINITY),
            Group::Known => (Evaluation::TypeA, f64::INFINITY),
        };
        let name = campaign.bench.sensors.get(source).map_or("priors".to_string(), |s| format!("readings of {}", s.id));
        contributions.push(Contribution {
            source: name,
            evaluation,
            distribution: if dof.is_finite() { "t" } else { "normal" },
            source_u: None,
            sensitivity: None,
            u: square.sqrt(),
            dof,
        });
    }
    contributions
}

/// `d(c . x)/d y` for every row, from the sensitivities `d x / d y` (unknowns x rows).
fn row_weights(sensitivities: &Mat<f64>, along: &[f64]) -> Vec<f64> {
    let mut weights = vec![0.0; sensitivities.ncols()];
    for (j, c) in along.iter().enumerate().take(sensitivities.nrows()) {
        if *c != 0.0 {
            for (i, weight) in weights.iter_mut().enumerate() {
                *weight += c * sensitivities[(j, i)];
            }
        }
    }
    weights
}

/// Is every scale that this estimate needs determined?
fn scales_known(estimate: &Estimate) -> bool {
    estimate.group_scale.iter().all(Option::is_some)
}

/// Results of all estimated parameters and their full covariance (readings and known inputs).
pub(super) fn results(
    campaign: &Campaign,
    design: &DesignMatrix,
    system: &System,
    estimate: &Estimate,
    point: &[f64],
    level: f64,
) -> (Vec<ParameterResult>, Mat<f64>) {
    let known = known_inputs(campaign, design, estimate);
    let sensitivities = estimate.factor.sensitivities();
    let mut covariance = estimate.covariance.clone();
    for (_, input, c) in &known {
        for i in 0..covariance.nrows().min(c.len()) {
            for j in 0..covariance.ncols().min(c.len()) {
                covariance[(i, j)] += c[i] * c[j] * input.u * input.u;
            }
        }
    }
    let results = campaign
        .estimated()
        .iter()
        .enumerate()
        .map(|(k, parameter)| {
            let estimable = estimate.estimable.get(k).copied().unwrap_or(false);
            let mut along = vec![0.0; campaign.unknowns()];
            if let Some(one) = along.get_mut(k) {
                *one = 1.0;
            }
            let budget = if estimable {
                budget_along(campaign, design, system, estimate, &sensitivities, &known, &along)
            } else {
                Vec::new()
            };
            ParameterResult {
                id: parameter.id.clone(),
                kind: parameter.kind,
                unit: parameter.unit.clone(),
                meaning: parameter.meaning.clone(),
                value: if estimable { point.get(k).copied() } else { None },
                uncertainty: if estimable && scales_known(estimate) { combine(&budget, level) } else { None },
                budget,
                state: if estimable { State::Free } else { State::NotEstimable },
            }
        })
        .collect();
    (results, covariance)
}

/// The whole budget of `c . x`.
fn budget_along(
    campaign: &Campaign,
    design: &DesignMatrix,
    system: &System,
    estimate: &Estimate,
    sensitivities: &Mat<f64>,
    known: &[(&str, Known, Vec<f64>)],
    along: &[f64],
) -> Vec<Contribution> {
    let mut budget = from_readings(campaign, design, system, estimate, sensitivities, along);
    for (id, input, c) in known {
        let sensitivity: f64 = along.iter().zip(c).map(|(a, c)| a * c).sum();
        budget.push(known_contribution(id, input, sensitivity));
    }
    budget
}

fn known_contribution(id: &str, input: &Known, sensitivity: f64) -> Contribution {
    Contribution {
        source: id.to_string(),
        evaluation: Evaluation::TypeB,
        distribution: input.distribution.name(),
        source_u: Some(input.u),
        sensitivity: Some(sensitivity),
        u: sensitivity.abs() * input.u,
        dof: input.dof,
    }
}

/// Results of the derived quantities: first order, `c = d quantity / d parameters` at the estimate.
///
/// A known parameter acts twice, through the line itself and through the estimates: its sensitivity is the sum of both.
pub(super) fn derived(
    campaign: &Campaign,
    design: &DesignMatrix,
    system: &System,
    estimate: &Estimate,
    point: &[f64],
    level: f64,
) -> Result<Vec<DerivedResult>> {
    let known = known_inputs(campaign, design, estimate);
    let sensitivities = estimate.factor.sensitivities();
    let ids: Vec<&str> = campaign.parameters.iter().map(|p| p.id.as_str()).collect();
    campaign
        .derived
        .iter()
        .map(|quantity| {
            let tape = Tape::compile(&quantity.line, &ids)?;
            let mut gradient: Vec<f64> = vec![0.0; ids.len()];
            let value = tape.gradient(point, &mut Scratch::default(), &mut gradient);
            let along = gradient.get(..campaign.unknowns()).unwrap_or_default();
            let needed =
                along.iter().enumerate().all(|(k, c)| *c == 0.0 || estimate.estimable.get(k).copied().unwrap_or(false));
            let usable = needed && value.is_finite() && gradient.iter().all(|c| c.is_finite());
            let mut budget = if usable {
                from_readings(campaign, design, system, estimate, &sensitivities, along)
            } else {
                Vec::new()
            };
            if usable {
                for (id, input, c) in &known {
                    let own = campaign.parameter_index(id).and_then(|k| gradient.get(k)).copied().unwrap_or_default();
                    let through: f64 = along.iter().zip(c).map(|(a, c)| a * c).sum();
                    budget.push(known_contribution(id, input, own + through));
                }
            }
            let angle = |name: &str| {
                let parameter = campaign.parameter_index(name).and_then(|k| campaign.parameters.get(k))?;
                Some(if parameter.kind == Kind::Tilt { 1.0 } else { return None })
            };
            Ok(DerivedResult {
                id: quantity.id.clone(),
                line: quantity.line.to_string(),
                is_angle: quantity.line.angle_degree(&angle) == Some(1.0),
                value: usable.then_some(value),
                uncertainty: if usable && scales_known(estimate) { combine(&budget, level) } else { None },
                budget,
            })
        })
        .collect()
}
