//! Reports: results as stable JSON for programs, and as tables for a person.
//!
//! Keys are fixed (design section 3); new ones may be added, none renamed. Numbers that do not exist (an uncertainty without degrees of
//! freedom, an infinite number of degrees of freedom) are null. Deliberately absent: computing anything.

mod compare;
mod correction;
pub mod dcc;
mod diagnose;
mod fit;
mod fit_checks;
pub mod fit_checks_table;
pub mod html;
pub mod markdown;
mod navigate;
mod plan;
mod plan_table;
pub mod plot;
mod provenance;
pub mod series;
pub mod table;

pub use compare::{CompareReport, GroupReport, MisprintReport, QuantityReport, compare_report};
pub use correction::{Correction, Direction, Mounting, corrections, mounting};
pub use diagnose::{
    AliasReport, AssertedReport, CellReport, ChangeReport, DiagnoseReport, EffectReport, GapReport, GapsReport,
    HoldoutReport, LevelReport, NoiseReport, PlaceReport, ResidualReport, SensorGapReport, StepReport,
    UnexplainedReport, diagnose_report, diagnose_table,
};
pub use fit::{
    ArcsecReport, BudgetReport, CombinationReport, ConvergenceReport, CovarianceReport, DerivedReport, FitReport,
    FitSummary, IterationReport, KnownReport, NotEstimableReport, ParameterReport, PositionReport, ReadingReport,
    fit_report, position_keys,
};
pub use provenance::Input;

pub use fit_checks::{
    ChecksReport, ConstraintReport, ConstraintsReport, DrawnReport, ExternalReport, JointReport, LackOfFitReport,
    MonteCarloReport, NormalityReport, RobustReport, RunsReport, ScatterReport, SnoopingReport, SuspectReport,
    monte_carlo_report,
};
pub use navigate::{
    CarriedReport, ErrorReport, NavigateReport, PeriodsReport, QuantityWithUnit, RatioReport, ResultReport,
    ScenarioReport, SummaryReport, navigate_report,
};

pub use plan::{
    Better, ComparisonReport, CorrelationReport, GoalReport, ImprovedReport, JudgementReport, PlanReport,
    PlannedPositionReport, PlannedReadingReport, PredictedDerivedReport, PredictedReport, SensorNoiseReport,
    WorkReport, plan_report,
};
pub use plan_table::plan_table;

/// Version of the program, as every report says it.
pub const VERSION: &str = env!("CARGO_PKG_VERSION");

/// One radian in arcseconds.
pub const ARCSEC: f64 = 180.0 * 3600.0 / std::f64::consts::PI;

/// The kinds of file that have a JSON Schema: what is read, then what is written.
pub fn schemas() -> Vec<&'static str> {
    crate::wire::SCHEMAS
        .iter()
        .copied()
        .chain(["fit-report", "compare-report", "diagnose-report", "plan-report", "navigate-report"])
        .collect()
}

/// The JSON Schema (draft 2020-12) of a kind of file, if there is such a kind.
///
/// ```
/// assert!(tumble::report::schema("fit-report").is_some());
/// ```
pub fn schema(kind: &str) -> Option<serde_json::Value> {
    match kind {
        "compare-report" => Some(schemars::schema_for!(CompareReport).to_value()),
        "diagnose-report" => Some(schemars::schema_for!(DiagnoseReport).to_value()),
        "fit-report" => Some(schemars::schema_for!(FitReport).to_value()),
        "navigate-report" => Some(schemars::schema_for!(NavigateReport).to_value()),
        "plan-report" => Some(schemars::schema_for!(PlanReport).to_value()),
        _ => crate::wire::schema(kind),
    }
}
