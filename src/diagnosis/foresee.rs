//! What a diagnosis could find on a schedule, before anyone measures.
//!
//! ```text
//! c' = c - Q Q'c,   u = 1 / |c'|           c: an effect's column for coefficient 1, Q: the basis of the model, both weighted
//! smallest effect that shows:              delta u,    delta = m + z(power) sqrt(1 + s^2)
//! smallest that is not taken for another:  x u / sqrt(1 - r^2),  x^2 - 2 z(power) x = 9,  r the cosine of the two c'
//! ```
//!
//! `m` is the `t` from which `diagnose` names an effect, and `s` its standard deviation over readings of noise: its class then has the probability
//! that a name needs against nothing, every other effect and every remainder of the bank, by the score that decides there ([`super::score`]).
//! 9 is the difference of the sums of squares, in noise variances, at which it drops a rival: with the size a of the effect in units of u that
//! difference has the mean `(1 - r^2) a^2` and twice the root of that as its standard deviation, so that both smallest sizes are those of one power.
//! Where only residuals tell the noise, `delta` is that of Student's t. One bad reading is not among the effects: its minimal detectable bias
//! stands in the judgement of the schedule.

use super::bank::bank;
use super::catalogue::{Effect, ORDER, carried};
use super::score::{ALIAS, Priors, Problem, Score};
use super::{Candidate, Settings, augmented, averaged, candidates, screen};
use crate::campaign::{Campaign, JointState, Kind, Reading, Readings, Role};
use crate::design::{self, DesignMatrix, Model};
use crate::elements::Elements;
use crate::error::Result;
use crate::estimate;
use crate::plan::{Independent, Noise};
use crate::simulate::Regressor;
use crate::uncertainty::quantiles::{normal_quantile, normal_survival, student_t_quantile};
use crate::vocabulary::vocabulary;
use faer::Mat;
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::{Pcg64Mcg, rand_core::SeedableRng};
use std::collections::HashMap;

/// The rule behind every smallest size: `minimal = noncentrality u`.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[schemars(rename = "RuleReport")]
pub struct Rule {
    /// Probability of naming anything when nothing is missing, over all tests.
    pub significance: f64,
    /// Probability of seeing an effect of the smallest size.
    pub power: f64,
    /// Distinct directions: tests that are made.
    pub tests: usize,
    /// `z(1 - a/2) + z(power)` with `a` the level of one test (Sidak), a pure number; the noise is known.
    pub noncentrality: f64,
    /// The same if the noise is known from the residuals only; null with too few degrees of freedom.
    pub with_residuals: Option<f64>,
}

impl Rule {
    /// Size of an effect, in units of its standard uncertainty, that is found with this power, the noise being known.
    pub(crate) fn size_for(&self, power: f64) -> f64 {
        self.noncentrality - z(self.power) + z(power)
    }
}

vocabulary! {
    /// What becomes of an effect on this schedule.
    Fate {
        /// It shows from its smallest size on.
        Detectable = "detectable",
        /// The estimated parameters take it up: it shifts them and leaves no residuals.
        Absorbed = "absorbed",
        /// Its term is zero at every position of the schedule.
        NotExercised = "not-exercised",
    }
}

/// One effect on a schedule.
#[derive(Debug, Clone)]
pub struct Prospect {
    /// The effect, with its column at the schedule's rows.
    pub effect: Candidate,
    /// Unit of its coefficient; empty where the model line does not tell.
    pub unit: String,
    /// What becomes of it.
    pub fate: Fate,
    /// Share of its weighted column that the model leaves.
    pub left: f64,
    /// Standard uncertainty of its coefficient, if it were estimated beside the others; `None` unless it is detectable.
    pub u: Option<f64>,
    /// Smallest size that shows.
    pub minimal: Option<f64>,
    /// The most that an effect of this size changes one value, in the sensor's unit, and in standard uncertainties of that value.
    pub at_a_reading: Option<(f64, f64)>,
    /// Shift of each estimated parameter for coefficient 1, while the effect is not in the model.
    pub shifts: Vec<f64>,
    /// Parameters that take part in hiding an absorbed effect, the strongest first.
    pub hides_in: Vec<usize>,
    /// The parameter that an effect of the smallest size shifts most against its u, and that ratio.
    pub moves: Option<(usize, f64)>,
    /// Its group of effects with one direction, by index; `None` unless it is detectable.
    pub group: Option<usize>,
}

