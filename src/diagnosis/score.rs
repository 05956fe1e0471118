//! Posterior over (set of effects) x (kernel and size of a remainder).
//!
//! ```text
//! V = s^2 (I + t^2 K),  beta_j and t with density 1/(L |.|): all sizes are drawn alike.
//! known:   ln p = -1/2 ln|V| - 1/2 q_S + sum_j [1/2 ln 2pi - ln(2 L |beta_j|)] - 1/2 ln|G_S|
//! unknown: ln p = -1/2 ln|V| + ln Gamma((nu-k)/2) - (nu-k)/2 ln q_S + sum_j [1/2 ln pi - ln(2 L |beta_j|)] - 1/2 ln|G_S|
//! ```

#![allow(
    clippy::indexing_slicing,
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a dense kernel: lengths are those of the columns that `Score::new` is given, which are no more than a u16 counts"
)]

use super::factor::{Apart, Factor, Reach};
use crate::linear::{Triangle, dot as product};
use crate::mix::Mix;
use crate::number::log_sum;
use crate::uncertainty::quantiles::ln_gamma;
use faer::{Mat, MatRef, Side};
use std::cell::{OnceCell, RefCell};
use std::cmp::Ordering;
use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::hash::BuildHasherDefault;
use std::ops::Range;
use std::rc::Rc;

/// Effects that are expected in addition to another where anything is missing: one finding in four has a second one.
const EXPECTED: f64 = 0.25;
/// Odds of any effect against nothing, for each hundredth of significance a third.
const FIRST: f64 = 30.0;
/// Probability of something outside the catalogue where anything is missing. The catalogue has what happens to instruments: that none of it
/// is the cause is rare. A remainder needs one of the bank's kernels and a size, each effect a term of the catalogue and a size.
const OUTSIDE: f64 = 0.03;
/// The same of the many that grow (6e-6): they are only looked through.
const GROWN: f64 = 12.0;
/// Most members of a set of one sensor, and in each of several sensors: they bound the work. Three effects at once are what is to be found; of one sensor twice as many,
/// since what is outside the catalogue may take several.
const EACH: usize = 6;
const IN_EACH_OF_SEVERAL: usize = 3;
/// Sets of each length that grow side by side where nothing but effects is there: they bound the work. A choice; with more the time grows in proportion.
const BEAM: usize = 24;
/// Neighbours of a set that are followed: their values are approximate, so that the best by them need not be the best; it bounds the work.
const FOLLOWED: usize = 3;
/// Most sets whose neighbours are looked at after the search.
const SPREAD: usize = 100;

/// Logarithm of the odds by which explanations may differ that stand in each other's place: ln 90, so that of two the less probable has 1 %, what may be
/// reported where nothing is missing.
pub(crate) const ALIAS: f64 = 4.5;
/// What one rank of the catalogue takes off the logarithm of the odds. A choice: five ranks are a factor e, less than the 3 of a bare mention, so that
/// common causes stand first only where the readings do not decide.
pub(crate) const RANK: f64 = 0.2;
/// Fewest directions of a remainder: of fewer it is an effect in all but name. A choice: more than the three effects at once that are to be found, and one to spare.
const LEAST_RANK: usize = 5;
/// Sets that are less probable than the best by more than this (ln, 1e-11) are not kept: all of them together change no probability.
const KEPT: f64 = 25.0;
/// Columns with a smaller cosine, given the model and the other effects, are different explanations of what is hardly seen.
const ALIKE: f64 = 0.5;
/// Logarithm of the odds of a place against none from which what explains it as well is the same explanation, whatever the cosine here: each set
/// may be judged at another point. Of two columns with the cosine c one has c^2 of what the other explains.
const PLAIN: f64 = 12.0;
/// Columns with a larger cosine differ by what another small effect makes up: with it they stand in each other's place.
const NEARLY: f64 = 0.95;
/// Share of a set's probability below which a kernel is left out where the set is judged at its solution.
const NEGLIGIBLE: f64 = 1e-3;
/// Members of a class are as probable as the best but for this factor: their prior odds decide which one represents them. Smaller odds are not worth
/// more than a bare mention (H. Jeffreys, Theory of Probability, app. B; R. Kass, A. Raftery, JASA 90 (1995), 777).
const NEAR: f64 = 3.0;
/// Odds and probabilities of members of a class that differ by a smaller share are equal.
const EQUAL: f64 = 1e-6;
/// Most sets whose members are reported as classes.
const TOLD: usize = 8;

/// A column is invisible when less than this share of its norm is left outside the model.
pub(crate) const VISIBLE: f64 = 1e-6;

/// What is believed before the readings are seen.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Priors {
    /// Sizes, in noise standard deviations, from one to which each is as probable as any other of its logarithm: of effects and of remainders.
    pub largest: f64,
    /// Odds of all effects together against nothing: a campaign is as its model says, or it is not, and then what is missing need not be one thing.
    pub first: f64,
    /// Most effects of a set.
    pub most: usize,
    /// Are kernels kept that do nearly what another does? Of a bank the first stands for all.
    pub all_kernels: bool,
}

impl Priors {
    /// With the odds at which nothing is reported in so many of the campaigns in which nothing is missing.
    pub fn at(significance: f64) -> Self {
        Priors { largest: 1e3, first: FIRST * significance, most: EACH, all_kernels: false }
    }

    /// For readings of so many sensors: an effect in several of them is a member for each.
    pub fn for_sensors(self, sensors: usize) -> Self {
        Priors { most: EACH.max(IN_EACH_OF_SEVERAL * sensors), ..self }
    }

    pub fn range(&self) -> f64 {
        self.largest.ln()
    }

    /// The share of the range of sizes that a density `1 / (|b| (1 + |b| / size))` has left, of that which all sizes have alike.
    pub fn share_below(&self, size: f64) -> f64 {
        ((1.0 + size).ln() / self.range()).min(1.0)
    }

    /// ln odds of candidates from what each has by itself (ln): so many are expected in all where anything is missing, each counted with its share of sizes.
    pub fn shared(&self, each: Vec<f64>, share: impl Fn(usize) -> f64) -> Vec<f64> {
        let all: f64 = each.iter().enumerate().map(|(j, odds)| odds.exp() * share(j)).sum();
        each.into_iter().map(|odds| odds + (EXPECTED / all.max(f64::MIN_POSITIVE)).ln()).collect()
    }

    /// ln of what nothing has over the odds of what is missing.
    pub fn nothing(&self) -> f64 {
        (EXPECTED / self.first).ln()
    }

    /// `|t|` of an effect that nothing but chance competes with, the noise being known, from which it is there with this probability:
    /// `t^2 / 2 - ln t = c`.
    pub fn threshold(&self, probability: f64) -> f64 {
        let c = (probability / (1.0 - probability)).ln() + (2.0 * self.range()).ln() - 0.5 * std::f64::consts::TAU.ln()
            + self.nothing()
            - EXPECTED.ln();
        (0..20).fold(5.0_f64, |t, _| (2.0 * (c + t.max(1.0).ln())).max(1.0).sqrt())
    }
}

/// A kernel `F F'`, rows of the weighted system.
#[derive(Clone)]
pub(crate) struct Kernel {
    /// What readings share that deviate alike; nothing where each deviates by itself.
    pub follows: Option<String>,
    /// Is that the position, so that each mounting deviates by itself?
    pub per_mounting: bool,
    /// Of so many kernels of one kind, which share its probability, it is one.
    pub one_of: usize,
    pub factor: Factor,
    /// The one of several sensors (or channels) that deviates alone.
    pub sensor: Option<usize>,
}

impl Kernel {
    /// Its share of the probability of its kind.
    pub fn share(&self) -> f64 {
        1.0 / self.one_of.max(1) as f64
    }
}

pub(crate) struct Problem<'a> {
    pub residual: &'a [f64],
    pub basis: MatRef<'a, f64>,
    pub columns: MatRef<'a, f64>,
    /// ln odds of each candidate.
    pub prior: &'a [f64],
    /// Coefficient of each column from which it is the less probable the larger it is.
    pub plain: &'a [f64],
    /// The coefficient of a column that has no other: two readings exchanged. Nothing where all sizes are possible; may be shorter.
    pub fixed: &'a [Option<f64>],
    /// Of each column that several sensors may have, the number of its kind, and of how many sensors; may be shorter.
    pub kinds: &'a [Option<(u16, u16)>],
    pub known: bool,
    pub kernels: &'a [Kernel],
    /// So many share the probability of a remainder; those that are not here have next to none.
    pub sharing: Option<f64>,
}

struct Prepared {
    /// The kernel of the bank that it is; nothing for none.
    place: Option<usize>,
    /// Its share of the probability of its kind.
    share: f64,
    lambda: Vec<f64>,
    along_z: Vec<f64>,
    along_c: Rc<Mat<f64>>,
    /// The same of the model's basis, where its directions are not projected.
    along_q: Option<Mat<f64>>,
    sizes: OnceCell<Sizes>,
}

/// Sufficient statistics in the space that the model leaves.
pub(crate) struct Score {
    settings: Priors,
    known: bool,
    nu: f64,
    zz: f64,
    /// ln odds of all that have one column.
    pub prior: Vec<f64>,
    /// What is believed of the size of each of these.
    beliefs: Vec<Vec<Belief>>,
    /// The kinds of these that several sensors may have.
    kinds: Vec<Vec<(u16, u16)>>,
    /// For each column what [`Score::alike_kinds`] says of it.
    alike_kinds: Vec<OnceCell<BTreeMap<u16, u16>>>,
    /// projected columns, unit norm
    c: Rc<Mat<f64>>,
    pub visible: Vec<f64>,
    /// Candidates with the same column, by the one that represents them.
    pub alike: Vec<Vec<u16>>,
    norm: Vec<f64>,
    b: Vec<f64>,
    kernels: Vec<Prepared>,
    /// So many kinds share the probability of a remainder.
    pub sharing: f64,
    gram: Vec<OnceCell<Rc<[f64]>>>,
    /// Remainders of one kernel that were made, each with its columns: many sets have the same best size.
    made: Vec<Rc<GivenRemainder>>,
    /// The others of the last cosine, and the inverse of their Gram matrix.
    given: RefCell<(Vec<u16>, Option<Vec<Vec<f64>>>)>,
    visited: Vec<Visited>,
    /// The place of each set among these.
    places: HashMap<Rc<[u16]>, usize, BuildHasherDefault<Mix>>,
    /// Sets, by place, that were nearly as probable as the best when they were visited, each with its kernel.
    near: Vec<(u16, usize)>,
    /// Of each kernel and set whose integral over t was made that integral, without the prior of the kernel, and the place of the best t.
    integrated: BTreeMap<(u16, Rc<[u16]>), (f64, usize)>,
    /// Sets whose neighbours were looked at, each with the best of these: many starts lead to the same sets.
    expanded: BTreeMap<(u16, Rc<[u16]>), Vec<(f64, Vec<u16>)>>,
    /// Sets that have their evidence at their solution.
    overruled: BTreeSet<Vec<u16>>,
    pub best: f64,
}

