//! The restricted likelihood, and the way to its top: from sums over parts of the rows (`chain.rs`) or from whitened rows (`inference.rs`).
//!
//! ```text
//! D = sum_p (rows_p ln w_p + log|V1_p|) + log|M_AA| + y' P y,          M = sum_p C' V1_p^-1 C / w_p,   C = [A y]
//! D_k  = (log|V|)_k + tr F_k + r' M_k r,                               F_k = L^-1 M_k L^-T,  M_AA = L L',  r = [-x; 1]
//! D_kh = (log|V|)_kh + tr F_kh - tr F_k F_h + r' M_kh r - 2 v_k' v_h,  v_k = L^-1 (M_k r)_A
//! Phi_k = -L^-T F_k L^-1,   Phi_kh = L^-T (F_k F_h + F_h F_k - F_kh) L^-1,        Phi the covariance of the unknowns
//! ```
//!
//! Parameters are logarithms of variances and of correlation times; `M_k`, `M_kh` are derivatives of the sums that the parts bring (`chain.rs`). H. D. Patterson,
//! R. Thompson 1971; derivatives of the profiled criterion in these forms: D. Bates, M. Maechler, B. Bolker, S. Walker, J. Stat. Software 67 (2015), 1; D. M. Bates,
//! MixedModels.jl. Kenward and Roger's addition to `Phi` is `-sum W_kh (Phi_kh - Phi R_kh Phi/2)` in variances themselves. The expected information of variances is
//! `S_kh = tr P V_k P V_h`; where `(log|V|)_kh` is not known the average information `r' M_kh r/2 - v_k' v_h` stands for it (A. R. Gilmour, R. Thompson, B. R. Cullis 1995).
#![allow(
    clippy::indexing_slicing,
    reason = "slots hold numbers of parameters, for each of which there is a logarithm, a range and a derivative; parts are as many as the model has; sums have as many derivatives as there are parameters"
)]

use super::chain::{Part, TimeNoise};
use crate::error::{Fault, Malformed, Result};
use crate::linear::dot;
use faer::linalg::solvers::Solve;
use faer::{Mat, Scale, Side};

/// A parameter of the noise: stated, or which of the free ones.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Slot {
    /// As stated.
    Stated(f64),
    /// The number of the free parameter whose exponential it is.
    Free(usize),
}

impl Slot {
    /// Its value.
    pub fn at(self, logarithms: &[f64]) -> f64 {
        match self {
            Slot::Stated(value) => value,
            Slot::Free(k) => logarithms[k].exp(),
        }
    }

    fn free(self) -> Option<usize> {
        if let Slot::Free(k) = self { Some(k) } else { None }
    }
}

/// The noise of one part.
#[derive(Debug, Clone, Copy)]
pub struct PartNoise {
    /// Variance factor of the white noise.
    pub white: Slot,
    /// Variance of the deviation; none where nothing is correlated.
    pub deviation: Option<(Slot, Slot)>,
}

impl PartNoise {
    /// In numbers.
    pub fn at(&self, logarithms: &[f64]) -> TimeNoise {
        let (deviation, tau) = self.deviation.map_or((0.0, 1.0), |(q, tau)| (q.at(logarithms), tau.at(logarithms)));
        TimeNoise { white: self.white.at(logarithms), deviation, tau }
    }
}

/// The parts, and what is free of their noise.
#[derive(Debug, Clone)]
pub struct NoiseModel {
    /// Noise of each part.
    pub parts: Vec<PartNoise>,
    /// Least and largest logarithm of each free parameter.
    pub range: Vec<(f64, f64)>,
    /// How many of the columns are unknowns' (observations stand last).
    pub columns: usize,
}

/// Sums over all rows at some noise, with their derivatives by the logarithms of what is free.
pub(super) struct Sums {
    /// `M`.
    pub whole: Mat<f64>,
    /// `M_k`.
    pub first: Vec<Mat<f64>>,
    /// `M_kh`, `h <= k`; none where it is zero.
    pub second: Vec<Vec<Option<Mat<f64>>>>,
    /// `log|V|`.
    pub logarithm: f64,
    /// `(log|V|)_k`.
    pub log_first: Vec<f64>,
    /// `(log|V|)_kh`, `h <= k`; none where it is not known.
    pub log_second: Vec<Vec<Option<f64>>>,
}

