//! The document of a reduction: the record with its segments, the means, and where their uncertainties come from.

use super::Input;
use super::colophon::begin;
use super::reduction::{ReduceReport, SegmentMeanReport};
use crate::document::chart::{Chart, RecordChart};
use crate::document::number::significant;
use crate::document::{Align, Cell, Document, Figure, Section, Table, Tone};
use crate::language::{Language, say};
use crate::reduce::{Segment, Trace};

/// The document of a reduction; `record` is its picture, `sources` puts before a reader of a terminal where each uncertainty comes from.
pub fn reduce_document(
    report: &ReduceReport,
    record: Option<RecordChart>,
    inputs: &[Input],
    sources: bool,
    lang: Language,
) -> Document {
    let mut document = begin(say!(lang, "from-samples-to-readings"), inputs, lang);
    let rate = significant(1.0 / report.interval_s, 6);
    document.facts = vec![
        (say!(lang, "record").into(), report.record.clone()),
        (say!(lang, "samples").into(), report.samples.to_string()),
        (say!(lang, "sampling-rate").into(), format!("{rate} Hz")),
        (
            say!(lang, "segments").into(),
            say!(lang, "grouped-by", what = report.segments.len().to_string(), by = lang.name(&report.by)),
        ),
    ];
    let mut result = Section::new(say!(lang, "record"));
    let (tone, sentence) = verdict(report, lang);
    result = result.verdict(tone, sentence);
    for text in notes(report, lang) {
        result = result.verdict(Tone::Caution, text);
    }
    if let Some(chart) = record {
        let caption = say!(lang, "the-whole-record-segments-are-shaded");
        result = result.figures(vec![Figure::new(caption, Chart::Record(chart), true)]);
    }
    let mut means = Section::new(say!(lang, "readings"));
    means = if sources { means } else { means.table(overview(report, lang)).full() };
    means = means.table(table(report, lang)).brief().prose(say!(lang, "u-on-either-side-of-a-mean"));
    if report.block > 1 {
        means = means.prose(say!(lang, "segments-begin-and-end-with-blocks-of", block = report.block.to_string()));
    }
    let mut rejected = Table::new(&[
        (say!(lang, "from-s"), Align::Decimal),
        (say!(lang, "to-s"), Align::Decimal),
        (say!(lang, "reason"), Align::Left),
    ]);
    for r in &report.rejected {
        rejected.row(vec![Cell::Decimals(r.start_s, 3), Cell::Decimals(r.end_s, 3), lang.name(&r.reason).into()]);
    }
    document.section(result).section(means).section(Section::new(say!(lang, "not-used-2")).table(rejected))
}

/// The picture of a record: for each step of it the smallest and largest value of each channel.
pub fn record_chart(trace: &Trace, segments: &[Segment]) -> RecordChart {
    const STEPS: usize = 820;
    let channels = trace.channels.iter().map(|channel| {
        let step = (channel.means.len() / STEPS).max(1);
        let course = channel.means.chunks(step).enumerate().flat_map(|(k, chunk)| {
            let at = trace.time((k * step * trace.block) as u64);
            let ends = chunk.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(*v), b.max(*v)));
            [Some((at, ends.0)), (chunk.len() > 1).then_some((at, ends.1))].into_iter().flatten()
        });
        let unit = if channel.unit.is_empty() { String::new() } else { format!(", {}", channel.unit) };
        (format!("{}{unit}", channel.name), course.collect())
    });
    let pieces = segments.iter().flat_map(|segment| &segment.pieces);
    RecordChart {
        channels: channels.collect(),
        segments: pieces.map(|piece| (trace.time(piece.start), trace.time(piece.end))).collect(),
        end: trace.time(trace.samples.saturating_sub(1)).max(trace.interval),
    }
}

fn each(report: &ReduceReport) -> impl Iterator<Item = (&str, &SegmentMeanReport)> {
    report.segments.iter().flat_map(|s| s.means.iter().map(|m| (s.position.as_str(), m)))
}

