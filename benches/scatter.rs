//! What scatter costs beside the plain adjustment, one thread: stated lines at many positions, an estimated one at few, and growth with the rows.
//!
//! `cargo bench --bench scatter`. The first column of the design is a constant; positions are felt through columns of sines.

use criterion::{Criterion, criterion_group, criterion_main};
use std::hint::black_box;
use tumble::estimate::{Felt, Group, ScatterLine, Settings, System, adjust, adjust_scattered};

fn noise(i: usize) -> f64 {
    (i * i * 7919 + 13) as f64 * 0.618_034 % 2.0 - 1.0
}

/// `positions` x 6 sensors, `n` unknowns, three joints felt at each position.
fn imu(positions: usize, n: usize) -> (System, Vec<ScatterLine>) {
    let m = 6 * positions;
    let derivative =
        |i: usize, j: usize| if j % 6 == i % 6 { ((i / 6) as f64 * 0.7 * (1 + j / 6) as f64 + 0.3).sin() } else { 0.0 };
    let system = System {
        rows: faer::Mat::from_fn(m, n, derivative),
        observed: (0..m).map(noise).collect(),
        u: vec![0.5; m],
        group: vec![Group::Known; m],
    };
    let joint = |k: usize| {
        let by = |i: usize| (i as f64 * 1.3 + k as f64).cos();
        let felt = (0..m).map(|row| Felt { row, level: row / 6, by: by(row) }).collect();
        ScatterLine { felt, variance: Some(0.3), memory: None }
    };
    (system, (0..3).map(joint).collect())
}

/// `rows` readings at 38 positions, six unknowns, one estimated offset a position.
fn positions(rows: usize) -> (System, Vec<ScatterLine>) {
    let system = System {
        rows: faer::Mat::from_fn(rows, 6, |i, j| ((i % 38) as f64 * 0.4 * j as f64 + 0.2).cos()),
        observed: (0..rows).map(|i| noise(i) + noise(i % 38)).collect(),
        u: vec![1.0; rows],
        group: vec![Group::Estimated(0); rows],
    };
    let felt = (0..rows).map(|row| Felt { row, level: row % 38, by: 1.0 }).collect();
    (system, vec![ScatterLine { felt, variance: None, memory: None }])
}

fn scatter(criterion: &mut Criterion) {
    let settings = Settings::default();
    let mut group = criterion.benchmark_group("scatter");
    group.sample_size(10);
    for (count, n) in [(100, 40), (20_000, 40)] {
        let (system, lines) = imu(count, n);
        group.bench_function(format!("{count} positions x 6 sensors, plain"), |b| {
            b.iter(|| adjust(black_box(&system), &settings))
        });
        group.bench_function(format!("{count} positions x 6 sensors, 3 angles stated"), |b| {
            b.iter(|| adjust_scattered(black_box(&system), &lines, None, &[], &settings));
        });
    }
    for rows in [1_000, 10_000, 32_895, 100_000, 1_000_000] {
        let (system, lines) = positions(rows);
        group.bench_function(format!("{rows} readings at 38 positions, estimated"), |b| {
            b.iter(|| adjust_scattered(black_box(&system), &lines, None, &[], &settings));
        });
    }
}

criterion_group!(benches, scatter);
criterion_main!(benches);
