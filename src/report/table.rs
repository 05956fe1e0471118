//! Tables for a person at a terminal: numbers with as many digits as their uncertainty carries.

use super::FitReport;
use comfy_table::{CellAlignment, ContentArrangement, Table, presets};

/// A table without frame: a header, a rule, rows; columns of numbers to the right.
pub fn plain(header: &[&str], rows: &[Vec<String>]) -> String {
    let mut table = Table::new();
    table.load_style(presets::NOTHING).set_content_arrangement(ContentArrangement::Disabled);
    table.set_header(header.to_vec());
    for row in rows {
        table.add_row(row.clone());
    }
    for (k, column) in table.column_iter_mut().enumerate() {
        column.set_padding((if k == 0 { 0 } else { 1 }, 1));
        let numeric = !rows.is_empty() && rows.iter().filter_map(|row| row.get(k)).all(|cell| looks_numeric(cell));
        if numeric {
            column.set_cell_alignment(CellAlignment::Right);
        }
    }
    let mut text = String::new();
    for (k, line) in table.to_string().lines().enumerate() {
        text.push_str(line.trim_end());
        text.push('\n');
        if k == 0 {
            let width = table.lines().map(|line| line.trim_end().chars().count()).max().unwrap_or(0);
            text.push_str(&"-".repeat(width));
            text.push('\n');
        }
    }
    text
}

fn looks_numeric(cell: &str) -> bool {
    cell.is_empty()
        || cell == "-"
        || cell == "inf"
        || cell.trim_start_matches('<').trim_end_matches(" %").parse::<f64>().is_ok()
}

/// A value rounded where its uncertainty ends: at the second significant digit of `u`, the third where `u` begins with 1 or 2 (GUM 7.2.6).
///
/// ```
/// use tumble::report::table::rounded;
/// assert_eq!(rounded(-162.0687, Some(0.5987)), "-162.07");
/// assert_eq!(rounded(0.001234567, None), "0.00123457");
/// ```
pub fn rounded(value: f64, uncertainty: Option<f64>) -> String {
    match uncertainty.filter(|u| *u > 0.0 && u.is_finite()) {
        Some(u) => {
            let lead = leading_digit(u);
            let digits = if u < 3.0 * 10f64.powi(lead) { 2 - lead } else { 1 - lead };
            if !(-6..=12).contains(&digits) {
                return format!("{value:.6e}");
            }
            let text = format!("{value:.*}", digits.max(0) as usize);
            let zero = text.trim_start_matches('-').chars().all(|c| matches!(c, '0' | '.'));
            if zero { text.trim_start_matches('-').to_string() } else { text }
        }
        None => significant(value, 6),
    }
}

/// A number with so many significant digits, plain where it is readable, else with an exponent.
pub fn significant(value: f64, digits: i32) -> String {
    if value == 0.0 {
        return "0".into();
    }
    if !value.is_finite() {
        return value.to_string();
    }
    let lead = leading_digit(value);
    if !(-5..9).contains(&lead) {
        return format!("{value:.*e}", (digits - 1).max(0) as usize);
    }
    format!("{value:.*}", (digits - 1 - lead).max(0) as usize)
}

/// Six digits at most, no idle zeros.
pub fn trimmed(value: f64) -> String {
    let text = significant(value, 6);
    if text.contains('.') && !text.contains('e') {
        return text.trim_end_matches('0').trim_end_matches('.').to_string();
    }
    text
}

/// Exponent of the leading digit.
fn leading_digit(value: f64) -> i32 {
    value.abs().log10().floor() as i32
}

fn optional(value: Option<f64>, format: impl Fn(f64) -> String) -> String {
    value.map_or("-".into(), format)
}

/// A probability in percent, without idle zeros.
pub(super) fn percent(p: f64) -> String {
    significant(100.0 * p, 4).trim_end_matches('0').trim_end_matches('.').to_string()
}

/// From here on a t distribution is the normal one to any printed digit.
const MANY: f64 = 1e6;

/// Degrees of freedom: whole ones (to rounding) without a point, infinite ones as `inf`.
pub(super) fn degrees_of_freedom(dof: Option<f64>, known: bool) -> String {
    match dof {
        None if known => "inf".into(),
        None => "-".into(),
        Some(dof) if dof > MANY => "inf".into(),
        Some(dof) if (dof - dof.round()).abs() < 1e-6 => format!("{dof:.0}"),
        Some(dof) => format!("{dof:.1}"),
    }
}

