//! What scatters in the readings, and how each estimated parameter follows it: the Type A side of every budget.

use super::system::Remounting;
use crate::campaign::Campaign;
use crate::design::DesignMatrix;
use crate::estimate::{Component, Components, Estimate, Group, ScaleUncertainty, System};
use crate::uncertainty::monte_carlo::Scatter;
use crate::uncertainty::{Contribution, Evaluation};
use faer::Mat;

/// One independent source of scatter with its variance component.
#[derive(Debug, Clone)]
pub struct Source {
    /// `readings of V`, `remounting of V`, `priors`.
    pub name: String,
    /// Type A where its variance comes from readings (or is that of single readings), B for priors and stated offsets.
    pub evaluation: Evaluation,
    /// Variance component; multiplies the squares of the rows' standard deviations.
    pub variance: f64,
    /// Is the variance estimated from these readings?
    pub estimated: bool,
    /// Degrees of freedom of the variance; infinite where it is known.
    pub dof: f64,
    /// Rows and the standard deviation that a unit component gives each.
    pub rows: Vec<(usize, f64)>,
    /// The offset that each row shares; empty where rows are independent.
    pub offset: Vec<usize>,
}

/// All sources, and how the unknowns follow each reading.
#[derive(Debug, Clone)]
pub struct Noise {
    /// Sources with their variances.
    pub sources: Vec<Source>,
    /// `d x / d y`, unknowns x rows.
    pub sensitivities: Mat<f64>,
    /// Covariance of the unknowns from all sources.
    pub covariance: Mat<f64>,
    /// Covariance of the estimated variances, where they were estimated together.
    spread: Option<Mat<f64>>,
    /// Small-sample addition to the covariance, contained in it.
    correction: Option<Mat<f64>>,
    /// Is every variance determined?
    pub determined: bool,
}

impl Source {
    /// `s' V s` for a component of one.
    fn form(&self, weights: &[f64]) -> f64 {
        let part = |(row, u): &(usize, f64)| weights.get(*row).copied().unwrap_or_default() * u;
        if self.offset.is_empty() {
            return self.rows.iter().map(|row| part(row).powi(2)).sum();
        }
        let mut sums = vec![0.0; self.offset.iter().max().map_or(0, |most| most + 1)];
        for (row, offset) in self.rows.iter().zip(&self.offset) {
            if let Some(sum) = sums.get_mut(*offset) {
                *sum += part(row);
            }
        }
        sums.iter().map(|sum| sum * sum).sum()
    }
}

/// Sources of a system: each sensor's readings, then priors, then offsets that remounting adds.
pub(super) fn sources(
    campaign: &Campaign,
    design: &DesignMatrix,
    system: &System,
    remounting: Option<&Remounting>,
) -> Vec<Source> {
    let sensors = campaign.bench.sensors.len();
    let mut sources: Vec<Source> = Vec::new();
    for s in 0..=sensors {
        let rows: Vec<(usize, f64)> = (0..system.observed.len())
            .filter(|i| design.rows.get(*i).map_or(sensors, |origin| origin.sensor) == s)
            .filter_map(|i| system.u.get(i).map(|u| (i, *u)))
            .collect();
        let Some(group) = rows.first().and_then(|(i, _)| system.group.get(*i)) else { continue };
        let name = campaign.bench.sensors.get(s).map_or("priors".to_string(), |s| format!("readings of {}", s.id));
        sources.push(Source {
            name,
            evaluation: if s == sensors { Evaluation::TypeB } else { Evaluation::TypeA },
            variance: 1.0,
            estimated: matches!(group, Group::Estimated(_)),
            dof: f64::INFINITY,
            rows,
            offset: Vec::new(),
        });
    }
    for shared in remounting.map(|r| r.shared.as_slice()).unwrap_or_default() {
        sources.push(Source {
            name: format!("remounting of {}", shared.sensor),
            evaluation: if shared.variance.is_some() { Evaluation::TypeB } else { Evaluation::TypeA },
            variance: shared.variance.unwrap_or(0.0),
            estimated: shared.variance.is_none(),
            dof: f64::INFINITY,
            rows: shared.rows.iter().map(|row| (*row, 1.0)).collect(),
            offset: shared.offset.clone(),
        });
    }
    sources
}

/// The same as variance components.
pub(super) fn components(sources: &[Source]) -> Vec<Component> {
    sources
        .iter()
        .map(|source| Component {
            rows: source.rows.clone(),
            offset: source.offset.clone(),
            known: (!source.estimated).then_some(source.variance),
        })
        .collect()
}

