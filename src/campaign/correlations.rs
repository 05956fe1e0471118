//! Correlated known parameters (GUM 5.2): two values of one earlier calibration, for example.

use super::{Campaign, Distribution, Parameter, Role};
use crate::error::{Fault, Malformed, Result};

/// A correlation matrix is positive semidefinite to this rounding.
const ROUNDING: f64 = 1e-9;

impl Campaign {
    /// The correlation coefficient of two known parameters.
    pub fn correlation(&self, a: usize, b: usize) -> f64 {
        let [a_id, b_id] = [a, b].map(|k| self.parameter_id(k));
        match a == b {
            true => 1.0,
            false => pair(&self.correlations, a_id, b_id).unwrap_or(0.0),
        }
    }

    /// The triangle `L` of the correlation matrix `L L'` of these known parameters, row by row: deviates that are independent become theirs.
    pub(crate) fn correlation_root(&self, known: &[usize]) -> Vec<Vec<f64>> {
        // the whole matrix was checked when the campaign was made
        root(known.len(), &|i, j| match (known.get(i), known.get(j)) {
            (Some(a), Some(b)) => self.correlation(*a, *b),
            _ => 0.0,
        })
        .unwrap_or_default()
    }
}

fn pair(list: &[(String, String, f64)], a: &str, b: &str) -> Option<f64> {
    let same = |entry: &&(String, String, f64)| (entry.0 == a && entry.1 == b) || (entry.0 == b && entry.1 == a);
    list.iter().find(same).map(|entry| entry.2)
}

/// Cholesky's triangle of a positive semidefinite matrix with ones on its diagonal; `None` where it is none.
fn root(n: usize, element: &dyn Fn(usize, usize) -> f64) -> Option<Vec<Vec<f64>>> {
    let mut rows: Vec<Vec<f64>> = Vec::with_capacity(n);
    for i in 0..n {
        let mut row: Vec<f64> = Vec::with_capacity(n);
        for (j, other) in rows.iter().enumerate() {
            let remainder = element(i, j) - row.iter().zip(other).map(|(a, b)| a * b).sum::<f64>();
            match other.get(j).copied().filter(|pivot| *pivot > 0.0) {
                Some(pivot) => row.push(remainder / pivot),
                None if remainder.abs() <= ROUNDING => row.push(0.0),
                None => return None,
            }
        }
        let remainder = element(i, i) - row.iter().map(|x| x * x).sum::<f64>();
        if remainder < -ROUNDING {
            return None;
        }
        // a remainder of rounding is no further direction
        row.push(if remainder > ROUNDING { remainder.sqrt() } else { 0.0 });
        rows.push(row);
    }
    Some(rows)
}

/// Errors: a name that is not known with an uncertainty, a pair that is stated twice, a coefficient outside -1 to 1, a matrix that is not positive semidefinite,
/// a distribution that is not normal.
pub(super) fn check(parameters: &[Parameter], correlations: &[(String, String, f64)]) -> Result<()> {
    let mut names: Vec<&str> = Vec::new();
    for (k, (a, b, r)) in correlations.iter().enumerate() {
        let path = format!("correlations[{k}]");
        for name in [a, b] {
            let known = parameters.iter().find(|p| p.id == *name).and_then(|p| match p.role {
                Role::Known(known) => Some(known),
                _ => None,
            });
            match known {
                Some(known) if known.u > 0.0 && known.distribution == Distribution::Normal => {}
                Some(known) if known.u > 0.0 => {
                    return Err(Malformed::new(Fault::Value, format!("'{name}' is correlated, and not normal"))
                        .expected("\"distribution\": \"normal\" for correlated inputs")
                        .found(known.distribution.to_string())
                        .at_path(path));
                }
                _ => {
                    return Err(Malformed::new(Fault::UnknownName, format!("'{name}' is not known with an uncertainty"))
                        .expected("the names of two entries of \"known\" with \"u\" above zero, and their correlation coefficient")
                        .found(format!("'{name}'"))
                        .at_path(path));
                }
            }
            if !names.contains(&name.as_str()) {
                names.push(name);
            }
        }
        if a == b || pair(correlations.get(..k).unwrap_or_default(), a, b).is_some() {
            return Err(Malformed::new(Fault::Value, format!("the correlation of '{a}' and '{b}' is stated already"))
                .expected("each pair of two different inputs once")
                .at_path(path));
        }
        if !(-1.0..=1.0).contains(r) {
            return Err(Malformed::new(Fault::Value, format!("the correlation of '{a}' and '{b}' is none"))
                .expected("a number from -1 to 1")
                .found(r.to_string())
                .at_path(path));
        }
    }
    let of = |k: usize| names.get(k).copied().unwrap_or_default();
    let element = |i: usize, j: usize| if i == j { 1.0 } else { pair(correlations, of(i), of(j)).unwrap_or(0.0) };
    match root(names.len(), &element) {
        Some(_) => Ok(()),
        None => {
            Err(Malformed::new(Fault::Value, "the correlation matrix of the known inputs is not positive semidefinite")
                .expected("coefficients that inputs can have together; pairs that are not stated are 0")
                .found(names.join(", "))
                .at_path("correlations"))
        }
    }
}
