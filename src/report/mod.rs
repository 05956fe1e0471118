//! Reports: results as stable JSON for programs, and as documents for a person.
//!
//! Keys are public; new ones may be added, none renamed. Numbers that do not exist (an uncertainty without degrees of
//! freedom, an infinite number of degrees of freedom) are null.
//!
//! | file | subject |
//! |---|---|
//! | `fit.rs`, `fit_document.rs`, `fit_figures.rs` | a fit: its report, its document, the figures of that |
//! | `checks.rs` | what that report says of the readings, a streamed record, the constraints, and the Monte Carlo |
//! | `scatter.rs`, `conformity.rs`, `site.rs`, `correction.rs` | what it says of what scatters, of limits, of gravity and Earth rate, of the correction |
//! | `batch.rs` | many devices: what they come to, a row for each |
//! | `compare.rs` | published closed forms beside least squares |
//! | `changes.rs` | two calibrations of one unit, the history of many |
//! | `reduction.rs` | from samples to readings |
//! | `noise.rs` | the noise of a record; the file of kalibr |
//! | `diagnose.rs`, `diagnose_document.rs` | a diagnosis: gap, effects, verdict |
//! | `plan.rs`, `plan_document.rs` | a schedule judged or chosen |
//! | `foresight.rs` | which effects a schedule would show |
//! | `guide.rs` | a step of a guided calibration |
//! | `navigate.rs` | errors of a navigator over a mission |
//! | `navigate_diagnose.rs` | effects found from the errors of a navigator |
//! | `separation.rs` | what is not estimable, and what would separate it |
//! | `scene.rs`, `sheet.rs` | a bench as a picture; a run sheet |
//! | `provenance.rs` | files that a report was made from, and how a document says so |
//! | `shown.rs` | answers and reports as text (`Display`) |
//! | `dcc/` | the digital calibration certificate |
//!
//! Deliberately absent: computing anything.

mod batch;
mod changes;
mod checks;
mod compare;
pub(crate) mod conformity;
mod correction;
#[cfg(feature = "dcc")]
pub mod dcc;
mod diagnose;
mod diagnose_document;
mod fit;
mod fit_document;
mod fit_figures;
mod foresight;
mod guide;
#[cfg(feature = "navigate")]
mod navigate;
#[cfg(feature = "navigate")]
mod navigate_diagnose;
mod noise;
mod plan;
mod plan_document;
mod provenance;
mod reduction;
mod scatter;
mod scene;
mod separation;
mod sheet;
mod shown;
mod site;

use crate::campaign::Campaign;
pub use crate::units::ARCSEC;
use crate::vocabulary::vocabulary;
use std::collections::BTreeMap;

pub use batch::{BatchReport, batch_document, batch_quantities, batch_report, batch_rows};
pub(crate) use changes::CalibratedReport;
pub use changes::{
    ChangesReport, HistoryReport, changes_document, changes_report, date_of, determination, history_document,
    history_report,
};
pub use checks::monte_carlo_report;
pub use compare::{CompareReport, compare_document, compare_report};
pub use conformity::conformity;
pub(crate) use diagnose::{ChangeReport, EffectReport, GapsReport};
pub use diagnose::{DiagnoseReport, diagnose_report};
pub use diagnose_document::diagnose_document;
pub(crate) use diagnose_document::{alias_note, diagnose_figure};
#[cfg(feature = "cli")]
pub(crate) use fit::fit_to_write;
pub(crate) use fit::{ArcsecReport, BudgetReport, ParameterReport, ReadingReport};
pub use fit::{FitReport, fit_report, fit_summary};
pub use fit_document::{Asked, fit_document};
pub use guide::{GuideReport, guide_report};
#[cfg(feature = "navigate")]
pub(crate) use navigate::QuantityWithUnit;
#[cfg(feature = "navigate")]
pub use navigate::{NavigateReport, navigate_document, navigate_report};
#[cfg(feature = "navigate")]
pub(crate) use navigate_diagnose::navigate_diagnose_figure;
#[cfg(feature = "navigate")]
pub use navigate_diagnose::{NavigateDiagnoseReport, navigate_diagnose_document, navigate_diagnose_report};
pub(crate) use noise::NoiseColumnReport;
pub use noise::{NoiseAnalysisReport, kalibr, noise_column_report, noise_document, noise_report};
pub use plan::{Better, Foreseen, PlanReport, plan_report};
pub(crate) use plan::{
    DiscriminationReport, Effort, FindReport, ImprovedReport, JudgementReport, PlannedPositionReport, PointReport,
    SharedReport,
};
pub use plan_document::plan_document;
pub use provenance::Input;
pub(crate) use reduction::record_chart;
pub use reduction::{ReduceReport, reduce_document, reduce_report};
pub(crate) use scatter::ScatterReport;
pub use scene::scene;
pub use separation::position_keys;
pub(crate) use separation::{NotEstimableReport, PositionReport};
pub use sheet::{sheet_csv, sheet_document};

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

/// A number that exists; what is infinite or undefined is null in a report.
fn finite(value: f64) -> Option<f64> {
    value.is_finite().then_some(value)
}

fn model_lines(campaign: &Campaign) -> BTreeMap<String, String> {
    campaign.bench.sensors.iter().map(|s| (s.id.clone(), s.model.to_string())).collect()
}

/// The kinds of report, each with its JSON Schema.
const SCHEMAS: &[(&str, fn() -> schemars::Schema)] = &[
    ("fit-report", || schemars::schema_for!(FitReport)),
    ("batch-report", || schemars::schema_for!(BatchReport)),
    ("compare-report", || schemars::schema_for!(CompareReport)),
    ("compare-calibrations-report", || schemars::schema_for!(ChangesReport)),
    ("compare-history-report", || schemars::schema_for!(HistoryReport)),
    ("diagnose-report", || schemars::schema_for!(DiagnoseReport)),
    ("plan-report", || schemars::schema_for!(PlanReport)),
    ("guide-report", || schemars::schema_for!(GuideReport)),
    ("noise-report", || schemars::schema_for!(NoiseAnalysisReport)),
    ("reduce-report", || schemars::schema_for!(ReduceReport)),
    #[cfg(feature = "navigate")]
    ("navigate-report", || schemars::schema_for!(NavigateReport)),
    #[cfg(feature = "navigate")]
    ("navigate-diagnose-report", || schemars::schema_for!(NavigateDiagnoseReport)),
];

/// The kinds of file that have a JSON Schema: what is read, then what is written.
pub fn schemas() -> Vec<&'static str> {
    crate::wire::SCHEMAS.iter().chain(SCHEMAS).map(|(kind, _)| *kind).collect()
}

/// The JSON Schema (draft 2020-12) of a kind of file, if there is such a kind.
///
/// ```
/// assert!(tumble::report::schema("fit-report").is_some());
/// ```
pub fn schema(kind: &str) -> Option<serde_json::Value> {
    match SCHEMAS.iter().find(|(other, _)| *other == kind) {
        Some((_, schema)) => Some(crate::wire::identified(kind, schema().to_value())),
        None => crate::wire::schema(kind),
    }
}
