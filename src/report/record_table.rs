//! What a fit of samples as rows adds to the table and to the page.

use super::record::{BinsReport, RecordReport};
use super::table::{plain, significant};
use crate::language::{Language, say};

/// How the record was read and what its residuals are like, for a terminal.
pub(super) fn text(report: &super::FitReport, lang: Language) -> String {
    let Some(record) = &report.record else { return String::new() };
    let line = say!(
        lang,
        "record-of-rows-read",
        rows = record.rows.to_string(),
        passes = lang.count(record.passes, "pass"),
        shown = record.shown.to_string()
    );
    let mut text = super::wrap::hanging(&line, 2) + "\n";
    let rows = means_rows(record);
    if !rows.is_empty() {
        let header = [
            say!(lang, "sensor"),
            say!(lang, "rows-in-a-mean"),
            say!(lang, "pairs-of-means"),
            say!(lang, "sd-over-that-of-independent-rows"),
            "p",
        ];
        text.push('\n');
        text.push_str(&plain(&header, &rows));
    }
    let rows = inputs_rows(record);
    if !rows.is_empty() {
        let header =
            [say!(lang, "sensor"), say!(lang, "lack-of-fit-over"), say!(lang, "chi-square"), say!(lang, "dof"), "p"];
        text.push('\n');
        text.push_str(&plain(&header, &rows));
    }
    text
}

/// Means of 1 row, of the longest means, and of lengths between them.
pub(super) fn means_rows(record: &RecordReport) -> Vec<Vec<String>> {
    const LINES: usize = 5;
    let mut rows = Vec::new();
    for own in &record.sensors {
        let every = own.means.len().div_ceil(LINES).max(1);
        let last = own.means.len().saturating_sub(1);
        for (_, test) in own.means.iter().enumerate().filter(|(k, _)| (last - k).is_multiple_of(every)) {
            rows.push(vec![
                own.sensor.clone(),
                test.rows.to_string(),
                test.pairs.to_string(),
                significant(test.ratio.sqrt(), 3),
                significant(test.p, 2),
            ]);
        }
    }
    rows
}

/// Lack of fit over each input.
pub(super) fn inputs_rows(record: &RecordReport) -> Vec<Vec<String>> {
    let row = |own: &BinsReport| {
        vec![
            own.sensor.clone(),
            own.input.clone(),
            significant(own.chi_square, 3),
            own.dof.to_string(),
            significant(own.p, 2),
        ]
    };
    record.inputs.iter().map(row).collect()
}
