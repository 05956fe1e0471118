//! Reports: results as stable JSON for programs, and as documents for a person.
//!
//! Keys are public; new ones may be added, none renamed. Numbers that do not exist (an uncertainty without degrees of
//! freedom, an infinite number of degrees of freedom) are null.
//!
//! | file | subject |
//! |---|---|
//! | `fit.rs`, `fit_build.rs`, `fit_document/` | a fit: the keys of its report, the report from the fit, its document |
//! | `fit_checks.rs`, `fit_constraints.rs`, `monte_carlo.rs` | what that report says of the readings, the constraints and the Monte Carlo |
//! | `scatter.rs`, `conformity.rs`, `site.rs`, `correction.rs` | what it says of what scatters, of limits, of gravity and Earth rate, of the correction |
//! | `record.rs` | what it says of a record that was streamed |
//! | `batch.rs`, `batch_document.rs` | many devices: what they come to, a row for each |
//! | `compare.rs`, `compare_document.rs` | published closed forms beside least squares |
//! | `changes.rs`, `changes_document.rs` | two calibrations of one unit, the history of many |
//! | `reduction.rs`, `reduction_document.rs` | from samples to readings |
//! | `noise_analysis.rs`, `noise_document.rs`, `kalibr.rs` | the noise of a record; the file of kalibr |
//! | `diagnose/` | a diagnosis: gap, effects, verdict |
//! | `plan.rs`, `plan_build.rs`, `plan_document.rs`, `plan_better.rs`, `plan_words.rs` | a schedule judged or chosen |
//! | `foresight.rs` | which effects a schedule would show |
//! | `guide.rs` | a step of a guided calibration |
//! | `navigate.rs`, `navigate_document.rs` | errors of a navigator over a mission |
//! | `navigate_diagnose.rs`, `navigate_diagnose_document.rs` | effects found from the errors of a navigator |
//! | `separation.rs` | what is not estimable, and what would separate it |
//! | `provenance.rs`, `colophon.rs` | files that a report was made from, and how a document says so |
//! | `shown.rs` | answers and reports as text (`Display`) |
//! | `dcc/` | the digital calibration certificate |
//!
//! Deliberately absent: computing anything.

mod batch;
mod batch_document;
mod changes;
mod changes_document;
mod colophon;
mod compare;
mod compare_document;
pub(crate) mod conformity;
mod correction;
#[cfg(feature = "dcc")]
pub mod dcc;
mod diagnose;
mod fit;
mod fit_build;
mod fit_checks;
mod fit_constraints;
mod fit_document;
mod foresight;
mod guide;
mod kalibr;
mod monte_carlo;
#[cfg(feature = "navigate")]
mod navigate;
#[cfg(feature = "navigate")]
mod navigate_diagnose;
#[cfg(feature = "navigate")]
mod navigate_diagnose_document;
#[cfg(feature = "navigate")]
mod navigate_document;
mod noise_analysis;
mod noise_document;
mod plan;
mod plan_better;
mod plan_build;
mod plan_document;
mod plan_words;
mod provenance;
pub(crate) mod record;
mod reduction;
mod reduction_document;
mod scatter;
mod scene;
mod separation;
mod sheet;
mod shown;
mod site;

use crate::vocabulary::vocabulary;

pub use batch::{
    BatchReport, BetweenReport, ConformityCounts, DeviceCounts, DistributionReport, LotReport, OutlyingReport,
    batch_quantities, batch_report, batch_rows,
};
pub use batch_document::batch_document;
pub use changes::{
    CalibratedReport, ChangesReport, HistoryReport, TrendReport, changes_report, date_of, determination, history_report,
};
pub use changes_document::{changes_document, history_document};
pub use compare::{CompareReport, GroupReport, MisprintReport, QuantityReport, compare_report};
pub use compare_document::compare_document;
pub use conformity::{ConformityReport, LimitedReport, conformity};
pub use correction::{correction_lines, given_sentence, validity_sentence};
pub use diagnose::{
    AliasReport, AssertedReport, CellReport, ChangeReport, DiagnoseReport, EffectReport, GapReport, GapsReport,
    HoldoutReport, LevelReport, NoiseReport, PlaceReport, ResidualReport, SensorGapReport, StepReport,
    UnexplainedReport, alias_note, diagnose_document, diagnose_figure, diagnose_report,
};
pub use fit::{
    ArcsecReport, BudgetReport, CombinationValueReport, ConditionalReport, ConvergenceReport, CovarianceReport,
    DerivedReport, FitReport, FitSummary, IterationReport, KnownReport, ParameterReport, ReadingReport,
};
pub use fit_build::{fit_report, fit_summary};
pub use fit_document::{Asked, fit_document};
pub use guide::{GuideReport, guide_report};
pub use kalibr::kalibr;
pub use provenance::Input;
pub use reduction::{
    DetectorReport, JumpReport, ReduceReport, RejectedReport, SegmentMeanReport, SegmentReport, reduce_report,
};
pub use reduction_document::{record_chart, reduce_document};
pub use scatter::ScatterReport;
pub use scene::scene;
pub use separation::{CombinationReport, NotEstimableReport, PositionReport, position_keys};
pub use sheet::{sheet_csv, sheet_document};
pub use site::{GravityBasis, GravityReport, SiteReport, gravity_text, site};

