//! The correction that a user applies: each model line solved for its input, and the rotation by the tilts that travel with the sensor.
//!
//! ```text
//! V = V0 + kI*w_I + kII*w_I^2      ->      w_I = (V - V0 - kII*w_I^2)/kI       (terms in the input itself: by iteration)
//! w_mount = R w_sensor,   R = the chain's tilts after its last joint
//! ```
//!
//! Terms that are zero because their coefficient is assumed zero are dropped. Deliberately absent: the correction of a reading (a program does
//! that from the JSON report), uncertainty of the corrected input.

use super::table::rounded;
use crate::algebra::{Expression, Tape};
use crate::bench::{Link, Sensor};
use crate::campaign::{Campaign, Role, is_axis_input};
use crate::fit::{Fit, State};
use nalgebra::{Rotation3, Unit, Vector3};

/// How one sensor's reading is corrected.
#[derive(Debug, Clone, PartialEq)]
pub struct Correction {
    /// The sensor.
    pub sensor: String,
    /// The input that its line is solved for, for example `w_I`.
    pub input: String,
    /// The line solved, with names.
    pub symbolic: String,
    /// The same with numbers; `None` where a coefficient that it needs is not estimable.
    pub numeric: Option<String>,
    /// Coefficients that it needs and that are not estimable.
    pub missing: Vec<String>,
    /// Does the right side hold the input itself?
    pub iterate: bool,
}

/// Where the axis of a sensor's input points in the frame of its mounting face, the frame after the chain's last joint.
#[derive(Debug, Clone, PartialEq)]
pub struct Direction {
    /// The sensor.
    pub sensor: String,
    /// The input, for example `w_I`.
    pub input: String,
    /// Direction cosines along x, y, z of the mounting face.
    pub cosines: [f64; 3],
}

/// The tilts after the last joint: those that travel with the sensor.
#[derive(Debug, Clone, PartialEq)]
pub struct Mounting {
    /// Their names, in chain order.
    pub tilts: Vec<String>,
    /// Those of them that are not estimable.
    pub missing: Vec<String>,
    /// Direction of each corrected input; empty where a tilt is missing.
    pub directions: Vec<Direction>,
}

/// The corrections of all sensors whose line can be solved for an input.
///
/// ```
/// use tumble::{fit, report, wire};
/// let text = r#"{ "bench": { "id": "b", "chain": [ {"joint": "t", "about": "x"} ],
///       "sensors": { "V": { "axes": {"I": "z"}, "model": "V0 + k*a_I + q*a_I^2" } } },
///     "known": { "k": { "value": 2 } }, "estimate": { "V0": {} },
///     "readings": [ {"t_deg": 0, "V": 2.5}, {"t_deg": 180, "V": -1.5} ] }"#;
/// let source = wire::Source { name: "b".into(), text: text.into() };
/// let campaign = wire::read_campaign(&source, &mut |_| unreachable!())?;
/// let fit = fit::fit(&campaign, &fit::Settings::default())?;
/// let correction = &report::corrections(&fit)[0];
/// assert_eq!(correction.symbolic, "a_I = (V - V0)/k");
/// assert_eq!(correction.numeric.as_deref(), Some("a_I = (V - 0.5)/2"));
/// # Ok::<(), tumble::error::Malformed>(())
/// ```
pub fn corrections(fit: &Fit) -> Vec<Correction> {
    fit.campaign.bench.sensors.iter().filter_map(|sensor| correction(fit, sensor)).collect()
}

fn correction(fit: &Fit, sensor: &Sensor) -> Option<Correction> {
    let campaign = &fit.campaign;
    let terms: Vec<Term> = terms(&sensor.model.to_string()).into_iter().filter(|term| acts(campaign, term)).collect();
    let input = terms.iter().find_map(|term| solvable_input(campaign, term))?;
    let (slope, rest): (Vec<_>, Vec<_>) = terms.iter().partition(|term| coefficient(term, &input).is_some());
    let mut numerator = sensor.id.clone();
    for term in &rest {
        numerator.push_str(if term.negative { " + " } else { " - " });
        numerator.push_str(&term.text);
    }
    let mut denominator = String::new();
    for term in &slope {
        let factor = coefficient(term, &input)?;
        denominator.push_str(match (denominator.is_empty(), term.negative) {
            (true, true) => "-",
            (true, false) => "",
            (false, true) => " - ",
            (false, false) => " + ",
        });
        denominator.push_str(&factor);
    }
    let closed = if rest.is_empty() { numerator.clone() } else { format!("({numerator})") };
    let symbolic = match denominator.as_str() {
        "1" => format!("{input} = {numerator}"),
        simple if simple.chars().all(|c| c.is_alphanumeric() || c == '_') => format!("{input} = {closed}/{simple}"),
        compound => format!("{input} = {closed}/({compound})"),
    };
    let names: Vec<String> = identifiers(&symbolic);
    let not_estimable =
        |name: &&String| fit.parameters.iter().any(|p| p.id == **name && p.state == State::NotEstimable);
    let missing: Vec<String> = names.iter().filter(not_estimable).cloned().collect();
    let right = symbolic.split_once(" = ").map_or("", |(_, right)| right);
    Some(Correction {
        sensor: sensor.id.clone(),
        iterate: identifiers(right).contains(&input),
        numeric: missing.is_empty().then(|| with_numbers(fit, &symbolic)),
        input,
        symbolic,
        missing,
    })
}

