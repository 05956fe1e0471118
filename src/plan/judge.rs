//! How well a schedule will do, before anyone measures.
//!
//! Rows need no readings, so the covariance, the leverages and the detectable faults are known beforehand. What scatters enters as one more
//! unknown for each deviation, with a row that says "0 with this standard deviation": readings of one mounting, or level, share it.

use super::derived::PredictedDerived;
use super::derived::derived;
use super::deviations::links;
use super::effort::{Costs, Noise, Work, planned, times};
use super::independent::Independent;
use super::known::{ThroughTilts, contributions};
use super::point::{self, Lacking};
use crate::campaign::{Campaign, Constraint, Deviating, Kind, Reading};
use crate::design::{self, DesignMatrix, Model, RowOrigin};
use crate::elements::Elements;
use crate::error::{Fault, Malformed, Result};
use crate::estimate;
use crate::fit::{self, RankDefect};
use crate::quality;
use faer::Mat;

/// Prediction for one estimated parameter.
#[derive(Debug, Clone, PartialEq)]
pub struct Predicted {
    /// Its name.
    pub id: String,
    /// Tilt or coefficient.
    pub kind: Kind,
    /// Unit of `u`.
    pub unit: String,
    /// Standard uncertainty from noise, scatter and known inputs; `None` where it is not estimable.
    pub u: Option<f64>,
    /// The part from noise and remounting scatter.
    pub from_readings: Option<f64>,
    /// The part from known inputs.
    pub from_known: f64,
}

/// Prediction for one value of the schedule.
#[derive(Debug, Clone, PartialEq)]
pub struct PredictedReading {
    /// Which reading and sensor.
    pub origin: RowOrigin,
    /// Standard uncertainty that was assumed.
    pub u: f64,
    /// Diagonal of the hat matrix.
    pub leverage: f64,
    /// Minimal detectable bias; `None` where no other reading checks this one.
    pub mdb: Option<f64>,
    /// What a bias of that size, undetected, does to each estimated parameter.
    pub effect: Vec<f64>,
}

/// How well a schedule will do.
#[derive(Debug, Clone)]
pub struct Judgement {
    /// Estimated parameters, in campaign order.
    pub parameters: Vec<Predicted>,
    /// Derived quantities.
    pub derived: Vec<PredictedDerived>,
    /// Covariance of the estimated parameters, known inputs included.
    pub covariance: Mat<f64>,
    /// Each value of the schedule.
    pub readings: Vec<PredictedReading>,
    /// What only combinations determine, wherever the parameters lie, and the position that would separate it.
    pub not_estimable: Vec<RankDefect>,
    /// What cannot be told at this point though it could nearby: a value is lacking.
    pub lacking: Option<Lacking>,
    /// Inequalities of the campaign: a bound lowers an uncertainty only where it is reached, so they are not counted.
    pub bounds: usize,
    /// Independent columns among the estimated parameters.
    pub rank: usize,
    /// Values minus rank.
    pub dof: usize,
    /// Condition number of the scaled rows.
    pub condition: Option<f64>,
    /// Readings, mountings, costs.
    pub work: Work,
    /// Largest effect of a drift of one noise standard deviation over the whole run, linear in the time that the work takes, as a share of a
    /// parameter's uncertainty.
    pub drift: Option<f64>,
    /// What known inputs do through the tilts, whose size a plan does not know; `None` where they do nothing.
    pub through_tilts: Option<ThroughTilts>,
}

impl Judgement {
    /// Correlation of two estimated parameters; `None` where one is not estimable.
    pub fn correlation(&self, i: usize, j: usize) -> Option<f64> {
        let inside = i < self.covariance.nrows() && j < self.covariance.nrows();
        let product = if inside { self.covariance[(i, i)] * self.covariance[(j, j)] } else { 0.0 };
        (product > 0.0).then(|| (self.covariance[(i, j)] / product.sqrt()).clamp(-1.0, 1.0))
    }

    /// The largest predicted standard uncertainty of an angle, in radians; `None` where an angle is not estimable or there is none.
    pub fn largest_angle_u(&self) -> Option<f64> {
        let tilts: Option<Vec<f64>> = self.parameters.iter().filter(|p| p.kind == Kind::Tilt).map(|p| p.u).collect();
        tilts?.into_iter().reduce(f64::max)
    }
}

