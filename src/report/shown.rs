//! Answers and reports as text: the table that the program prints, in English, within the width of a terminal.

use super::{
    BatchReport, ChangesReport, CompareReport, DiagnoseReport, FitReport, HistoryReport, NoiseAnalysisReport,
    PlanReport, ReduceReport, batch_table, changes_table, compare_report, diagnose_table, fit_summary, history_table,
    noise_table, plan_table, reduce_table, table, wrap,
};
#[cfg(feature = "navigate")]
use super::{NavigateDiagnoseReport, NavigateReport, navigate_diagnose_table, navigate_table};
use crate::compare::Comparison;
use crate::fit::Fit;
use crate::language::Language::English;
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
    Fit: |fit| fit_summary(fit).to_string();
    Comparison: |comparison| compare_report(comparison).to_string();
    FitReport: |report| table::fit(report, false, English);
    CompareReport: |report| table::compare(report, English);
    ChangesReport: |report| changes_table(report, English);
    HistoryReport: |report| history_table(report, English);
    DiagnoseReport: |report| diagnose_table(report, English);
    PlanReport: |report| plan_table(report, false, English);
    BatchReport: |report| batch_table(report, English);
    NoiseAnalysisReport: |report| noise_table(report, false, English);
    ReduceReport: |report| reduce_table(report, false, English);
}

#[cfg(feature = "navigate")]
shown! {
    NavigateReport: |report| navigate_table(report, English);
    NavigateDiagnoseReport: |report| navigate_diagnose_table(report, English);
}
