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
    let linear = fit::Settings { estimator: fit::Estimator::Linear, ..settings };
    criterion.bench_function("Table 1: fit", |bencher| bencher.iter(|| fit::fit(black_box(&campaign), &settings)));
    criterion.bench_function("Table 1: linear fit", |bencher| bencher.iter(|| fit::fit(black_box(&campaign), &linear)));
    let fitted = fit::fit(&campaign, &settings).expect("a fit");
    criterion.bench_function("Table 1: report as JSON", |bencher| {
        bencher.iter(|| serde_json::to_string(&report::fit_report(black_box(&fitted))));
    });
}

/// Six sensors, 24 positions and 36 rate runs: 252 values in 27 unknowns, or 33 with table errors.
fn imu(criterion: &mut Criterion) {
    let campaigns = [
        ("stated u, perfect table", include_str!("../tests/data/simulated/imu-table.campaign.json")),
        ("stated u, table errors", include_str!("../tests/data/simulated/imu-table-tilted.campaign.json")),
        ("estimated u, perfect table", include_str!("../examples/10-imu-three-axis-table/perfect-table.campaign.json")),
        ("estimated u, table errors", include_str!("../examples/10-imu-three-axis-table/table-errors.campaign.json")),
    ];
    for (name, text) in campaigns {
        let source = wire::Source { name: name.into(), text: text.into() };
        let campaign =
            wire::read_campaign(&source, &mut |name| panic!("{name} is built in")).expect("a campaign of the project");
        let model = Model::new(&campaign).expect("a model");
        let point = campaign.reference_point();
        criterion.bench_function(&format!("IMU, {name}: rows"), |bencher| {
            bencher.iter(|| assemble(black_box(&campaign), &model, &point));
        });
        for estimator in [fit::Estimator::Linear, fit::Estimator::Exact] {
            let settings = fit::Settings { estimator, ..fit::Settings::default() };
            let way = if estimator == fit::Estimator::Exact { "exact fit" } else { "linear fit" };
            criterion.bench_function(&format!("IMU, {name}: {way}"), |bencher| {
                bencher.iter(|| fit::fit(black_box(&campaign), &settings));
            });
        }
    }
}

criterion_group!(benches, campaign, imu);
criterion_main!(benches);
