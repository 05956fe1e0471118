//! The page of a reduction: the record with its segments, the means, and where their uncertainties come from.

use super::{Align, Figure, Page, Section, Table, Tone};
use crate::error::Result;
use crate::language::{Language, say};
use crate::number;
use crate::reduce::{Segment, Trace};
use crate::report::reduction::ReduceReport;
use crate::report::table::{rounded, significant};
use crate::report::{Input, VERSION, plot};

/// The page of a reduction.
///
/// Errors: a chart that cannot be drawn.
pub fn reduce_page(
    report: &ReduceReport,
    trace: &Trace,
    segments: &[Segment],
    inputs: &[Input],
    lang: Language,
) -> Result<Page> {
    let mut page = Page::new(say!(lang, "from-samples-to-readings"));
    page.language = lang;
    page.subtitle = report.record.clone();
    page.facts = vec![
        (
            say!(lang, "samples").into(),
            say!(
                lang,
                "a-second",
                samples = report.samples.to_string(),
                rate = significant(1.0 / report.interval_s, 6)
            ),
        ),
        (
            say!(lang, "segments").into(),
            say!(lang, "segments-by", n = report.segments.len().to_string(), by = lang.name(&report.by)),
        ),
    ];
    page.colophon = vec![(say!(lang, "program").into(), format!("tumble {VERSION}"))];
    page.colophon.extend(inputs.iter().map(|input| (input.name.clone(), format!("SHA-256 {}", input.sha256))));
    let each = || report.segments.iter().flat_map(|s| &s.means);
    let sloping = each().filter(|m| m.sloping == Some(true)).count();
    let odd: u64 = each().flat_map(|m| m.events.values()).sum();
    let tone = if report.segments.is_empty() {
        Tone::Bad
    } else if odd > 0 || sloping * 20 > each().count() {
        Tone::Caution
    } else {
        Tone::Good
    };
    let [sloping, all] = [sloping, each().count()].map(|n| n.to_string());
    let sentence = say!(
        lang,
        "not-used-of-means-have-a-slope",
        segments = lang.count(report.segments.len(), "segment"),
        stretches = lang.count(report.rejected.len(), "stretch"),
        sloping,
        all,
        odd = lang.count(number::index(odd), "odd-sample")
    );
    let figure = Figure {
        caption: say!(lang, "the-whole-record-segments-are-shaded").into(),
        description: say!(
            lang,
            "panels-one-for-each-column-against-time",
            panels = trace.channels.len().to_string(),
            segments = report.segments.len().to_string()
        ),
        svg: plot::record(trace, segments, lang)?,
        wide: true,
    };
    page = page.section(Section::new(say!(lang, "record")).verdict(tone, sentence).figures(vec![figure]));
    let mut section = Section::new(say!(lang, "means")).prose(say!(lang, "u-on-either-side-of-a-mean"));
    let mut table = Table::new(&[
        (say!(lang, "per-position"), Align::Left),
        (say!(lang, "from-s"), Align::Decimal),
        (say!(lang, "to-s"), Align::Decimal),
        (say!(lang, "column"), Align::Left),
        (say!(lang, "mean"), Align::Decimal),
        ("u", Align::Decimal),
        (say!(lang, "white"), Align::Decimal),
        (say!(lang, "autocorr-2"), Align::Decimal),
        (say!(lang, "allan"), Align::Decimal),
        ("n", Align::Right),
        (say!(lang, "effective-n"), Align::Decimal),
        (say!(lang, "slope-p"), Align::Decimal),
        (say!(lang, "odd"), Align::Left),
    ]);
    table.small = true;
    for s in &report.segments {
        for (k, m) in s.means.iter().enumerate() {
            let first = k == 0;
            let odd = m
                .events
                .iter()
                .map(|(kind, n)| format!("{} {n}", lang.term("event", &kind.to_string())))
                .collect::<Vec<_>>()
                .join(", ");
            table.row(vec![
                if first { s.position.clone() } else { String::new() },
                if first { format!("{:.2}", s.start_s) } else { String::new() },
                if first { format!("{:.2}", s.end_s) } else { String::new() },
                format!("`{}`", m.column),
                rounded(m.mean, Some(m.u)),
                significant(m.u, 2),
                significant(m.u_white, 2),
                significant(m.u_autocorrelation, 2),
                significant(m.u_allan_floor, 2),
                if first { s.n.to_string() } else { String::new() },
                significant(m.effective_n, 2),
                significant(m.slope_p, 2),
                odd,
            ]);
            table.rows.last_mut().into_iter().for_each(|row| row.rule = first);
        }
    }
    section = section.table(table);
    page = page.section(section);
    let mut rejected = Table::new(&[
        (say!(lang, "from-s"), Align::Decimal),
        (say!(lang, "to-s"), Align::Decimal),
        (say!(lang, "reason"), Align::Left),
    ]);
    for r in &report.rejected {
        rejected.row(vec![format!("{:.3}", r.start_s), format!("{:.3}", r.end_s), lang.name(&r.reason).into_owned()]);
    }
    Ok(page.section(Section::new(say!(lang, "not-used-2")).table(rejected)))
}
