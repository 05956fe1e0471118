//! Exchange: start from some candidates, then replace one chosen candidate at a time while the criterion improves.
//!
//! With `M` the information of the design, replacing block `i` by block `j` multiplies the determinant by
//!
//! ```text
//! det(M + Xj'Xj - Xi'Xi) / det M = |det(S + X M^-1 X')|,   X = [Xj; Xi],  S = diag(1, .., -1, ..)
//! tr(W M'^-1) = tr(W M^-1) - tr[(S + X M^-1 X')^-1 X M^-1 W M^-1 X']
//! ```
//!
//! (V. V. Fedorov, Theory of Optimal Experiments, 1972, 3.1; the order of trials is that of R. D. Cook, C. J. Nachtsheim, Technometrics 22
//! (1980) 315: the best partner of one chosen block at a time). `M^-1` and the sums over candidates follow by rank-one updates; every
//! start ends with a fresh factorisation, so that no drift of the updates reaches the answer.

use super::blocks::{
    Blocks, add_outer, determinant_and_trace, dot, inverse_and_root, invert, largest as largest_of, times,
};
use rand_pcg::Pcg64Mcg;
use rand_pcg::rand_core::Rng;

/// What the exchange makes small, in the coordinates of the blocks.
#[derive(Debug, Clone)]
pub(super) enum Objective {
    /// `-log det M`.
    Determinant,
    /// `tr(W M^-1)`, `W` symmetric and row by row.
    Trace(Vec<f64>),
    /// The largest `x' M^-1 x` over all rows of all candidates.
    Largest,
}

/// The exchange problem.
#[derive(Debug, Clone)]
pub(super) struct Problem<'a> {
    /// What may be chosen.
    pub blocks: &'a Blocks,
    /// Information of what is kept, row by row.
    pub base: &'a [f64],
    /// What is made small.
    pub objective: &'a Objective,
    /// How many blocks are chosen.
    pub choose: usize,
    /// How often one candidate may be chosen.
    pub most_repeats: usize,
    /// For coordinate exchange: candidates that differ from each in one coordinate; empty for Fedorov's exchange.
    pub neighbours: &'a [Vec<usize>],
}

/// A chosen design.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Design {
    /// Candidates, sorted, with repeats.
    pub chosen: Vec<usize>,
    /// The objective's value after a fresh factorisation.
    pub value: f64,
}

/// An exchange must improve the criterion by this share to be made: less is rounding, and could go round in a circle.
const WORTH: f64 = 1e-9;
/// More sweeps than this have never been needed.
const SWEEPS: usize = 200;

/// `M`, for a list of chosen candidates.
pub(super) fn information(blocks: &Blocks, base: &[f64], chosen: &[usize]) -> Vec<f64> {
    let mut m = base.to_vec();
    for j in chosen {
        for r in 0..blocks.rows() {
            add_outer(&mut m, 1.0, &blocks.row(*j, r));
        }
    }
    m
}

/// The objective's value for an information matrix; `None` where it is singular.
pub(super) fn value(blocks: &Blocks, objective: &Objective, m: &[f64]) -> Option<f64> {
    let n = blocks.unknowns();
    let (inverse, log_det) = invert(m, n)?;
    Some(match objective {
        Objective::Determinant => -log_det,
        Objective::Trace(w) => dot(w, &inverse),
        Objective::Largest => largest(blocks, &inverse),
    })
}

/// The largest `x' M^-1 x` over all rows of all candidates.
fn largest(blocks: &Blocks, inverse: &[f64]) -> f64 {
    let (mut out, mut work) = (vec![0.0; blocks.count()], vec![0.0; blocks.count()]);
    let mut most = 0.0_f64;
    for r in 0..blocks.rows() {
        blocks.quadratic(r, r, inverse, &mut out, &mut work);
        most = out.iter().fold(most, |most, d| most.max(*d));
    }
    most
}

