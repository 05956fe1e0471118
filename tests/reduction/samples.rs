//! Samples in a campaign: the same readings and the same fit as by `tumble reduce`, and errors that say where.

use crate::support::*;
use assert_cmd::Command;
use serde_json::{Value, json};
use std::path::Path;

pub fn tumble(folder: &Path, arguments: &[&str]) -> (i32, String, String) {
    let output =
        Command::cargo_bin("tumble").expect("the program").current_dir(folder).args(arguments).output().expect("a run");
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).expect("UTF-8");
    (output.status.code().expect("no signal"), text(output.stdout), text(output.stderr))
}

pub fn write(folder: &Path, name: &str, text: &str) {
    std::fs::write(folder.join(name), text).expect("a file");
}

/// A gyro on a table that turns at eight rates, each 6.2 s at 100 Hz with a shake between; samples in mV.
fn log() -> (String, Vec<Value>) {
    let mut text = String::from("t_ms;Stellung;Ausgang (mV)\n");
    let mut positions = Vec::new();
    let mut state = 1_u64;
    let mut noise = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 40) as f64 / f64::from(1 << 24) - 0.5
    };
    let mut row = 0;
    for (k, rate) in [150.0, 90.0, -90.0, 180.0, -180.0, 120.0, -120.0, -150.0].into_iter().enumerate() {
        for i in 0..700 {
            let between = i >= 620;
            let value = 1000.0 * (0.01 + 0.002 * rate) + 0.4 * noise() + if between { 300.0 * noise() } else { 0.0 };
            let label = if between { String::new() } else { format!("p{k}") };
            text.push_str(&format!("{};{label};{value:.4}\n", 10 * row));
            row += 1;
        }
        positions.push(json!({ "position": format!("p{k}"), "gamma_deg_s": rate }));
    }
    (text, positions)
}

fn campaign(readings: Value) -> Value {
    json!({
        "bench": { "id": "rate-table", "units": { "rate": "deg/s" }, "chain": [ { "joint": "gamma", "about": "z" } ], "site": { "latitude_deg": 90, "earth_rate_deg_h": 0 },
            "sensors": { "V": { "unit": "V", "axes": { "I": "z" }, "model": "V0 + k*w_I" } } },
        "estimate": { "V0": {}, "k": {} },
        "readings": readings
    })
}

/// A fit report without what names its input files.
fn fitted_by(folder: &Path, name: &str) -> Value {
    let (code, out, error) = tumble(folder, &["fit", name, "--json", "-"]);
    let mut report: Value = serde_json::from_str(&out).unwrap_or_else(|e| panic!("{code} {e}: {error}"));
    report.as_object_mut().expect("a report").remove("inputs");
    report
}