impl Sums {
    /// Nothing being free.
    pub fn of(whole: Mat<f64>) -> Self {
        let (first, second, log_first, log_second) = Default::default();
        Sums { whole, first, second, logarithm: 0.0, log_first, log_second }
    }
}

/// The likelihood at some noise, with its derivatives by the logarithms of what is free.
#[derive(Debug, Clone)]
pub struct Likelihood {
    /// `-2 log L`, without constants.
    pub deviance: f64,
    /// Its gradient.
    pub gradient: Vec<f64>,
    /// Its second derivatives.
    pub bend: Mat<f64>,
    /// The expected information of variances, or the average one.
    pub expected: Mat<f64>,
    /// The solution, in the columns that the parts have.
    pub solution: Vec<f64>,
    /// Covariance of the unknowns.
    pub covariance: Mat<f64>,
    /// `(log|V|)_k + tr F_k`: what of the rows belongs to each variance.
    pub redundancy: Vec<f64>,
    /// `L^-1`, `F_k` and `F_kh`, `k` before `h <= k`; none where it is zero.
    inverse: Mat<f64>,
    forms: Vec<Mat<f64>>,
    second: Vec<Vec<Option<Mat<f64>>>>,
}

/// Where Newton's steps ended.
#[derive(Debug, Clone)]
pub struct Top {
    /// Logarithms of what is free.
    pub at: Vec<f64>,
    /// The likelihood there.
    pub found: Likelihood,
    /// Parameters that stand at the end of their range, and variances that are as good as zero there.
    pub at_end: Vec<bool>,
    /// Steps.
    pub iterations: usize,
    /// Did they settle?
    pub converged: bool,
}

/// Most steps, where nothing else is said.
pub const NEWTON_STEPS: usize = 60;
/// Change of every logarithm at which the steps end.
const SETTLED: f64 = 1e-10;
/// Changes that no longer get smaller, and are below this, are the rounding of the sums.
const ROUNDING: f64 = 1e-7;
/// Longest step of a logarithm.
const LONGEST: f64 = 2.0;
/// Eigenvalues of the scaled second derivatives are taken as this at least: a tenth of the least that components have which are told apart (`problem.rs`).
const FLATTEST: f64 = 1e-9;
/// Information of a logarithm and slope by it below which the likelihood says nothing of it: its standard uncertainty would be a factor of e^10^6, and the
/// slope is the rounding of sums over 10^7 rows (1e-16 of each). A variance on its way to zero has less information, and a slope.
const UNTOLD: f64 = 1e-12;
const FLAT: f64 = 1e-9;
/// Degrees of freedom of a variance that is as good as zero: its relative standard uncertainty, `sqrt(2/S)` with `S` at most these, is 1,400 or more, and at zero the
/// deviance is the same within these.
const ZERO: f64 = 1e-6;
/// Steps that are longer than this are Fisher's, where only variances are free: Newton's leaves a third-order rest of about its square, a tenth here.
const NEAR: f64 = 0.3;
/// Largest factor of one of Fisher's steps. A choice: any variance is reached within the steps that there are.
const LEAP: f64 = 30.0;
/// A step that does no good however short it is: the rounding of the deviance, whose square root is this at most.
const SHORTEST: f64 = 1e-6;
/// Logarithms that differ by less than this from the end of a range are at it: ends follow other variances.
pub(super) const AT_END: f64 = 1e-9;

impl NoiseModel {
    /// Which of the free parameters are correlation times.
    fn times(&self) -> Vec<usize> {
        let time = |part: &PartNoise| part.deviation.and_then(|(_, time)| time.free());
        self.parts.iter().filter_map(time).collect()
    }

    /// The likelihood at these logarithms from the parts there, with derivatives where the parts have theirs; `None` where the unknowns' columns are
    /// not independent in them.
    pub fn likelihood(&self, logarithms: &[f64], parts: &[Part]) -> Option<Likelihood> {
        let (n, free) = (self.columns, self.range.len());
        let zero = || Mat::zeros(n + 1, n + 1);
        let mut sums = Sums {
            first: vec![zero(); free],
            second: (0..free).map(|k| vec![None; k + 1]).collect(),
            log_first: vec![0.0; free],
            log_second: (0..free).map(|k| vec![Some(0.0); k + 1]).collect(),
            ..Sums::of(zero())
        };
        for (own, part) in self.parts.iter().zip(parts) {
            let white = own.white.at(logarithms);
            sums.whole += &part.gram[0] * Scale(1.0 / white);
            sums.logarithm += part.rows * white.ln() + part.log_determinant[0];
            own.derivatives(part, white, &mut sums);
        }
        Likelihood::of(sums)
    }

