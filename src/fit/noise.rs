//! What scatters in the readings, and how each estimated parameter follows it: the Type A side of every budget.

use crate::campaign::{Campaign, Deviating, Scatter, Size};
use crate::design::DesignMatrix;
use crate::elements::Elements;
use crate::estimate::{
    Absorbed, Estimate, Group, LineState, Mixture, ScaleUncertainty, Scattered, System, satterthwaite,
};
use crate::linear::form;
use crate::uncertainty::{Contribution, Evaluation, Shape};
use crate::uncertainty::{monte_carlo, quantiles};
use crate::vocabulary::vocabulary;
use faer::Mat;
use faer::linalg::matmul::matmul;
use faer::{Accum, Par, Side};

vocabulary! {
    /// Where a standard deviation comes from.
    VarianceFrom {
        /// As stated.
        Stated = "stated",
        /// Estimated from these readings.
        Estimated = "estimated",
    }
}

/// One independent source of scatter.
#[derive(Debug, Clone)]
pub struct VarianceSource {
    /// `readings of V`, `beta per position`, `priors`.
    pub name: String,
    /// Type A where its size comes from readings (or is that of single readings), B for priors and stated deviations.
    pub evaluation: Evaluation,
    /// Its variance in internal units; a factor where the rows have stated uncertainties.
    pub variance: f64,
    /// Is the variance estimated from these readings?
    pub estimated: bool,
    /// Degrees of freedom of the variance; infinite where it is known.
    pub dof: f64,
    /// Its part of the covariance of the unknowns.
    pub share: Mat<f64>,
    /// The line of the campaign's scatter, if it is one.
    pub line: Option<usize>,
    /// What became of it.
    pub state: LineState,
    /// Correlation time of a line that has one, and its standard uncertainty where it was estimated.
    pub tau: Option<(f64, Option<f64>)>,
    /// At zero: the standard deviation that it could have, one standard uncertainty above.
    pub could_be: Option<f64>,
    /// Number of deviations; rows for the readings of a sensor.
    pub levels: usize,
    /// Where it stands among the estimated variances.
    pub(super) component: Option<usize>,
    /// The sensor, for the readings of one.
    pub(super) sensor: Option<usize>,
}

impl VarianceSource {
    /// A stated source of unit variance, of Type B.
    pub(super) fn stated(name: String, share: Mat<f64>, levels: usize) -> Self {
        VarianceSource {
            name,
            evaluation: Evaluation::TypeB,
            variance: 1.0,
            estimated: false,
            dof: f64::INFINITY,
            share,
            line: None,
            state: LineState::Stated,
            tau: None,
            could_be: None,
            levels,
            component: None,
            sensor: None,
        }
    }

    /// A line of the campaign's scatter.
    pub(super) fn line(campaign: &Campaign, k: usize, line: &Scatter, share: Mat<f64>, levels: usize) -> Self {
        let estimated = line.size == Size::Estimated;
        VarianceSource {
            evaluation: if estimated { Evaluation::TypeA } else { Evaluation::TypeB },
            estimated,
            dof: if let Size::Stated { dof, .. } = line.size { dof } else { f64::INFINITY },
            line: Some(k),
            ..VarianceSource::stated(line.name(campaign), share, levels)
        }
    }
}

/// All sources, and how the unknowns follow each reading.
#[derive(Debug, Clone)]
pub struct ScatterSources {
    /// Sources with their variances.
    pub sources: Vec<VarianceSource>,
    /// `d x / d y`, unknowns x rows.
    pub sensitivities: Mat<f64>,
    /// Covariance of the unknowns from all sources.
    pub covariance: Mat<f64>,
    /// Covariance of the estimated variances relative to them, where they were estimated together.
    spread: Option<Mat<f64>>,
    /// Small-sample addition to the covariance, contained in it.
    correction: Option<Mat<f64>>,
    /// Correlation times that were estimated: where they stand in `spread`, and the derivative of the covariance by their logarithms.
    leans: Vec<(usize, Mat<f64>)>,
    /// Is the variance of every group of rows determined?
    pub determined: bool,
    /// The unknowns over the whole likelihood of the variances, where its top says nothing of some.
    mixture: Option<Mixture>,
    /// Lines of the campaign's scatter whose variance the readings do not tell, and what follows it.
    pub absorbed: Vec<(usize, Absorbed)>,
}

