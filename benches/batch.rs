//! Many devices through one schedule, 30 readings in 6 unknowns: the fitting alone, with all checks and uncertainties, and with nothing shared.
//!
//! Beside numpy in one run: `benches/peers/devices.py`.

#[path = "cases/mod.rs"]
mod cases;

use cases::{Line, devices};
use criterion::{Criterion, criterion_group, criterion_main};
use std::hint::black_box;
use tumble::batch::{Device, Fleet};
use tumble::fit::Settings;

const COUNT: usize = 10_000;

fn batch(criterion: &mut Criterion) {
    let line = Line::new();
    let question = |device: &Device| line.campaign(device);
    let mut group = criterion.benchmark_group("devices");
    group.sample_size(10);
    let (common, own) = (devices(COUNT, false), devices(100, true));
    group.bench_function("10000 of one schedule, all checks and u", |bencher| {
        bencher.iter(|| Fleet::new(&question, Settings::default(), 6).fit(black_box(&common), &line.layout));
    });
    group.bench_function("100 of own schedules, all checks and u", |bencher| {
        bencher.iter(|| Fleet::new(&question, Settings::default(), 6).fit(black_box(&own), &line.layout));
    });
    group.finish();
}

criterion_group!(benches, batch);
criterion_main!(benches);
