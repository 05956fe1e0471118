//! How long it takes to choose 12 of 1,000 candidates in 8 unknowns: one start with the bound, 100 starts, and the sum of the variances.

use criterion::{Criterion, criterion_group, criterion_main};
use std::hint::black_box;
use tumble::campaign::{Campaign, Readings};
use tumble::plan::{self, Costs, Noise, Offer, Request};
use tumble::wire::{self, Source};

/// Rows of sines and cosines at 1,000 positions in no particular order: the same numbers as in tests/scripts/plan_numpy.py.
fn candidates() -> Campaign {
    let turns = |step: f64| (0..1000).map(move |j| (f64::from(j) * step) % 1.0 * std::f64::consts::TAU);
    let [a, b] = [turns(0.618_034), turns(0.754_877_666)].map(|angles| angles.collect::<Vec<f64>>());
    let line = "p0 + p1*cos(a) + p2*sin(a) + p3*cos(b) + p4*sin(b) + p5*cos(a)*cos(b) + p6*sin(a)*sin(b) + p7*cos(2*a)";
    let estimate: Vec<String> = (0..8).map(|k| format!(r#""p{k}": {{}}"#)).collect();
    let text = format!(
        r#"{{ "bench": {{ "id": "plain", "sensors": {{ "y": {{ "model": "{line}" }} }} }},
             "estimate": {{ {} }}, "readings": [ {{ "a": {a:?}, "b": {b:?} }} ] }}"#,
        estimate.join(", ")
    );
    wire::read_campaign(&Source { name: "plain".into(), text }, &mut |_| unreachable!()).unwrap()
}

fn plan(criterion: &mut Criterion) {
    let campaign = candidates();
    let noise = Noise::new(&campaign, &[("y".into(), 1.0)], &[]).unwrap();
    let kept = Readings { rows: Vec::new(), columns: campaign.readings.columns.clone() };
    let offer = Offer { kept, candidates: campaign.readings.clone(), noise, costs: Costs::default() };
    let request = |criterion, starts, seed| Request { readings: 12, criterion, starts, seed, ..Request::default() };
    let mut seed = 0;
    for (name, wanted, starts) in [
        ("one start", plan::Criterion::D, 1),
        ("100 starts", plan::Criterion::D, 100),
        ("one start, sum of variances", plan::Criterion::A, 1),
    ] {
        criterion.bench_function(&format!("12 of 1000 x 8, {name}"), |bencher| {
            bencher.iter(|| {
                seed += 1;
                plan::improve(black_box(&campaign), &offer, &request(wanted.clone(), starts, seed)).unwrap()
            });
        });
    }
}

criterion_group!(benches, plan);
criterion_main!(benches);