pub use fit_checks::{
    ChecksReport, ExternalReport, LackOfFitReport, NormalityReport, RobustReport, RunsReport, SnoopingReport,
    SuspectReport,
};
pub use fit_constraints::{ConstraintReport, ConstraintState, ConstraintsReport, ConstraintsStatus};
pub use foresight::{
    AlikeReport, ForesightReport, MovesReport, NearReport, PassedOverReport, ProspectReport, RuleReport,
    foresight_report,
};
pub use monte_carlo::{DrawnReport, JointReport, MonteCarloReport, monte_carlo_report};
#[cfg(feature = "navigate")]
pub use navigate::{
    CarriedReport, ErrorReport, NavigateReport, PeriodsReport, QuantityWithUnit, RatioReport, ResultReport,
    ScenarioReport, SummaryReport, navigate_report,
};
pub use record::{BinReport, BinsReport, FarReport, LagReport, MeansReport, RecordReport, RecordSensorReport};

#[cfg(feature = "navigate")]
pub use navigate_diagnose::{
    ChannelReport, NavigateDiagnoseReport, NavigationAliasReport, NavigationCellReport, NavigationEffectReport,
    NavigationGapStepReport, RunReport, SeparationReport, UnexplainedNavigationReport, navigate_diagnose_report,
};
#[cfg(feature = "navigate")]
pub use navigate_diagnose_document::{navigate_diagnose_document, navigate_diagnose_figure};
#[cfg(feature = "navigate")]
pub use navigate_document::navigate_document;
pub use noise_analysis::{
    AgreementReport, CoefficientReport, DeviationReport, DeviationsReport, NoiseAnalysisReport, NoiseColumnReport,
    NoiseScatterReport, noise_column_report, noise_report,
};
pub use noise_document::noise_document;
pub use plan::{
    ComparisonReport, CorrelationReport, DiscriminationReport, Effort, FindReport, GoalReport, ImprovedReport,
    JudgementReport, LackingReport, PlanReport, PlannedPositionReport, PlannedReadingReport, PointReport,
    PredictedDerivedReport, PredictedReport, ReasonReport, SensorNoiseReport, SharedReport, ThroughTiltsReport,
    WorkReport,
};
pub use plan_build::{Better, Foreseen, plan_report};
pub use plan_document::plan_document;

vocabulary! {
    /// What kind of report it is.
    ReportKind {
        /// One fit.
        Fit = "fit",
        /// Many devices.
        Batch = "batch",
        /// Published closed forms compared with least squares.
        Compare = "compare",
        /// Two calibrations of one unit.
        CompareCalibrations = "compare-calibrations",
        /// Several calibrations of one unit.
        CompareHistory = "compare-history",
        /// What the model misses.
        Diagnose = "diagnose",
        /// A schedule judged or chosen.
        Plan = "plan",
        /// A step of a guided calibration.
        Guide = "guide",
        /// What calibration errors do to a navigator.
        Navigate = "navigate",
        /// What the errors of a navigator come from.
        NavigateDiagnose = "navigate-diagnose",
        /// Allan deviations and coefficients of a record.
        Noise = "noise",
        /// Means of a record's segments.
        Reduce = "reduce",
    }
}

/// Version of the program, as every report says it.
pub const VERSION: &str = env!("CARGO_PKG_VERSION");

/// One radian in arcseconds.
pub const ARCSEC: f64 = 180.0 * 3600.0 / std::f64::consts::PI;

/// A number that exists; what is infinite or undefined is null in a report.
fn finite(value: f64) -> Option<f64> {
    value.is_finite().then_some(value)
}

/// The kinds of file that have a JSON Schema: what is read, then what is written.
pub fn schemas() -> Vec<&'static str> {
    crate::wire::SCHEMAS
        .iter()
        .copied()
        .chain([
            "fit-report",
            "batch-report",
            "compare-report",
            "compare-calibrations-report",
            "compare-history-report",
            "diagnose-report",
            "plan-report",
            "guide-report",
            "noise-report",
            "reduce-report",
        ])
        .chain(
            cfg!(feature = "navigate").then_some(["navigate-report", "navigate-diagnose-report"]).into_iter().flatten(),
        )
        .collect()
}

/// The JSON Schema (draft 2020-12) of a kind of file, if there is such a kind.
///
/// ```
/// assert!(tumble::report::schema("fit-report").is_some());
/// ```
pub fn schema(kind: &str) -> Option<serde_json::Value> {
    let schema = match kind {
        "batch-report" => schemars::schema_for!(BatchReport),
        "compare-report" => schemars::schema_for!(CompareReport),
        "compare-calibrations-report" => schemars::schema_for!(ChangesReport),
        "compare-history-report" => schemars::schema_for!(HistoryReport),
        "diagnose-report" => schemars::schema_for!(DiagnoseReport),
        "fit-report" => schemars::schema_for!(FitReport),
        "guide-report" => schemars::schema_for!(GuideReport),
        #[cfg(feature = "navigate")]
        "navigate-report" => schemars::schema_for!(NavigateReport),
        #[cfg(feature = "navigate")]
        "navigate-diagnose-report" => schemars::schema_for!(NavigateDiagnoseReport),
        "noise-report" => schemars::schema_for!(NoiseAnalysisReport),
        "plan-report" => schemars::schema_for!(PlanReport),
        "reduce-report" => schemars::schema_for!(ReduceReport),
        _ => return crate::wire::schema(kind),
    };
    Some(crate::wire::identified(kind, schema.to_value()))
}
