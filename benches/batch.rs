//! Many devices through one schedule, 30 readings in 6 unknowns: the fitting alone, with all checks and uncertainties, and with nothing shared.
//!
//! Beside numpy in one run: `benches/peers/devices.py`.

use criterion::{Criterion, criterion_group, criterion_main};
use std::hint::black_box;
use tumble::batch::{Device, Fleet, Layout};
use tumble::campaign::{Campaign, Readings};
use tumble::fit::Settings;
use tumble::wire::{self, CampaignFile};

const COUNT: usize = 10_000;

/// Devices with one schedule, or (`own`) each with a schedule that no other has.
fn devices(own: bool) -> Vec<Device> {
    let mut state = 1_u64;
    let mut uniform = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
    };
    (0..COUNT)
        .map(|k| {
            let (mut inputs, mut values) = (Vec::new(), Vec::new());
            for i in 0..30 {
                let rate = [-100.0, -50.0, -20.0, 20.0, 50.0, 100.0][i / 5] + if own { uniform() } else { 0.0 };
                let acc = [0.0, 0.5, 1.0, -0.5, -1.0][i % 5];
                let warm = f64::from((i as u32 * 7) % 5) * 5.0 + 20.0;
                inputs.extend([rate, acc, warm]);
                values.push(0.01 - 2.9e-3 * rate + 1e-7 * rate * rate + 2e-3 * acc + 1e-5 * warm + 3e-4 * uniform());
            }
            Device {
                label: format!("S{k:06}"),
                inputs,
                values,
                rows: 30,
                first_row: 30 * k as u64 + 1,
                ..Device::default()
            }
        })
        .collect()
}

fn batch(criterion: &mut Criterion) {
    let text = r#"{ "bench": { "id": "line", "sensors": { "V": { "unit": "V",
        "model": "V0 + k1*rate + k2*rate^2/10000 + ka*acc + kt*temperature_c + kaa*acc^2" } } },
        "estimate": { "V0": {}, "k1": {}, "k2": {}, "ka": {}, "kt": {}, "kaa": {} }, "readings": [] }"#;
    let file: CampaignFile = serde_json::from_str(text).expect("a campaign");
    let bench = file.own_bench(&mut |name| panic!("refers to {name}")).expect("a bench");
    let titled = |name: &str| tumble::record::Column { name: name.into(), title: name.into(), unit: None };
    let columns = ["serial", "rate", "acc", "temperature_c", "V"].map(titled);
    let layout = Layout::of(&bench, &columns, Some(0), |_| false);
    let readings = Readings { columns: layout.numeric(&bench), rows: Vec::new() };
    let template = file.with(bench.clone(), readings).expect("a campaign");
    let question = |device: &Device| -> tumble::error::Result<Campaign> {
        Ok(template.with_readings(wire::device_readings(&bench, &layout, device)?))
    };
    let mut group = criterion.benchmark_group("devices");
    group.sample_size(10);
    let (common, own) = (devices(false), devices(true));
    group.bench_function("10000 of one schedule, all checks and u", |bencher| {
        bencher.iter(|| Fleet::new(&question, Settings::default(), 6).fit(black_box(&common), &layout));
    });
    group.bench_function("100 of own schedules, all checks and u", |bencher| {
        let few = own.get(..100).unwrap_or_default();
        bencher.iter(|| Fleet::new(&question, Settings::default(), 6).fit(black_box(few), &layout));
    });
    group.finish();
}

criterion_group!(benches, batch);
criterion_main!(benches);
