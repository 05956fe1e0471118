//! A reduction as tables for a terminal.

use super::reduction::{ReduceReport, SegmentMeanReport};
use super::table::{count, plain, rounded, significant};

/// Every segment with its means, then what was rejected and what was odd; `all` shows where each uncertainty comes from.
pub fn reduce_table(report: &ReduceReport, all: bool) -> String {
    let rate = significant(1.0 / report.interval_s, 6);
    let mut text = format!(
        "{}: {} samples, {rate} a second; {} by {}\n",
        report.record,
        report.samples,
        count(report.segments.len(), "segment"),
        report.by
    );
    if report.block > 1 {
        text.push_str(&format!("Segments begin and end with blocks of {} samples.\n", report.block));
    }
    if all {
        text.push_str(&sources(report));
    } else {
        text.push_str(&means(report));
    }
    text.push_str(
        "\nu: 1.96 u on either side of the mean covers 95 %. It is learnt from all segments of a column\ntogether; the noise is taken to be the same in all of them.\n",
    );
    let each = || report.segments.iter().flat_map(|s| s.means.iter().map(move |m| (s, m)));
    let sloping = each().filter(|(_, m)| m.sloping == Some(true)).count();
    if sloping > 0 {
        text.push_str(&format!(
            "{sloping} of {} means have a slope (p < 0.01), more than their noise explains.\n",
            each().count()
        ));
    }
    for (segment, m) in each().filter(|(_, m)| m.noisier > 1.0) {
        text.push_str(&format!(
            "{} in segment {} is {} times noisier than elsewhere: its u is as much larger.\n",
            m.column,
            segment.position,
            significant(m.noisier, 2)
        ));
    }
    for segment in report.segments.iter().filter(|s| !s.notes.is_empty()) {
        text.push_str(&format!("segment {}: {}\n", segment.position, segment.notes.join("; ")));
    }
    for (segment, m) in each().filter(|(_, m)| !m.events.is_empty()) {
        text.push_str(&format!("segment {}, {}: {} (in the mean)\n", segment.position, m.column, events(m)));
    }
    if !report.rejected.is_empty() {
        text.push_str("\nNot used:\n");
        let rows: Vec<Vec<String>> = report
            .rejected
            .iter()
            .map(|r| vec![format!("{:.3}", r.start_s), format!("{:.3}", r.end_s), r.reason.clone()])
            .collect();
        text.push_str(&plain(&["from, s", "to, s", "reason"], &rows));
    }
    text
}

fn events(m: &SegmentMeanReport) -> String {
    m.events.iter().map(|(kind, n)| format!("{kind} {n}")).collect::<Vec<_>>().join(", ")
}

fn means(report: &ReduceReport) -> String {
    let columns: Vec<&str> =
        report.segments.first().map(|s| s.means.iter().map(|m| m.column.as_str()).collect()).unwrap_or_default();
    let mut text = String::new();
    // three columns stand beside each other on a terminal
    for (k, part) in columns.chunks(3).enumerate() {
        let mut header = vec!["position", "from, s", "to, s"];
        for column in part {
            header.extend([*column, "u"]);
        }
        let rows: Vec<Vec<String>> = report
            .segments
            .iter()
            .map(|s| {
                let mut row = vec![s.position.clone(), format!("{:.2}", s.start_s), format!("{:.2}", s.end_s)];
                for m in s.means.iter().skip(3 * k).take(part.len()) {
                    row.extend([rounded(m.mean, Some(m.u)), significant(m.u, 2)]);
                }
                row
            })
            .collect();
        text.push('\n');
        text.push_str(&plain(&header, &rows));
    }
    text
}

fn sources(report: &ReduceReport) -> String {
    let mut text = String::new();
    let columns = report.segments.first().map_or(0, |s| s.means.len());
    for k in 0..columns {
        let Some(name) = report.segments.first().and_then(|s| s.means.get(k)).map(|m| m.column.clone()) else {
            continue;
        };
        let rows: Vec<Vec<String>> = report
            .segments
            .iter()
            .filter_map(|s| Some((s, s.means.get(k)?)))
            .map(|(s, m)| {
                vec![
                    s.position.clone(),
                    s.n.to_string(),
                    rounded(m.mean, Some(m.u)),
                    significant(m.u, 2),
                    significant(m.u_white, 2),
                    significant(m.u_autocorrelation, 2),
                    significant(m.u_allan_floor, 2),
                    significant(m.effective_n, 2),
                    format!("{:.2}", m.lag1),
                    significant(m.slope_p, 2),
                ]
            })
            .collect();
        text.push_str(&format!("\n{name}\n"));
        text.push_str(&plain(
            &["position", "n", "mean", "u", "white", "autocorr", "Allan", "n_eff", "lag 1", "slope p"],
            &rows,
        ));
    }
    text
}
