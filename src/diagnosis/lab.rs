//! What the score needs of a campaign at one point of its parameters.

use super::candidates::{Kept, build};
use super::noise::{self, NoiseFrom, Weighted};
use super::{Candidate, Effect, assumptions, screen};
use crate::campaign::{Campaign, Role};
use crate::design::{self, DesignMatrix, Model};
use crate::error::Result;
use crate::fit::Fit;
use faer::Mat;

/// The rows at one point, weighted, and every candidate.
pub struct At {
    /// The rows.
    pub design: DesignMatrix,
    /// Orthonormal basis of the model's weighted columns.
    pub basis: Mat<f64>,
    /// Weighted residuals.
    pub residual: Vec<f64>,
    /// Weighted columns of the candidates (each scaled).
    pub columns: Mat<f64>,
    /// The candidates.
    pub candidates: Vec<Candidate>,
    /// Is the noise stated?
    pub known: bool,
    /// One over the standard deviation of each row.
    pub weight: Vec<f64>,
    weighted: Weighted,
}

/// The campaign with its constraints held, and the point of its exact fit.
pub fn start(campaign: &Campaign) -> Result<(Campaign, Vec<usize>, Vec<f64>)> {
    let assumed = assumptions::hold(campaign)?;
    let before = super::fit_exactly(&assumed.campaign)?;
    let mut point = before.point.clone();
    point.truncate(before.design.point.len());
    Ok((assumed.campaign, assumed.asked, before.design.point.clone()))
}

/// Everything at one point.
///
/// With a fit of these effects the model's columns are those of the augmented model, its derivatives to the tilts through the effects among them.
pub fn at(
    campaign: &Campaign,
    asked: &[usize],
    catalogue: &[Effect],
    point: &[f64],
    augmented: Option<(&Fit, &[&Candidate])>,
) -> Result<At> {
    let model = Model::new(campaign)?;
    let mut design = design::assemble(campaign, &model, point)?;
    let given = campaign.reference_point();
    let plain = |(_, effects): &(&Fit, &[&Candidate])| !effects.iter().any(|c| assumptions::is_assumption(c));
    let augmented = augmented.filter(plain).filter(|(fit, _)| fit.design.predicted.len() == design.predicted.len());
    if let Some((fit, effects)) = augmented {
        let (rows, columns) = (design.jacobian.nrows(), fit.design.jacobian.ncols());
        for (k, parameter) in campaign.parameters.iter().enumerate().take(design.jacobian.ncols()) {
            if let Some(own) = fit.campaign.parameter_index(&parameter.id).filter(|own| *own < columns) {
                let column = fit.design.jacobian.col_as_slice(own).to_vec();
                design.jacobian.col_as_slice_mut(k).copy_from_slice(column.get(..rows).unwrap_or(&vec![0.0; rows]));
            }
        }
        design.predicted.clone_from(&fit.design.predicted);
        for effect in effects {
            let Some(own) = fit.campaign.parameter_index(&effect.coefficient).filter(|own| *own < columns) else { continue };
            let before = campaign.parameter_index(&effect.coefficient).and_then(|k| given.get(k)).copied();
            let size = fit.design.point.get(own).copied().unwrap_or_default() - before.unwrap_or_default();
            let column = fit.design.jacobian.col_as_slice(own);
            design.predicted.iter_mut().zip(column).for_each(|(predicted, slope)| *predicted -= slope * size);
        }
    }
    for k in campaign.unknowns()..campaign.parameters.len().min(design.jacobian.ncols()) {
        let moved = point.get(k).zip(given.get(k)).map_or(0.0, |(point, given)| point - given);
        if moved != 0.0 && augmented.is_none() {
            let column = design.jacobian.col_as_slice(k);
            design.predicted.iter_mut().zip(column).for_each(|(predicted, slope)| *predicted -= slope * moved);
        }
    }
    let weighted = noise::weigh(campaign, &design, None)?;
    let mut chosen = screen::chosen(campaign);
    let scan = screen::Screen::new(campaign, &design, &weighted, &chosen, &[]);
    chosen.add(scan.strongest(&chosen).into_iter().map(|(member, _)| member));
    chosen.add(screen::exchanged(campaign, &design, &weighted, &super::Settings::default()));
    let rows = weighted.weight.len();
    let mut candidates = build(campaign, catalogue, &model, &design, rows, &chosen, &mut Kept::new())?;
    candidates.extend(assumptions::candidates(campaign, asked, &design)?);
    let columns = weighted.columns(candidates.iter().map(|c| &c.column).collect::<Vec<_>>().into_iter());
    Ok(At {
        basis: weighted.estimate.factor.thin_q().to_owned(),
        residual: weighted.residual.clone(),
        columns,
        candidates,
        known: weighted.from == NoiseFrom::Stated,
        weight: weighted.weight.clone(),
        design,
        weighted,
    })
}

impl At {
    /// Weighted sum of squares of a fit's residuals.
    pub fn squares(&self, residuals: &[f64]) -> f64 {
        self.weighted.squares(residuals)
    }

    /// A column weighted.
    pub fn whiten(&self, column: &[f64]) -> Vec<f64> {
        self.weighted.whiten(column)
    }

    /// The position of each row.
    pub fn positions(&self, campaign: &Campaign) -> Vec<usize> {
        noise::positions(campaign, &self.design, self.weight.len())
    }
}

/// The exact fit with these effects from this point, and its point in the campaign's order.
pub fn exact(campaign: &Campaign, effects: &[&Candidate], from: &[f64]) -> Result<(Fit, Vec<f64>)> {
    let repaired = super::repair::repaired(campaign, effects)?;
    let mut beside = repaired.clone();
    for (parameter, value) in campaign.parameters.iter().zip(from) {
        let own = repaired.parameter_index(&parameter.id).and_then(|k| beside.parameters.get_mut(k));
        if let Some(Role::Estimated { start, .. }) = own.map(|p| &mut p.role) {
            *start = Some(*value);
        }
    }
    let fit = super::fit_exactly(&beside)?;
    let mut point = from.to_vec();
    let given = campaign.reference_point();
    for (k, (value, parameter)) in point.iter_mut().zip(&campaign.parameters).enumerate() {
        let index = repaired.parameter_index(&parameter.id);
        let estimated = index.is_some_and(|k| k < repaired.unknowns());
        let found = index.filter(|_| estimated).and_then(|k| fit.point.get(k));
        *value = found.copied().or_else(|| given.get(k).copied()).unwrap_or(*value);
    }
    Ok((fit, point))
}