impl Noise {
    /// Independent readings: the variances are the squares of the estimate's group scales.
    pub(super) fn independent(mut sources: Vec<Source>, system: &System, estimate: &Estimate) -> Self {
        for source in &mut sources {
            let group = source.rows.first().and_then(|(row, _)| system.group.get(*row));
            if let Some(Group::Estimated(g)) = group {
                source.variance = estimate.group_scale.get(*g).copied().flatten().unwrap_or(1.0).powi(2);
                source.dof = estimate.group_redundancy.get(*g).copied().unwrap_or_default();
            }
        }
        let mut noise = Noise {
            sensitivities: estimate.factor.sensitivities(),
            covariance: estimate.covariance.clone(),
            spread: None,
            correction: None,
            determined: estimate.group_scale.iter().all(Option::is_some),
            sources,
        };
        let several = estimate.scale_uncertainty(system).filter(|_| noise.determined);
        if let Some(ScaleUncertainty { relative, correction }) = several {
            // which group each source's variance belongs to
            let group = |source: &Source| match source.rows.first().and_then(|(row, _)| system.group.get(*row)) {
                Some(Group::Estimated(g)) if source.estimated => Some(*g),
                _ => None,
            };
            let count = noise.sources.len();
            noise.spread = Some(Mat::from_fn(count, count, |a, b| {
                let (a, b) = (&noise.sources[a], &noise.sources[b]);
                let pair = group(a).zip(group(b));
                pair.map_or(0.0, |(g, h)| relative[(g, h)] * a.variance * b.variance)
            }));
            noise.covariance += &correction;
            noise.correction = Some(correction);
        }
        noise
    }

    /// Variances of a robust estimate: `variance` for every source that was estimated, the plain estimate's sensitivities.
    pub(super) fn robust(mut sources: Vec<Source>, plain: &Estimate, factors: &[f64], covariance: Mat<f64>) -> Self {
        for (source, factor) in sources.iter_mut().zip(factors) {
            source.variance = *factor;
            if source.evaluation == Evaluation::TypeA {
                source.dof = plain.dof as f64;
            }
        }
        Noise {
            sources,
            sensitivities: plain.factor.sensitivities(),
            covariance,
            spread: None,
            correction: None,
            determined: plain.dof > 0,
        }
    }

    /// Estimated or stated variance components.
    pub(super) fn from_components(mut sources: Vec<Source>, adjusted: &Components) -> Self {
        for (k, (source, variance)) in sources.iter_mut().zip(&adjusted.variance).enumerate() {
            source.variance = *variance;
            let spread = adjusted.spread[(k, k)];
            if source.estimated {
                source.dof = if spread > 0.0 { 2.0 * variance * variance / spread } else { 0.0 };
            }
        }
        let estimate = &adjusted.estimate;
        let estimated = sources.iter().any(|s| s.estimated);
        Noise {
            sources,
            sensitivities: adjusted.sensitivities.clone(),
            covariance: &estimate.covariance + &adjusted.correction,
            spread: estimated.then(|| adjusted.spread.clone()),
            correction: estimated.then(|| adjusted.correction.clone()),
            determined: !estimated || estimate.dof > 0,
        }
    }

    /// Every source's covariance of the unknowns, factored, with its degrees of freedom.
    pub(super) fn scatter(&self) -> Vec<Scatter> {
        let (n, m) = (self.sensitivities.nrows(), self.sensitivities.ncols());
        let mut all = Vec::new();
        if self.sources.iter().any(|s| s.variance < 0.0) {
            let dof = self.sources.iter().map(|s| s.dof).filter(|nu| *nu > 0.0).fold(f64::INFINITY, f64::min);
            return vec![Scatter { factor: super::propagate::factor(&self.covariance), dof }];
        }
        for source in self.sources.iter().filter(|s| s.variance > 0.0) {
            // columns of the square root of V: rows, or offsets
            let count = if source.offset.is_empty() { m } else { source.offset.iter().max().map_or(0, |k| k + 1) };
            let mut moved = Mat::<f64>::zeros(n, count);
            for (at, (row, u)) in source.rows.iter().enumerate() {
                let column = source.offset.get(at).copied().unwrap_or(*row);
                for j in 0..n {
                    moved[(j, column)] += self.sensitivities[(j, *row)] * u * source.variance.sqrt();
                }
            }
            let factor = super::propagate::factor(&(&moved * moved.transpose()));
            all.push(Scatter { factor, dof: source.dof });
        }
        if let Some(correction) = &self.correction {
            all.push(Scatter { factor: super::propagate::factor(correction), dof: f64::INFINITY });
        }
        all
    }

