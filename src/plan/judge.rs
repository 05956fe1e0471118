//! How well a schedule will do, before anyone measures.
//!
//! Rows need no readings, so the covariance, the leverages and the detectable faults are known beforehand. Random effects that readings of one mounting, or
//! level, share enter as one more unknown for each deviation, with the prior value 0 and its standard deviation.
//!
//! Predicted uncertainties of derived quantities.
//!
//! Known inputs: how their uncertainties reach the estimates, when nobody knows yet how large the tilts are.
//!
//! ```text
//! c(x) = -A^+ d f / d known  at the tilts x,    Type B covariance of the estimates: u^2 E[c c'] = u^2 (c0 c0' + sum_k g_k g_k')
//! g_k = [c(s_k e_k) - c(-s_k e_k)] / 2,         tilts independent, with expected sizes (standard deviations) s_k
//! ```
//!
//! At zero tilts a scale factor error moves no angle at all; at tilts of `x` it moves them by `x u(kI) / kI`. A fit knows `x`, a plan cannot:
//! the user states the size. Where it is not stated, that part is left out, and its value for an example size is reported.

use super::effort::{Costs, Noise, Work, planned, times};
use super::point::{self, Lacking};
use super::whitened::{Independent, links};
use crate::algebra::{Scratch, Tape};
use crate::campaign::{Campaign, Constraint, Derived, Deviating, Kind, Parameter, Role};
use crate::design::{DesignMatrix, Model, RowOrigin};
use crate::elements::{Elements, Parts};
use crate::error::{Fault, Malformed, Result};
use crate::estimate::Estimate;
use crate::fit::{self, RankDefect};
use crate::linear::form;
use crate::quality;
use crate::units::ARCSEC;
use faer::Mat;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Prediction for one parameter.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(rename = "PredictedReport")]
pub struct Predicted {
    /// Its name.
    pub id: String,
    /// `tilt` or `coefficient`.
    pub kind: Kind,
    /// Unit of `u`.
    pub unit: String,
    /// Predicted standard uncertainty, in `unit`; null where not estimable.
    pub u: Option<f64>,
    /// The same in arcseconds, for tilts.
    pub u_arcsec: Option<f64>,
    /// The part from noise and remounting, in `unit`.
    pub from_readings: Option<f64>,
    /// The part from known inputs, in `unit`.
    pub from_known: f64,
    /// The most that one bad value does to it, of a size that is just not detected, in `unit`; null where nothing checks any value.
    #[serde(default)]
    pub undetected_fault: Option<f64>,
    /// The same in arcseconds, for tilts.
    #[serde(default)]
    pub undetected_fault_arcsec: Option<f64>,
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
    /// What is not estimable at this point though it is nearby: a value is lacking.
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
    let here = Independent::at(campaign, &campaign.reference_point(), noise)?;
    let (design, independent, estimate) = &here;
    let nearby = point::lacking(campaign, estimate, noise)?;
    let n = campaign.unknowns();
    let sensitivities = independent.sensitivities(estimate);
    let (redundancies, u) = (independent.redundancies(estimate), &independent.u);
    let (known, through_tilts) = contributions(campaign, &here, noise)?;
    let mut covariance = Mat::from_fn(n, n, |i, j| estimate.unknowns.covariance[(i, j)]);
    for c in &known {
        for (i, a) in c.iter().enumerate().take(n) {
            for (j, b) in c.iter().enumerate().take(n) {
                covariance[(i, j)] += a * b;
            }
        }
    }
    let estimable = |k: usize| estimate.unknowns.is_estimable(k);
    let arcsec = |kind: Kind, value: Option<f64>| value.filter(|_| kind == Kind::Tilt).map(|value| value * ARCSEC);
    let delta = quality::baarda_delta();
    let readings: Vec<PredictedReading> = design
        .rows
        .iter()
        .enumerate()
        .map(|(i, origin)| {
            let (u, redundancy) = (u.at(i), redundancies.at(i));
            let leverage = 1.0 - redundancy;
            let mdb = (redundancy > quality::UNCHECKED).then(|| delta * u / redundancy.sqrt());
            // an unchecked reading has no effects
            let effect = (0..n).map(|k| sensitivities[(k, i)] * mdb.unwrap_or_default()).collect();
            PredictedReading { origin: *origin, u, leverage, mdb, effect }
        })
        .collect();
    let parameters: Vec<Predicted> = campaign
        .estimated()
        .iter()
        .enumerate()
        .map(|(k, parameter)| {
            let checked = readings.iter().filter(|reading| reading.mdb.is_some());
            let fault = checked.filter_map(|reading| reading.effect.get(k)).map(|e| e.abs()).reduce(f64::max);
            let u = estimable(k).then(|| covariance[(k, k)].sqrt());
            Predicted {
                id: parameter.id.clone(),
                kind: parameter.kind,
                unit: parameter.unit.clone(),
                u,
                u_arcsec: arcsec(parameter.kind, u),
                from_readings: estimable(k).then(|| estimate.unknowns.covariance[(k, k)].sqrt()),
                from_known: known.iter().filter_map(|c| c.get(k)).map(|c| c * c).sum::<f64>().sqrt(),
                undetected_fault: fault,
                undetected_fault_arcsec: arcsec(parameter.kind, fault),
            }
        })
        .collect();
    let rows = &campaign.readings.rows;
    let rank = estimate.unknowns.rank;
    Ok(Judgement {
        derived: derived(campaign, &covariance, estimate)?,
        not_estimable: {
            let (design, estimate) = nearby.as_ref().map_or((design, estimate), |(_, design, there)| (design, there));
            fit::separations(campaign, &Model::new(campaign)?, design, estimate, &[])
        },
        lacking: nearby.map(|(lacking, ..)| lacking),
        bounds: campaign
            .constraints
            .iter()
            .filter(|c| !matches!(c, Constraint::Linear { lower, upper, .. } if lower == upper))
            .count(),
        drift: {
            let parts = parts(campaign, &here, &sensitivities, &covariance);
            let is_seen = rows.len() > 1 && parts.first().is_some_and(|part| !part.is_empty());
            is_seen.then(|| shifts(&times(rows.iter(), costs), parts.iter().map(Vec::as_slice)).0)
        },
        parameters,
        covariance,
        readings,
        rank,
        dof: design.rows.len().saturating_sub(rank),
        condition: estimate.unknowns.condition(),
        work: costs.work(&campaign.readings.rows),
        through_tilts,
    })
}