    /// At most so many of Newton's steps from a start to the top of the likelihood; `gather` brings the parts at some noise.
    ///
    /// Errors: those of `gather`; a start that is no covariance.
    pub fn top(
        &self,
        start: &[f64],
        steps: usize,
        gather: &mut dyn FnMut(&[TimeNoise]) -> Result<Vec<Part>>,
    ) -> Result<Top> {
        let mut at = start.to_vec();
        self.range.iter().zip(&mut at).for_each(|((low, high), x)| *x = x.clamp(*low, *high));
        let mut look = |at: &[f64]| -> Result<Option<(Likelihood, ())>> {
            let noises: Vec<TimeNoise> = self.parts.iter().map(|own| own.at(at)).collect();
            Ok(self.likelihood(at, &gather(&noises)?).map(|found| (found, ())))
        };
        let found = look(&at)?.ok_or_else(no_covariance)?;
        let mut hill = Hill {
            range: &|_| self.range.clone(),
            look: &mut look,
            alike: &|_, _| true,
            scoring: self.times().is_empty(),
            limits: Limits { steps, settled: SETTLED },
        };
        let all: Vec<usize> = (0..at.len()).collect();
        let Climbed { at, found: (found, ()), iterations, converged } = hill.climb(at, found, &all)?;
        let times = self.times();
        let unseen = |k: usize| !times.contains(&k) && found.is_unseen(k);
        let beyond = |k: usize| at[k] <= self.range[k].0 || at[k] >= self.range[k].1;
        let at_end = (0..at.len()).map(|k| beyond(k) || unseen(k)).collect();
        Ok(Top { at, found, at_end, iterations, converged })
    }

    /// Variance factors of the white noise of `parts`, beginning with `variance`: those in `free` at the top of the likelihood, and not below `least`. How
    /// the steps ended.
    ///
    /// Errors: parts in which the columns of the unknowns are not independent.
    pub fn scales(
        parts: &[Part],
        variance: &mut [f64],
        (free, least): (&[usize], &[f64]),
        steps: usize,
    ) -> Result<Top> {
        let white = |p: usize| match free.iter().position(|own| *own == p) {
            Some(k) => Slot::Free(k),
            None => Slot::Stated(variance[p]),
        };
        let model = NoiseModel {
            parts: (0..parts.len()).map(|p| PartNoise { white: white(p), deviation: None }).collect(),
            range: free.iter().map(|p| (least[*p].ln(), f64::MAX.ln())).collect(),
            columns: parts.first().map_or(0, Part::columns),
        };
        let start: Vec<f64> = free.iter().map(|p| variance[*p].ln()).collect();
        let top = model.top(&start, steps, &mut |_| Ok(parts.to_vec()))?;
        free.iter().zip(&top.at).for_each(|(p, x)| variance[*p] = x.exp());
        Ok(top)
    }
}

/// How far the steps go.
#[derive(Debug, Clone, Copy)]
pub(super) struct Limits {
    pub steps: usize,
    /// Change of every logarithm at which they end.
    pub settled: f64,
}

/// A likelihood over logarithms of variances and correlation times.
pub(super) struct Hill<'a, T> {
    /// Least and largest of each, at some of them.
    pub range: &'a dyn Fn(&[f64]) -> Vec<(f64, f64)>,
    /// The likelihood, and what is kept beside it; `None` where there is no covariance.
    pub look: &'a mut dyn FnMut(&[f64]) -> Result<Option<(Likelihood, T)>>,
    /// Do the deviances of two of them compare?
    pub alike: &'a dyn Fn(&T, &T) -> bool,
    /// Are Fisher's steps taken far from the top?
    pub scoring: bool,
    pub limits: Limits,
}

/// Where the steps ended.
pub(super) struct Climbed<T> {
    pub at: Vec<f64>,
    pub found: (Likelihood, T),
    pub iterations: usize,
    /// Did they settle?
    pub converged: bool,
}