/// One start: random blocks first, then the most informative, then exchanges until none is worth it. `None` where no such design is regular.
pub(super) fn start(problem: &Problem<'_>, rng: &mut Pcg64Mcg) -> Option<Design> {
    let mut state = State::begin(problem, rng)?;
    match problem.objective {
        Objective::Largest => {
            state.sweeps(&Objective::Determinant);
            state.lower_the_largest();
        }
        objective => state.sweeps(objective),
    }
    let mut chosen = state.chosen;
    chosen.sort_unstable();
    let value = value(problem.blocks, problem.objective, &information(problem.blocks, problem.base, &chosen))?;
    Some(Design { chosen, value })
}

struct State<'a> {
    problem: &'a Problem<'a>,
    chosen: Vec<usize>,
    times_chosen: Vec<u32>,
    inverse: Vec<f64>,
    /// `x_jr' M^-1 x_js`, r <= s, for all j.
    spread: Vec<Vec<f64>>,
    /// `x_jr' M^-1 W M^-1 x_js`, r <= s, for all j; empty for determinants.
    effect: Vec<Vec<f64>>,
    work: Vec<f64>,
    /// For single rows: `x_j' M^-1 x_i` of the last chosen row that was looked at.
    cross: Vec<f64>,
}

/// Position of (r, s), r <= s, in a packed triangle.
fn packed(r: usize, s: usize) -> usize {
    s * (s + 1) / 2 + r
}

