//! Every source of scatter with its part of the covariance, and what it costs to have estimated the noise: derivatives of the restricted likelihood of the last
//! pass by the logarithms of every variance and correlation time (`estimate/scatter/restricted.rs`).
//!
//! ```text
//! Phi = sum_k dPhi/dln(v_k)     v: variances of white noise, deviations, priors
//! ```
#![allow(
    clippy::indexing_slicing,
    reason = "every list here has one entry for each sensor; places of parameters are those that the model of the noise was made with"
)]

use super::noise::Found;
use super::octaves::Noise;
use super::question::Question;
use super::together::Together;
use crate::campaign::Campaign;
use crate::error::{Fault, Malformed, Result};
use crate::estimate::{Likelihood, LineState, NoiseModel, NoisePart, PartNoise, Slot};
use crate::fit::noise::{ScatterSources, VarianceSource};
use crate::uncertainty::Evaluation;
use faer::Mat;

/// Where a sensor's parameters stand: variance factor of its white noise, variance of its deviation, correlation time.
type Places = [Option<usize>; 3];

/// The likelihood at what was found, with its derivatives by all that the noise has.
pub(super) struct Noised {
    likelihood: Likelihood,
    model: NoiseModel,
    places: Vec<Places>,
    directions: Mat<f64>,
}

impl Noised {
    /// `parts` are the sums of the sensors that are read and of the priors, in `directions`; `scale` multiplies the white noise that a sensor without a deviation
    /// was folded with.
    ///
    /// Errors: sums in which the directions are not independent.
    pub(super) fn new(
        found: &Found,
        scale: &[f64],
        read: &[usize],
        parts: &[NoisePart],
        directions: Mat<f64>,
    ) -> Result<Self> {
        let mut model = NoiseModel { parts: Vec::new(), range: Vec::new(), columns: directions.ncols() };
        let (mut at, mut places) = (Vec::new(), vec![Places::default(); scale.len()]);
        for s in read {
            let Noise { white, deviation, tau } = found.noise[*s];
            let values = match deviation > 0.0 {
                true => vec![white * white, deviation * deviation, tau],
                false => vec![scale[*s]],
            };
            for (place, value) in places[*s].iter_mut().zip(values) {
                *place = Some(at.len());
                at.push(value.ln());
            }
            let slot = |k: usize| places[*s][k].map(Slot::Free);
            let white = slot(0).unwrap_or(Slot::Stated(1.0));
            model.parts.push(PartNoise { white, deviation: slot(1).zip(slot(2)) });
        }
        model.parts.push(PartNoise { white: Slot::Stated(1.0), deviation: None });
        model.range = vec![(f64::NEG_INFINITY, f64::INFINITY); at.len()];
        let likelihood = model.likelihood(&at, parts).ok_or_else(|| {
            Malformed::new(Fault::Value, "the rows of the record do not separate the unknowns")
                .expected("unknowns that the readings separate, or fewer of them in \"estimate\"")
        })?;
        Ok(Noised { likelihood, model, places, directions })
    }

    /// A matrix in the directions, in the unknowns.
    fn back(&self, own: &Mat<f64>) -> Mat<f64> {
        &self.directions * own * self.directions.transpose()
    }

    /// The derivative of the covariance by the logarithm of a sensor's parameter.
    fn slope(&self, s: usize, which: usize) -> Option<Mat<f64>> {
        let place = self.places[s][which]?;
        Some(self.back(&self.likelihood.slope(place)))
    }

    /// Every source of scatter; `rows` are those of each sensor, `told` what the noise was estimated beside.
    pub(super) fn sources(
        &self,
        told: Option<&Noised>,
        campaign: &Campaign,
        question: &Question,
        found: &Found,
        solved: &Together,
        rows: &[u64],
    ) -> ScatterSources {
        let n = question.unknowns;
        // what was estimated, by its place among the parameters
        let pairs = found.free.iter().flatten().zip(self.places.iter().flatten());
        let among: Vec<usize> = pairs.filter_map(|(is_free, place)| place.filter(|_| *is_free)).collect();
        let told = told.unwrap_or(self);
        let (covariances, correction) = told.likelihood.costs(&told.model, &among);
        let spread = Mat::from_fn(among.len(), among.len(), |a, b| covariances[(among[a], among[b])]);
        let component = |s: usize, which: usize| {
            let place = self.places[s][which]?;
            among.iter().position(|own| *own == place)
        };
        let dof = |component: Option<usize>, stated: f64| component.map_or(stated, |c| 2.0 / spread[(c, c)]);
        let (mut sources, mut over, mut leans) = (Vec::new(), Vec::new(), Vec::new());
        let mut determined = true;
        for (s, own) in question.sensors.iter().enumerate().filter(|(s, _)| question.is_read(*s)) {
            let size = found.noise[s];
            let levels = crate::number::index(rows[s]);
            let white = component(s, 0);
            determined &= white.is_none() || solved.redundancy[s] > 0.0;
            let name = format!("readings of {}", campaign.sensor_id(s));
            let share = |which: usize| self.slope(s, which).unwrap_or_else(|| Mat::zeros(n, n));
            let (variance, state, part) = match (found.white_at_zero[s], white) {
                (true, _) => (0.0, LineState::AtZero, Mat::zeros(n, n)),
                (false, Some(_)) => (size.white * size.white * solved.scale[s], LineState::Estimated, share(0)),
                (false, None) => (1.0, LineState::Stated, share(0)),
            };
            sources.push(VarianceSource {
                evaluation: Evaluation::TypeA,
                estimated: state != LineState::Stated,
                dof: dof(white, f64::INFINITY),
                variance,
                state,
                component: white,
                sensor: Some(s),
                ..VarianceSource::stated(name, part, levels)
            });
            let Some((k, line)) = own.line.and_then(|(k, _)| Some((k, campaign.scatter.get(k)?))) else { continue };
            let own = VarianceSource::line(campaign, k, line, share(1), levels);
            let stated_tau = line.over.as_ref().and_then(|over| over.tau);
            let tau = component(s, 2);
            let u_tau = tau.map(|k| spread[(k, k)].sqrt() * size.tau).filter(|u| u.is_finite());
            over.push(VarianceSource {
                variance: size.deviation * size.deviation,
                state: match (found.at_zero[s], own.estimated) {
                    (true, _) => LineState::AtZero,
                    (false, false) => LineState::Stated,
                    (false, true) => LineState::Estimated,
                },
                tau: (!found.at_zero[s] || stated_tau.is_some()).then_some((stated_tau.unwrap_or(size.tau), u_tau)),
                dof: dof(component(s, 1), own.dof),
                component: component(s, 1),
                ..own
            });
            leans.extend(tau.zip(self.slope(s, 2)));
        }
        let c = &solved.found.unknowns.cofactor;
        if !question.priors.is_empty() {
            let share =
                |i: usize, j: usize| question.priors.iter().map(|(k, _, u)| c[(i, *k)] * c[(*k, j)] / (u * u)).sum();
            let (share, count) = (Mat::from_fn(n, n, share), question.priors.len());
            sources.push(VarianceSource::stated("priors".into(), share, count));
        }
        sources.extend(over);
        ScatterSources::jointly(
            sources,
            c,
            (spread, told.back(&correction).submatrix(0, 0, n, n).to_owned()),
            leans,
            determined,
        )
    }
}