/// By a marker column, by times and by stillness: what `reduce --for --to` and then `fit` say, `fit` says in one command.
#[test]
fn one_recipe_two_doors() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let (text, positions) = log();
    write(at, "log.csv", &text);
    let times: String = (0..8).map(|k| format!("p{k},{},{}\n", 7 * k, 7.0 * f64::from(k) + 6.2)).collect();
    write(at, "times.csv", &format!("position,start_s,end_s\n{times}"));
    let list: Vec<Value> = (0..8)
        .map(|k| json!({ "position": format!("p{k}"), "start_s": 7 * k, "end_s": 7.0 * f64::from(k) + 6.2 }))
        .collect();
    write(at, "schedule.json", &campaign(json!(positions)).to_string());
    let doors: [(&[&str], Value); 4] = [
        (&["--by", "Stellung"], json!({ "by": "Stellung" })),
        (
            &["--by", "Stellung", "--guard", "0.7", "--least", "2"],
            json!({ "by": "Stellung", "guard_s": 0.7, "least_s": 2 }),
        ),
        (&["--times", "times.csv"], json!({ "times": "times.csv" })),
        (
            &["--window", "0.4", "--threshold", "5", "--guard", "0.3"],
            json!({ "window_s": 0.4, "threshold": 5, "guard_s": 0.3 }),
        ),
    ];
    let mut by_file = Value::Null;
    for (k, (options, keys)) in doors.iter().enumerate() {
        let to = format!("reduced{k}.campaign.json");
        let mut arguments = vec![
            "reduce",
            "log.csv",
            "--for",
            "schedule.json",
            "--to",
            &to,
            "--columns",
            "V=Ausgang",
            "--time",
            "t_ms",
        ];
        arguments.extend(*options);
        let (code, _, error) = tumble(at, &arguments);
        assert_eq!(code, 0, "{error}");
        let mut readings = keys.clone();
        readings["samples"] = json!("log.csv");
        readings["positions"] = json!(positions);
        readings["columns"] = json!({ "V": "Ausgang" });
        readings["time"] = json!("t_ms");
        let name = format!("samples{k}.campaign.json");
        write(at, &name, &campaign(readings).to_string());
        let (one, two) = (fitted_by(at, &to), fitted_by(at, &name));
        assert_eq!(one["fit"]["readings"], 8);
        assert_eq!(one["parameters"], two["parameters"], "{options:?}");
        assert_eq!(one["readings"], two["readings"], "{options:?}");
        // millivolts became the bench's volts
        let v0 = number(&two["parameters"][0]["value"]);
        assert!((v0 - 0.01).abs() < 1e-4, "{v0}");
        if k == 2 {
            by_file = two["parameters"].clone();
        }
    }
    let mut readings = json!({ "samples": "log.csv", "times": list, "positions": positions, "time": "t_ms" });
    let mut whole = campaign(readings.clone());
    whole["columns"] = json!({ "V": "Ausgang (mV)" });
    write(at, "list.campaign.json", &whole.to_string());
    assert_eq!(fitted_by(at, "list.campaign.json")["parameters"], by_file);
    // every command that takes a campaign takes this one
    for command in ["check", "diagnose"] {
        let (code, _, error) = tumble(at, &[command, "list.campaign.json"]);
        assert!(code != 1, "{command}: {error}");
    }
    let library = tumble::Campaign::from_path(at.join("list.campaign.json")).expect("a campaign");
    assert_eq!(library.readings.rows.len(), 8);

    // what is wrong says where
    let faults: [(&str, Value, &[&str]); 8] = [
        ("samples", json!("nothing.csv"), &["nothing.csv", "readings.samples"]),
        ("columns", json!({ "V": "Spannung" }), &["log.csv", "'Spannung'", "t_ms, Stellung, Ausgang (mV)"]),
        ("guard", json!(1), &["unknown key 'guard'", "guard_s"]),
        ("by", json!("Stellung"), &["exclude each other", "readings.times"]),
        ("threshold", json!(4), &["exclude each other"]),
        ("time", json!("Uhr"), &["'Uhr'", "t_ms"]),
        ("positions", json!([{ "gamma_deg_s": 100 }, { "gamma_deg_s": 200 }]), &["2 positions", "8 segments"]),
        ("positions", json!([{ "position": "p" }]), &["gamma_deg", "readings.positions[0]"]),
    ];
    for (key, value, words) in faults {
        let before = readings[key].clone();
        readings[key] = value;
        let mut campaign = campaign(readings.clone());
        if key != "columns" {
            campaign["columns"] = json!({ "V": "Ausgang (mV)" });
        }
        write(at, "bad.campaign.json", &campaign.to_string());
        let (code, _, error) = tumble(at, &["fit", "bad.campaign.json"]);
        let flat = error.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(code == 1 && words.iter().all(|word| flat.contains(word)), "{key}: {error}");
        if before.is_null() {
            readings.as_object_mut().expect("an object").remove(key);
        } else {
            readings[key] = before;
        }
    }
    let never = json!({ "samples": "log.csv", "columns": { "V": "Ausgang" }, "time": "t_ms", "least_s": 100 });
    write(at, "never.campaign.json", &campaign(never).to_string());
    let (code, _, error) = tumble(at, &["fit", "never.campaign.json"]);
    let flat = error.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(code == 1 && flat.contains("no static segment of 100 s") && flat.contains("log.csv"), "{error}");
}

/// The Xsens record: 38 positions and the calibration in one command, to the digit those of two.
#[test]
fn xsens_in_one_command() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/15-xsens-from-the-log");
    let scratch = tempfile::tempdir().expect("a folder");
    let to = scratch.path().join("two.campaign.json");
    let to = to.to_str().expect("a path");
    let (code, _, error) =
        tumble(&folder, &["reduce", "xsens.csv.gz", "--for", "accelerometer.schedule.json", "--to", to]);
    assert_eq!(code, 0, "{error}");
    let (one, two) = (fitted_by(&folder, "accelerometer.campaign.json"), fitted_by(&folder, to));
    assert_eq!(one["fit"]["readings"], 38);
    assert_eq!(one["parameters"], two["parameters"]);
}

