//! One process: what SQL says of a thousand devices is what tumble's own batch fit says of them.

mod common;

use common::{CAMPAIGN, Draws, Reading, by_fleet, compare, question, readings, write};
use datafusion::arrow::array::{ArrayRef, AsArray, Float64Array, RecordBatch};
use datafusion::arrow::datatypes::{DataType, Field, Float64Type, Int64Type, Schema};
use datafusion::prelude::{SessionConfig, SessionContext};
use std::sync::Arc;
use tumble::batch::Verdict;
use tumble::wire::Source;
use tumble_sql::Question;

async fn session(partitions: usize, batch: usize, question: &Question) -> SessionContext {
    let config = SessionConfig::new().with_target_partitions(partitions).with_batch_size(batch);
    let ctx = SessionContext::new_with_config(config).enable_url_table();
    tumble_sql::register(&ctx, question).expect("a campaign");
    ctx
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
    let mut malformed: Vec<&str> = expected
        .iter()
        .filter(|(_, row)| row.verdict == Verdict::Malformed)
        .map(|(serial, _)| serial.as_str())
        .collect();
    malformed.sort_unstable();
    // (a u without a value is a reading that was not made, in G0506)
    assert_eq!(malformed, ["G0502", "G0503", "G0504", "G0507"]);
    let ranks = (expected["G0500"].rank, expected["G0501"].rank);
    assert!(of(Verdict::Rejected) > 3 && ranks == (1, 4), "{} rejected, {ranks:?}", of(Verdict::Rejected));
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
