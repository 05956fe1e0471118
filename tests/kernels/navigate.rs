//! What the causes of navigation errors are judged by: the score of sets of columns, and their least squares on inner products.

#[path = "../../src/navigate/products.rs"]
mod products;
#[path = "../../src/diagnosis/score.rs"]
mod score;

use crate::linear::dot;
use faer::Mat;
use products::{Products, penalty};
use score::{Priors, Problem, Score};

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
        let mut set = score.posterior().sets.swap_remove(0).1;
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