/// Variances that are no covariance.
pub(super) fn no_covariance() -> Malformed {
    Malformed::new(Fault::Value, "the variances of the random effects are not a covariance matrix")
}

/// The longest of some steps.
fn size(step: &[f64]) -> f64 {
    step.iter().fold(0.0_f64, |most, x| most.max(x.abs()))
}

impl<T> Hill<'_, T> {
    /// From a place, and what was found there, to the top; only what is in `movable` moves. A step that lowers the likelihood is shortened.
    ///
    /// Errors: those of `look`.
    pub fn climb(&mut self, mut at: Vec<f64>, mut found: (Likelihood, T), movable: &[usize]) -> Result<Climbed<T>> {
        let (mut iterations, mut converged, mut before) = (0, movable.is_empty(), f64::INFINITY);
        // where second derivatives are those of the average information steps may be too long each time: by how much, the slopes along the last one say
        let (mut part, mut taken) = (1.0_f64, None::<(Vec<f64>, f64)>);
        'steps: while !converged && iterations < self.limits.steps {
            crate::stop::poll();
            iterations += 1;
            let (range, likelihood) = ((self.range)(&at), &found.0);
            let outwards = |k: usize| {
                let ((low, high), slope) = (range[k], likelihood.gradient[k]);
                (at[k] <= low + AT_END && slope >= 0.0) || (at[k] >= high - AT_END && slope <= 0.0)
            };
            let open: Vec<usize> = movable.iter().copied().filter(|k| !outwards(*k)).collect();
            let step = likelihood.step(&open, self.scoring);
            let largest = size(&step);
            if !(largest.is_finite() && open.iter().all(|k| likelihood.gradient[*k].is_finite())) {
                break;
            }
            converged = largest <= self.limits.settled || (largest < ROUNDING && largest > 0.5 * before);
            if converged {
                break;
            }
            before = largest;
            let along =
                |step: &[f64]| -> f64 { step.iter().zip(&likelihood.gradient).map(|(x, slope)| x * slope).sum() };
            if let Some((step, slope)) = taken.take().filter(|(step, slope)| *slope < along(step)) {
                part = (part * slope / (slope - along(&step))).clamp(0.1, 1.0);
            }
            // a step of Fisher's has its bounds
            let mut share = if self.scoring { 1.0 } else { part * (LONGEST / largest).min(1.0) };
            loop {
                let mut trial = at.clone();
                for (k, x) in open.iter().zip(&step) {
                    trial[*k] = (trial[*k] + share * x).clamp(range[*k].0, range[*k].1);
                }
                let room = 1e-10 * (1.0 + found.0.deviance.abs());
                match (self.look)(&trial)? {
                    Some(there) if there.0.deviance <= found.0.deviance + room || !(self.alike)(&there.1, &found.1) => {
                        let moved: Vec<f64> =
                            trial.iter().zip(&at).map(|(to, from)| if to == from { 0.0 } else { to - from }).collect();
                        let slope = moved.iter().zip(&found.0.gradient).map(|(x, slope)| x * slope).sum();
                        taken = Some((moved, slope));
                        (at, found) = (trial, there);
                        break;
                    }
                    there if share * largest < SHORTEST => {
                        converged = there.is_some();
                        break 'steps;
                    }
                    // a choice: the best share of a parabola that turned is seldom less
                    _ => share *= 0.3,
                }
            }
        }
        Ok(Climbed { at, found, iterations, converged })
    }
}

