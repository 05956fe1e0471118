//! What the adjustment is made of: compensated sums, conditions, small factorisations, eight systems at a time.

#[path = "../../src/estimate/compensated.rs"]
mod compensated;
#[path = "../../src/estimate/eight.rs"]
pub(crate) mod eight;
#[path = "../../src/estimate/pivoted.rs"]
mod pivoted;

pub(crate) use compensated::Sum;

use crate::linear::{condition, short_dot};
use compensated::{accumulate, compensated_dot};
use eight::{Eight, LANES};
use faer::Mat;
use pulp::Arch;
use tumble::estimate::{Group, Settings, System, adjust};

#[test]
fn cancellation_leaves_the_exact_rest() {
    // 1e16 + 3 - 1e16 + 0.01 - 0.01: plain summation gives 4.
    let a = [1e8, 3.0, -1e8, 0.1, -0.1];
    let b = [1e8, 1.0, 1e8, 0.1, 0.1];
    assert_eq!(compensated_dot(&a, &b), 3.0);
}

#[test]
fn sums_keep_what_is_small_beside_them() {
    let mut sum = Sum::default();
    [1.0, 1e100, 1.0, -1e100].into_iter().for_each(|x| sum.add(x));
    assert_eq!(sum.value(), 2.0);
}

#[test]
fn accumulating_keeps_what_plain_sums_lose() {
    let (mut high, mut low) = (vec![1e20, 1.0], vec![0.0, 0.0]);
    accumulate(&mut high, &mut low, 3.0, &[1.0, 1e-20]);
    accumulate(&mut high, &mut low, -1e10, &[1e10, 0.0]);
    assert_eq!(high[0] + low[0], 3.0);
    assert!((low[1] / 3e-20 - 1.0).abs() < 1e-15);
}

#[test]
fn the_condition_of_a_triangle_known_in_closed_form() {
    // [[1, 1], [0, 1]]: singular values are the golden ratio and its reciprocal.
    let r = Mat::from_fn(2, 2, |i, j| if i <= j { 1.0 } else { 0.0 });
    let golden: f64 = (1.0 + 5.0_f64.sqrt()) / 2.0;
    assert!((condition(&r).unwrap() / golden.powi(2) - 1.0).abs() < 1e-9);
    assert_eq!(condition(&Mat::new()), None);
}

/// Solutions, residuals, leverages and cofactors of eight systems are those of `adjust`, and a pair of equal columns shows in the condition.
#[test]
fn eight_are_each_by_itself() {
    let (m, n) = (14, 5);
    let number = |i: usize, j: usize, l: usize| ((i * i * 31 + j * 17 + i * j * 7 + l * 101 + 1) as f64 * 0.37).sin();
    let mut eight = Eight::default();
    eight.shape(m, n);
    for l in 0..LANES {
        for i in 0..m {
            for j in 0..n {
                eight.rows[j * m + i][l] =
                    10f64.powi(j as i32 - 2) * number(i, if l == 7 && j == 4 { 0 } else { j }, l);
            }
            eight.observed[i][l] = number(i, 77, l);
            eight.weight[i][l] = 1.0 / (0.5 + number(i, 99, l).powi(2));
        }
    }
    eight.solve(Arch::new());
    assert!(!(eight.condition[7] < 1e9), "{:?}", eight.condition);
    for l in 0..LANES - 1 {
        let system = System {
            rows: Mat::from_fn(m, n, |i, j| eight.rows[j * m + i][l]),
            observed: (0..m).map(|i| eight.observed[i][l]).collect(),
            u: (0..m).map(|i| 1.0 / eight.weight[i][l]).collect(),
            group: vec![Group::Known; m],
        };
        let single = adjust(&system, &Settings::default()).unwrap();
        let condition = single.unknowns.condition().unwrap();
        assert!(eight.condition[l] >= condition && eight.condition[l] < 5.0 * condition);
        for j in 0..n {
            let u = single.unknowns.standard_uncertainty[j].unwrap();
            assert!(
                (eight.solution[j][l] - single.unknowns.solution[j]).abs()
                    < 1e-13 * u.max(single.unknowns.solution[j].abs())
            );
            for i in 0..n {
                let (own, other) = (eight.cofactor(i, j, l), single.unknowns.cofactor[(i, j)]);
                assert!((own - other).abs() < 1e-13 * u * single.unknowns.standard_uncertainty[i].unwrap());
            }
        }
        let squares: f64 = (0..m).map(|i| (eight.residuals[i][l] * eight.weight[i][l]).powi(2)).sum();
        assert!((squares - single.sum_of_squares).abs() < 1e-13 * single.sum_of_squares);
        for i in 0..m {
            assert!((eight.residuals[i][l] - single.residuals[i]).abs() < 1e-14);
            assert!((eight.leverage[i][l] - single.leverage[i]).abs() < 1e-13);
            let square: f64 = (0..n).map(|j| eight.orthonormal(i, j, l).powi(2)).sum();
            assert!((eight.leverage[i][l] - square).abs() < 1e-13);
        }
    }
}

/// Columns of a Hilbert-like matrix, one of them twice: `Q R` gives them back, `Q` is orthonormal, and the rank is one less.
#[test]
fn factors_multiply_to_the_columns() {
    for (m, k) in [(7, 5), (5, 7), (30, 6), (4, 4), (1, 1), (3, 0)] {
        let mut a = Mat::from_fn(m, k, |i, j| ((i * i + 3 * j * i + 2 * j) as f64 * 0.37 + 0.1).sin());
        if k == 6 {
            let twin = a.col_as_slice(1).to_vec();
            a.col_as_slice_mut(4).copy_from_slice(&twin);
        }
        for j in 0..k {
            let norm = short_dot(a.col_as_slice(j), a.col_as_slice(j)).sqrt();
            a.col_as_slice_mut(j).iter_mut().for_each(|x| *x /= norm);
        }
        let active: Vec<usize> = (0..k).collect();
        let found = pivoted::pivoted_qr(&a, &active, 1e-13);
        assert_eq!(found.rank, if k == 6 { 5 } else { m.min(k) });
        let product = &found.q * &found.r;
        for (l, &j) in found.order.iter().enumerate() {
            for i in 0..m {
                assert!((product[(i, l)] - a[(i, j)]).abs() < 1e-14, "{m} x {k}");
            }
        }
        let unit = found.q.transpose() * &found.q;
        for i in 0..unit.nrows() {
            for j in 0..unit.ncols() {
                assert!((unit[(i, j)] - f64::from(u8::from(i == j))).abs() < 1e-14);
            }
        }
    }
}
