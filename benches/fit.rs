//! How long one adjustment takes with all its diagnostics: 30 readings in 6 unknowns, and larger ones.

use criterion::{Criterion, criterion_group, criterion_main};
use std::hint::black_box;
use tumble::estimate::{Fold, Group, Settings, System, adjust};

/// Rows like those of a rate table: constants, sines and cosines of evenly spread positions.
fn system(m: usize, n: usize) -> System {
    let derivative = |i: usize, j: usize| {
        let angle = i as f64 * 0.7 + 0.1;
        match j {
            0 => 1.0,
            _ if j % 2 == 1 => (angle * j.div_ceil(2) as f64).sin() * 30.0,
            _ => (angle * j.div_ceil(2) as f64).cos() * 30.0,
        }
    };
    System {
        rows: faer::Mat::from_fn(m, n, derivative),
        // Spread evenly over -1..1 in no particular order.
        observed: (0..m).map(|i| (i * i * 7919 + 13) as f64 * 0.618_034 % 2.0 - 1.0).collect(),
        u: vec![0.9e-3; m],
        group: vec![Group::Estimated(0); m],
    }
}

fn fit(criterion: &mut Criterion) {
    let settings = Settings::default();
    for (m, n) in [(30, 6), (200, 12), (10_000, 20)] {
        let system = system(m, n);
        criterion.bench_function(&format!("adjust {m} x {n}"), |bencher| {
            bencher.iter(|| adjust(black_box(&system), &settings));
        });
    }
    let mut mixed = system(30, 6);
    mixed.group.iter_mut().skip(15).for_each(|group| *group = Group::Estimated(1));
    criterion.bench_function("adjust 30 x 6, two groups", |bencher| {
        bencher.iter(|| adjust(black_box(&mixed), &settings));
    });
    let block = system(64, 6);
    criterion.bench_function("fold 64 x 6", |bencher| {
        let mut fold = Fold::new(6);
        bencher.iter(|| fold.push(block.rows.as_ref(), &block.observed, &block.u));
    });
}

criterion_group!(benches, fit);
criterion_main!(benches);
