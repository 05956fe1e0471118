//! How long one adjustment takes with all its diagnostics: 30 readings in 6 unknowns, and larger ones.

#[path = "cases/mod.rs"]
mod cases;

use cases::system;
use criterion::{Criterion, criterion_group, criterion_main};
use std::hint::black_box;
use tumble::estimate::{Fold, Group, Settings, adjust};

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