/// The rows of each source of single rows: each sensor's readings, then the priors.
fn row_sources(campaign: &Campaign, design: &DesignMatrix, system: &System) -> Vec<(VarianceSource, Vec<usize>)> {
    let sensors = campaign.bench.sensors.len();
    let mut sources = Vec::new();
    for s in 0..=sensors {
        let of = |i: &usize| design.rows.get(*i).map_or(sensors, |origin| origin.sensor) == s;
        let rows: Vec<usize> = (0..system.observed.len()).filter(of).collect();
        let Some(group) = rows.first().and_then(|i| system.group.get(*i)) else { continue };
        let name = campaign.bench.sensors.get(s).map_or("priors".to_string(), |s| format!("readings of {}", s.id));
        let component = if let Group::Estimated(g) = group { Some(*g) } else { None };
        let stated = VarianceSource::stated(name, Mat::new(), rows.len());
        let source = VarianceSource {
            evaluation: if s == sensors { Evaluation::TypeB } else { Evaluation::TypeA },
            estimated: component.is_some(),
            state: if component.is_some() { LineState::Estimated } else { LineState::Stated },
            component,
            sensor: (s < sensors).then_some(s),
            ..stated
        };
        sources.push((source, rows));
    }
    sources
}

/// `sum over rows of s s' u^2 variance`.
fn share(sensitivities: &Mat<f64>, rows: &[usize], u: &[f64], variance: f64) -> Mat<f64> {
    /// Rows at a time: of many, a copy would be as large as the sensitivities.
    const BLOCK: usize = 1 << 14;
    let n = sensitivities.nrows();
    let mut out = Mat::zeros(n, n);
    for rows in rows.chunks(BLOCK) {
        let scaled = Mat::from_fn(n, rows.len(), |j, k| rows.get(k).map_or(0.0, |i| sensitivities[(j, *i)] * u.at(*i)));
        matmul(&mut out, Accum::Add, &scaled, scaled.transpose(), variance, Par::Seq);
    }
    out
}

impl ScatterSources {
    /// Nothing that scatters.
    fn none() -> Self {
        ScatterSources {
            sources: Vec::new(),
            sensitivities: Mat::new(),
            covariance: Mat::new(),
            spread: None,
            correction: None,
            leans: Vec::new(),
            determined: true,
            mixture: None,
            absorbed: Vec::new(),
        }
    }

    /// Independent rows, the unknowns following them as in a plain estimate; `of` tells the variance of a source and its degrees of freedom.
    fn of_rows(
        campaign: &Campaign,
        design: &DesignMatrix,
        system: &System,
        plain: &Estimate,
        of: impl Fn(&VarianceSource) -> (f64, f64),
    ) -> Self {
        let sensitivities = plain.factor.sensitivities();
        let own = |(mut source, rows): (VarianceSource, Vec<usize>)| {
            (source.variance, source.dof) = of(&source);
            source.share = share(&sensitivities, &rows, &system.u, source.variance);
            source
        };
        let sources = row_sources(campaign, design, system).into_iter().map(own).collect();
        ScatterSources { sources, sensitivities, ..ScatterSources::none() }
    }

