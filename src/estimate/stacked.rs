//! Many systems of one shape, each with a design of its own: estimates and uncertainties, eight systems side by side.
#![allow(
    clippy::indexing_slicing,
    reason = "`adjust_stacked` compares the numbers of rows, observations and u with the shape before any of them is read; a lane has `LANES` numbers"
)]

use super::eight::{Eight, LANES};
use super::{Group, Settings, System, adjust};
use crate::error::{Fault, Malformed, Result};
use faer::Mat;
use pulp::Arch;

/// Above this condition number a system is adjusted by itself, with the rank decision and the refinement of [`adjust`].
const ILL: f64 = 1e4;

/// Estimates of many systems, one after the other.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Stacked {
    /// Estimates of the unknowns, `systems x n`; of a rank defect a basic solution, as in [`super::Unknowns::solution`].
    pub solution: Vec<f64>,
    /// Their standard uncertainties, `systems x n`; NaN where an unknown is not estimable, or the scatter cannot be estimated.
    pub standard_uncertainty: Vec<f64>,
    /// `sum (v/u)^2` of each system.
    pub sum_of_squares: Vec<f64>,
    /// Independent columns of each system.
    pub rank: Vec<usize>,
}

/// Adjusts many systems of one shape `(m, n)`: [`adjust`] of each, without what belongs to single rows.
///
/// `rows` are `systems x m x n` numbers, the last running fastest; `observed` are `systems x m`; `u` as many, or `m` for all systems alike, or
/// none for 1. With [`Group::Estimated`] the scale of each system is estimated from its residuals. Results are those of [`adjust`] to the rounding
/// of its weighted rows; ill-conditioned and deficient systems go through it.
///
/// Errors: numbers of values that are no multiples of the shape; those of [`adjust`] for the first system that it refuses.
///
/// ```
/// use tumble::estimate::{Group, Settings, adjust_stacked};
/// // two straight lines, through (0, 1), (1, 3), (2, 4) and through (0, 0), (2, 1), (4, 2)
/// let rows = [1.0, 0.0, 1.0, 1.0, 1.0, 2.0, 1.0, 0.0, 1.0, 2.0, 1.0, 4.0];
/// let found = adjust_stacked(&rows, &[1.0, 3.0, 4.0, 0.0, 1.0, 2.0], &[], (3, 2), Group::Estimated(0), &Settings::default())?;
/// assert!((found.solution[0] - 7.0 / 6.0).abs() < 1e-14 && (found.solution[3] - 0.5).abs() < 1e-14);
/// assert!((found.standard_uncertainty[1].powi(2) - 1.0 / 12.0).abs() < 1e-14);
/// # Ok::<(), tumble::error::Malformed>(())
/// ```
pub fn adjust_stacked(
    rows: &[f64],
    observed: &[f64],
    u: &[f64],
    (m, n): (usize, usize),
    group: Group,
    settings: &Settings,
) -> Result<Stacked> {
    let count = observed.len() / m.max(1);
    let refuse = |what: &str, expected: usize, found: usize| {
        Err(Malformed::new(Fault::Value, format!("the stack's '{what}' has the wrong length"))
            .at_path(what)
            .expected(expected.to_string())
            .found(found.to_string()))
    };
    if m == 0 || observed.len() != count * m {
        return refuse("observed", count * m, observed.len());
    }
    if rows.len() != count * m * n {
        return refuse("rows", count * m * n, rows.len());
    }
    if !(u.is_empty() || u.len() == m || u.len() == observed.len()) {
        return refuse("u", observed.len(), u.len());
    }
    let mut found = Stacked {
        solution: vec![0.0; count * n],
        standard_uncertainty: vec![f64::NAN; count * n],
        sum_of_squares: vec![0.0; count],
        rank: vec![n; count],
    };
    let (arch, mut eight) = (Arch::new(), Eight::default());
    eight.shape(m, n);
    let own_u = |k: usize| match u.len() {
        0 => &[][..],
        all if all == m => u,
        _ => &u[k * m..(k + 1) * m],
    };
    // a tolerance far above rounding decides ranks itself
    let fits = m > n && n > 0 && settings.rank_tolerance.is_none_or(|t| t * ILL < 1.0);
    for first in (0..count).step_by(LANES) {
        let here = LANES.min(count - first);
        if fits {
            fill(&mut eight, rows, observed, own_u, (first, here), (m, n));
            eight.solve(arch, false);
        }
        for l in 0..here {
            let k = first + l;
            let finite = fits && eight.condition[l] < ILL && read(&eight, l, group, (m, n), k, &mut found);
            if !finite {
                let system = System {
                    rows: Mat::from_fn(m, n, |i, j| rows[(k * m + i) * n + j]),
                    observed: observed[k * m..(k + 1) * m].to_vec(),
                    u: if u.is_empty() { vec![1.0; m] } else { own_u(k).to_vec() },
                    group: vec![if group == Group::Known { Group::Known } else { Group::Estimated(0) }; m],
                };
                let single = adjust(&system, settings).map_err(|error| error.under(&format!("system {k}")))?;
                found.solution[k * n..(k + 1) * n].copy_from_slice(&single.unknowns.solution);
                let slots = &mut found.standard_uncertainty[k * n..(k + 1) * n];
                slots
                    .iter_mut()
                    .zip(&single.unknowns.standard_uncertainty)
                    .for_each(|(slot, u)| *slot = u.unwrap_or(f64::NAN));
                (found.sum_of_squares[k], found.rank[k]) = (single.sum_of_squares, single.unknowns.rank);
            }
        }
    }
    Ok(found)
}

