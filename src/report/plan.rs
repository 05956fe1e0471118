//! The report of a plan: how well a schedule will do, and the better one.

use super::separation::not_estimable;
use super::{ARCSEC, NotEstimableReport, PositionReport, VERSION, position_keys};
use crate::campaign::{Campaign, Kind};
use crate::plan::{Goal, Improvement, Judgement, Noise, Reached, Work};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// What `tumble plan --json` writes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct PlanReport {
    /// Version of the program.
    pub tumble: String,
    /// Always `plan`.
    pub report: String,
    /// Bench id.
    pub bench: String,
    /// Model line of each sensor.
    pub model: BTreeMap<String, String>,
    /// Noise of each sensor.
    pub noise: BTreeMap<String, SensorNoiseReport>,
    /// Parameters that every remounting scatters, with the standard deviation (radians for tilts).
    pub remount: BTreeMap<String, f64>,
    /// The schedule that was given.
    pub schedule: JudgementReport,
    /// The better schedule, if one was asked for.
    pub improved: Option<ImprovedReport>,
}

/// Noise of one sensor.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct SensorNoiseReport {
    /// Standard deviation of one reading.
    pub sd: f64,
    /// Its unit.
    pub unit: String,
    /// `given`, `stated` (in the readings) or `residuals` (of a fit to the readings).
    pub from: String,
}

/// How well a schedule will do.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct JudgementReport {
    /// Readings, mountings, rate changes, cost.
    pub work: WorkReport,
    /// Independent combinations of the estimated parameters that it determines.
    pub rank: usize,
    /// Values minus rank.
    pub dof: usize,
    /// Condition number of the scaled rows.
    pub condition: Option<f64>,
    /// Predicted uncertainty of each estimated parameter.
    pub parameters: Vec<PredictedReport>,
    /// Predicted uncertainty of each derived quantity.
    pub derived: Vec<PredictedDerivedReport>,
    /// Correlations of the estimated parameters; null where one is not estimable.
    pub correlation: CorrelationReport,
    /// What only combinations determine, with the position that would separate it.
    pub not_estimable: Vec<NotEstimableReport>,
    /// Largest shift of a parameter, as a share of its uncertainty, when a reading drifts by one standard deviation over the run.
    pub drift: Option<f64>,
    /// Every value of the schedule: leverage, minimal detectable bias and its effect.
    pub readings: Vec<PlannedReadingReport>,
}

/// Work of a schedule.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct WorkReport {
    /// Readings.
    pub readings: usize,
    /// Mountings.
    pub mountings: usize,
    /// Rate changes within mountings.
    pub rate_changes: usize,
    /// Cost of it all.
    pub cost: f64,
}

/// Prediction for one parameter.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct PredictedReport {
    /// Its name.
    pub id: String,
    /// `tilt` or `coefficient`.
    pub kind: String,
    /// Unit of `u`.
    pub unit: String,
    /// Predicted standard uncertainty; null where not estimable.
    pub u: Option<f64>,
    /// The same in arcseconds, for tilts.
    pub u_arcsec: Option<f64>,
    /// The part from noise and remounting.
    pub from_readings: Option<f64>,
    /// The part from known inputs.
    pub from_known: f64,
}

/// Prediction for one derived quantity.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct PredictedDerivedReport {
    /// Its name.
    pub id: String,
    /// Its line of algebra.
    pub line: String,
    /// Predicted standard uncertainty; null where not estimable.
    pub u: Option<f64>,
    /// The same in arcseconds, for angles.
    pub u_arcsec: Option<f64>,
    /// It has no derivative at the reference point, and this is the largest close by.
    pub is_largest: bool,
}

/// Correlations.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct CorrelationReport {
    /// Parameters, in the order of rows and columns.
    pub order: Vec<String>,
    /// Correlation coefficients.
    pub matrix: Vec<Vec<Option<f64>>>,
}

/// One value of a schedule.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct PlannedReadingReport {
    /// Number of the reading, from 1.
    pub index: usize,
    /// Its label.
    pub position: String,
    /// The position as reading keys.
    pub at: PositionReport,
    /// Sensor.
    pub sensor: String,
    /// Standard uncertainty that was assumed.
    pub u: f64,
    /// Leverage, 0 to 1; near 1, nothing checks this reading.
    pub leverage: f64,
    /// Minimal detectable bias (significance 0.1 %, power 80 %), in the sensor's unit; null where nothing checks this reading.
    pub mdb: Option<f64>,
    /// What a bias of that size does to each estimated parameter, in its unit.
    pub effect: BTreeMap<String, f64>,
    /// The same in arcseconds, for tilts.
    pub effect_arcsec: BTreeMap<String, f64>,
}