    /// Independent readings: the variances are the squares of the estimate's group scales, which were estimated together in the system of `told`.
    pub(super) fn independent(
        campaign: &Campaign,
        design: &DesignMatrix,
        (system, estimate): (&System, &Estimate),
        told: (&System, &Estimate),
    ) -> Self {
        let of = |source: &VarianceSource| match source.component {
            Some(g) => (estimate.scale_or_one(g).powi(2), estimate.group_redundancy.at(g)),
            None => (source.variance, source.dof),
        };
        let mut noise = ScatterSources {
            covariance: estimate.unknowns.covariance.clone(),
            determined: estimate.group_scale.iter().all(Option::is_some),
            ..ScatterSources::of_rows(campaign, design, system, estimate, of)
        };
        // the scale of one group alone leaves the weights as they are
        let several = estimate.group_iterations > 0 && noise.determined;
        let several = several.then(|| told.1.scale_uncertainty(told.0)).flatten();
        if let Some(ScaleUncertainty { relative, correction }) = several {
            let n = noise.covariance.nrows();
            let correction = correction.submatrix(0, 0, n, n).to_owned();
            noise.spread = Some(relative);
            noise.covariance += &correction;
            noise.correction = Some(correction);
        }
        noise
    }

    /// Variances of a robust estimate: `scale(g)` squared times `inflation`, the plain estimate's sensitivities.
    pub(super) fn robust(
        campaign: &Campaign,
        design: &DesignMatrix,
        system: &System,
        plain: &Estimate,
        factor: impl Fn(Option<usize>) -> f64,
        covariance: Mat<f64>,
    ) -> Self {
        let dof = |own: &VarianceSource| {
            if own.evaluation == Evaluation::TypeA { plain.dof as f64 } else { own.dof }
        };
        let of = |own: &VarianceSource| (factor(own.component), dof(own));
        let determined = plain.dof > 0;
        ScatterSources { covariance, determined, ..ScatterSources::of_rows(campaign, design, system, plain, of) }
    }

    /// What was estimated together: the covariance with variances as if they were known, theirs, what they add to it and how it follows
    /// correlation times.
    pub(super) fn jointly(
        sources: Vec<VarianceSource>,
        known: &Mat<f64>,
        (spread, correction): (Mat<f64>, Mat<f64>),
        leans: Vec<(usize, Mat<f64>)>,
        determined: bool,
    ) -> Self {
        let estimated = !leans.is_empty() || sources.iter().any(|s| s.component.is_some());
        ScatterSources {
            sources,
            // of a record that was streamed it is not known how the unknowns follow single readings
            sensitivities: Mat::zeros(known.nrows(), 0),
            covariance: known + &correction,
            spread: estimated.then_some(spread),
            correction: estimated.then_some(correction),
            leans,
            determined,
            ..ScatterSources::none()
        }
    }

    /// Readings and lines of scatter together; the sensitivities, as large as the readings, are taken over.
    pub(super) fn scattered(
        campaign: &Campaign,
        design: &DesignMatrix,
        own: &System,
        found: &mut Scattered,
        levels: &[usize],
    ) -> Self {
        let dof = |component: Option<usize>| {
            let spread = component.map_or(0.0, |c| found.spread[(c, c)]);
            // a group at the floor of its range has no spread, and is as if it were known
            let undetermined = |c: usize| found.group_variance.get(c).is_some_and(Option::is_none);
            match component {
                _ if spread > 0.0 => 2.0 / spread,
                Some(c) if undetermined(c) => 0.0,
                _ => f64::INFINITY,
            }
        };
        let mut sources = Vec::new();
        for (mut source, rows) in row_sources(campaign, design, own) {
            // stated uncertainties weigh as they are
            let weighed_with = source.component.and_then(|g| found.weighed_with.get(g).copied()).unwrap_or(1.0);
            if let Some(g) = source.component {
                // not determined: no u is told then
                source.variance = found.group_variance.get(g).copied().flatten().unwrap_or(1.0);
                source.dof = dof(source.component);
                if let Some(could_be) = found.group_could_be.get(g).copied().flatten() {
                    // none of the rows' scatter is their own: the lines hold it
                    source.could_be = Some(could_be);
                    (source.state, source.variance, source.component) = (LineState::AtZero, 0.0, None);
                    source.dof = f64::INFINITY;
                }
            }
            let felt = if source.state == LineState::AtZero { 0.0 } else { weighed_with };
            source.share = share(&found.sensitivities, &rows, &own.u, felt);
            sources.push(source);
        }
        for (k, line) in campaign.scatter.iter().enumerate() {
            let at = |list: &[f64]| list.at(k);
            // a line of which the estimate knows nothing
            let state = found.state.get(k).copied().unwrap_or(LineState::NotFelt);
            let component = found.component.get(k).copied().flatten();
            // a line that no row feels has no share
            let share = found.shares.get(k).cloned().unwrap_or_else(Mat::new);
            let own = VarianceSource::line(campaign, k, line, share, levels.at(k));
            sources.push(VarianceSource {
                variance: at(&found.variance),
                dof: if own.estimated && state == LineState::Estimated { dof(component) } else { own.dof },
                state,
                tau: found.tau.get(k).copied().flatten(),
                could_be: found.could_be.get(k).copied().flatten(),
                component,
                ..own
            });
        }
        let leans = found.leans.iter().flatten().cloned().collect();
        let estimate = (&found.estimate.unknowns.covariance, (found.spread.clone(), found.correction.clone()));
        let determined = found.group_variance.iter().all(Option::is_some);
        let jointly = ScatterSources::jointly(sources, estimate.0, estimate.1, leans, determined);
        ScatterSources {
            sensitivities: std::mem::replace(&mut found.sensitivities, Mat::new()),
            covariance: match &found.mixture {
                Some(mixture) => summed_covariance(mixture).0,
                None => jointly.covariance,
            },
            mixture: found.mixture.take(),
            absorbed: found.absorbed.iter().enumerate().filter_map(|(k, own)| Some((k, own.clone()?))).collect(),
            ..jointly
        }
    }

