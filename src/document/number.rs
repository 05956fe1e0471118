//! Numbers as every output writes them: with as many digits as their uncertainty carries.

use crate::number;

/// With more decimals than this a number has an exponent: value, u and U of a table then take 3 * (14 + 2) of a terminal's 80 columns and leave 32
/// for names, units, degrees of freedom and k.
const PLAIN: i32 = 11;

/// A value rounded where its uncertainty ends: at the second significant digit of `u`, the third where `u` begins with 1 or 2,
/// so that rounding changes no `u` by more than 2 % (GUM 7.2.6: two usually suffice).
///
/// ```
/// use tumble::document::number::rounded;
/// assert_eq!(rounded(-162.0687, Some(0.5987)), "-162.07");
/// assert_eq!(rounded(0.001234567, None), "0.00123457");
/// assert_eq!(rounded(-3.3217e-11, Some(1.2e-12)), "-3.322e-11");
/// ```
pub fn rounded(value: f64, uncertainty: Option<f64>) -> String {
    match uncertainty.filter(|u| *u > 0.0 && u.is_finite()) {
        Some(u) => {
            let lead = leading_digit(u);
            let digits = if u < 3.0 * 10f64.powi(lead) { 2 - lead } else { 1 - lead };
            if !(-6..=PLAIN).contains(&digits) {
                // the same digits behind the leading one; none where the value is below its uncertainty
                let significant = if value == 0.0 { 0 } else { digits.saturating_add(leading_digit(value)) };
                return format!("{value:.*e}", number::unsigned(significant.min(16)));
            }
            let text = format!("{value:.*}", number::unsigned(digits));
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
        return format!("{value:.*e}", number::unsigned(digits - 1));
    }
    format!("{value:.*}", number::unsigned(digits - 1 - lead))
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
    number::whole(value.abs().log10().floor())
}

/// A probability in percent, to four digits and without idle zeros.
pub fn percent(p: f64) -> String {
    trim(significant(100.0 * p, 4))
}

/// A level as a person writes it, with all digits that were given: `95 %`, `99.73 %`.
pub fn level(level: f64) -> String {
    format!("{} %", level_in_percent(level))
}

/// The number of [`level`] without its sign, for sentences that have it.
pub fn level_in_percent(level: f64) -> String {
    trim(significant(100.0 * level, 8))
}

fn trim(text: String) -> String {
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').into() } else { text }
}

/// From here on a t distribution is the normal one to any printed digit.
const MANY: f64 = 1e6;

/// Degrees of freedom: whole ones and those from 100 without a point, infinite ones as `inf`.
pub fn dof(dof: f64) -> String {
    match dof {
        _ if dof > MANY => "inf".into(),
        _ if dof >= 100.0 || (dof - dof.round()).abs() < 0.05 => format!("{dof:.0}"),
        _ => format!("{dof:.1}"),
    }
}

/// Probability of a test, to two digits.
pub fn probability(p: f64) -> String {
    if p == 0.0 { "< 1e-300".into() } else { significant(p, 2) }
}
