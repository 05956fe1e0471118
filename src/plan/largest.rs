//! Exchanges for the G criterion: the largest variance of a predicted reading is not smooth in the design, so partners are tried one by one.

use super::blocks::{Blocks, add_outer, invert};
use super::exchange::{SWEEPS, WORTH, information};
use super::state::State;

/// Partners that are tried first: those whose own reading is predicted worst.
const PARTNERS: usize = 12;
/// With at most so many candidates, all are tried before a chosen block is left as it is.
const ALL: usize = 400;

/// Exchanges that lower the largest `x' M^-1 x` over the predicted rows.
pub(super) fn lower(state: &mut State<'_>, predicted: &Blocks) {
    let (blocks, n) = (state.problem.blocks, state.problem.blocks.unknowns());
    let mut now = predicted.largest_quadratic(&state.inverse);
    let mut spread = vec![0.0_f64; blocks.count()];
    for _ in 0..SWEEPS {
        let mut improved = false;
        for at in 0..state.chosen.len() {
            spread.fill(0.0);
            for r in 0..blocks.rows() {
                let own = &state.spread[super::state::packed(r, r)];
                spread.iter_mut().zip(own).for_each(|(most, d)| *most = most.max(*d));
            }
            let mut partners: Vec<usize> = (0..blocks.count()).filter(|j| state.allowed(at, *j)).collect();
            partners.sort_by(|&a, &b| spread[b].total_cmp(&spread[a]));
            let mut without = information(blocks, state.problem.base, &state.chosen);
            for r in 0..blocks.rows() {
                add_outer(&mut without, -1.0, &blocks.row(state.chosen[at], r));
            }
            let mut best: Option<(usize, f64)> = None;
            for (tried, &j) in partners.iter().enumerate() {
                if tried >= PARTNERS && (best.is_some() || partners.len() > ALL) {
                    break;
                }
                let mut m = without.clone();
                for r in 0..blocks.rows() {
                    add_outer(&mut m, 1.0, &blocks.row(j, r));
                }
                let Some((inverse, _)) = invert(&m, n) else { continue };
                let value = predicted.largest_quadratic(&inverse);
                if value < now * (1.0 - WORTH) && best.is_none_or(|(_, before)| value < before) {
                    best = Some((j, value));
                }
            }
            if let Some((j, value)) = best {
                state.exchange(at, j);
                now = value;
                improved = true;
            }
        }
        if !improved || state.refactor().is_none() {
            return;
        }
    }
}