/// Judge a schedule (or the positions of a campaign; its values play no part) at its reference point; [`super::judged_at`] sets that.
///
/// `cov x = (A' V^-1 A)^-1`, `V = diag(u^2) + sum over mountings s^2 g g'` with `g = d reading / d scattering tilt`; known inputs add
/// `u^2 E[c c']` with `c = -A^+ d f / d known` over tilts of the size that [`Noise::tilts`] states. Angles in radians. Errors: nothing to estimate, no readings, a column that a reading lacks.
///
/// ```
/// use tumble::{plan, wire};
/// let text = r#"{ "bench": { "id": "line", "sensors": { "y": { "model": "a + b*x" } } },
///     "estimate": { "a": {}, "b": {} }, "readings": [ { "x": [-1, 0, 1] } ] }"#;
/// let source = wire::Source { name: "line".into(), text: text.into() };
/// let schedule = wire::read_campaign(&source, &mut |_| unreachable!())?;
/// let noise = plan::Noise::new(&schedule, &[("y".into(), 0.3)], &[])?;
/// let judgement = plan::judge(&schedule, &noise, &plan::Costs::default())?;
/// assert!((judgement.parameters[1].u.unwrap() - 0.3 / 2f64.sqrt()).abs() < 1e-15);
/// # Ok::<(), tumble::error::Malformed>(())
/// ```
pub fn judge(campaign: &Campaign, noise: &Noise, costs: &Costs) -> Result<Judgement> {
    check_question(campaign)?;
    let model = Model::new(campaign)?;
    let design = design::assemble(campaign, &model, &campaign.reference_point())?;
    let independent = Independent::new(campaign, &design, noise);
    let estimate = independent.adjust(campaign, &design)?;
    let nearby = point::lacking(campaign, &model, &estimate, noise)?;
    let n = campaign.unknowns();
    let sensitivities = independent.sensitivities(&estimate);
    let (redundancies, u) = (independent.redundancies(&estimate), &independent.u);
    let (known, through_tilts) = contributions(campaign, &model, &design, (&independent, &estimate), noise)?;
    let mut covariance = Mat::from_fn(n, n, |i, j| estimate.unknowns.covariance[(i, j)]);
    for c in &known {
        for (i, a) in c.iter().enumerate().take(n) {
            for (j, b) in c.iter().enumerate().take(n) {
                covariance[(i, j)] += a * b;
            }
        }
    }
    let estimable = |k: usize| estimate.unknowns.is_estimable(k);
    let parameters: Vec<Predicted> = campaign
        .estimated()
        .iter()
        .enumerate()
        .map(|(k, parameter)| Predicted {
            id: parameter.id.clone(),
            kind: parameter.kind,
            unit: parameter.unit.clone(),
            u: estimable(k).then(|| covariance[(k, k)].sqrt()),
            from_readings: estimable(k).then(|| estimate.unknowns.covariance[(k, k)].sqrt()),
            from_known: known.iter().filter_map(|c| c.get(k)).map(|c| c * c).sum::<f64>().sqrt(),
        })
        .collect();
    let rows = &campaign.readings.rows;
    let determined: Vec<(usize, f64)> =
        parameters.iter().enumerate().filter_map(|(k, p)| Some((k, p.u.filter(|u| *u > 0.0)?))).collect();
    let delta = quality::baarda_delta();
    let readings = design
        .rows
        .iter()
        .enumerate()
        .map(|(i, origin)| {
            let at = |list: &[f64]| list.at(i);
            let (u, redundancy) = (at(u), at(&redundancies));
            let leverage = 1.0 - redundancy;
            let mdb = (redundancy > quality::UNCHECKED).then(|| delta * u / redundancy.sqrt());
            // an unchecked reading: reported without effects
            let effect = (0..n).map(|k| sensitivities[(k, i)] * mdb.unwrap_or_default()).collect();
            PredictedReading { origin: *origin, u, leverage, mdb, effect }
        })
        .collect();
    let rank = estimate.unknowns.rank;
    Ok(Judgement {
        derived: derived(campaign, &design, &covariance, &estimate)?,
        not_estimable: match &nearby {
            None => fit::separations(campaign, &model, &design, &estimate, &[]),
            Some((_, design, estimate)) => fit::separations(campaign, &model, design, estimate, &[]),
        },
        lacking: nearby.map(|(lacking, ..)| lacking),
        bounds: campaign
            .constraints
            .iter()
            .filter(|c| !matches!(c, Constraint::Linear { lower, upper, .. } if lower == upper))
            .count(),
        drift: drift(&design, u, &sensitivities, &determined, rows, costs),
        parameters,
        covariance,
        readings,
        rank,
        dof: design.rows.len().saturating_sub(rank),
        condition: estimate.unknowns.condition,
        work: costs.work(&campaign.readings.rows),
        through_tilts,
    })
}