    /// The same sources for one quantity that follows readings of one sensor: what their own noise, as stated or of unit variance, makes of it,
    /// and deviations of unit variance of a line with its correlation time.
    pub(super) fn of_one(&self, sensor: usize, of_rows: f64, of_line: &dyn Fn(usize, Option<f64>) -> f64) -> Self {
        let mut own = ScatterSources {
            sources: self.sources.clone(),
            covariance: Mat::zeros(1, 1),
            spread: self.spread.clone(),
            determined: self.determined,
            ..ScatterSources::none()
        };
        for source in &mut own.sources {
            let form = match source.line {
                Some(k) => of_line(k, source.tau.map(|(tau, _)| tau)),
                None if source.sensor == Some(sensor) => of_rows,
                None => 0.0,
            };
            source.share = Mat::from_fn(1, 1, |_, _| source.variance * form);
        }
        own
    }

    /// Is the variance of `along . x` known?
    pub(crate) fn tells(&self, along: &[f64]) -> bool {
        self.determined && !self.absorbed.iter().any(|(_, own)| own.touches(along))
    }

    /// Every source's covariance of the unknowns, factored, with its degrees of freedom.
    ///
    /// What a variance estimated as zero takes off the others cannot be drawn alone: with such a line, all that the readings tell of is drawn
    /// together.
    pub(super) fn scatter(&self) -> Vec<monte_carlo::Scatter> {
        let factored = |share: &Mat<f64>, dof: f64| monte_carlo::Scatter { factor: covariance_root(share), dof };
        let felt = self.sources.iter().filter(|s| s.variance > 0.0 && s.share.nrows() > 0);
        let below = self.sources.iter().any(VarianceSource::is_below_zero);
        let (mut joint, mut all) = (Mat::zeros(self.covariance.nrows(), self.covariance.nrows()), Vec::new());
        for source in felt.chain(self.sources.iter().filter(|s| s.is_below_zero())) {
            if (below || self.mixture.is_some()) && source.evaluation == Evaluation::TypeA {
                joint += &source.share;
            } else {
                all.push(factored(&source.share, source.dof));
            }
        }
        if let Some(mixture) = &self.mixture {
            let (mut whole, dof) = summed_covariance(mixture);
            let stated = self.sources.iter().filter(|s| s.evaluation != Evaluation::TypeA && s.share.nrows() > 0);
            stated.for_each(|source| whole -= &source.share);
            all.push(factored(&whole, dof));
            return all;
        }
        if below {
            let part = |share: &Mat<f64>| -> f64 {
                let shares = (0..share.nrows()).filter(|j| joint[(*j, *j)] > 0.0);
                shares.map(|j| share[(j, j)] / joint[(j, j)]).sum()
            };
            // nothing of it is estimated
            let dof = self.together(&part).unwrap_or(f64::INFINITY);
            all.push(factored(&joint, dof));
        }
        all.extend(self.correction.as_ref().map(|correction| factored(correction, f64::INFINITY)));
        all
    }

