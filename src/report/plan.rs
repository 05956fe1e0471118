//! The report of a plan: how well a schedule will do, and the better one.

use super::{ForesightReport, NotEstimableReport, PositionReport};
use crate::campaign::{Identity, Kind};
use crate::plan::{NoiseSource, PointSource};
use crate::report::ReportKind;
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
#[non_exhaustive]
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
#[non_exhaustive]
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

/// What cannot be predicted at the point of evaluation although it could be nearby.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[non_exhaustive]
pub struct LackingReport {
    /// Parameters whose uncertainty cannot be predicted.
    pub untold: Vec<String>,
    /// Parameters without a stated value on which these uncertainties depend.
    pub needs: Vec<String>,
}

/// Noise of one sensor.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[non_exhaustive]
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
#[non_exhaustive]
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
    /// What vanishes at the point of judging and needs a value; null where nothing does.
    #[serde(default)]
    pub lacking: Option<LackingReport>,
    /// Bounds of the campaign, which are not counted: a bound lowers an uncertainty only where it is reached.
    #[serde(default)]
    pub bounds_not_counted: usize,
    /// Largest shift of a parameter, as a share of its uncertainty, when a reading drifts by one standard deviation over the run.
    pub drift: Option<f64>,
    /// What known inputs do through tilts whose size a plan does not know; null where they do nothing.
    pub through_tilts: Option<ThroughTiltsReport>,
    /// Values that no other value checks.
    #[serde(default)]
    pub unchecked: usize,
    /// Every value of the schedule: leverage, minimal detectable bias and its effect; empty with more than 20,000 values.
    pub readings: Vec<PlannedReadingReport>,
    /// What a diagnosis could find; null with more than 100,000 values.
    pub effects: Option<ForesightReport>,
}

/// What a known input's uncertainty does through the tilts.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[non_exhaustive]
pub struct ThroughTiltsReport {
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

/// Work of a schedule.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[non_exhaustive]
pub struct WorkReport {
    /// Readings.
    pub readings: usize,
    /// Mountings.
    pub mountings: usize,
    /// Rate changes within mountings.
    pub rate_changes: usize,
    /// Cost of it all, in the unit of the costs that were given (readings, where none were).
    pub cost: f64,
}

/// Prediction for one parameter.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[non_exhaustive]
pub struct PredictedReport {
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

/// Prediction for one derived quantity.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[non_exhaustive]
pub struct PredictedDerivedReport {
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

/// Correlations.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[non_exhaustive]
pub struct CorrelationReport {
    /// Parameters, in the order of rows and columns.
    pub order: Vec<String>,
    /// Correlation coefficients, -1 to 1.
    pub matrix: Vec<Vec<Option<f64>>>,
}

/// One value of a schedule.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[non_exhaustive]
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

/// Angles moved between the candidates.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[non_exhaustive]
pub struct RefinedReport {
    /// Angles were moved in multiples of this, in degrees.
    pub resolution_deg: f64,
    /// Mountings with an angle that no candidate has.
    pub moved: usize,
    /// By what share the criterion is better: the determinant for each unknown (D), a variance (else).
    pub gain: f64,
    /// Did it end because no move was worth it? Else because of the effort.
    pub finished: bool,
}

/// The better schedule.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[non_exhaustive]
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
    pub to_run: WorkReport,
    /// What the chosen ones might cost at most, where that was limited, in the unit of the costs.
    #[serde(default)]
    pub cost_limit: Option<f64>,
    /// Designs that there are, where all of them were tried: none is better.
    #[serde(default)]
    pub enumerated: Option<u64>,
    /// At least this share of the best possible choice of these candidates (within the budget, where there is one); null where no bound is
    /// known (goal, two effects).
    pub efficiency: Option<f64>,
    /// How loose that bound may be, as a share; a larger shortfall means that so few portions cannot follow the best weights.
    pub bound_gap: Option<f64>,
    /// What moving the angles between the candidates brought; absent where that was not asked for. Efficiency and enumeration are those of the
    /// choice among the candidates.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub refined: Option<RefinedReport>,
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
    pub goal: Option<GoalReport>,
    /// Why each chosen mounting is there.
    #[serde(default)]
    pub reasons: Vec<ReasonReport>,
    /// The two effects to be discriminated, if two were named.
    pub separation: Option<DiscriminationReport>,
}

/// Deviations that chosen positions share.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[non_exhaustive]
pub struct SharedReport {
    /// The line of scatter: `V per day`.
    pub line: String,
    /// The column of the levels.
    pub column: String,
    /// Its values at the chosen positions.
    pub levels: Vec<String>,
}

/// What would be lost without one mounting.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[non_exhaustive]
pub struct ReasonReport {
    /// Label of the mounting.
    pub position: String,
    /// The parameter that would lose most.
    pub parameter: String,
    /// By what factor its uncertainty would grow; null where nothing would determine it.
    pub grows: Option<f64>,
}

/// Two effects, and how well their coefficients are known with both in the model.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[non_exhaustive]
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
#[non_exhaustive]
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
#[non_exhaustive]
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

/// Whether a goal was reached.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[non_exhaustive]
pub struct GoalReport {
    /// Limit of each parameter and derived quantity that is counted, in its unit (arcsec for angles).
    pub limits: BTreeMap<String, f64>,
    /// Are all limits kept? If not, this schedule is the best reachable with so many readings.
    pub reached: bool,
    /// Largest uncertainty as a share of its limit.
    pub largest_share: Option<f64>,
    /// Is it proven that no fewer readings of these candidates reach the goal?
    pub is_fewest: bool,
    /// Was the cheapest schedule sought? It is the cheapest that was found, without a proof that none is cheaper.
    #[serde(default)]
    pub is_cheapest_found: bool,
    /// Limited quantities that even all candidates together do not determine.
    pub impossible: Vec<String>,
}
