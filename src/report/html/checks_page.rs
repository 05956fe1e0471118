//! Sections of a fit's page on what was checked: agreement of the readings, constraints, the robust estimator, Monte Carlo.

use super::{Align, Section, Table, Tone, cells};
use crate::campaign::Kind;
use crate::language::{Language, say};
use crate::report::fit_checks::PRINTED;
use crate::report::fit_constraints::ConstraintsStatus;
use crate::report::table::{rounded, significant};
use crate::report::{ARCSEC, FitReport, RecordReport, record_table};

/// What the checks found, as verdicts for the head of the page.
pub(super) fn verdicts(report: &FitReport, lang: Language) -> Vec<(Tone, String)> {
    let mut verdicts = Vec::new();
    if let Some(constraints) = &report.constraints {
        let tone = if constraints.status == ConstraintsStatus::Met { Tone::Plain } else { Tone::Bad };
        verdicts.push((tone, lang.sentence(&constraints.verdict.say(lang))));
    }
    if let Some(test) = report.checks.misfit().filter(|test| test.rejected) {
        let p = significant(test.p, 3);
        let text = match report.checks.lack_of_fit {
            Some(_) => say!(lang, "lack-of-fit-the-model-leaves-more", p),
            None => say!(lang, "lack-of-fit-the-model-leaves-more-between-positions", p),
        };
        verdicts.push((if test.is_beyond_doubt() { Tone::Bad } else { Tone::Caution }, text));
    }
    let suspects = report.checks.snooping.as_ref().map(|s| s.suspects.as_slice()).unwrap_or_default();
    if !suspects.is_empty() {
        let more = (suspects.len() > PRINTED).then(|| "...".to_string());
        let numbers = suspects.iter().take(PRINTED).map(|s| s.index.to_string());
        let numbers: Vec<String> = numbers.chain(more).collect();
        verdicts.push((
            Tone::Caution,
            say!(lang, "suspicious-see-the-checks", numbers = numbers.join(lang.comma()), n = suspects.len()),
        ));
    }
    if report.is_misfit() {
        verdicts.push((Tone::Plain, lang.sentence(say!(lang, "diagnose-says-what-is-missing"))));
    }
    if let Some(robust) = report.robust.as_ref().filter(|robust| !robust.converged) {
        verdicts
            .push((Tone::Bad, say!(lang, "the-robust-estimator-did-not-settle", method = robust.method.to_string())));
    }
    verdicts
}

/// The checks of the readings.
pub(super) fn checks(report: &FitReport, lang: Language) -> Section {
    let checks = &report.checks;
    let mut section = Section::new(say!(lang, "checks"))
        .list(checks.verdict.iter().map(|line| lang.sentence(&line.say(lang))).collect());
    let mut tests =
        Table::new(&[(say!(lang, "test"), Align::Left), (say!(lang, "statistic"), Align::Left), ("p", Align::Right)]);
    if let Some(test) = checks.misfit() {
        let by_replicates = checks.lack_of_fit.is_some();
        tests.row(vec![
            if by_replicates { say!(lang, "lack-of-fit") } else { say!(lang, "lack-of-fit-by-position") }.into(),
            say!(
                lang,
                "f-with-and",
                f = cells::digits(test.f, 4),
                between_dof = test.between_dof,
                pure_error_dof = test.pure_error_dof
            ),
            significant(test.p, 3),
        ]);
    }
    for (sensor, test) in &checks.runs {
        tests.row(vec![
            say!(lang, "runs-of", sensor),
            say!(lang, "runs-expected", runs = test.runs, expected = significant(test.expected, 3)),
            significant(test.p, 3),
        ]);
    }
    if let Some(test) = &checks.normality {
        tests.row(vec![
            say!(lang, "normality").into(),
            format!("Shapiro-Francia W' = {}", significant(test.w, 4)),
            significant(test.p, 3),
        ]);
    }
    section = section.table(tests);
    if let Some(record) = &report.record {
        section = record_tables(section, record, lang);
    }
    if let Some(snooping) = &checks.snooping {
        let mut table = Table::new(&[
            (say!(lang, "suspicious-reading"), Align::Left),
            (say!(lang, "position"), Align::Left),
            (say!(lang, "sensor"), Align::Left),
            (say!(lang, "shift"), Align::Decimal),
            ("u", Align::Decimal),
            ("w", Align::Decimal),
            ("p", Align::Right),
        ]);
        for s in &snooping.suspects {
            table.row(vec![
                s.index.to_string(),
                s.position.clone(),
                s.sensor.clone(),
                rounded(s.shift, Some(s.u)),
                rounded(s.u, Some(s.u)),
                format!("{:.2}", s.w),
                significant(s.p, 3),
            ]);
        }
        table.note = say!(lang, "shift-how-far-the-reading-is-off", tested = snooping.tested);
        section = section.table(table);
    }
    let without = checks.snooping.as_ref().filter(|s| !s.suspects.is_empty()).map(|s| &s.without_suspects);
    let mut columns = vec![
        (say!(lang, "parameter"), Align::Left),
        (say!(lang, "weakest-reading"), Align::Right),
        (say!(lang, "effect"), Align::Right),
    ];
    if without.is_some() {
        columns.push((say!(lang, "change-without-suspects"), Align::Right));
    }
    columns.push((say!(lang, "unit"), Align::Left));
    let mut table = Table::new(&columns);
    table.small = true;
    for p in &report.parameters {
        let Some(external) = checks.external.get(&p.id) else { continue };
        let mut row = vec![format!("`{}`", p.id), external.index.to_string(), significant(external.effect, 3)];
        if let Some(changes) = without {
            row.push(cells::digits(changes.get(&p.id).copied(), 3));
        }
        row.push(if p.kind == Kind::Tilt { "arcsec".into() } else { p.unit.clone() });
        table.row(row);
    }
    table.caption = say!(lang, "external-reliability").into();
    table.note = say!(lang, "effect-what-the-smallest-detectable-fault-of").into();
    section.table(table)
}

