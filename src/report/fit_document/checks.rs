//! Sections of a fit's document on what was checked: agreement of the readings, constraints, the robust estimator, Monte Carlo.

use super::super::record::{BinsReport, RecordReport};
use super::super::{ARCSEC, FitReport};
use crate::campaign::Kind;
use crate::document::number::{level, rounded, significant};
use crate::document::{Align, Cell, Detail, Section, Table, Tone};
use crate::language::{Language, say};

/// The checks of the readings.
pub(super) fn checks(report: &FitReport, lang: Language) -> Section {
    let checks = &report.checks;
    let mut section = Section::new(say!(lang, "checks"));
    if let Some(record) = &report.record {
        section = record_tables(section, record, lang);
    }
    section = section.full();
    let mut tests =
        Table::new(&[(say!(lang, "test"), Align::Left), (say!(lang, "statistic"), Align::Left), ("p", Align::Right)]);
    if let Some(test) = checks.misfit() {
        let by_replicates = checks.lack_of_fit.is_some();
        tests.row(vec![
            Cell::from(if by_replicates { say!(lang, "lack-of-fit") } else { say!(lang, "lack-of-fit-by-position") }),
            say!(
                lang,
                "f-test",
                f = Cell::digits(test.f, 4).text(),
                between_dof = test.between_dof,
                pure_error_dof = test.pure_error_dof
            )
            .into(),
            Cell::Probability(test.p),
        ]);
    }
    for (sensor, test) in &checks.runs {
        tests.row(vec![
            Cell::from(say!(lang, "runs-of", sensor)),
            say!(lang, "runs-expected", runs = test.runs, expected = significant(test.expected, 3)).into(),
            Cell::Probability(test.p),
        ]);
    }
    if let Some(test) = &checks.normality {
        tests.row(vec![
            Cell::from(say!(lang, "normality")),
            format!("Shapiro-Francia W' = {}", significant(test.w, 4)).into(),
            Cell::Probability(test.p),
        ]);
    }
    section = section.table(tests);
    if let Some(snooping) = &checks.snooping {
        let mut table = Table::new(&[
            (say!(lang, "reading"), Align::Left),
            (say!(lang, "position"), Align::Left),
            (say!(lang, "sensor"), Align::Left),
            (say!(lang, "shift"), Align::Decimal),
            ("u", Align::Decimal),
            ("w", Align::Decimal),
            ("p", Align::Right),
        ]);
        for s in &snooping.suspects {
            table.row(vec![
                s.index.into(),
                s.position.as_str().into(),
                s.sensor.as_str().into(),
                Cell::Value(s.shift, Some(s.u)),
                Cell::Value(s.u, Some(s.u)),
                Cell::Decimals(s.w, 2),
                Cell::Probability(s.p),
            ]);
        }
        table.caption = lang.title(&lang.term("suspicious-readings"));
        table.note = say!(lang, "shift-how-far-the-reading-is-off", tested = snooping.tested);
        section = section.table(table);
    }
    let without = checks.snooping.as_ref().filter(|s| !s.suspects.is_empty()).map(|s| &s.without_suspects);
    let mut columns = vec![
        (say!(lang, "parameter"), Align::Left),
        (say!(lang, "reading"), Align::Right),
        (say!(lang, "shift"), Align::Right),
    ];
    if without.is_some() {
        columns.push((say!(lang, "change-without-suspects"), Align::Right));
    }
    columns.push((say!(lang, "unit"), Align::Left));
    let mut table = Table::new(&columns);
    table.small = true;
    for p in &report.parameters {
        let Some(external) = checks.external.get(&p.id) else { continue };
        let mut row = vec![Cell::name(&p.id), external.index.into(), Cell::Digits(external.effect, 3)];
        if let Some(changes) = without {
            row.push(Cell::digits(changes.get(&p.id).copied(), 3));
        }
        row.push(if p.kind == Kind::Tilt { "arcsec".into() } else { p.unit.as_str().into() });
        table.row(row);
    }
    table.caption = say!(lang, "external-reliability").into();
    table.note = say!(lang, "effect-what-the-smallest-detectable-fault-of").into();
    section.table(table)
}

