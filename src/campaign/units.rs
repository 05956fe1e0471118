//! Units of coefficients, read off the model line: in `V0 + kI*w_I`, with V in volts and rates in deg/s, `kI` is in V/(deg/s).

use crate::algebra::Term;
use crate::bench::{Bench, Sensor};

/// The unit of a coefficient: the sensor's unit over the units of what it multiplies; `None` where the line does not tell.
///
/// A term with a second coefficient tells nothing; a numeric column's unit is the end of its name (`time_s`, `temperature_c`).
///
/// ```
/// use tumble::{bench, campaign, wire};
/// let text = bench::built_in("gyro-turntable").unwrap().text;
/// let bench = wire::read_bench(&wire::Source { name: String::new(), text: text.into() })?;
/// assert_eq!(campaign::coefficient_unit(&bench, "kIO").as_deref(), Some("V/(deg/s)^2"));
/// # Ok::<(), tumble::error::Malformed>(())
/// ```
pub fn coefficient_unit(bench: &Bench, coefficient: &str) -> Option<String> {
    bench.sensors.iter().find_map(|sensor| {
        let terms = sensor.model.terms()?;
        let term =
            terms.iter().find(|term| term.powers.iter().any(|(name, power)| name == coefficient && *power == 1.0))?;
        unit_beside(bench, sensor, term, coefficient)
    })
}

fn unit_beside(bench: &Bench, sensor: &Sensor, term: &Term, coefficient: &str) -> Option<String> {
    let mut denominator: Vec<(String, f64)> = Vec::new();
    for (name, power) in term.powers.iter().filter(|(name, _)| name != coefficient) {
        let unit = input_unit(bench, name)?;
        match denominator.iter_mut().find(|(own, _)| *own == unit) {
            _ if unit.is_empty() => {}
            Some((_, own)) => *own += power,
            None => denominator.push((unit, *power)),
        }
    }
    let below: Vec<String> =
        denominator.iter().filter(|(_, power)| *power != 0.0).map(|(unit, power)| raised(unit, *power)).collect();
    Some(match (sensor.unit.as_str(), below.as_slice()) {
        (unit, []) => unit.to_string(),
        ("", below) => format!("1/{}", grouped(below)),
        (unit, below) => format!("{unit}/{}", grouped(below)),
    })
}

fn raised(unit: &str, power: f64) -> String {
    let base = if unit.contains(['/', '^']) { format!("({unit})") } else { unit.to_string() };
    if power == 1.0 { base } else { format!("{base}^{power}") }
}

fn grouped(factors: &[String]) -> String {
    if let [only] = factors { only.clone() } else { format!("({})", factors.join("*")) }
}

/// The unit of an input of a model line; empty for a pure number (a joint's angle), `None` for what is no input.
fn input_unit(bench: &Bench, name: &str) -> Option<String> {
    if super::is_axis_input(bench, name) {
        let unit = if name.starts_with("w_") { bench.units.rate.symbol() } else { bench.units.force.symbol() };
        return Some(unit.into());
    }
    if bench.joints().any(|joint| joint == name) {
        return Some(String::new());
    }
    let suffixes = [
        ("_deg_s", "deg/s"),
        ("_deg_h", "deg/h"),
        ("_deg", "deg"),
        ("_s", "s"),
        ("_min", "min"),
        ("_h", "h"),
        ("_c", "degC"),
        ("_k", "K"),
    ];
    suffixes.iter().find(|(suffix, _)| name.ends_with(suffix)).map(|(_, unit)| (*unit).to_string())
}
