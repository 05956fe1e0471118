//! Reports that earlier versions wrote are read by this one, and written back as they were: `tests/data/kept-VERSION`.

use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::Value;
use std::path::Path;
use tumble::report::{
    BatchReport, ChangesReport, CompareReport, DiagnoseReport, FitReport, HistoryReport, NavigateDiagnoseReport,
    NavigateReport, NoiseAnalysisReport, PlanReport, ReduceReport, ReportKind,
};

/// Through the type and back, as the program writes it.
fn through<T: DeserializeOwned + Serialize>(text: &str) -> Result<String, serde_json::Error> {
    Ok(serde_json::to_string_pretty(&serde_json::from_str::<T>(text)?)? + "\n")
}

#[test]
fn reports_of_earlier_versions_are_read_and_written_back() {
    let mut kinds = std::collections::BTreeSet::new();
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/kept-0.1");
    for entry in std::fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        if path.extension().is_none_or(|extension| extension != "json") {
            continue;
        }
        let text = std::fs::read_to_string(&path).expect("text");
        let kept: Value = serde_json::from_str(&text).expect("JSON");
        let kind: ReportKind = serde_json::from_value(kept["report"].clone()).expect("a kind of report");
        let back = match kind {
            ReportKind::Fit => through::<FitReport>(&text),
            ReportKind::Batch => through::<BatchReport>(&text),
            ReportKind::Compare => through::<CompareReport>(&text),
            ReportKind::CompareCalibrations => through::<ChangesReport>(&text),
            ReportKind::CompareHistory => through::<HistoryReport>(&text),
            ReportKind::Diagnose => through::<DiagnoseReport>(&text),
            ReportKind::Plan => through::<PlanReport>(&text),
            ReportKind::Navigate => through::<NavigateReport>(&text),
            ReportKind::NavigateDiagnose => through::<NavigateDiagnoseReport>(&text),
            ReportKind::Noise => through::<NoiseAnalysisReport>(&text),
            ReportKind::Reduce => through::<ReduceReport>(&text),
            other => panic!("a kind without a type: {other}"),
        };
        let back = back.unwrap_or_else(|error| panic!("{}: {error}", path.display()));
        assert!(back == text, "{} is written back as\n{back}", path.display());
        kinds.insert(kind);
    }
    // lines of a guide are new in this version
    let earlier = ReportKind::ALL.iter().filter(|kind| **kind != ReportKind::Guide).count();
    assert_eq!(kinds.len(), earlier, "one kept report of each kind: {kinds:?}");
}

/// A word that this version does not know is refused, with those that it knows.
#[test]
fn unknown_words_are_refused() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/kept-0.1");
    let text = std::fs::read_to_string(folder.join("fit-linear.json")).expect("text");
    let changed = text.replace("\"state\": \"free\"", "\"state\": \"loose\"");
    assert_ne!(changed, text);
    let error = serde_json::from_str::<FitReport>(&changed).expect_err("an unknown state").to_string();
    assert!(error.contains("loose") && error.contains("at-bound") && error.contains("not-estimable"), "{error}");
}