/// A set that was visited, in order, and ln p with each kernel that it was visited with.
struct Visited {
    set: Rc<[u16]>,
    /// Most sets are visited with one kernel.
    first: Valued,
    others: Vec<Valued>,
}

impl Visited {
    fn each(&self) -> impl Iterator<Item = &Valued> {
        std::iter::once(&self.first).chain(&self.others)
    }
}

/// ln p with one kernel.
struct Valued {
    kernel: u16,
    /// Is it more than an approximation at the size that another set has?
    is_settled: bool,
    value: f64,
}

/// What is believed of the size of a candidate, in the units of its projected column of unit norm.
#[derive(Clone, Copy)]
struct Belief {
    /// Its odds.
    odds: f64,
    /// One over the size from which it is the less probable the larger it is.
    absurd: f64,
    /// Its size, where it has only one.
    fixed: Option<f64>,
}

impl Belief {
    /// Its odds at a size.
    fn at(&self, size: f64) -> f64 {
        self.odds / (1.0 + size.abs() * self.absurd)
    }

    /// The odds times `2 L` of the density of sizes, `1/|b|`, where it is estimated with a variance; where only one is possible, of that the normal density.
    fn density(&self, size: f64, variance: f64, range: f64) -> f64 {
        match self.fixed {
            None => {
                let root_mean_square = (size * size + variance).sqrt();
                self.odds / (root_mean_square * (1.0 + root_mean_square * self.absurd))
            }
            Some(fixed) => {
                let exponent = -0.5 * (size - fixed).powi(2) / variance;
                2.0 * range * self.odds * exponent.exp() / (std::f64::consts::TAU * variance).sqrt()
            }
        }
    }
}

/// A set, of each column the part along each of its members (one member after the other), and what is left of it and of its product with the readings.
#[derive(Clone)]
struct Further {
    state: State,
    h: Vec<f64>,
    left: Vec<(f64, f64)>,
}

/// A product of many factors by one logarithm for all that cannot leave the range of numbers together.
struct Product {
    ln: f64,
    rest: f64,
}

impl Product {
    fn of(first: f64) -> Self {
        Product { ln: 0.0, rest: first }
    }

    fn times(&mut self, factor: f64) {
        // a double reaches from 1e-308 to 1e308: with a factor that is no further from one than this, the product does not leave it
        if !(self.rest > 1e-100 && self.rest < 1e100) {
            self.ln += self.rest.ln();
            self.rest = 1.0;
        }
        self.rest *= factor;
    }

    fn ln(&self) -> f64 {
        self.ln + self.rest.ln()
    }
}

/// A column that may be enough to be kept with a set: its size, what is left of it, the variance of unit weight with it, and its ln p, what is believed of sizes apart.
struct Enough {
    j: usize,
    size: f64,
    d: f64,
    s2: f64,
    value: f64,
    believed: Product,
}

#[derive(Clone)]
struct State {
    set: Vec<u16>,
    g: Vec<Rc<[f64]>>,
    inverse: Vec<f64>,
    beta: Vec<f64>,
    q: f64,
    logdet: f64,
    value: f64,
}

/// A kernel at the place of one of its sizes; by default none.
#[derive(Clone, Copy, Default)]
pub(crate) struct Remainder {
    kernel: usize,
    place: usize,
}

/// A set with one remainder of one size: ln p, its sizes and their t, and the sum of squares that is left.
pub(crate) struct Solved {
    value: f64,
    sizes: Vec<f64>,
    pub t: Vec<f64>,
    pub squares: f64,
}

/// What all sets share of one kernel: its sizes, and of each direction (row) at each of them `s = t^2 l/(1 + t^2 l)`.
struct Sizes {
    t: Vec<f64>,
    shrink: Mat<f64>,
    each: Vec<AtSize>,
}

/// One remainder of one size: what the model takes of its directions where they are not projected, `z' V^-1 z` and `ln|V|`.
struct AtSize {
    reach: Option<Reach>,
    of_z: Vec<f64>,
    q: f64,
    logdet: f64,
}

impl AtSize {
    fn taken(&self, along: &[f64]) -> Vec<f64> {
        self.reach.as_ref().map_or_else(Vec::new, |reach| reach.of(along))
    }
}

/// All columns given one remainder of one size: `c_j' V^-1 z` and `c_j' V^-1 c_j`.
struct GivenRemainder {
    kernel: usize,
    place: usize,
    q: f64,
    logdet: f64,
    b: Vec<f64>,
    d: Vec<f64>,
    /// Of each column, what the model takes.
    taken: Vec<Vec<f64>>,
    /// `c_j' V^-1 c_m` for all j, of each m that was in a set.
    columns: RefCell<BTreeMap<usize, Rc<[f64]>>>,
}

/// Eigenvalues of a Gram matrix and its eigenvectors; no vectors where it is diagonal.
fn principal(gram: &Mat<f64>) -> Option<(Vec<f64>, Option<Mat<f64>>)> {
    let k = gram.ncols();
    let diagonal: Vec<f64> = (0..k).map(|i| gram[(i, i)]).collect();
    let is_zero = |i: usize, j: usize| gram[(i, j)].abs() <= 1e-12 * (diagonal[i] * diagonal[j]).sqrt();
    if (0..k).all(|j| (0..j).all(|i| is_zero(i, j))) {
        return Some((diagonal, None));
    }
    let eigen = gram.self_adjoint_eigen(Side::Lower).ok()?;
    Some((eigen.S().column_vector().iter().copied().collect(), Some(eigen.U().to_owned())))
}

fn project(basis: MatRef<'_, f64>, m: &mut Mat<f64>) {
    for _ in 0..2 {
        let a = basis.transpose() * &*m;
        *m -= basis * a;
    }
}

impl Score {
    pub fn new(p: &Problem<'_>, settings: Priors) -> Self {
        let (n, k) = (p.residual.len(), p.columns.ncols());
        let mut c = p.columns.to_owned();
        let before: Vec<f64> = (0..k).map(|j| c.col(j).norm_l2()).collect();
        project(p.basis, &mut c);
        let mut visible = vec![0.0; k];
        let mut plain = vec![f64::INFINITY; k];
        let mut fixed = vec![None; k];
        for j in 0..k {
            let projected_norm = c.col(j).norm_l2();
            visible[j] = if before[j] > 0.0 { projected_norm / before[j] } else { 0.0 };
            let scale = if projected_norm > 0.0 && visible[j] > VISIBLE { 1.0 / projected_norm } else { 0.0 };
            if scale == 0.0 {
                visible[j] = 0.0;
            }
            plain[j] = p.plain[j] * projected_norm;
            fixed[j] = p.fixed.get(j).copied().flatten().map(|size| size * projected_norm);
            c.col_mut(j).iter_mut().for_each(|v| *v *= scale);
        }
        let c = Rc::new(c);
        let mut z = Mat::from_fn(n, 1, |i, _| p.residual[i]);
        project(p.basis, &mut z);
        let dot = |x: faer::ColRef<'_, f64>, y: faer::ColRef<'_, f64>| -> f64 {
            x.iter().zip(y.iter()).map(|(a, b)| a * b).sum()
        };
        let zz = dot(z.col(0), z.col(0));
        let b: Vec<f64> = (0..k).map(|j| dot(c.col(j), z.col(0))).collect();
        let none = Rc::new(Mat::zeros(0, k));
        let (lambda, along_z) = (vec![], vec![]);
        let (sizes, along_q) = (OnceCell::new(), None);
        let mut kernels = vec![Prepared { place: None, share: 0.0, lambda, along_z, along_c: none, along_q, sizes }];
        // what it does to a few vectors tells kernels that are alike
        let mut trial = Mat::from_fn(n, 8, |i, v| (12.9898 * (i + 1) as f64 * (v as f64 + 1.7)).sin());
        project(p.basis, &mut trial);
        let mut factors = vec![];
        for (place, kernel) in p.kernels.iter().enumerate() {
            // directions in which it deviates by less than a fifth of its largest are neglected: a choice
            let is_wide = |s: &[f64]| {
                let top = s.iter().fold(0.0_f64, |a, b| a.max(*b));
                s.iter().filter(|l| **l > 0.05 * top).count() >= LEAST_RANK
            };
            let (lambda, along_z, along_c, along_q, does) = match &kernel.factor {
                Factor::Dense(factor) => {
                    let mut f = factor.clone();
                    project(p.basis, &mut f);
                    let Some((s, turn)) = principal(&(f.transpose() * &f)).filter(|(s, _)| is_wide(s)) else {
                        continue;
                    };
                    let top = s.iter().fold(0.0_f64, |a, b| a.max(*b));
                    let keep: Vec<usize> = (0..s.len()).filter(|i| s[*i] > 1e-7 * top && s[*i] > 1e-12).collect();
                    let turned =
                        |i: usize, j: usize| turn.as_ref().map_or(0.0, |turn| turn[(i, keep[j])]) / s[keep[j]].sqrt();
                    let u = match turn {
                        Some(_) => &f * Mat::from_fn(s.len(), keep.len(), turned),
                        None => Mat::from_fn(n, keep.len(), |i, j| f[(i, keep[j])] / s[keep[j]].sqrt()),
                    };
                    let along_z: Vec<f64> = (0..keep.len()).map(|j| dot(u.col(j), z.col(0))).collect();
                    let along_c = Rc::new(u.transpose() * &*c);
                    let lambda = keep.iter().map(|i| s[*i]).collect();
                    (lambda, along_z, along_c, None, &f * (f.transpose() * &trial))
                }
                Factor::Apart(columns) => {
                    let apart = Apart::new(columns, n);
                    let lambda = apart.eigenvalues();
                    if !is_wide(&lambda) {
                        continue;
                    }
                    let along_c = if apart.is_single() { Rc::clone(&c) } else { Rc::new(apart.along((*c).as_ref())) };
                    let along_z = apart.along(z.as_ref()).col_as_slice(0).to_vec();
                    let along_q = Some(apart.along(p.basis));
                    let mut does = apart.twice(trial.as_ref());
                    project(p.basis, &mut does);
                    (lambda, along_z, along_c, along_q, does)
                }
            };
            let size = does.norm_l2();
            let same = |other: &Mat<f64>| {
                let inner: f64 = (0..8).map(|v| dot(does.col(v), other.col(v))).sum();
                // kernels that do the same to a few vectors, to 3 %, are one: a choice that bounds the bank
                inner > 0.97 * size * other.norm_l2()
            };
            if !settings.all_kernels && factors.iter().any(same) {
                continue;
            }
            factors.push(does);
            let (place, share, sizes) = (Some(place), kernel.share(), OnceCell::new());
            kernels.push(Prepared { place, share, lambda, along_z, along_c, along_q, sizes });
        }
        let nu = (n - p.basis.ncols().min(n)) as f64;
        let mut norm: Vec<f64> = (0..k).map(|j| if visible[j] > 0.0 { 1.0 } else { 0.0 }).collect();
        // one column for those that are the same: the first of the most probable represents all
        let mut order: Vec<usize> = (0..k).filter(|j| norm[*j] > 0.0).collect();
        order.sort_by(|x, y| b[*x].abs().total_cmp(&b[*y].abs()));
        let mut alike: Vec<Vec<u16>> = vec![vec![]; k];
        let mut prior = p.prior.to_vec();
        let mut beliefs: Vec<Vec<Belief>> = vec![vec![]; k];
        let mut kinds: Vec<Vec<(u16, u16)>> = vec![vec![]; k];
        let mut taken = vec![false; k];
        for (n, &j) in order.iter().enumerate() {
            if taken[j] {
                continue;
            }
            let mut group = vec![j];
            for &i in order[n + 1..].iter() {
                if b[i].abs() - b[j].abs() > 1e-7 * zz.sqrt() {
                    break;
                }
                let cosine = dot(c.col(i), c.col(j));
                if !taken[i] && cosine.abs() > 1.0 - 1e-9 {
                    fixed[i] = fixed[i].map(|size| size * cosine.signum());
                    group.push(i);
                }
            }
            group.sort_by(|x, y| p.prior[*y].total_cmp(&p.prior[*x]).then(x.cmp(y)));
            let first = group[0];
            let top = p.prior[first];
            prior[first] = top + group.iter().map(|i| (p.prior[*i] - top).exp()).sum::<f64>().ln();
            for i in &group {
                taken[*i] = true;
                if *i != first {
                    norm[*i] = 0.0;
                }
            }
            // sizes are those of the column that represents all
            let sign = if dot(c.col(first), c.col(j)) < 0.0 { -1.0 } else { 1.0 };
            let belief = |i: &usize| Belief {
                odds: p.prior[*i].exp(),
                absurd: 1.0 / plain[*i].max(f64::MIN_POSITIVE),
                fixed: fixed[*i].map(|size| size * sign),
            };
            beliefs[first] = group.iter().map(belief).collect();
            kinds[first] = group.iter().filter_map(|i| p.kinds.get(*i).copied().flatten()).collect();
            alike[first] = group.iter().map(|i| *i as u16).collect();
        }
        Score {
            settings,
            known: p.known,
            nu,
            zz,
            prior,
            beliefs,
            kinds,
            alike_kinds: vec![OnceCell::new(); k],
            alike,
            c: Rc::clone(&c),
            visible,
            norm,
            b,
            sharing: p.sharing.unwrap_or_else(|| kernels.iter().map(|kernel| kernel.share).sum()),
            kernels,
            gram: vec![OnceCell::new(); k],
            made: vec![],
            given: RefCell::new((vec![], Some(vec![]))),
            visited: vec![],
            places: HashMap::default(),
            near: vec![],
            integrated: BTreeMap::new(),
            expanded: BTreeMap::new(),
            overruled: BTreeSet::new(),
            best: f64::NEG_INFINITY,
        }
    }

