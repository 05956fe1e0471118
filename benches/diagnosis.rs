//! The scores of 200 candidates of 2,000 readings by themselves and a whole diagnosis of the published Table 1.

use criterion::{Criterion, criterion_group, criterion_main};
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::{Pcg64Mcg, rand_core::SeedableRng};
use tumble::diagnosis::{Pool, Settings, diagnose};
use tumble::wire::{self, Source};

fn selection(bench: &mut Criterion) {
    let mut generator = Pcg64Mcg::seed_from_u64(4);
    let mut normal = || -> f64 { StandardNormal.sample(&mut generator) };
    let columns = faer::Mat::from_fn(2000, 200, |_, _| normal());
    let q = faer::Mat::from_fn(2000, 6, |i, j| if i % 6 == j { (6.0_f64 / 2000.0).sqrt() } else { 0.0 });
    let residual: Vec<f64> = (0..2000).map(|i| columns[(i, 17)] + 0.5 * columns[(i, 99)] + 0.1 * normal()).collect();
    bench.bench_function("200 candidates, 2000 readings: columns to scores", |b| {
        b.iter_batched(
            || columns.clone(),
            |columns| Pool::new(columns, q.as_ref(), &residual),
            criterion::BatchSize::LargeInput,
        )
    });
}

fn table_1(bench: &mut Criterion) {
    let text = include_str!("../examples/05-table-1-diagnosed/table1.campaign.json");
    let source = Source { name: "table 1".into(), text: text.into() };
    let campaign = wire::read_campaign(&source, &mut |_| unreachable!("a built-in bench")).unwrap();
    let catalogue = wire::built_in_effects().unwrap();
    bench.bench_function("diagnose Table 1", |b| {
        b.iter(|| diagnose(&campaign, &catalogue, &Settings::default()).unwrap())
    });
}

criterion_group!(benches, selection, table_1);
criterion_main!(benches);