impl<'a> State<'a> {
    fn begin(problem: &'a Problem<'a>, rng: &mut Pcg64Mcg) -> Option<Self> {
        let (n, count, rows) = (problem.blocks.unknowns(), problem.blocks.count(), problem.blocks.rows());
        if count == 0 || problem.choose > count.saturating_mul(problem.most_repeats) {
            return None;
        }
        let mut state = State {
            problem,
            chosen: Vec::with_capacity(problem.choose),
            times_chosen: vec![0; count],
            inverse: Vec::new(),
            spread: vec![vec![0.0; count]; rows * (rows + 1) / 2],
            effect: Vec::new(),
            work: vec![0.0; count],
            cross: vec![0.0; if rows == 1 { count } else { 0 }],
        };
        // a third at random; the rest by the largest gain, on top of a little information everywhere that is taken away again
        while state.chosen.len() < problem.choose.div_ceil(3) {
            let j = ((u128::from(rng.next_u64()) * count as u128) >> 64) as usize;
            state.choose(j);
        }
        let mut m = information(problem.blocks, problem.base, &state.chosen);
        let little = 1e-6 * (0..n).map(|i| m[i * n + i]).fold(0.0_f64, f64::max).max(f64::MIN_POSITIVE);
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
            let best = largest_of(&gain).0;
            for r in 0..rows {
                state.update(&problem.blocks.row(best, r), 1.0);
            }
            state.choose(best);
        }
        state.refactor()?;
        Some(state)
    }

    fn choose(&mut self, j: usize) {
        if (self.times_chosen[j] as usize) < self.problem.most_repeats {
            self.times_chosen[j] += 1;
            self.chosen.push(j);
        }
    }

    /// Inverse and sums from scratch.
    fn refactor(&mut self) -> Option<()> {
        let blocks = self.problem.blocks;
        let (inverse, root, _) =
            inverse_and_root(&information(blocks, self.problem.base, &self.chosen), blocks.unknowns())?;
        self.inverse = inverse;
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

    /// `M^-1 W M^-1`.
    fn sandwich(&self, w: &[f64]) -> Vec<f64> {
        let n = self.problem.blocks.unknowns();
        let mut half = vec![0.0; n * n]; // M^-1 W, by rows, as M^-1 is symmetric
        for (out, row) in half.chunks_exact_mut(n).zip(self.inverse.chunks_exact(n)) {
            out.copy_from_slice(&times(w, row));
        }
        let mut full = vec![0.0; n * n];
        for (out, row) in full.chunks_exact_mut(n).zip(half.chunks_exact(n)) {
            out.copy_from_slice(&times(&self.inverse, row));
        }
        full
    }

    fn refresh_effect(&mut self, sandwich: &[f64]) {
        let (blocks, count) = (self.problem.blocks, self.problem.blocks.count());
        self.effect.resize(blocks.rows() * (blocks.rows() + 1) / 2, vec![0.0; count]);
        for s in 0..blocks.rows() {
            for r in 0..=s {
                blocks.quadratic(r, s, sandwich, &mut self.effect[packed(r, s)], &mut self.work);
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
    fn exchange(&mut self, at: usize, j: usize) {
        let blocks = self.problem.blocks;
        let i = self.chosen[at];
        for r in 0..blocks.rows() {
            self.update(&blocks.row(j, r), 1.0);
        }
        for r in 0..blocks.rows() {
            self.update(&blocks.row(i, r), -1.0);
        }
        self.times_chosen[i] -= 1;
        self.times_chosen[j] += 1;
        self.chosen[at] = j;
    }

    /// The same for single rows just after `best_for_determinant(at)`, whose sums it reuses: one pass over the candidates.
    fn exchange_single(&mut self, at: usize, j: usize) {
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
        for ((d, come), go) in self.spread[0].iter_mut().zip(&self.work).zip(&self.cross) {
            let go = go - share * come;
            *d += go * go * gone - come * come * came;
        }
        self.times_chosen[i] -= 1;
        self.times_chosen[j] += 1;
        self.chosen[at] = j;
    }

    /// Sweep over the chosen blocks until none has a better partner.
    fn sweeps(&mut self, objective: &Objective) {
        let n = self.problem.blocks.unknowns();
        let mut since_refactor = 0;
        for _ in 0..SWEEPS {
            let mut improved = false;
            for at in 0..self.chosen.len() {
                let (best, better) = match objective {
                    Objective::Trace(w) => {
                        let sandwich = self.sandwich(w);
                        if self.effect.is_empty() {
                            self.refresh_effect(&sandwich);
                        }
                        let (j, decrease) = self.best_for_trace(at, &sandwich);
                        (j, decrease > WORTH * dot(w, &self.inverse))
                    }
                    _ => {
                        let (j, ratio) = self.best_for_determinant(at);
                        (j, ratio > 1.0 + WORTH * n as f64)
                    }
                };
                if better && best != self.chosen[at] {
                    match objective {
                        Objective::Determinant if self.problem.blocks.rows() == 1 => self.exchange_single(at, best),
                        _ => self.exchange(at, best),
                    }
                    self.effect.clear();
                    improved = true;
                    since_refactor += 1;
                    if since_refactor >= 50 {
                        since_refactor = 0;
                        if self.refactor().is_none() {
                            return;
                        }
                    }
                }
            }
            if !improved {
                return;
            }
        }
    }

    /// May `j` come in for the block at `at`?
    fn allowed(&self, j: usize) -> bool {
        (self.times_chosen[j] as usize) < self.problem.most_repeats
    }

    /// The candidate with the largest score, among all or the neighbours.
    fn best_of(&self, at: usize, score: impl Fn(usize) -> f64) -> (usize, f64) {
        let mut best = (self.chosen[at], 0.0);
        let mut try_one = |j: usize| {
            let value = score(j);
            if value > best.1 && self.allowed(j) {
                best = (j, value);
            }
        };
        match self.problem.neighbours.get(self.chosen[at]) {
            Some(list) => list.iter().for_each(|j| try_one(*j)),
            None => (0..self.problem.blocks.count()).for_each(try_one),
        }
        best
    }

    /// `x_jr' B x_is` for every candidate j and the rows of block i.
    fn cross(&self, i: usize, b: &[f64]) -> Vec<Vec<f64>> {
        let blocks = self.problem.blocks;
        let mut cross = Vec::with_capacity(blocks.rows() * blocks.rows());
        for s in 0..blocks.rows() {
            let w = times(b, &blocks.row(i, s));
            for r in 0..blocks.rows() {
                let mut out = vec![0.0; blocks.count()];
                blocks.along(r, &w, &mut out);
                cross.push(out);
            }
        }
        cross
    }

    fn best_for_determinant(&mut self, at: usize) -> (usize, f64) {
        let (blocks, i) = (self.problem.blocks, self.chosen[at]);
        if blocks.rows() == 1 {
            let w = times(&self.inverse, &blocks.row(i, 0));
            blocks.along(0, &w, &mut self.cross);
            let (spread, cross) = (&self.spread[0], &self.cross);
            let remaining = 1.0 - spread[i];
            if self.problem.most_repeats >= self.chosen.len() && self.problem.neighbours.is_empty() {
                let terms = self.work.iter_mut().zip(spread).zip(cross);
                terms.for_each(|((ratio, d), b)| *ratio = (1.0 + d) * remaining + b * b);
                return largest_of(&self.work);
            }
            return self.best_of(at, |j| (1.0 + spread[j]) * remaining + cross[j] * cross[j]);
        }
        let cross = self.cross(i, &self.inverse);
        self.best_of(at, |j| {
            let mut bordered = self.bordered(i, j, &self.spread, &cross, true);
            let size = 2 * blocks.rows();
            determinant_and_trace(&mut bordered, &mut vec![0.0; size * size], size).0.abs()
        })
    }

    fn best_for_trace(&mut self, at: usize, sandwich: &[f64]) -> (usize, f64) {
        let (blocks, i) = (self.problem.blocks, self.chosen[at]);
        let cross = self.cross(i, &self.inverse);
        let cross_effect = self.cross(i, sandwich);
        if blocks.rows() == 1 {
            let (spread, effect, b, g) = (&self.spread[0], &self.effect[0], &cross[0], &cross_effect[0]);
            let (di, fi) = (spread[i], effect[i]);
            return self.best_of(at, |j| {
                let ratio = (1.0 + spread[j]) * (1.0 - di) + b[j] * b[j];
                let gain = (1.0 - di) * effect[j] + 2.0 * b[j] * g[j] - (1.0 + spread[j]) * fi;
                if ratio > 1e-9 { gain / ratio } else { 0.0 }
            });
        }
        self.best_of(at, |j| {
            let size = 2 * blocks.rows();
            let mut bordered = self.bordered(i, j, &self.spread, &cross, true);
            let mut effect = self.bordered(i, j, &self.effect, &cross_effect, false);
            let (determinant, trace) = determinant_and_trace(&mut bordered, &mut effect, size);
            if determinant.abs() > 1e-9 { trace } else { 0.0 }
        })
    }

    /// `[Xj; Xi] B [Xj; Xi]'`, with `S` added or not.
    fn bordered(&self, i: usize, j: usize, own: &[Vec<f64>], cross: &[Vec<f64>], with_signs: bool) -> Vec<f64> {
        let k = self.problem.blocks.rows();
        let size = 2 * k;
        let mut t = vec![0.0; size * size];
        for s in 0..k {
            for r in 0..k {
                let (low, high) = (r.min(s), r.max(s));
                t[r * size + s] = own[packed(low, high)][j];
                t[(k + r) * size + k + s] = own[packed(low, high)][i];
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
        t
    }

    /// Exchanges that lower the largest `x' M^-1 x`, tried with the candidates that have the largest values now.
    fn lower_the_largest(&mut self) {
        const PARTNERS: usize = 12;
        let (blocks, n) = (self.problem.blocks, self.problem.blocks.unknowns());
        let mut now = largest(blocks, &self.inverse);
        for _ in 0..SWEEPS {
            let mut improved = false;
            for at in 0..self.chosen.len() {
                let most = |j: usize| (0..blocks.rows()).map(|r| self.spread[packed(r, r)][j]).fold(0.0, f64::max);
                let mut partners: Vec<usize> = (0..blocks.count()).filter(|j| self.allowed(*j)).collect();
                partners.sort_by(|&a, &b| most(b).total_cmp(&most(a)));
                let mut best: Option<(usize, f64)> = None;
                for &j in partners.iter().take(PARTNERS) {
                    let mut trial = self.chosen.clone();
                    trial[at] = j;
                    let m = information(blocks, self.problem.base, &trial);
                    let Some((inverse, _)) = invert(&m, n) else { continue };
                    let value = largest(blocks, &inverse);
                    if value < now * (1.0 - WORTH) && best.is_none_or(|(_, before)| value < before) {
                        best = Some((j, value));
                    }
                }
                if let Some((j, value)) = best {
                    self.exchange(at, j);
                    now = value;
                    improved = true;
                }
            }
            if !improved || self.refactor().is_none() {
                return;
            }
        }
    }
}
