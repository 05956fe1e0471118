//! How long it takes to choose 12 of 1,000 candidates in 8 unknowns: one start, 100 starts, and with the bound.

use criterion::{Criterion, criterion_group, criterion_main};
use std::hint::black_box;
use tumble::plan::{Blocks, Objective, choose};

/// Rows of sines and cosines at 1,000 positions in no particular order: the same numbers as in tests/scripts/plan_numpy.py.
fn candidates() -> Blocks {
    Blocks::from_fn(1000, 1, 8, |j, _, c| {
        let angle = (j as f64 * 0.618_034) % 1.0 * std::f64::consts::TAU;
        let other = (j as f64 * 0.754_877_666) % 1.0 * std::f64::consts::TAU;
        match c {
            0 => 1.0,
            1 => angle.cos(),
            2 => angle.sin(),
            3 => other.cos(),
            4 => other.sin(),
            5 => angle.cos() * other.cos(),
            6 => angle.sin() * other.sin(),
            _ => (2.0 * angle).cos(),
        }
    })
}

fn plan(criterion: &mut Criterion) {
    let blocks = candidates();
    criterion.bench_function("12 of 1000 x 8, one start", |bencher| {
        let mut seed = 0;
        bencher.iter(|| {
            seed += 1;
            choose(black_box(&blocks), 12, usize::MAX, &Objective::Determinant, 1, seed, false)
        });
    });
    criterion.bench_function("12 of 1000 x 8, 100 starts", |bencher| {
        bencher.iter(|| choose(black_box(&blocks), 12, usize::MAX, &Objective::Determinant, 100, 1, false));
    });
    let sum = Objective::Trace((0..64).map(|k| if k % 9 == 0 { 1.0 } else { 0.0 }).collect());
    criterion.bench_function("12 of 1000 x 8, one start, sum of variances", |bencher| {
        bencher.iter(|| choose(black_box(&blocks), 12, usize::MAX, &sum, 1, 1, false));
    });
    criterion.bench_function("bound for 12 of 1000 x 8", |bencher| {
        bencher.iter(|| choose(black_box(&blocks), 12, usize::MAX, &Objective::Determinant, 1, 1, true));
    });
}

criterion_group!(benches, plan);
criterion_main!(benches);