/// The better schedule.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ImprovedReport {
    /// `D`, `A`, `G`, `c:<quantity>` or `goal`.
    pub criterion: String,
    /// Portions that could be chosen.
    pub candidates: usize,
    /// Readings that were chosen; others were kept.
    pub chosen: usize,
    /// At least this share of what no schedule can beat.
    pub efficiency: Option<f64>,
    /// Starts of the exchange.
    pub starts: usize,
    /// Starts that ended at this schedule's value.
    pub hits: usize,
    /// Seed that gives the same schedule again.
    pub seed: u64,
    /// Fresh QR against the exchange's updates, as a relative difference for each unknown.
    pub check: Option<f64>,
    /// How well it will do.
    pub judgement: JudgementReport,
    /// Per parameter and derived quantity: the given schedule, at equal effort, and the better one.
    pub comparison: Vec<ComparisonReport>,
    /// The positions in the order to run, as reading keys.
    pub positions: Vec<PlannedPositionReport>,
    /// What even all candidates together do not determine.
    pub unreachable: Vec<NotEstimableReport>,
    /// The goal, if one was set.
    pub goal: Option<GoalReport>,
}

/// One position to run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct PlannedPositionReport {
    /// Label of the mounting.
    pub position: String,
    /// Reading keys.
    pub at: PositionReport,
}

/// One line of the comparison.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ComparisonReport {
    /// Parameter or derived quantity.
    pub id: String,
    /// Unit of the uncertainties: arcsec for angles.
    pub unit: String,
    /// Predicted uncertainty with the given schedule.
    pub given: Option<f64>,
    /// With the given schedule repeated, or cut, to the number of readings of the better one: `u sqrt(readings given / readings better)`.
    pub equal_effort: Option<f64>,
    /// With the better schedule.
    pub better: Option<f64>,
    /// `equal_effort / better`.
    pub gain: Option<f64>,
}

/// Whether a goal was reached.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct GoalReport {
    /// Limit of each parameter, in its unit (arcsec for tilts).
    pub limits: BTreeMap<String, f64>,
    /// Are all limits kept? If not, this schedule is the best reachable with so many readings.
    pub reached: bool,
    /// Largest uncertainty as a share of its limit.
    pub largest_share: Option<f64>,
    /// Is it proven that no fewer readings of these candidates reach the goal?
    pub is_fewest: bool,
    /// Limited parameters that even all candidates together do not determine.
    pub impossible: Vec<String>,
}

/// What was found beside the judgement of the given schedule.
#[derive(Debug, Clone, Copy)]
pub enum Better<'a> {
    /// The best schedule by a criterion, and the criterion's name.
    Best(&'a Improvement, &'a str),
    /// The schedule that reaches goals.
    Goal(&'a Reached, &'a [Goal]),
}

/// The report of a plan.
pub fn plan_report(
    campaign: &Campaign,
    noise: &Noise,
    judgement: &Judgement,
    better: Option<Better<'_>>,
    seed: u64,
) -> PlanReport {
    let given = judgement_report(campaign, judgement);
    let sensors = campaign.bench.sensors.iter();
    let improved = better.map(|better| {
        let (improvement, criterion) = match better {
            Better::Best(improvement, criterion) => (improvement, criterion),
            Better::Goal(reached, _) => (&reached.improvement, "goal"),
        };
        let own = judgement_report(&improvement.schedule, &improvement.judgement);
        ImprovedReport {
            criterion: criterion.to_string(),
            candidates: improvement.candidates,
            chosen: improvement.chosen,
            efficiency: improvement.efficiency,
            starts: improvement.starts,
            hits: improvement.hits,
            seed,
            check: improvement.check,
            comparison: comparison(&given, &own),
            positions: positions(&improvement.schedule),
            unreachable: improvement.unreachable.iter().map(|s| not_estimable(campaign, s)).collect(),
            goal: match better {
                Better::Goal(reached, goals) => Some(goal_report(campaign, reached, goals)),
                Better::Best(..) => None,
            },
            judgement: own,
        }
    });
    PlanReport {
        tumble: VERSION.into(),
        report: "plan".into(),
        bench: campaign.bench.id.clone(),
        model: sensors.clone().map(|s| (s.id.clone(), s.model.to_string())).collect(),
        noise: sensors
            .zip(&noise.sensors)
            .map(|(s, n)| {
                (s.id.clone(), SensorNoiseReport { sd: n.sd, unit: s.unit.clone(), from: n.from.name().to_string() })
            })
            .collect(),
        remount: noise
            .remount
            .iter()
            .filter_map(|(k, sd)| Some((campaign.parameters.get(*k)?.id.clone(), *sd)))
            .collect(),
        schedule: given,
        improved,
    }
}

fn work(work: Work) -> WorkReport {
    WorkReport { readings: work.readings, mountings: work.mountings, rate_changes: work.rate_changes, cost: work.cost }
}