/// A schedule whose readings are all taken so many times, on the same days, by the same operators: deviations that positions share do not average out. `None`
/// where they share none, so that every `u` is divided by the root, and where it cannot be judged.
pub(crate) fn repeated(campaign: &Campaign, noise: &Noise, times: f64, costs: &Costs) -> Option<Judgement> {
    let shares = |k: usize| links(campaign, k) && noise.lines.get(k).is_some_and(|variance| *variance > 0.0);
    if !(0..campaign.scatter.len()).any(shares) || !(times > 0.0) {
        return None;
    }
    let by = times.recip().sqrt();
    let mut readings = planned(campaign, &campaign.readings);
    for row in &mut readings.rows {
        row.planned_u.iter_mut().for_each(|(_, u)| *u *= by);
        row.observations.iter_mut().filter_map(|observation| observation.u.as_mut()).for_each(|u| *u *= by);
    }
    let mut less = noise.clone();
    less.sensors.iter_mut().for_each(|sensor| sensor.sd *= by);
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
    let here = Independent::at(campaign, &campaign.reference_point(), noise)?;
    Ok(parts(campaign, &here, &here.1.sensitivities(&here.2), &here.2.unknowns.covariance))
}

fn parts(
    campaign: &Campaign,
    (design, rows, estimate): &(DesignMatrix, Independent, Estimate),
    sensitivities: &Mat<f64>,
    covariance: &Mat<f64>,
) -> Vec<Vec<f64>> {
    let known = (0..campaign.unknowns()).filter(|k| estimate.unknowns.is_estimable(*k));
    let known: Vec<(usize, f64)> = known.map(|k| (k, covariance[(k, k)].sqrt())).filter(|(_, u)| *u > 0.0).collect();
    let mut parts = vec![vec![0.0; known.len()]; campaign.readings.rows.len()];
    for (i, origin) in design.rows.iter().enumerate() {
        let noise = rows.u.at(i);
        if let Some(part) = parts.get_mut(origin.reading) {
            part.iter_mut().zip(&known).for_each(|(sum, (k, u))| *sum += sensitivities[(*k, i)] * noise / u);
        }
    }
    parts
}