/// One line of the table of estimates.
struct Line<'a> {
    id: &'a str,
    unit: &'a str,
    value: Option<f64>,
    u: Option<f64>,
    expanded: Option<f64>,
    dof: Option<f64>,
    k: Option<f64>,
    state: &'a str,
}

impl Line<'_> {
    fn cells(&self) -> Vec<String> {
        vec![
            self.id.to_string(),
            optional(self.value, |v| rounded(v, self.u)),
            optional(self.u, |u| rounded(u, Some(u))),
            optional(self.expanded, |e| rounded(e, self.u)),
            degrees_of_freedom(self.dof, self.u.is_some()),
            optional(self.k, |k| format!("{k:.2}")),
            self.unit.to_string(),
            self.state.to_string(),
        ]
    }
}

/// A fit report as a person reads it.
pub fn fit(report: &FitReport, with_readings: bool) -> String {
    let mut text = format!("tumble {}: {} fit on {}\n", report.tumble, report.estimator, report.bench);
    for (sensor, line) in &report.model {
        text.push_str(&format!("  {sensor} = {line}\n"));
    }
    text.push('\n');
    let level = report.parameters.first().map_or(0.95, |p| p.level);
    let mut rows: Vec<Vec<String>> = Vec::new();
    for p in &report.parameters {
        let line = match p.arcsec {
            Some(a) => Line {
                id: &p.id,
                unit: "arcsec",
                value: a.value,
                u: a.u,
                expanded: a.expanded,
                dof: p.dof,
                k: p.k,
                state: &p.state,
            },
            None => Line {
                id: &p.id,
                unit: &p.unit,
                value: p.value,
                u: p.u,
                expanded: p.expanded,
                dof: p.dof,
                k: p.k,
                state: &p.state,
            },
        };
        rows.push(line.cells());
    }
    for d in &report.derived {
        let line = match d.arcsec {
            Some(a) => Line {
                id: &d.id,
                unit: "arcsec",
                value: a.value,
                u: a.u,
                expanded: a.expanded,
                dof: d.dof,
                k: d.k,
                state: "derived",
            },
            None => Line {
                id: &d.id,
                unit: &d.unit,
                value: d.value,
                u: d.u,
                expanded: d.expanded,
                dof: d.dof,
                k: d.k,
                state: "derived",
            },
        };
        rows.push(line.cells());
    }
    let expanded = format!("U ({} %)", significant(100.0 * level, 3).trim_end_matches('0').trim_end_matches('.'));
    text.push_str(&plain(&["parameter", "estimate", "u", &expanded, "dof", "k", "unit", "state"], &rows));
    text.push('\n');
    text.push_str(&summary(report));
    text.push_str(&super::fit_checks_table::findings(report));
    text.push_str(&defects(report));
    if let Some(record) = &report.convergence {
        let steps = record.iterations.len();
        let word = if record.converged { "converged" } else { "NOT converged" };
        let why = if record.converged { String::new() } else { format!(" ({})", record.stop) };
        if !record.held.is_empty() {
            text.push_str(&format!(
                "held at the reference point, which does not determine them (and the exact model beyond it too weakly): {}\n",
                record.held.join(", ")
            ));
        }
        text.push_str(&format!("Gauss-Newton {word} after {steps} iterations{why}; exact minus linear:"));
        for p in &report.parameters {
            if let Some(change) = record.change.get(&p.id) {
                let (scale, unit) = if p.kind == "tilt" { (super::ARCSEC, "arcsec") } else { (1.0, p.unit.as_str()) };
                text.push_str(format!(" {} {} {unit},", p.id, significant(change * scale, 3)).trim_end_matches(' '));
            }
        }
        text = text.trim_end_matches(',').to_string() + "\n";
    }
    if with_readings {
        text.push('\n');
        text.push_str(&readings(report));
    }
    text
}

/// `1 reading`, `30 readings`.
pub(super) fn count(n: usize, what: &str) -> String {
    if n == 1 { format!("1 {what}") } else { format!("{n} {what}s") }
}

