//! Malformed questions about these systems are refused, and the message says where and what was expected.

use crate::support::*;
use tumble::bench::built_in;
use tumble::fit::{self, Settings};
use tumble::wire::{self, Source};

fn bench_error(text: &str) -> String {
    let source = Source { name: "imu.bench.json".into(), text: text.into() };
    let error = wire::read_bench(&source).unwrap_err();
    let place = error.place();
    format!("{} | {} | {} | line {}", error.what(), error.expectation().unwrap_or(""), place.path, place.line)
}

#[test]
fn a_tilt_may_follow_joints_only() {
    let good = built_in("imu-three-axis-table").unwrap().text;
    let text = bench_error(&good.replacen("\"times\": \"middle\"", "\"times\": \"sin(muddle)\"", 1));
    println!("{text}");
    assert!(text.contains("muddle") && text.contains("outer, middle, inner") && text.contains("chain[8].times"));
    let text = bench_error(&good.replacen("{ \"joint\": \"outer\",", "{ \"joint\": \"outer\", \"times\": \"2\",", 1));
    assert!(text.contains("only a tilt can follow"), "{text}");
    let text = bench_error(&good.replacen("\"times\": \"middle\"", "\"times\": \"2 middle\"", 1));
    assert!(text.contains("chain[8].times"), "{text}");
}

#[test]
fn a_circle_reading_without_its_face_is_refused() {
    let text = read("examples/12-cube-mirror/attitude.campaign.json").replacen("\"face\": 1,", "", 1);
    let error = fit::fit(&parse("attitude", &text).unwrap(), &Settings::default()).unwrap_err();
    assert!(error.what().contains("face") && error.place().path.contains("readings[1]"), "{error:?}");
}

#[test]
fn a_rate_run_without_its_held_joints_is_refused() {
    let text = read("examples/10-imu-three-axis-table/perfect-table.campaign.json").replacen(
        "\"middle_deg\": 180, \"inner_deg\": 90",
        "\"middle_deg\": 180",
        1,
    );
    let text = if text.contains("\"inner_deg\": 270") { text.replacen(", \"inner_deg\": 270", "", 1) } else { text };
    let error = parse("imu", &text).unwrap_err();
    assert!(error.what().contains("inner"), "{error:?}");
}

/// What is wrong with an option is no place of the file.
#[test]
fn an_impossible_level_is_refused_without_quoting_the_campaign() {
    let output = std::process::Command::new(env!("CARGO_BIN_EXE_tumble"))
        .args(["fit", "examples/10-imu-three-axis-table/perfect-table.campaign.json", "--level", "1.5"])
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .output()
        .unwrap();
    let text = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(1));
    assert!(text.contains("a number between 0 and 1") && !text.contains("line 1") && !text.contains("bench"), "{text}");
}
