//! The state of one start: what is chosen, `M^-1`, and the sums over all candidates that follow it by rank-one updates.
//!
//! The best replacement of one chosen block: every candidate is evaluated.
//!
//! Without block `i`, both criteria are sums over the rows that a candidate adds: with `G = L^-1 Xi M^-1`, `L L' = I - Xi M^-1 Xi'`,
//!
//! ```text
//! Mi^-1 = M^-1 + G'G,   T = I + Xj Mi^-1 Xj' = I + Xj M^-1 Xj' + C'C,   C = G Xj'
//! det ratio = det(L)^2 det T,    decrease of the trace = tr(T^-1 Xj Mi^-1 W Mi^-1 Xj') - tr(G W G')
//! ```
#![allow(
    clippy::indexing_slicing,
    reason = "`chosen` holds numbers of candidates below `blocks.count()`; `State::empty` sizes spread, cross and effect by the block's rows and all candidates"
)]

use super::blocks::{Blocks, add_outer, determinant_and_trace, inverse_and_root, largest, packed, times};
use super::prices::Till;
use super::problem::{Problem, information};
use crate::linear::dot;
use crate::number;
use rand_pcg::Pcg64Mcg;
use rand_pcg::rand_core::Rng;

/// A design in the making.
#[derive(Clone)]
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
    /// `M^-1 W M^-1`; valid while `effect` is not empty.
    pub sandwich: Vec<f64>,
    /// Room for one number of each candidate.
    pub work: Vec<f64>,
    /// Products of all candidates' rows with the rows of the chosen block that was last looked at.
    pub cross: Vec<Vec<f64>>,
    /// The same through `M^-1 W`.
    pub cross_effect: Vec<Vec<f64>>,
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

    /// Nothing inverted yet.
    pub(crate) fn unsolved(problem: &'a Problem<'a>, chosen: Vec<usize>) -> Self {
        let mut state = State::empty(problem);
        chosen.iter().for_each(|k| state.times_chosen[*k] += 1);
        state.till = problem.prices.map(|prices| Till::new(prices, &chosen));
        state.chosen = chosen;
        state
    }

    /// The state of a given design; `None` where it is singular.
    pub fn of(problem: &'a Problem<'a>, chosen: Vec<usize>) -> Option<Self> {
        let mut state = State::unsolved(problem, chosen);
        state.refactor()?;
        Some(state)
    }

    /// The inverse and sums with a small multiple of the identity added to `M`, so that a singular design has them, too.
    pub(crate) fn solve_nearly(&mut self) -> Option<()> {
        let (blocks, n) = (self.problem.blocks, self.problem.blocks.unknowns());
        let mut m = information(blocks, self.problem.base, &self.chosen);
        let largest = (0..n).map(|i| m[i * n + i]).fold(0.0_f64, f64::max);
        let little = 1e-6 * if largest > 0.0 { largest } else { blocks.largest_square().max(f64::MIN_POSITIVE) };
        (0..n).for_each(|i| m[i * n + i] += little);
        let (inverse, root, _) = inverse_and_root(&m, n)?;
        self.inverse = inverse;
        self.refresh_spread(&root);
        Some(())
    }

    /// A share of the blocks at random, then the most informative.
    pub(crate) fn begin(problem: &'a Problem<'a>, share: f64, rng: &mut Pcg64Mcg) -> Option<Self> {
        let (count, rows) = (problem.blocks.count(), problem.blocks.rows());
        if count == 0 || problem.choose > count.saturating_mul(problem.most_repeats) {
            return None;
        }
        let mut state = State::empty(problem);
        // some at random; then the largest gain each, with a small multiple of the identity added to `M`
        let random = number::count((problem.choose as f64 * share).ceil()).min(problem.choose);
        while state.chosen.len() < random {
            let j = number::below(rng.next_u64(), count);
            state.choose(j);
        }
        state.solve_nearly()?;
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
        let mut remainders: Vec<(f64, usize)> = Vec::with_capacity(weights.len());
        for (j, w) in weights.iter().enumerate() {
            let times = (w * total).floor().min(problem.most_repeats as f64);
            chosen.extend(std::iter::repeat_n(j, number::count(times)));
            if number::count(times) < problem.most_repeats {
                let jitter = (rng.next_u64() >> 11) as f64 / (1_u64 << 53) as f64;
                remainders.push((w * total - times + 0.3 * jitter, j));
            }
        }
        remainders.sort_by(|a, b| b.0.total_cmp(&a.0));
        chosen.truncate(problem.choose);
        let lacking = problem.choose - chosen.len();
        chosen.extend(remainders.iter().take(lacking).map(|(_, j)| *j));
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
    pub(crate) fn refactor(&mut self) -> Option<()> {
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
        blocks.all_quadratics(&self.inverse, &mut self.spread, &mut self.work);
    }

    /// `M^-1 W M^-1` and its sums, unless they are up to date.
    pub(crate) fn refresh_effect(&mut self, w: &[f64]) {
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
        blocks.all_quadratics(&self.sandwich, &mut self.effect, &mut self.work);
    }

    /// Rank-one update of the inverse and the sums: `sign` is +1 for a row that is added, -1 for one that is removed, or a multiple for repeats. Sherman-Morrison.
    pub fn update(&mut self, x: &[f64], sign: f64) {
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
    pub(crate) fn exchange(&mut self, at: usize, j: usize) {
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
    pub(crate) fn exchange_single(&mut self, at: usize, j: usize) {
        let blocks = self.problem.blocks;
        let i = self.chosen[at];
        let (come, go) = (blocks.row(j, 0), blocks.row(i, 0));
        let (w_come, w_go) = (times(&self.inverse, &come), times(&self.inverse, &go));
        let added = 1.0 + dot(&come, &w_come);
        let share = dot(&go, &w_come) / added;
        let w_go: Vec<f64> = w_go.iter().zip(&w_come).map(|(g, c)| g - share * c).collect();
        let removed = 1.0 - dot(&go, &w_go);
        add_outer(&mut self.inverse, -1.0 / added, &w_come);
        add_outer(&mut self.inverse, 1.0 / removed, &w_go);
        blocks.along(0, &w_come, &mut self.work);
        let (came, gone) = (added.recip(), removed.recip());
        for ((d, come), go) in self.spread[0].iter_mut().zip(&self.work).zip(&self.cross[0]) {
            let go = go - share * come;
            *d += go * go * gone - come * come * came;
        }
        self.replaced(at, j);
    }

    /// One more of a candidate; the inverse and the sums follow.
    pub(crate) fn add(&mut self, j: usize) {
        let blocks = self.problem.blocks;
        (0..blocks.rows()).for_each(|r| self.update(&blocks.row(j, r), 1.0));
        if let (Some(till), Some(prices)) = (&mut self.till, self.problem.prices) {
            till.change(prices, None, Some(j));
        }
        self.times_chosen[j] += 1;
        self.chosen.push(j);
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
    pub(crate) fn replacements(&self, at: usize) -> Vec<usize> {
        let neighbours = self.chosen.get(at).and_then(|i| self.problem.neighbours.get(*i));
        match neighbours {
            Some(list) => list.iter().copied().filter(|j| self.allowed(at, *j)).collect(),
            None => (0..self.problem.blocks.count()).filter(|j| self.allowed(at, *j)).collect(),
        }
    }

    /// May `j` come in for the block at `at`?
    pub(crate) fn allowed(&self, at: usize, j: usize) -> bool {
        (self.times_chosen[j] as usize) < self.problem.most_repeats
            && match (&self.till, self.problem.prices) {
                (Some(till), Some(prices)) => {
                    prices.affords(till.spent + till.difference(prices, self.chosen.get(at).copied(), Some(j)))
                }
                _ => true,
            }
    }
}

/// Smallest pivot of `I - Xi M^-1 Xi'`: below it, the design without the block is singular.
const PIVOT: f64 = 1e-12;
/// Below this pivot the decrease of a trace is the difference of two large numbers, and the bordered form is used.
const STABLE: f64 = 1e-5;

/// The design without one chosen block.
struct Without {
    /// Rows of `G`.
    g: Vec<Vec<f64>>,
    /// `det(L)^2`.
    determinant: f64,
    smallest_pivot: f64,
}

impl State<'_> {
    /// The candidate whose exchange for the block at `at` multiplies the determinant most, and that factor.
    pub(crate) fn best_for_determinant(&mut self, at: usize) -> (usize, f64) {
        let (blocks, i) = (self.problem.blocks, self.chosen[at]);
        self.effort += (blocks.count() * blocks.rows() * blocks.rows() * blocks.unknowns()) as f64;
        if blocks.rows() == 1 {
            let w = times(&self.inverse, &blocks.row(i, 0));
            blocks.along(0, &w, &mut self.cross[0]);
            let (spread, cross) = (&self.spread[0], &self.cross[0]);
            let remaining = 1.0 - spread[i];
            let terms = self.work.iter_mut().zip(spread).zip(cross);
            terms.for_each(|((ratio, d), b)| *ratio = (1.0 + d) * remaining + b * b);
            return self.best(at);
        }
        let without = self.without(i);
        self.cross = products(blocks, &without.g, std::mem::take(&mut self.cross));
        let mut ratios = std::mem::take(&mut self.work);
        let mut t = vec![0.0; self.spread.len()];
        for (j, ratio) in ratios.iter_mut().enumerate() {
            self.fill_t(j, &mut t);
            *ratio = without.determinant;
            eliminate(blocks.rows(), &mut t, &mut [], |pivot, _| *ratio *= pivot);
        }
        self.work = ratios;
        self.best(at)
    }

    /// The candidate whose exchange for the block at `at` lowers `tr(W M^-1)` most, and by how much.
    pub(crate) fn best_for_trace(&mut self, at: usize, w: &[f64]) -> (usize, f64) {
        self.refresh_effect(w);
        self.effort +=
            (2 * self.problem.blocks.count() * self.problem.blocks.rows().pow(2) * self.problem.blocks.unknowns())
                as f64;
        let (blocks, i, k) = (self.problem.blocks, self.chosen[at], self.problem.blocks.rows());
        let rows: Vec<Vec<f64>> = (0..k).map(|s| blocks.row(i, s)).collect();
        let along = |b: &[f64]| rows.iter().map(|x| times(b, x)).collect::<Vec<Vec<f64>>>();
        if k == 1 {
            self.cross = products(blocks, &along(&self.inverse), std::mem::take(&mut self.cross));
            self.cross_effect = products(blocks, &along(&self.sandwich), std::mem::take(&mut self.cross_effect));
            let (spread, effect, b, g) = (&self.spread[0], &self.effect[0], &self.cross[0], &self.cross_effect[0]);
            let (di, fi) = (spread[i], effect[i]);
            for (j, gain) in self.work.iter_mut().enumerate() {
                let ratio = (1.0 + spread[j]) * (1.0 - di) + b[j] * b[j];
                let change = (1.0 - di) * effect[j] + 2.0 * b[j] * g[j] - (1.0 + spread[j]) * fi;
                *gain = if ratio > 1e-9 { change / ratio } else { 0.0 };
            }
            return self.best(at);
        }
        let without = self.without(i);
        let mut gains = std::mem::take(&mut self.work);
        if without.smallest_pivot < STABLE {
            self.cross = products(blocks, &along(&self.inverse), std::mem::take(&mut self.cross));
            self.cross_effect = products(blocks, &along(&self.sandwich), std::mem::take(&mut self.cross_effect));
            let (mut bordered, mut effect) = (vec![0.0; 4 * k * k], vec![0.0; 4 * k * k]);
            for (j, gain) in gains.iter_mut().enumerate() {
                self.border(i, j, &self.spread, &self.cross, true, &mut bordered);
                self.border(i, j, &self.effect, &self.cross_effect, false, &mut effect);
                let (determinant, trace) = determinant_and_trace(&mut bordered, &mut effect, 2 * k);
                *gain = if determinant.abs() > 1e-9 { trace } else { 0.0 };
            }
        } else {
            let wg: Vec<Vec<f64>> = without.g.iter().map(|g| times(w, g)).collect();
            let between = |m: usize, l: usize| dot(&without.g[m], &wg[l]);
            let lost: f64 = (0..k).map(|m| between(m, m)).sum();
            // Xj Mi^-1 W Mi^-1 Xj' = Xj M^-1 W M^-1 Xj' + H C + C'H',  row m of H from M^-1 W g_m + (1/2) sum_l (g_m' W g_l) g_l
            let h: Vec<Vec<f64>> = (0..k)
                .map(|m| {
                    let mut h = times(&self.inverse, &wg[m]);
                    for (l, g) in without.g.iter().enumerate() {
                        let half = 0.5 * between(m, l);
                        h.iter_mut().zip(g).for_each(|(h, g)| *h += half * g);
                    }
                    h
                })
                .collect();
            self.cross = products(blocks, &without.g, std::mem::take(&mut self.cross));
            self.cross_effect = products(blocks, &h, std::mem::take(&mut self.cross_effect));
            let mut t = vec![0.0; self.spread.len()];
            let mut e = t.clone();
            for (j, gain) in gains.iter_mut().enumerate() {
                self.fill_t(j, &mut t);
                self.fill_e(j, &mut e);
                *gain = -lost;
                eliminate(k, &mut t, &mut e, |pivot, element| *gain += element / pivot);
            }
        }
        self.work = gains;
        self.best(at)
    }

    /// The candidate with the largest number in `work`, among all or the neighbours; the block itself where none is positive.
    fn best(&self, at: usize) -> (usize, f64) {
        let free = self.problem.most_repeats >= self.chosen.len() && self.problem.prices.is_none();
        match self.problem.neighbours.get(self.chosen[at]) {
            None if free => largest(&self.work),
            None => self.best_among(at, 0..self.work.len()),
            Some(list) => self.best_among(at, list.iter().copied()),
        }
    }

    fn best_among(&self, at: usize, list: impl Iterator<Item = usize>) -> (usize, f64) {
        let better = |best: (usize, f64), j: usize| match self.work.get(j) {
            Some(value) if *value > best.1 && self.allowed(at, j) => (j, *value),
            _ => best,
        };
        list.fold((self.chosen[at], 0.0), better)
    }

    /// `G` and `det(L)^2` of chosen block `i`.
    fn without(&self, i: usize) -> Without {
        let (blocks, k) = (self.problem.blocks, self.problem.blocks.rows());
        let mut g: Vec<Vec<f64>> = (0..k).map(|s| times(&self.inverse, &blocks.row(i, s))).collect();
        let mut l = vec![0.0; k * k];
        let (mut determinant, mut smallest_pivot) = (1.0, f64::INFINITY);
        for r in 0..k {
            for c in 0..=r {
                let entry = f64::from(u8::from(r == c)) - self.spread[packed(c, r)][i];
                let remainder = entry - (0..c).map(|m| l[r * k + m] * l[c * k + m]).sum::<f64>();
                l[r * k + c] = if r == c { remainder.max(PIVOT).sqrt() } else { remainder / l[c * k + c] };
            }
            let pivot = l[r * k + r] * l[r * k + r];
            determinant *= pivot;
            smallest_pivot = pivot.min(smallest_pivot);
            let (done, rows_below) = g.split_at_mut(r);
            if let Some(row) = rows_below.first_mut() {
                for (m, before) in done.iter().enumerate() {
                    row.iter_mut().zip(before).for_each(|(a, b)| *a -= l[r * k + m] * b);
                }
                row.iter_mut().for_each(|a| *a /= l[r * k + r]);
            }
        }
        Without { g, determinant, smallest_pivot }
    }

    /// `T` of a candidate, packed.
    fn fill_t(&self, j: usize, t: &mut [f64]) {
        let k = self.problem.blocks.rows();
        for s in 0..k {
            for r in 0..=s {
                let first = self.spread[packed(r, s)][j] + f64::from(u8::from(r == s));
                t[packed(r, s)] = (0..k).fold(first, |t, m| t + self.cross[m * k + r][j] * self.cross[m * k + s][j]);
            }
        }
    }

    /// `Xj Mi^-1 W Mi^-1 Xj'` of a candidate, packed.
    fn fill_e(&self, j: usize, e: &mut [f64]) {
        let k = self.problem.blocks.rows();
        let (c, h) =
            (|m: usize, r: usize| self.cross[m * k + r][j], |m: usize, r: usize| self.cross_effect[m * k + r][j]);
        for s in 0..k {
            for r in 0..=s {
                let first = self.effect[packed(r, s)][j];
                e[packed(r, s)] = (0..k).fold(first, |e, m| e + (h(m, r) * c(m, s) + c(m, r) * h(m, s)));
            }
        }
    }

    /// `[Xj; Xi] B [Xj; Xi]'`, with `S` added or not.
    fn border(&self, i: usize, j: usize, sums: &[Vec<f64>], cross: &[Vec<f64>], with_signs: bool, t: &mut [f64]) {
        let k = self.problem.blocks.rows();
        let size = 2 * k;
        for s in 0..k {
            for r in 0..k {
                let (low, high) = (r.min(s), r.max(s));
                t[r * size + s] = sums[packed(low, high)][j];
                t[(k + r) * size + k + s] = sums[packed(low, high)][i];
                t[r * size + k + s] = cross[s * k + r][j];
                t[(k + s) * size + r] = cross[s * k + r][j];
            }
        }
        if with_signs {
            for r in 0..k {
                t[r * size + r] += 1.0;
                t[(k + r) * size + k + r] -= 1.0;
            }
        }
    }
}

/// `L D L'` of a packed symmetric matrix in place, and `E <- L^-1 E L^-T` of another (which may be empty); `each` sees every pivot, and the diagonal
/// element of `E`.
fn eliminate(k: usize, t: &mut [f64], e: &mut [f64], mut each: impl FnMut(f64, f64)) {
    for c in 0..k {
        let (pivot, diagonal) = (t[packed(c, c)], e.get(packed(c, c)).copied().unwrap_or(0.0));
        each(pivot, diagonal);
        for s in c + 1..k {
            let fs = t[packed(c, s)] / pivot;
            for r in c + 1..=s {
                let fr = t[packed(c, r)] / pivot;
                t[packed(r, s)] -= fs * t[packed(c, r)];
                if !e.is_empty() {
                    e[packed(r, s)] -= fr * e[packed(c, s)] + fs * e[packed(c, r)] - fr * fs * diagonal;
                }
            }
        }
    }
}

/// `v_s . x_jr` for every candidate j at `s * rows + r`, in room that is reused.
fn products(blocks: &Blocks, v: &[Vec<f64>], mut room: Vec<Vec<f64>>) -> Vec<Vec<f64>> {
    room.resize(v.len() * blocks.rows(), vec![0.0; blocks.count()]);
    for (s, v) in v.iter().enumerate() {
        for r in 0..blocks.rows() {
            blocks.along(r, v, &mut room[s * blocks.rows() + r]);
        }
    }
    room
}