    /// The same where nothing is believed of the columns: what is left of them, their products, and which are alike.
    pub fn of_columns(columns: MatRef<'_, f64>, basis: MatRef<'_, f64>, residual: &[f64]) -> Self {
        let k = columns.ncols();
        let (prior, plain) = (&vec![0.0; k], &vec![f64::INFINITY; k]);
        let (fixed, kinds, kernels) = (&[], &[], &[]);
        let problem =
            Problem { residual, basis, columns, prior, plain, fixed, kinds, known: true, kernels, sharing: None };
        Score::new(&problem, Priors::at(1.0))
    }

    /// How many columns are distinct.
    pub fn distinct(&self) -> usize {
        self.alike.iter().filter(|same| !same.is_empty()).count()
    }

    /// The readings along each column, `c'z`.
    pub fn along(&self) -> &[f64] {
        &self.b
    }

    /// The column that represents a candidate; `None` where nothing of it is seen.
    pub fn standing(&self, candidate: usize) -> Option<u16> {
        let place = self.alike.iter().position(|same| same.iter().any(|j| usize::from(*j) == candidate))?;
        u16::try_from(place).ok()
    }

    /// Cosines of a column with all, the model taken out.
    pub fn cosines(&self, m: usize) -> &Rc<[f64]> {
        self.gram[m].get_or_init(|| (self.c.transpose() * self.c.col(m)).iter().copied().collect())
    }

    fn sizes_of(&self, kernel: usize) -> &Sizes {
        let Prepared { lambda, along_z, along_q, sizes, .. } = &self.kernels[kernel];
        sizes.get_or_init(|| {
            let steps = if kernel == 0 { 0 } else { (2.0 * self.settings.range() / 2f64.ln()).ceil() as usize };
            let t: Vec<f64> = (0..=steps).map(|k| if kernel == 0 { 0.0 } else { 2f64.powf(0.5 * k as f64) }).collect();
            let share = |l: f64, t: f64| t * t * l / (1.0 + t * t * l);
            let shrink = Mat::from_fn(lambda.len(), t.len(), |i, place| share(lambda[i], t[place]));
            let at = |(place, t): (usize, &f64)| {
                let shrink = shrink.col_as_slice(place);
                let reach = along_q.as_ref().and_then(|along_q| Reach::new(along_q, shrink));
                let of_z = reach.as_ref().map_or_else(Vec::new, |reach| reach.of(along_z));
                let shrunk: f64 = shrink.iter().zip(along_z).map(|(s, z)| s * z * z).sum();
                let logdet = lambda.iter().map(|l| (1.0 + t * t * l).ln()).sum::<f64>();
                let logdet = logdet + reach.as_ref().map_or(0.0, |reach| reach.log_determinant());
                AtSize { q: self.zz - shrunk - product(&of_z, &of_z), logdet, reach, of_z }
            };
            let each = t.iter().enumerate().map(at).collect();
            Sizes { t, shrink, each }
        })
    }

    /// c_j' V^-1 c_m for all j.
    fn column(&self, remainder: &GivenRemainder, m: usize) -> Rc<[f64]> {
        let gram = self.cosines(m);
        if remainder.kernel == 0 {
            return Rc::clone(gram);
        }
        if let Some(column) = remainder.columns.borrow().get(&m) {
            return Rc::clone(column);
        }
        let kernel = &self.kernels[remainder.kernel];
        let shrink = self.sizes_of(remainder.kernel).shrink.col_as_slice(remainder.place);
        let w: Vec<f64> = shrink.iter().zip(kernel.along_c.col_as_slice(m)).map(|(d, a)| d * a).collect();
        let taken = |j: usize| match (remainder.taken.get(j), remainder.taken.get(m)) {
            (Some(a), Some(b)) => product(a, b),
            _ => 0.0,
        };
        let at = |(j, g): (usize, &f64)| g - product(kernel.along_c.col_as_slice(j), &w) - taken(j);
        let column: Rc<[f64]> = gram.iter().enumerate().map(at).collect();
        let _first = remainder.columns.borrow_mut().insert(m, Rc::clone(&column));
        column
    }

    /// A remainder of one size; of one kernel they are kept.
    fn at(&mut self, kernel: usize, place: usize) -> Rc<GivenRemainder> {
        self.made.retain(|made| made.kernel == kernel);
        if let Some(made) = self.made.iter().find(|made| made.place == place) {
            return Rc::clone(made);
        }
        let made = Rc::new(self.make(Remainder { kernel, place }));
        self.made.push(Rc::clone(&made));
        made
    }

    fn make(&self, Remainder { kernel, place }: Remainder) -> GivenRemainder {
        let (Prepared { along_c, along_z, .. }, sizes) = (&self.kernels[kernel], self.sizes_of(kernel));
        let (shrink, at) = (sizes.shrink.col_as_slice(place), &sizes.each[place]);
        let (mut b, mut d) = (self.b.clone(), self.norm.clone());
        let mut shrunk = vec![0.0; shrink.len()];
        for j in (0..b.len()).filter(|j| kernel > 0 && self.norm[*j] > 0.0) {
            let along = along_c.col_as_slice(j);
            shrunk.iter_mut().zip(along.iter().zip(shrink)).for_each(|(v, (a, s))| *v = a * s);
            b[j] -= product(along_z, &shrunk);
            d[j] -= product(along, &shrunk);
        }
        let mut taken = vec![];
        if at.reach.is_some() {
            taken.extend((0..b.len()).map(|j| match self.norm[j] > 0.0 {
                true => at.taken(along_c.col_as_slice(j)),
                false => vec![0.0; at.of_z.len()],
            }));
            b.iter_mut().zip(&taken).for_each(|(b, taken)| *b -= product(taken, &at.of_z));
            d.iter_mut().zip(&taken).for_each(|(d, taken)| *d -= product(taken, taken));
        }
        GivenRemainder { kernel, place, q: at.q, logdet: at.logdet, b, d, taken, columns: RefCell::default() }
    }

    /// The odds of a column times the density of its size, but for the range: all sizes are drawn alike, absurd ones less and less.
    fn likely(&self, j: usize, size: f64, variance: f64) -> f64 {
        let range = self.settings.range();
        self.beliefs[j].iter().map(|belief| belief.density(size, variance, range)).sum()
    }

    /// What a set gains (ln) for a further member of a kind that it has in other sensors, over one of another kind. What is in one of `s` sensors is in it
    /// alone with the probability one half, else in two of them, in three, in all (a drift of the room) with equal ones: of a set of `m`, `1 / (2 (s-1) C(s, m))`.
    fn joins(&self, set: &[u16], j: u16) -> f64 {
        let own = &self.kinds[j as usize];
        let Some(sensors) = own.iter().map(|(_, sensors)| f64::from(*sensors)).reduce(f64::max) else { return 0.0 };
        let same = |other: &&u16| self.kinds[**other as usize].iter().any(|kind| own.contains(kind));
        let before = set.iter().filter(same).count() as f64;
        let second = if before == 1.0 { (sensors - 1.0).ln() } else { 0.0 };
        // the odds of a kind are counted once
        if before > 0.0 {
            ((before + 1.0) / (sensors - before).max(1.0)).ln() - second - self.prior[j as usize]
        } else {
            0.0
        }
    }

    /// How many effects a set has: one in several sensors is one.
    pub fn effects(&self, set: &[u16]) -> usize {
        let mut kinds: Vec<u16> = vec![];
        let mut is_new = |j: &&u16| {
            let own = &self.kinds[usize::from(**j)];
            let is_known = own.iter().any(|(kind, _)| kinds.contains(kind));
            kinds.extend(own.iter().map(|(kind, _)| *kind));
            !is_known
        };
        set.iter().filter(&mut is_new).count()
    }

    fn of_one_kind(&self, set: &[u16]) -> f64 {
        set.iter().enumerate().map(|(k, j)| self.joins(&set[..k], *j)).sum()
    }