/// Two groups that are easily taken for each other.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
pub struct Near {
    /// The other group, from 0.
    pub group: usize,
    /// Cosine of the angle between the two after projection on the model, -1 to 1.
    pub cosine: f64,
    /// Size of the first effect of this group from which it is not taken for the other, in its coefficient's unit.
    pub apart_from: f64,
}

/// A family of effects that was passed over.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[schemars(rename = "PassedOverReport")]
pub struct PassedOver {
    /// Its name.
    pub name: String,
    /// Columns that the schedule lacks.
    pub needs: Vec<String>,
}

/// Effects whose columns have one direction beside the model: nothing on this schedule tells them apart.
#[derive(Debug, Clone, PartialEq)]
pub struct Alike {
    /// Effects, by index, the plainest first.
    pub members: Vec<usize>,
    /// Groups for which an effect of the smallest size could be taken, nearest first.
    pub near: Vec<Near>,
}

/// All effects of a catalogue on a schedule.
#[derive(Debug, Clone)]
pub struct Foresight {
    /// The rule behind every smallest size.
    pub rule: Rule,
    /// Every effect.
    pub prospects: Vec<Prospect>,
    /// Groups that nothing tells apart; most have one member.
    pub groups: Vec<Alike>,
    /// Families that were passed over, with the columns that the schedule lacks for them.
    pub passed_over: Vec<PassedOver>,
}

/// Simulated noise readings at which the score is evaluated: their mean scatters by a fifth of what one of them does.
const DRAWS: usize = 24;
/// Power of the smallest sizes.
const POWER: f64 = 0.8;
/// A column this small against its size at general positions and small tilts is zero but for rounding.
const ZERO: f64 = 1e-9;
/// Cosines this near to 1 are one direction.
const ONE_DIRECTION: f64 = 1e-6;
/// Means of terms with kinks have no more than four digits: less than this share left of them is error of the mean.
const ROUGH: f64 = 1e-3;
/// A parameter that takes up less than this share of an absorbed effect is not named.
const TAKES_PART: f64 = 0.01;

