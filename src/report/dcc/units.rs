//! Units in the notation of D-SI: `\volt`, `\volt\per\degree`; what D-SI does not have stands after a bar: `|g`.

/// A unit as `tumble` writes it, in D-SI's notation. `1` and nothing are `\one`.
///
/// Angles in degrees, arcseconds and hours are units accepted beside the SI and have D-SI names.
pub(super) fn d_si(unit: &str) -> String {
    match unit.trim() {
        "" | "1" => "\\one".into(),
        unit => quotient(unit).unwrap_or_else(|| format!("|{}", unit.replace(char::is_whitespace, ""))),
    }
}

/// The unit of the covariance of two quantities.
pub(super) fn product(a: &str, b: &str) -> String {
    match (a, b) {
        ("\\one", other) | (other, "\\one") => other.to_string(),
        (a, b) if a.starts_with('|') || b.starts_with('|') => {
            format!("|{}*{}", a.trim_start_matches('|'), b.trim_start_matches('|'))
        }
        (a, b) if a == b && !a.contains("\\per") && a.matches('\\').count() == 1 => format!("{a}\\tothe{{2}}"),
        (a, b) => {
            let halves = |unit: &str| match unit.split_once("\\per") {
                Some((above, below)) => (above.to_string(), format!("\\per{below}")),
                None => (unit.to_string(), String::new()),
            };
            let ((a, below_a), (b, below_b)) = (halves(a), halves(b));
            format!("{a}{b}{below_a}{below_b}").replace("\\one", "")
        }
    }
}

/// `a`, `a/b`, `a/(b/c)`, `a/b/c`, with powers; `None` where a part is not known to D-SI.
fn quotient(unit: &str) -> Option<String> {
    let (mut above, mut below) = (String::new(), String::new());
    factors(unit, false, &mut above, &mut below)?;
    let above = if above.is_empty() { "\\one".to_string() } else { above };
    Some(above + &below)
}

fn factors(text: &str, under: bool, above: &mut String, below: &mut String) -> Option<()> {
    let mut under_now = under;
    for (k, part) in split(text)?.into_iter().enumerate() {
        if k > 0 {
            under_now = !under;
        }
        let (base, power) = match part.rsplit_once('^').filter(|(base, _)| !base.contains('/') || base.ends_with(')')) {
            Some((base, power)) => (base, power.parse::<u32>().ok()?),
            None => (part.as_str(), 1),
        };
        if let Some(inner) = base.strip_prefix('(').and_then(|rest| rest.strip_suffix(')')) {
            for _ in 0..power.min(9) {
                factors(inner, under_now, above, below)?;
            }
            continue;
        }
        let name = if base == "1" { continue } else { name(base)? };
        let exponent = if power == 1 { String::new() } else { format!("\\tothe{{{power}}}") };
        if under_now {
            below.push_str(&format!("\\per{name}{exponent}"));
        } else {
            above.push_str(&format!("{name}{exponent}"));
        }
    }
    Some(())
}

/// The parts between slashes outside parentheses; parts after the first are divided by.
fn split(text: &str) -> Option<Vec<String>> {
    let (mut depth, mut parts) = (0_i32, vec![String::new()]);
    for c in text.chars() {
        match c {
            '(' => depth += 1,
            ')' => depth -= 1,
            '/' if depth == 0 => {
                parts.push(String::new());
                continue;
            }
            '*' | ' ' => return None,
            _ => {}
        }
        parts.last_mut()?.push(c);
    }
    (depth == 0 && parts.len() < 9).then_some(parts)
}

fn name(symbol: &str) -> Option<&'static str> {
    Some(match symbol {
        "V" => "\\volt",
        "mV" => "\\milli\\volt",
        "uV" => "\\micro\\volt",
        "A" => "\\ampere",
        "mA" => "\\milli\\ampere",
        "Hz" => "\\hertz",
        "rad" => "\\radian",
        "mrad" => "\\milli\\radian",
        "urad" => "\\micro\\radian",
        "deg" => "\\degree",
        "arcmin" => "\\arcminute",
        "arcsec" => "\\arcsecond",
        "s" => "\\second",
        "min" => "\\minute",
        "h" => "\\hour",
        "m" => "\\metre",
        "mm" => "\\milli\\metre",
        "um" => "\\micro\\metre",
        "kg" => "\\kilogram",
        "N" => "\\newton",
        "K" => "\\kelvin",
        "degC" | "c" => "\\degreecelsius",
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_have_their_d_si_names() {
        assert_eq!(d_si("V"), "\\volt");
        assert_eq!(d_si("V/(deg/s)"), "\\volt\\second\\per\\degree");
        assert_eq!(d_si("V/(deg/s)^2"), "\\volt\\second\\second\\per\\degree\\per\\degree");
        assert_eq!(d_si("deg/h/(deg/h)"), "\\degree\\hour\\per\\hour\\per\\degree");
        assert_eq!(d_si("1/s"), "\\one\\per\\second");
        assert_eq!((d_si(""), d_si("1"), d_si("g/g^2")), ("\\one".into(), "\\one".into(), "|g/g^2".into()));
        assert_eq!(d_si("(((("), "|((((");
    }

    #[test]
    fn covariances_have_the_product_of_units() {
        assert_eq!(product("\\radian", "\\radian"), "\\radian\\tothe{2}");
        assert_eq!(product("\\volt", "\\radian"), "\\volt\\radian");
        assert_eq!(product("\\one", "\\volt"), "\\volt");
        assert_eq!(product("\\volt\\per\\second", "\\radian"), "\\volt\\radian\\per\\second");
        assert_eq!(product("|g", "\\volt"), "|g*\\volt");
    }
}
