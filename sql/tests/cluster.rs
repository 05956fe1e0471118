//! Two real executors and a scheduler: what they say of a thousand devices is what one process says, also where one executor is killed midway.
#![cfg(feature = "cluster")]

#[allow(dead_code, reason = "shared with the tests of one process")]
mod common;

use common::{Draws, by_fleet, compare, question, readings, write};
use datafusion::prelude::SessionConfig;
use std::path::Path;
use tumble_sql::local::Local;

/// Files that each hold rows of every device, so that devices are merged over executors.
fn dealt(folder: &Path, files: usize) {
    let mut rows = readings();
    let mut draws = Draws(7);
    (1..rows.len()).rev().for_each(|k| rows.swap(k, (draws.uniform() * (k + 1) as f64) as usize));
    for (k, part) in rows.chunks(rows.len().div_ceil(files)).enumerate() {
        write(&folder.join(format!("{k:02}.parquet")), part, true);
    }
}

fn has_a_file(folder: &Path) -> bool {
    std::fs::read_dir(folder).into_iter().flatten().flatten().any(|own| match own.file_type() {
        Ok(kind) if kind.is_dir() => has_a_file(&own.path()),
        Ok(kind) => kind.is_file(),
        Err(_) => false,
    })
}

async fn run(kill: bool) {
    let folder = tempfile::tempdir().expect("a folder");
    dealt(folder.path(), 24);
    let mut local = Local::start(Path::new(env!("CARGO_BIN_EXE_tumble-sql-node")), 2, 1, 6).expect("a cluster");
    let config = SessionConfig::new().with_target_partitions(24).with_batch_size(97);
    let ctx = tumble_sql::cluster::client(&local.url(), config, &question()).await.expect("a client");
    let sql =
        format!("SELECT serial, tumble_fit() AS fit FROM '{}/*.parquet' GROUP BY serial", folder.path().display());
    let frame = ctx.sql(&sql).await.expect("a query");
    let work = tokio::spawn(frame.collect());
    if kill {
        let first = local.work(0).expect("a folder").to_path_buf();
        while !has_a_file(&first) && !work.is_finished() {
            tokio::time::sleep(std::time::Duration::from_millis(1)).await;
        }
        assert!(!work.is_finished(), "the work ended before an executor was killed");
        local.kill(0).expect("killed");
    }
    let found = work.await.expect("no panic").expect("rows");
    let [worst, squares] = compare(&found, &by_fleet(&readings()), 1e-12);
    println!("killed: {kill}; worst relative difference {worst:.1e}, of chi-square and residual_sd {squares:.1e}");
}

/// The program itself: a file of the working folder, on executors of its own, is what one process says of it.
#[test]
fn the_program_starts_a_cluster_of_its_own() {
    let example = Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/26-production-line");
    let rows = |more: &[&str]| {
        let run = std::process::Command::new(env!("CARGO_BIN_EXE_tumble-sql"))
            .current_dir(&example)
            .args(["--campaign", "line.campaign.json"])
            .args(more)
            .arg("SELECT serial, f.verdict, f.kI, f.kI_u FROM (SELECT serial, tumble_fit() AS f FROM 'readings.csv' GROUP BY serial) ORDER BY serial")
            .output()
            .expect("a run");
        assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
        String::from_utf8(run.stdout).expect("text")
    };
    let (alone, cluster) = (rows(&[]), rows(&["--cluster", "2"]));
    assert_eq!(alone.lines().count(), 41);
    for (a, b) in alone.lines().zip(cluster.lines()) {
        for (a, b) in a.split(',').zip(b.split(',')) {
            match (a.parse::<f64>(), b.parse::<f64>()) {
                (Ok(a), Ok(b)) => assert!((a - b).abs() <= 1e-12 * b.abs(), "{a} {b}"),
                _ => assert_eq!(a, b),
            }
        }
    }
    assert_eq!(alone.lines().count(), cluster.lines().count());
}

#[tokio::test(flavor = "multi_thread")]
async fn two_executors_say_what_one_process_says() {
    run(false).await;
}

#[tokio::test(flavor = "multi_thread")]
async fn an_executor_that_is_killed_midway_changes_nothing() {
    run(true).await;
}
