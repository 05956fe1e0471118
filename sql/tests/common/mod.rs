//! A thousand devices, and what tumble's own batch fit says of them.

use datafusion::arrow::array::{Array, ArrayRef, AsArray, Float64Builder, Int32Array, RecordBatch, StringArray};
use datafusion::arrow::compute::cast;
use datafusion::arrow::datatypes::{DataType, Float64Type, Int64Type};
use datafusion::parquet::arrow::ArrowWriter;
use std::collections::HashMap;
use std::path::Path;
use std::sync::Arc;
use tumble::batch::{Device, Fleet, Layout, Row, Verdict};
use tumble::campaign::Readings;
use tumble::fit::Settings;
use tumble::record::Column;
use tumble::wire::{self, CampaignFile, Source};
use tumble_sql::Question;

/// An accelerometer on a dividing head, with a scale factor of the excitation known to 1e-4, a derived bias and limits.
pub const CAMPAIGN: &str = r#"{
  "bench": { "id": "head", "site": { "latitude_deg": 45 },
    "chain": [ { "joint": "theta", "about": "x" } ],
    "sensors": { "V": { "unit": "V", "axes": { "I": "z", "P": "y" },
                 "model": "G*(K0 + K1*a_I + K2*a_I^2 + KP*a_P + KT*(temperature_c - 20))" } } },
  "known": { "G": { "value": 1.25, "u": 1e-4, "dof": 12 } },
  "estimate": { "K0": {}, "K1": {}, "K2": {}, "KP": {}, "KT": {} },
  "derived": { "bias": "K0/K1" },
  "limits": { "K0": [-0.012, 0.012] }, "decision": "guard-u",
  "by": "serial",
  "readings": [] }"#;

/// A multiplicative generator (D. Lehmer): seeded, and the same everywhere.
pub struct Draws(pub u128);

impl Draws {
    pub fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(0xda94_2042_e4dd_58b5);
        (self.0 >> 75) as f64 / (1_u64 << 53) as f64
    }
    pub fn normal(&mut self) -> f64 {
        (-2.0 * (1.0 - self.uniform()).ln()).sqrt() * (std::f64::consts::TAU * self.uniform()).cos()
    }
}

/// One row of the table; what is absent is NaN.
#[derive(Debug, Clone)]
pub struct Reading {
    pub serial: String,
    pub theta_deg: f64,
    pub temperature_c: f64,
    pub value: f64,
    pub u: f64,
}

/// A thousand devices with 30 readings: of each seven the second lacks readings, the third has unequal u; a collinear device, one that never
/// moved, one with a joint of no state, one with a value but no u, one with an infinite value, one whose noise is larger than stated.
pub fn readings() -> Vec<Reading> {
    let mut draws = Draws(0x5eed_5eed_5eed_5eed_u128 << 1 | 1);
    let mut rows = Vec::new();
    for device in 0..1000 {
        // some have so many that their parts are triangles
        let count = if device % 50 == 10 { 300 } else { 30 };
        let truth =
            [0.01 * draws.normal(), 1.0 + 0.01 * draws.normal(), 1e-4 * draws.normal(), 1e-3 * draws.normal(), 1e-4];
        for k in 0..count {
            let step = if device == 500 { 0 } else { k };
            let (theta, temperature) =
                (f64::from(step % 12) * 30.0, if device == 501 { 20.0 } else { 20.0 + f64::from(step / 12) * 5.0 });
            let (sin, cos) = theta.to_radians().sin_cos();
            let (i, p) = (cos, sin);
            let u = 2e-5 * if device % 7 == 2 { 1.0 + 4.0 * draws.uniform() } else { 1.0 };
            let noise = if device == 505 { 3.0 } else { 1.0 };
            let line = truth[0] + truth[1] * i + truth[2] * i * i + truth[3] * p + truth[4] * (temperature - 20.0);
            let mut row = Reading {
                serial: format!("G{device:04}"),
                theta_deg: theta,
                temperature_c: temperature,
                value: 1.25 * line + noise * u * draws.normal(),
                u,
            };
            if device % 7 == 1 && (k + device) % 9 == 0 {
                (row.value, row.u) = (f64::NAN, f64::NAN);
            }
            match (device, k) {
                (502, 4) => row.theta_deg = f64::NAN,
                (503, 5) => row.u = f64::NAN,
                (504, 6) => row.value = f64::INFINITY,
                (506, 7) => row.value = f64::NAN,
                (507, _) => (row.value, row.u) = (f64::NAN, f64::NAN),
                _ => {}
            }
            rows.push(row);
        }
    }
    rows
}

/// A Parquet file; `shuffled` deals the rows about. NaN is written as null or as NaN in turn.
pub fn write(path: &Path, rows: &[Reading], shuffled: bool) {
    let mut rows = rows.to_vec();
    if shuffled {
        let mut draws = Draws(99);
        (1..rows.len()).rev().for_each(|k| rows.swap(k, (draws.uniform() * (k + 1) as f64) as usize));
    }
    let column = |of: &dyn Fn(&Reading) -> f64| -> ArrayRef {
        let mut column = Float64Builder::new();
        for (k, row) in rows.iter().enumerate() {
            let x = of(row);
            column.append_option(if x.is_nan() && k % 2 == 0 { None } else { Some(x) });
        }
        Arc::new(column.finish())
    };
    let serial: ArrayRef = Arc::new(StringArray::from_iter_values(rows.iter().map(|row| &row.serial)));
    let line: ArrayRef = Arc::new(Int32Array::from_iter_values((0..rows.len()).map(|k| k as i32)));
    let batch = RecordBatch::try_from_iter([
        ("serial", serial),
        ("theta_deg", column(&|row| row.theta_deg)),
        ("temperature_c", column(&|row| row.temperature_c)),
        ("V", column(&|row| row.value)),
        ("V_u", column(&|row| row.u)),
        ("line", line),
    ])
    .expect("columns");
    let file = std::fs::File::create(path).expect("a file");
    let mut writer = ArrowWriter::try_new(file, batch.schema(), None).expect("a writer");
    writer.write(&batch).expect("written");
    writer.close().expect("closed");
}

