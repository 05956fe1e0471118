//! Evidence for any set of candidates: scores given the set, family-wise probabilities, and whether the remainder is only noise.
//!
//! Where the variances of what scatters are estimated a candidate is compared with the scatter in its direction, and with the degrees of
//! freedom from which that is known:
//!
//! ```text
//! g = shares of the estimated variances in a candidate's direction,   nu = 2 / (g' S g),   o(j) = nu g_j' S g / 2
//! t^2 = s^2 (nu - n) / (nu - lost - s^2),     n = 1 + sum o(j),  lost = sum o(j) step_j^2 over the effects already in
//! ```
//!
//! The variances were estimated with the candidate's own effect among what scatters; what it takes off is taken off them. For a single variance
//! that is Student's t with the residuals' own sum of squares, in a balanced design the t of each stratum. Where the variances come from a model
//! with some effects in it, those count the other way.

use super::common::NoiseFrom;
use super::noise::{Weighted, scaled_columns};
use super::pool::Pool;
use crate::elements::Elements;
use crate::linear::{dot, norm, normalise, project};
use crate::uncertainty::quantiles::{chi_square_survival, fisher_f_survival, normal_survival, student_t_two_sided};
use faer::Mat;
use std::cell::OnceCell;

/// A column whose direction is this near to the span of others is no further effect.
const DISTINCT: f64 = 1e-6;

/// All candidates against one model.
pub(super) struct Evidence {
    pub pool: Pool,
    /// Cosines of each candidate with all, orthogonalised; computed when they are first asked for.
    cosines: Vec<OnceCell<Vec<f64>>>,
    /// Distinct directions among the candidates: how many tests were made.
    pub tests: usize,
    pub rss: f64,
    pub dof: usize,
    pub from: NoiseFrom,
    /// Tests that each candidate's probability accounts for: those with columns.
    multiplicity: f64,
    basis: Mat<f64>,
    residual: Vec<f64>,
    pure: Option<Pure>,
    /// Where variances of what scatters are estimated.
    strata: Option<Strata>,
}

/// The part of everything within replicates.
struct Pure {
    columns: Mat<f64>,
    residual: Vec<f64>,
    dof: usize,
}

impl Evidence {
    pub fn new(weighted: &Weighted, columns: &[&Vec<f64>]) -> Self {
        let matrix = weighted.columns(columns.iter().copied());
        let pure = weighted.replicates.as_ref().map(|replicates| {
            // within replicates only the noise of single readings scatters
            let weight = &weighted.own_weight;
            let weigh = |column: &[f64]| column.iter().zip(weight).map(|(v, w)| v * w).collect();
            let matrix = scaled_columns(columns.iter().copied(), weight.len(), weigh);
            let mut within = Mat::zeros(matrix.nrows(), matrix.ncols());
            for j in 0..matrix.ncols() {
                let column = matrix.col_as_slice(j);
                let norm = norm(column);
                let deviations = replicates.within(column, weight);
                let size = self::norm(&deviations);
                if size > 1e-9 * norm {
                    within.col_as_slice_mut(j).iter_mut().zip(deviations).for_each(|(slot, v)| *slot = v / size);
                }
            }
            let residual: Vec<f64> = weighted.estimate.residuals.iter().zip(weight).map(|(v, w)| v * w).collect();
            let residual = replicates.within(&residual, weight);
            Pure { columns: within, residual, dof: replicates.dof }
        });
        let pool = Pool::new(matrix, weighted.estimate.factor.thin_q(), &weighted.residual);
        let tests = pool.distinct().max(1);
        let strata = Strata::new(weighted, &pool);
        Evidence {
            strata,
            tests,
            multiplicity: tests as f64,
            basis: weighted.estimate.factor.thin_q().to_owned(),
            residual: weighted.residual.clone(),
            cosines: vec![OnceCell::new(); pool.len()],
            rss: weighted.rss,
            dof: weighted.estimate.dof,
            from: weighted.from,
            pure,
            pool,
        }
    }

    /// The effects that were in the model from which the variances of what scatters come.
    pub fn found_with(&mut self, set: &[usize]) {
        // dependent columns: the set tells nothing more
        let steps = self.given(set).map(|given| given.steps).unwrap_or_default();
        if let Some(strata) = &mut self.strata {
            strata.reference = steps;
        }
    }

    /// Cosines of a candidate with all, orthogonalised; empty for one that does not exist.
    pub fn cosines(&self, index: usize) -> &[f64] {
        self.cosines.get(index).map_or(&[], |row| row.get_or_init(|| self.pool.cosines(index)))
    }