/// Which effects of a catalogue a schedule could show, which the model would absorb, and which would be taken for each other.
///
/// Linear in the effects, at the campaign's reference point. Errors: those of `plan::judge`; a catalogue's term with a name that this campaign
/// does not have.
pub fn foresee(campaign: &Campaign, catalogue: &[Effect], noise: &Noise) -> Result<Foresight> {
    let Directions { mut prospects, mut groups, beside, weighted, design, independent, estimate, tests } =
        directions(campaign, catalogue, noise)?;
    let rows = independent.u.len();
    let settings = Settings::default();
    let priors = Priors::at(settings.significance).for_sensors(campaign.bench.sensors.len());
    let zeros = vec![0.0; rows];
    // longer records are averaged before they are diagnosed
    let kernels = if rows <= averaged::LONG { bank(campaign, &design, &independent) } else { Vec::new() };
    let mut odds = augmented::odds(prospects.iter().map(|prospect| &prospect.effect), &priors, |_| 1.0);
    let noise = prospects.len()..prospects.len() + DRAWS;
    odds.resize(noise.end, f64::NEG_INFINITY);
    let mut generator = Pcg64Mcg::seed_from_u64(0);
    let columns = Mat::from_fn(rows, noise.end, |i, j| match j.checked_sub(noise.start) {
        None => weighted[(i, j)],
        Some(_) => StandardNormal.sample(&mut generator),
    });
    let problem = Problem {
        residual: &zeros,
        basis: estimate.factor.thin_q(),
        columns: columns.as_ref(),
        prior: &odds,
        plain: &vec![f64::INFINITY; noise.end],
        fixed: &[],
        kinds: &[],
        known: true,
        kernels: &kernels,
        sharing: None,
    };
    let score = Score::new(&problem, priors);
    let first: Vec<usize> = groups.iter().filter_map(|group| group.members.first()).copied().collect();
    let of_groups = score.named_from(&first, noise, settings.probability);
    let seen = of_groups.iter().flatten().map(|(t, _)| *t);
    // the plainest of all; where a schedule shows none, one that competes with chance alone
    let usual = seen.reduce(f64::min).unwrap_or_else(|| priors.threshold(settings.probability));
    let rule = rule(tests.max(groups.len()).max(1), usual, estimate.dof);
    for prospect in &mut prospects {
        let named = prospect.group.and_then(|g| of_groups.get(g).copied().flatten());
        let Some((u, (t, sd))) = prospect.u.zip(named) else { continue };
        let minimal = (t + z(POWER) * sd.hypot(1.0)) * u;
        let values = prospect.effect.column.iter().zip(&independent.u).map(|(c, u)| (c.abs() * minimal, u));
        prospect.at_a_reading = values.map(|(c, u)| (c, c / u)).reduce(|a, b| if b.0 > a.0 { b } else { a });
        let sd = |k: usize| estimate.unknowns.covariance[(k, k)].sqrt();
        prospect.moves = (0..campaign.unknowns())
            .filter(|k| estimate.unknowns.is_estimable(*k) && sd(*k) > 0.0)
            .map(|k| (k, prospect.shifts.get(k).map_or(0.0, |s| (s * minimal / sd(k)).abs())))
            .reduce(|a, b| if b.1 > a.1 { b } else { a });
        prospect.minimal = Some(minimal);
    }
    for (g, group) in groups.iter_mut().enumerate() {
        let Some(&place) = first.get(g) else { continue };
        let Some(u) = prospects.get(place).and_then(|p| p.u) else { continue };
        group.near = first
            .iter()
            .enumerate()
            .filter(|(other, _)| *other != g)
            .map(|(other, member)| {
                let cosine = beside.cosines(place).at(*member);
                let apart_from = u * apart() / (1.0 - cosine * cosine).max(f64::MIN_POSITIVE).sqrt();
                Near { group: other, cosine, apart_from }
            })
            .filter(|near| prospects.get(place).and_then(|p| p.minimal).is_some_and(|m| near.apart_from > m))
            .collect();
        group.near.sort_by(|a, b| b.cosine.abs().total_cmp(&a.cosine.abs()));
    }
    // the order of the readings is that in which they will be taken
    let is_lacking = |name: &&String| *name != ORDER && !campaign.readings.columns.contains(name);
    let passed_over = catalogue.iter().filter_map(|effect| {
        let needs: Vec<String> = effect.needs.iter().filter(is_lacking).cloned().collect();
        (!needs.is_empty()).then(|| PassedOver { name: effect.name.clone(), needs })
    });
    let passed_over = passed_over.collect();
    Ok(Foresight { rule, prospects, groups, passed_over })
}

/// Effects of a catalogue as directions orthogonal to the model.
pub(crate) struct Directions {
    pub prospects: Vec<Prospect>,
    pub groups: Vec<Alike>,
    /// The effects beside the model.
    beside: Score,
    weighted: Mat<f64>,
    design: DesignMatrix,
    independent: Independent,
    estimate: estimate::Estimate,
    tests: usize,
}