/// Eight systems into their places; where there are fewer, the last one again.
fn fill<'a>(
    eight: &mut Eight,
    rows: &[f64],
    observed: &[f64],
    u: impl Fn(usize) -> &'a [f64],
    (first, here): (usize, usize),
    (m, n): (usize, usize),
) {
    let system = |l: usize| first + l.min(here - 1);
    let size = m * n;
    let own: [&[f64]; LANES] = std::array::from_fn(|l| &rows[system(l) * size..][..size]);
    for (j, column) in eight.rows.chunks_exact_mut(m).enumerate() {
        for (i, to) in column.iter_mut().enumerate() {
            let t = i * n + j;
            // said once for all eight, so that it is not asked of each
            if t >= size {
                break;
            }
            *to = own.map(|own| own[t]);
        }
    }
    let own: [&[f64]; LANES] = std::array::from_fn(|l| &observed[system(l) * m..][..m]);
    for (i, to) in eight.observed.iter_mut().enumerate().take(m) {
        *to = own.map(|own| own[i]);
    }
    for l in 0..LANES {
        let u = u(system(l));
        if u.is_empty() {
            eight.weight.iter_mut().for_each(|to| to[l] = 1.0);
        }
        // what is no uncertainty makes no weight, and no condition number
        eight.weight.iter_mut().zip(u).for_each(|(to, u)| to[l] = if *u > 0.0 { 1.0 / u } else { f64::NAN });
    }
}

/// What was found of one system; are all of its numbers finite?
fn read(eight: &Eight, l: usize, group: Group, (m, n): (usize, usize), k: usize, found: &mut Stacked) -> bool {
    let squares = eight.squares[l];
    let variance = if group == Group::Known { 1.0 } else { squares / (m - n) as f64 };
    let mut all = squares;
    let own = found.solution[k * n..].iter_mut().zip(&mut found.standard_uncertainty[k * n..]);
    for ((x, u), (solution, own)) in own.zip(eight.solution.iter().zip(&eight.variance)) {
        (*x, *u) = (solution[l], (own[l] * variance).sqrt());
        all += *x * 0.0 + *u * 0.0;
    }
    found.sum_of_squares[k] = squares;
    all.is_finite()
}
