//! Titles of columns: a name, and the unit that stands behind it in brackets.

use crate::units::Unit;

/// Name and unit of a title such as `Acc X [m/s^2]`, `Winkel (Grad)`, `Rate in deg/s`, `rate / deg/s` or `U/mV` (ISO 80000-1). A number in brackets is an index of the name,
/// and a unit alone (`deg/s`) is a name; a quotient of units that is a pure number (`V/mV`) is a quantity over its unit.
///
/// ```
/// use tumble::record::title;
/// assert_eq!(title("Winkel (Grad)"), ("Winkel".into(), Some("Grad".into())));
/// assert_eq!(title("time_s"), ("time_s".into(), None));
/// assert_eq!(title("gyro_rad[0]"), ("gyro_rad[0]".into(), None));
/// assert_eq!(title("输出（mV）"), ("输出".into(), Some("mV".into())));
/// assert_eq!(title("Output [mV] mean"), ("Output mean".into(), Some("mV".into())));
/// assert_eq!(title("[rad/s] Rate"), ("Rate".into(), Some("rad/s".into())));
/// assert_eq!(title("Rate (rad/s, Z)"), ("Rate".into(), Some("rad/s".into())));
/// assert_eq!(title("t/ms"), ("t".into(), Some("ms".into())));
/// assert_eq!(title("Rate deg/s"), ("Rate".into(), Some("deg/s".into())));
/// assert_eq!(title("deg/s"), ("deg/s".into(), None));
/// assert_eq!(title("V/mV"), ("V".into(), Some("mV".into())));
/// assert_eq!(title("Drehrate in °/s"), ("Drehrate".into(), Some("°/s".into())));
/// ```
pub fn title(text: &str) -> (String, Option<String>) {
    let text = text.trim();
    for (open, close) in [('[', ']'), ('(', ')'), ('{', '}'), ('（', '）'), ('［', '］'), ('【', '】'), ('<', '>')]
    {
        if let Some(rest) = text.strip_suffix(close)
            && let Some((name, unit)) = rest.rsplit_once(open)
            && !name.trim().is_empty()
            && (open != '[' || name.ends_with(' ') || unit.is_empty() || unit.bytes().any(|b| !b.is_ascii_digit()))
        {
            // beside a unit other words may stand
            let is_unit = |part: &&str| Unit::parse(part).is_ok_and(|unit| !unit.dimension().is_number());
            let mut units = unit.split(',').filter(is_unit);
            let unit = units.next().filter(|_| units.next().is_none()).unwrap_or(unit).trim();
            return (name.trim().to_string(), Some(unit.to_string()).filter(|unit| !unit.is_empty()));
        }
        // a unit before further words
        if let Some((name, rest)) = text.split_once(open)
            && let Some((unit, more)) = rest.split_once(close)
            && Unit::parse(unit).is_ok_and(|unit| !unit.dimension().is_number())
        {
            let words = format!("{} {}", name.trim(), more.trim()).trim().to_string();
            if !words.is_empty() {
                return (words, Some(unit.trim().to_string()));
            }
        }
    }
    if let Some((name, unit)) = text.rsplit_once(" in ")
        && Unit::parse(unit).is_ok()
    {
        return (name.trim().to_string(), Some(unit.trim().to_string()));
    }
    if let Some((name, unit)) = text.rsplit_once(' ')
        && unit.contains('/')
        && Unit::parse(unit).is_ok()
    {
        return (name.trim().to_string(), Some(unit.to_string()));
    }
    match text.split_once(" / ") {
        Some((name, unit)) if !name.trim().is_empty() => (name.trim().to_string(), Some(unit.trim().to_string())),
        _ => match text.split_once('/') {
            Some((name, unit))
                if name.starts_with(char::is_alphabetic)
                    && Unit::parse(unit).is_ok()
                    && !Unit::parse(text).is_ok_and(|whole| !whole.dimension().is_number()) =>
            {
                (name.trim().to_string(), Some(unit.trim().to_string()))
            }
            _ => (text.to_string(), None),
        },
    }
}

/// A unit without the brackets around it.
pub(super) fn bare(unit: &str) -> String {
    unit.trim().trim_matches(|c| matches!(c, '[' | ']' | '(' | ')')).trim().to_string()
}

/// Can a line of texts be the units of the columns named above it?
pub(super) fn is_units(cells: &[String]) -> bool {
    let filled: Vec<String> = cells.iter().map(|cell| bare(cell)).filter(|cell| !cell.is_empty()).collect();
    !filled.is_empty() && filled.iter().all(|cell| cell == "-" || Unit::parse(cell).is_ok())
}