impl Likelihood {
    /// From sums; `None` where the unknowns' columns are not independent in them.
    pub(super) fn of(sums: Sums) -> Option<Self> {
        let Sums { whole, first, second, logarithm, log_first, log_second } = sums;
        let (n, free) = (whole.ncols() - 1, first.len());
        let cholesky = whole.as_ref().subrows(0, n).subcols(0, n).llt(Side::Lower).ok()?;
        let lower = cholesky.L().to_owned();
        let solution = cholesky.solve(whole.as_ref().subrows(0, n).subcols(n, 1));
        let squares = whole[(n, n)] - (0..n).map(|j| whole[(j, n)] * solution[(j, 0)]).sum::<f64>();
        let mut inverse = Mat::<f64>::identity(n, n);
        faer::linalg::triangular_solve::solve_lower_triangular_in_place(
            lower.as_ref(),
            inverse.as_mut(),
            faer::Par::Seq,
        );
        let solution: Vec<f64> = (0..n).map(|j| solution[(j, 0)]).collect();
        // L^-1 M_k r and L^-1 M_k L^-T
        let turned = |m: &Mat<f64>| &inverse * m.subrows(0, n).subcols(0, n) * inverse.transpose();
        let rest = |m: &Mat<f64>, i: usize| m[(i, n)] - (0..n).map(|j| m[(i, j)] * solution[j]).sum::<f64>();
        let along = |m: &Mat<f64>| {
            let own: Vec<f64> = (0..n).map(|i| rest(m, i)).collect();
            let square = rest(m, n) - own.iter().zip(&solution).map(|(v, x)| v * x).sum::<f64>();
            (own, square)
        };
        let trace = |m: &Mat<f64>| (0..n).map(|i| m[(i, i)]).sum::<f64>();
        let (mut shifts, mut forms): (Vec<Vec<f64>>, Vec<Mat<f64>>) = Default::default();
        let (mut gradient, mut redundancy) = (vec![0.0; free], log_first);
        for (k, m) in first.iter().enumerate() {
            let (own, square) = along(m);
            let form = turned(m);
            redundancy[k] += trace(&form);
            gradient[k] = redundancy[k] + square;
            shifts.push((0..n).map(|i| (0..=i).map(|j| inverse[(i, j)] * own[j]).sum()).collect());
            forms.push(form);
        }
        let (mut bend, mut expected) = (Mat::zeros(free, free), Mat::zeros(free, free));
        let mut seconds = Vec::with_capacity(free);
        for (k, row) in second.into_iter().enumerate() {
            let mut own = Vec::with_capacity(k + 1);
            for (h, m) in row.into_iter().enumerate() {
                let form = m.as_ref().map(turned);
                let square = m.as_ref().map_or(0.0, |m| along(m).1);
                // tr F_k F_h, both symmetric
                let crossed: f64 = (0..n).map(|j| dot(forms[k].col_as_slice(j), forms[h].col_as_slice(j))).sum();
                let through = dot(&shifts[k], &shifts[h]);
                // of variances themselves, in which V is linear
                let (own_redundancy, own_square) =
                    if k == h { (redundancy[k], gradient[k] - redundancy[k]) } else { (0.0, 0.0) };
                expected[(k, h)] = match log_second[k][h] {
                    Some(logarithm) => own_redundancy - (logarithm + form.as_ref().map_or(0.0, trace) - crossed),
                    None => 0.5 * (square - own_square) - through,
                };
                bend[(k, h)] = own_redundancy - expected[(k, h)] + square - 2.0 * through;
                (expected[(h, k)], bend[(h, k)]) = (expected[(k, h)], bend[(k, h)]);
                own.push(form);
            }
            seconds.push(own);
        }
        let deviance = logarithm + 2.0 * (0..n).map(|j| lower[(j, j)].ln()).sum::<f64>() + squares;
        let covariance = inverse.transpose() * &inverse;
        Some(Likelihood {
            deviance,
            gradient,
            bend,
            expected,
            solution,
            covariance,
            redundancy,
            inverse,
            forms,
            second: seconds,
        })
    }

    /// Is this variance as good as zero?
    pub(super) fn is_unseen(&self, k: usize) -> bool {
        self.redundancy[k].abs() <= ZERO
    }

    /// Fisher's or Newton's step on some of the parameters.
    fn step(&self, open: &[usize], scoring: bool) -> Vec<f64> {
        let step = newton(&self.gradient, &self.bend, open);
        if !scoring {
            return step;
        }
        // far from the top Fisher's steps, which do not run to tops where a variance vanishes
        let scoring = self.scoring(open);
        if size(&scoring) > NEAR || size(&step) > NEAR { scoring } else { step }
    }