    /// ln p(y, S | K, t) but for what all share.
    fn evidence(&self, k: usize, q: f64, logdet_v: f64, logdet_g: f64, believed: f64) -> f64 {
        let q = if self.known { q } else { q.max(1e-14 * self.zz).max(f64::MIN_POSITIVE).ln() };
        believed - 0.5 * (logdet_g + logdet_v) + self.volume(k) - self.per_q(k) * q
    }

    /// What `k` sizes have of it, whatever they are.
    fn volume(&self, k: usize) -> f64 {
        let (kf, range) = (k as f64, 2.0 * self.settings.range());
        let nu = self.nu - kf;
        match self.known {
            true => kf * (0.5 * std::f64::consts::TAU.ln() - range.ln()),
            false if nu < 1.0 => f64::NEG_INFINITY,
            false => kf * (0.5 * std::f64::consts::PI.ln() - range.ln()) + ln_gamma(0.5 * nu),
        }
    }

    /// What the sum of squares, or where the noise is unknown its logarithm, takes off.
    fn per_q(&self, k: usize) -> f64 {
        if self.known { 0.5 } else { 0.5 * (self.nu - k as f64) }
    }

    fn sigma2(&self, q: f64, k: usize) -> f64 {
        if self.known {
            return 1.0;
        }
        q.max(1e-14 * self.zz).max(f64::MIN_POSITIVE) / (self.nu - k as f64).max(1.0)
    }

    fn value_of(&self, state: &State, remainder: &GivenRemainder) -> f64 {
        let (set, k) = (&state.set, state.set.len());
        let s2 = self.sigma2(state.q, k);
        let variance = |i: usize| s2 * state.inverse[i * k + i];
        let believed: f64 = (0..k).map(|i| self.likely(set[i] as usize, state.beta[i], variance(i)).ln()).sum();
        self.evidence(k, state.q, remainder.logdet, state.logdet, believed + self.of_one_kind(set))
    }

    /// A set with further members. With `r` what the set leaves of the products of a member's column with all, `d` of that with itself and `b` of that with the readings: the
    /// parts along the member are `r/d`, and the set that has it takes `r r/d` of `d` and `r b/d` of `b`.
    fn further(&self, mut of: Further, remainder: &GivenRemainder, set: &[u16]) -> Option<Further> {
        let n = self.b.len();
        for m in set.iter().filter(|m| !of.state.set.contains(m)).copied().collect::<Vec<_>>() {
            let j = usize::from(m);
            let (d, bb) = of.left[j];
            if !is_left(remainder, j, d) {
                return None;
            }
            let (column, h) =
                (self.column(remainder, j), of.h.chunks_exact(n).map(|along| along[j]).collect::<Vec<_>>());
            let mut own = column.to_vec();
            for (g, h) in of.state.g.iter().zip(&h) {
                own.iter_mut().zip(&**g).for_each(|(r, g)| *r -= h * g);
            }
            for ((left, product), r) in of.left.iter_mut().zip(&mut own) {
                let part = *r / d;
                (*left, *product, *r) = (*left - *r * part, *product - bb * part, part);
            }
            for (along, h) in of.h.chunks_exact_mut(n).zip(&h) {
                along.iter_mut().zip(&own).for_each(|(along, part)| *along -= h * part);
            }
            of.h.extend(own);
            extend(&mut of.state, &h, d, bb, m);
            of.state.g.push(column);
        }
        of.state.value = self.value_of(&of.state, remainder);
        Some(of)
    }

    /// A set, with all columns.
    fn with_all(&self, remainder: &GivenRemainder, set: &[u16]) -> Option<Further> {
        let left = remainder.d.iter().copied().zip(remainder.b.iter().copied()).collect();
        let (q, logdet, value) = (remainder.q, 0.0, 0.0);
        let state = State { set: vec![], g: vec![], inverse: vec![], beta: vec![], q, logdet, value };
        self.further(Further { state, h: vec![], left }, remainder, set)
    }

    /// A set without one of its members: with `G` the inverse, `G - G_i G_i'/G_ii`, `b - G_i b_i/G_ii`, `q + b_i^2/G_ii`, `|G_S| G_ii`.
    fn without(&self, state: &State, place: usize, remainder: &GivenRemainder) -> State {
        let (k, own) = (state.set.len(), state.inverse[place * state.set.len() + place]);
        let share = |l: usize| state.inverse[l * k + place] / own;
        let mut less = state.clone();
        let (_, _, beta) = (less.set.remove(place), less.g.remove(place), less.beta.remove(place));
        let others: Vec<usize> = (0..k).filter(|l| *l != place).collect();
        let at = |l: usize, m: usize| state.inverse[l * k + m] - share(l) * state.inverse[m * k + place];
        less.inverse = others.iter().flat_map(|l| others.iter().map(|m| at(*l, *m))).collect();
        less.beta.iter_mut().zip(&others).for_each(|(b, l)| *b -= share(*l) * beta);
        (less.q, less.logdet) = (state.q + beta * beta / own, state.logdet + own.ln());
        less.value = self.value_of(&less, remainder);
        less
    }

    /// ln p of a set with one member more, for all of them, or where a member is left out, of that set (`reduced`): of the parts `h` along the set, and what is
    /// left, without it `h_l - h_i G_li/G_ii`, `d + h_i^2/G_ii` and `b + h_i b_i/G_ii`, with `G` the inverse. What is less than `least` may be minus infinity.
    fn additions(
        &self,
        of: &Further,
        left_out: Option<(usize, &State)>,
        remainder: &GivenRemainder,
        least: f64,
    ) -> Vec<f64> {
        let (n, all) = (self.b.len(), of.state.set.len());
        let state = left_out.map_or(&of.state, |(_, reduced)| reduced);
        let part = |place: usize| &of.h[place * n..(place + 1) * n];
        let of_out = left_out.map(|(i, _)| (i, part(i), of.state.inverse[i * all + i]));
        let k = state.set.len();
        let least_q = (1e-14 * self.zz).max(f64::MIN_POSITIVE);
        let of_q = |q: f64| if self.known { q } else { q.max(least_q).ln() };
        let own_q = of_q(state.q);
        let before = self.of_one_kind(&state.set);
        let volume = self.volume(k + 1) + before - 0.5 * (state.logdet + remainder.logdet);
        let there: Vec<u16> =
            state.set.iter().flat_map(|j| self.kinds[*j as usize].iter().map(|(kind, _)| *kind)).collect();
        let mut open: Vec<bool> = (0..n).map(|j| self.norm[j] > 0.0 && self.prior[j].is_finite()).collect();
        state.set.iter().for_each(|j| open[usize::from(*j)] = false);
        let enough = |j: usize| {
            let (mut d, mut bb) = of.left[j];
            if let Some((i, along, inverse)) = of_out {
                let part = along[j] / inverse;
                (d, bb) = (d + along[j] * part, bb + part * of.state.beta[i]);
            }
            if !is_left(remainder, j, d) {
                return None;
            }
            let q = state.q - bb * bb / d;
            // a kind that the set does not have joins nothing
            let is_there = self.kinds[j].iter().any(|(kind, _)| there.contains(kind));
            let joins = if is_there { self.joins(&state.set, j as u16) } else { 0.0 };
            // sizes and volume cost: what a column takes off bounds what it gains; ln x <= x - 1
            let bound = state.value + self.prior[j] + joins + 2.0;
            let most = if self.known { state.q - q } else { state.q / q.max(least_q) - 1.0 };
            if bound + self.per_q(k) * most < least {
                return None;
            }
            let ln_q = of_q(q);
            if bound + self.per_q(k) * (own_q - ln_q) < least {
                return None;
            }
            let (size, s2) = (bb / d, self.sigma2(q, k + 1));
            let value = volume + joins - self.per_q(k + 1) * ln_q;
            Some(Enough { j, size, d, s2, value, believed: Product::of(self.likely(j, size, s2 / d) / d.sqrt()) })
        };
        let mut enough: Vec<Enough> = (0..n).filter(|j| open[*j]).filter_map(enough).collect();
        for (l, place) in (0..all).filter(|place| left_out.is_none_or(|(i, _)| i != *place)).enumerate() {
            let (along, member) = (part(place), state.set[l] as usize);
            let (beta, inverse) = (state.beta[l], state.inverse[l * k + l]);
            let gone = of_out.map(|(i, along, own)| (along, of.state.inverse[place * all + i] / own));
            for own in &mut enough {
                let h = along[own.j] - gone.map_or(0.0, |(along, share)| along[own.j] * share);
                let (size, variance) = (beta - h * own.size, own.s2 * (inverse + h * h / own.d));
                own.believed.times(self.likely(member, size, variance));
            }
        }
        let mut values = vec![f64::NEG_INFINITY; n];
        enough.into_iter().for_each(|own| values[own.j] = own.value + own.believed.ln());
        values
    }

    /// ln of the integral over t, and the place of the best t; it replaces an approximation at another t.
    fn integral(&mut self, kernel: usize, set: &[u16]) -> Option<(f64, usize)> {
        let key = key(kernel, set);
        if let Some(known) = self.integrated.get(&key) {
            return Some(*known);
        }
        let integral = self.integrate(kernel, set)?;
        if integral.0.is_finite() {
            let value = integral.0 + self.prior_of(kernel, set);
            self.best = self.best.max(value);
            self.visit(kernel, &key.1, value, true);
            let _first = self.integrated.insert(key, integral);
        }
        Some(integral)
    }

    /// A set in order, with its ln p: what is settled replaces what is not; of others the largest counts.
    fn visit(&mut self, kernel: usize, set: &[u16], value: f64, is_settled: bool) {
        let valued = Valued { kernel: kernel as u16, is_settled, value };
        let place = self.places.get(set).copied().unwrap_or(self.visited.len());
        if let Some(Visited { first, others, .. }) = self.visited.get_mut(place) {
            let known = std::iter::once(first).chain(&mut *others).find(|known| known.kernel == valued.kernel);
            match known {
                Some(known) if known.is_settled && !is_settled => return,
                Some(known) => {
                    known.value = if is_settled { value } else { known.value.max(value) };
                    known.is_settled |= is_settled;
                }
                None => others.push(valued),
            }
        } else {
            let set: Rc<[u16]> = set.into();
            let _none = self.places.insert(Rc::clone(&set), place);
            self.visited.push(Visited { set, first: valued, others: vec![] });
        }
        if value > self.best - ALIAS {
            self.near.push((kernel as u16, place));
        }
    }

    /// ln p of a set that was visited with a kernel, by place.
    fn visited_with(&self, kernel: u16, place: usize) -> f64 {
        let each = self.visited[place].each();
        each.filter(|valued| valued.kernel == kernel).fold(f64::NEG_INFINITY, |_, valued| valued.value)
    }

