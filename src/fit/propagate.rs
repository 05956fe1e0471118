//! A fit's distributions, drawn: Monte Carlo beside the first order.

use super::Fit;
use super::rules::Rules;
use crate::algebra::Tape;
use crate::error::{Fault, Malformed, Result};
use crate::estimate::Bounds;
use crate::uncertainty::monte_carlo::{KnownInput, Model, Output, Propagated, monte_carlo};

/// Monte Carlo of a fit beside the first order: its outputs are the estimable parameters, then the derived quantities that have a value.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
pub struct Drawn {
    /// Trials that gave finite values.
    pub trials: usize,
    /// Trials asked for.
    pub asked: usize,
    /// Seed.
    pub seed: u64,
    /// Did bounds hold any trial back? What was drawn is the constrained estimate.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub held: bool,
    /// Each output.
    pub outputs: Vec<DrawnOutput>,
    /// Several outputs together (GUM Supplement 2): the derived quantities, or the parameters where fewer than two are derived.
    pub joint: Option<Joint>,
}

/// One output of the Monte Carlo.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[schemars(rename = "DrawnReport")]
pub struct DrawnOutput {
    /// Name of the parameter or derived quantity.
    pub id: String,
    /// Mean of the trials, in the quantity's unit.
    pub mean: f64,
    /// Standard deviation of the trials, in the quantity's unit.
    pub u: f64,
    /// Probabilistically symmetric coverage interval, in the quantity's unit.
    pub interval: [f64; 2],
    /// Shortest coverage interval, in the quantity's unit.
    pub shortest: [f64; 2],
    /// First-order interval, in the quantity's unit; with bounds that of the estimate without them, cut to what they allow.
    pub first_order: Option<[f64; 2]>,
    /// Is the first order as good as two digits of the uncertainty (JCGM 101, clause 8): do both ends of the symmetric interval agree within
    /// half a unit of the second digit of `u` and the sampling error of the trials? Null where bounds held trials back: the first order is not about
    /// the constrained estimate.
    pub first_order_agrees: Option<bool>,
}

/// Several outputs together.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[schemars(rename = "JointReport")]
pub struct Joint {
    /// Their order.
    #[serde(rename = "order")]
    pub names: Vec<String>,
    /// Covariance, in products of the quantities' units.
    pub covariance: Vec<Vec<f64>>,
    /// Factor of the coverage ellipsoid, a pure number; null where they depend on each other.
    #[serde(rename = "k_p")]
    pub ellipsoid_factor: Option<f64>,
}

/// Most trials.
pub(crate) const MOST_TRIALS: usize = 20_000_000;
/// Fewest and most trials.
const TRIALS: std::ops::RangeInclusive<usize> = 1_000..=MOST_TRIALS;

/// Draw a fit's parameters and derived quantities.
///
/// The parameters scatter about the estimate that equations restrict but inequalities do not (as its intervals do), linearly in the
/// readings and the known inputs, and each trial is constrained as the estimate is; the derived lines are evaluated in full. `None` where no uncertainty is known or nothing is estimable.
/// Errors: fewer than 1000 or more than 20 million trials.
pub fn draw(fit: &Fit, trials: usize, seed: u64, progress: &(dyn Fn(usize) + Sync)) -> Result<Option<Drawn>> {
    if !TRIALS.contains(&trials) {
        return Err(Malformed::new(Fault::Value, "this many Monte Carlo trials cannot be drawn")
            .expected(format!("{} to {}", TRIALS.start(), TRIALS.end()))
            .found(trials.to_string()));
    }
    if !fit.noise.determined {
        return Ok(None);
    }
    let campaign = &fit.campaign;
    let mut point = fit.point.clone();
    let mut bounds = None;
    if let super::Constraints::Met { free, along, .. } = &fit.constraints {
        point.iter_mut().zip(free).for_each(|(x, free)| *x = *free);
        let inequalities = Rules::at(campaign, &vec![0.0; point.len()]).inequalities;
        bounds = Some(Bounds { along: along.clone(), inequalities });
    }
    let scatter = fit.noise.scatter();
    let indices: Vec<usize> = fit.known_sensitivities.iter().map(|(parameter, ..)| *parameter).collect();
    let correlation = if campaign.correlations.is_empty() { Vec::new() } else { campaign.correlation_root(&indices) };
    let known = fit
        .known_sensitivities
        .iter()
        .map(|(parameter, known, c)| KnownInput { parameter: *parameter, known: *known, sensitivity: c.clone() })
        .collect();
    let (mut names, mut outputs, mut first_order) = (Vec::new(), Vec::new(), Vec::new());
    for (k, result) in fit.parameters.iter().enumerate() {
        let Some(combined) = result.uncertainty else { continue };
        names.push(result.id.clone());
        outputs.push(Output::Parameter(k));
        first_order.push((result.interval, combined.u));
    }
    let parameters = names.len();
    let ids: Vec<&str> = campaign.parameters.iter().map(|p| p.id.as_str()).collect();
    for (quantity, result) in campaign.derived.iter().zip(&fit.derived) {
        let (Some(_), Some(combined)) = (result.value, result.uncertainty) else { continue };
        names.push(result.id.clone());
        outputs.push(Output::Line(Tape::compile(&quantity.line, &ids)?));
        first_order.push((result.interval, combined.u));
    }
    if outputs.is_empty() {
        return Ok(None);
    }
    let model = Model { point, scatter, known, correlation, outputs, bounds };
    let Some(trials) = monte_carlo(&model, trials, seed, parameters, fit.settings.level, progress) else {
        return Ok(None);
    };
    let agrees = |((low, high), u): ((f64, f64), f64), ends: [(f64, f64); 2]| {
        let u = Some(u).filter(|u| *u > 0.0 && !trials.held)?;
        let digit = 10f64.powf(u.log10().floor() - 1.0);
        let within = |end: f64, (least, most): (f64, f64)| end >= least - 0.5 * digit && end <= most + 0.5 * digit;
        Some(within(low, ends[0]) && within(high, ends[1]))
    };
    let output = |((id, law), (first, u)): ((&String, &Propagated), (Option<(f64, f64)>, f64))| DrawnOutput {
        id: id.clone(),
        mean: law.mean,
        u: law.sd,
        interval: law.symmetric.into(),
        shortest: law.shortest.into(),
        first_order: first.map(<[f64; 2]>::from),
        first_order_agrees: first.and_then(|first| agrees((first, u), law.ends)),
    };
    let outputs = names.iter().zip(&trials.outputs).zip(first_order).map(output).collect();
    let several = names.len() - parameters >= 2;
    let which = if several { parameters..names.len() } else { 0..parameters };
    let (from, count) = (which.start, which.len());
    let joint = (count >= 2).then(|| Joint {
        names: names.iter().skip(from).take(count).cloned().collect(),
        covariance: (trials.covariance.iter().skip(from).take(count))
            .map(|row| row.iter().skip(from).take(count).copied().collect())
            .collect(),
        ellipsoid_factor: trials.ellipsoid_factor,
    });
    let (asked, seed, held) = (trials.asked, trials.seed, trials.held);
    Ok(Some(Drawn { trials: trials.trials, asked, seed, held, outputs, joint }))
}
