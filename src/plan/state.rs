//! A design in the making: what is chosen, `M^-1`, the sums over all candidates that follow it, and what every candidate would do to the objective.
//!
//! With `M` the information of the design, block `j` comes and block `i` goes:
//!
//! ```text
//! X = [Xj; Xi],   S = diag(1, .., -1, ..),   T = S + X M^-1 X' = L D L'
//! det M' / det M = |det T|
//! c' M'^-1 c     = c' M^-1 c - y' D^-1 y,                  L y = X M^-1 c
//! tr(W M'^-1)    = tr(W M^-1) - tr(D^-1 E),                L E L' = X M^-1 W M^-1 X'
//! det C' / det C = |det(S + X A X')| / |det T|,            C = F M^-1 F',   A = M^-1 - M^-1 F' C^-1 F M^-1
//! ```
//!
//! (V. V. Fedorov, Theory of Optimal Experiments, 1972, 3.1; `A` is the covariance of the other unknowns for known functions `F` of them.) Block `j` is
//! eliminated first: its pivots are at least one, so that nothing is lost where the design without `i` is singular. Without `i`, `j` is added. The matrices of all
//! candidates are eliminated side by side.
#![allow(
    clippy::indexing_slicing,
    reason = "`chosen` holds numbers of candidates below `blocks.count()`; sums have an entry for each pair of rows of a block or of two, each with all candidates"
)]

use super::blocks::{add_outer, eliminate, invert, packed, shares, size, squares, times};
use super::objective::{FEW, Objective};
use super::prices::Till;
use super::problem::{Problem, WORTH, counted, information};
use crate::linear::dot;

/// A design in the making.
#[derive(Clone)]
pub(super) struct State<'a> {
    /// What is asked.
    pub problem: &'a Problem<'a>,
    /// Chosen candidates, with repeats.
    pub chosen: Vec<usize>,
    /// Multiplications so far, roughly.
    pub effort: f64,
    /// How often each candidate is chosen.
    times_chosen: Vec<u32>,
    /// What the chosen ones cost, where that matters.
    till: Option<Till<'a>>,
    /// `M^-1`, row by row.
    inverse: Vec<f64>,
    /// `Xj M^-1 Xj'` of all candidates.
    spread: Vec<Vec<f64>>,
    /// The objective's second matrix, `M^-1 W M^-1` or `A`, and its sums; none when `M` has changed since.
    second: Option<(Vec<f64>, Vec<Vec<f64>>)>,
}

/// Share of the largest diagonal element that is added to all of them, so that a singular design has an inverse, too: what is determined
/// changes by a millionth, and rounding (1e-16) by a condition number of 1e6 at most.
const LITTLE: f64 = 1e-6;
/// A replacement that leaves a smaller share of the determinant leaves a singular design: ten times that rounding.
const SINGULAR: f64 = 1e-9;
/// Candidates that are evaluated one by one when the largest of several variances is made small: they bound the work.
const CUTS: usize = 60;
/// Of gains that differ by less, which is that rounding, the first candidate's counts.
const EQUAL: f64 = 1e-10;

impl<'a> State<'a> {
    /// Nothing inverted yet.
    pub fn unsolved(problem: &'a Problem<'a>, chosen: Vec<usize>) -> Self {
        let mut times_chosen = vec![0; problem.blocks.count()];
        chosen.iter().for_each(|k| times_chosen[*k] += 1);
        let till = problem.prices.map(|prices| Till::new(prices, &chosen));
        let (inverse, spread) = (Vec::new(), Vec::new());
        State { problem, chosen, effort: 0.0, times_chosen, till, inverse, spread, second: None }
    }

    /// The state of a given design; `None` where it is singular.
    pub fn of(problem: &'a Problem<'a>, chosen: Vec<usize>) -> Option<Self> {
        let mut state = State::unsolved(problem, chosen);
        state.solve(0.0)?;
        Some(state)
    }