fn summary(report: &FitReport) -> String {
    let fit = &report.fit;
    let priors = if fit.priors > 0 { format!(" + {}", count(fit.priors, "prior")) } else { String::new() };
    let mut text = format!(
        "{}{priors}, rank {} of {}, {} degrees of freedom",
        count(fit.readings, "reading"),
        fit.rank,
        report.parameters.len(),
        fit.dof
    );
    if let Some(condition) = fit.condition {
        text.push_str(&format!(", condition {}", significant(condition, 3)));
    }
    text.push('\n');
    match (fit.chi_square, fit.p, fit.residual_sd) {
        (Some(chi_square), Some(p), Some(sd)) => {
            let verdict = if p < 1.0 - report.parameters.first().map_or(0.95, |p| p.level) {
                "REJECTED: the readings scatter more than their stated uncertainties allow"
            } else {
                "accepted"
            };
            text.push_str(&format!(
                "global test: chi-square {} with {} degrees of freedom, p = {}, factor {}: {verdict}\n",
                significant(chi_square, 4),
                fit.dof,
                significant(p, 3),
                significant(sd, 3)
            ));
        }
        _ => {
            for (sensor, sd) in &fit.sensor_sd {
                match sd {
                    Some(sd) => {
                        let how = if fit.at_rounding.contains(sensor) {
                            "the rounding of its readings, which show no scatter"
                        } else {
                            "estimated from these readings"
                        };
                        text.push_str(&format!("residual sd of {sensor}: {}, {how}\n", significant(*sd, 4)));
                    }
                    None => text.push_str(&format!(
                        "residual sd of {sensor}: none (no degrees of freedom), so no uncertainty can be given\n"
                    )),
                }
            }
        }
    }
    if let Some(error) = fit.linearisation_error.filter(|e| *e > 0.1 && report.estimator == "linear") {
        text.push_str(&format!(
            "note: the exact model differs from the linear one by up to {} standard uncertainties of a reading; use --exact\n",
            significant(error, 2)
        ));
    }
    if !report.known.is_empty() {
        let known: Vec<String> = report.known.iter().map(known_text).collect();
        text.push_str(&format!("known: {}\n", known.join(", ")));
    }
    if !report.assumed_zero.is_empty() {
        text.push_str(&format!("assumed zero: {}\n", report.assumed_zero.join(", ")));
    }
    text
}

fn known_text(known: &super::KnownReport) -> String {
    let u = if known.u > 0.0 { format!(" (u {})", significant(known.u, 2)) } else { String::new() };
    format!(
        "{} = {}{}{u}",
        known.id,
        known.value,
        if known.unit.is_empty() { String::new() } else { format!(" {}", known.unit) }
    )
}

fn defects(report: &FitReport) -> String {
    let mut text = String::new();
    for defect in &report.not_estimable {
        text.push_str(&format!("NOT ESTIMABLE: {} is free;", defect.text));
        if let Some(hides) = &defect.hides {
            text.push_str(&format!(" {hides};"));
        }
        let only: Vec<&str> = defect.estimable.iter().map(|c| c.text.as_str()).collect();
        if only.is_empty() {
            text.push_str(" no reading responds to it");
        } else {
            let verb = if only.len() == 1 { "is" } else { "are" };
            text.push_str(&format!(" only {} {verb} estimable here", only.join(" and ")));
        }
        match &defect.separate_by {
            Some(position) => {
                let keys: Vec<String> = position.iter().map(|(key, value)| format!("{key} = {value}")).collect();
                text.push_str(&format!("\n  a reading at {} would separate it\n", keys.join(", ")));
            }
            None => text.push_str("\n  no position of this bench would separate it\n"),
        }
    }
    text
}

fn readings(report: &FitReport) -> String {
    let rows: Vec<Vec<String>> = report
        .readings
        .iter()
        .map(|r| {
            vec![
                r.index.to_string(),
                r.position.clone(),
                r.sensor.clone(),
                significant(r.value, 6),
                significant(r.fitted, 6),
                significant(r.residual, 3),
                optional(r.studentized, |s| format!("{s:.2}")),
                format!("{:.3}", r.redundancy),
                optional(r.mdb, |m| significant(m, 3)),
            ]
        })
        .collect();
    plain(&["reading", "position", "sensor", "value", "fitted", "residual", "studentized", "redundancy", "mdb"], &rows)
}

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
        "least squares,\u{a0}no\u{a0}Earth\u{a0}rate",
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
        Some(difference) if ignored => text.push_str(&format!(
            "closed form and least squares without Earth rate differ by at most {difference} of the value: per group the formulas are the\n\
             square special case. With the Earth rate in every row least squares moves by the difference of the last two columns;\n\
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