/// A schedule whose readings are all taken so many times, on the same days, by the same operators: what positions share does not average out. `None`
/// where they share nothing, so that every `u` falls by the root, and where it cannot be judged.
pub(crate) fn repeated(campaign: &Campaign, noise: &Noise, times: f64, costs: &Costs) -> Option<Judgement> {
    let shares = |k: usize| links(campaign, k) && noise.lines.get(k).is_some_and(|variance| *variance > 0.0);
    if !(0..campaign.scatter.len()).any(shares) || !(times > 0.0) {
        return None;
    }
    let by = times.recip().sqrt();
    let mut readings = planned(campaign, &campaign.readings);
    for row in &mut readings.rows {
        row.planned_u.iter_mut().for_each(|(_, u)| *u *= by);
        row.observations.iter_mut().filter_map(|own| own.u.as_mut()).for_each(|u| *u *= by);
    }
    let mut less = noise.clone();
    less.sensors.iter_mut().for_each(|own| own.sd *= by);
    less.remount.iter_mut().for_each(|(_, sd)| *sd *= by);
    for (k, variance) in less.lines.iter_mut().enumerate().filter(|(k, _)| !links(campaign, *k)) {
        *variance /=
            if matches!(campaign.scatter.get(k).map(|l| &l.of), Some(Deviating::Correlated(..))) { 1.0 } else { times };
    }
    judge(&campaign.with_readings(readings), &less, costs).ok()
}

pub(super) fn check_question(campaign: &Campaign) -> Result<()> {
    if campaign.unknowns() == 0 {
        return Err(Malformed::new(Fault::Missing, "nothing is to be estimated, so there is nothing to plan for")
            .expected("at least one parameter in \"estimate\", for example { \"V0\": {} }")
            .at_path("estimate"));
    }
    if let Some(which) = fit::contradicting_equations(campaign) {
        let places: Vec<String> = which.iter().map(|k| (k + 1).to_string()).collect();
        return Err(Malformed::new(
            Fault::Value,
            format!("the constraints {} contradict each other", places.join(", ")),
        )
        .expected("equations that some values satisfy")
        .at_path("constraints"));
    }
    if campaign.readings.rows.is_empty() {
        return Err(Malformed::new(Fault::Missing, "the schedule has no positions")
            .expected("at least one reading with the states of the joints; the rates to plan with are taken from there")
            .found("an empty list")
            .at_path("readings"));
    }
    Ok(())
}

/// For each reading its part in the shift of every estimable parameter by a drift of one standard deviation, as a share of the parameter's `u`.
pub(super) fn weighted_sensitivities(campaign: &Campaign, noise: &Noise) -> Result<Vec<Vec<f64>>> {
    let design = design::assemble(campaign, &Model::new(campaign)?, &campaign.reference_point())?;
    let independent = Independent::new(campaign, &design, noise);
    let settings = estimate::Settings { refinements: 0, ..estimate::Settings::default() };
    let estimate = fit::adjust_meeting_equations(campaign, &design.point, &independent.system, &settings)?;
    let sensitivities = independent.sensitivities(&estimate);
    let known: Vec<(usize, f64)> = (0..campaign.unknowns())
        .filter(|k| estimate.unknowns.is_estimable(*k))
        .map(|k| (k, estimate.unknowns.covariance[(k, k)].sqrt()))
        .filter(|(_, u)| *u > 0.0)
        .collect();
    Ok(parts(&design, &independent.u, &sensitivities, &known, campaign.readings.rows.len()))
}

fn parts(
    design: &DesignMatrix,
    u: &[f64],
    sensitivities: &Mat<f64>,
    known: &[(usize, f64)],
    readings: usize,
) -> Vec<Vec<f64>> {
    let mut parts = vec![vec![0.0; known.len()]; readings];
    for (i, origin) in design.rows.iter().enumerate() {
        let noise = u.at(i);
        if let Some(part) = parts.get_mut(origin.reading) {
            part.iter_mut().zip(known).for_each(|(sum, (k, u))| *sum += sensitivities[(*k, i)] * noise / u);
        }
    }
    parts
}

/// A reading drifts by one standard deviation from the first to the last, in proportion to the time that the work takes: the largest shift of a
/// parameter, as a share of its uncertainty.
fn drift(
    design: &DesignMatrix,
    u: &[f64],
    sensitivities: &Mat<f64>,
    known: &[(usize, f64)],
    rows: &[Reading],
    costs: &Costs,
) -> Option<f64> {
    let times = times(rows, costs);
    let (first, last) = (times.first()?, times.last().filter(|_| times.len() > 1)?);
    let mut shifts = vec![0.0; known.len()];
    for (i, origin) in design.rows.iter().enumerate() {
        let drifted = u.at(i) * ((times.at(origin.reading) - first) / (last - first) - 0.5);
        shifts.iter_mut().zip(known).for_each(|(sum, (k, u))| *sum += sensitivities[(*k, i)] * drifted / u);
    }
    shifts.into_iter().map(f64::abs).reduce(f64::max)
}
