//! Sections of a fit's page on its numbers: the estimates, what is not estimable, where the uncertainty comes from.

use super::fit_figures::{budget_figures, estimate_figures};
use super::{Align, Section, Table, Tone, cells};
use crate::campaign::Kind;
use crate::error::Result;
use crate::fit::Fit;
use crate::fit::State;
use crate::language::{Language, say};
use crate::report::table::significant;
use crate::report::{ARCSEC, FitReport, scatter};

/// Every angle and coefficient with its uncertainty.
pub(super) fn estimates(fit: &Fit, report: &FitReport, lang: Language) -> Result<Section> {
    let level = report.parameters.first().map_or(0.95, |p| p.level);
    let expanded = format!("U ({})", cells::level(level));
    let columns = |what: &'static str| {
        Table::new(&[
            (what, Align::Left),
            (say!(lang, "estimate"), Align::Decimal),
            ("u", Align::Decimal),
            (&expanded, Align::Decimal),
            ("\u{3bd}", Align::Right),
            ("k", Align::Right),
            (say!(lang, "unit"), Align::Left),
            ("", Align::Left),
        ])
    };
    let (mut angles, mut coefficients) = (columns(say!(lang, "angle")), columns(say!(lang, "coefficient")));
    for (p, result) in report.parameters.iter().zip(&fit.parameters) {
        let remark = match p.state {
            State::Free => meaning(result, lang),
            State::NotEstimable => say!(lang, "not-estimable").into(),
            other => {
                let scale = if p.kind == Kind::Tilt { ARCSEC } else { 1.0 };
                let interval =
                    p.interval.map(|ends| ends.map(|end| cells::value(Some(end * scale), p.u.map(|u| u * scale))));
                let between = interval.map_or(String::new(), |[a, b]| say!(lang, "interval-to", a, b));
                say!(
                    lang,
                    "state-and-meaning",
                    state = lang.term("state", other.name()),
                    between,
                    meaning = meaning(result, lang)
                )
                .trim_end()
                .to_string()
            }
        };
        let (value, u, expanded, unit) = match p.arcsec {
            Some(a) => (a.value, a.u, a.expanded, "arcsec"),
            None => (p.value, p.u, p.expanded, if p.kind == Kind::Tilt { "arcsec" } else { &p.unit }),
        };
        let table = if p.kind == Kind::Tilt { &mut angles } else { &mut coefficients };
        table.row(row(&p.id, value, (u, expanded), p.dof, p.k, unit, remark));
        if let Some(last) = table.rows.last_mut().filter(|_| p.state == State::NotEstimable) {
            last.tone = Tone::Bad;
        }
    }
    for d in report.derived.iter().filter(|d| d.value.is_some()) {
        let (value, u, expanded, unit) = match d.arcsec {
            Some(a) => (a.value, a.u, a.expanded, "arcsec"),
            None => (d.value, d.u, d.expanded, d.unit.as_str()),
        };
        let table = if d.arcsec.is_some() { &mut angles } else { &mut coefficients };
        table.row(row(&d.id, value, (u, expanded), d.dof, d.k, unit, format!("= `{}`", d.line)));
        if let (Some(note), Some(last)) = (&d.note, table.rows.last_mut()) {
            last.tone = Tone::Caution;
            let remark = last.cells.last_mut();
            remark.into_iter().for_each(|cell| cell.push_str(&format!("{}{}", lang.semicolon(), note.say(lang))));
        }
    }
    coefficients.note = say!(lang, "u-combined-standard-uncertainty-k-u-expanded", expanded);
    if coefficients.rows.is_empty() {
        angles.note = std::mem::take(&mut coefficients.note);
    }
    let without = report.derived_without_a_value();
    let section = match without.is_empty() {
        true => Section::new(say!(lang, "estimates")),
        false => Section::new(say!(lang, "estimates")).prose(say!(
            lang,
            "derived-without-a-value",
            names = cells::names(&without, lang)
        )),
    };
    Ok(section.table(angles).figures(estimate_figures(report, lang)?).table(coefficients))
}

fn row(
    id: &str,
    value: Option<f64>,
    (u, expanded): (Option<f64>, Option<f64>),
    dof: Option<f64>,
    k: Option<f64>,
    unit: &str,
    remark: String,
) -> Vec<String> {
    vec![
        format!("`{id}`"),
        cells::value(value, u),
        cells::value(u, u),
        cells::value(expanded, u),
        cells::dof(dof, u.is_some()),
        cells::decimals(k, 2),
        unit.to_string(),
        remark,
    ]
}