/// What becomes of each effect of a catalogue on a schedule, and which have one direction; the sizes from which they are named are left open, for
/// they take most of the work.
///
/// Errors: as [`foresee`].
pub(crate) fn directions(campaign: &Campaign, catalogue: &[Effect], noise: &Noise) -> Result<Directions> {
    let model = Model::new(campaign)?;
    let point = campaign.reference_point();
    let design = design::assemble(campaign, &model, &point)?;
    let independent = Independent::new(campaign, &design, noise);
    let estimate = independent.adjust(campaign, &design)?;
    let (effects, tests) = effects(campaign, catalogue, &model, &design, noise)?;
    let rows = independent.u.len();
    let mut weighted = Mat::zeros(rows, effects.len());
    for (j, (effect, _)) in effects.iter().enumerate() {
        weighted.col_as_slice_mut(j).copy_from_slice(&independent.white(&effect.column));
    }
    let norm: Vec<f64> = (0..effects.len()).map(|j| weighted.col(j).norm_l2()).collect();
    let beside = Score::of_columns(weighted.as_ref(), estimate.factor.thin_q(), &vec![0.0; rows]);
    let mut prospects: Vec<Prospect> = Vec::with_capacity(effects.len());
    for (((effect, size), norm), left) in effects.into_iter().zip(norm).zip(&beside.visible) {
        let largest = effect.column.iter().fold(0.0_f64, |most, v| most.max(v.abs()));
        let fate = match () {
            () if largest <= ZERO * size => Fate::NotExercised,
            () if *left == 0.0 || (*left < ROUGH && has_kinks(&effect)) => Fate::Absorbed,
            () => Fate::Detectable,
        };
        let mut shifts =
            if fate == Fate::NotExercised { Vec::new() } else { shifts(&estimate, &effect, &independent)? };
        shifts.truncate(campaign.unknowns());
        let hides_in = if fate == Fate::Absorbed { hides_in(&estimate, &shifts) } else { Vec::new() };
        prospects.push(Prospect {
            unit: unit(campaign, &effect),
            u: (fate == Fate::Detectable).then(|| 1.0 / (norm * left)),
            left: if fate == Fate::NotExercised { 0.0 } else { *left },
            effect,
            fate,
            minimal: None,
            at_a_reading: None,
            shifts,
            hides_in,
            moves: None,
            group: None,
        });
    }
    let groups = alike(&beside, &mut prospects);
    Ok(Directions { prospects, groups, beside, weighted, design, independent, estimate, tests })
}

/// What is written of the rule: for one of so many tests, where `|t|` beyond this names an effect.
fn rule(tests: usize, named: f64, dof: usize) -> Rule {
    let nu = dof.saturating_sub(1) as f64;
    // the noncentral t by its normal approximation (M. Abramowitz, I. A. Stegun 1964, 26.7.10)
    // a size has a level
    let with_residuals = normal_survival(named)
        .and_then(|p| student_t_quantile(1.0 - p, nu))
        .filter(|_| nu >= 1.0)
        .map(|t| t * (1.0 - 0.25 / nu) + z(POWER) * (1.0 + 0.5 * t * t / nu).sqrt());
    let significance = Settings::default().significance;
    Rule { significance, power: POWER, tests, noncentrality: named + z(POWER), with_residuals }
}

fn z(p: f64) -> f64 {
    // probabilities between 0 and 1 have a quantile
    normal_quantile(p).unwrap_or(0.0)
}

/// What must remain of an effect given another one, in units of u, for the other to be dropped with the power of the rule.
fn apart() -> f64 {
    z(POWER) + (z(POWER).powi(2) + 2.0 * ALIAS).sqrt()
}

/// Change of every unknown when the effect, with coefficient 1, is in the readings and not in the model.
fn shifts(estimate: &estimate::Estimate, effect: &Candidate, independent: &Independent) -> Result<Vec<f64>> {
    let mut column = effect.column.clone();
    column.resize(independent.u.len(), 0.0);
    estimate.factor.solve(&independent.column(column))
}

/// Parameters by how much of the effect's column they take up.
fn hides_in(estimate: &estimate::Estimate, shifts: &[f64]) -> Vec<usize> {
    let scale = estimate.factor.scale();
    let mut parts: Vec<(f64, usize)> = shifts.iter().enumerate().map(|(k, s)| (s.abs() * scale.at(k), k)).collect();
    let most = parts.iter().fold(0.0_f64, |most, (part, _)| most.max(*part));
    parts.retain(|(part, _)| *part > TAKES_PART * most);
    parts.sort_by(|a, b| b.0.total_cmp(&a.0));
    parts.into_iter().map(|(_, k)| k).collect()
}