fn judgement_report(campaign: &Campaign, judgement: &Judgement) -> JudgementReport {
    let ids: Vec<String> = judgement.parameters.iter().map(|p| p.id.clone()).collect();
    let n = ids.len();
    let is_tilt: Vec<bool> = judgement.parameters.iter().map(|p| p.kind == Kind::Tilt).collect();
    JudgementReport {
        work: work(judgement.work),
        rank: judgement.rank,
        dof: judgement.dof,
        condition: judgement.condition,
        parameters: judgement
            .parameters
            .iter()
            .map(|p| PredictedReport {
                id: p.id.clone(),
                kind: if p.kind == Kind::Tilt { "tilt" } else { "coefficient" }.into(),
                unit: p.unit.clone(),
                u: p.u,
                u_arcsec: p.u.filter(|_| p.kind == Kind::Tilt).map(|u| u * ARCSEC),
                from_readings: p.from_readings,
                from_known: p.from_known,
            })
            .collect(),
        derived: judgement
            .derived
            .iter()
            .map(|d| PredictedDerivedReport {
                id: d.id.clone(),
                line: d.line.clone(),
                u: d.u,
                u_arcsec: d.u.filter(|_| d.is_angle).map(|u| u * ARCSEC),
                is_largest: d.is_largest,
            })
            .collect(),
        correlation: CorrelationReport {
            matrix: (0..n).map(|i| (0..n).map(|j| judgement.correlation(i, j)).collect()).collect(),
            order: ids.clone(),
        },
        not_estimable: judgement.not_estimable.iter().map(|s| not_estimable(campaign, s)).collect(),
        drift: judgement.drift,
        readings: judgement
            .readings
            .iter()
            .map(|r| {
                let reading = campaign.readings.rows.get(r.origin.reading);
                let effects = ids.iter().zip(&r.effect).filter(|_| r.mdb.is_some());
                let tilts = effects.clone().zip(&is_tilt).filter(|(_, tilt)| **tilt);
                PlannedReadingReport {
                    index: r.origin.reading + 1,
                    position: reading.map(|r| r.position.clone()).unwrap_or_default(),
                    at: reading.map(|r| position_keys(campaign, &r.joints)).unwrap_or_default(),
                    sensor: campaign.bench.sensors.get(r.origin.sensor).map(|s| s.id.clone()).unwrap_or_default(),
                    u: r.u,
                    leverage: r.leverage,
                    mdb: r.mdb,
                    effect_arcsec: tilts.map(|((id, e), _)| (id.clone(), e * ARCSEC)).collect(),
                    effect: effects.map(|(id, e)| (id.clone(), *e)).collect(),
                }
            })
            .collect(),
    }
}

fn positions(schedule: &Campaign) -> Vec<PlannedPositionReport> {
    let rows = schedule.readings.rows.iter();
    rows.map(|r| PlannedPositionReport { position: r.position.clone(), at: position_keys(schedule, &r.joints) })
        .collect()
}

fn comparison(given: &JudgementReport, better: &JudgementReport) -> Vec<ComparisonReport> {
    let effort = (given.work.readings as f64 / better.work.readings.max(1) as f64).sqrt();
    let line = |id: &str, unit: &str, given: Option<f64>, better: Option<f64>| ComparisonReport {
        id: id.to_string(),
        unit: unit.to_string(),
        given,
        equal_effort: given.map(|u| u * effort),
        better,
        gain: given.zip(better).filter(|(_, b)| *b > 0.0).map(|(g, b)| g * effort / b),
    };
    let own = |u: Option<f64>, arcsec: Option<f64>, is_angle: bool| if is_angle { arcsec } else { u };
    let parameters = given.parameters.iter().zip(&better.parameters).map(|(g, b)| {
        let angle = g.kind == "tilt";
        let unit = if angle { "arcsec" } else { g.unit.as_str() };
        line(&g.id, unit, own(g.u, g.u_arcsec, angle), own(b.u, b.u_arcsec, angle))
    });
    let derived = given.derived.iter().zip(&better.derived).map(|(g, b)| {
        let angle = g.u_arcsec.is_some() || b.u_arcsec.is_some();
        line(&g.id, if angle { "arcsec" } else { "" }, own(g.u, g.u_arcsec, angle), own(b.u, b.u_arcsec, angle))
    });
    parameters.chain(derived).collect()
}

fn goal_report(campaign: &Campaign, reached: &Reached, goals: &[Goal]) -> GoalReport {
    let limit = |goal: &Goal| {
        let tilt = campaign.parameters.iter().any(|p| p.id == goal.id && p.kind == Kind::Tilt);
        (goal.id.clone(), if tilt { goal.u * ARCSEC } else { goal.u })
    };
    GoalReport {
        limits: goals.iter().map(limit).collect(),
        reached: reached.reached,
        largest_share: reached.largest_share,
        is_fewest: reached.is_fewest,
        impossible: reached.impossible.clone(),
    }
}
