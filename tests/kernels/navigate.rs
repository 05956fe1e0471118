//! What the causes of navigation errors are judged by: the score of sets of columns, and their least squares on inner products.

#[path = "../../src/diagnosis/factor.rs"]
mod factor;
#[path = "../../src/navigate/products.rs"]
mod products;
#[path = "../../src/diagnosis/score.rs"]
mod score;

use crate::linear::dot;
use factor::Factor;
use faer::Mat;
use products::{Products, penalty};
use score::{Kernel, Priors, Problem, Score};

fn unit(column: Vec<f64>) -> Vec<f64> {
    let norm = dot(&column, &column).sqrt();
    column.into_iter().map(|v| v / norm).collect()
}

fn shared(columns: &[Vec<f64>]) -> Vec<std::rc::Rc<Vec<f64>>> {
    columns.iter().cloned().map(std::rc::Rc::new).collect()
}

#[test]
fn five_correlated_columns_come_out_of_sixty() {
    let line = |f: &dyn Fn(f64) -> f64| unit((0..400).map(|i| f(f64::from(i) / 400.0)).collect());
    let columns: Vec<Vec<f64>> = (0..60).map(|k| line(&|x| (x * (1.0 + 3.5 * f64::from(k))).sin() + 0.2 * x)).collect();
    let noise: Vec<f64> = (0..400).map(|i| 1.4 * (1e4 * f64::from(i) * f64::from(i)).sin()).collect();
    let mut residual = noise.clone();
    for (k, size) in [(3, 300.0), (14, -200.0), (25, 150.0), (40, 90.0), (55, 60.0)] {
        residual.iter_mut().zip(&columns[k]).for_each(|(r, c)| *r += size * c);
    }
    let found = |residual: &[f64]| {
        let matrix = Mat::from_fn(400, 60, |i, j| columns[j][i]);
        let priors = Priors { most: 12, ..Priors::at(0.01) };
        let odds = priors.shared(vec![0.0; 60], |_| 1.0);
        let none = Mat::zeros(400, 0);
        let mut score = Score::new(
            &Problem {
                residual,
                basis: none.as_ref(),
                columns: matrix.as_ref(),
                prior: &odds,
                plain: &[f64::INFINITY; 60],
                fixed: &[],
                kinds: &[],
                known: true,
                kernels: &[],
                sharing: None,
            },
            priors,
        );
        score.search(&[]);
        let mut set = score.posterior().sets.swap_remove(0).1.to_vec();
        set.sort_unstable();
        set
    };
    assert_eq!(found(&residual), [3, 14, 25, 40, 55]);
    assert!(Products::new(shared(&columns), &residual).rivals(&[3, 14, 25, 40, 55], 0, 9.0).is_empty());
    assert!(found(&noise).is_empty());
}

#[test]
fn the_penalty_is_the_square_of_a_quantile() {
    // 2 (1 - Phi(2.5758)) = 0.01
    assert!((penalty(0.01, 1) - 2.575_829_3_f64.powi(2)).abs() < 1e-5);
}

/// Groups that deviate each by itself, of three rows each and of one, unequally large, beside a model of a mean and a slope: kept by their rows they say what
/// they say as columns of all rows.
#[test]
fn kernels_kept_by_their_rows_are_those_of_full_columns() {
    const N: usize = 60;
    let place = |i: usize| i as f64 - 29.5;
    let (mean, slope) = (unit(vec![1.0; N]), unit((0..N).map(place).collect()));
    let basis = Mat::from_fn(N, 2, |i, j| if j == 0 { mean[i] } else { slope[i] });
    let columns = Mat::from_fn(N, 4, |i, j| (0.7 * (j + 1) as f64 * place(i)).sin() + 0.1 * place(i));
    let priors = Priors::at(0.01);
    let odds = priors.shared(vec![0.0; 4], |_| 1.0);
    for rows in [3, 1] {
        let groups: Vec<Vec<(usize, f64)>> =
            (0..N / rows).map(|g| (0..rows).map(|k| (rows * g + k, 1.0 + 0.1 * (g % 4) as f64)).collect()).collect();
        let common = |i: usize| 4.0 * (12.9898 * (i / rows) as f64).sin();
        let residual: Vec<f64> =
            (0..N).map(|i| common(i) + (78.233 * i as f64).sin() + 6.0 * columns[(i, 2)]).collect();
        let score = |factor: Factor| {
            let kernel = Kernel { follows: None, per_mounting: false, one_of: 1, factor, sensor: None };
            let problem = Problem {
                residual: &residual,
                basis: basis.as_ref(),
                columns: columns.as_ref(),
                prior: &odds,
                plain: &[f64::INFINITY; 4],
                fixed: &[],
                kinds: &[],
                known: true,
                kernels: &[kernel],
                sharing: None,
            };
            let mut score = Score::new(&problem, priors);
            let remainder = score.foremost(&[0, 2]);
            let t = score.solved(remainder, &[0, 2]).unwrap().t;
            let values = [&[][..], &[2], &[0, 2]].map(|set| score.remainder(set));
            (values, [&[][..], &[2], &[0, 2]].map(|set| score.of(set)), t)
        };
        let apart = score(Factor::Apart(groups.clone()));
        let full = score(Factor::Dense(Factor::Apart(groups).dense(N)));
        // the remainder is what the readings have: none of it is left out
        assert!(full.0.iter().all(|odds| *odds > 3.0), "{:?}", full.0);
        let pairs = apart.0.iter().chain(&apart.1).chain(&apart.2).zip(full.0.iter().chain(&full.1).chain(&full.2));
        for (a, b) in pairs {
            // sixty rows: the rounding of sums, and of eigenvalues of a projected matrix
            assert!((a - b).abs() < 1e-9 * b.abs().max(1.0), "{rows}: {apart:?} {full:?}");
        }
    }
}
