//! What the unknowns are, whatever the noise correlated in time is: the likelihood of its correlation times and ratios of variances, instead of its top alone.
//!
//! ```text
//! p(x | y) = sum over nodes of  L(rho, tau) p(x | rho, tau, y),      L the restricted likelihood, the common variance integrated out where all of it is estimated
//! ```
//!
//! Where the readings hardly tell a correlation time, first-order theory of its estimate is wrong: one that is as long as the record leaves an offset that has almost no
//! degrees of freedom, or one that has all of them. The sum over a grid, even in logarithms over what the times of the readings can show, has neither (G. E. P. Box,
//! G. C. Tiao, Bayesian Inference in Statistical Analysis, 1973, chapters 2 and 5).
#![allow(clippy::indexing_slicing, reason = "nodes, noises and parts have one entry for each part of the model")]

use super::chain::{Part, TimeNoise};
use super::restricted::{NoiseModel, PartNoise, Slot, Top};
use super::time::spaced;
use crate::error::Result;
use faer::{Mat, Scale};

/// Points of the grid in each direction.
const POINTS: usize = 15;
/// How far it goes about the top, in standard uncertainties.
const REACH: f64 = 6.0;
/// Ratios of variances of the deviation and of the white noise that are looked at, where the likelihood has no width.
const RATIOS: (f64, f64) = (1e-3, 1e4);
/// Combinations of several sensors' noises.
const COMBINED: usize = 500;

/// A sum of distributions of the unknowns.
#[derive(Debug, Clone)]
pub struct Mixture {
    /// Each with its weight; their sum is 1.
    pub nodes: Vec<Node>,
    /// Degrees of freedom of each Student distribution.
    pub dof: f64,
}

/// The unknowns at some noise.
#[derive(Debug, Clone)]
pub struct Node {
    /// Its probability.
    pub weight: f64,
    /// How far the solution is from the one at the top of the likelihood.
    pub shift: Vec<f64>,
    /// Covariance of the unknowns.
    pub covariance: Mat<f64>,
}

impl Mixture {
    /// About the top of the likelihood; `natural` is the variance of each part's relative noise, `directions` how the unknowns follow the parts' columns, `look`
    /// brings the parts that are asked for at some noises.
    ///
    /// Errors: those of `look`.
    pub fn about(
        model: &NoiseModel,
        top: &Top,
        natural: &[f64],
        directions: &Mat<f64>,
        look: &mut dyn FnMut(&[Vec<TimeNoise>]) -> Result<Vec<Vec<Part>>>,
    ) -> Result<Self> {
        let noises: Vec<Vec<TimeNoise>> =
            (0..model.parts.len()).map(|s| model.parts[s].grid(model, top, natural[s])).collect();
        let parts = look(&noises)?;
        let open = |slot: Slot| matches!(slot, Slot::Free(_));
        let common = model.parts.iter().all(|own| open(own.white) && own.deviation.is_none_or(|(size, _)| open(size)));
        let rows: f64 = parts.iter().filter_map(|list| list.first()).map(|part| part.rows).sum();
        let dof = rows - model.columns as f64;
        let mut nodes: Vec<(f64, Node)> = Vec::new();
        let node = |own: &[TimeNoise], parts: Vec<Part>| {
            let known = own.iter().map(|noise| PartNoise::known(*noise)).collect();
            let here = NoiseModel { parts: known, range: Vec::new(), columns: model.columns };
            let found = here.likelihood(&[], &parts)?;
            let (scale, likelihood) = match common {
                true => (found.squares / dof, -0.5 * (found.deviance - found.squares + dof * found.squares.ln())),
                false => (1.0, -0.5 * found.deviance),
            };
            let shift = Mat::from_fn(model.columns, 1, |j, _| found.solution[j] - top.found.solution[j]);
            let shift = directions * shift;
            let covariance = directions * found.covariance * directions.transpose() * Scale(scale);
            Some((likelihood, Node { weight: 0.0, shift: shift.col_as_slice(0).to_vec(), covariance }))
        };
        // a part's own grid, the others at the top
        let middle = |s: usize| noises[s].len() - 1;
        let at_top = |s: usize| (noises[s][middle(s)], parts[s][middle(s)].clone());
        let several: Vec<usize> = (0..parts.len()).filter(|s| noises[*s].len() > 1).collect();
        let combine = |s: usize, k: usize| -> (Vec<TimeNoise>, Vec<Part>) {
            let of = |r: usize| if r == s { (noises[r][k], parts[r][k].clone()) } else { at_top(r) };
            (0..parts.len()).map(of).unzip()
        };
        let mut alone: Vec<Vec<f64>> = Vec::new();
        for s in &several {
            let mut list = Vec::with_capacity(middle(*s));
            for k in 0..middle(*s) {
                let (own, parts) = combine(*s, k);
                let found = node(&own, parts);
                list.push(found.as_ref().map_or(f64::NEG_INFINITY, |(likelihood, _)| *likelihood));
                nodes.extend(found);
            }
            alone.push(list);
        }
        if several.len() > 1 {
            // places in each part's distribution by sequences that share no step
            let ends: Vec<Vec<f64>> = alone.iter().map(|list| cumulated(list)).collect();
            let mut combined = Vec::with_capacity(COMBINED);
            for j in 0..COMBINED {
                let place = |p: usize| (0.5 + j as f64 * (p as f64 + 2.0).sqrt() + j as f64 / (p as f64 + 1.7)).fract();
                let chosen: Vec<usize> = ends
                    .iter()
                    .enumerate()
                    .map(|(p, ends)| ends.partition_point(|end| *end < place(p)).min(ends.len() - 1))
                    .collect();
                combined.push(chosen);
            }
            nodes.clear();
            for chosen in combined {
                let pick = |s: usize| match several.iter().position(|own| *own == s) {
                    Some(p) => (noises[s][chosen[p]], parts[s][chosen[p]].clone()),
                    None => at_top(s),
                };
                let (noise, there): (Vec<_>, Vec<_>) = (0..parts.len()).map(pick).unzip();
                let given: f64 = chosen.iter().zip(&alone).map(|(k, list)| list[*k]).sum();
                nodes.extend(node(&noise, there).map(|(likelihood, node)| (likelihood - given, node)));
            }
        }
        let most = nodes.iter().map(|(weight, _)| *weight).fold(f64::NEG_INFINITY, f64::max);
        let sum: f64 = nodes.iter().map(|(weight, _)| (weight - most).exp()).sum();
        let nodes = nodes.into_iter().map(|(weight, node)| Node { weight: (weight - most).exp() / sum, ..node });
        Ok(Mixture {
            nodes: nodes.filter(|node| node.weight > 1e-12).collect(),
            dof: if common { dof } else { f64::INFINITY },
        })
    }

