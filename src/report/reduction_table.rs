//! A reduction as tables for a terminal.

use super::reduction::{ReduceReport, SegmentMeanReport};
use super::table::{plain, rounded, significant};
use super::wrap::hanging;
use crate::language::{Language, say};

/// Every segment with its means, then what was rejected and what was odd; `all` shows where each uncertainty comes from.
pub fn reduce_table(report: &ReduceReport, all: bool, lang: Language) -> String {
    let rate = significant(1.0 / report.interval_s, 6);
    let mut text = format!(
        "{}\n",
        say!(
            lang,
            "samples-a-second-by",
            record = report.record,
            samples = report.samples.to_string(),
            rate,
            segments = lang.count(report.segments.len(), "segment"),
            by = lang.name(&report.by)
        )
    );
    if report.block > 1 {
        text.push_str(&format!(
            "{}\n",
            say!(lang, "segments-begin-and-end-with-blocks-of", block = report.block.to_string())
        ));
    }
    if all {
        text.push_str(&sources(report, lang));
    } else {
        text.push_str(&means(report, lang));
    }
    let note = say!(lang, "u-u-on-either-side-of-the");
    text.push_str(&format!("\n{}\n", hanging(note, 0)));
    let each = || report.segments.iter().flat_map(|s| s.means.iter().map(move |m| (s, m)));
    let sloping = each().filter(|(_, m)| m.sloping == Some(true)).count();
    if sloping > 0 {
        let [sloping, all] = [sloping, each().count()].map(|n| n.to_string());
        text.push_str(&format!("{}\n", say!(lang, "of-means-have-a-slope-p-more", sloping, all)));
    }
    for (segment, m) in each().filter(|(_, m)| m.noisier > 1.0) {
        let [column, segment, times] = [m.column.clone(), segment.position.clone(), significant(m.noisier, 2)];
        let said = match m.apart {
            Some(true) => say!(lang, "in-segment-the-noise-is-another", column, segment, times),
            _ => say!(lang, "in-segment-is-times-noisier-than-elsewhere", column, segment, times),
        };
        text.push_str(&format!("{said}\n"));
    }
    for segment in report.segments.iter().filter(|s| !s.notes.is_empty()) {
        let notes: Vec<_> = segment.notes.iter().map(|note| lang.name(note)).collect();
        text.push_str(&format!(
            "{}\n",
            say!(lang, "reduction-table-segment", segment = segment.position, notes = notes.join(lang.semicolon()))
        ));
    }
    for (segment, m) in each().filter(|(_, m)| !m.events.is_empty()) {
        text.push_str(&format!(
            "{}\n",
            say!(lang, "segment-in-the-mean", segment = segment.position, column = m.column, events = events(m, lang))
        ));
    }
    if !report.rejected.is_empty() {
        text.push_str(&format!("\n{}\n", say!(lang, "not-used")));
        let rows: Vec<Vec<String>> = report
            .rejected
            .iter()
            .map(|r| vec![format!("{:.3}", r.start_s), format!("{:.3}", r.end_s), lang.name(&r.reason).into_owned()])
            .collect();
        text.push_str(&plain(&[say!(lang, "from-s"), say!(lang, "to-s"), say!(lang, "reason")], &rows));
    }
    text
}

fn events(m: &SegmentMeanReport, lang: Language) -> String {
    m.events
        .iter()
        .map(|(kind, n)| format!("{} {n}", lang.term("event", &kind.to_string())))
        .collect::<Vec<_>>()
        .join(", ")
}

fn means(report: &ReduceReport, lang: Language) -> String {
    let columns: Vec<&str> =
        report.segments.first().map(|s| s.means.iter().map(|m| m.column.as_str()).collect()).unwrap_or_default();
    let mut text = String::new();
    // three columns stand beside each other on a terminal
    for (k, part) in columns.chunks(3).enumerate() {
        let mut header = vec![say!(lang, "per-position"), say!(lang, "from-s"), say!(lang, "to-s")];
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

fn sources(report: &ReduceReport, lang: Language) -> String {
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
            &[
                say!(lang, "per-position"),
                "n",
                say!(lang, "mean"),
                "u",
                say!(lang, "white"),
                say!(lang, "autocorr"),
                say!(lang, "allan"),
                say!(lang, "n-eff"),
                say!(lang, "lag"),
                say!(lang, "slope-p"),
            ],
            &rows,
        ));
    }
    text
}
