//! Numbers as every output writes them: with as many digits as their uncertainty carries.

use crate::number;

/// With more decimals than this a number has an exponent: value, u and U of a table then take 3 * (14 + 2) of a terminal's 80 columns and leave 32
/// for names, units, degrees of freedom and k.
const PLAIN: i32 = 11;

/// The decimal place of the second significant digit of an uncertainty, as it is rounded (GUM 7.2.6): 2 for 0.13 and for 0.0996, which is 0.10; -1 for 130. No
/// place where there is no uncertainty.
///
/// ```
/// use tumble::document::number::places;
/// assert_eq!([0.13, 0.0996, 130.0].map(places), [Some(2), Some(2), Some(-1)]);
/// assert_eq!([0.0, f64::NAN].map(places), [None, None]);
/// ```
pub fn places(uncertainty: f64) -> Option<i32> {
    let is_one = uncertainty > 0.0 && uncertainty.is_finite();
    let rounded = is_one.then(|| format!("{uncertainty:.1e}"))?;
    rounded.split_once('e').and_then(|(_, exponent)| exponent.parse::<i32>().ok()).map(|exponent| 1 - exponent)
}

/// A value rounded at the second significant digit of its uncertainty, or to six digits where it has none.
///
/// ```
/// use tumble::document::number::rounded;
/// assert_eq!(rounded(-162.0687, Some(0.5987)), "-162.07");
/// assert_eq!(rounded(12345.6, Some(678.0)), "12350");
/// assert_eq!(rounded(0.001234567, None), "0.00123457");
/// assert_eq!(rounded(-3.3217e-11, Some(1.2e-12)), "-3.32e-11");
/// ```
pub fn rounded(value: f64, uncertainty: Option<f64>) -> String {
    match uncertainty.and_then(places) {
        Some(digits) => {
            if !(-6..=PLAIN).contains(&digits) {
                // the same digits behind the leading one; none where the value is below its uncertainty
                let significant = if value == 0.0 { 0 } else { digits.saturating_add(leading_digit(value)) };
                return format!("{value:.*e}", number::unsigned(significant.min(16)));
            }
            let unit = 10f64.powi(-digits);
            let value = if digits < 0 { (value / unit).round() * unit } else { value };
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
    // the exponent of the rounded number: 0.00996 is 0.010
    let written = format!("{value:.*e}", number::unsigned(digits - 1));
    let lead = written.split_once('e').and_then(|(_, exponent)| exponent.parse().ok()).unwrap_or(leading_digit(value));
    if !(-5..9).contains(&lead) {
        return written;
    }
    format!("{value:.*}", number::unsigned(digits - 1 - lead))
}

/// Six digits at most, no idle zeros.
pub(crate) fn trimmed(value: f64) -> String {
    at_most(value, 6)
}

/// So many digits at most, no idle zeros.
pub(crate) fn at_most(value: f64, digits: i32) -> String {
    let text = significant(value, digits);
    if text.contains('e') { text } else { trim(text) }
}

fn leading_digit(value: f64) -> i32 {
    number::whole(value.abs().log10().floor())
}

/// A probability in percent, to four digits and without idle zeros.
pub(crate) fn percent(p: f64) -> String {
    trim(significant(100.0 * p, 4))
}

/// A level as a person writes it, with all digits that were given: `95 %`, `99.73 %`.
pub(crate) fn level(level: f64) -> String {
    format!("{} %", level_in_percent(level))
}

/// The number of [`level`] without its sign, for sentences that have it.
pub(crate) fn level_in_percent(level: f64) -> String {
    trim(significant(100.0 * level, 8))
}

fn trim(text: String) -> String {
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').into() } else { text }
}

/// From here on a t distribution is the normal one to any printed digit.
const MANY: f64 = 1e6;

/// Degrees of freedom: whole ones and those from 100 without a point, infinite ones as `inf`.
pub(crate) fn dof(dof: f64) -> String {
    match dof {
        _ if dof > MANY => "inf".into(),
        _ if dof >= 100.0 || (dof - dof.round()).abs() < 0.05 => format!("{dof:.0}"),
        _ => format!("{dof:.1}"),
    }
}

/// Probability of a test, to two digits.
pub(crate) fn probability(p: f64) -> String {
    if p == 0.0 { "< 1e-300".into() } else { significant(p, 2) }
}