/// A term of a sum, without its sign.
#[derive(Debug, Clone, PartialEq)]
struct Term {
    negative: bool,
    text: String,
}

/// The terms of a printed line: only sums are printed with spaces around their sign.
fn terms(line: &str) -> Vec<Term> {
    let mut terms = Vec::new();
    let (mut depth, mut negative, mut text) = (0_usize, false, String::new());
    let letters: Vec<char> = line.chars().collect();
    for (k, c) in letters.iter().enumerate() {
        let spaced = k > 0 && letters.get(k - 1) == Some(&' ') && letters.get(k + 1) == Some(&' ');
        match c {
            '(' => depth += 1,
            ')' => depth = depth.saturating_sub(1),
            '+' | '-' if depth == 0 && spaced => {
                terms.push(Term { negative, text: text.trim().to_string() });
                (negative, text) = (*c == '-', String::new());
                continue;
            }
            _ => {}
        }
        text.push(*c);
    }
    terms.push(Term { negative, text: text.trim().to_string() });
    for term in &mut terms {
        if let Some(positive) = term.text.strip_prefix('-') {
            (term.negative, term.text) = (!term.negative, positive.to_string());
        }
    }
    terms
}

/// Is a term more than zero, with what is assumed zero put to zero and everything else at odd values?
fn acts(campaign: &Campaign, term: &Term) -> bool {
    let Ok(expression) = Expression::parse(&term.text) else { return true };
    let names = expression.names();
    let Ok(tape) = Tape::compile(&expression, &names) else { return true };
    let at = |shift: f64| {
        let values: Vec<f64> = names
            .iter()
            .enumerate()
            .map(|(k, name)| match campaign.parameters.iter().find(|p| p.id == *name).map(|p| &p.role) {
                Some(Role::AssumedZero) => 0.0,
                _ => 0.37 + 0.61 * (k as f64) + shift,
            })
            .collect();
        tape.value(&values, &mut crate::algebra::Scratch::default())
    };
    at(0.0) != 0.0 || at(0.29) != 0.0
}

/// A rate or force along an axis that the term is a plain multiple of.
fn solvable_input(campaign: &Campaign, term: &Term) -> Option<String> {
    let names = identifiers(&term.text);
    names.into_iter().find(|name| is_axis_input(&campaign.bench, name) && coefficient(term, name).is_some())
}

/// What multiplies the input in a term `a*b*input`; `None` if the term is not a plain multiple of it.
fn coefficient(term: &Term, input: &str) -> Option<String> {
    let (mut depth, mut factors) = (0_usize, vec![String::new()]);
    for c in term.text.chars() {
        match c {
            '(' => depth += 1,
            ')' => depth = depth.saturating_sub(1),
            '*' if depth == 0 => {
                factors.push(String::new());
                continue;
            }
            _ => {}
        }
        factors.last_mut()?.push(c);
    }
    let others: Vec<String> = factors.iter().filter(|factor| *factor != input).cloned().collect();
    let plain = others.len() + 1 == factors.len() && !others.iter().any(|f| identifiers(f).iter().any(|n| n == input));
    plain.then(|| if others.is_empty() { "1".into() } else { others.join("*") })
}

/// Names in a text of algebra, functions included, in order.
fn identifiers(text: &str) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for word in text.split(|c: char| !(c.is_alphanumeric() || c == '_' || c == '.')) {
        if word.starts_with(|c: char| c.is_alphabetic() || c == '_') && !names.iter().any(|n| n == word) {
            names.push(word.to_string());
        }
    }
    names
}

