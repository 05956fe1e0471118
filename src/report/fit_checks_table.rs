//! Tables for a terminal: the uncertainty budget, constraints, checks and Monte Carlo of a fit.

use super::table::{degrees_of_freedom, percent, plain, significant};
use super::{BudgetReport, FitReport};
use crate::campaign::Kind;
use crate::fit::State;
use crate::language::{Language, say};

/// The budget of every parameter and derived quantity, one table each.
pub fn budget(report: &FitReport, lang: Language) -> String {
    let mut text = String::new();
    for p in &report.parameters {
        text.push_str(&one_budget(&p.id, &p.unit, p.u, p.dof, &p.budget, lang));
    }
    for d in &report.derived {
        text.push_str(&one_budget(&d.id, &d.unit, d.u, d.dof, &d.budget, lang));
    }
    text.push_str(&correlations(report, lang));
    text
}

fn one_budget(
    id: &str,
    unit: &str,
    u: Option<f64>,
    dof: Option<f64>,
    budget: &[BudgetReport],
    lang: Language,
) -> String {
    if budget.is_empty() {
        return String::new();
    }
    let or_dash = |value: Option<f64>, digits| value.map_or("-".to_string(), |v| significant(v, digits));
    let degrees = |dof: Option<f64>| degrees_of_freedom(dof, true);
    let mut rows: Vec<Vec<String>> = budget
        .iter()
        .map(|line| {
            vec![
                super::scatter::source_name(&line.source, lang),
                or_dash(line.estimate, 6),
                or_dash(line.source_u, 3),
                line.evaluation.to_string(),
                lang.term("distribution", &line.distribution.to_string()).into_owned(),
                degrees(line.dof),
                or_dash(line.c, 4),
                significant(line.u, 3),
                format!("{:.1} %", 100.0 * line.share),
            ]
        })
        .collect();
    if let Some(u) = u {
        let mut total = vec![say!(lang, "combined").to_string(), "-".into(), "-".into(), String::new(), String::new()];
        total.extend([degrees(dof), "-".into(), significant(u, 3), "100.0 %".into()]);
        rows.push(total);
    }
    let header = [
        say!(lang, "quantity"),
        say!(lang, "estimate"),
        "u",
        say!(lang, "type"),
        say!(lang, "distribution"),
        "nu",
        "c",
        say!(lang, "contribution"),
        say!(lang, "share"),
    ];
    let unit = if unit.is_empty() { String::new() } else { format!(" ({unit})") };
    format!("\n{}\n{}", say!(lang, "budget-of", id, unit), plain(&header, &rows))
}

fn correlations(report: &FitReport, lang: Language) -> String {
    if report.correlation.order.len() < 2 {
        return String::new();
    }
    let mut header = vec![say!(lang, "correlation")];
    header.extend(report.correlation.order.iter().map(String::as_str));
    let rows: Vec<Vec<String>> = report
        .correlation
        .order
        .iter()
        .zip(&report.correlation.matrix)
        .map(|(id, row)| {
            let cells = row.iter().map(|r| r.map_or("-".to_string(), |r| format!("{r:.3}")));
            std::iter::once(id.clone()).chain(cells).collect()
        })
        .collect();
    format!("\n{}", plain(&header, &rows))
}

/// What was found beside the estimates: sentences under the table.
pub fn findings(report: &FitReport, lang: Language) -> String {
    let mut text = String::new();
    if let Some(robust) = &report.robust {
        text.push_str(&match robust.converged {
            true => {
                say!(
                    lang,
                    "robust-estimate-settled",
                    method = robust.method.to_string(),
                    steps = robust.iterations.to_string()
                )
            }
            false => say!(
                lang,
                "robust-estimate-did-not-settle",
                method = robust.method.to_string(),
                steps = robust.iterations.to_string()
            ),
        });
        if !robust.downweighted.is_empty() {
            let named: Vec<String> = robust.downweighted.iter().map(usize::to_string).collect();
            text.push_str(&say!(lang, "less-than-half-weight-readings", named = named.join(lang.comma())));
        }
        text.push('\n');
    }
    if let Some(constraints) = &report.constraints {
        text.push_str(&format!("{}\n", say!(lang, "fit-checks-table-constraints", verdict = constraints.verdict)));
        for p in report.parameters.iter().filter(|p| p.state == State::AtBound) {
            let (scale, unit) = if p.kind == Kind::Tilt { (super::ARCSEC, "arcsec") } else { (1.0, p.unit.as_str()) };
            match p.interval {
                Some([low, high]) => text.push_str(&format!(
                    "  {}\n",
                    say!(
                        lang,
                        "is-at-a-bound-interval-to-of",
                        id = p.id,
                        level = percent(p.level),
                        low = significant(low * scale, 5),
                        high = significant(high * scale, 5),
                        unit
                    )
                )),
                None if p.u.is_some() => text.push_str(&format!(
                    "  {}\n",
                    say!(lang, "is-at-a-bound-and-the-whole", id = p.id, level = percent(p.level))
                )),
                None => {}
            }
        }
    }
    for sentence in &report.checks.verdict {
        text.push_str(&sentence.say(lang));
        text.push('\n');
    }
    if let Some(drawn) = &report.monte_carlo {
        text.push_str(&monte_carlo(report, drawn, lang));
    }
    text
}

fn monte_carlo(report: &FitReport, drawn: &super::MonteCarloReport, lang: Language) -> String {
    let mut rows = Vec::new();
    for output in &drawn.outputs {
        let angle = report.parameters.iter().any(|p| p.id == output.id && p.kind == Kind::Tilt)
            || report.derived.iter().any(|d| d.id == output.id && d.unit == "rad");
        let (scale, unit) = if angle { (super::ARCSEC, "arcsec") } else { (1.0, "") };
        let show = |x: f64| significant(x * scale, 5);
        rows.push(vec![
            output.id.clone(),
            show(output.mean),
            significant(output.u * scale, 3),
            show(output.interval[0]),
            show(output.interval[1]),
            show(output.shortest[0]),
            show(output.shortest[1]),
            unit.to_string(),
            match output.first_order_agrees {
                Some(true) => say!(lang, "yes").into(),
                Some(false) => say!(lang, "no-loud").into(),
                None => "-".to_string(),
            },
        ]);
    }
    let header = [
        say!(lang, "monte-carlo"),
        say!(lang, "mean"),
        "u",
        say!(lang, "low"),
        say!(lang, "high"),
        say!(lang, "shortest-low"),
        say!(lang, "shortest-high"),
        say!(lang, "unit"),
        say!(lang, "first-order-agrees"),
    ];
    let mut text = format!("\n{}", plain(&header, &rows));
    text.push_str(&format!("{}\n", say!(lang, "trials-seed", trials = drawn.trials, seed = drawn.seed)));
    if let Some(joint) = &drawn.joint
        && let Some(k) = joint.k_p
    {
        text.push_str(&format!(
            "{}\n",
            say!(lang, "coverage-ellipsoid-of-k-p", order = joint.order.join(lang.comma()), k = significant(k, 4))
        ));
    }
    for sentence in &drawn.verdict {
        text.push_str(&sentence.say(lang));
        text.push('\n');
    }
    text
}
