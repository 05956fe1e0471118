//! The search for the causes of navigation errors, by products of columns.

#[path = "../../src/navigate/search.rs"]
mod search;

use crate::linear::dot;
use search::{Products, penalty};

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
    let products = Products::new(shared(&columns), &residual, vec![0.0; 60], penalty(0.01, 60));
    let mut set = products.improve(Vec::new(), 12);
    set.sort_unstable();
    assert_eq!(set, [3, 14, 25, 40, 55]);
    assert!(products.rivals(&set, 0, 9.0).is_empty());
    let products = Products::new(shared(&columns), &noise, vec![0.0; 60], penalty(0.01, 60));
    assert!(products.improve(Vec::new(), 12).is_empty());
}

#[test]
fn the_penalty_is_the_square_of_a_quantile() {
    // 2 (1 - Phi(2.5758)) = 0.01
    assert!((penalty(0.01, 1) - 2.575_829_3_f64.powi(2)).abs() < 1e-5);
}