/// Readings drift by one standard deviation from the first to the last, in proportion to the time that the work takes, and by as much in a parabola:
/// the largest shift of a parameter by either, as a share of its uncertainty. `parts`: of each reading, in the order of the times.
pub(super) fn shifts<'a>(times: &[f64], parts: impl Iterator<Item = &'a [f64]>) -> (f64, f64) {
    let (first, last) = match (times.first(), times.last()) {
        (Some(first), Some(last)) if last > first => (*first, *last),
        _ => return (0.0, 0.0),
    };
    let (mut linear, mut quadratic): (Vec<f64>, Vec<f64>) = (Vec::new(), Vec::new());
    for (time, row) in times.iter().zip(parts) {
        let t = (time - first) / (last - first) - 0.5;
        linear.resize(row.len().max(linear.len()), 0.0);
        quadratic.resize(linear.len(), 0.0);
        for ((l, q), part) in linear.iter_mut().zip(&mut quadratic).zip(row) {
            *l += part * t;
            *q += part * (2.0 * t * t - 0.5);
        }
    }
    let most = |list: &[f64]| list.iter().fold(0.0_f64, |most, v| most.max(v.abs()));
    (most(&linear), most(&quadratic))
}

/// Prediction for one derived quantity.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(rename = "PredictedDerivedReport")]
pub struct PredictedDerived {
    /// Its name.
    pub id: String,
    /// Its line of algebra.
    pub line: String,
    /// Its unit, as asked for or as the line has it; absent where a parameter in it has none.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub unit: String,
    /// Predicted standard uncertainty, in `unit`; null where not estimable, or where it depends on values that are not known.
    pub u: Option<f64>,
    /// The same in arcseconds, for angles.
    pub u_arcsec: Option<f64>,
    /// It has no derivative at the reference point, and this is the largest close by.
    pub is_largest: bool,
}

/// Derived quantities: `u^2 = g' C g`; where the gradient does not exist at the reference point, the largest over points close by.
fn derived(campaign: &Campaign, covariance: &Mat<f64>, estimate: &Estimate) -> Result<Vec<PredictedDerived>> {
    let of = |quantity: &Derived| -> Result<PredictedDerived> {
        let (slopes, is_here) = gradients(campaign, quantity)?;
        let u_of = |g: &Vec<f64>| -> Option<f64> {
            let usable = g.iter().enumerate().all(|(k, c)| *c == 0.0 || estimate.unknowns.is_estimable(k));
            let variance = form(covariance, g);
            (usable && variance.is_finite()).then(|| variance.max(0.0).sqrt())
        };
        // the uncertainty of the azimuth of a vector of zero length is not defined
        let is_defined = is_here || quantity.line.as_azimuth().is_none();
        let u = slopes.iter().filter(|_| is_defined).filter_map(u_of).reduce(f64::max);
        Ok(PredictedDerived {
            id: quantity.id.clone(),
            line: quantity.line.to_string(),
            unit: quantity.unit.clone(),
            u,
            u_arcsec: u.filter(|_| is_angle(campaign, &quantity.id)).map(|u| u * ARCSEC),
            is_largest: u.is_some() && !is_here,
        })
    };
    campaign.derived.iter().map(of).collect()
}

/// Distance of the points close by.
const STEP: f64 = 1e-4;

/// Points so close to one at which a quantity has no derivative: all round in the plane of each two of its parameters.
fn nearby(campaign: &Campaign, quantity: &Derived, point: &[f64], step: f64) -> Vec<Vec<f64>> {
    // opposite directions have opposite gradients
    const DIRECTIONS: u32 = 32;
    let n = campaign.unknowns();
    let names = quantity.line.names();
    let used: Vec<usize> = names.iter().filter_map(|name| campaign.parameter_index(name)).filter(|k| *k < n).collect();
    let moved = |along: &[(usize, f64)]| {
        let mut there = point.to_vec();
        for (k, step) in along {
            if let Some(slot) = there.get_mut(*k) {
                *slot += step;
            }
        }
        there
    };
    if let [only] = used.as_slice() {
        return vec![moved(&[(*only, step)]), moved(&[(*only, -step)])];
    }
    let mut points = Vec::new();
    for (p, first) in used.iter().enumerate() {
        for second in used.part(p + 1..) {
            for direction in 0..DIRECTIONS {
                let (sin, cos) = (std::f64::consts::PI * f64::from(direction) / f64::from(DIRECTIONS)).sin_cos();
                points.push(moved(&[(*first, step * cos), (*second, step * sin)]));
            }
        }
    }
    points
}

