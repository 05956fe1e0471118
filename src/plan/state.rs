//! The state of one start: what is chosen, `M^-1`, and the sums over all candidates that follow it by rank-one updates.
#![allow(
    clippy::indexing_slicing,
    reason = "`State::empty` sizes the sums by the block's rows and all candidates; `chosen` holds numbers of candidates below `blocks.count()`"
)]

use super::blocks::{add_outer, inverse_and_root, largest, times};
use super::prices::Till;
use super::problem::{Problem, information};
use crate::linear::dot;
use crate::number;
use rand_pcg::Pcg64Mcg;
use rand_pcg::rand_core::Rng;

/// A design in the making.
pub(super) struct State<'a> {
    /// What is asked.
    pub problem: &'a Problem<'a>,
    /// Chosen candidates, with repeats.
    pub chosen: Vec<usize>,
    /// How often each candidate is chosen.
    pub times_chosen: Vec<u32>,
    /// Multiplications so far, roughly.
    pub effort: f64,
    /// What the chosen ones cost, where that matters.
    pub till: Option<Till>,
    /// `M^-1`, row by row.
    pub inverse: Vec<f64>,
    /// `x_jr' M^-1 x_js`, r <= s, for all j.
    pub spread: Vec<Vec<f64>>,
    /// `x_jr' M^-1 W M^-1 x_js`, r <= s, for all j; empty when `M` has changed since.
    pub effect: Vec<Vec<f64>>,
    /// `M^-1 W M^-1`, as long as `effect` stands.
    pub sandwich: Vec<f64>,
    /// Room for one number of each candidate.
    pub work: Vec<f64>,
    /// Products of all candidates' rows with the rows of the chosen block that was last looked at.
    pub cross: Vec<Vec<f64>>,
    /// The same through `M^-1 W`.
    pub cross_effect: Vec<Vec<f64>>,
}

/// Position of (r, s), r <= s, in a packed triangle.
pub(super) fn packed(r: usize, s: usize) -> usize {
    s * (s + 1) / 2 + r
}

impl<'a> State<'a> {
    fn empty(problem: &'a Problem<'a>) -> Self {
        let (count, rows) = (problem.blocks.count(), problem.blocks.rows());
        State {
            problem,
            chosen: Vec::with_capacity(problem.choose.min(problem.blocks.count())),
            times_chosen: vec![0; count],
            effort: 0.0,
            till: problem.prices.map(|prices| Till::new(prices, &[])),
            inverse: Vec::new(),
            spread: vec![vec![0.0; count]; rows * (rows + 1) / 2],
            effect: Vec::new(),
            sandwich: Vec::new(),
            work: vec![0.0; count],
            cross: vec![vec![0.0; count]; rows * rows],
            cross_effect: Vec::new(),
        }
    }

    /// A design as it stands; `None` where it is singular.
    pub fn of(problem: &'a Problem<'a>, chosen: Vec<usize>) -> Option<Self> {
        let mut state = State::empty(problem);
        chosen.iter().for_each(|k| state.times_chosen[*k] += 1);
        state.till = problem.prices.map(|prices| Till::new(prices, &chosen));
        state.chosen = chosen;
        state.refactor()?;
        Some(state)
    }

