//! A campaign with effects as further unknowns: what is to be found, and what it must not be taken for.
//!
//! With the effect's column `c` in the model, `u = 1 / |c'|` is the standard uncertainty of its coefficient, `c'` being what the other columns leave
//! of `c`: a limit on `u` is a limit on the size that a diagnosis finds, and beside a second effect on the size that is not taken for that one.

use super::whitened::Term;
use crate::algebra::Expression;
use crate::bench::Bench;
use crate::campaign::{Asked, Campaign, Deviating, Given, Readings, Request, Role, Scatter};
use crate::error::{Fault, Malformed, Result};
use crate::simulate::Regressor;

/// The campaign with these effects estimated beside its unknowns, and the names of their coefficients.
///
/// A term is appended to its sensor's model line with a coefficient of its own (`c_a_S*a_S`); a tilt assumed zero or a known parameter is
/// estimated. Errors: an effect of single readings or positions, one that is estimated already.
pub fn extended(campaign: &Campaign, terms: &[Term]) -> Result<(Campaign, Vec<String>)> {
    let mut bench = campaign.bench.clone();
    let mut names: Vec<String> = Vec::new();
    let mut promoted: Vec<usize> = Vec::new();
    for term in terms {
        match (&term.regressor, term.sensor) {
            (Regressor::Tilt(k) | Regressor::Known(k), _) => {
                let parameter = campaign.parameters.get(*k);
                let id = parameter.map_or(String::new(), |own| own.id.clone());
                if parameter.is_none_or(|own| matches!(own.role, Role::Estimated { .. })) {
                    return Err(Malformed::new(
                        Fault::Value,
                        format!("'{id}' is estimated here, so it is no effect that may be missing"),
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
                if let Some(own) = bench.sensors.get_mut(sensor) {
                    own.model = own.model.plus(&Expression::parse(&name)?.times(line));
                }
                names.push(name);
            }
            _ => {
                return Err(Malformed::new(Fault::Value, "this effect cannot become an unknown of a plan")
                    .expected("a term of the inputs (a_S, w_I^2, sin(2*beta)), tilt:NAME or known:NAME"));
            }
        }
    }
    let longer = with_unknowns(campaign, bench, campaign.readings.clone(), &promoted, &names)?;
    Ok((longer, names))
}

/// The campaign with another bench and other readings, in which some parameters that are not estimated, and some new ones, are.
pub(crate) fn with_unknowns(
    campaign: &Campaign,
    bench: Bench,
    readings: Readings,
    promoted: &[usize],
    names: &[String],
) -> Result<Campaign> {
    let mut request = Request::default();
    for (k, parameter) in campaign.parameters.iter().enumerate() {
        let unit = (!parameter.unit.is_empty()).then(|| parameter.unit.clone());
        match &parameter.role {
            Role::Estimated { start, prior } => {
                request.estimate.push((parameter.id.clone(), Asked { start: *start, prior: *prior, unit }));
            }
            Role::Known(known) if !promoted.contains(&k) => {
                request.known.push((parameter.id.clone(), Given { known: *known, unit }));
            }
            _ => {}
        }
    }
    for parameter in promoted.iter().filter_map(|k| campaign.parameters.get(*k)) {
        let start = matches!(parameter.role, Role::Known(_)).then(|| parameter.reference());
        let unit = (!parameter.unit.is_empty()).then(|| parameter.unit.clone());
        request.estimate.push((parameter.id.clone(), Asked { start, prior: None, unit }));
    }
    let fresh = names.iter().filter(|name| campaign.parameter_index(name).is_none());
    request.estimate.extend(fresh.map(|name| (name.clone(), Asked::default())));
    let known = |name: &String| request.known.iter().any(|(id, _)| id == name);
    let stated = campaign.correlations.iter().filter(|(a, b, _)| known(a) && known(b));
    request.correlations = stated.cloned().collect();
    let mut longer = Campaign::new(bench, request, readings)?;
    longer.constraints = campaign.constraints.clone();
    longer.derived = campaign.derived.clone();
    longer.identity = campaign.identity.clone();
    for line in &campaign.scatter {
        let of = match &line.of {
            // the longer campaign counts its parameters anew
            Deviating::Parameter(k) => match longer.parameter_index(campaign.parameter_id(*k)) {
                Some(k) => Deviating::Parameter(k),
                None => continue,
            },
            other => other.clone(),
        };
        longer.add_scatter(Scatter { of, ..line.clone() })?;
    }
    Ok(longer)
}

/// A name for a term's coefficient that nothing has yet: `c_sin_2_beta` for `sin(2*beta)`.
fn coefficient(campaign: &Campaign, taken: &[String], term: &str) -> String {
    let words: Vec<&str> = term.split(|c: char| !c.is_alphanumeric() && c != '_').filter(|w| !w.is_empty()).collect();
    let plain = format!("c_{}", words.join("_"));
    let is_taken = |name: &String| campaign.parameter_index(name).is_some() || taken.contains(name);
    (2..1000)
        .map(|k| format!("{plain}_{k}"))
        .fold(plain.clone(), |name, next| if is_taken(&name) { next } else { name })
}
