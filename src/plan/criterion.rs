//! What is best: criteria in the coordinates of the candidates.

use super::blocks::Blocks;
use super::judge::gradients;
use super::objective::{Combinations, Objective};
use super::pool::Pool;
use super::whitened::single;
use crate::campaign::{Campaign, Kind};
use crate::elements::Elements;
use crate::error::{Fault, Malformed, Result};
use crate::linear::normalise;

/// What the best schedule is best in.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub enum Criterion {
    /// Smallest volume of the confidence ellipsoid of all estimated parameters.
    #[default]
    D,
    /// Smallest sum of squared uncertainties of the angles (of all parameters, each in units of what all candidates give, where none is an angle).
    A,
    /// Smallest largest uncertainty of a predicted reading, over all candidates.
    G,
    /// Smallest mean of the squared uncertainties of all predicted readings.
    I,
    /// Smallest uncertainty of the worst determined combination of angles, with squared coefficients that sum to one (of all parameters, each
    /// in units of what all candidates give, where none is an angle).
    E,
    /// Smallest uncertainty of one parameter or derived quantity.
    C(String),
}

/// The criterion in the coordinates of the pool. Errors: a quantity that does not exist or that the candidates do not determine.
pub(super) fn objective(campaign: &Campaign, pool: &Pool, criterion: &Criterion) -> Result<Objective> {
    let n = campaign.unknowns();
    match criterion {
        Criterion::D if !pool.augmentation.deviations.is_empty() => {
            Ok(Objective::Volume(Combinations::new(pool.independent(n))))
        }
        Criterion::D => Ok(Objective::Determinant),
        Criterion::G => Ok(Objective::Largest(pool.rows.clone())),
        Criterion::A => Ok(Objective::Trace(asked(campaign, pool)?.sum())),
        Criterion::E => Ok(Objective::Eigenvalue(asked(campaign, pool)?)),
        Criterion::I => {
            // each predicted reading with the same weight
            let mut mean = pool.rows.sum();
            let count = (pool.rows.count() * pool.rows.rows()).max(1) as f64;
            mean.iter_mut().for_each(|m| *m /= count);
            Ok(Objective::Trace(mean))
        }
        Criterion::C(id) => {
            let Some(rows) = gradients_of(campaign, id)? else {
                let what = format!("the best set for '{id}' cannot be found: it is not estimated here");
                return Err(no_result(campaign, what, "D, A, G, I, E, or ", id));
            };
            if rows.is_empty() {
                let line = campaign.derived.iter().find(|d| d.id == *id).map(|d| d.line.to_string());
                return Err(Malformed::new(Fault::Value, format!("'{id}' has no derivative at the reference point"))
                    .expected("a quantity that is smooth there, or \"start\" values at which it is")
                    .found(line.unwrap_or_default()));
            }
            let rows: Option<Vec<Vec<f64>>> = rows.iter().map(|c| pool.coordinates(c)).collect();
            let rows = rows.ok_or_else(|| not_determined(&format!("'{id}'")))?;
            let n = pool.blocks.unknowns();
            Ok(match rows.len() {
                1 => Objective::Trace(Combinations::new(rows).sum()),
                many => Objective::Largest(Blocks::from_fn(many, 1, n, |j, _, c| rows.at(j).at(c))),
            })
        }
    }
}

/// The angles; where none is an angle all parameters, each in units of what all candidates give.
fn asked(campaign: &Campaign, pool: &Pool) -> Result<Combinations> {
    let n = campaign.unknowns();
    let is_tilt = |k: &usize| campaign.parameters.get(*k).is_some_and(|p| p.kind == Kind::Tilt);
    let some_tilt = (0..n).any(|k| is_tilt(&k));
    let of = (0..n).filter(|k| !some_tilt || is_tilt(k)).filter_map(|k| pool.coordinates(&single(n, k, 1.0)));
    let rows = of.map(|mut row| {
        if !some_tilt {
            normalise(&mut row);
        }
        row
    });
    let rows: Vec<Vec<f64>> = rows.collect();
    if rows.is_empty() { Err(not_determined("an angle")) } else { Ok(Combinations::new(rows)) }
}

fn not_determined(what: &str) -> Malformed {
    Malformed::new(Fault::Value, format!("even all candidates together do not determine {what}"))
        .expected("candidates that separate it from the other parameters, or a prior")
}

/// Gradients of an estimated parameter, or of a derived quantity: one, or all round where it has no derivative at the reference point. `None` for
/// another name.
pub(super) fn gradients_of(campaign: &Campaign, id: &str) -> Result<Option<Vec<Vec<f64>>>> {
    let n = campaign.unknowns();
    match campaign.parameter_index(id).filter(|k| *k < n) {
        Some(k) => Ok(Some(vec![single(n, k, 1.0)])),
        None => campaign.derived.iter().find(|d| d.id == id).map(|d| Ok(gradients(campaign, d)?.0)).transpose(),
    }
}

/// A name that is no result of the campaign; `or` what else could be meant.
pub(super) fn no_result(campaign: &Campaign, what: String, or: &str, id: &str) -> Malformed {
    let mut names: Vec<&str> = campaign.estimated().iter().map(|p| p.id.as_str()).collect();
    names.extend(campaign.derived.iter().map(|d| d.id.as_str()));
    Malformed::new(Fault::UnknownName, what)
        .expected(format!("{or}one of {}", names.join(", ")))
        .found(format!("'{id}'"))
}