    /// Evidence given a set, `None` where its members are not independent of each other and the model.
    pub fn given(&self, set: &[usize]) -> Option<Given> {
        let k = self.pool.len();
        let mut score = self.pool.scores().to_vec();
        let mut left: Vec<f64> = self.pool.visible().iter().map(|v| f64::from(u8::from(*v > 0.0))).collect();
        let mut rss = self.rss;
        let mut basis: Vec<Vec<f64>> = Vec::with_capacity(set.len());
        let mut steps: Vec<(usize, f64)> = Vec::with_capacity(set.len());
        for &member in set {
            let size = left.get(member).copied().filter(|n| *n > DISTINCT)?.sqrt();
            let mut direction = self.cosines(member).to_vec();
            for before in &basis {
                let along = before.at(member);
                direction.iter_mut().zip(before).for_each(|(d, b)| *d -= along * b);
            }
            let step = score.at(member) / size;
            for ((d, n), s) in direction.iter_mut().zip(&mut left).zip(&mut score) {
                *d /= size;
                *n -= *d * *d;
                *s -= *d * step;
            }
            rss -= step * step;
            steps.push((member, step * step));
            basis.push(direction);
        }
        let pure = self.pure.as_ref().map(|pure| pure.given(set, k));
        for (s, n) in score.iter_mut().zip(&left) {
            *s = if *n > DISTINCT { *s / n.sqrt() } else { 0.0 };
        }
        let dof = self.dof.checked_sub(set.len())?;
        Some(Given { score, left, rss: rss.max(0.0), dof, pure, steps })
    }

    /// Sum of squares left by a set; infinite for one that is not independent.
    pub fn rss_of(&self, set: &[usize]) -> f64 {
        self.given(set).map_or(f64::INFINITY, |given| given.rss)
    }

    /// Student's t (or the normal z) of a candidate given the set, and its degrees of freedom (infinite where the noise is stated).
    pub fn t(&self, given: &Given, index: usize) -> (f64, f64) {
        let score = given.score.at(index);
        if let Some(strata) = &self.strata {
            return strata.t(given, index, score);
        }
        match (self.from, &given.pure) {
            (NoiseFrom::Stated, _) => (score, f64::INFINITY),
            (NoiseFrom::Replicates, Some((sum, dof, within))) => {
                let along = within.at(index);
                ratio(score, sum - along * along, dof.saturating_sub(usize::from(along != 0.0)))
            }
            _ => ratio(score, given.rss - score * score, given.dof.saturating_sub(1)),
        }
    }

    /// The probability of a `t` as large by chance, anywhere among all that was tried (Sidak).
    pub fn family_wise(&self, t: f64, dof: f64) -> f64 {
        of_all(by_chance(t, dof), self.multiplicity)
    }

    /// Of some candidates the one with the strongest evidence given the set: `t^2`, less what the tests cost. Its index, t and family-wise p.
    pub fn strongest_of(&self, given: &Given, wanted: impl Fn(usize) -> bool) -> Option<(usize, f64, f64)> {
        let mut best: Option<(usize, f64, f64, f64)> = None;
        for index in 0..self.pool.len() {
            if given.left.get(index).is_some_and(|n| *n > DISTINCT) && wanted(index) {
                let (t, dof) = self.t(given, index);
                let order = t * t - 2.0 * self.multiplicity.ln();
                if best.is_none_or(|(.., before)| order > before) {
                    best = Some((index, t, dof, order));
                }
            }
        }
        best.map(|(index, t, dof, _)| (index, t, self.family_wise(t, dof)))
    }

    /// The residuals outside the model and a set; `None` where they are not independent.
    pub fn residual_outside(&self, set: &[usize]) -> Option<Vec<f64>> {
        let mut directions: Vec<Vec<f64>> = Vec::with_capacity(set.len());
        let mut residual = self.residual.clone();
        for member in set {
            let mut direction = self.pool.direction(*member, self.basis.as_ref());
            (0..2).for_each(|_| project(&mut direction, &directions));
            let size = normalise(&mut direction);
            if !(size * size > DISTINCT) {
                return None;
            }
            project(&mut residual, std::slice::from_ref(&direction));
            directions.push(direction);
        }
        Some(residual)
    }

    /// Probability of residuals as large as these if the model with the set were complete; `None` where only they tell the noise. Replicates have the
    /// scatter that they have with all that is found in the model: what changes from one to the next (a temperature) is no noise.
    pub fn global(&self, given: &Given, found: &Given) -> Option<f64> {
        match (self.from, &found.pure) {
            (NoiseFrom::Stated, _) if given.dof > 0 => chi_square_survival(given.rss, given.dof as f64),
            (NoiseFrom::Replicates, Some((sum, dof, _))) if *dof > 0 && *sum > 0.0 => {
                let between = given.dof.checked_sub(*dof).filter(|d| *d > 0)? as f64;
                fisher_f_survival((given.rss - sum).max(0.0) / between / (sum / *dof as f64), between, *dof as f64)
            }
            _ => None,
        }
    }
}

/// The probability of a `t` as large by chance in one test; the noise is known where the degrees of freedom are infinite.
pub(super) fn by_chance(t: f64, dof: f64) -> f64 {
    let alone = if dof.is_finite() {
        if dof < 1.0 { Some(1.0) } else { student_t_two_sided(t.abs(), dof) }
    } else {
        normal_survival(t.abs()).map(|p| 2.0 * p)
    };
    // not testable: not significant
    alone.unwrap_or(1.0).clamp(0.0, 1.0)
}