    /// `d (c . x) / d y`.
    pub(super) fn weights(&self, along: &[f64]) -> Vec<f64> {
        let mut weights = vec![0.0; self.sensitivities.ncols()];
        for (j, c) in along.iter().enumerate().take(self.sensitivities.nrows()) {
            if *c != 0.0 {
                for (i, weight) in weights.iter_mut().enumerate() {
                    *weight += c * self.sensitivities[(j, i)];
                }
            }
        }
        weights
    }

    /// Contributions of the readings to `c . x`, and the degrees of freedom of the Type A part where they are not those of
    /// Welch and Satterthwaite for independent sources.
    pub(super) fn contributions(&self, along: &[f64]) -> (Vec<Contribution>, Option<f64>) {
        let weights = self.weights(along);
        let forms: Vec<f64> = self.sources.iter().map(|source| source.form(&weights)).collect();
        if self.sources.iter().any(|s| s.variance < 0.0) {
            return self.merged(along, &forms);
        }
        let mut contributions: Vec<Contribution> = self
            .sources
            .iter()
            .zip(&forms)
            .filter(|(source, form)| **form * source.variance > 0.0)
            .map(|(source, form)| Contribution {
                source: source.name.clone(),
                evaluation: source.evaluation,
                distribution: if source.dof.is_finite() { "t" } else { "normal" },
                estimate: None,
                source_u: None,
                sensitivity: None,
                u: (form * source.variance).sqrt(),
                dof: source.dof,
            })
            .collect();
        let Some(dof) = self.together(&forms) else { return (contributions, None) };
        let added = self.added(along);
        if added > 0.0 {
            contributions.push(type_a("estimated weights (Kenward-Roger)".into(), added, dof));
        }
        (contributions, Some(dof))
    }

    /// Degrees of freedom of all estimated variances together (Satterthwaite, with their covariance).
    fn together(&self, forms: &[f64]) -> Option<f64> {
        let spread = self.spread.as_ref()?;
        let estimated = self.sources.iter().zip(forms).filter(|(s, _)| s.estimated);
        let plain: f64 = estimated.map(|(s, form)| s.variance * form).sum();
        let mut of_variance = 0.0;
        for (g, a) in forms.iter().enumerate() {
            for (h, b) in forms.iter().enumerate() {
                of_variance += a * b * spread[(g, h)];
            }
        }
        Some(if of_variance > 0.0 { 2.0 * plain * plain / of_variance } else { f64::INFINITY })
    }

    /// What the small-sample correction adds to the variance of `c . x`.
    fn added(&self, along: &[f64]) -> f64 {
        let Some(correction) = &self.correction else { return 0.0 };
        let inside = |k: usize| k < correction.nrows();
        let pairs =
            along.iter().enumerate().flat_map(|(i, a)| along.iter().enumerate().map(move |(j, b)| (i, j, a * b)));
        pairs.filter(|(i, j, _)| inside(*i) && inside(*j)).map(|(i, j, ab)| ab * correction[(i, j)]).sum()
    }

    /// With a negative variance among them, sources have no contributions of their own: all estimated ones as one.
    fn merged(&self, along: &[f64], forms: &[f64]) -> (Vec<Contribution>, Option<f64>) {
        let dof = self.together(forms).unwrap_or(f64::INFINITY);
        let (mut names, mut square) = (Vec::new(), self.added(along).max(0.0));
        let mut contributions = Vec::new();
        for (source, form) in self.sources.iter().zip(forms) {
            if source.estimated {
                names.push(source.name.as_str());
                square += source.variance * form;
            } else if *form > 0.0 {
                let mut own = type_a(source.name.clone(), source.variance * form, source.dof);
                own.evaluation = source.evaluation;
                contributions.push(own);
            }
        }
        contributions.push(type_a(names.join(", "), square.max(0.0), dof));
        (contributions, Some(dof))
    }
}

/// A Type A contribution of many readings.
fn type_a(source: String, variance: f64, dof: f64) -> Contribution {
    Contribution {
        source,
        evaluation: Evaluation::TypeA,
        distribution: if dof.is_finite() { "t" } else { "normal" },
        estimate: None,
        source_u: None,
        sensitivity: None,
        u: variance.sqrt(),
        dof,
    }
}
