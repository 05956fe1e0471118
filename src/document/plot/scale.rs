//! From numbers to axes: powers of a thousand, ranges that are never empty, ticks.

use crate::number;

/// A power of ten, multiple of three, that brings the largest finite size to 1 .. 1000.
pub(super) fn exponent(values: impl Iterator<Item = f64>) -> i32 {
    let largest = values.filter(|v| v.is_finite()).fold(0.0_f64, |m, v| m.max(v.abs()));
    if largest < f64::MIN_POSITIVE {
        return 0;
    }
    (number::whole((largest.log10() / 3.0).floor()) * 3).clamp(-300, 300)
}

/// An exponent that keeps numbers of everyday size as they are.
pub(super) fn readable_exponent(values: impl Iterator<Item = f64>) -> i32 {
    match exponent(values) {
        -3 | 0 | 3 => 0,
        other => other,
    }
}

/// A value in units of ten to the exponent; what is not finite or out of reach becomes zero.
pub(super) fn scaled(value: f64, exponent: i32) -> f64 {
    let scaled = if exponent < 0 { value * 10f64.powi(-exponent) } else { value / 10f64.powi(exponent) };
    if scaled.is_finite() && scaled.abs() < 1e9 { scaled } else { 0.0 }
}

/// A title with its unit and power of ten: `residual, 10⁻³ V`.
pub(super) fn title(what: &str, unit: &str, exponent: i32) -> String {
    let power = if exponent == 0 {
        String::new()
    } else {
        let digits = "\u{2070}\u{b9}\u{b2}\u{b3}\u{2074}\u{2075}\u{2076}\u{2077}\u{2078}\u{2079}";
        let superscript = exponent
            .abs()
            .to_string()
            .chars()
            .filter_map(|d| digits.chars().nth(d.to_digit(10)? as usize))
            .collect::<String>();
        format!("10{}{superscript}", if exponent < 0 { "\u{207b}" } else { "" })
    };
    let unit = [power.as_str(), unit].iter().filter(|s| !s.is_empty()).copied().collect::<Vec<_>>().join(" ");
    let title = if unit.is_empty() { what.to_string() } else { format!("{what}, {unit}") };
    title.chars().map(|c| if c.is_control() { ' ' } else { c }).collect()
}

/// A range that holds all values with a margin, and is never empty.
pub(super) fn range(values: impl Iterator<Item = f64>, margin: f64) -> (f64, f64) {
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    for value in values.filter(|v| v.is_finite()) {
        low = low.min(value);
        high = high.max(value);
    }
    if low > high {
        return (-1.0, 1.0);
    }
    let least = 1e-6 * low.abs().max(high.abs()).max(1e-3);
    let width = (high - low).max(least);
    (low - margin * width, high + margin * width)
}

/// Round positions of ticks within a range, 1, 2 or 5 times a power of ten apart, and the decimals that their labels need; three or more, so that a scale can be
/// read from them.
pub(super) fn ticks(low: f64, high: f64, most: usize) -> (Vec<f64>, usize) {
    let width = high - low;
    if !(width > 0.0) || !width.is_finite() {
        return (vec![low], 3);
    }
    let rough = width / most.max(1) as f64;
    let power = 10f64.powf(rough.log10().floor());
    let within = |step: f64| (high / step + 1e-9).floor() - (low / step - 1e-9).ceil() + 1.0;
    let steps = [10.0, 5.0, 2.0, 1.0, 0.5, 0.2].map(|m| m * power);
    let near = steps.into_iter().rev().find(|step| *step >= rough).unwrap_or(10.0 * power);
    let step = steps.into_iter().find(|step| *step <= near && within(*step) >= 3.0).unwrap_or(near);
    let decimals = number::count((-(step.log10() + 1e-9).floor()).clamp(0.0, 12.0));
    let first = number::whole_i64((low / step).ceil());
    let ticks =
        (first..).take(3 * most + 3).map(|k| k as f64 * step).take_while(|t| *t <= high + 1e-9 * width).collect();
    (ticks, decimals)
}

/// A tick's label, with a true minus sign.
pub(super) fn label(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$}");
    let zero = text.trim_start_matches('-').chars().all(|c| c == '0' || c == '.');
    match text.strip_prefix('-') {
        Some(size) if !zero => format!("\u{2212}{size}"),
        Some(size) => size.to_string(),
        None => text,
    }
}
