//! The comparison with published closed forms as a person reads it.

use super::table::{optional, plain, significant};
use crate::language::{Language, say};

/// A comparison as a person reads it.
pub fn compare(report: &super::CompareReport, lang: Language) -> String {
    let title = say!(lang, "tumble-published-closed-forms-on", tumble = report.tumble, bench = report.bench);
    let mut text = format!("{title}\n  {}\n\n", lang.name(&report.source));
    let angle = |unit: &str| unit == "arcsec";
    let digits =
        |v: Option<f64>, unit: &str| optional(v, |v| if angle(unit) { format!("{v:.3}") } else { significant(v, 7) });
    let print =
        |v: Option<f64>, unit: &str| optional(v, |v| if angle(unit) { format!("{v:.1}") } else { significant(v, 7) });
    let mut rows = Vec::new();
    for group in &report.groups {
        for q in &group.quantities {
            rows.push(vec![
                group.group.map_or(say!(lang, "all").into(), |g| g.to_string()),
                q.id.clone(),
                digits(q.closed_form, &q.unit),
                digits(q.without_earth_rate, &q.unit),
                digits(q.least_squares, &q.unit),
                print(q.printed, &q.unit),
                q.unit.clone(),
            ]);
        }
    }
    let header = [
        &lang.name(&report.group_title),
        say!(lang, "angle"),
        say!(lang, "closed-form"),
        say!(lang, "least-squares-no-earth-rate"),
        say!(lang, "least-squares"),
        say!(lang, "printed"),
        say!(lang, "unit"),
    ];
    text.push_str(&plain(&header, &rows));
    text.push('\n');
    let rows: Vec<Vec<String>> = report
        .all
        .quantities
        .iter()
        .map(|q| {
            vec![
                q.id.clone(),
                digits(q.closed_form, &q.unit),
                digits(q.least_squares, &q.unit),
                print(q.printed, &q.unit),
                q.unit.clone(),
            ]
        })
        .collect();
    text.push_str(&plain(
        &[
            say!(lang, "angle"),
            say!(lang, "mean-of-closed-forms"),
            say!(lang, "least-squares-all-readings"),
            say!(lang, "printed-mean"),
            say!(lang, "unit"),
        ],
        &rows,
    ));
    text.push('\n');
    let ignored = report.groups.iter().flat_map(|g| &g.quantities).any(|q| q.without_earth_rate.is_some());
    match report.largest_relative_difference.map(|difference| significant(difference, 2)) {
        Some(difference) if ignored && !report.is_square_case() => {
            text.push_str(&format!("{}\n", say!(lang, "closed-form-and-least-squares-without-earth", difference)))
        }
        Some(difference) if ignored => {
            text.push_str(&format!("{}\n", say!(lang, "closed-form-and-least-squares-without-earth-2", difference)))
        }
        Some(difference) => {
            text.push_str(&format!("{}\n", say!(lang, "closed-form-and-least-squares-differ-by", difference)));
        }
        None => {}
    }
    if !report.misprints.is_empty() {
        text.push_str(&format!("\n{}\n", say!(lang, "misprints-that-this-comparison-finds")));
        for m in &report.misprints {
            let values = match (m.printed, m.computed) {
                (Some(printed), Some(computed)) => {
                    format!(
                        "{}{}",
                        lang.space(),
                        say!(
                            lang,
                            "printed-computed",
                            printed = significant(printed, 4),
                            computed = significant(computed, 4)
                        )
                    )
                }
                _ => String::new(),
            };
            text.push_str(&format!(
                "- {}{values} {}\n",
                say!(lang, "misprint-of", what = m.what),
                m.explanation.say(lang)
            ));
        }
    }
    text
}