    /// Contributions of the readings to `c . x`, and the degrees of freedom of the Type A part where they are not those of
    /// Welch and Satterthwaite for independent sources.
    pub(super) fn contributions(&self, along: &[f64]) -> (Vec<Contribution>, Option<f64>) {
        let mut forms: Vec<f64> = self.sources.iter().map(|source| form(&source.share, along)).collect();
        // what a variance estimated as zero takes off the others
        let (mut below, mut above) = (0.0, 0.0);
        for (source, form) in self.sources.iter().zip(&mut forms) {
            if source.is_below_zero() {
                below += -*form;
                *form = 0.0;
            } else if source.evaluation == Evaluation::TypeA {
                above += *form;
            }
        }
        if below > 0.0 && below < above {
            let type_a = self.sources.iter().zip(&mut forms).filter(|(s, _)| s.evaluation == Evaluation::TypeA);
            type_a.for_each(|(_, form)| *form *= (above - below) / above);
        }
        let mut contributions: Vec<Contribution> = self
            .sources
            .iter()
            .zip(&forms)
            .filter(|(_, form)| **form > 0.0)
            .map(|(own, form)| Contribution::of_many(own.name.clone(), own.evaluation, form.sqrt(), own.dof))
            .collect();
        let Some(dof) = self.together(&|share| form(share, along)) else { return (contributions, None) };
        if let Some((u, dof)) = self.mixture.as_ref().and_then(|own| summed(own, along)) {
            // shares of the sources at the top of the likelihood, in the whole that they have over all of it
            let of_type_a = |c: &&Contribution| c.evaluation == Evaluation::TypeA;
            let all: f64 = contributions.iter().map(|c| c.u * c.u).sum();
            let estimated: f64 = contributions.iter().filter(of_type_a).map(|c| c.u * c.u).sum();
            let factor = if estimated > 0.0 { ((u * u - (all - estimated)).max(0.0) / estimated).sqrt() } else { 1.0 };
            for own in contributions.iter_mut().filter(|c| c.evaluation == Evaluation::TypeA) {
                (own.u, own.dof, own.distribution) = (own.u * factor, dof, Shape::T);
            }
            return (contributions, Some(dof));
        }
        if below > 0.0 {
            let type_a = contributions.iter_mut().filter(|c| c.evaluation == Evaluation::TypeA);
            type_a.for_each(|c| (c.dof, c.distribution) = (dof, Shape::T));
        }
        let added = self.correction.as_ref().map_or(0.0, |correction| form(correction, along));
        // one variance for all readings leaves their weights as they are, to rounding: of sums over 10^4 epsilons
        if added > 1e-12 * form(&self.covariance, along) {
            let source = "estimated weights (Kenward-Roger)".to_string();
            contributions.push(Contribution::of_many(source, Evaluation::TypeA, added.sqrt(), dof));
        }
        (contributions, Some(dof))
    }

    /// Do the intervals come from the whole likelihood of the variances?
    pub fn is_summed(&self) -> bool {
        self.mixture.is_some()
    }

    /// Degrees of freedom of all estimated variances together (Satterthwaite, with their covariance): `of` is what is made of each part of the
    /// covariance.
    fn together(&self, of: &dyn Fn(&Mat<f64>) -> f64) -> Option<f64> {
        let spread = self.spread.as_ref()?;
        let mut estimated: Vec<(usize, f64)> =
            self.sources.iter().filter_map(|s| Some((s.component?, of(&s.share)))).collect();
        // the noise that a variance below zero reduces is estimated with it, though it may be stated
        let below = self.sources.iter().any(VarianceSource::is_below_zero);
        let parts =
            self.sources.iter().filter(|s| s.component.is_some() || (below && s.evaluation == Evaluation::TypeA));
        let plain: f64 = parts.map(|s| of(&s.share)).sum();
        estimated.extend(self.leans.iter().map(|(c, lean)| (*c, of(lean))));
        Some(satterthwaite(plain, &estimated, spread))
    }
}

