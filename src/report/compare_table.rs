//! The comparison with published closed forms as a person reads it.

use super::table::{optional, plain, significant};

/// A comparison as a person reads it.
pub fn compare(report: &super::CompareReport) -> String {
    let mut text =
        format!("tumble {}: published closed forms on {}\n  {}\n\n", report.tumble, report.bench, report.source);
    let angle = |unit: &str| unit == "arcsec";
    let digits =
        |v: Option<f64>, unit: &str| optional(v, |v| if angle(unit) { format!("{v:.3}") } else { significant(v, 7) });
    let print =
        |v: Option<f64>, unit: &str| optional(v, |v| if angle(unit) { format!("{v:.1}") } else { significant(v, 7) });
    let mut rows = Vec::new();
    for group in &report.groups {
        for q in &group.quantities {
            rows.push(vec![
                group.group.map_or("all".into(), |g| g.to_string()),
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
        &report.group_title,
        "angle",
        "closed form",
        "least squares, no Earth rate",
        "least squares",
        "printed",
        "unit",
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
        &["angle", "mean of closed forms", "least squares, all readings", "printed mean", "unit"],
        &rows,
    ));
    text.push('\n');
    let ignored = report.groups.iter().flat_map(|g| &g.quantities).any(|q| q.without_earth_rate.is_some());
    match report.largest_relative_difference.map(|difference| significant(difference, 2)) {
        Some(difference) if ignored && !report.is_square_case() => text.push_str(&format!(
            "closed form and least squares without Earth rate differ by up to {difference} of the value: these positions are not the square case \
             of the formulas, which use some of the readings or weigh them otherwise.\n"
        )),
        Some(difference) if ignored => text.push_str(&format!(
            "closed form and least squares without Earth rate differ by at most {difference} of the value: per group the formulas are the \
             square special case. With the Earth rate in every row least squares moves by the difference of the last two columns; \
             the closed forms ignore it.\n"
        )),
        Some(difference) => {
            text.push_str(&format!("closed form and least squares differ by at most {difference} of the value.\n"));
        }
        None => {}
    }
    if !report.misprints.is_empty() {
        text.push_str("\nmisprints that this comparison finds:\n");
        for m in &report.misprints {
            let values = match (m.printed, m.computed) {
                (Some(printed), Some(computed)) => {
                    format!(" printed {}, computed {}:", significant(printed, 4), significant(computed, 4))
                }
                _ => String::new(),
            };
            text.push_str(&format!("- {}:{values} {}\n", m.what, m.explanation));
        }
    }
    text
}