    /// Inverse and sums from scratch.
    fn solve(&mut self, share: f64) -> Option<()> {
        let (blocks, n) = (self.problem.blocks, self.problem.blocks.unknowns());
        let mut m = information(blocks, self.problem.base, &counted(&self.chosen));
        if share > 0.0 {
            let largest = |m: &[f64]| (0..n).map(|i| m[i * n + i]).fold(0.0_f64, f64::max);
            let size = Some(largest(&m)).filter(|size| *size > 0.0).unwrap_or_else(|| largest(&blocks.sum()));
            (0..n).for_each(|i| m[i * n + i] += share * size);
        }
        self.inverse = invert(&m, n)?.0;
        self.spread = blocks.quadratics(&self.inverse);
        self.second = None;
        Some(())
    }

    /// Are there an inverse and sums?
    pub fn is_solved(&self) -> bool {
        !self.inverse.is_empty()
    }

    /// The same, for a design that may be singular.
    pub fn solve_nearly(&mut self) -> Option<()> {
        self.solve(LITTLE)
    }

    /// Cost of one more of a candidate, if it may be chosen.
    pub fn room(&self, j: usize) -> Option<f64> {
        if self.chosen.len() >= self.problem.choose {
            return None;
        }
        self.cost_of_change(None, j)
    }

    /// What it costs more when a candidate comes (and another goes), if that is allowed.
    fn cost_of_change(&self, goes: Option<usize>, comes: usize) -> Option<f64> {
        if self.times_chosen[comes] as usize >= self.problem.most_repeats {
            return None;
        }
        self.till.as_ref().map_or(Some(1.0), |till| till.room(goes, comes))
    }

    /// One more of a candidate is counted; the inverse does not follow.
    pub fn count_in(&mut self, j: usize) {
        self.till.iter_mut().for_each(|till| till.change(None, Some(j)));
        self.times_chosen[j] += 1;
        self.chosen.push(j);
    }

    /// The candidate chosen at a place, if there is one, is no more counted.
    pub fn count_out(&mut self, at: usize) {
        if at >= self.chosen.len() {
            return;
        }
        let j = self.chosen.remove(at);
        self.till.iter_mut().for_each(|till| till.change(Some(j), None));
        self.times_chosen[j] = self.times_chosen[j].saturating_sub(1);
    }

    /// Inverse and sums with one more (or less) of a candidate.
    fn change(&mut self, j: usize, sign: f64) {
        let blocks = self.problem.blocks;
        for x in (0..blocks.rows()).map(|r| blocks.row(j, r)) {
            let (w, factor) = update(&mut self.inverse, &x, sign);
            let along = blocks.products(&w);
            for s in 0..blocks.rows() {
                for r in 0..=s {
                    let sums = self.spread[packed(r, s)].iter_mut().zip(along[r].iter().zip(&along[s]));
                    sums.for_each(|(sum, (a, b))| *sum += factor * a * b);
                }
            }
        }
        self.second = None;
    }

    /// One more of a candidate.
    pub fn add(&mut self, j: usize) {
        self.change(j, 1.0);
        self.count_in(j);
    }

    /// One less of a candidate that is chosen.
    pub fn remove(&mut self, j: usize) {
        self.change(j, -1.0);
        self.chosen.iter().rposition(|k| *k == j).into_iter().for_each(|at| self.count_out(at));
    }

    /// Replace the chosen block `at` by candidate `j`.
    fn exchange(&mut self, at: usize, j: usize) {
        let i = self.chosen[at];
        self.change(j, 1.0);
        self.change(i, -1.0);
        self.count_in(j);
        let last = self.chosen.len() - 1;
        self.chosen.swap(at, last);
        self.count_out(last);
    }

    /// `X B X'` of every candidate that comes (and the block that goes), from `B` and its sums.
    fn bordered(&self, b: &[f64], sums: &[Vec<f64>], goes: Option<usize>) -> Vec<Vec<f64>> {
        let blocks = self.problem.blocks;
        let mut bordered = sums.to_vec();
        for (i, s) in goes.into_iter().flat_map(|i| (0..blocks.rows()).map(move |s| (i, s))) {
            bordered.extend(blocks.products(&times(b, &blocks.row(i, s))));
            bordered.extend((0..=s).map(|r| vec![sums[packed(r, s)][i]; blocks.count()]));
        }
        bordered
    }

