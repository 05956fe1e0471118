//! Answers and reports as text: the table that the program prints, in English, within the width of a terminal.

use super::{
    Asked, BatchReport, ChangesReport, CompareReport, DiagnoseReport, FitReport, HistoryReport, NoiseAnalysisReport,
    PlanReport, ReduceReport, batch_document, changes_document, compare_document, compare_report, diagnose_document,
    fit_document, fit_summary, history_document, noise_document, plan_document, reduce_document,
};
#[cfg(feature = "navigate")]
use super::{NavigateDiagnoseReport, NavigateReport, navigate_diagnose_document, navigate_document};
use crate::compare::Comparison;
use crate::document::terminal::brief;
use crate::document::wrap;
use crate::fit::Fit;
use crate::language::Language::English;
use std::collections::BTreeMap;
use std::fmt::{Display, Formatter, Result};

macro_rules! shown {
    ($($type:ident: $table:expr;)*) => {
        $(impl Display for $type {
            fn fmt(&self, f: &mut Formatter<'_>) -> Result {
                let table: fn(&$type) -> String = $table;
                f.write_str(wrap::lines(&table(self)).trim_end())
            }
        })*
    };
}

shown! {
    Fit: |fit| brief(&fit_document(&fit_summary(fit), &Asked { fit: Some(fit), ..Asked::default() }, English));
    Comparison: |comparison| compare_report(comparison).to_string();
    FitReport: |report| brief(&fit_document(report, &Asked::default(), English));
    CompareReport: |report| brief(&compare_document(report, &report.inputs, English));
    ChangesReport: |report| brief(&changes_document(report, English));
    HistoryReport: |report| brief(&history_document(report, English));
    DiagnoseReport: |report| brief(&diagnose_document(report, None, English));
    PlanReport: |report| brief(&plan_document(report, None, false, English));
    BatchReport: |report| brief(&batch_document(report, None, &BTreeMap::new(), English));
    NoiseAnalysisReport: |report| brief(&noise_document(report, &[], false, English));
    ReduceReport: |report| brief(&reduce_document(report, None, &[], false, English));
}

#[cfg(feature = "navigate")]
shown! {
    NavigateReport: |report| brief(&navigate_document(report, None, English));
    NavigateDiagnoseReport: |report| brief(&navigate_diagnose_document(report, None, English));
}