    /// Weight, shift and standard deviation of a linear function of the unknowns.
    pub fn along(&self, along: &[f64]) -> Vec<(f64, f64, f64)> {
        let one = |node: &Node| {
            let shift: f64 = node.shift.iter().zip(along).map(|(x, c)| x * c).sum();
            (node.weight, shift, crate::linear::form(&node.covariance, along).max(0.0).sqrt())
        };
        self.nodes.iter().map(one).collect()
    }

    /// Mean covariance of the unknowns.
    pub fn covariance(&self) -> Mat<f64> {
        let size = self.nodes.first().map_or(0, |node| node.covariance.nrows());
        let mut sum = Mat::zeros(size, size);
        for node in &self.nodes {
            sum += &node.covariance * Scale(node.weight);
        }
        sum
    }
}

/// Ends of the steps of a distribution given by logarithms of its weights.
fn cumulated(logarithms: &[f64]) -> Vec<f64> {
    let most = logarithms.iter().fold(f64::NEG_INFINITY, |most, x| most.max(*x));
    let all: f64 = logarithms.iter().map(|x| (x - most).exp()).sum();
    let mut sum = 0.0;
    logarithms
        .iter()
        .map(|x| {
            sum += (x - most).exp() / all;
            sum
        })
        .collect()
}

impl PartNoise {
    /// Noises over which the likelihood is summed, that at the top last.
    fn grid(&self, model: &NoiseModel, top: &Top, natural: f64) -> Vec<TimeNoise> {
        let own = self.at(&top.at);
        let Some((size, Slot::Free(time))) = self.deviation else { return vec![own] };
        let spread = super::cost::spread(&top.found.bend, &top.inside());
        let width = |weights: &[(usize, f64)]| -> Option<f64> {
            let with = |(k, a): &(usize, f64)| weights.iter().map(|(h, b)| a * b * spread[(*k, *h)]).sum::<f64>();
            let square: f64 = weights.iter().map(with).sum();
            Some(REACH * square.sqrt()).filter(|width| *width > 0.0 && width.is_finite())
        };
        let about = |centre: f64, width: Option<f64>, (low, high): (f64, f64)| match width {
            Some(width) => ((centre - width).max(low), (centre + width).min(high)),
            None => (low, high),
        };
        let times = about(own.tau.ln(), width(&[(time, 1.0)]), model.range[time]);
        // the size of the deviation beside white noise
        let unit = own.white * natural;
        let ratio = (own.deviation / unit).max(f64::MIN_POSITIVE).ln();
        let limits = (RATIOS.0.ln(), RATIOS.1.ln());
        let ratios: Vec<f64> = match (self.white, size) {
            (Slot::Stated(_), Slot::Stated(_)) => vec![ratio],
            (Slot::Free(w), Slot::Free(q)) => {
                spaced(about(ratio, width(&[(q, 1.0), (w, -1.0)]), limits), POINTS).collect()
            }
            (_, Slot::Free(k)) | (Slot::Free(k), _) => {
                spaced(about(ratio, width(&[(k, 1.0)]), limits), POINTS).collect()
            }
        };
        let mut grid = Vec::with_capacity(POINTS * ratios.len() + 1);
        for tau in spaced(times, POINTS) {
            for ratio in &ratios {
                let part = ratio.exp() * natural;
                let (white, deviation) = match (self.white, size) {
                    (_, Slot::Stated(q)) => (q / part, q),
                    (Slot::Stated(white), _) => (white, white * part),
                    // as much as at the top, both together
                    _ => {
                        let white = (own.white * natural + own.deviation) / (natural + part);
                        (white, white * part)
                    }
                };
                let white = if let Slot::Stated(white) = self.white { white } else { white };
                grid.push(TimeNoise { white, deviation, tau: tau.exp() });
            }
        }
        grid.push(own);
        grid
    }
}