/// Segments, what was left out, slopes and odd samples, in one sentence.
fn verdict(report: &ReduceReport, lang: Language) -> (Tone, String) {
    let all = each(report).count();
    let sloping = each(report).filter(|(_, m)| m.sloping == Some(true)).count();
    let odd: u64 = each(report).flat_map(|(_, m)| m.events.values()).sum();
    let tone = match report.segments.is_empty() {
        true => Tone::Bad,
        false if odd > 0 || sloping * 20 > all => Tone::Caution,
        false => Tone::Good,
    };
    let sentence = say!(
        lang,
        "not-used-of-means-have-a-slope",
        segments = report.segments.len().to_string(),
        stretches = report.rejected.len().to_string(),
        sloping = sloping.to_string(),
        all = all.to_string(),
        odd = odd.to_string()
    );
    (tone, sentence)
}

/// What a reader should know of single segments.
fn notes(report: &ReduceReport, lang: Language) -> Vec<String> {
    let mut notes = Vec::new();
    for (segment, m) in each(report).filter(|(_, m)| m.noisier > 1.0) {
        let [column, segment, times] = [m.column.clone(), segment.to_string(), significant(m.noisier, 2)];
        let apart = m.apart == Some(true);
        notes.push(say!(lang, "noisier-segment", apart, column, segment, times));
    }
    for segment in report.segments.iter().filter(|s| !s.notes.is_empty()) {
        let said: Vec<_> = segment.notes.iter().map(|note| lang.name(note)).collect();
        let notes_of = say!(lang, "reduction-segment", segment = segment.position, notes = said.join(lang.semicolon()));
        notes.push(notes_of);
    }
    notes
}

fn events(m: &SegmentMeanReport, lang: Language) -> String {
    let event = |(kind, n): (&crate::reduce::EventKind, &u64)| format!("{} {n}", lang.term(&kind.to_string()));
    m.events.iter().map(event).collect::<Vec<_>>().join(", ")
}

/// A row for each segment, its means beside one another.
fn overview(report: &ReduceReport, lang: Language) -> Table {
    let means = || report.segments.first().into_iter().flat_map(|s| &s.means);
    let mut columns = vec![
        (say!(lang, "position"), Align::Left),
        (say!(lang, "from-s"), Align::Decimal),
        (say!(lang, "to-s"), Align::Decimal),
    ];
    columns.extend(means().flat_map(|m| [(m.column.as_str(), Align::Decimal), ("u", Align::Decimal)]));
    let mut table = Table::new(&columns);
    for s in &report.segments {
        let mut row = vec![s.position.as_str().into(), Cell::Decimals(s.start_s, 2), Cell::Decimals(s.end_s, 2)];
        row.extend(s.means.iter().flat_map(|m| [Cell::Value(m.mean, Some(m.u)), Cell::Digits(m.u, 2)]));
        table.row(row);
    }
    table
}

/// A row for each mean, with what its uncertainty would be in other ways.
fn table(report: &ReduceReport, lang: Language) -> Table {
    let mut table = Table::new(&[
        (say!(lang, "position"), Align::Left),
        (say!(lang, "column"), Align::Left),
        ("n", Align::Right),
        (say!(lang, "mean"), Align::Decimal),
        ("u", Align::Decimal),
        (say!(lang, "white"), Align::Decimal),
        (say!(lang, "autocorr"), Align::Decimal),
        (say!(lang, "allan"), Align::Decimal),
        (say!(lang, "n-eff"), Align::Decimal),
        (say!(lang, "lag"), Align::Decimal),
        (say!(lang, "slope-p"), Align::Decimal),
        (say!(lang, "odd"), Align::Left),
    ])
    .at(crate::document::Detail::Full, &[11]);
    table.small = true;
    for s in &report.segments {
        for (k, m) in s.means.iter().enumerate() {
            table.row(vec![
                if k == 0 { s.position.as_str().into() } else { "".into() },
                Cell::name(&m.column),
                if k == 0 { s.n.to_string().into() } else { "".into() },
                Cell::Value(m.mean, Some(m.u)),
                Cell::Digits(m.u, 2),
                Cell::Digits(m.u_white, 2),
                Cell::Digits(m.u_autocorrelation, 2),
                Cell::Digits(m.u_allan_floor, 2),
                Cell::Digits(m.effective_n, 2),
                Cell::Decimals(m.lag1, 2),
                Cell::Probability(m.slope_p),
                events(m, lang).into(),
            ]);
            table.rule(k == 0);
        }
    }
    table
}