/// What a parameter is, as its bench says it.
fn meaning(result: &crate::fit::ParameterResult, lang: Language) -> String {
    lang.name(&result.meaning).into_owned()
}

/// What the readings leave free, and what would separate it.
pub(super) fn not_estimable(report: &FitReport, lang: Language) -> Section {
    let mut section = Section::new(say!(lang, "not-estimable-from-these-readings"));
    for defect in &report.not_estimable {
        let only: Vec<&str> = defect.estimable.iter().map(|c| c.text.as_str()).collect();
        let instead = if only.is_empty() {
            say!(lang, "no-reading-responds-to-it").to_string()
        } else {
            say!(lang, "only-determined", only = cells::names(&only, lang), n = only.len())
        };
        section = section.prose(say!(lang, "the-parameters-can-move-along-and-no", text = defect.text, instead));
        section = match &defect.separate_by {
            Some(_) if defect.separate_sensor.is_some() => {
                section.prose(lang.sentence(&defect.further(lang).unwrap_or_default()))
            }
            Some(position) => {
                let keys: Vec<String> = position.iter().map(|(key, value)| format!("{key} = {value}")).collect();
                section.prose(say!(lang, "what-would-separate-it-a-further-reading", keys = cells::names(&keys, lang)))
            }
            None if defect.weak => section.prose(say!(lang, "fit-estimates-but", nowhere = defect.nowhere())),
            None => section.prose(say!(lang, "no-position-of-this-bench-would-separate")),
        };
    }
    if !report.estimable_combinations.is_empty() {
        let mut table = Table::new(&[
            (say!(lang, "determined-instead"), Align::Left),
            (say!(lang, "estimate"), Align::Decimal),
            ("u", Align::Decimal),
            ("U", Align::Decimal),
            (say!(lang, "unit"), Align::Left),
        ]);
        for own in &report.estimable_combinations {
            let (value, u, expanded, unit) = match own.arcsec {
                Some(a) => (a.value, a.u, a.expanded, "arcsec"),
                None => (Some(own.value), own.u, own.expanded, own.unit.as_str()),
            };
            table.row(vec![
                format!("`{}`", own.text),
                cells::value(value, u),
                cells::value(u, u),
                cells::value(expanded, u),
                unit.to_string(),
            ]);
        }
        section = section.table(table);
    }
    section
}

/// The budget of each quantity.
pub(super) fn budget(report: &FitReport, lang: Language) -> Result<Section> {
    let mut section =
        Section::new(say!(lang, "where-the-uncertainty-comes-from")).figures(budget_figures(report, lang)?);
    let mut table = Table::new(&[
        (say!(lang, "quantity"), Align::Left),
        (say!(lang, "source-2"), Align::Left),
        (say!(lang, "type"), Align::Left),
        (say!(lang, "distribution"), Align::Left),
        (say!(lang, "u-of-source"), Align::Right),
        ("c", Align::Right),
        ("\u{3bd}", Align::Right),
        (say!(lang, "contribution"), Align::Right),
        (say!(lang, "share"), Align::Right),
    ]);
    table.small = true;
    let parameters = report.parameters.iter().map(|p| (&p.id, &p.budget));
    let derived = report.derived.iter().map(|d| (&d.id, &d.budget));
    let mut hidden = 0;
    for (id, budget) in parameters.chain(derived) {
        let mut first = true;
        for line in budget {
            if line.share.abs() < 5e-4 {
                hidden += 1;
                continue;
            }
            table.row(vec![
                if first { format!("`{id}`") } else { String::new() },
                scatter::source_name(&line.source, lang),
                line.evaluation.to_string(),
                lang.term("distribution", &line.distribution.to_string()).into_owned(),
                cells::digits(line.source_u, 3),
                cells::digits(line.c, 4),
                cells::dof(line.dof, true),
                significant(line.u, 3),
                cells::percent(line.share),
            ]);
            if let Some(row) = table.rows.last_mut() {
                row.rule = first;
            }
            first = false;
        }
    }
    table.note = say!(lang, "angles-in-radians-c-sensitivity-coefficient-of").into();
    if hidden > 0 {
        table.note.push_str(&format!(
            "{}{}",
            lang.space(),
            say!(lang, "below-of-the-variance-left-out", contribution = lang.count(hidden, "contribution"))
        ));
    }
    section = section.table(table);
    Ok(section)
}
