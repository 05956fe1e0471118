//! The report of a plan: how well a schedule will do, and the better one; from a judgement and what was found beside it.

use super::foresight::{ForesightReport, foresight_report};
use super::separation::not_estimable;
use super::{ARCSEC, NotEstimableReport, PositionReport, ReportKind, VERSION, position_keys};
use crate::campaign::{Campaign, Identity, Kind, Per, Reading, Scatter};
use crate::diagnosis::Foresight;
use crate::plan::{
    Costs, GoalOutcome, Improvement, Judgement, Lacking, Noise, NoiseSource, PointSource, Predicted, PredictedDerived,
    Reached, Reason, Request, SearchRecord, Separated, ThroughTilts, Work,
};
use crate::vocabulary::vocabulary;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// What `tumble plan --json` writes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[non_exhaustive]
pub struct PlanReport {
    /// Version of the program that wrote it.
    pub tumble: String,
    /// Always `plan`.
    #[schemars(extend("const" = "plan"))]
    pub report: ReportKind,
    /// Bench id.
    pub bench: String,
    /// The unit under test, when, where, by whom, with what.
    #[serde(default, skip_serializing_if = "Identity::is_empty")]
    pub identity: Identity,
    /// Model line of each sensor.
    pub model: BTreeMap<String, String>,
    /// Noise of each sensor.
    pub noise: BTreeMap<String, SensorNoiseReport>,
    /// Parameters that every remounting scatters, with the standard deviation (radians for tilts).
    pub remount: BTreeMap<String, f64>,
    /// The value of each estimated parameter at which the schedules are evaluated.
    #[serde(default)]
    pub judged_at: Vec<PointReport>,
    /// Effects that the schedule is asked to find.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub finds: Vec<FindReport>,
    /// The schedule that was given.
    pub schedule: JudgementReport,
    /// The better schedule, if one was asked for.
    pub improved: Option<ImprovedReport>,
}

/// An effect that is to be found, as a limit on the uncertainty of its coefficient.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct FindReport {
    /// The effect.
    pub effect: String,
    /// Its coefficient in the model of this plan.
    pub coefficient: String,
    /// The size that is to be found (radians for tilts).
    pub size: f64,
    /// Probability of finding it.
    pub power: f64,
    /// The limit, in the coefficient's unit: the size over the noncentrality of that power.
    pub u: f64,
}

/// Value of one estimated parameter at which schedules are judged.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct PointReport {
    /// The parameter.
    pub id: String,
    /// Its value, in `unit`.
    pub value: f64,
    /// Unit.
    pub unit: String,
    /// The same in arcseconds, for tilts.
    pub arcsec: Option<f64>,
    /// `given` (--at), `fitted` (from the campaign's readings), `start`, `prior`, or `zero` where nothing is stated.
    pub from: PointSource,
}

/// Noise of one sensor.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct SensorNoiseReport {
    /// Standard deviation of one reading, in `unit`.
    pub sd: f64,
    /// Its unit.
    pub unit: String,
    /// `given`, `stated` (in the readings) or `residuals` (of a fit to the readings).
    pub from: NoiseSource,
}

