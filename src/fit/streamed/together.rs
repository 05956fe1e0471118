//! The triangles of several sensors, and the priors, in one adjustment with their open scales estimated.
#![allow(
    clippy::indexing_slicing,
    reason = "a fold's triangle is square, with the unknowns' columns first and the observations last; lists over sensors are as long as the parts"
)]

use super::question::{Part, Question};
use crate::elements::Elements;
use crate::error::Result;
use crate::estimate::{Block, Compressed, ScaleHints, Scaled};
use faer::Mat;

/// An adjustment of all sensors at some noise.
pub(super) struct Together {
    pub found: Scaled,
    pub rows: Compressed,
    /// The same beside the known inputs that have an uncertainty, where there are such: what scales and tests come from. Their rows are behind the priors.
    pub extended: Option<(Scaled, Compressed)>,
    /// The sensor of each block of the rows; the priors are behind them.
    pub order: Vec<usize>,
    /// Variance factor of each sensor, 1 where it is not open.
    pub scale: Vec<f64>,
    /// Its redundancy.
    pub redundancy: Vec<f64>,
}

/// Adjust `parts`, one for each sensor that is read; `open` says whose scale is estimated.
pub(super) fn together(question: &Question, parts: &[Option<Part>], open: &[bool], point: &[f64]) -> Result<Together> {
    let of = |is_open: bool| (0..parts.len()).filter(move |s| parts[*s].is_some() && open[*s] == is_open);
    let order: Vec<usize> = of(true).chain(of(false)).collect();
    let n = question.unknowns;
    let blocks = order.iter().filter_map(|s| Some(parts[*s].as_ref()?.block(n))).chain([question.prior_block(point)]);
    let rows = Compressed::of(blocks.collect(), n, of(true).count());
    let white = |s: usize| parts[s].as_ref().map_or(1.0, |part| part.white);
    let least: Vec<f64> = of(true).map(|s| (question.floor.at(s) / white(s)).sqrt()).collect();
    let hints = ScaleHints { start: &[], least: &least, given: &[] };
    let settings = &question.settings.adjust;
    let extended = match question.carried.is_empty() {
        true => None,
        false => {
            let own = Compressed::of(question.extended_blocks(&rows.blocks), n + question.carried.len(), rows.groups);
            Some((own.adjust(&hints, settings)?, own))
        }
    };
    let told = extended.as_ref().map(|(own, _)| own);
    let given: Vec<Option<f64>> = told.iter().flat_map(|own| &own.scale).map(|scale| Some(*scale)).collect();
    let found = rows.adjust(&ScaleHints { given: &given, ..hints }, settings)?;
    let told = told.unwrap_or(&found);
    let (mut scale, mut redundancy) = (vec![1.0; parts.len()], vec![0.0; parts.len()]);
    for (k, s) in order.iter().enumerate() {
        scale[*s] = told.scale.get(k).map_or(1.0, |scale| scale * scale);
        redundancy[*s] = told.redundancy[k];
    }
    Ok(Together { found, rows, extended, order, scale, redundancy })
}

impl Together {
    /// `chi^2` of the residuals.
    pub(super) fn sum_of_squares(&self) -> f64 {
        self.extended.as_ref().map_or(self.found.sum_of_squares, |(own, _)| own.sum_of_squares)
    }
}

impl Part {
    /// The rows of the triangle, observations at the point of the design.
    pub(super) fn block(&self, unknowns: usize) -> Block {
        let triangle = self.fold.triangle();
        let last = triangle.ncols() - 1;
        let mut observed: Vec<f64> = (0..=last).map(|i| triangle[(i, last)]).collect();
        let dof = self.rows.saturating_sub(unknowns as u64);
        let squares = observed[unknowns..].iter().map(|rho| rho * rho).sum();
        let rows = triangle.subcols(0, last).to_owned();
        // they are taken about another
        let away: Vec<f64> = self.fold.about().iter().map(|a| -a).collect();
        crate::linear::subtract(&mut observed, &rows, &away);
        Block {
            rows,
            observed,
            size: crate::number::index(self.rows),
            own: (dof > 0).then(|| (squares, crate::number::index(dof))),
            magnitude: 0.0,
            log_determinant: self.log_determinant,
        }
    }
}

impl Question {
    /// Blocks beside the known inputs, the last with what is stated of these.
    pub(super) fn extended_blocks(&self, blocks: &[Block]) -> Vec<Block> {
        let (n, k) = (self.unknowns, self.carried.len());
        let mut all: Vec<Block> =
            blocks.iter().map(|own| Block { rows: self.extended(&own.rows), ..own.clone() }).collect();
        if let Some(last) = all.last_mut() {
            let before = last.rows.nrows();
            last.rows.resize_with(before + k, n + k, |i, j| f64::from(u8::from(i - before + n == j)));
            last.observed.resize(before + k, 0.0);
            last.size += k;
        }
        all
    }

    /// The priors as rows.
    pub(super) fn prior_block(&self, point: &[f64]) -> Block {
        let (count, columns) = (self.priors.len(), self.unknowns + self.carried.len());
        let row = |i: usize, j: usize| if self.priors[i].0 == j { 1.0 / self.priors[i].2 } else { 0.0 };
        Block {
            rows: Mat::from_fn(count, columns, row),
            observed: self.priors.iter().map(|(k, value, u)| (value - point.at(*k)) / u).collect(),
            size: count,
            own: None,
            magnitude: 0.0,
            log_determinant: 0.0,
        }
    }
}