/// Effects with one direction, plainest first.
fn alike(beside: &Score, prospects: &mut [Prospect]) -> Vec<Alike> {
    let mut order: Vec<usize> =
        prospects.iter().enumerate().filter(|(_, p)| p.fate == Fate::Detectable).map(|(j, _)| j).collect();
    order.sort_by_key(|j| (prospects.get(*j).map(|p| p.effect.rank), *j));
    let mut groups: Vec<Alike> = Vec::new();
    for j in order {
        let cosine = |first: usize| beside.cosines(first).at(j);
        let same = |group: &Alike| group.members.first().is_some_and(|j| 1.0 - cosine(*j).abs() < ONE_DIRECTION);
        let group = groups.iter().position(same).unwrap_or(groups.len());
        match groups.get_mut(group) {
            Some(group) => group.members.push(j),
            None => groups.push(Alike { members: vec![j], near: Vec::new() }),
        }
        if let Some(prospect) = prospects.get_mut(j) {
            prospect.group = Some(group);
        }
    }
    groups
}

/// Unit of an effect's coefficient, from the model line with its term; empty for one of all sensors, and where the line leaves it open.
fn unit(campaign: &Campaign, effect: &Candidate) -> String {
    let own = effect.existing.map(|k| campaign.parameter_unit(k).to_string());
    own.or_else(|| effect.kind.unit(campaign, effect.sensor, &effect.coefficient)).unwrap_or_default()
}

fn has_kinks(effect: &Candidate) -> bool {
    matches!(&effect.kind, Regressor::Term(line) if !line.is_smooth_in(&|_| true))
}

/// Is the coefficient of this effect an angle?
pub fn is_angle(campaign: &Campaign, effect: &Candidate) -> bool {
    let tilt = |k: usize| campaign.parameters.get(k).is_some_and(|p| p.kind == Kind::Tilt);
    match &effect.kind {
        Regressor::Tilt(k) | Regressor::Known(k) => tilt(*k),
        _ => effect.existing.is_some_and(tilt),
    }
}

/// General positions that are considered in addition to the schedule.
const GENERAL: usize = 24;
/// Small tilts, radians: 100 arcsec.
const SMALL: f64 = 5e-4;

/// Every candidate with its column at the reference point and its size at small tilts; and how many directions a diagnosis would try.
///
/// What vanishes at zero tilts only is tried by a diagnosis all the same, because the fitted tilts are not zero.
pub(super) fn effects(
    campaign: &Campaign,
    catalogue: &[Effect],
    model: &Model,
    design: &DesignMatrix,
    noise: &Noise,
) -> Result<(Vec<(Candidate, f64)>, usize)> {
    let mut point = design.point.clone();
    for (k, (parameter, value)) in campaign.parameters.iter().zip(&mut point).enumerate() {
        if parameter.kind == Kind::Tilt && matches!(parameter.role, Role::Estimated { .. }) {
            *value += SMALL * (1.0 + 0.618_034 * k as f64).sin();
        }
    }
    let tilted = design::assemble(campaign, model, &point)?;
    let independent = Independent::new(campaign, &tilted, noise);
    let estimate = estimate::adjust(&independent.system, &estimate::Settings::default())?;
    let all = columns(campaign, catalogue, model, &tilted)?;
    let rows = independent.u.len();
    let mut matrix = Mat::zeros(rows, all.len());
    for (j, (effect, _)) in all.iter().enumerate() {
        matrix.col_as_slice_mut(j).copy_from_slice(&independent.white(&effect.column));
    }
    // distinct by their scores against numbers of no pattern
    let patternless: Vec<f64> = (0..rows).map(|i| (1.0 + 1.7 * i as f64).sin() + (0.3 * i as f64).cos()).collect();
    let tests = Score::of_columns(matrix.as_ref(), estimate.factor.thin_q(), &patternless).distinct();
    let mut here: HashMap<(String, Option<usize>), Vec<f64>> = columns(campaign, catalogue, model, design)?
        .into_iter()
        .map(|(effect, _)| ((effect.regressor, effect.sensor), effect.column))
        .collect();
    let effects = all.into_iter().map(|(mut effect, size)| {
        let none = vec![0.0; effect.column.len()];
        // what no reading shows has a column of zeros
        effect.column = here.remove(&(effect.regressor.clone(), effect.sensor)).unwrap_or(none);
        (effect, size)
    });
    Ok((effects.collect(), tests))
}

