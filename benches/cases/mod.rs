//! What several benches time: rows of a table, and devices of a line.
#![allow(dead_code, reason = "each bench uses its part")]

use tumble::batch::{Device, Layout};
use tumble::bench::Bench;
use tumble::campaign::{Campaign, Readings};
use tumble::estimate::{Group, System};
use tumble::record::Column;
use tumble::wire::{self, CampaignFile};

/// Rows like those of a rate table: constants, sines and cosines of evenly spread positions.
pub fn system(m: usize, n: usize) -> System {
    let derivative = |i: usize, j: usize| {
        let angle = i as f64 * 0.7 + 0.1;
        match j {
            0 => 1.0,
            _ if j % 2 == 1 => (angle * j.div_ceil(2) as f64).sin() * 30.0,
            _ => (angle * j.div_ceil(2) as f64).cos() * 30.0,
        }
    };
    System {
        rows: faer::Mat::from_fn(m, n, derivative),
        observed: (0..m).map(|i| (i * i * 7919 + 13) as f64 * 0.618_034 % 2.0 - 1.0).collect(),
        u: vec![0.9e-3; m],
        group: vec![Group::Estimated(0); m],
    }
}

/// Devices with one schedule, or (`own`) each with a schedule that no other has.
pub fn devices(count: usize, own: bool) -> Vec<Device> {
    let mut state = 1_u64;
    let mut uniform = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
    };
    let device = |k: usize| {
        let (mut inputs, mut values) = (Vec::new(), Vec::new());
        for i in 0..30 {
            let rate = [-100.0, -50.0, -20.0, 20.0, 50.0, 100.0][i / 5] + if own { uniform() } else { 0.0 };
            let acc = [0.0, 0.5, 1.0, -0.5, -1.0][i % 5];
            let warm = f64::from((i as u32 * 7) % 5) * 5.0 + 20.0;
            inputs.extend([rate, acc, warm]);
            values.push(0.01 - 2.9e-3 * rate + 1e-7 * rate * rate + 2e-3 * acc + 1e-5 * warm + 3e-4 * uniform());
        }
        let (label, first_row) = (format!("S{k:06}"), 30 * k as u64 + 1);
        Device { label, inputs, values, rows: 30, first_row, ..Device::default() }
    };
    (0..count).map(device).collect()
}

/// The campaign of these devices, without their readings.
pub struct Line {
    pub layout: Layout,
    bench: Bench,
    template: Campaign,
}

impl Line {
    pub fn new() -> Self {
        let text = r#"{ "bench": { "id": "line", "sensors": { "V": { "unit": "V",
            "model": "V0 + k1*rate + k2*rate^2/10000 + ka*acc + kt*temperature_c + kaa*acc^2" } } },
            "estimate": { "V0": {}, "k1": {}, "k2": {}, "ka": {}, "kt": {}, "kaa": {} }, "readings": [] }"#;
        let file: CampaignFile = serde_json::from_str(text).expect("a campaign");
        let bench = file.resolved_bench(&mut |name| panic!("refers to {name}")).expect("a bench");
        let titled = |name: &str| Column { name: name.into(), title: name.into(), unit: None };
        let columns = ["serial", "rate", "acc", "temperature_c", "V"].map(titled);
        let layout = Layout::of(&bench, &columns, Some(0), |_| false);
        let readings = Readings { columns: layout.numeric(&bench), rows: Vec::new() };
        let template = file.with(bench.clone(), readings).expect("a campaign");
        Line { layout, bench, template }
    }

    /// A device's own campaign.
    pub fn campaign(&self, device: &Device) -> tumble::error::Result<Campaign> {
        Ok(self.template.with_readings(wire::device_readings(&self.bench, &self.layout, device)?))
    }
}