/// tumble's own batch fit of the same readings.
pub fn by_fleet(rows: &[Reading]) -> HashMap<String, Row> {
    let source = Source { name: "head".into(), text: CAMPAIGN.into() };
    let file: CampaignFile = wire::campaign_of(&source).expect("a campaign");
    let bench = file.resolved_bench(&mut |name| panic!("refers to {name}")).expect("a bench");
    let names = ["serial", "theta_deg", "temperature_c", "V", "V_u"];
    let columns: Vec<Column> =
        names.iter().map(|name| Column { name: (*name).into(), title: (*name).into(), unit: None }).collect();
    let layout = Layout::of(&bench, &columns, Some(0), |_| false);
    assert_eq!(layout.keys, ["theta_deg", "temperature_c", "V", "V_u"]);
    let readings = Readings { columns: layout.numeric(&bench), rows: Vec::new() };
    let template = file.with(bench, readings).expect("a campaign");
    let mut devices: Vec<Device> = Vec::new();
    for row in rows {
        if devices.last().is_none_or(|device| device.label != row.serial) {
            devices.push(Device { label: row.serial.clone(), ..Device::default() });
        }
        let device = devices.last_mut().expect("a device");
        device.inputs.extend([row.theta_deg, row.temperature_c, row.u]);
        device.values.push(row.value);
        device.rows += 1;
    }
    let question = |device: &Device| -> tumble::Result<_> {
        Ok(template.with_readings(wire::device_readings(&template.bench, &layout, device)?))
    };
    let rows = Fleet::new(&question, Settings::default(), 6).fit(&devices, &layout);
    rows.into_iter().map(|row| (row.label.clone(), row)).collect()
}

pub fn question() -> Question {
    Question::new(Source { name: "head.campaign.json".into(), text: CAMPAIGN.into() }, &mut |_| panic!())
        .expect("a campaign")
}

pub const NAMES: [&str; 6] = ["K0", "K1", "K2", "KP", "KT", "bias"];

/// The worst relative difference; verdicts, ranks and degrees of freedom are equal.
pub fn compare(batches: &[RecordBatch], expected: &HashMap<String, Row>, squares_to: f64) -> [f64; 2] {
    let (mut worst, mut seen) = ([0.0_f64; 2], 0);
    for batch in batches {
        let serial = cast(batch.column(0), &DataType::Utf8).expect("texts");
        let serial = serial.as_string::<i32>();
        let fit = batch.column(1).as_struct();
        let number = |name: &str, k: usize| -> f64 {
            let column = fit.column_by_name(name).expect(name).as_primitive::<Float64Type>();
            if column.is_valid(k) { column.value(k) } else { f64::NAN }
        };
        let count =
            |name: &str, k: usize| fit.column_by_name(name).expect(name).as_primitive::<Int64Type>().value(k) as usize;
        let text = |name: &str, k: usize| fit.column_by_name(name).expect(name).as_string::<i32>().value(k).to_string();
        for k in 0..batch.num_rows() {
            let own = &expected[serial.value(k)];
            seen += 1;
            let label = &own.label;
            assert_eq!(text("verdict", k), own.verdict.name(), "{label}: {} {own:?}", text("why", k));
            assert_eq!(
                (count("readings", k), count("rank", k), count("dof", k)),
                (own.readings, own.rank, own.dof),
                "{label}"
            );
            if own.verdict == Verdict::Malformed {
                assert!(!text("why", k).is_empty(), "{label}");
                assert!(number("K0", k).is_nan());
                continue;
            }
            assert_eq!(text("conformity", k), own.conformity.expect("limits").name(), "{label}");
            let mut near = |name: &str, a: f64, b: f64, scale: f64| {
                assert_eq!(a.is_nan(), b.is_nan(), "{label} {name}: {a} for {b}");
                if scale > 0.0 && !b.is_nan() {
                    let squares = name == "chi_square" || name == "residual_sd";
                    let own = &mut worst[usize::from(squares)];
                    *own = own.max((a - b).abs() / scale);
                    assert!(
                        (a - b).abs() <= if squares { squares_to } else { 1e-12 } * scale,
                        "{label} {name}: {a:e} for {b:e}"
                    );
                }
            };
            for (j, name) in NAMES.iter().enumerate() {
                let (value, u) = (own.value[j], own.u[j]);
                // readings of size 1 are rounded to 2e-16, and so is what is a part of them
                near(name, number(name, k), value, value.abs().max(u).max(2.2e-4));
                near(name, number(&format!("{name}_u"), k), u, u);
                near(name, number(&format!("{name}_U"), k), own.expanded[j], own.expanded[j]);
            }
            near("residual_sd", number("residual_sd", k), own.residual_sd, own.residual_sd);
            let squares = own.residual_sd * own.residual_sd * own.dof as f64;
            near("chi_square", number("chi_square", k), squares, squares);
            // a probability follows its sum of squares with a slope of some tens
            near("chi_square_p", number("chi_square_p", k), own.chi_square_p, 100.0);
        }
    }
    assert_eq!(seen, expected.len());
    worst
}
