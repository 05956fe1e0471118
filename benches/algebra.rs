//! What one evaluation of a model line costs: its value, and its value with the exact gradient.

use criterion::{Criterion, criterion_group, criterion_main};
use std::hint::black_box;
use tumble::algebra::{Expression, Scratch, Tape};

const NAMES: [&str; 9] = ["w_I", "w_S", "w_O", "V0", "kI", "kII", "kIO", "kIS", "kOS"];
const INPUTS: [f64; 9] = [20.0, 0.3, -0.2, -0.06, -2.9, 1e-4, 2e-4, -1e-4, 3e-5];
const LINES: [(&str, &str); 3] = [
    ("gyro", "V0 + kI*w_I + kII*w_I^2 + kIO*w_I*w_O + kIS*w_I*w_S + kOS*w_O*w_S"),
    ("product", "w_I*w_S"),
    ("harmonic", "kI*sin(2*w_S)"),
];

fn evaluation(criterion: &mut Criterion) {
    for (name, line) in LINES {
        let tape = Expression::parse(line).and_then(|model| Tape::compile(&model, &NAMES)).expect("the line is sound");
        let (mut scratch, mut gradient) = (Scratch::default(), [0.0; 9]);
        criterion.bench_function(&format!("value/{name}"), |bencher| {
            bencher.iter(|| tape.value(black_box(&INPUTS), &mut scratch))
        });
        criterion.bench_function(&format!("gradient/{name}"), |bencher| {
            bencher.iter(|| tape.gradient(black_box(&INPUTS), &mut scratch, black_box(&mut gradient)))
        });
    }
    criterion.bench_function("parse/gyro", |bencher| bencher.iter(|| Expression::parse(black_box(LINES[0].1))));
}

criterion_group!(benches, evaluation);
criterion_main!(benches);