/// Gradients of a derived quantity by the estimated parameters: one at the reference point (and that it is), or those of points nearby where it has none
/// there. Empty where it has none at all, or where they grow without a bound (`V0/K` at `K = 0`). Errors: a line that does not compile.
pub(crate) fn gradients(campaign: &Campaign, quantity: &Derived) -> Result<(Vec<Vec<f64>>, bool)> {
    let ids: Vec<&str> = campaign.parameters.iter().map(|p| p.id.as_str()).collect();
    let tape = Tape::compile(&quantity.line, &ids)?;
    let mut scratch = Scratch::default();
    let mut at = |point: &[f64]| {
        let mut gradient = vec![0.0; ids.len()];
        tape.gradient(point, &mut scratch, &mut gradient);
        gradient.truncate(campaign.unknowns());
        (gradient.iter().all(|g| g.is_finite()) && gradient.iter().any(|g| *g != 0.0)).then_some(gradient)
    };
    let point = campaign.reference_point();
    Ok(match at(&point) {
        Some(gradient) => (vec![gradient], true),
        None => {
            let mut around = |step: f64| -> Vec<Vec<f64>> {
                nearby(campaign, quantity, &point, step).iter().filter_map(|point| at(point)).collect()
            };
            let largest = |all: &[Vec<f64>]| all.iter().flatten().fold(0.0_f64, |most, g| most.max(g.abs()));
            let (close, closer) = (around(STEP), around(0.1 * STEP));
            // at a tenth of the distance bounded gradients are as large, those that grow as its reciprocal are tenfold
            let bounded = largest(&closer) < 2.0 * largest(&close);
            (if bounded { close } else { Vec::new() }, false)
        }
    })
}

/// Is a parameter or derived quantity an angle without another unit? Limits and uncertainties of it are in radians then.
pub fn is_angle(campaign: &Campaign, id: &str) -> bool {
    let tilt = |name: &str| {
        let parameter = campaign.parameter_index(name).and_then(|k| campaign.parameters.get(k));
        parameter.is_some_and(|p| p.kind == Kind::Tilt)
    };
    let quantity = campaign.derived.iter().find(|d| d.id == id);
    // a requested unit is a factor of the line
    let in_radians = |quantity: &Derived| {
        matches!(quantity.unit.as_str(), "" | "rad")
            && quantity.line.angle_degree(&|name: &str| tilt(name).then_some(1.0)) == Some(1.0)
    };
    tilt(id) || quantity.is_some_and(in_radians)
}

/// Example size for which the part that was left out is reported: 100 arcsec.
const FOR_EXAMPLE: f64 = 100.0 * std::f64::consts::PI / 648_000.0;

/// What a known input's uncertainty does through the tilts.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[schemars(rename = "ThroughTiltsReport")]
pub struct ThroughTilts {
    /// Size of the tilts in arcseconds: as stated, or an example.
    pub tilts_arcsec: f64,
    /// Is it counted in the predicted uncertainties? Only where the size was stated.
    pub counted: bool,
    /// The known input that matters most.
    pub known: String,
    /// The parameter that it moves most.
    pub parameter: String,
    /// Standard uncertainty from it, in the parameter's unit.
    pub u: f64,
    /// The same in arcseconds, for tilts.
    pub u_arcsec: Option<f64>,
}

