//! One process: what SQL says of a thousand devices is what tumble's own batch fit says of them.

use datafusion::arrow::array::{
    Array, ArrayRef, AsArray, Float64Array, Float64Builder, Int32Array, RecordBatch, StringArray,
};
use datafusion::arrow::compute::cast;
use datafusion::arrow::datatypes::{DataType, Field, Float64Type, Int64Type, Schema};
use datafusion::parquet::arrow::ArrowWriter;
use datafusion::prelude::{SessionConfig, SessionContext};
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
const CAMPAIGN: &str = r#"{
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
struct Draws(u128);

impl Draws {
    fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(0xda94_2042_e4dd_58b5);
        (self.0 >> 75) as f64 / (1_u64 << 53) as f64
    }
    fn normal(&mut self) -> f64 {
        (-2.0 * (1.0 - self.uniform()).ln()).sqrt() * (std::f64::consts::TAU * self.uniform()).cos()
    }
}

/// One row of the table; what is absent is NaN.
#[derive(Debug, Clone)]
struct Reading {
    serial: String,
    theta_deg: f64,
    temperature_c: f64,
    value: f64,
    u: f64,
}

/// A thousand devices with 30 readings: of each seven the second lacks readings, the third has unequal u; a collinear device, one that never
/// moved, one with a joint of no state, one with a value but no u, one with an infinite value, one whose noise is larger than stated.
fn readings() -> Vec<Reading> {
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
fn write(path: &Path, rows: &[Reading], shuffled: bool) {
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
fn by_fleet(rows: &[Reading]) -> HashMap<String, Row> {
    let source = Source { name: "head".into(), text: CAMPAIGN.into() };
    let file: CampaignFile = wire::campaign_of(&source).expect("a campaign");
    let bench = file.own_bench(&mut |name| panic!("refers to {name}")).expect("a bench");
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

async fn session(partitions: usize, batch: usize, question: &Question) -> SessionContext {
    let config = SessionConfig::new().with_target_partitions(partitions).with_batch_size(batch);
    let ctx = SessionContext::new_with_config(config).enable_url_table();
    tumble_sql::register(&ctx, question).expect("a campaign");
    ctx
}

fn question() -> Question {
    Question::new(Source { name: "head.campaign.json".into(), text: CAMPAIGN.into() }, &mut |_| panic!())
        .expect("a campaign")
}

const NAMES: [&str; 6] = ["K0", "K1", "K2", "KP", "KT", "bias"];

/// The worst relative difference; verdicts, ranks and degrees of freedom are equal.
fn compare(batches: &[RecordBatch], expected: &HashMap<String, Row>, squares_to: f64) -> [f64; 2] {
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

/// Estimates, u, U, chi-square, rank and verdict are those of the batch fit to 1e-12: one partition; four with batches of 97 rows, the rows
/// shuffled over three files, so that every device is merged, of values as they are or (twenty devices of 300 readings) of several triangles;
/// and the function that keeps the rows. The readings are 60 000 times their u.
#[tokio::test]
async fn a_thousand_devices_are_those_of_the_batch_fit() {
    let folder = tempfile::tempdir().expect("a folder");
    let rows = readings();
    let expected = by_fleet(&rows);
    let of = |verdict| expected.values().filter(|row| row.verdict == verdict).count();
    assert!(
        of(Verdict::Malformed) == 5
            && of(Verdict::Rejected) > 3
            && expected["G0500"].rank == 1
            && expected["G0501"].rank == 4
    );
    write(&folder.path().join("all.parquet"), &rows, false);
    let mut dealt = rows.clone();
    let mut draws = Draws(7);
    (1..dealt.len()).rev().for_each(|k| dealt.swap(k, (draws.uniform() * (k + 1) as f64) as usize));
    std::fs::create_dir(folder.path().join("runs")).expect("a folder");
    for (k, part) in dealt.chunks(10_007).enumerate() {
        write(&folder.path().join(format!("runs/{k}.parquet")), part, true);
    }
    let question = question();
    let all = folder.path().join("all.parquet");
    let runs = folder.path().join("runs/*.parquet");
    for (what, partitions, batch, path, function, squares_to) in [
        ("one partition", 1, 8192, &all, "tumble_fit", 1e-12),
        ("four partitions, batches of 97", 4, 97, &runs, "tumble_fit", 1e-12),
        ("rows kept, four partitions", 4, 97, &all, "tumble_fit_exact", 1e-12),
    ] {
        let ctx = session(partitions, batch, &question).await;
        let sql = format!("SELECT serial, {function}() AS fit FROM '{}' GROUP BY serial", path.display());
        let found = ctx.sql(&sql).await.expect("a query").collect().await.expect("rows");
        let [worst, squares] = compare(&found, &expected, squares_to);
        println!("{what}: worst relative difference {worst:.1e}, of chi-square and residual_sd {squares:.1e}");
    }
    // several stages are what the second case is about
    let ctx = session(4, 97, &question).await;
    let sql = format!("EXPLAIN SELECT serial, tumble_fit() FROM '{}' GROUP BY serial", runs.display());
    let plan = ctx.sql(&sql).await.expect("a query").to_string().await.expect("a plan");
    assert!(plan.contains("mode=Partial") && plan.contains("FinalPartitioned"), "{plan}");
}

/// Filters, grouping by several columns, no grouping at all, and what stands around the function.
#[tokio::test]
async fn the_function_stands_anywhere_in_a_query() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("few.parquet");
    let rows: Vec<Reading> = readings().into_iter().take(90).collect();
    write(&path, &rows, false);
    let ctx = session(2, 8192, &question()).await;
    let table = path.display();
    let numbers = async |sql: String| -> Vec<f64> {
        let batches = ctx.sql(&sql).await.expect("a query").collect().await.expect("rows");
        batches.iter().flat_map(|b| b.column(0).as_primitive::<Float64Type>().values().to_vec()).collect()
    };
    let each = numbers(format!(
        "SELECT f.\"K1\" FROM (SELECT serial, tumble_fit() AS f FROM '{table}' GROUP BY serial) WHERE f.verdict <> 'malformed' ORDER BY serial"
    ))
    .await;
    assert_eq!(each.len(), 3);
    let one =
        numbers(format!("SELECT f.\"K1\" FROM (SELECT tumble_fit() AS f FROM '{table}' WHERE serial = 'G0002')")).await;
    assert!((one[0] - each[2]).abs() < 1e-14);
    let own = format!("SELECT f.\"K1\" FROM (SELECT tumble_fit() FILTER (WHERE serial = 'G0002') AS f FROM '{table}')");
    assert!((numbers(own).await[0] - each[2]).abs() < 1e-14);
    let cte = format!(
        "WITH own AS (SELECT serial AS unit, theta_deg, temperature_c, \"V\", \"V_u\" FROM '{table}' WHERE theta_deg <> 90)
         SELECT f.\"K1\" FROM (SELECT unit, tumble_fit() AS f, count(*) AS n FROM own GROUP BY unit HAVING count(*) > 5) ORDER BY unit"
    );
    assert_eq!(numbers(cte).await.len(), 3);
    let none = format!("SELECT f.why FROM (SELECT tumble_fit() AS f FROM '{table}' WHERE false)");
    let none = ctx.sql(&none).await.expect("a query").collect().await.expect("a row");
    assert!(none[0].column(0).as_string::<i32>().value(0).contains("no reading has a sensor value"));
}

/// A cell that is no number makes a column of a CSV one of texts; its device says so, and the others are fitted.
#[tokio::test]
async fn a_bad_cell_is_the_answer_of_its_device() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("runs.csv");
    let rows = ["A,0,1", "A,1,3", "B,0,1", "B,1,broken", "A,2,", "A,3,7.5"];
    std::fs::write(&path, format!("serial,x,y\n{}\n", rows.join("\n"))).expect("written");
    let text = r#"{ "bench": { "id": "line", "sensors": { "y": { "model": "a + b*x" } } }, "estimate": { "a": {}, "b": {} }, "readings": [] }"#;
    let question =
        Question::new(Source { name: "line".into(), text: text.into() }, &mut |_| panic!()).expect("a campaign");
    let ctx = session(1, 8192, &question).await;
    let mut why = Vec::new();
    for function in ["tumble_fit", "tumble_fit_exact"] {
        let sql = format!(
            "SELECT f.readings, f.why FROM (SELECT serial, {function}() AS f FROM '{}' GROUP BY serial) ORDER BY serial",
            path.display()
        );
        let found = ctx.sql(&sql).await.expect("a query").collect().await.expect("rows");
        let (readings, own) = (found[0].column(0).as_primitive::<Int64Type>(), found[0].column(1).as_string::<i32>());
        assert_eq!((readings.value(0), readings.value(1)), (3, 0));
        why.push(own.value(1).to_string());
    }
    assert!(why.iter().all(|why| why.contains("y is not a number")), "{why:?}");
}

/// What is wrong is said before anything is read.
#[tokio::test]
async fn errors_say_what_to_do() {
    let ctx = session(1, 8192, &question()).await;
    let refused = async |ctx: &SessionContext, sql: &str| -> String {
        match ctx.sql(sql).await {
            Err(error) => error.to_string(),
            Ok(frame) => frame.collect().await.expect_err("an error").to_string(),
        }
    };
    let error = refused(&ctx, "SELECT tumble_fit() FROM (VALUES (1, 2)) AS t(a, b)").await;
    assert!(error.contains("no column has readings") && error.contains("expected V"), "{error}");
    let error = refused(&ctx, "SELECT tumble_fit() FROM (VALUES (1, true)) AS t(theta_deg, \"V\")").await;
    assert!(error.contains("column V is") && error.contains("CAST"), "{error}");
    let error = refused(&ctx, "SELECT tumble_fit(a) FROM (VALUES (1, 2)) AS t(a, \"V\")").await;
    assert!(error.contains("takes no arguments"), "{error}");
    let nonlinear = CAMPAIGN.replace("K2*a_I^2", "K1*K2*a_I^2");
    let source = Source { name: "bent.campaign.json".into(), text: nonlinear };
    let bent = Question::new(source, &mut |_| panic!()).expect("a campaign");
    let table = "(VALUES (0.0, 20.0, 1.0), (90.0, 20.0, 0.0)) AS t(theta_deg, temperature_c, \"V\")";
    let ctx = session(1, 8192, &bent).await;
    let error = refused(&ctx, &format!("SELECT tumble_fit() FROM {table}")).await;
    for word in ["not linear", "linear estimator", "tumble fit CAMPAIGN --by", "tumble_fit_exact()"] {
        assert!(error.contains(word), "{word}: {error}");
    }
    let exact = ctx.sql(&format!("SELECT tumble_fit_exact() FROM {table}")).await.expect("a query");
    assert_eq!(exact.collect().await.expect("a row").len(), 1);
}

/// Scatter of one sensor from its residuals: with numbers of samples, and readings that are rounded to four places.
#[tokio::test]
async fn scatter_is_estimated_where_no_u_is_stated() {
    let text = r#"{ "bench": { "id": "line", "sensors": { "y": { "model": "a + b*x" } } }, "estimate": { "a": {}, "b": {} }, "readings": [] }"#;
    let question =
        Question::new(Source { name: "line".into(), text: text.into() }, &mut |_| panic!()).expect("a campaign");
    let (xs, ys): (Vec<f64>, Vec<f64>) = (0..8).map(|k| (f64::from(k), (1.0 + f64::from(k * k) * 0.01) * 1e4)).unzip();
    let ys: Vec<f64> = ys.iter().map(|y| y.round() / 1e4).collect();
    let n: Vec<f64> = (0..8).map(|k| f64::from(1 + k % 3)).collect();
    let schema = Schema::new(["x", "y", "n"].map(|name| Field::new(name, DataType::Float64, false)).to_vec());
    let columns: Vec<ArrayRef> = [&xs, &ys, &n].map(|c| Arc::new(Float64Array::from(c.clone())) as ArrayRef).to_vec();
    let batch = RecordBatch::try_new(Arc::new(schema), columns).expect("a batch");
    let ctx = session(3, 2, &question).await;
    ctx.register_batch("t", batch).expect("a table");
    let both = ctx
        .sql("SELECT f.b, f.b_u, e.b, e.b_u, e.runs_p FROM (SELECT tumble_fit() AS f, tumble_fit_exact() AS e FROM t)")
        .await;
    let row = &both.expect("a query").collect().await.expect("a row")[0];
    let number = |k: usize| row.column(k).as_primitive::<Float64Type>().value(0);
    assert!((number(0) - number(2)).abs() < 1e-14 && (number(1) / number(3) - 1.0).abs() < 1e-12);
    // weighted by hand: sums with weights n
    let sum = |of: &dyn Fn(usize) -> f64| (0..8).map(|k| n[k] * of(k)).sum::<f64>();
    let (w, x, y) = (sum(&|_| 1.0), sum(&|k| xs[k]), sum(&|k| ys[k]));
    let slope = (w * sum(&|k| xs[k] * ys[k]) - x * y) / (w * sum(&|k| xs[k] * xs[k]) - x * x);
    assert!((number(0) - slope).abs() < 1e-13);
}
