//! By how much an assumption (a prior, an equation) is missed, once it is found wrong.

use super::{Finding, Regressor};
use crate::campaign::{Campaign, Constraint, Role};
use crate::elements::Elements;
use crate::fit::Fit;

/// By how much a prior or an equation misses, with its standard uncertainty: in the parameter's unit (radians for tilts).
pub(super) fn missed(campaign: &Campaign, after: &Fit, finding: &mut Finding) {
    let at = |j: usize| after.point.at(j);
    let unit = |j: usize| campaign.parameters.get(j).map_or(String::new(), |p| p.unit.clone());
    let n = after.covariance.nrows();
    let along = |terms: &[(usize, f64)]| {
        let inside = || terms.iter().filter(|(j, _)| *j < n);
        inside().map(|(j, a)| inside().map(|(k, b)| a * b * after.covariance[(*j, *k)]).sum::<f64>()).sum::<f64>()
    };
    match finding.effect.kind {
        Regressor::Prior(k) => {
            let Some(Role::Estimated { prior: Some(prior), .. }) = campaign.parameters.get(k).map(|p| &p.role) else {
                return;
            };
            finding.value = Some(at(k) - prior.value);
            finding.u = Some((along(&[(k, 1.0)]) + prior.u * prior.u).sqrt());
            finding.unit = unit(k);
        }
        Regressor::Constraint(k) => {
            let Some(Constraint::Linear { terms, lower, .. }) = campaign.constraints.get(k) else { return };
            finding.value = Some(terms.iter().map(|(j, c)| c * at(*j)).sum::<f64>() - lower);
            finding.u = Some(along(terms).max(0.0).sqrt());
            finding.unit = terms.first().map_or(String::new(), |(j, _)| unit(*j));
        }
        _ => {}
    }
}
