//! A whole diagnosis of the published Table 1.

use criterion::{Criterion, criterion_group, criterion_main};
use tumble::diagnosis::{Settings, diagnose};
use tumble::wire::{self, Source};

fn table_1(bench: &mut Criterion) {
    let text = include_str!("../examples/05-table-1-diagnosed/table1.campaign.json");
    let source = Source { name: "table 1".into(), text: text.into() };
    let campaign = wire::read_campaign(&source, &mut |_| unreachable!("a built-in bench")).unwrap();
    let catalogue = wire::built_in_effects().unwrap();
    bench.bench_function("diagnose Table 1", |b| {
        b.iter(|| diagnose(&campaign, &catalogue, &Settings::default()).unwrap())
    });
}

criterion_group!(benches, table_1);
criterion_main!(benches);
