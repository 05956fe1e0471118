//! Sections of a fit's page on its numbers: the estimates, what is not estimable, where the uncertainty comes from.

use super::fit_figures::{budget_figures, estimate_figures};
use super::{Align, Section, Table, Tone, cells};
use crate::campaign::Kind;
use crate::error::Result;
use crate::fit::Fit;
use crate::fit::State;
use crate::report::table::significant;
use crate::report::{ARCSEC, FitReport};

/// Every angle and coefficient with its uncertainty.
pub(super) fn estimates(fit: &Fit, report: &FitReport) -> Result<Section> {
    let level = report.parameters.first().map_or(0.95, |p| p.level);
    let expanded = format!("U ({})", cells::level(level));
    let columns = |what: &'static str| {
        Table::new(&[
            (what, Align::Left),
            ("estimate", Align::Decimal),
            ("u", Align::Decimal),
            (&expanded, Align::Decimal),
            ("\u{3bd}", Align::Right),
            ("k", Align::Right),
            ("unit", Align::Left),
            ("", Align::Left),
        ])
    };
    let (mut angles, mut coefficients) = (columns("angle"), columns("coefficient"));
    for (p, result) in report.parameters.iter().zip(&fit.parameters) {
        let remark = match p.state {
            State::Free => result.meaning.clone(),
            State::NotEstimable => "not estimable".into(),
            other => {
                let scale = if p.kind == Kind::Tilt { ARCSEC } else { 1.0 };
                let interval =
                    p.interval.map(|ends| ends.map(|end| cells::value(Some(end * scale), p.u.map(|u| u * scale))));
                let between = interval.map_or(String::new(), |[a, b]| format!(", interval {a} to {b}"));
                format!("{other}{between}. {}", result.meaning)
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
    for d in &report.derived {
        let (value, u, expanded, unit) = match d.arcsec {
            Some(a) => (a.value, a.u, a.expanded, "arcsec"),
            None => (d.value, d.u, d.expanded, d.unit.as_str()),
        };
        let table = if d.arcsec.is_some() { &mut angles } else { &mut coefficients };
        table.row(row(&d.id, value, (u, expanded), d.dof, d.k, unit, format!("= `{}`", d.line)));
    }
    coefficients.note = format!(
        "u: combined standard uncertainty; {expanded} = k u: expanded uncertainty, k from Student's t with \u{3bd} effective degrees of freedom."
    );
    if coefficients.rows.is_empty() {
        angles.note = std::mem::take(&mut coefficients.note);
    }
    Ok(Section::new("Estimates").table(angles).figures(estimate_figures(report)?).table(coefficients))
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

/// What the readings leave free, and what would separate it.
pub(super) fn not_estimable(report: &FitReport) -> Section {
    let mut section = Section::new("Not estimable from these readings");
    for defect in &report.not_estimable {
        let only: Vec<&str> = defect.estimable.iter().map(|c| c.text.as_str()).collect();
        let instead = if only.is_empty() {
            "no reading responds to it".to_string()
        } else {
            format!("only {} {} determined", cells::names(&only), if only.len() == 1 { "is" } else { "are" })
        };
        section = section
            .prose(format!("The parameters can move along `{}` and no reading changes; {instead}.", defect.text));
        section = match &defect.separate_by {
            Some(position) => {
                let keys: Vec<String> = position.iter().map(|(key, value)| format!("{key} = {value}")).collect();
                section.prose(format!("What would separate it: a further reading at {}.", cells::names(&keys)))
            }
            None if defect.weak => section.prose(format!("But {}.", defect.nowhere())),
            None => {
                section.prose("No position of this bench would separate it: it takes another bench, or a known value.")
            }
        };
    }
    if !report.estimable_combinations.is_empty() {
        let mut table = Table::new(&[
            ("determined instead", Align::Left),
            ("estimate", Align::Decimal),
            ("u", Align::Decimal),
            ("U", Align::Decimal),
            ("unit", Align::Left),
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
pub(super) fn budget(report: &FitReport) -> Result<Section> {
    let mut section = Section::new("Where the uncertainty comes from").figures(budget_figures(report)?);
    let mut table = Table::new(&[
        ("quantity", Align::Left),
        ("source", Align::Left),
        ("type", Align::Left),
        ("distribution", Align::Left),
        ("u of source", Align::Right),
        ("c", Align::Right),
        ("\u{3bd}", Align::Right),
        ("contribution", Align::Right),
        ("share", Align::Right),
    ]);
    table.small = true;
    let parameters = report.parameters.iter().map(|p| (&p.id, &p.budget));
    let derived = report.derived.iter().map(|d| (&d.id, &d.budget));
    let mut hidden = 0;
    for (id, budget) in parameters.chain(derived) {
        let mut first = true;
        for line in budget {
            if line.share < 5e-4 {
                hidden += 1;
                continue;
            }
            table.row(vec![
                if first { format!("`{id}`") } else { String::new() },
                line.source.clone(),
                line.evaluation.to_string(),
                line.distribution.to_string(),
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
    table.note = "Angles in radians. c: sensitivity coefficient of a single source; \u{3bd}: degrees of freedom; share: part of the variance.".into();
    if hidden > 0 {
        table
            .note
            .push_str(&format!(" {} below 0.05 % of the variance left out.", cells::count(hidden, "contribution")));
    }
    section = section.table(table);
    Ok(section)
}
