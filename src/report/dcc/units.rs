//! Units in the notation of D-SI, every factor with its power: `\volt\degree\tothe{-1}\second`; what D-SI does not have stands after a bar: `|g`.

use crate::units::{Unit, plain};

/// The product of units in D-SI's notation; nothing and `1` are `\one`.
///
/// Angles in degrees, arcseconds and hours are units accepted beside the SI and have D-SI names.
pub(super) fn d_si(units: &[&str]) -> String {
    let units: Vec<&str> = units.iter().map(|unit| unit.trim()).filter(|unit| !matches!(*unit, "" | "1")).collect();
    quotient(&units).unwrap_or_else(|| {
        let bracketed = |unit: &&str| match units.len() > 1 && unit.contains('/') {
            true => format!("({unit})"),
            false => unit.to_string(),
        };
        format!("|{}", units.iter().map(bracketed).collect::<Vec<_>>().join("*").replace(char::is_whitespace, ""))
    })
}

/// `None` where a part is not known to D-SI.
fn quotient(units: &[&str]) -> Option<String> {
    let mut parsed = units.iter().map(|unit| Unit::parse_any(unit).ok());
    let product = parsed.try_fold(Unit::one(), |product, unit| Some(product.times(&unit?.0, 1.0)))?;
    let written = product.factors().iter().map(|(symbol, power)| {
        let exponent = if *power == 1.0 { String::new() } else { format!("\\tothe{{{power}}}") };
        Some(name(symbol)? + &exponent)
    });
    let written: String = written.collect::<Option<_>>()?;
    Some(if written.is_empty() { "\\one".into() } else { written })
}

/// Names without prefix, and names that prefixes may stand before.
const WHOLE: &[(&str, &str)] = &[
    ("deg", "\\degree"),
    ("arcmin", "\\arcminute"),
    ("arcsec", "\\arcsecond"),
    ("min", "\\minute"),
    ("h", "\\hour"),
    ("day", "\\day"),
    ("degC", "\\degreecelsius"),
    ("%", "\\percent"),
    ("ppm", "\\ppm"),
    ("kg", "\\kilogram"),
    ("cm", "\\centi\\metre"),
    ("hPa", "\\hecto\\pascal"),
];
const PREFIXED: &[(&str, &str)] = &[
    ("V", "\\volt"),
    ("A", "\\ampere"),
    ("ohm", "\\ohm"),
    ("Hz", "\\hertz"),
    ("rad", "\\radian"),
    ("s", "\\second"),
    ("K", "\\kelvin"),
    ("m", "\\metre"),
    ("N", "\\newton"),
    ("Pa", "\\pascal"),
    ("W", "\\watt"),
    ("T", "\\tesla"),
];
const PREFIXES: &[(char, &str)] = &[
    ('n', "\\nano"),
    ('u', "\\micro"),
    ('\u{b5}', "\\micro"),
    ('\u{3bc}', "\\micro"),
    ('m', "\\milli"),
    ('k', "\\kilo"),
    ('M', "\\mega"),
];

fn name(symbol: &str) -> Option<String> {
    let symbol = plain(symbol);
    let of = |list: &[(&str, &'static str)], wanted: &str| {
        list.iter().find(|(symbol, _)| *symbol == wanted).map(|(_, name)| name.to_string())
    };
    of(WHOLE, symbol).or_else(|| of(PREFIXED, symbol)).or_else(|| {
        let first = symbol.chars().next()?;
        let (_, prefix) = PREFIXES.iter().find(|(symbol, _)| *symbol == first)?;
        Some(format!("{prefix}{}", of(PREFIXED, symbol.get(first.len_utf8()..)?)?))
    })
}