/// A record that was streamed: means of its residuals, lack of fit over its inputs, the largest residuals.
fn record_tables(section: Section, record: &RecordReport, lang: Language) -> Section {
    let mut means = Table::new(&[
        (say!(lang, "sensor"), Align::Left),
        (say!(lang, "rows-in-a-mean"), Align::Right),
        (say!(lang, "pairs-of-means"), Align::Right),
        (say!(lang, "sd-over-that-of-independent-rows"), Align::Decimal),
        ("p", Align::Right),
    ]);
    for row in record_table::means_rows(record) {
        means.row(row);
    }
    means.note = say!(
        lang,
        "record-of-rows-read",
        rows = record.rows.to_string(),
        passes = lang.count(record.passes, "pass"),
        shown = record.shown.to_string()
    );
    let mut inputs = Table::new(&[
        (say!(lang, "sensor"), Align::Left),
        (say!(lang, "lack-of-fit-over"), Align::Left),
        (say!(lang, "chi-square"), Align::Decimal),
        (say!(lang, "dof"), Align::Right),
        ("p", Align::Right),
    ]);
    for row in record_table::inputs_rows(record) {
        inputs.row(row);
    }
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
                own.sensor.clone(),
                far.row.to_string(),
                significant(far.value, 6),
                significant(far.residual, 3),
                format!("{:.2}", far.w),
                significant(far.p, 3),
            ]);
        }
    }
    largest.small = true;
    section.table(means).table(inputs).table(largest)
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
                c.index.to_string(),
                format!("`{}`", c.text),
                lang.term("constraint", &c.state.to_string()).into_owned(),
                c.side.map_or(String::new(), |side| lang.term("side", &side.to_string()).into_owned()),
                cells::digits(c.cost, 3),
            ]);
        }
        section = section.prose(lang.sentence(&constraints.verdict.say(lang))).table(table);
    }
    if let Some(robust) = &report.robust {
        let low: Vec<String> = robust.downweighted.iter().map(usize::to_string).collect();
        let down = if low.is_empty() {
            say!(lang, "no-reading-lost-more-than-half-of").to_string()
        } else {
            say!(lang, "less-than-half-of-their-weight-readings", low = low.join(lang.comma()))
        };
        let steps = lang.count(robust.iterations, "step");
        section = section.prose(say!(
            lang,
            "robust-estimator-of-reweighting",
            method = robust.method.to_string(),
            steps,
            down
        ));
    }
    section
}

/// Monte Carlo beside the first order.
pub(super) fn monte_carlo(report: &FitReport, lang: Language) -> Section {
    let Some(drawn) = &report.monte_carlo else { return Section::new(say!(lang, "monte-carlo")) };
    let level = report.parameters.first().map_or(0.95, |p| p.level);
    let interval = say!(lang, "checks-page-interval", level = cells::level(level));
    let mut table = Table::new(&[
        (say!(lang, "quantity"), Align::Left),
        (say!(lang, "mean"), Align::Decimal),
        ("u", Align::Decimal),
        (&interval, Align::Right),
        (say!(lang, "shortest"), Align::Right),
        (say!(lang, "first-order"), Align::Right),
        (say!(lang, "unit"), Align::Left),
    ]);
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
            format!("`{}`", output.id),
            rounded(output.mean * scale, u),
            cells::value(u, u),
            pair(output.interval),
            pair(output.shortest),
            output.first_order.map_or_else(cells::dash, pair),
            unit.to_string(),
        ]);
        if let Some(row) = table.rows.last_mut().filter(|_| output.first_order_agrees == Some(false)) {
            row.tone = Tone::Caution;
        }
    }
    let trials = say!(lang, "of-trials-seed", trials = drawn.trials, asked = drawn.asked, seed = drawn.seed);
    table.note = say!(lang, "marked-the-first-order-is-not-good", trials);
    Section::new(say!(lang, "monte-carlo"))
        .list(drawn.verdict.iter().map(|line| lang.sentence(&line.say(lang))).collect())
        .table(table)
}
