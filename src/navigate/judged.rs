//! The posterior of sets of causes, and of what none of them explains, on the linear model at a state: the score of campaigns (`diagnosis`).

use super::bank::{bank, matrix};
use super::cause::{Cause, Change};
use super::products::{INDEPENDENT, Products, Solved};
use super::refine::{Search, State};
use crate::diagnosis::{Class, Deviations, Kernel, NoiseFrom, Posterior, Priors, Problem, Score};
use crate::linear::orthonormal;
use faer::Mat;
use faer::linalg::solvers::Solve;

/// Sizes of effects and remainders from one standard deviation to so many, at least.
const LARGEST: f64 = 1e3;

/// The largest size of what explains a residual: no single value of it has more.
pub(super) fn largest(residual: &[f64]) -> f64 {
    residual.iter().fold(LARGEST, |most, v| most.max(v.abs()))
}

/// The linear model of all causes at a state.
pub(super) struct Linear {
    pub causes: Vec<Cause>,
    pub products: Products,
    pub norms: Vec<f64>,
}

impl Linear {
    /// The values, SI, of a set that was solved in columns of unit norm.
    pub fn values(&self, set: &[usize], solved: &Solved) -> Vec<f64> {
        let sized = |(j, x): (&usize, &f64)| self.norms.get(*j).map_or(0.0, |norm| x / norm);
        set.iter().zip(&solved.values).map(sized).collect()
    }

    /// The share of the residual sum of squares of a set that more causes would remove; columns that depend on those of the set remove nothing.
    pub fn share_of(&self, set: &[usize], more: &[usize]) -> f64 {
        let with: Vec<usize> = set.iter().chain(more).copied().collect();
        let rss = |set: &[usize]| self.products.solve(set).map(|solved| solved.rss);
        rss(&with).zip(rss(set)).map_or(0.0, |(with, set)| 1.0 - with / set.max(f64::MIN_POSITIVE))
    }

    pub fn places(&self, set: &[Cause]) -> Vec<usize> {
        set.iter().filter_map(|cause| self.causes.iter().position(|other| other == cause)).collect()
    }
}

/// What is probable at a state.
pub(super) struct Judged {
    score: Score,
    pub posterior: Posterior,
    kernels: Vec<Kernel>,
    /// Columns of all causes, of unit norm.
    columns: Mat<f64>,
}

/// ln odds of each cause but for what all share: a nat for a penalty of two variances; steps, warm-ups and waves of one bias or channel share the odds
/// of one.
fn odds(causes: &[Cause], rank_penalty: f64, rows: usize) -> Vec<f64> {
    let frequencies = rows.div_ceil(2) as f64;
    let count = |cause: &Cause| match cause.change() {
        // one of as many frequencies as these rows resolve
        Some(Change::Wave { .. }) => frequencies,
        // and two edges between the phases of the rows, which are all different where a period is no multiple of their spacing
        Some(Change::Square { .. }) => frequencies * 0.5 * rows as f64 * rows.saturating_sub(1).max(1) as f64,
        _ => causes.iter().filter(|other| other.family() == cause.family()).count() as f64,
    };
    causes.iter().map(|cause| -count(cause).max(1.0).ln() - 0.5 * rank_penalty * cause.rank()).collect()
}

/// The alternatives with which a set is compared.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Among {
    /// None: only the probability density of the set itself is computed.
    None,
    /// Sets of so many causes at most; what they leave is noise alone.
    Sets(usize),
    /// All sets, and remainders that none of them explains.
    Remainders,
}

impl Search<'_> {
    /// The posterior at a state.
    pub(super) fn judge(&self, linear: &Linear, state: &State, among: Among) -> Judged {
        let (case, settings) = (&self.case, &self.case.settings);
        let residual = &linear.products.residual[..];
        let columns = matrix(residual.len(), &linear.products.columns);
        let whole = among != Among::Remainders;
        let rows = self.weighed(&state.out);
        let kernels = match whole {
            true => Vec::new(),
            false => {
                let residual = rows.rows([&case.residual(&state.flown.predicted)].into_iter());
                residual.first().map_or_else(Vec::new, |residual| bank(&rows, residual))
            }
        };
        let most = if let Among::Sets(most) = among { most } else { settings.causes };
        let priors = Priors {
            most: most.max(state.set.len()),
            largest: largest(residual),
            ..Priors::at(settings.common.significance)
        };
        // of each its largest plausible size, as a coefficient of its unit column
        let sizes = linear.causes.iter().zip(&linear.norms).map(|(cause, norm)| cause.limit() * norm);
        let absurd: Vec<f64> = sizes.map(|size| if size > 0.0 { size } else { f64::INFINITY }).collect();
        let log_odds = odds(&linear.causes, settings.rank_penalty, case.measured.longest_run());
        let share = |j: usize| priors.share_below(absurd.get(j).copied().unwrap_or(f64::INFINITY));
        // times, periods and phases are fitted anew with every set that the search looks at: at those of the present one another set would explain too little.
        // What is probable in the end is asked without: along its time a warm-up is nearly explained by itself
        let is_search = matches!(among, Among::Sets(_));
        let mut moves = if is_search { self.moves(&state.set, &rows.made) } else { Vec::new() };
        rows.weigh(&mut moves);
        let basis = matrix(residual.len(), &orthonormal(moves, INDEPENDENT));
        let problem = Problem {
            residual,
            basis: basis.as_ref(),
            columns: columns.as_ref(),
            prior: &priors.shared(log_odds, share),
            plain: &absurd,
            fixed: &[],
            kinds: &[],
            // where something is unexplained, the noise itself may be larger than stated
            known: whole && case.from == NoiseFrom::Stated,
            kernels: &kernels,
            sharing: None,
        };
        let mut score = Score::new(&problem, priors);
        let of = |cause: &Cause| linear.causes.iter().position(|other| other == cause).and_then(|j| score.standing(j));
        let start: Vec<u16> = state.set.iter().filter_map(of).collect();
        if among != Among::None {
            score.search(&[start]);
        }
        let posterior = score.posterior();
        Judged { score, posterior, kernels, columns }
    }
}