/// A line with the estimated and known values in place of their names, two digits beyond their uncertainty.
fn with_numbers(fit: &Fit, line: &str) -> String {
    let mut out = String::new();
    let mut word = String::new();
    for c in line.chars().chain([' ']) {
        if c.is_alphanumeric() || c == '_' || c == '.' {
            word.push(c);
            continue;
        }
        match number(fit, &word) {
            Some(number) if number.starts_with('-') && out.ends_with("- ") => {
                out.truncate(out.len() - 2);
                out.push_str(&format!("+ {}", number.trim_start_matches('-')));
            }
            Some(number) if number.starts_with('-') && out.ends_with("+ ") => {
                out.truncate(out.len() - 2);
                out.push_str(&format!("- {}", number.trim_start_matches('-')));
            }
            Some(number) if number.starts_with('-') && !out.ends_with('(') => out.push_str(&format!("({number})")),
            Some(number) => out.push_str(&number),
            None => out.push_str(&word),
        }
        word.clear();
        out.push(c);
    }
    out.trim_end().to_string()
}

fn number(fit: &Fit, name: &str) -> Option<String> {
    let index = fit.campaign.parameter_index(name)?;
    let value = fit.point.get(index).copied()?;
    if let Some(result) = fit.parameters.iter().find(|p| p.id == name) {
        let u = result.uncertainty.map(|c| c.u / 100.0);
        let text = rounded(value, u);
        if !text.contains('e') {
            return Some(text);
        }
        // an uncertainty at the level of rounding, or far from one: fifteen digits say it all
        return Some(format!("{value:.14e}").parse::<f64>().map_or(text, |shortest| shortest.to_string()));
    }
    Some(value.to_string())
}

/// The tilts after the last joint, and where they turn each corrected input; `None` where the chain ends with a joint.
///
/// `u_mount = R1(t1) R2(t2) ... u_sensor`, exact rotations at the estimates.
pub fn mounting(fit: &Fit) -> Option<Mounting> {
    let chain = &fit.campaign.bench.chain;
    let after = chain.iter().rposition(|link| matches!(link, Link::Joint { .. })).map_or(0, |k| k + 1);
    let last = chain.get(after..).unwrap_or_default();
    let taken = |name: &str| {
        let role = fit.campaign.parameters.iter().find(|p| p.id == name).map(|p| &p.role);
        !matches!(role, None | Some(Role::AssumedZero))
    };
    let tilts: Vec<String> = last.iter().map(|link| link.name().to_string()).filter(|name| taken(name)).collect();
    if tilts.is_empty() {
        return None;
    }
    let not_estimable =
        |name: &&String| fit.parameters.iter().any(|p| p.id == **name && p.state == State::NotEstimable);
    let missing: Vec<String> = tilts.iter().filter(not_estimable).cloned().collect();
    let mut rotation_ms = Rotation3::identity();
    for link in last {
        if let Link::Tilt { name, about, .. } = link {
            let angle = fit.campaign.parameter_index(name).and_then(|k| fit.point.get(k)).copied().unwrap_or_default();
            rotation_ms *= Rotation3::from_axis_angle(&Unit::new_unchecked(about.unit()), angle);
        }
    }
    let mut directions = Vec::new();
    for correction in corrections(fit).iter().filter(|_| missing.is_empty()) {
        let Some(sensor) = fit.campaign.bench.sensors.iter().find(|s| s.id == correction.sensor) else { continue };
        let axis = correction.input.get(2..).unwrap_or_default();
        let named = sensor.axes.iter().find(|(own, _)| own == axis).map(|(_, direction)| *direction);
        let frame = match axis {
            "x" => Some(Vector3::x()),
            "y" => Some(Vector3::y()),
            "z" => Some(Vector3::z()),
            _ => None,
        };
        let Some(direction) = named.or(frame) else { continue };
        let turned = rotation_ms * direction;
        let cosines = [turned.x, turned.y, turned.z];
        directions.push(Direction { sensor: sensor.id.clone(), input: correction.input.clone(), cosines });
    }
    Some(Mounting { tilts, missing, directions })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_falls_into_its_terms() {
        let texts: Vec<(bool, String)> =
            terms("-a + k*(x - y)*w_I - 1e-3*b").into_iter().map(|t| (t.negative, t.text)).collect();
        assert_eq!(texts, [(true, "a".into()), (false, "k*(x - y)*w_I".into()), (true, "1e-3*b".into())]);
    }

    #[test]
    fn a_coefficient_is_what_multiplies_the_input() {
        let of = |text: &str| coefficient(&Term { negative: false, text: text.into() }, "w_I");
        assert_eq!(of("kI*w_I").as_deref(), Some("kI"));
        assert_eq!(of("w_I").as_deref(), Some("1"));
        assert_eq!(of("k*(1 + T)*w_I").as_deref(), Some("k*(1 + T)"));
        assert_eq!((of("kII*w_I^2"), of("k*w_I*sin(w_I)"), of("V0")), (None, None, None));
    }
}