/// How well a schedule will do.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct JudgementReport {
    /// Readings, mountings, rate changes, cost.
    pub work: Work,
    /// Independent combinations of the estimated parameters that it determines.
    pub rank: usize,
    /// Values minus rank.
    pub dof: usize,
    /// Condition number of the scaled rows.
    pub condition: Option<f64>,
    /// Predicted uncertainty of each estimated parameter.
    pub parameters: Vec<Predicted>,
    /// Predicted uncertainty of each derived quantity.
    pub derived: Vec<PredictedDerived>,
    /// Correlations of the estimated parameters; null where one is not estimable.
    pub correlation: CorrelationReport,
    /// What only combinations determine, with the position that would separate it.
    pub not_estimable: Vec<NotEstimableReport>,
    /// What vanishes at the point of judging and needs a value; null where nothing does.
    #[serde(default)]
    pub lacking: Option<Lacking>,
    /// Bounds of the campaign, which are not counted: a bound lowers an uncertainty only where it is reached.
    #[serde(default)]
    pub bounds_not_counted: usize,
    /// Largest shift of a parameter, as a share of its uncertainty, when a reading drifts by one standard deviation over the run.
    pub drift: Option<f64>,
    /// What known inputs do through tilts whose size a plan does not know; null where they do nothing.
    pub through_tilts: Option<ThroughTilts>,
    /// Values that no other value checks.
    #[serde(default)]
    pub unchecked: usize,
    /// Every value of the schedule: leverage, minimal detectable bias and its effect; empty with more than 20,000 values.
    pub readings: Vec<PlannedReadingReport>,
    /// What a diagnosis could find; null with more than 100,000 values.
    pub effects: Option<ForesightReport>,
}

/// Correlations.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct CorrelationReport {
    /// Parameters, in the order of rows and columns.
    pub order: Vec<String>,
    /// Correlation coefficients, -1 to 1.
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
    /// Standard uncertainty that was assumed, in the sensor's unit.
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

vocabulary! {
    /// What effort is counted in.
    Effort {
        /// The number of readings.
        Readings = "readings",
        /// What readings, mountings and rate changes cost.
        Cost = "cost",
    }
}

/// The better schedule.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ImprovedReport {
    /// `D`, `A`, `G`, `c:<quantity>`, `goal` or `T:<effect>|<effect>`.
    pub criterion: String,
    /// What could be spent on what was chosen, if there was a budget, in the unit of the costs.
    pub budget: Option<f64>,
    /// Portions that could be chosen.
    pub candidates: usize,
    /// Readings that were chosen; others were kept.
    pub chosen: usize,
    /// The first so many readings were kept, in their order.
    #[serde(default)]
    pub kept: usize,
    /// Work that is still to be done: without what has been measured.
    pub to_run: Work,
    /// How it was searched.
    #[serde(flatten)]
    pub search: SearchRecord,
    /// Seed that gives the same schedule again.
    pub seed: u64,
    /// From the rows of the final schedule against the exchange's updates, as a relative difference for each unknown.
    pub check: Option<f64>,
    /// How well it will do.
    pub judgement: JudgementReport,
    /// What effort is counted in when schedules are compared: `readings`, or `cost` where there was a budget.
    pub effort: Effort,
    /// Per parameter and derived quantity: the given schedule, at equal effort, and the better one.
    pub comparison: Vec<ComparisonReport>,
    /// The positions still to be measured, in the order to run, as reading keys.
    pub positions: Vec<PlannedPositionReport>,
    /// What even all candidates together do not determine.
    pub unreachable: Vec<NotEstimableReport>,
    /// Columns that differ in the given schedule and have one value in all candidates, with that value.
    #[serde(default)]
    pub frozen: BTreeMap<String, f64>,
    /// Lines of scatter by which the chosen positions share deviations, and the levels that they are planned for.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub shared: Vec<SharedReport>,
    /// The goal, if one was set.
    pub goal: Option<GoalOutcome>,
    /// Why each chosen mounting is there.
    #[serde(default)]
    pub reasons: Vec<Reason>,
    /// The two effects to be discriminated, if two were named.
    pub separation: Option<DiscriminationReport>,
}

/// Deviations that chosen positions share.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct SharedReport {
    /// The line of scatter: `V per day`.
    pub line: String,
    /// The column of the levels.
    pub column: String,
    /// Its values at the chosen positions.
    pub levels: Vec<String>,
}

/// Two effects, and how well their coefficients are known with both in the model.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct DiscriminationReport {
    /// Regressors.
    pub effects: [String; 2],
    /// Standard uncertainties before, in each coefficient's unit; null where nothing distinguishes them.
    pub before: [Option<f64>; 2],
    /// Standard uncertainties with the added positions, in each coefficient's unit.
    pub after: [Option<f64>; 2],
}

