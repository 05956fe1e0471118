//! How long the whole way takes: reading a campaign, assembling its rows, and one fit with all its diagnostics.

use criterion::{Criterion, criterion_group, criterion_main};
use std::hint::black_box;
use tumble::design::{Model, assemble};
use tumble::{fit, report, wire};

fn campaign(criterion: &mut Criterion) {
    let text = include_str!("../data/campaigns/li2012-table1.campaign.json");
    let source = wire::Source { name: "table 1".into(), text: text.into() };
    let read = || wire::read_campaign(&source, &mut |name| panic!("{name} is built in"));
    let campaign = read().expect("a published campaign");
    criterion.bench_function("Table 1: read the campaign", |bencher| bencher.iter(read));
    let model = Model::new(&campaign).expect("a model");
    let point = campaign.reference_point();
    criterion.bench_function("Table 1: rows of 30 readings over whole turns", |bencher| {
        bencher.iter(|| assemble(black_box(&campaign), &model, &point));
    });
    let settings = fit::Settings::default();
    let exact = fit::Settings { exact: true, ..settings };
    criterion.bench_function("Table 1: fit", |bencher| bencher.iter(|| fit::fit(black_box(&campaign), &settings)));
    criterion.bench_function("Table 1: exact fit", |bencher| bencher.iter(|| fit::fit(black_box(&campaign), &exact)));
    let fitted = fit::fit(&campaign, &settings).expect("a fit");
    criterion.bench_function("Table 1: report as JSON", |bencher| {
        bencher.iter(|| serde_json::to_string(&report::fit_report(black_box(&fitted))));
    });
}

criterion_group!(benches, campaign);
criterion_main!(benches);