impl Judged {
    /// The most probable set; of causes with the same column those that are in the present set, or else the most probable.
    pub(super) fn best(&self, now: &[usize]) -> Vec<usize> {
        let Some((_, set)) = self.posterior.sets.first() else { return now.to_vec() };
        let one = |j: &u16| {
            let alike = self.score.alike.get(usize::from(*j)).into_iter().flatten().map(|j| usize::from(*j));
            alike.into_iter().find(|j| now.contains(j)).unwrap_or_else(|| usize::from(*j))
        };
        set.iter().map(one).collect()
    }

    /// ln p of a set.
    pub(super) fn value(&mut self, set: &[usize]) -> f64 {
        let standing: Option<Vec<u16>> = set.iter().map(|j| self.score.standing(*j)).collect();
        standing.map_or(f64::NEG_INFINITY, |set| self.score.of(&set))
    }

    /// Causes with at least this probability that the cause, or one that cannot be distinguished from it, is present: of each class the most probable,
    /// the first of the catalogue among those that are nearly as probable. Classes with a member in a set are left out.
    pub(super) fn likely(&self, least: f64, beside: &[usize]) -> Vec<(usize, f64)> {
        let is_known = |class: &Class| class.members.iter().any(|m| beside.contains(&m.candidate));
        let likely = self.posterior.classes.iter().filter(|class| class.probability >= least && !is_known(class));
        let front = |class: &Class| class.front(f64::INFINITY, |_| true, |a, b| a.cmp(&b));
        likely.filter_map(|class| Some((front(class)?.candidate, class.probability))).collect()
    }

    /// Probability that a cause, or one that cannot be distinguished from it, is present.
    pub(super) fn probability(&self, index: usize) -> f64 {
        let holds = |class: &&Class| class.members.iter().any(|m| m.candidate == index);
        let class = self.posterior.classes.iter().filter(holds).map(|class| class.probability).fold(0.0, f64::max);
        let number = self.score.standing(index);
        let sets = self.posterior.sets.iter().filter(|(_, set)| number.is_some_and(|number| set.contains(&number)));
        let sum: f64 = sets.map(|(p, _)| p).sum();
        class.max(sum).min(1.0)
    }

    /// Variance of the least-squares coefficient of each member of a set under the covariance `V` of noise and remainder, less that of the noise alone:
    /// `l = C (C'C)^-1 e_j`, `E[l'V l] - l'l`.
    pub(super) fn beyond_noise(&mut self, set: &[usize]) -> Vec<f64> {
        let standing: Vec<u16> = set.iter().filter_map(|j| self.score.standing(*j)).collect();
        let each = self.score.deviations(&standing);
        let deviations = Deviations { each, kernels: std::mem::take(&mut self.kernels) };
        let chosen = Mat::from_fn(self.columns.nrows(), set.len(), |i, k| {
            // a set has columns of the model
            set.get(k).filter(|j| **j < self.columns.ncols()).map_or(0.0, |j| self.columns[(i, *j)])
        });
        let gram = chosen.transpose() * &chosen;
        let inverse = gram.partial_piv_lu().solve(&Mat::<f64>::identity(set.len(), set.len()));
        let combinations = &chosen * inverse;
        let extra = |k: usize| {
            let combination = combinations.col_as_slice(k);
            let white: f64 = combination.iter().map(|l| l * l).sum();
            (deviations.variance_of(combination) - white).max(0.0)
        };
        let variances = (0..set.len()).map(extra).collect();
        self.kernels = deviations.kernels;
        variances
    }
}