/// One position to run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct PlannedPositionReport {
    /// Label of the mounting.
    pub position: String,
    /// Reading keys.
    pub at: PositionReport,
    /// Values of the columns by which positions share deviations: the day, the operator.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub levels: BTreeMap<String, String>,
}

/// One line of the comparison.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ComparisonReport {
    /// Parameter or derived quantity.
    pub id: String,
    /// Unit of the uncertainties: arcsec for angles.
    pub unit: String,
    /// Predicted uncertainty with the given schedule, in `unit`.
    pub given: Option<f64>,
    /// With the given schedule repeated, or cut, to the effort of the better one: `u sqrt(effort given / effort better)`, in `unit`.
    pub equal_effort: Option<f64>,
    /// With the better schedule, in `unit`.
    pub better: Option<f64>,
    /// `equal_effort / better`, a ratio.
    pub gain: Option<f64>,
}

/// What was found beside the judgement of the given schedule.
#[derive(Debug, Clone, Copy)]
pub enum Better<'a> {
    /// The best schedule by a criterion, and the criterion's name.
    Best(&'a Improvement, &'a str),
    /// The schedule that reaches goals.
    Goal(&'a Reached),
    /// The schedule that tells two effects apart.
    Apart(&'a Separated, &'a [String; 2]),
}

/// What a diagnosis could find, of the given schedule and the better one.
#[derive(Debug, Clone, Copy, Default)]
pub struct Foreseen<'a> {
    /// Of the given one.
    pub given: Option<&'a Foresight>,
    /// Of the better one.
    pub better: Option<&'a Foresight>,
}

/// The report of a plan.
#[allow(clippy::too_many_arguments, reason = "each part of the report has its source")]
pub fn plan_report(
    campaign: &Campaign,
    noise: &Noise,
    judgement: &Judgement,
    better: Option<Better<'_>>,
    foreseen: Foreseen<'_>,
    request: &Request,
    costs: &Costs,
    from: &[PointSource],
) -> PlanReport {
    let given = judgement_report(campaign, judgement, foreseen.given);
    let sensors = campaign.bench.sensors.iter();
    let improved = better.map(|better| {
        let (improvement, criterion, goal, separation) = match better {
            Better::Best(improvement, criterion) => (improvement, criterion.to_string(), None, None),
            Better::Goal(Reached { improvement, goal }) => (improvement, "goal".to_string(), Some(goal.clone()), None),
            Better::Apart(Separated { improvement, before, after }, effects @ [a, b]) => {
                let discrimination = DiscriminationReport { effects: effects.clone(), before: *before, after: *after };
                (improvement, format!("T:{a}|{b}"), None, Some(discrimination))
            }
        };
        let to_run = to_run(campaign, improvement);
        let judged = judgement_report(&improvement.schedule, &improvement.judgement, foreseen.better);
        let budget = request.budget.filter(|_| matches!(better, Better::Best(..)) && !request.may_cost_more);
        let effort = |work: &Work| if budget.is_some() { work.cost } else { work.readings as f64 };
        ImprovedReport {
            criterion,
            budget,
            candidates: improvement.candidates,
            chosen: improvement.chosen,
            kept: improvement.kept,
            to_run: costs.work(&to_run),
            search: improvement.search,
            seed: request.seed,
            check: improvement.check,
            effort: if budget.is_some() { Effort::Cost } else { Effort::Readings },
            comparison: {
                let times = effort(&judged.work) / effort(&given.work).max(f64::MIN_POSITIVE);
                let better = &improvement.judgement;
                match crate::plan::repeated(campaign, noise, times, costs) {
                    // what positions share does not average out
                    Some(repeated) => comparison(judgement, better, &repeated, 1.0),
                    None => comparison(judgement, better, judgement, times.recip().sqrt()),
                }
            },
            positions: positions(&improvement.schedule, &to_run),
            reasons: improvement.reasons.clone(),
            unreachable: improvement.unreachable.iter().map(|s| not_estimable(campaign, s)).collect(),
            frozen: improvement.frozen.iter().cloned().collect(),
            shared: shared(&improvement.schedule, improvement.kept),
            goal,
            separation,
            judgement: judged,
        }
    });
    PlanReport {
        tumble: VERSION.into(),
        report: ReportKind::Plan,
        bench: campaign.bench.id.clone(),
        identity: campaign.identity.clone(),
        model: super::model_lines(campaign),
        noise: sensors
            .zip(&noise.sensors)
            .map(|(s, n)| (s.id.clone(), SensorNoiseReport { sd: n.sd, unit: s.unit.clone(), from: n.from }))
            .collect(),
        remount: noise
            .remount
            .iter()
            .filter_map(|(k, sd)| Some((campaign.parameters.get(*k)?.id.clone(), *sd)))
            .collect(),
        judged_at: point(campaign, from),
        finds: Vec::new(),
        schedule: given,
        improved,
    }
}