/// Lines of means of a sensor: of 1 row, of the longest means, and of lengths between them.
const LINES: usize = 5;

/// A record that was streamed: means of its residuals, lack of fit over its inputs, the largest residuals.
fn record_tables(section: Section, record: &RecordReport, lang: Language) -> Section {
    let mut means = Table::new(&[
        (say!(lang, "sensor"), Align::Left),
        (say!(lang, "rows-in-a-mean"), Align::Right),
        (say!(lang, "sd-over-that-of-independent-rows"), Align::Decimal),
        ("p", Align::Right),
    ]);
    for own in &record.sensors {
        let every = own.means.len().div_ceil(LINES).max(1);
        let last = own.means.len().saturating_sub(1);
        for (_, test) in own.means.iter().enumerate().filter(|(k, _)| (last - k).is_multiple_of(every)) {
            means.row(vec![
                own.sensor.as_str().into(),
                test.rows.to_string().into(),
                Cell::Digits(test.ratio.sqrt(), 3),
                Cell::Probability(test.p),
            ]);
        }
    }
    let [rows, shown] = [record.rows, record.shown as u64].map(|n| n.to_string());
    let read = say!(lang, "record-of-rows-read", rows, shown);
    let mut inputs = Table::new(&[
        (say!(lang, "sensor"), Align::Left),
        (say!(lang, "input"), Align::Left),
        (say!(lang, "chi-square"), Align::Decimal),
        (say!(lang, "dof"), Align::Right),
        ("p", Align::Right),
    ]);
    for own in &record.inputs {
        let BinsReport { sensor, input, chi_square, dof, p, .. } = own;
        inputs.row(vec![
            sensor.as_str().into(),
            input.as_str().into(),
            Cell::Digits(*chi_square, 3),
            dof.to_string().into(),
            Cell::Probability(*p),
        ]);
    }
    inputs.caption = lang.title(say!(lang, "lack-of-fit"));
    let mut largest = Table::new(&[
        (say!(lang, "sensor"), Align::Left),
        (say!(lang, "row-of-the-record"), Align::Right),
        (say!(lang, "value"), Align::Decimal),
        (say!(lang, "residual"), Align::Decimal),
        ("w", Align::Decimal),
        ("p", Align::Right),
    ]);
    for own in &record.sensors {
        for far in own.largest.iter().take(5) {
            largest.row(vec![
                own.sensor.as_str().into(),
                far.row.to_string().into(),
                Cell::Digits(far.value, 6),
                Cell::Digits(far.residual, 3),
                Cell::Decimals(far.w, 2),
                Cell::Probability(far.p),
            ]);
        }
    }
    largest.small = true;
    section.prose(read).table(means).table(inputs).full().table(largest)
}

/// Constraints, the robust estimator and remounting, where the fit has them.
pub(super) fn conditions(report: &FitReport, lang: Language) -> Section {
    let mut section = Section::new(say!(lang, "constraints-and-weights"));
    if let Some(constraints) = &report.constraints {
        let mut table = Table::new(&[
            (say!(lang, "constraint"), Align::Right),
            ("", Align::Left),
            (say!(lang, "state"), Align::Left),
            (say!(lang, "side"), Align::Left),
            (say!(lang, "cost-in-chi-square"), Align::Right),
        ]);
        for c in &constraints.list {
            table.row(vec![
                c.index.into(),
                Cell::name(&c.text),
                lang.term(&c.state.to_string()).into(),
                c.side.map_or("".into(), |side| lang.term(&side.to_string()).into()),
                Cell::digits(c.cost, 3),
            ]);
        }
        section = section.table(table);
    }
    if let Some(robust) = &report.robust {
        let low: Vec<String> = robust.downweighted.iter().map(usize::to_string).collect();
        let low = if low.is_empty() { say!(lang, "none").into() } else { low.join(lang.comma()) };
        section = section.prose(say!(lang, "robust-estimator", method = robust.method.to_string())).prose(say!(
            lang,
            "less-than-half-of-their-weight-readings",
            low
        ));
    }
    section
}