    fn integrate(&mut self, kernel: usize, set: &[u16]) -> Option<(f64, usize)> {
        if kernel == 0 {
            let remainder = self.at(0, 0);
            return Some((self.with_all(&remainder, set)?.state.value, 0));
        }
        let (mut best, mut at, mut values) = (f64::NEG_INFINITY, 0, vec![]);
        for (place, Solved { value, .. }) in self.profile(kernel, set)?.into_iter().enumerate() {
            if value > best {
                (best, at) = (value, place);
            }
            values.push(value);
        }
        let width = 0.5 * 2f64.ln() / self.settings.range();
        let sum: f64 = values.iter().map(|v| (v - best).exp()).sum();
        Some((best + (sum * width).ln(), at))
    }

    /// A set at each size of a remainder.
    fn profile(&self, kernel: usize, set: &[u16]) -> Option<Vec<Solved>> {
        self.solved_at(kernel, 0..self.sizes_of(kernel).t.len(), set)
    }

    /// The random effects given a set: each kernel of the bank, or none, at each size with its probability and the variance of unit weight.
    pub fn deviations(&self, set: &[u16]) -> Vec<Deviation> {
        let mut deviations = vec![];
        for kernel in 0..self.kernels.len() {
            let (prior, place) = (self.prior_of(kernel, set), self.kernels[kernel].place);
            let width = if kernel == 0 { 1.0 } else { 0.5 * 2f64.ln() / self.settings.range() };
            let free = self.nu - set.len() as f64 - 2.0;
            // the mean of an inverse gamma distribution; of two degrees of freedom and fewer there is none
            let variance = |q: f64| if self.known { 1.0 } else { q / if free > 0.5 { free } else { 0.5 } };
            let profile = self.profile(kernel, set).unwrap_or_default();
            for (t, Solved { value, squares, .. }) in self.sizes_of(kernel).t.iter().zip(profile) {
                let (probability, variance) = (value + prior + f64::ln(width), variance(squares));
                deviations.push(Deviation { kernel: place, ratio: t * t, variance, probability });
            }
        }
        let all = log_sum(&deviations.iter().map(|d| d.probability).collect::<Vec<_>>());
        deviations.iter_mut().for_each(|d| d.probability = (d.probability - all).exp());
        deviations.retain(|d| d.probability > 1e-9);
        deviations
    }

    /// Twice what a kernel of the bank adds to ln p of a set at its best size, before anything is believed of kernels.
    pub fn gain(&self, place: usize, set: &[u16]) -> f64 {
        let most = |profile: Option<Vec<Solved>>| {
            profile.unwrap_or_default().iter().fold(f64::NEG_INFINITY, |most, solved| most.max(solved.value))
        };
        let Some(kernel) = self.kernels.iter().position(|kernel| kernel.place == Some(place)) else { return 0.0 };
        2.0 * (most(self.profile(kernel, set)) - most(self.profile(0, set)))
    }

    /// ln of the odds of a remainder, of whatever kernel and size, against none, given a set.
    pub fn remainder(&mut self, set: &[u16]) -> f64 {
        let value = |this: &mut Self, kernel: usize| {
            this.integral(kernel, set).map_or(f64::NEG_INFINITY, |(value, _)| value + this.kernel_prior(kernel))
        };
        let all: Vec<f64> = (0..self.kernels.len()).map(|kernel| value(self, kernel)).collect();
        all.split_first().map_or(f64::NEG_INFINITY, |(none, others)| log_sum(others) - none)
    }

    /// One set given one remainder.
    pub fn solved(&self, Remainder { kernel, place }: Remainder, set: &[u16]) -> Option<Solved> {
        self.solved_at(kernel, place..place + 1, set)?.pop()
    }

    /// One set at some sizes, solved with nothing but what it needs; the t of its members are `b_j / (s (G_S^-1)_jj^1/2)`.
    /// With `G_S = L L'`: `(G_S^-1)_jj` is the square of a column of `L^-1`, and `q = z'V^-1 z - |L^-1 C'V^-1 z|^2`.
    fn solved_at(&self, kernel: usize, places: Range<usize>, set: &[u16]) -> Option<Vec<Solved>> {
        let (Prepared { along_c, along_z, .. }, sizes) = (&self.kernels[kernel], self.sizes_of(kernel));
        let k = set.len();
        // the readings last
        let along: Vec<&[f64]> =
            set.iter().map(|m| along_c.col_as_slice(usize::from(*m))).chain([&along_z[..]]).collect();
        // direction by direction the products of all pairs: that of x and y, y <= x, at x (x + 1) / 2 + y
        let mut products = Mat::<f64>::zeros(along_z.len(), (k + 1) * (k + 2) / 2 - 1);
        let pairs = (0..=k).flat_map(|x| (0..=x).map(move |y| (x, y)));
        for ((x, y), column) in pairs.zip(products.col_iter_mut()) {
            column.iter_mut().zip(along[x].iter().zip(along[y])).for_each(|(v, (a, b))| *v = a * b);
        }
        let shrunk = products.transpose() * sizes.shrink.subcols(places.start, places.len());
        let gram: Vec<&Rc<[f64]>> = set.iter().map(|m| self.cosines(usize::from(*m))).collect();
        let (of_kind, mut all) = (self.of_one_kind(set), Vec::with_capacity(places.len()));
        for (at, shrunk) in sizes.each[places].iter().zip(shrunk.col_iter()) {
            let taken: Vec<Vec<f64>> = along[..k].iter().map(|along| at.taken(along)).collect();
            let less = |x: usize, y: usize| shrunk[x * (x + 1) / 2 + y];
            let entry = |x: usize, y: usize| gram[x][usize::from(set[y])] - less(x, y) - product(&taken[x], &taken[y]);
            let lower = Triangle::of(k, entry, |_| 0.0)?;
            let own = |y: usize| self.b[usize::from(set[y])] - less(k, y) - product(&taken[y], &at.of_z);
            let mut turned: Vec<f64> = (0..k).map(own).collect();
            lower.forward(&mut turned);
            let q = at.q - product(&turned, &turned);
            let s2 = self.sigma2(q, k);
            let (mut sizes, mut t, mut believed) = (Vec::with_capacity(k), Vec::with_capacity(k), Product::of(1.0));
            for (j, column) in set.iter().zip(lower.inverse_columns()) {
                let size = product(&column, &turned);
                let variance = (s2 * product(&column, &column)).max(f64::MIN_POSITIVE);
                believed.times(self.likely(usize::from(*j), size, variance));
                sizes.push(size);
                t.push(size / variance.sqrt());
            }
            let value = self.evidence(k, q, at.logdet, lower.log_determinant(), of_kind + believed.ln());
            all.push(Solved { value, sizes, t, squares: q });
        }
        Some(all)
    }

    /// The most probable remainder given a set.
    pub fn foremost(&mut self, set: &[u16]) -> Remainder {
        let (_, sorted) = key(0, set);
        let each = self.places.get(&sorted).into_iter().flat_map(|place| self.visited[*place].each());
        let most = |best: &'_ Valued, next: &'_ Valued| (next.value, next.kernel) > (best.value, best.kernel);
        let best = each.reduce(|best, next| if most(best, next) { next } else { best });
        let best = best.map_or(0, |valued| usize::from(valued.kernel));
        Remainder { kernel: best, place: self.integral(best, set).map_or(0, |(_, place)| place) }
    }

    /// Degrees of freedom of the t of a set of so many; infinite where the noise is known.
    pub fn dof(&self, k: usize) -> f64 {
        if self.known { f64::INFINITY } else { self.nu - k as f64 }
    }

    /// The one of some further candidates that has the largest t given a remainder and a set, and that t.
    pub fn strongest(&self, at: Remainder, set: &[u16], wanted: impl Fn(usize) -> bool) -> Option<(usize, f64)> {
        let remainder = self.make(at);
        let standing: Vec<u16> = set.iter().map(|j| self.standing(usize::from(*j))).collect::<Option<_>>()?;
        let Further { state, left, .. } = self.with_all(&remainder, &standing)?;
        let further =
            (0..self.alike.len()).filter(|j| !standing.contains(&(*j as u16)) && self.dof(set.len() + 1) >= 1.0);
        let t_of = |j: usize| {
            let candidate = self.alike[j].iter().map(|i| usize::from(*i)).find(|i| wanted(*i))?;
            let (d, bb) = left[j];
            if !is_left(&remainder, j, d) {
                return None;
            }
            let t = bb / (d * self.sigma2(state.q - bb * bb / d, set.len() + 1)).sqrt();
            Some((candidate, t * product(self.c.col_as_slice(j), self.c.col_as_slice(candidate)).signum()))
        };
        further.filter_map(t_of).reduce(|best, next| if next.1.abs() > best.1.abs() { next } else { best })
    }

    /// The size of each member of a set given its most probable remainder.
    fn sizes(&mut self, set: &[u16]) -> Vec<f64> {
        let at = self.foremost(set);
        self.solved(at, set).map_or_else(|| vec![0.0; set.len()], |solved| solved.sizes)
    }

    /// Odds of each candidate of a column at a size.
    fn odds_at(&self, j: u16, size: f64) -> impl Iterator<Item = (usize, f64)> {
        let beliefs = self.alike[j as usize].iter().zip(&self.beliefs[j as usize]);
        beliefs.map(move |(i, belief)| (*i as usize, belief.at(size)))
    }

    /// Odds of a column at a size.
    fn odds(&self, j: u16, size: f64) -> f64 {
        self.odds_at(j, size).map(|(_, odds)| odds).sum()
    }

    /// The candidates that each member of a set represents, with their odds at its size.
    pub fn shares(&mut self, set: &[u16]) -> Vec<Vec<(usize, f64)>> {
        let sizes = self.sizes(set);
        set.iter().zip(sizes).map(|(j, size)| self.odds_at(*j, size).collect()).collect()
    }

    fn kernel_prior(&self, kernel: usize) -> f64 {
        let share = self.kernels[kernel].share / self.sharing.max(1.0);
        if kernel == 0 { (1.0 - OUTSIDE).ln() } else { (OUTSIDE * share).ln() }
    }

    /// ln prior of a remainder, and of nothing at all.
    fn prior_of(&self, kernel: usize, set: &[u16]) -> f64 {
        let nothing = kernel == 0 && set.is_empty();
        self.kernel_prior(kernel) + if nothing { self.settings.nothing() } else { 0.0 }
    }

    /// A set in order, with its ln p at the size of another set's remainder.
    fn record(&mut self, kernel: usize, set: &[u16], value: f64) {
        let value = value + self.prior_of(kernel, set);
        if !value.is_finite() || value < self.best - KEPT {
            return;
        }
        self.best = self.best.max(value);
        self.visit(kernel, set, value, false);
    }

    /// Those that are less probable than the best by no more than this (ln).
    fn record_all(&mut self, kernel: usize, set: &[u16], values: &[f64], (shift, kept): (f64, f64)) {
        let least = self.best - kept - self.kernel_prior(kernel) - shift;
        let (_, before) = key(kernel, set);
        let mut with = vec![];
        for (j, value) in values.iter().enumerate() {
            if *value > least {
                insert(&before, j as u16, &mut with);
                self.record(kernel, &with, value + shift);
            }
        }
    }