/// Columns by which the positions after the first `kept` share deviations, with their values there.
fn shared(schedule: &Campaign, kept: usize) -> Vec<SharedReport> {
    let readings = &schedule.readings;
    let of = |line: &Scatter| {
        let Per::Column(column) = &line.per else { return None };
        let mut levels: Vec<String> = Vec::new();
        for level in readings.rows.iter().skip(kept).filter_map(|row| line.per.level_name(readings, row)) {
            if !levels.iter().any(|known| *known == level) {
                levels.push(level.into_owned());
            }
        }
        (!levels.is_empty()).then(|| SharedReport { line: line.name(schedule), column: column.clone(), levels })
    };
    schedule.scatter.iter().filter_map(of).collect()
}

/// The point at which schedules are judged: the campaign's reference point.
fn point(campaign: &Campaign, from: &[PointSource]) -> Vec<PointReport> {
    let values = campaign.estimated().iter().zip(from);
    values
        .map(|(p, from)| PointReport {
            id: p.id.clone(),
            value: p.reference(),
            unit: p.unit.clone(),
            arcsec: (p.kind == Kind::Tilt).then(|| p.reference() * ARCSEC),
            from: *from,
        })
        .collect()
}

/// With more values than this they are not listed one by one: each takes two kilobytes of a report.
const MOST_LISTED: usize = 20_000;