/// The same of so many tests, any of which may show it (Sidak).
pub(super) fn of_all(alone: f64, tests: f64) -> f64 {
    -f64::exp_m1(tests * f64::ln_1p(-alone))
}

/// `score / sqrt(sum / dof)`; no degrees of freedom, no evidence.
fn ratio(score: f64, sum: f64, dof: usize) -> (f64, f64) {
    if dof == 0 {
        return (0.0, 0.0);
    }
    let floor = 1e-24 * score * score;
    (score / (sum.max(floor) / dof as f64).sqrt().max(f64::MIN_POSITIVE), dof as f64)
}

impl Pure {
    /// Sum of squares and degrees of freedom within replicates given a set, and the score of each candidate there.
    fn given(&self, set: &[usize], k: usize) -> (f64, usize, Vec<f64>) {
        let mut residual = self.residual.clone();
        let mut basis: Vec<Vec<f64>> = Vec::new();
        for &member in set.iter().filter(|j| **j < self.columns.ncols()) {
            let mut direction = self.columns.col_as_slice(member).to_vec();
            project(&mut direction, &basis);
            if normalise(&mut direction) < 1e-6 {
                continue;
            }
            project(&mut residual, std::slice::from_ref(&direction));
            basis.push(direction);
        }
        let score = (0..k.min(self.columns.ncols())).map(|j| dot(self.columns.col_as_slice(j), &residual)).collect();
        (dot(&residual, &residual), self.dof.saturating_sub(basis.len()), score)
    }
}

/// What is left of a stratum is not taken for less than the noise of the readings in it, nor than this.
const LEAST: f64 = 1e-3;

/// Everything given that some candidates are in the model.
pub(super) struct Given {
    /// Score of each candidate; its square is the further drop of the sum of squares.
    pub score: Vec<f64>,
    /// Squared sine of each candidate with the set.
    pub left: Vec<f64>,
    pub rss: f64,
    pub dof: usize,
    pure: Option<(f64, usize, Vec<f64>)>,
    /// The members, and what each takes off the sum of squares in this order.
    steps: Vec<(usize, f64)>,
}

/// The estimated variances, as candidates feel them.
struct Strata {
    /// Of each candidate.
    shares: Vec<Vec<f64>>,
    /// Share of the noise of single readings in each candidate's direction.
    noise: Vec<f64>,
    spread: Mat<f64>,
    /// Effects in the model from which the variances come.
    reference: Vec<(usize, f64)>,
}

impl Strata {
    /// `None` where every variance is stated.
    fn new(weighted: &Weighted, pool: &Pool) -> Option<Self> {
        let floor = weighted.floor.as_ref().filter(|floor| floor.spread().nrows() > 0)?;
        let q = weighted.estimate.factor.thin_q();
        let shares_of = |j: usize| match pool.visible().get(j) {
            Some(visible) if *visible > 0.0 => floor.shares(&pool.direction(j, q)),
            _ => Vec::new(),
        };
        let shares: Vec<Vec<f64>> = (0..pool.len()).map(shares_of).collect();
        let of_lines = |shares: &Vec<f64>| shares.iter().skip(floor.groups()).sum::<f64>();
        Some(Strata {
            noise: shares.iter().map(|shares| (1.0 - of_lines(shares)).clamp(LEAST, 1.0)).collect(),
            shares,
            spread: floor.spread().clone(),
            reference: Vec::new(),
        })
    }

    /// `g_a' S g_b`.
    fn product(&self, a: usize, b: usize) -> f64 {
        let (Some(shares), Some(other)) = (self.shares.get(a), self.shares.get(b)) else { return 0.0 };
        let mut sum = 0.0;
        for (k, x) in shares.iter().enumerate() {
            for (l, y) in other.iter().enumerate() {
                sum += x * self.spread[(k, l)] * y;
            }
        }
        sum
    }

    /// Student's t and its degrees of freedom, from the sum of squares and degrees of freedom of what scatters in a candidate's direction, given some
    /// effects; where that is all stated these are infinite.
    fn t(&self, given: &Given, index: usize, score: f64) -> (f64, f64) {
        let square = self.product(index, index);
        if !(square > 1e-9) {
            return (score, f64::INFINITY);
        }
        let nu = 2.0 / square;
        let overlap = |j: usize| (nu * 0.5 * self.product(j, index)).clamp(0.0, 1.0);
        let (mut sum, mut dof) = (nu, nu);
        for (step, sign) in given.steps.iter().map(|s| (s, -1.0)).chain(self.reference.iter().map(|s| (s, 1.0))) {
            let part = sign * overlap(step.0);
            sum += part * step.1;
            dof += part;
        }
        let (sum, dof) = (sum.max(self.noise.at(index) * dof), dof - 1.0);
        if dof < 1.0 {
            return (0.0, 0.0);
        }
        let remainder = (sum - score * score).max(self.noise.at(index) * dof);
        (score / (remainder / dof).sqrt(), dof)
    }
}
