//! The page of a reduction: the record with its segments, the means, and where their uncertainties come from.

use super::{Align, Figure, Page, Section, Table, Tone};
use crate::error::Result;
use crate::reduce::{Segment, Trace};
use crate::report::reduction::ReduceReport;
use crate::report::table::{count, rounded, significant};
use crate::report::{Input, VERSION, plot};

/// The page of a reduction.
///
/// Errors: a chart that cannot be drawn.
pub fn reduce_page(report: &ReduceReport, trace: &Trace, segments: &[Segment], inputs: &[Input]) -> Result<Page> {
    let mut page = Page::new("From samples to readings");
    page.subtitle = report.record.clone();
    page.facts = vec![
        ("Samples".into(), format!("{}, {} a second", report.samples, significant(1.0 / report.interval_s, 6))),
        ("Segments".into(), format!("{} by {}", report.segments.len(), report.by)),
    ];
    page.colophon = vec![("Program".into(), format!("tumble {VERSION}"))];
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
    let sentence = format!(
        "{}, {} not used. {sloping} of {} means have a slope (p < 0.01) that their noise does not explain; {} within segments (none was left out of a mean).",
        count(report.segments.len(), "segment"),
        count(report.rejected.len(), "stretch").replace("stretchs", "stretches"),
        each().count(),
        count(odd as usize, "odd sample"),
    );
    let figure = Figure {
        caption: "The whole record; segments are shaded.".into(),
        description: format!(
            "{} panels, one for each column, against time; {} shaded segments.",
            trace.channels.len(),
            report.segments.len()
        ),
        svg: plot::record(trace, segments)?,
        wide: true,
    };
    page = page.section(Section::new("Record").verdict(tone, sentence).figures(vec![figure]));
    let mut section = Section::new("Means").prose(
        "1.96 `u` on either side of a mean covers 95 %. `u` is learnt from all segments of a column together and holds what that costs; beside it what it would be for noise without memory, with the sum of the autocorrelations, and as the Allan deviation at the segment's length.",
    );
    let mut table = Table::new(&[
        ("position", Align::Left),
        ("from, s", Align::Decimal),
        ("to, s", Align::Decimal),
        ("column", Align::Left),
        ("mean", Align::Decimal),
        ("u", Align::Decimal),
        ("white", Align::Decimal),
        ("autocorr.", Align::Decimal),
        ("Allan", Align::Decimal),
        ("n", Align::Right),
        ("effective n", Align::Decimal),
        ("slope p", Align::Decimal),
        ("odd", Align::Left),
    ]);
    table.small = true;
    for s in &report.segments {
        for (k, m) in s.means.iter().enumerate() {
            let first = k == 0;
            let odd = m.events.iter().map(|(kind, n)| format!("{kind} {n}")).collect::<Vec<_>>().join(", ");
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
    let mut rejected = Table::new(&[("from, s", Align::Decimal), ("to, s", Align::Decimal), ("reason", Align::Left)]);
    for r in &report.rejected {
        rejected.row(vec![format!("{:.3}", r.start_s), format!("{:.3}", r.end_s), r.reason.clone()]);
    }
    Ok(page.section(Section::new("Not used").table(rejected)))
}