    /// The same with `S`, ready to be eliminated.
    fn signed(&self, b: &[f64], sums: &[Vec<f64>], goes: Option<usize>) -> Vec<Vec<f64>> {
        let k = self.problem.blocks.rows();
        let mut t = self.bordered(b, sums, goes);
        for r in 0..size(&t) {
            let sign = if r < k { 1.0 } else { -1.0 };
            t[packed(r, r)].iter_mut().for_each(|v| *v += sign);
        }
        t
    }

    /// By what share the objective is lower when each candidate comes (and the block `goes`): of `det M^(-1/n)`, of a trace, of a volume. Minus infinity
    /// where the design would be singular. For the largest of several variances: the share of the determinant.
    pub fn gains(&mut self, goes: Option<usize>) -> Vec<f64> {
        let Problem { blocks, objective, .. } = *self.problem;
        let (n, k) = (blocks.unknowns(), blocks.rows());
        self.effort += (2 * blocks.count() * k * k * n) as f64;
        if self.second.is_none()
            && let Some(matrix) = objective.second(&self.inverse)
        {
            let sums = blocks.quadratics(&matrix);
            self.second = Some((matrix, sums));
            self.effort += (blocks.count() * k * n * n) as f64;
        }
        let mut t = self.signed(&self.inverse, &self.spread, goes);
        let shares = |t: &[Vec<f64>]| shares(t, k, blocks.count());
        match (objective, &self.second) {
            (Objective::Trace(w), Some((matrix, sums))) => {
                let mut e = self.bordered(matrix, sums, goes);
                eliminate(&mut t, &mut e);
                let now = dot(w, &self.inverse);
                let mut gains = vec![0.0; blocks.count()];
                for c in 0..size(&t) {
                    let less = e[packed(c, c)].iter().zip(&t[packed(c, c)]);
                    gains.iter_mut().zip(less).for_each(|(gain, (e, pivot))| *gain += e / (pivot * now));
                }
                let of = |(gain, share): (f64, f64)| if share > SINGULAR { gain } else { f64::NEG_INFINITY };
                gains.into_iter().zip(shares(&t)).map(of).collect()
            }
            (Objective::Volume(functions), Some((matrix, sums))) => {
                let mut others = self.signed(matrix, sums, goes);
                eliminate(&mut t, &mut []);
                eliminate(&mut others, &mut []);
                let of = |(own, others): (f64, f64)| (own.ln() - others.ln()) / functions.size();
                shares(&t).into_iter().zip(shares(&others)).map(of).collect()
            }
            _ => {
                eliminate(&mut t, &mut []);
                shares(&t).into_iter().map(|share| share.ln() / n as f64).collect()
            }
        }
    }

    /// The best significant replacement of the chosen block at a place, among all or its neighbours.
    fn replacement(&mut self, at: usize) -> Option<usize> {
        let goes = self.chosen[at];
        if matches!(self.problem.objective, Objective::Largest(_) | Objective::Eigenvalue(_)) {
            return self.least_largest(goes);
        }
        let gains = self.gains(Some(goes));
        let better = |best: (Option<usize>, f64), j: usize| match gains[j] {
            gain if gain > best.1 && self.cost_of_change(Some(goes), j).is_some() => (Some(j), gain + EQUAL),
            _ => best,
        };
        self.offered(goes).fold((None, WORTH), better).0.filter(|j| *j != goes)
    }