    /// This share of the blocks at random, then the most informative.
    pub fn begin(problem: &'a Problem<'a>, share: f64, rng: &mut Pcg64Mcg) -> Option<Self> {
        let (n, count, rows) = (problem.blocks.unknowns(), problem.blocks.count(), problem.blocks.rows());
        if count == 0 || problem.choose > count.saturating_mul(problem.most_repeats) {
            return None;
        }
        let mut state = State::empty(problem);
        // some at random; the rest by the largest gain, on top of a little information everywhere that is taken away again
        let random = number::count((problem.choose as f64 * share).ceil()).min(problem.choose);
        while state.chosen.len() < random {
            let j = number::below(rng.next_u64(), count);
            state.choose(j);
        }
        let mut m = information(problem.blocks, problem.base, &state.chosen);
        let own = (0..n).map(|i| m[i * n + i]).fold(0.0_f64, f64::max);
        let little = 1e-6 * if own > 0.0 { own } else { problem.blocks.largest_square().max(f64::MIN_POSITIVE) };
        (0..n).for_each(|i| m[i * n + i] += little);
        let (inverse, root, _) = inverse_and_root(&m, n)?;
        state.inverse = inverse;
        state.refresh_spread(&root);
        let mut gain = vec![0.0; count];
        while state.chosen.len() < problem.choose {
            gain.fill(0.0);
            for r in 0..rows {
                gain.iter_mut().zip(&state.spread[packed(r, r)]).for_each(|(g, d)| *g += d);
            }
            if problem.most_repeats < problem.choose {
                let full = |j: usize| state.times_chosen[j] as usize >= problem.most_repeats;
                gain.iter_mut().enumerate().filter(|(j, _)| full(*j)).for_each(|(_, g)| *g = f64::NEG_INFINITY);
            }
            let best = largest(&gain).0;
            if gain[best].is_nan() || (state.times_chosen[best] as usize) >= problem.most_repeats {
                return None;
            }
            for r in 0..rows {
                state.update(&problem.blocks.row(best, r), 1.0);
            }
            state.choose(best);
        }
        state.refactor()?;
        Some(state)
    }

    /// Weights of the candidates, rounded: whole parts first, then the largest remainders, ties at random.
    pub fn rounded(problem: &'a Problem<'a>, weights: &[f64], rng: &mut Pcg64Mcg) -> Option<Self> {
        let total = problem.choose as f64;
        let mut chosen: Vec<usize> = Vec::with_capacity(problem.choose);
        let mut rest: Vec<(f64, usize)> = Vec::with_capacity(weights.len());
        for (j, w) in weights.iter().enumerate() {
            let times = (w * total).floor().min(problem.most_repeats as f64);
            chosen.extend(std::iter::repeat_n(j, number::count(times)));
            if number::count(times) < problem.most_repeats {
                let jitter = (rng.next_u64() >> 11) as f64 / (1_u64 << 53) as f64;
                rest.push((w * total - times + 0.3 * jitter, j));
            }
        }
        rest.sort_by(|a, b| b.0.total_cmp(&a.0));
        chosen.truncate(problem.choose);
        let lacking = problem.choose - chosen.len();
        chosen.extend(rest.iter().take(lacking).map(|(_, j)| *j));
        if chosen.len() < problem.choose {
            return None;
        }
        State::of(problem, chosen)
    }

    fn choose(&mut self, j: usize) {
        if (self.times_chosen[j] as usize) < self.problem.most_repeats {
            self.times_chosen[j] += 1;
            self.chosen.push(j);
        }
    }

    /// Inverse and sums from scratch.
    pub fn refactor(&mut self) -> Option<()> {
        let blocks = self.problem.blocks;
        let (inverse, root, _) =
            inverse_and_root(&information(blocks, self.problem.base, &self.chosen), blocks.unknowns())?;
        self.inverse = inverse;
        self.effect.clear();
        self.refresh_spread(&root);
        Some(())
    }

    fn refresh_spread(&mut self, root: &[f64]) {
        let blocks = self.problem.blocks;
        if blocks.rows() == 1 {
            blocks.squares(0, root, &mut self.spread[0], &mut self.work);
            return;
        }
        for s in 0..blocks.rows() {
            for r in 0..=s {
                blocks.quadratic(r, s, &self.inverse, &mut self.spread[packed(r, s)], &mut self.work);
            }
        }
    }

    /// `M^-1 W M^-1` and its sums, unless they stand.
    pub fn refresh_effect(&mut self, w: &[f64]) {
        if !self.effect.is_empty() {
            return;
        }
        let blocks = self.problem.blocks;
        let (n, count) = (blocks.unknowns(), blocks.count());
        let mut half = vec![0.0; n * n]; // M^-1 W, by rows, as M^-1 is symmetric
        for (out, row) in half.chunks_exact_mut(n).zip(self.inverse.chunks_exact(n)) {
            out.copy_from_slice(&times(w, row));
        }
        self.sandwich.resize(n * n, 0.0);
        for (out, row) in self.sandwich.chunks_exact_mut(n).zip(half.chunks_exact(n)) {
            out.copy_from_slice(&times(&self.inverse, row));
        }
        self.effect.resize(blocks.rows() * (blocks.rows() + 1) / 2, vec![0.0; count]);
        for s in 0..blocks.rows() {
            for r in 0..=s {
                blocks.quadratic(r, s, &self.sandwich, &mut self.effect[packed(r, s)], &mut self.work);
            }
        }
    }

