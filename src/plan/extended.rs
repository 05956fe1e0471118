//! The augmented model: a campaign with effects as further unknowns.
//!
//! With the effect's column `c` in the model, `u = 1 / |c'|` is the standard uncertainty of its coefficient, `c'` being the residual of `c` after projection on
//! the other columns: a limit on `u` is a limit on the size that a diagnosis detects, and with a second effect in the model on the size that is discriminated from it.

use super::whitened::Term;
use crate::algebra::Expression;
use crate::campaign::{Campaign, Role};
use crate::error::{Fault, Malformed, Result};
use crate::simulate::Regressor;

/// The campaign with these effects as further unknowns, and the names of their coefficients.
///
/// A term is appended to its sensor's model line with its coefficient (`c_a_S*a_S`); a tilt assumed zero or a known parameter is
/// estimated. Errors: an effect of single readings or positions, one that is estimated already.
pub fn extended(campaign: &Campaign, terms: &[Term]) -> Result<(Campaign, Vec<String>)> {
    let mut bench = campaign.bench.clone();
    let mut names: Vec<String> = Vec::new();
    let mut promoted: Vec<usize> = Vec::new();
    for term in terms {
        match (&term.regressor, term.sensor) {
            (Regressor::Tilt(k) | Regressor::Known(k), _) => {
                let parameter = campaign.parameters.get(*k);
                let id = parameter.map_or(String::new(), |p| p.id.clone());
                if parameter.is_none_or(|p| matches!(p.role, Role::Estimated { .. })) {
                    return Err(Malformed::new(
                        Fault::Value,
                        format!("'{id}' is estimated here, so it cannot be a missing effect"),
                    )
                    .expected("a goal, for a limit on its uncertainty")
                    .argument("goal", format!("{id}=U"))
                    .found(format!("'{id}'")));
                }
                promoted.push(*k);
                names.push(id);
            }
            (Regressor::Term(line), Some(sensor)) => {
                let name = coefficient(campaign, &names, &line.to_string());
                if let Some(sensor) = bench.sensors.get_mut(sensor) {
                    sensor.model = sensor.model.plus(&Expression::parse(&name)?.times(line));
                }
                names.push(name);
            }
            _ => {
                return Err(Malformed::new(Fault::Value, "this effect cannot become an unknown of a plan")
                    .expected("a term of the inputs (a_S, w_I^2, sin(2*beta)), tilt:NAME or known:NAME"));
            }
        }
    }
    let fresh = names.iter().filter(|name| campaign.parameter_index(name).is_none()).cloned().collect();
    let longer = campaign.extended(bench, campaign.readings.clone(), &promoted, fresh)?;
    Ok((longer, names))
}

/// An unused name for a term's coefficient: `c_sin_2_beta` for `sin(2*beta)`.
fn coefficient(campaign: &Campaign, taken: &[String], term: &str) -> String {
    let words: Vec<&str> = term.split(|c: char| !c.is_alphanumeric() && c != '_').filter(|w| !w.is_empty()).collect();
    let plain = format!("c_{}", words.join("_"));
    let is_taken = |name: &String| campaign.parameter_index(name).is_some() || taken.contains(name);
    (2..1000)
        .map(|k| format!("{plain}_{k}"))
        .fold(plain.clone(), |name, next| if is_taken(&name) { next } else { name })
}