    /// The best that one addition, exchange or omission makes of a set, each with its value at the best t of the set; all of it is recorded.
    fn neighbours(&mut self, kernel: usize, set: &[u16]) -> Option<(f64, Vec<(f64, Vec<u16>)>)> {
        let (integral, size) = self.integral(kernel, set)?;
        if let Some(best) = self.expanded.get(&key(kernel, set)) {
            return Some((integral, best.clone()));
        }
        let remainder = self.at(kernel, size);
        let of = self.with_all(&remainder, set)?;
        let shift = integral - of.state.value;
        let mut options: Vec<(f64, Vec<u16>)> = vec![];
        let consider = |options: &mut Vec<(f64, Vec<u16>)>, values: &[f64], of: &[u16]| {
            let top = values.iter().enumerate().max_by(|a, b| a.1.total_cmp(b.1));
            if let Some((j, v)) = top.filter(|(_, v)| **v > f64::NEG_INFINITY) {
                let mut next = of.to_vec();
                next.push(j as u16);
                options.push((*v + shift, next));
            }
        };
        let least = |this: &Self| this.best - KEPT - this.kernel_prior(kernel) - shift;
        if set.len() < self.settings.most {
            let values = self.additions(&of, None, &remainder, least(self));
            self.record_all(kernel, set, &values, (shift, KEPT));
            consider(&mut options, &values, set);
        }
        for place in 0..set.len() {
            let reduced = self.without(&of.state, place, &remainder);
            let less = reduced.set.clone();
            self.record(kernel, &key(kernel, &less).1, reduced.value + shift);
            let values = self.additions(&of, Some((place, &reduced)), &remainder, least(self));
            self.record_all(kernel, &less, &values, (shift, KEPT));
            consider(&mut options, &values, &less);
            options.push((reduced.value + shift, less));
        }
        // only sets that are nearly as probable as the best have others beside them that count
        let exchanged = if integral > self.best - ALIAS { self.of_other_kinds(set) } else { vec![] };
        for next in exchanged {
            let Some(solved) = self.solved(Remainder { kernel, place: size }, &next) else { continue };
            self.record(kernel, &key(kernel, &next).1, solved.value + shift);
            options.push((solved.value + shift, next));
        }
        options.sort_by(|a, b| b.0.total_cmp(&a.0));
        options.truncate(FOLLOWED);
        let _first = self.expanded.insert(key(kernel, set), options.clone());
        Some((integral, options))
    }

    /// Sets in which one effect of several sensors is another effect of the same sensors: all its members are exchanged at once, since a set with some of them is one
    /// of two effects, and less probable. Of another kind each member is the one that resembles a member here; where one resembles none, the kind cannot do the same.
    fn of_other_kinds(&self, set: &[u16]) -> Vec<Vec<u16>> {
        let mut exchanged = vec![];
        let of = |j: u16| self.kinds[usize::from(j)].iter().map(|(kind, _)| *kind);
        for kind in set.iter().flat_map(|j| of(*j)).collect::<BTreeSet<u16>>() {
            let (members, others): (Vec<u16>, Vec<u16>) = set.iter().partition(|j| of(**j).any(|own| own == kind));
            let Some((first, further)) = members.split_first().filter(|(_, further)| !further.is_empty()) else {
                continue;
            };
            for (other, place) in self.alike_kinds(*first).iter().filter(|(other, _)| **other != kind) {
                let places = further.iter().map(|j| self.alike_kinds(*j).get(other).copied());
                let Some(places) = places.collect::<Option<BTreeSet<u16>>>() else { continue };
                let next: BTreeSet<u16> = others.iter().copied().chain(places).chain([*place]).collect();
                exchanged.extend((next.len() == set.len()).then(|| next.into_iter().collect::<Vec<u16>>()));
            }
        }
        exchanged.sort_unstable();
        exchanged.dedup();
        exchanged
    }

    /// For each kind the member that resembles a column most, where one does.
    fn alike_kinds(&self, j: u16) -> &BTreeMap<u16, u16> {
        self.alike_kinds[usize::from(j)].get_or_init(|| {
            let cosines = self.cosines(usize::from(j));
            let size = |i: u16| cosines[usize::from(i)].abs();
            let mut like: BTreeMap<u16, u16> = BTreeMap::new();
            for i in (0..cosines.len() as u16).filter(|i| *i != j && size(*i) >= ALIKE) {
                for (kind, _) in &self.kinds[usize::from(i)] {
                    let most = like.entry(*kind).or_insert(i);
                    *most = if size(i) > size(*most) { i } else { *most };
                }
            }
            like
        })
    }

    /// From a set to its best neighbour until none is better.
    fn climb(&mut self, kernel: usize, start: Vec<u16>) -> Vec<u16> {
        let mut set = start;
        for _ in 0..10 + self.settings.most {
            let Some((integral, options)) = self.neighbours(kernel, &set) else { return set };
            // values of neighbours are those at the size of the set's remainder: the three best, and 3 in ln, allow for that
            let better = options.into_iter().take_while(|(value, _)| *value >= integral - 3.0);
            let better = better.map(|(_, next)| next).find(|next| {
                let same = next.len() == set.len() && next.iter().all(|j| set.contains(j));
                !same && self.integral(kernel, next).is_some_and(|(there, _)| there > integral + 1e-6)
            });
            let Some(next) = better else { return set };
            set = next;
        }
        set
    }

    /// The neighbours of every set that is nearly as probable as the best: what could stand in several places at once.
    fn spread(&mut self) {
        for _ in 0..SPREAD {
            let mut near = std::mem::take(&mut self.near);
            near.sort_unstable();
            near.dedup();
            let set = |place: usize| Rc::clone(&self.visited[place].set);
            near.retain(|(kernel, place)| {
                let is_near = self.visited_with(*kernel, *place) > self.best - ALIAS;
                is_near && !self.expanded.contains_key(&(*kernel, set(*place)))
            });
            let value = |(kernel, place): &(u16, usize)| self.visited_with(*kernel, *place);
            let order = |(kernel, place): &(u16, usize)| (*kernel, set(*place));
            let next = near.iter().max_by(|a, b| value(a).total_cmp(&value(b)).then_with(|| order(a).cmp(&order(b))));
            let Some((kernel, set)) = next.map(order) else { return };
            self.near = near;
            if self.neighbours(usize::from(kernel), &set).is_none() {
                let _none = self.expanded.insert((kernel, set), vec![]);
            }
        }
    }

    /// The best sets with two effects more, some of which show only together; the best first. None where there are too many pairs.
    fn pairs(&mut self, kernel: usize, set: &[u16]) -> Vec<Vec<u16>> {
        let k = self.b.len();
        // bounds the work: pairs times rows, about a second
        if k * k * self.c.nrows() > 200_000_000 || set.len() + 2 > self.settings.most {
            return vec![];
        }
        // the best by themselves first: the others are bounded by their values
        let mut singles = self.longer(kernel, set, vec![set.to_vec()]);
        let others = (0..k as u16).filter(|j| self.norm[*j as usize] > 0.0 && !set.contains(j));
        let others = others.map(|j| {
            let mut with = [set, &[j]].concat();
            with.sort_unstable();
            with
        });
        let others: Vec<Vec<u16>> = others.filter(|with| !singles.contains(with)).collect();
        singles.extend(others);
        self.longer(kernel, set, singles)
    }

    /// The best sets with one effect more than some sets have, the best first: so many that the first effect of each need not be in the best set.
    /// Remainders have the size that they have given `at`, which all sets contain.
    fn longer(&mut self, kernel: usize, at: &[u16], sets: Vec<Vec<u16>>) -> Vec<Vec<u16>> {
        let Some((integral, size)) = self.integral(kernel, at) else { return vec![] };
        let remainder = self.at(kernel, size);
        let Some(start) = self.with_all(&remainder, at) else { return vec![] };
        let shift = integral - start.state.value;
        let mut longer: Vec<(f64, Vec<u16>)> = vec![];
        for set in sets {
            let Some(of) = self.further(start.clone(), &remainder, &set) else { continue };
            let least = if longer.len() < BEAM { f64::NEG_INFINITY } else { longer[BEAM - 1].0 };
            let record = self.best - GROWN - self.kernel_prior(kernel) - shift;
            let values = self.additions(&of, None, &remainder, least.min(record));
            self.record_all(kernel, &set, &values, (shift, GROWN));
            for (j, value) in values.iter().enumerate().filter(|(_, value)| **value > least) {
                let mut next = [&set[..], &[j as u16]].concat();
                next.sort_unstable();
                let place = longer.partition_point(|(other, _)| other >= value);
                // each set is met once from each of its members
                if place < BEAM && !longer.iter().any(|(_, other)| *other == next) {
                    longer.insert(place, (*value, next));
                    longer.truncate(BEAM);
                }
            }
        }
        longer.into_iter().map(|(_, set)| set).collect()
    }

    pub fn search(&mut self, starts: &[Vec<u16>]) {
        let mut white = self.climb(0, vec![]);
        let mut level = self.pairs(0, &[]);
        if level.is_empty() {
            level = self.longer(0, &[], vec![vec![]]);
        }
        // what shows only with two others is there where one effect more gains nothing, and two do
        let (mut most, mut without_gain) = (self.value(0, &white), 0);
        while let Some(first) = level.first().cloned() {
            let reached = self.value(0, &first);
            without_gain = if reached > most { 0 } else { without_gain + 1 };
            if reached > most - ALIAS {
                let other = self.climb(0, first.clone());
                if self.value(0, &other) > self.value(0, &white) {
                    white = other;
                }
            }
            most = most.max(reached);
            let is_last = without_gain == 2 || first.len() >= self.settings.most;
            level = if is_last { vec![] } else { self.longer(0, &[], level) };
        }
        let mut ranked = vec![];
        for kernel in 0..self.kernels.len() {
            let mut climbed = vec![];
            let begin: Vec<Vec<u16>> = [vec![], white.clone()].into_iter().chain(starts.iter().cloned()).collect();
            // given a kernel without deviations no other set becomes probable
            let is_probable = begin.iter().any(|start| self.value(kernel, start) > self.best - KEPT);
            for start in begin.into_iter().filter(|_| is_probable) {
                let top = self.climb(kernel, start);
                climbed.push((self.value(kernel, &top), top));
            }
            climbed.sort_by(|a, b| b.0.total_cmp(&a.0));
            if let Some((value, set)) = climbed.into_iter().next() {
                ranked.push((value, kernel, set));
            }
        }
        ranked.sort_by(|a, b| b.0.total_cmp(&a.0));
        let Some((top, _, _)) = ranked.first().cloned() else { return };
        for (value, kernel, set) in ranked.into_iter().take(3) {
            // no pair given a kernel that is 3000 times less probable
            if value < top - 8.0 {
                break;
            }
            // two effects more, and two others in the place of any two: neither of them need be better by itself
            let without = |a: usize, b: usize| -> Vec<u16> {
                set.iter().enumerate().filter(|(k, _)| *k != a && *k != b).map(|(_, j)| *j).collect()
            };
            let fewer = (0..set.len()).flat_map(|b| (0..b).map(move |a| (a, b))).map(|(a, b)| without(a, b));
            for base in fewer.chain([set.clone()]).collect::<Vec<_>>() {
                if let Some(pair) = self.pairs(kernel, &base).into_iter().next() {
                    self.climb(kernel, pair);
                }
            }
        }
        self.spread();
        // what the best sets are under every kernel, until no approximate value is among the best
        for _ in 0..4 {
            let mut sets = self.marginal();
            let order = |a: &(f64, Rc<[u16]>), b: &(f64, Rc<[u16]>)| b.0.total_cmp(&a.0).then_with(|| a.1.cmp(&b.1));
            if sets.len() > 12 {
                sets.select_nth_unstable_by(12, order);
                sets.truncate(12);
            }
            sets.sort_unstable_by(order);
            let before = self.integrated.len();
            for (_, set) in sets {
                for kernel in 0..self.kernels.len() {
                    let _kept = self.integral(kernel, &set);
                }
            }
            if self.integrated.len() == before {
                break;
            }
        }
    }