    /// Rank-one update of the inverse and the sums: `sign` is +1 for a row that comes, -1 for one that goes. Sherman-Morrison.
    fn update(&mut self, x: &[f64], sign: f64) {
        let blocks = self.problem.blocks;
        let w = times(&self.inverse, x);
        let factor = -sign / (1.0 + sign * dot(x, &w));
        add_outer(&mut self.inverse, factor, &w);
        if blocks.rows() == 1 {
            blocks.along(0, &w, &mut self.work);
            self.spread[0].iter_mut().zip(&self.work).for_each(|(d, t)| *d += factor * t * t);
            return;
        }
        let along: Vec<Vec<f64>> = (0..blocks.rows())
            .map(|r| {
                blocks.along(r, &w, &mut self.work);
                self.work.clone()
            })
            .collect();
        for s in 0..blocks.rows() {
            for r in 0..=s {
                let sums = self.spread[packed(r, s)].iter_mut().zip(&along[r]).zip(&along[s]);
                sums.for_each(|((d, a), b)| *d += factor * a * b);
            }
        }
    }

    /// Replace chosen block `at` by candidate `j`.
    pub fn exchange(&mut self, at: usize, j: usize) {
        let blocks = self.problem.blocks;
        let i = self.chosen[at];
        for r in 0..blocks.rows() {
            self.update(&blocks.row(j, r), 1.0);
        }
        for r in 0..blocks.rows() {
            self.update(&blocks.row(i, r), -1.0);
        }
        self.replaced(at, j);
    }

    /// The same for single rows just after `best_for_determinant(at)`, whose sums it reuses: one pass over the candidates.
    pub fn exchange_single(&mut self, at: usize, j: usize) {
        let blocks = self.problem.blocks;
        let i = self.chosen[at];
        let (come, go) = (blocks.row(j, 0), blocks.row(i, 0));
        let (w_come, w_go) = (times(&self.inverse, &come), times(&self.inverse, &go));
        let added = 1.0 + dot(&come, &w_come);
        let share = dot(&go, &w_come) / added;
        let w_go: Vec<f64> = w_go.iter().zip(&w_come).map(|(g, c)| g - share * c).collect();
        let left = 1.0 - dot(&go, &w_go);
        add_outer(&mut self.inverse, -1.0 / added, &w_come);
        add_outer(&mut self.inverse, 1.0 / left, &w_go);
        blocks.along(0, &w_come, &mut self.work);
        let (came, gone) = (added.recip(), left.recip());
        for ((d, come), go) in self.spread[0].iter_mut().zip(&self.work).zip(&self.cross[0]) {
            let go = go - share * come;
            *d += go * go * gone - come * come * came;
        }
        self.replaced(at, j);
    }

    fn replaced(&mut self, at: usize, j: usize) {
        let i = self.chosen[at];
        if let (Some(till), Some(prices)) = (&mut self.till, self.problem.prices) {
            till.change(prices, Some(i), Some(j));
        }
        self.times_chosen[i] -= 1;
        self.times_chosen[j] += 1;
        self.chosen[at] = j;
        self.effect.clear();
    }

    /// Candidates that may come in for the block at `at`: all, or its neighbours.
    pub fn replacements(&self, at: usize) -> Vec<usize> {
        let own = self.chosen.get(at).and_then(|i| self.problem.neighbours.get(*i));
        match own {
            Some(list) => list.iter().copied().filter(|j| self.allowed(at, *j)).collect(),
            None => (0..self.problem.blocks.count()).filter(|j| self.allowed(at, *j)).collect(),
        }
    }

    /// May `j` come in for the block at `at`?
    pub fn allowed(&self, at: usize, j: usize) -> bool {
        (self.times_chosen[j] as usize) < self.problem.most_repeats
            && match (&self.till, self.problem.prices) {
                (Some(till), Some(prices)) => {
                    prices.affords(till.spent + till.difference(prices, self.chosen.get(at).copied(), Some(j)))
                }
                _ => true,
            }
    }
}