/// Each iteration of Gauss-Newton.
pub(super) fn iterations(report: &FitReport, lang: Language) -> Section {
    let mut table = Table::new(&[
        ("#", Align::Right),
        (say!(lang, "weighted-sum-of-squares"), Align::Decimal),
        (say!(lang, "step-of-the-predictions"), Align::Right),
        (say!(lang, "share-of-the-step"), Align::Decimal),
    ]);
    table.small = true;
    for (k, own) in report.convergence.iter().flat_map(|record| &record.iterations).enumerate() {
        let (sum, step) = (Cell::Digits(own.sum_of_squares, 6), Cell::Digits(own.step, 3));
        table.row(vec![(k + 1).into(), sum, step, Cell::Digits(own.share, 3)]);
    }
    Section::new(say!(lang, "iterations")).full().table(table)
}

/// Monte Carlo compared with the first order.
pub(super) fn monte_carlo(report: &FitReport, lang: Language) -> Section {
    let Some(drawn) = &report.monte_carlo else { return Section::new(say!(lang, "monte-carlo")) };
    let interval = say!(lang, "checks-page-interval", level = level(report.level()));
    let mut table = Table::new(&[
        (say!(lang, "quantity"), Align::Left),
        (say!(lang, "mean"), Align::Decimal),
        ("u", Align::Decimal),
        (&interval, Align::Right),
        (say!(lang, "shortest"), Align::Right),
        (say!(lang, "first-order"), Align::Right),
        (say!(lang, "unit"), Align::Left),
    ])
    .at(Detail::Roomy, &[4]);
    for output in &drawn.outputs {
        let parameter = report.parameters.iter().find(|p| p.id == output.id);
        let derived = report.derived.iter().find(|d| d.id == output.id);
        let angle = parameter.is_some_and(|p| p.kind == Kind::Tilt) || derived.is_some_and(|d| d.arcsec.is_some());
        let (scale, unit) = match (angle, parameter) {
            (true, _) => (ARCSEC, "arcsec"),
            (false, Some(p)) => (1.0, p.unit.as_str()),
            (false, None) => (1.0, ""),
        };
        let u = Some(output.u * scale);
        let pair = |[a, b]: [f64; 2]| say!(lang, "from-to", a = rounded(a * scale, u), b = rounded(b * scale, u));
        table.row(vec![
            Cell::name(&output.id),
            Cell::Value(output.mean * scale, u),
            Cell::value(u, u),
            pair(output.interval).into(),
            pair(output.shortest).into(),
            output.first_order.map_or_else(Cell::absent, |ends| pair(ends).into()),
            unit.into(),
        ]);
        table.tone(if output.first_order_agrees == Some(false) { Tone::Caution } else { Tone::Plain });
    }
    let trials = say!(lang, "of-trials-seed", trials = drawn.trials, asked = drawn.asked, seed = drawn.seed);
    let section = Section::new(say!(lang, "monte-carlo"))
        .list(drawn.verdict.iter().map(|line| lang.sentence(&line.say(lang))).collect())
        .table(table)
        .prose(say!(lang, "marked-the-first-order-is-not-good", trials));
    match drawn.joint.as_ref().and_then(|joint| Some((joint, joint.k_p?))) {
        Some((joint, k)) => {
            let (order, k) = (joint.order.join(lang.comma()), significant(k, 4));
            section.prose(lang.sentence(&say!(lang, "coverage-ellipsoid-of-k-p", order, k)))
        }
        None => section,
    }
}