    fn value(&mut self, kernel: usize, set: &[u16]) -> f64 {
        self.integral(kernel, set).map_or(f64::NEG_INFINITY, |(v, _)| v) + self.prior_of(kernel, set)
    }

    /// The `t` from which what could stand in an effect's place has a probability, if it is what the readings show and the noise is known, with its
    /// standard deviation over some columns of noise given it; for each of some candidates. Single effects and remainders compete:
    ///
    /// ```text
    /// t_i = c t + e_i,     -2 ln p(K, x) = ln|V| - sum_d w_d (p_d t + e_d)^2,    w = x^2 l/(1 + x^2 l),   c, p: cosines with the effect's column
    /// e = n - a p,         sum_d w (p t + n - a p)^2 = sum w n^2 + 2 (t - a) sum w p n + (t - a)^2 sum w p^2,    n: noise, a: its part along the effect
    /// ```
    pub fn named_from(
        &self,
        candidates: &[usize],
        noise: std::ops::Range<usize>,
        probability: f64,
    ) -> Vec<Option<(f64, f64)>> {
        let scale = self.nu.sqrt();
        let width = 0.5 * 2f64.ln() / self.settings.range();
        // each remainder of each size: its kernel, its weights, what of ln p no effect changes, and sum w n^2 of each noise
        let remainders: Vec<(usize, &[f64], f64, Vec<f64>)> = (1..self.kernels.len())
            .flat_map(|kernel| self.sizes_of(kernel).t.iter().enumerate().map(move |(place, x)| (kernel, place, x)))
            .map(|(kernel, place, x)| {
                let (at, weights) = (&self.kernels[kernel], self.sizes_of(kernel).shrink.col_as_slice(place));
                let volume: f64 = at.lambda.iter().map(|l| (1.0 + x * x * l).ln()).sum();
                let square = |column: usize| {
                    let along = weights.iter().zip(at.along_c.col_as_slice(column));
                    scale * scale * along.map(|(w, n)| w * n * n).sum::<f64>()
                };
                let squares = noise.clone().map(square).collect();
                (kernel, weights, self.prior_of(kernel, &[]) + width.ln() - 0.5 * volume, squares)
            })
            .collect();
        let noises: Vec<Rc<[f64]>> = noise.clone().map(|column| Rc::clone(self.cosines(column))).collect();
        let named = |candidate: &usize| {
            let first = usize::from(self.standing(*candidate)?);
            let along = Rc::clone(self.cosines(first));
            // of each remainder sum w p^2, and sum w p n of each noise
            let crossed = |(kernel, weights, ..): &(usize, &[f64], f64, Vec<f64>)| {
                let columns = &self.kernels[*kernel].along_c;
                let effect = columns.col_as_slice(first);
                let weighted: Vec<f64> = effect.iter().zip(*weights).map(|(p, w)| p * w).collect();
                let with = noise.clone().map(|column| scale * product(&weighted, columns.col_as_slice(column)));
                (product(&weighted, effect), with.collect::<Vec<f64>>())
            };
            let crossed: Vec<(f64, Vec<f64>)> = remainders.iter().map(crossed).collect();
            let thresholds = noises.iter().enumerate().map(|(draw, row)| {
                let projection = row[first] * scale;
                let orthogonal: Vec<f64> =
                    row.iter().zip(along.iter()).map(|(n, c)| n * scale - c * projection).collect();
                // ln p of a remainder: a + b (t - projection) + c (t - projection)^2
                let outside: Vec<[f64; 3]> = remainders
                    .iter()
                    .zip(&crossed)
                    .map(|((.., constant, squares), (pp, pn))| [constant + 0.5 * squares[draw], pn[draw], 0.5 * pp])
                    .collect();
                self.named_beside(first, &along, (&orthogonal, projection), &outside, probability)
            });
            let thresholds: Vec<f64> = thresholds.collect::<Option<_>>()?;
            let count = thresholds.len() as f64;
            let mean = thresholds.iter().sum::<f64>() / count;
            let variance = thresholds.iter().map(|t| (t - mean).powi(2)).sum::<f64>() / (count - 1.0).max(1.0);
            (count > 0.0).then(|| (mean, variance.sqrt()))
        };
        candidates.iter().map(named).collect()
    }

    /// The `t` from which a candidate's class has a probability, beside one noise (its part orthogonal to the candidate, and that along it) and remainders,
    /// each with the coefficients of its ln p by powers of `t` less that part. `None` where no size is enough.
    fn named_beside(
        &self,
        first: usize,
        along: &[f64],
        (orthogonal, projection): (&[f64], f64),
        outside: &[[f64; 3]],
        probability: f64,
    ) -> Option<f64> {
        let each = 0.5 * std::f64::consts::TAU.ln() - (2.0 * self.settings.range()).ln() + self.kernel_prior(0);
        let nothing = self.prior_of(0, &[]);
        let open: Vec<usize> = (0..along.len()).filter(|j| self.norm[*j] > 0.0 && self.prior[*j].is_finite()).collect();
        let share = |t: f64| {
            let score = |j: usize| along[j] * t + orthogonal[j];
            let like = |j: usize| 0.5 * score(j).powi(2) + each;
            let outside = outside.iter().map(|[a, b, c]| a + (b + c * (t - projection)) * (t - projection));
            let top = open.iter().map(|j| like(*j)).chain(outside.clone()).fold(nothing, f64::max);
            let is_plain = like(first) - nothing >= PLAIN;
            let (mut class, mut all) =
                (0.0, (nothing - top).exp() + outside.map(|value| (value - top).exp()).sum::<f64>());
            for j in &open {
                let value = (like(*j) - top).exp() * self.likely(*j, score(*j), 1.0);
                all += value;
                if self.replaces(like(first) - like(*j), is_plain, || along[*j].abs()) {
                    class += value;
                }
            }
            class / all
        };
        // what is not named from thirty standard uncertainties on never is
        let (mut low, mut high) = (1.0, 30.0);
        if share(high) < probability {
            return None;
        }
        for _ in 0..12 {
            let middle = 0.5 * (low + high);
            if share(middle) >= probability { high = middle } else { low = middle }
        }
        Some(high)
    }

    /// For each set visited the sum of p over its kernels, in that of the best.
    fn marginal(&self) -> Vec<(f64, Rc<[u16]>)> {
        let sum = |visited: &Visited| visited.each().map(|valued| (valued.value - self.best).exp()).sum();
        self.visited.iter().map(|visited| (sum(visited), Rc::clone(&visited.set))).collect()
    }

    /// Do two explanations that differ by so much (ln) stand in each other's place? Of what is hardly seen only columns that are alike do.
    fn replaces(&self, apart: f64, is_plain: bool, cosine: impl FnOnce() -> f64) -> bool {
        apart <= ALIAS && (is_plain || cosine() >= ALIKE)
    }

    /// Cosine of two columns given the model and some others, by size; zero where one of them was never in a set.
    pub fn cosine(&self, others: &[u16], a: u16, b: u16) -> f64 {
        let rows: Option<Vec<&Rc<[f64]>>> =
            others.iter().chain([&a]).map(|j| self.gram.get(usize::from(*j))?.get()).collect();
        let Some((row, given)) = rows.as_ref().and_then(|rows| rows.split_last()) else { return 0.0 };
        let k = others.len();
        let mut last = self.given.borrow_mut();
        if last.0 != others {
            let gram = |i: usize, l: usize| given[i][usize::from(others[l])];
            *last = (others.to_vec(), Triangle::of(k, gram, |_| 0.0).map(|lower| lower.inverse()));
        }
        let Some(inverse) = &last.1 else { return 0.0 };
        let along = |x: u16, y: u16| -> f64 {
            let pair = |i: usize, l: usize| given[i][x as usize] * inverse[i][l] * given[l][y as usize];
            (0..k).flat_map(|i| (0..k).map(move |l| (i, l))).map(|(i, l)| pair(i, l)).sum()
        };
        let (left, right) = (1.0 - along(a, a), 1.0 - along(b, b));
        if left > 1e-9 && right > 1e-9 { ((row[b as usize] - along(a, b)) / (left * right).sqrt()).abs() } else { 0.0 }
    }