    /// Fisher's step: relative changes `c` of the variances with `S c = -D'`, as logarithms. What would leave `1/LEAP` to `LEAP` goes as far, and the others go with
    /// that: a variance that falls to nothing has an information that is lost in rounding.
    fn scoring(&self, open: &[usize]) -> Vec<f64> {
        let mut found: Vec<Option<f64>> = vec![None; self.gradient.len()];
        let mut slope = self.gradient.clone();
        loop {
            let left: Vec<usize> = open.iter().copied().filter(|k| found[*k].is_none()).collect();
            let change = newton(&slope, &self.expected, &left);
            let bounded = |c: &f64| c.clamp(1.0 / LEAP - 1.0, LEAP - 1.0);
            let is_beyond = change.iter().any(|c| bounded(c) != *c);
            for (k, c) in left.iter().zip(&change).filter(|(_, c)| !is_beyond || bounded(c) != **c) {
                found[*k] = Some(bounded(c));
                slope.iter_mut().enumerate().for_each(|(h, slope)| *slope += self.expected[(h, *k)] * bounded(c));
            }
            if !is_beyond {
                return open.iter().map(|k| found[*k].unwrap_or(0.0).ln_1p()).collect();
            }
        }
    }

    /// The first derivative of the covariance of the unknowns.
    pub fn slope(&self, k: usize) -> Mat<f64> {
        self.back(&self.forms[k]) * Scale(-1.0)
    }

    /// `L^-T F L^-1`.
    fn back(&self, form: &Mat<f64>) -> Mat<f64> {
        self.inverse.transpose() * form * &self.inverse
    }

    /// Covariance of the estimated parameters `among` all that are free, of logarithms, zero for the others; and what estimating them adds to the covariance of
    /// the unknowns.
    ///
    /// Of variances alone the information is the expected one; with correlation times it is that of the likelihood at hand.
    ///
    /// Kenward and Roger's `2 sum W_kh Phi (Q_kh - P_k Phi P_h - R_kh/4) Phi`, `R_kh = A' V^-1 V_kh V^-1 A`, is `sum W_kh (Phi R_kh Phi / 2 - Phi_kh)`: from the second
    /// derivatives of `Phi` by the variances themselves, in which `V` is linear, and by the correlation time itself, in which its slow part is.
    pub fn costs(&self, model: Option<&NoiseModel>, among: &[usize]) -> (Mat<f64>, Mat<f64>) {
        let times = model.map_or_else(Vec::new, NoiseModel::times);
        let linear = !among.iter().any(|k| times.contains(k));
        let spread = spread(if linear { &self.expected } else { &self.bend }, among);
        let n = self.covariance.nrows();
        let mut correction = Mat::<f64>::zeros(n, n);
        for k in among {
            for h in among {
                let (a, b) = (*k.max(h), *k.min(h));
                let product = &self.forms[a] * &self.forms[b];
                // -Phi_kh
                let mut own = (&product + product.transpose()) * Scale(-1.0);
                if let Some(form) = &self.second[a][b] {
                    own += form;
                }
                if k == h {
                    own -= &self.forms[*k];
                }
                let pair = |part: &PartNoise| {
                    let (size, time) = part.deviation?;
                    let (size, time) = (size.free()?, time.free()?);
                    (size.max(time) == a && size.min(time) == b).then_some(time)
                };
                if let Some(time) = model.and_then(|model| model.parts.iter().find_map(pair)) {
                    own -= &self.forms[time] * Scale(0.5);
                }
                correction += own * Scale(spread[(*k, *h)]);
            }
        }
        (spread, self.back(&correction))
    }
}

/// Newton's step on some parameters, downhill also where the likelihood is not bent as at its top.
pub(super) fn newton(gradient: &[f64], bend: &Mat<f64>, open: &[usize]) -> Vec<f64> {
    // what the likelihood says nothing of stays where it is
    let told = |k: &usize| !(bend[(*k, *k)].abs() <= UNTOLD && gradient[*k].abs() <= FLAT);
    if !open.iter().all(told) {
        let fewer: Vec<usize> = open.iter().copied().filter(told).collect();
        let mut step = newton(gradient, bend, &fewer).into_iter();
        return open.iter().map(|k| if told(k) { step.next().unwrap_or(0.0) } else { 0.0 }).collect();
    }
    if open.is_empty() {
        return Vec::new();
    }
    let size: Vec<f64> = open.iter().map(|k| bend[(*k, *k)].abs().max(f64::MIN_POSITIVE).sqrt()).collect();
    let part = Mat::from_fn(open.len(), open.len(), |a, b| bend[(open[a], open[b])] / (size[a] * size[b]));
    let Ok(eigen) = part.self_adjoint_eigen(Side::Lower) else { return vec![0.0; open.len()] };
    let (values, vectors) = (eigen.S().column_vector().to_owned(), eigen.U());
    let mut step = vec![0.0; open.len()];
    for e in 0..open.len() {
        let along: f64 = (0..open.len()).map(|a| vectors[(a, e)] * gradient[open[a]] / size[a]).sum();
        let by = along / values[e].abs().max(FLATTEST);
        (0..open.len()).for_each(|a| step[a] -= by * vectors[(a, e)]);
    }
    step.iter().zip(&size).map(|(x, size)| x / size).collect()
}

