//! How long one evaluation of a compiled model line takes: value alone, and value with gradient.

use criterion::{Criterion, criterion_group, criterion_main};
use std::hint::black_box;
use tumble::algebra::{Expression, Scratch, Tape};

fn algebra(criterion: &mut Criterion) {
    let names = ["w_I", "w_O", "w_S", "V0", "kI", "kII", "kIO", "kIS", "kOS"];
    let inputs = [19.9, 0.02, -0.01, 0.0016, -2.9222, 1e-6, 2e-6, 3e-6, 4e-6];
    let line = "V0 + kI*w_I + kII*w_I^2 + kIO*w_I*w_O + kIS*w_I*w_S + kOS*w_O*w_S";
    let Some(tape) = Expression::parse(line).ok().and_then(|line| Tape::compile(&line, &names).ok()) else { return };
    let (mut scratch, mut gradient) = (Scratch::default(), [0.0; 9]);
    criterion.bench_function("gyro line, value", |bencher| {
        bencher.iter(|| tape.value(black_box(&inputs), &mut scratch));
    });
    criterion.bench_function("gyro line, value and gradient", |bencher| {
        bencher.iter(|| tape.gradient(black_box(&inputs), &mut scratch, &mut gradient));
    });
    criterion.bench_function("gyro line, parse", |bencher| bencher.iter(|| Expression::parse(black_box(line))));
}

criterion_group!(benches, algebra);
criterion_main!(benches);