/// Segments that turn are cut to whole turns by the encoder, whatever its counts, and whether the rate is steady or not.
#[test]
fn whole_turns_by_an_encoder() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let mut text = String::from("time_s,run,counts,enc (rad),enc_deg,enc (counts),V\n");
    for k in 0..5000 {
        let t = f64::from(k) / 100.0;
        // 2.35 turns forward, at rest, 3.6 turns back with a rate that changes
        let (label, turns) = match k {
            0..1410 => ("a", t / 6.0 + 0.3),
            1500..2500 => ("b", 2.65),
            2600..4760 => ("c", 2.65 - 3.6 * ((t - 26.0) / 21.6).powf(1.05)),
            _ => ("", 0.0),
        };
        let angle = std::f64::consts::TAU * turns;
        let counts = (4096.0 * turns).rem_euclid(4096.0);
        // at rest no two samples are equal: the last digits of a reading scatter
        let noise = 1e-10 * (f64::from(k) * 1.7).sin();
        // an encoder in radians goes on, one in degrees begins anew
        let units = format!("{angle},{},{counts}", (360.0 * turns).rem_euclid(360.0));
        let value = 2.0 + angle.sin() + 0.5 * (2.0 * angle).cos() + noise;
        text.push_str(&format!("{t},{label},{counts},{units},{value}\n"));
    }
    write(at, "log.csv", &text);
    let options = ["reduce", "log.csv", "--by", "run", "--columns", "V", "--encoder", "counts", "--json", "-"];
    let (code, out, error) = tumble(at, &[&options[..], &["--counts-per-turn", "4096"]].concat());
    assert_eq!(code, 0, "{error}");
    let report: Value = serde_json::from_str(&out).expect("a report");
    let segments = report["segments"].as_array().expect("segments");
    let notes: Vec<String> = segments.iter().map(|s| s["notes"].to_string()).collect();
    assert!(notes[0].contains("2 whole turns") && notes[2].contains("3 whole turns"), "{notes:?}");
    assert_eq!(notes[1], "null");
    // 600 samples to a turn, exactly: the harmonics leave nothing
    assert_eq!(segments[0]["n"], 1200);
    assert!((number(&segments[0]["means"][0]["mean"]) - 2.0).abs() < 1e-9);
    // about 700 to a turn, none of them whole: what a sample more or less leaves, and the rate's change of some percent
    assert!((number(&segments[2]["means"][0]["mean"]) - 2.0).abs() < 0.02, "{}", segments[2]["means"][0]["mean"]);
    let (code, _, error) = tumble(at, &options);
    assert_eq!(code, 0, "{error}");
    // a unit in the title is converted; counts need the number of them in a turn
    for encoder in ["enc (rad)", "enc_deg"] {
        let options = ["reduce", "log.csv", "--by", "run", "--columns", "V", "--encoder", encoder, "--json", "-"];
        let (code, out, error) = tumble(at, &options);
        assert_eq!(code, 0, "{error}");
        let of: Value = serde_json::from_str(&out).expect("a report");
        for k in 0..3 {
            assert_eq!(
                (&of["segments"][k]["notes"], &of["segments"][k]["n"]),
                (&segments[k]["notes"], &segments[k]["n"])
            );
        }
    }
    let (code, _, error) = tumble(at, &["reduce", "log.csv", "--by", "run", "--encoder", "enc (counts)"]);
    assert!(code == 1 && error.contains("--counts-per-turn"), "{error}");
    // less than a turn is no reading
    let short =
        ["reduce", "log.csv", "--by", "run", "--columns", "V", "--encoder", "counts", "--json", "-", "--guard", "4.5"];
    let (_, out, _) = tumble(at, &[&short[..], &["--counts-per-turn", "4096"]].concat());
    let report: Value = serde_json::from_str(&out).expect("a report");
    assert!(report["rejected"][0]["reason"].as_str().is_some_and(|r| r.contains("turns by the encoder")), "{report}");
}