fn judgement_report(campaign: &Campaign, judgement: &Judgement, foresight: Option<&Foresight>) -> JudgementReport {
    let ids: Vec<String> = judgement.parameters.iter().map(|p| p.id.clone()).collect();
    let n = ids.len();
    let is_tilt: Vec<bool> = judgement.parameters.iter().map(|p| p.kind == Kind::Tilt).collect();
    let listed = if judgement.readings.len() > MOST_LISTED { 0 } else { judgement.readings.len() };
    JudgementReport {
        unchecked: judgement.readings.iter().filter(|r| r.mdb.is_none()).count(),
        work: judgement.work,
        rank: judgement.rank,
        dof: judgement.dof,
        condition: judgement.condition,
        parameters: judgement.parameters.clone(),
        derived: judgement.derived.clone(),
        correlation: CorrelationReport {
            matrix: (0..n).map(|i| (0..n).map(|j| judgement.correlation(i, j)).collect()).collect(),
            order: ids.clone(),
        },
        not_estimable: judgement.not_estimable.iter().map(|s| not_estimable(campaign, s)).collect(),
        lacking: judgement.lacking.clone(),
        bounds_not_counted: judgement.bounds,
        drift: judgement.drift,
        through_tilts: judgement.through_tilts.clone(),
        effects: foresight.map(|foresight| foresight_report(campaign, foresight)),
        readings: judgement
            .readings
            .iter()
            .take(listed)
            .map(|r| {
                let reading = campaign.readings.rows.get(r.origin.reading);
                let effects = ids.iter().zip(&r.effect).filter(|_| r.mdb.is_some());
                let tilts = effects.clone().zip(&is_tilt).filter(|(_, tilt)| **tilt);
                PlannedReadingReport {
                    index: r.origin.reading + 1,
                    position: campaign.position_of(r.origin.reading).to_string(),
                    at: reading.map(|r| place(campaign, r)).unwrap_or_default(),
                    sensor: campaign.sensor_id(r.origin.sensor).to_string(),
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

/// The readings of a better schedule that have no value yet; `campaign` has the values, of what was kept.
fn to_run(campaign: &Campaign, improvement: &Improvement) -> Vec<Reading> {
    let done = |k: usize| {
        k < improvement.kept && campaign.readings.rows.get(k).is_some_and(|row| !row.observations.is_empty())
    };
    let rows = improvement.schedule.readings.rows.iter().enumerate();
    rows.filter(|(k, _)| !done(*k)).map(|(_, row)| row.clone()).collect()
}

/// Where a reading is taken: joint states, and the columns that model lines read.
fn place(campaign: &Campaign, row: &Reading) -> PositionReport {
    let mut keys = position_keys(campaign, &row.joints);
    let named = |k: usize| Some((campaign.readings.columns.get(k)?.clone(), row.columns.get(k).copied().flatten()?));
    keys.extend(crate::plan::conditions_read(campaign).into_iter().filter_map(named));
    keys
}

fn positions(schedule: &Campaign, rows: &[Reading]) -> Vec<PlannedPositionReport> {
    let level = |line: &Scatter, row: &Reading| match &line.per {
        Per::Column(column) => Some((column.clone(), line.per.level_name(&schedule.readings, row)?.into_owned())),
        _ => None,
    };
    let position = |row: &Reading| PlannedPositionReport {
        position: row.position.to_string(),
        at: place(schedule, row),
        levels: schedule.scatter.iter().filter_map(|line| level(line, row)).collect(),
    };
    rows.iter().map(position).collect()
}

/// `equal` is the given schedule at equal effort, but for the factor `by`.
fn comparison(given: &Judgement, better: &Judgement, equal: &Judgement, by: f64) -> Vec<ComparisonReport> {
    let quantities = predictions(given).zip(predictions(better)).zip(predictions(equal));
    let line = |((given, better), equal): ((Prediction<'_>, Prediction<'_>), Prediction<'_>)| {
        let (id, unit, ..) = given;
        let is_angle = given.3 || better.3;
        let [given, better, equal] =
            [given, better, equal].map(|(.., [u, arcsec], _)| if is_angle { arcsec } else { u });
        ComparisonReport {
            id: id.to_string(),
            unit: if is_angle { "arcsec" } else { unit }.to_string(),
            given,
            equal_effort: equal.map(|u| u * by),
            better,
            gain: equal.zip(better).filter(|(_, b)| *b > 0.0).map(|(e, b)| e * by / b),
        }
    };
    quantities.map(line).collect()
}

/// Name, unit, uncertainty in this unit and in arcseconds, and whether it is an angle.
type Prediction<'a> = (&'a str, &'a str, [Option<f64>; 2], bool);

fn predictions(of: &Judgement) -> impl Iterator<Item = Prediction<'_>> {
    let parameters = of.parameters.iter();
    let parameters = parameters.map(|p| (p.id.as_str(), p.unit.as_str(), [p.u, p.u_arcsec], p.kind == Kind::Tilt));
    let derived = of.derived.iter();
    let derived = derived.map(|d| (d.id.as_str(), d.unit.as_str(), [d.u, d.u_arcsec], d.u_arcsec.is_some()));
    parameters.chain(derived)
}