/// For each known input, `u c` at the reference point and `u g_k` for each tilt of stated size; and what was left out or added.
fn contributions(
    campaign: &Campaign,
    here: &(DesignMatrix, Independent, Estimate),
    noise: &Noise,
) -> Result<(Vec<Vec<f64>>, Option<ThroughTilts>)> {
    let known: Vec<(usize, f64)> = campaign.uncertain().map(|(k, known)| (k, known.u)).collect();
    let root = campaign.correlation_root(&known.iter().map(|(k, _)| *k).collect::<Vec<usize>>());
    // correlated inputs as independent ones: sum of r_ij p_i p_j' = sum of (sum L_ik p_i)(...)'
    let independent = |parts: Vec<Vec<f64>>| -> Vec<Vec<f64>> {
        let unknowns = parts.first().map_or(0, Vec::len);
        let mut mixed = vec![vec![0.0; unknowns]; parts.len()];
        for (part, row) in parts.iter().zip(&root) {
            for (sum, share) in mixed.iter_mut().zip(row) {
                sum.iter_mut().zip(part).for_each(|(sum, p)| *sum += share * p);
            }
        }
        mixed
    };
    let mut parts: Vec<Vec<f64>> = independent(sensitivities(campaign, here, &known)?);
    let tilts: Vec<(usize, Option<f64>)> = campaign
        .estimated()
        .iter()
        .enumerate()
        .filter(|(_, p)| p.kind == Kind::Tilt && !known.is_empty())
        .filter_map(|(k, p)| Some((k, expected_size(p, noise.tilts)?)))
        .collect();
    let (design, _, estimate) = here;
    let unstated = tilts.iter().any(|(_, size)| size.is_none());
    let mut squares = vec![vec![0.0; campaign.unknowns()]; known.len()];
    for (tilt, size) in &tilts {
        let step = size.unwrap_or(FOR_EXAMPLE);
        let at = |sign: f64| -> Result<Vec<Vec<f64>>> {
            let mut point = design.point.clone();
            if let Some(value) = point.get_mut(*tilt) {
                *value += sign * step;
            }
            sensitivities(campaign, &Independent::at(campaign, &point, noise)?, &known).map(&independent)
        };
        for ((plus, minus), squares) in at(1.0)?.into_iter().zip(at(-1.0)?).zip(&mut squares) {
            let half: Vec<f64> = plus.iter().zip(&minus).map(|(p, m)| 0.5 * (p - m)).collect();
            squares.iter_mut().zip(&half).for_each(|(s, g)| *s += g * g);
            if size.is_some() {
                parts.push(half);
            }
        }
    }
    let share = |(_, k, u): &(usize, usize, f64)| {
        let u_of_readings = estimate.unknowns.covariance[(*k, *k)].sqrt();
        if u_of_readings > 0.0 && estimate.unknowns.is_estimable(*k) { u / u_of_readings } else { 0.0 }
    };
    let all =
        squares.iter().zip(&known).flat_map(|(s, (p, _))| s.iter().enumerate().map(move |(k, s)| (*p, k, s.sqrt())));
    let strongest = all.reduce(|best, next| if share(&best) >= share(&next) { best } else { next });
    let through = strongest.filter(|most| share(most) > 1e-6).map(|(p, k, u)| ThroughTilts {
        // the report says that it is an example
        tilts_arcsec: ARCSEC * if unstated { FOR_EXAMPLE } else { noise.tilts.unwrap_or(FOR_EXAMPLE) },
        counted: !unstated,
        known: campaign.parameter_id(p).to_string(),
        parameter: campaign.parameter_id(k).to_string(),
        u,
        u_arcsec: campaign.parameters.get(k).filter(|p| p.kind == Kind::Tilt).map(|_| u * ARCSEC),
    });
    Ok((parts, through))
}

/// The expected size of a tilt: from its prior, else as the user states it. `None` for one with a start value, which is known well enough.
fn expected_size(parameter: &Parameter, stated: Option<f64>) -> Option<Option<f64>> {
    match &parameter.role {
        Role::Estimated { start: Some(_), .. } => None,
        Role::Estimated { prior: Some(prior), .. } => Some(Some(prior.u)),
        _ => Some(stated),
    }
}

/// For each known input, its uncertainty times the sensitivities of the estimates, `-A^+ df/dp`.
fn sensitivities(
    campaign: &Campaign,
    (design, rows, estimate): &(DesignMatrix, Independent, Estimate),
    known: &[(usize, f64)],
) -> Result<Vec<Vec<f64>>> {
    known
        .iter()
        .map(|(k, u)| {
            let mut shift: Vec<f64> = (0..design.rows.len()).map(|i| -design.jacobian[(i, *k)] * u).collect();
            shift.resize(rows.u.len(), 0.0);
            let mut c = estimate.factor.solve(&rows.column(shift))?;
            c.truncate(campaign.unknowns());
            Ok(c)
        })
        .collect()
}