impl VarianceSource {
    /// Was its variance estimated as zero, and taken below it for the uncertainties?
    pub(crate) fn is_below_zero(&self) -> bool {
        self.state == LineState::AtZero && self.component.is_some()
    }
}

/// Standard uncertainty and degrees of freedom of `along . x` over the likelihood of the variances: of the Student distribution that has the same
/// probability within its 68 % and 95 % intervals, or the same 95 % interval and one degree of freedom where the sum has longer tails.
fn summed(mixture: &Mixture, along: &[f64]) -> Option<(f64, f64)> {
    let parts = mixture.along(along);
    let half = |level: f64| quantiles::mixture_half_interval(&parts, mixture.dof, level);
    let (near, far) = (half(0.6827)?, half(0.95)?);
    let ratio = |dof: f64| Some(quantiles::coverage_factor(0.95, dof)? / quantiles::coverage_factor(0.6827, dof)?);
    let (mut low, mut high) = (0.0_f64, 1e4_f64.ln());
    for _ in 0..50 {
        let middle = 0.5 * (low + high);
        if ratio(middle.exp())? > far / near { low = middle } else { high = middle }
    }
    let dof = if high < 1e4_f64.ln() { high.exp() } else { f64::INFINITY };
    Some((far / quantiles::coverage_factor(0.95, dof)?, dof))
}

/// Covariance of the unknowns over the likelihood of the variances, with the standard uncertainties of [`summed`]; and the least of their degrees of
/// freedom.
fn summed_covariance(mixture: &Mixture) -> (Mat<f64>, f64) {
    let mean = mixture.covariance();
    let (mut factor, mut least) = (vec![0.0; mean.nrows()], f64::INFINITY);
    for (j, slot) in factor.iter_mut().enumerate() {
        let along: Vec<f64> = (0..mean.nrows()).map(|k| f64::from(u8::from(k == j))).collect();
        let Some((u, dof)) = summed(mixture, &along).filter(|_| mean[(j, j)] > 0.0) else { continue };
        *slot = u / mean[(j, j)].sqrt();
        least = least.min(dof);
    }
    (Mat::from_fn(mean.nrows(), mean.ncols(), |i, j| mean[(i, j)] * factor.at(i) * factor.at(j)), least)
}

/// `F` with `F F' = covariance`, from the eigenvectors of the correlation; directions without variance are left out.
fn covariance_root(covariance: &Mat<f64>) -> Mat<f64> {
    let n = covariance.nrows();
    let sd: Vec<f64> = (0..n).map(|k| covariance[(k, k)].max(0.0).sqrt()).collect();
    let sd_of = |i: usize| sd.at(i);
    let correlation = Mat::from_fn(n, n, |i, j| match sd_of(i) * sd_of(j) {
        product if product > 0.0 => covariance[(i, j)] / product,
        _ => 0.0,
    });
    let Ok(eigen) = correlation.self_adjoint_eigen(Side::Lower) else { return Mat::zeros(n, 0) };
    let values = eigen.S().column_vector().iter().copied().enumerate();
    let kept: Vec<(usize, f64)> = values.filter(|(_, value)| *value > 1e-14).collect();
    Mat::from_fn(n, kept.len(), |i, k| {
        kept.get(k).map_or(0.0, |(k, value)| sd_of(i) * eigen.U()[(i, *k)] * value.sqrt())
    })
}

/// Is this line a correlation, which has no size of its own?
pub(crate) fn is_correlation(line: &Scatter) -> bool {
    matches!(line.of, Deviating::Correlated(..))
}