    /// Candidates that may stand in a block's place, whatever they cost: all, or its neighbours.
    fn offered(&self, goes: usize) -> Box<dyn Iterator<Item = usize> + 'a> {
        match self.problem.neighbours.get(goes) {
            Some(list) => Box::new(list.iter().copied()),
            None => Box::new(0..self.problem.blocks.count()),
        }
    }

    /// The replacement with the smallest largest variance. The worst direction of one replacement bounds all of them from below, so they are evaluated in
    /// the order of their bounds until none can be better.
    fn least_largest(&mut self, goes: usize) -> Option<usize> {
        let Problem { blocks, objective, .. } = *self.problem;
        let (n, k) = (blocks.unknowns(), blocks.rows());
        let mut t = self.signed(&self.inverse, &self.spread, Some(goes));
        eliminate(&mut t, &mut []);
        // the most informative is evaluated first
        let shares = shares(&t, k, blocks.count());
        let mut bounds = vec![f64::INFINITY; blocks.count()];
        for j in self.offered(goes) {
            if shares[j] > SINGULAR && self.cost_of_change(Some(goes), j).is_some() {
                bounds[j] = -shares[j];
            }
        }
        let now = objective.worst(&self.inverse)?.0;
        let mut best = (None, now * (1.0 - WORTH));
        // the largest of few leaves other unknowns free: of equal ones the more informative, and one is tried
        let least_share = if objective.size() > FEW { f64::INFINITY } else { (n as f64 * WORTH).exp() };
        let (mut equal, mut tried) = ((None, least_share), false);
        for _ in 0..CUTS {
            let less = |a: &usize, b: &usize| bounds[*a].total_cmp(&bounds[*b]);
            let least = (0..bounds.len()).min_by(less).filter(|j| bounds[*j] < best.1);
            let is_equal = |j: &usize| best.0.is_none() && bounds[*j] <= now * (1.0 + EQUAL) && shares[*j] > equal.1;
            let informative = || (0..bounds.len()).filter(is_equal).max_by(|a, b| shares[*a].total_cmp(&shares[*b]));
            let informative = || if std::mem::replace(&mut tried, true) { None } else { informative() };
            let Some(j) = least.or_else(informative) else { break };
            let mut inverse = self.inverse.clone();
            for (block, sign) in [(j, 1.0), (goes, -1.0)] {
                (0..k).for_each(|r| drop(update(&mut inverse, &blocks.row(block, r), sign)));
            }
            let (value, direction) = objective.worst(&inverse)?;
            if value < best.1 {
                best = (Some(j), value * (1.0 - EQUAL));
            } else if value <= now * (1.0 + EQUAL) && shares[j] > equal.1 {
                equal = (Some(j), shares[j]);
            }
            let w = times(&self.inverse, &direction);
            let mut along = blocks.products(&w);
            along.extend((0..k).map(|s| vec![dot(&blocks.row(goes, s), &w); blocks.count()]));
            let variance = dot(&direction, &w);
            let less = squares(&t, along);
            bounds.iter_mut().zip(less).for_each(|(bound, less)| *bound = bound.max(variance - less));
            bounds[j] = f64::INFINITY;
            self.effort += (blocks.count() * k * (n + 2 * k) + objective.size() * n * n) as f64;
        }
        best.0.or(equal.0)
    }

    /// Exchanges of one chosen block at a time until none is significant. (The order of trials is that of R. D. Cook, C. J. Nachtsheim, Technometrics 22
    /// (1980) 315.)
    pub fn swept(mut self) -> Self {
        let mut since_solved = 0;
        for _ in 0..SWEEPS {
            let mut improved = false;
            // blocks without a better replacement in the present design
            let mut settled = vec![false; self.problem.blocks.count()];
            for at in 0..self.chosen.len() {
                crate::stop::poll();
                if settled[self.chosen[at]] {
                    continue;
                }
                let Some(best) = self.replacement(at) else {
                    settled[self.chosen[at]] = true;
                    continue;
                };
                self.exchange(at, best);
                improved = true;
                settled.fill(false);
                since_solved += 1;
                if since_solved >= REFACTOR {
                    since_solved = 0;
                    if self.solve(0.0).is_none() {
                        return self;
                    }
                }
            }
            if !improved {
                break;
            }
        }
        self
    }
}

/// More sweeps than this have never been needed.
const SWEEPS: usize = 200;
/// Exchanges between fresh factorisations.
const REFACTOR: usize = 50;

/// The inverse of `M + s x x'` in place (Sherman and Morrison): by how much, along what.
fn update(inverse: &mut [f64], x: &[f64], sign: f64) -> (Vec<f64>, f64) {
    let w = times(inverse, x);
    let factor = -sign / (1.0 + sign * dot(x, &w));
    add_outer(inverse, factor, &w);
    (w, factor)
}
