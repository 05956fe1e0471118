//! The hot paths, each the shortest of many runs, one thread: a line of name, tab, seconds for each. A word as argument keeps the names with it.
//!
//! Beside peers in one run, with ratios: `benches/peers/hot.py`.

#[path = "cases/mod.rs"]
mod cases;

use cases::{Line, devices, system};
use std::hint::black_box;
use std::time::{Duration, Instant};
use tumble::batch::{Device, Fleet};
use tumble::design::{Model, assemble};
use tumble::estimate::{Fold, Settings, adjust};
use tumble::fit;
use tumble::navigate::{self, Attitude, Continue, ImuErrors, Mission, Motion, Oscillation, Scenario, Site};
use tumble::wire::{self, Source};

/// Shortest time of one call, over rounds of about 20 ms until `budget` is spent.
fn shortest(budget: Duration, mut work: impl FnMut()) -> f64 {
    let begun = Instant::now();
    work();
    let once = begun.elapsed().as_secs_f64().max(1e-9);
    let count = (0.02 / once).clamp(1.0, 1e6) as u32;
    let mut best = once;
    while begun.elapsed() < budget {
        let start = Instant::now();
        (0..count).for_each(|_| work());
        best = best.min(start.elapsed().as_secs_f64() / f64::from(count));
    }
    best
}

fn show(name: &str, work: impl FnMut()) {
    if std::env::args().skip(1).filter(|word| !word.starts_with("--")).all(|word| name.contains(&word)) {
        println!("{name}\t{:e}", shortest(Duration::from_secs(1), work));
    }
}

fn estimates() {
    let text = include_str!("../data/campaigns/li2012-table1.campaign.json");
    let source = Source { name: "table 1".into(), text: text.into() };
    let campaign =
        wire::read_campaign(&source, &mut |name| panic!("{name} is built in")).expect("a published campaign");
    let settings = fit::Settings::default();
    show("fit Table 1", || drop(black_box(fit::fit(black_box(&campaign), &settings))));
    let model = Model::new(&campaign).expect("a model");
    let point = campaign.reference_point();
    show("rows Table 1", || drop(black_box(assemble(black_box(&campaign), &model, &point))));
    let small = system(30, 6);
    show("adjust 30 x 6", || drop(black_box(adjust(black_box(&small), &Settings::default()))));
    for (k, n) in [(64, 6), (4096, 10)] {
        let block = system(k, n);
        let mut fold = Fold::new(n);
        show(&format!("fold {k} x {n}"), || drop(fold.push(block.rows.as_ref(), &block.observed, &block.u)));
    }
}

/// A thousand gyros through the schedule of Table 1, whose tilts act non-linearly: Gauss-Newton of each to its end.
fn exact_fleet() {
    let text = include_str!("../data/campaigns/li2012-table1.campaign.json");
    let file: wire::CampaignFile = serde_json::from_str(text).expect("a campaign");
    let bench = file.resolved_bench(&mut |name| panic!("{name} is built in")).expect("a bench");
    let source = Source { name: "table 1".into(), text: text.into() };
    let campaign =
        wire::read_campaign(&source, &mut |name| panic!("{name} is built in")).expect("a published campaign");
    let wire::ReadingsRef::Inline(readings) = file.readings.clone() else { return };
    let mut rows: Vec<wire::ReadingFile> = Vec::new();
    for k in 0..1000 {
        for (i, row) in readings.iter().enumerate() {
            let mut own = row.clone();
            for (key, cell) in &mut own.0 {
                if let (wire::Cell::Number(value), "V") = (cell, key.as_str()) {
                    *value += 1e-4 * (f64::from(k * 30 + i as u32 * 7) * 12.9898).sin();
                }
            }
            own.0.push(("serial".into(), wire::Cell::Text(format!("S{k}"))));
            rows.push(own);
        }
    }
    let (layout, devices) = wire::inline_devices(&bench, rows, "serial", |_| false).expect("devices");
    let question = |device: &Device| Ok(campaign.with_readings(wire::device_readings(&bench, &layout, device)?));
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
    let mut work = || drop(Fleet::new(&question, fit::Settings::default(), 7).fit(black_box(&devices), &layout));
    one.install(|| show("1000 devices of Table 1's model", &mut work));
}

fn fleets() {
    let line = Line::new();
    let question = |device: &Device| line.campaign(device);
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
    let mut lacking = devices(1_000, false);
    // three readings of thirty are absent, in each device others
    for (k, device) in lacking.iter_mut().enumerate() {
        [k, 7 * (k / 5) + 11, 13 * (k / 29) + 5].into_iter().for_each(|row| device.values[row % 30] = f64::NAN);
    }
    for (name, devices) in [
        ("10000 devices of one schedule", devices(10_000, false)),
        ("1000 devices of own schedules", devices(1_000, true)),
        ("1000 devices that lack readings", lacking),
    ] {
        let mut work =
            || drop(Fleet::new(&question, fit::Settings::default(), 6).fit(black_box(&devices), &line.layout));
        one.install(|| show(name, &mut work));
    }
}

/// A thousand seconds of a swinging vehicle at 100 steps a second, errors without noise.
fn navigators() {
    let site = Site { latitude_rad: 0.8, longitude_rad: 0.0, altitude_m: 0.0 };
    let swing = |amplitude: f64, period: f64| Oscillation { amplitude, period, ..Oscillation::constant(0.0) };
    let attitude = Attitude { pitch: swing(0.05, 7.0), roll: swing(0.1, 9.0), yaw: swing(0.03, 11.0) };
    let motion = Motion::swing(attitude).expect("a motion");
    let mission = Mission::new(site, 0.01, 1000.0, 1000.0, motion).expect("a mission");
    for count in [1, 8] {
        let scenario = |k: usize| {
            let mut errors = ImuErrors::default();
            errors.gyro.bias = [1e-7 * (k + 1) as f64, 2e-7, -1e-7];
            Scenario { id: k.to_string(), errors }
        };
        let scenarios: Vec<Scenario> = (0..count).map(scenario).collect();
        show(&format!("navigator 100000 steps x {count}"), || {
            drop(black_box(navigate::fly(&mission, &scenarios, &mut |_, _, _| Continue::Yes)));
        });
    }
}

fn main() {
    estimates();
    fleets();
    exact_fleet();
    navigators();
}