/// A clock that was set back or stood still is named and counted, and the record goes on; rows that are not sorted are an error.
#[test]
fn clock_jumps_are_counted() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let row = |k: i32, t: f64| format!("{t},{}\n", 1.0 + 0.001 * f64::from(k * 7919 % 101));
    let mut text = String::from("time_s,V\n");
    for k in 0..3000 {
        let set = if k >= 1000 { -1.25 } else { 0.0 } + if k >= 2000 { 60.0 } else { 0.0 };
        text.push_str(&row(k, f64::from(k) / 100.0 + set));
    }
    write(at, "log.csv", &text);
    let (code, out, error) = tumble(at, &["reduce", "log.csv", "--json", "-"]);
    assert_eq!(code, 0, "{error}");
    let report: Value = serde_json::from_str(&out).expect("a report");
    assert_eq!((&report["gaps"], &report["clock_jumps"]), (&json!(1), &json!(1)));
    assert_eq!((&report["jumps"][0]["kind"], &report["jumps"][0]["row"]), (&json!("back"), &json!(1000)));
    assert_eq!((&report["jumps"][1]["kind"], &report["jumps"][1]["row"]), (&json!("gap"), &json!(2000)));
    assert!((number(&report["jumps"][0]["step_s"]) + 1.24).abs() < 1e-9);
    assert!(error.contains("goes back 1 time") && error.contains("1 gap"), "{error}");
    let mixed: String = (0..300).map(|k| row(k, f64::from(k * 37 % 300))).collect();
    write(at, "mixed.csv", &format!("time_s,V\n{mixed}"));
    let (code, _, error) = tumble(at, &["reduce", "mixed.csv"]);
    assert!(code == 1 && error.contains("not sorted"), "{error}");
}

/// Labels of positions in which several readings were taken: the k-th run of a label is the k-th reading of that position, of a record that is reduced, of one whose rows
/// are the readings, and by times. Another number of runs, or a label that is no position, is an error that names it.
#[test]
fn positions_with_several_readings_by_label() {
    let rates = [("P1", 30.0), ("P1", -30.0), ("P2", 60.0), ("P2", -60.0)];
    let mut text = String::from("t_s,pos,V\n");
    let mut times = Vec::new();
    for (k, (label, rate)) in rates.into_iter().enumerate() {
        for i in 0..1300 {
            // two readings of a position are parted by rows without a label
            let own = if i < 1200 { label } else { "" };
            let t = 0.01 * (1300 * k + i) as f64;
            // 1 mV of an alternating kind
            let value = 0.1 + 0.02 * rate + if i % 2 == 0 { 1e-3 } else { -1e-3 };
            text.push_str(&format!("{t:.2},{own},{value:.4}\n"));
        }
        let start = 13.0 * k as f64;
        times.push(json!([label, start, start + 12.0]));
    }
    let folder = tempfile::tempdir().expect("a folder");
    write(folder.path(), "record.csv", &text);
    let positions = |names: [&str; 4]| -> Vec<Value> {
        names.iter().zip(rates).map(|(name, (_, rate))| json!({ "position": name, "gamma_deg_s": rate })).collect()
    };
    let right = positions(["P1", "P1", "P2", "P2"]);
    let by =
        |positions: &Vec<Value>| json!({ "samples": "record.csv", "time": "t_s", "by": "pos", "positions": positions });
    let mut rows = by(&right);
    rows["as"] = "rows".into();
    for (name, readings) in [
        ("labels", by(&right)),
        ("rows", rows),
        ("times", json!({ "samples": "record.csv", "time": "t_s", "times": times, "positions": right })),
    ] {
        write(folder.path(), "own.campaign.json", &campaign(readings).to_string());
        let report = fitted_by(folder.path(), "own.campaign.json");
        let value = |k: usize| report["parameters"][k]["value"].as_f64().unwrap_or_else(|| panic!("{name} {report}"));
        // an odd sample of 1 mV in a mean over a turn or more, of 600 samples or more, and times that are rounded to a sample
        assert!((value(0) - 0.1).abs() < 1e-5 && (value(1) - 0.02).abs() < 1e-6, "{name} {} {}", value(0), value(1));
    }
    for (names, what) in [
        (["P1", "P1", "P1", "P2"], "3 of the position 'P1', the record 2 segments"),
        (["P1", "P1", "p2", "P2"], "1 of the position 'P2', the record 2 segments"),
        (["P1", "P1", "p2", "p2"], "no position of the schedule is called 'P2'"),
    ] {
        write(folder.path(), "own.campaign.json", &campaign(by(&positions(names))).to_string());
        let (code, _, error) = tumble(folder.path(), &["fit", "own.campaign.json"]);
        let flat = error.split_whitespace().filter(|word| *word != "│").collect::<Vec<_>>().join(" ");
        assert!(code == 1 && flat.contains(what), "{flat}");
    }
    // the rows of a record: a run for each of the positions of a label, no fewer and no more
    for names in [["P1", "P1", "P1", "P2"], ["P1", "P2", "P2", "P2"]] {
        let mut rows = by(&positions(names));
        rows["as"] = "rows".into();
        write(folder.path(), "own.campaign.json", &campaign(rows).to_string());
        let (code, _, error) = tumble(folder.path(), &["fit", "own.campaign.json"]);
        assert!(code == 1 && error.contains("runs"), "{code} {error}");
    }
}