    pub fn posterior(&mut self) -> Posterior {
        let sums: Vec<f64> = self.marginal().into_iter().map(|(sum, _)| sum).collect();
        let total: f64 = sums.iter().sum();
        let of_place = |place: &usize| sums.get(*place).map_or(0.0, |sum| sum / total);
        let probable = |visited: &[Visited]| -> Vec<(f64, Rc<[u16]>)> {
            let each = visited.iter().zip(&sums).filter(|(_, sum)| **sum > 0.0);
            each.map(|(visited, sum)| (sum / total, Rc::clone(&visited.set))).collect()
        };
        let mut sets = probable(&self.visited);
        sets.sort_unstable_by(|a, b| b.0.total_cmp(&a.0).then_with(|| a.1.cmp(&b.1)));
        let mut kernels = vec![0.0; self.kernels.len()];
        let mut alone = vec![0.0; self.settings.most + 1];
        for visited in &self.visited {
            for valued in visited.each() {
                let p = (valued.value - self.best).exp() / total;
                kernels[usize::from(valued.kernel)] += p;
                if valued.kernel == 0
                    && let Some(share) = alone.get_mut(self.effects(&visited.set))
                {
                    *share += p;
                }
            }
        }
        let nothing = self.places.get(&[][..]).map_or(f64::NEG_INFINITY, |place| self.visited_with(0, *place));
        let nothing = (nothing - self.best).exp() / total;
        let mut classes: Vec<Class> = vec![];
        let mut in_class = vec![false; self.alike.len()];
        // many that stand in each other's place share what one without them has: not only the best set tells what is probable
        let least = sets.first().map_or(0.0, |(top, _)| top * (-ALIAS).exp());
        let sizes: Vec<Vec<f64>> = sets.iter().take(TOLD).map(|(_, set)| self.sizes(set)).collect();
        let probable = sets.iter().zip(sizes).take_while(|((p, _), _)| *p >= least);
        for (order, ((top, set), sizes)) in probable.enumerate() {
            for (place, size) in sizes.into_iter().enumerate() {
                let mut less = set.to_vec();
                let member = less.remove(place);
                let mut class = vec![(member, *top)];
                // what the search passed over has a probability all the same
                let visited = self.places.get(&less[..]).map(of_place).filter(|p| *p > 0.0);
                let without = visited.unwrap_or_else(|| (self.of(&less) - self.best).exp() / total);
                // of two sets one of which is judged at its solution both are compared by the columns here
                let both = self.overruled.contains(&**set) == self.overruled.contains(&less);
                let here =
                    if both { None } else { Some(self.of(set) - self.of(&less)).filter(|gain| gain.is_finite()) };
                let gain = here.unwrap_or_else(|| top.max(1e-300).ln() - without.max(1e-300).ln());
                // by what the readings say alone
                let like = |p: f64, j: u16| p.max(1e-300).ln() - self.odds(j, size).ln();
                let is_plain = gain - self.odds(member, size).ln() >= PLAIN;
                // each of the sets that differ from this one in this place
                let mut other = vec![];
                for j in (0..self.alike.len() as u16).filter(|j| !set.contains(j)) {
                    insert(&less, j, &mut other);
                    let p = self.places.get(&other[..]).map_or(0.0, of_place);
                    if p > 0.0
                        && self.replaces(like(*top, member) - like(p, j), is_plain, || self.cosine(&less, member, j))
                    {
                        class.push((j, p));
                    }
                }
                // of further sets only what is in no class yet; members of the best set are different effects
                let is_known = |class: &[(u16, f64)]| order > 0 && class.iter().any(|(j, _)| in_class[usize::from(*j)]);
                if is_known(&class) {
                    continue;
                }
                let mut is_member = vec![false; self.alike.len()];
                class.iter().for_each(|(j, _)| is_member[usize::from(*j)] = true);
                // many sets have the same further member
                let mut is_other: Vec<Option<bool>> = vec![None; self.alike.len()];
                for (p, other) in sets.iter().take_while(|(p, _)| *p >= *top * 1e-4) {
                    if other.iter().any(|j| is_member[usize::from(*j)]) {
                        continue;
                    }
                    for j in other.iter().copied().filter(|j| !set.contains(j)) {
                        let other = &mut is_other[usize::from(j)];
                        if !*other.get_or_insert_with(|| self.cosine(&less, member, j) < NEARLY) {
                            is_member[usize::from(j)] = true;
                            class.push((j, *p));
                        }
                    }
                }
                if is_known(&class) {
                    continue;
                }
                class.iter().for_each(|(j, _)| in_class[usize::from(*j)] = true);
                let each = |(j, p): &(u16, f64)| {
                    let (j, p) = (*j, *p);
                    let all = self.odds(j, size);
                    let one = move |(i, odds): (usize, f64)| Member { candidate: i, probability: p * odds / all, odds };
                    self.odds_at(j, size).map(one)
                };
                let mut members: Vec<Member> = class.iter().flat_map(each).collect();
                let with = self.visited.iter().zip(&sums);
                let with = with.filter(|(visited, _)| visited.set.iter().any(|j| is_member[usize::from(*j)]));
                let probability = (with.map(|(_, sum)| *sum).sum::<f64>() / total).min(1.0);
                members.sort_by(|a, b| b.probability.total_cmp(&a.probability).then(a.candidate.cmp(&b.candidate)));
                classes.push(Class { members, probability });
            }
        }
        let outside = kernels.iter().skip(1).sum();
        Posterior { sets, classes, nothing, outside, alone }
    }

    /// The evidence of sets at their solutions replaces that from columns at another point; minus infinity where one has none.
    pub fn overrule(&mut self, judged: impl IntoIterator<Item = (Vec<u16>, f64)>) {
        for (set, value) in judged {
            let each = self.values(&set);
            let shift = value - log_sum(&each);
            for (kernel, at) in each.into_iter().enumerate() {
                // for a set that is judged only at its solution no remainder is known here
                let at = if shift == f64::INFINITY && kernel == 0 { value } else { at + shift };
                self.visit(kernel, &set, if at.is_finite() { at } else { f64::NEG_INFINITY }, true);
            }
            let _first = self.overruled.insert(set);
        }
        let values = self.visited.iter().flat_map(Visited::each).map(|valued| valued.value);
        self.best = values.fold(f64::NEG_INFINITY, f64::max);
    }

    /// Places in the bank of the kernels that matter given a set.
    pub fn kernels_given(&mut self, set: &[u16]) -> Vec<usize> {
        let values = self.values(set);
        let least = log_sum(&values) + NEGLIGIBLE.ln();
        let near = self.kernels.iter().zip(values).filter(|(_, value)| *value >= least);
        near.filter_map(|(kernel, _)| kernel.place).collect()
    }

    /// ln of the sum over kernels of one set.
    pub fn of(&mut self, set: &[u16]) -> f64 {
        log_sum(&self.values(set))
    }

    /// ln p of a set with each kernel.
    fn values(&mut self, set: &[u16]) -> Vec<f64> {
        (0..self.kernels.len()).map(|kernel| self.value(kernel, set)).collect()
    }
}

/// A set in order with one member more.
fn insert(set: &[u16], j: u16, with: &mut Vec<u16>) {
    let place = set.partition_point(|other| *other < j);
    with.clear();
    with.extend_from_slice(&set[..place]);
    with.push(j);
    with.extend_from_slice(&set[place..]);
}

/// A kernel, and a set in order.
fn key(kernel: usize, set: &[u16]) -> (u16, Rc<[u16]>) {
    let mut set = set.to_vec();
    set.sort_unstable();
    (kernel as u16, set.into())
}

/// A remainder: a kernel of the bank, or none, at one size.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Deviation {
    pub kernel: Option<usize>,
    /// `t^2`.
    pub ratio: f64,
    /// Variance of unit weight.
    pub variance: f64,
    pub probability: f64,
}

/// All that may deviate, with the kernels of the bank.
pub(crate) struct Deviations {
    pub each: Vec<Deviation>,
    pub kernels: Vec<Kernel>,
}

impl Deviations {
    /// The most probable kernel and the mean of `t^2 s^2` there: the variance of what is left over that of the noise.
    pub fn foremost(&self) -> Option<(&Kernel, f64)> {
        let of = |k: usize| self.each.iter().filter(move |d| d.kernel == Some(k));
        let probable = |k: usize| of(k).map(|d| d.probability).sum::<f64>();
        let best = (0..self.kernels.len()).max_by(|a, b| probable(*a).total_cmp(&probable(*b)))?;
        let variance: f64 = of(best).map(|d| d.probability * d.ratio * d.variance).sum();
        let all = probable(best);
        self.kernels.get(best).filter(|_| all > 0.0).map(|kernel| (kernel, variance / all))
    }

    /// Variance of a combination `l` of the weighted rows: `sum_k P_k s_k^2 (l'l + t_k^2 l'K l)`.
    pub fn variance_of(&self, l: &[f64]) -> f64 {
        let white: f64 = l.iter().map(|l| l * l).sum();
        let shared: Vec<f64> = self.kernels.iter().map(|kernel| kernel.factor.form(l)).collect();
        let of = |d: &Deviation| d.kernel.and_then(|k| shared.get(k)).map_or(0.0, |shared| d.ratio * shared);
        self.each.iter().map(|d| d.probability * d.variance * (white + of(d))).sum()
    }
}

/// A candidate that could stand in a place.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Member {
    pub candidate: usize,
    /// The probability of the set that has it there.
    pub probability: f64,
    /// Its odds before the readings are seen, at its size.
    pub odds: f64,
}

/// What could stand in one place of the most probable set.
#[derive(Debug, Clone)]
pub(crate) struct Class {
    pub members: Vec<Member>,
    /// That any of them is there.
    pub probability: f64,
}

impl Class {
    /// The member that represents the class: of those that are nearly as probable as any (but for what is hardly worth a mention) the one with the best odds by
    /// itself; of equals the more probable, then the first. What is not plain never represents a plain one that it could replace, by so much (ln).
    pub fn front(
        &self,
        alias: f64,
        is_plain: impl Fn(usize) -> bool,
        order: impl Fn(usize, usize) -> Ordering,
    ) -> Option<Member> {
        let most = |all: bool| {
            let members = self.members.iter().filter(|m| all || is_plain(m.candidate));
            members.fold(0.0_f64, |most, m| most.max(m.probability))
        };
        let top = most(true);
        let most = Some(most(false)).filter(|p| p.ln() >= top.ln() - alias).unwrap_or(top);
        let near = self.members.iter().filter(|m| m.probability * NEAR >= most && m.probability <= most);
        let equal = |a: f64, b: f64| if (a - b).abs() <= EQUAL * a { Ordering::Equal } else { a.total_cmp(&b) };
        near.copied().max_by(|a, b| {
            let probable = || equal(a.probability / most, b.probability / most);
            equal(a.odds, b.odds).then_with(probable).then_with(|| order(b.candidate, a.candidate))
        })
    }
}

/// What is probable once the readings are seen.
#[derive(Debug, Clone, Default)]
pub(crate) struct Posterior {
    /// Sets, whatever the remainder, the most probable first.
    pub sets: Vec<(f64, Rc<[u16]>)>,
    pub classes: Vec<Class>,
    /// No effect and no remainder.
    pub nothing: f64,
    /// A remainder, whatever the effects.
    pub outside: f64,
    /// So many effects, one in several sensors being one, and no remainder.
    pub alone: Vec<f64>,
}

/// Is enough left of a column for it to be another?
fn is_left(remainder: &GivenRemainder, j: usize, d: f64) -> bool {
    d > 1e-4 * remainder.d[j] && d > 1e-12
}

fn extend(state: &mut State, h: &[f64], d: f64, bb: f64, m: u16) {
    let k = state.set.len();
    let bj = bb / d;
    let mut inverse = vec![0.0; (k + 1) * (k + 1)];
    for i in 0..k {
        for l in 0..k {
            inverse[i * (k + 1) + l] = state.inverse[i * k + l] + h[i] * h[l] / d;
        }
        inverse[i * (k + 1) + k] = -h[i] / d;
        inverse[k * (k + 1) + i] = -h[i] / d;
        state.beta[i] -= h[i] * bj;
    }
    inverse[k * (k + 1) + k] = 1.0 / d;
    state.inverse = inverse;
    state.beta.push(bj);
    state.q -= bb * bj;
    state.logdet += d.ln();
    state.set.push(m);
}