impl PartNoise {
    /// Adds the derivatives of `M` and of `log|V|` by the logarithms of this part's parameters.
    fn derivatives(&self, part: &Part, white: f64, sums: &mut Sums) {
        // by ln w, ln q, ln tau from those by ln w at a fixed ratio, rho and phi: d/dlnw = d/ds - d/drho
        const FIRST: [[f64; 4]; 3] = [[-1.0, -1.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
        // of the logarithm of the determinant, which has no product with ln w, one derivative with its sign
        const SECOND: [([usize; 2], [f64; 6], (f64, usize)); 6] = [
            ([0, 0], [1.0, 2.0, 0.0, 1.0, 0.0, 0.0], (1.0, 3)),
            ([0, 1], [0.0, -1.0, 0.0, -1.0, 0.0, 0.0], (-1.0, 3)),
            ([0, 2], [0.0, 0.0, -1.0, 0.0, -1.0, 0.0], (-1.0, 4)),
            ([1, 1], [0.0, 0.0, 0.0, 1.0, 0.0, 0.0], (1.0, 3)),
            ([1, 2], [0.0, 0.0, 0.0, 0.0, 1.0, 0.0], (1.0, 4)),
            ([2, 2], [0.0, 0.0, 0.0, 0.0, 0.0, 1.0], (1.0, 5)),
        ];
        let slots = [
            self.white.free(),
            self.deviation.and_then(|(q, _)| q.free()),
            self.deviation.and_then(|(_, tau)| tau.free()),
        ];
        let sum = |to: &mut Mat<f64>, weights: &[f64]| {
            for (gram, by) in part.gram.iter().zip(weights).filter(|(_, by)| **by != 0.0) {
                *to += gram * Scale(by / white);
            }
        };
        let logarithm =
            |weights: &[f64]| -> f64 { part.log_determinant.iter().zip(weights).skip(1).map(|(l, by)| l * by).sum() };
        for (slot, weights) in slots.iter().zip(&FIRST) {
            if let Some(k) = slot {
                sum(&mut sums.first[*k], weights);
                sums.log_first[*k] += logarithm(weights);
            }
        }
        if let Some(k) = slots[0] {
            sums.log_first[k] += part.rows;
        }
        for ([a, b], weights, (sign, own)) in SECOND {
            if let (Some(k), Some(h)) = (slots[a], slots[b]) {
                let (k, h) = (k.max(h), k.min(h));
                let (rows, columns) = sums.whole.shape();
                sum(sums.second[k][h].get_or_insert_with(|| Mat::zeros(rows, columns)), &weights);
                sums.log_second[k][h].iter_mut().for_each(|sum| *sum += sign * part.log_determinant[own]);
            }
        }
    }
}

/// `2 S^-1` over some components: the covariance of the estimated variances, each relative to its estimate; zero for the others.
pub(super) fn spread(s: &Mat<f64>, among: &[usize]) -> Mat<f64> {
    let mut all = Mat::zeros(s.nrows(), s.nrows());
    if among.is_empty() {
        return all;
    }
    let size = |g: usize| s[(g, g)].max(f64::MIN_POSITIVE).sqrt();
    let part =
        Mat::from_fn(among.len(), among.len(), |a, b| s[(among[a], among[b])] / (size(among[a]) * size(among[b])));
    let inverse = part.col_piv_qr().solve(Mat::<f64>::identity(among.len(), among.len()));
    for (a, g) in among.iter().enumerate() {
        for (b, h) in among.iter().enumerate() {
            all[(*g, *h)] = 2.0 * inverse[(a, b)] / (size(*g) * size(*h));
        }
    }
    all
}