/// Every candidate with its column at the rows of the design, and its largest value there and at general positions.
fn columns(
    campaign: &Campaign,
    catalogue: &[Effect],
    model: &Model,
    design: &DesignMatrix,
) -> Result<Vec<(Candidate, f64)>> {
    let mut rows: Vec<Reading> = campaign.readings.rows.iter().map(Reading::unread).collect();
    rows.extend(general(campaign));
    let sensors = campaign.bench.sensors.len();
    let wide = campaign.with_readings(Readings { columns: campaign.readings.columns.clone(), rows });
    let all = design::assemble(&wide, model, &design.point)?;
    let built = candidates::build(
        &wide,
        catalogue,
        model,
        &all,
        all.rows.len(),
        &screen::chosen(&wide),
        &mut candidates::Kept::new(),
    )?;
    let keep = |mut candidate: Candidate| {
        let size = candidate.column.iter().fold(0.0_f64, |most, v| most.max(v.abs()));
        let at = |origin: &design::RowOrigin| candidate.column.get(origin.reading * sensors + origin.sensor);
        // columns were made for every sensor of every reading
        candidate.column = design.rows.iter().map(|o| at(o).copied().unwrap_or_default()).collect();
        (candidate, size)
    };
    // one bad reading has its detectable bias; a wrong prior or constraint is no effect of a position
    // a coefficient that is estimated hides nothing but itself
    let estimated = |c: &Candidate| {
        let of = |sensor: usize| {
            candidates::coefficient(campaign, sensor, &c.kind, |role| matches!(role, Role::Estimated { .. }))
        };
        match c.sensor {
            Some(sensor) => of(sensor).is_some(),
            None => (0..sensors).all(|sensor| of(sensor).is_some()),
        }
    };
    let other = |c: &Candidate| {
        let of_readings = matches!(c.kind, Regressor::Reading(_) | Regressor::Exchange(..));
        let assumed = matches!(c.kind, Regressor::Prior(_) | Regressor::Constraint(_));
        !of_readings && !assumed && is_carried(campaign, c) && !estimated(c)
    };
    Ok(built.into_iter().filter(other).map(keep).collect())
}

/// Is this a harmonic that the angles of the schedule can discriminate, or none at all?
fn is_carried(campaign: &Campaign, candidate: &Candidate) -> bool {
    candidate.harmonic == 0
        || campaign.bench.joints().enumerate().any(|(place, joint)| {
            candidate.regressor.contains(&format!("{joint})")) && candidate.harmonic <= carried(campaign, place)
        })
}

/// Positions at no special angles, with the rates of the schedule: a term that is zero there too is zero everywhere.
fn general(campaign: &Campaign) -> Vec<Reading> {
    let names: Vec<&str> = campaign.bench.joints().collect();
    let rows = &campaign.readings.rows;
    let states: Vec<Vec<JointState>> = (0..names.len())
        .map(|joint| {
            let mut seen: Vec<JointState> = Vec::new();
            for state in rows.iter().filter_map(|r| r.joints.get(joint)) {
                let held = matches!(state, JointState::Held { .. });
                if !seen.iter().any(|s| s == state || (held && matches!(s, JointState::Held { .. }))) {
                    seen.push(*state);
                }
            }
            seen
        })
        .collect();
    if names.is_empty() || rows.is_empty() {
        return Vec::new();
    }
    let mut general = Vec::with_capacity(GENERAL);
    for k in 0..GENERAL {
        let state = |(joint, options): (usize, &Vec<JointState>)| {
            // golden-ratio angles never repeat; the states of each joint are visited in order
            let angle_deg = 360.0 * ((k + 1) as f64 * 0.618_034 * (joint + 1) as f64 + 0.113).fract();
            match options.get((k / (joint + 1)) % options.len().max(1)) {
                None | Some(JointState::Held { .. }) => JointState::Held { angle_deg },
                Some(other) => *other,
            }
        };
        let joints: Vec<JointState> = states.iter().enumerate().map(state).collect();
        let Some(like) = rows.get(k % rows.len()) else { continue };
        let reading = campaign.readings.position(&names, like, joints);
        if Reading::check_turning(&reading.joints, &names).is_ok() {
            general.push(reading);
        }
    }
    general
}
