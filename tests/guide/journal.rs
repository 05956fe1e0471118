//! The program: a simulated calibration, its journal, kills at any moment, lines that are no readings.

use crate::draws::draws;
use rand_pcg::Pcg64Mcg;
use rand_pcg::rand_core::SeedableRng;
use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Child, Command, Stdio};

const SCHEDULE: &str = include_str!("../../examples/07-hidden-effect/schedule.campaign.json");
const TRUTH: &str = include_str!("../../examples/07-hidden-effect/hidden.truth.json");

fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("schedule.campaign.json"), SCHEDULE).unwrap();
    std::fs::write(folder.path().join("hidden.truth.json"), TRUTH).unwrap();
    folder
}

fn tumble(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_tumble"));
    command.current_dir(folder).arg("guide").args(arguments);
    command
}

const SIMULATED: [&str; 7] =
    ["schedule.campaign.json", "--simulate", "hidden.truth.json", "--noise", "V=1e-4", "--goal", "8"];

#[test]
fn a_simulated_calibration_ends_with_an_ordinary_campaign() {
    let folder = folder();
    let output = tumble(folder.path(), &SIMULATED).output().unwrap();
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(output.status.success(), "{text}\n{}", String::from_utf8_lossy(&output.stderr));
    assert!(text.contains("next: position"), "{text}");
    assert!(text.contains("done: every goal is met"), "{text}");
    let campaign = std::fs::read_to_string(folder.path().join("guided.campaign.json")).unwrap();
    assert!(campaign.contains("journal guided.journal.jsonl, SHA-256"), "{campaign}");
    let fitted = Command::new(env!("CARGO_BIN_EXE_tumble"))
        .current_dir(folder.path())
        .args(["check", "guided.campaign.json"])
        .output()
        .unwrap();
    assert!(fitted.status.success());
}

/// Five orientations of which two are the same: the means and differences of both senses tell four combinations of the five tilts beside the bias, so that no
/// tilt's goal can be reached. Every orientation is read, and no reading is asked for that decides nothing.
#[test]
fn it_stops_where_readings_decide_nothing_more() {
    let folder = tempfile::tempdir().unwrap();
    let schedule = r#"{"bench": "gyro-turntable", "known": {"kI": {"value": -2.9222, "unit": "V/(deg/s)", "u": 0}},
        "estimate": {"V0": {}, "dtheta_x0": {}, "dtheta_y0": {}, "dtheta_y1": {}, "dtheta_y2": {}, "dtheta_z2": {}},
        "readings": [
            {"position": "1", "alpha_deg": 135, "beta_deg": 225, "gamma_deg_s": [40, -40]},
            {"position": "2", "alpha_deg": 135, "beta_deg": 225, "gamma_deg_s": [10, -10]},
            {"position": "3", "alpha_deg": 135, "beta_deg": 270, "gamma_deg_s": [20, -20]},
            {"position": "4", "alpha_deg": 90, "beta_deg": 135, "gamma_deg_s": [40, -40]},
            {"position": "5", "alpha_deg": 0, "beta_deg": 270, "gamma_deg_s": [10, -10]}]}"#;
    let truth = r#"{"values": {"V0": {"value": 0.001}, "dtheta_x0": {"value": -52, "unit": "arcsec"}, "dtheta_y1": {"value": 80, "unit": "arcsec"}},
        "noise": {"V": {"sd": 1e-4}}}"#;
    std::fs::write(folder.path().join("schedule.campaign.json"), schedule).unwrap();
    std::fs::write(folder.path().join("hidden.truth.json"), truth).unwrap();
    for seed in ["1", "2", "3"] {
        let journal = format!("{seed}.jsonl");
        let arguments = [&SIMULATED[..], &["--seed", seed, "--force", "--journal", &journal]].concat();
        let output = tumble(folder.path(), &arguments).output().unwrap();
        let text = String::from_utf8(output.stdout).unwrap();
        assert_eq!(output.status.code(), Some(2), "{text}");
        assert!(text.contains("would not decide"), "{text}");
        let campaign = std::fs::read_to_string(folder.path().join("guided.campaign.json")).unwrap();
        let campaign: serde_json::Value = serde_json::from_str(&campaign).unwrap();
        let readings = campaign["readings"].as_array().unwrap();
        let orientations: std::collections::BTreeSet<String> =
            readings.iter().map(|own| format!("{} {}", own["alpha_deg"], own["beta_deg"])).collect();
        assert_eq!(orientations.len(), 4, "{orientations:?}");
    }
}

/// 3 kills by default, 1,000 with `TUMBLE_LONG=1`.
#[test]
fn killed_at_any_moment_it_ends_with_the_same_bytes() {
    let whole = folder();
    let started = std::time::Instant::now();
    assert!(tumble(whole.path(), &SIMULATED).output().unwrap().status.success());
    let lasts = started.elapsed();
    let expected =
        ["guided.campaign.json", "guided.journal.jsonl"].map(|name| std::fs::read(whole.path().join(name)).unwrap());
    let mut random = Pcg64Mcg::seed_from_u64(1);
    let mut kills = 0;
    while kills < draws(3, 1000) {
        let own = folder();
        let mut resumes = false;
        loop {
            let mut arguments = SIMULATED.to_vec();
            arguments.extend(resumes.then_some("--resume"));
            let mut child: Child =
                tumble(own.path(), &arguments).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
            std::thread::sleep(lasts.mul_f64(crate::bench::uniform(&mut random, 0.05, 1.2)));
            if child.try_wait().unwrap().is_some() {
                break;
            }
            child.kill().unwrap();
            child.wait().unwrap();
            kills += 1;
            resumes = own.path().join("guided.journal.jsonl").exists();
        }
        let found =
            ["guided.campaign.json", "guided.journal.jsonl"].map(|name| std::fs::read(own.path().join(name)).unwrap());
        assert!(found == expected, "{}", String::from_utf8_lossy(&found[1]));
    }
}

#[test]
fn a_second_guide_on_one_journal_is_refused() {
    let folder = folder();
    let arguments = ["schedule.campaign.json", "--noise", "V=1e-4"];
    let mut first = tumble(folder.path(), &arguments)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    // it has its journal when it has said something
    let mut line = String::new();
    BufReader::new(first.stdout.as_mut().unwrap()).read_line(&mut line).unwrap();
    let second = tumble(folder.path(), &arguments).args(["--resume"]).stdin(Stdio::null()).output().unwrap();
    assert_eq!(second.status.code(), Some(1));
    let said = String::from_utf8(second.stderr).unwrap();
    assert!(said.contains("another guide writes the journal"), "{said}");
    drop(first.stdin.take());
    first.wait().unwrap();
    let third = tumble(folder.path(), &arguments).stdin(Stdio::null()).output().unwrap();
    assert!(String::from_utf8(third.stderr).unwrap().contains("is there already"));
}

#[test]
fn lines_that_are_no_readings_are_said_and_the_next_one_is_taken() {
    let folder = folder();
    let arguments = ["schedule.campaign.json", "--noise", "V=1e-4", "--json", "-"];
    let mut guide = tumble(folder.path(), &arguments)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let mut input = guide.stdin.take().unwrap();
    let mut answers = BufReader::new(guide.stdout.take().unwrap()).lines();
    let schema = jsonschema::validator_for(&tumble::report::schema("guide-report").unwrap()).unwrap();
    let mut next = || {
        let line: serde_json::Value = serde_json::from_str(&answers.next().unwrap().unwrap()).unwrap();
        let faults: Vec<String> = schema.iter_errors(&line).map(|error| error.to_string()).collect();
        assert!(faults.is_empty(), "{faults:?}");
        line
    };
    let asked = next();
    assert!(asked["next"]["set"]["gamma_deg_s"].is_number(), "{asked}");
    for (line, said) in [
        ("{\"V\": }", "the line is not a reading"),
        ("1,2,3", "there is no line of titles"),
        // a word that was mistyped is no line of titles, under which nothing could be read from then on
        ("udno", "not a reading, a command or titles"),
        ("{\"V\": -58.0, \"position\": \"12a\"}", "no position of this label"),
        ("{\"W\": 1}", "no 'W'"),
        ("{\"position\": \"1\", \"gamma_deg_s\": 20}", "the reading has no value"),
        ("{\"position\": \"8\", \"beta_deg\": 45, \"V\": 1}", "does not say how gamma stands"),
        ("undo 7", "there is no reading 7"),
        ("undo last", "'undo' is not understood"),
    ] {
        writeln!(input, "{line}").unwrap();
        let answer = next();
        assert!(answer["error"].as_str().is_some_and(|text| text.contains(said)), "{line}: {answer}");
    }
    writeln!(input, "{{\"V\": -58.0}}").unwrap();
    assert_eq!(next()["readings"], 1);
    writeln!(input, "position;gamma_deg_s;V").unwrap();
    writeln!(input, "\"2\";20;-0,5").unwrap();
    assert_eq!(next()["readings"], 2);
    writeln!(input, "undo").unwrap();
    assert_eq!(next()["readings"], 1);
    writeln!(input, "quit").unwrap();
    assert_eq!(guide.wait().unwrap().code(), Some(2));
    let journal = std::fs::read_to_string(folder.path().join("guided.journal.jsonl")).unwrap();
    assert!(journal.contains("{\"undone\":{\"number\":2}}"), "{journal}");
    assert_eq!(journal.matches("\"reading\"").count(), 2);
}

#[test]
fn a_full_disk_stops_it_before_anything_is_shown() {
    if !Path::new("/dev/full").exists() {
        return;
    }
    let folder = folder();
    let output = tumble(folder.path(), &SIMULATED).args(["--journal", "/dev/full"]).output().unwrap();
    assert_eq!(output.status.code(), Some(1));
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(said.contains("cannot write the journal '/dev/full'"), "{said}");
    assert!(output.stdout.is_empty());
}

#[test]
fn a_file_that_grows_is_followed() {
    let folder = folder();
    let path = folder.path().join("table.csv");
    std::fs::write(&path, "position,gamma_deg_s,V\n1,20,-58.4").unwrap();
    let arguments = ["schedule.campaign.json", "--noise", "V=1e-4", "--json", "-", "--readings", "table.csv"];
    let mut guide = tumble(folder.path(), &arguments).stdout(Stdio::piped()).stderr(Stdio::null()).spawn().unwrap();
    let mut answers = BufReader::new(guide.stdout.take().unwrap()).lines();
    let mut next = || serde_json::from_str::<serde_json::Value>(&answers.next().unwrap().unwrap()).unwrap();
    assert_eq!(next()["readings"], 0);
    let mut file = std::fs::OpenOptions::new().append(true).open(&path).unwrap();
    // the rest of the line, and one more
    write!(file, "43\n1,-20,58.4\n").unwrap();
    let first = next();
    assert_eq!(
        (&first["readings"], &first["newest"]["setting"]),
        (&1.into(), &"gamma 20 deg/s, beta 0 deg, alpha 0 deg".into())
    );
    assert_eq!(next()["readings"], 2);
    writeln!(file, "quit").unwrap();
    assert_eq!(guide.wait().unwrap().code(), Some(2));
}

#[test]
fn a_file_that_is_removed_or_cut_is_said() {
    for cut in [false, true] {
        let folder = folder();
        let path = folder.path().join("table.csv");
        std::fs::write(&path, "position,gamma_deg_s,V\n1,20,-58.443\n").unwrap();
        let arguments = ["schedule.campaign.json", "--noise", "V=1e-4", "--json", "-", "--readings", "table.csv"];
        let mut guide = tumble(folder.path(), &arguments);
        let mut guide = guide.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        let mut answers = BufReader::new(guide.stdout.take().unwrap()).lines();
        answers.next().unwrap().unwrap();
        answers.next().unwrap().unwrap();
        if cut {
            std::fs::write(&path, "position").unwrap()
        } else {
            std::fs::remove_file(&path).unwrap()
        }
        let output = guide.wait_with_output().unwrap();
        let said = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(1), "{said}");
        assert!(said.contains("no more readings come from 'table.csv'"), "{said}");
        // what was accepted is kept
        let journal = std::fs::read_to_string(folder.path().join("guided.journal.jsonl")).unwrap();
        assert_eq!(journal.matches("\"reading\"").count(), 1);
    }
}

#[test]
fn it_is_spoken_with_inside_another_process() {
    let folder = folder();
    let path = |name: &str| folder.path().join(name).display().to_string();
    let arguments: Vec<String> = ["guide", "--noise", "V=1e-4", "--json", "-", "--output"].map(String::from).to_vec();
    let arguments = [arguments, vec![path("own.campaign.json"), path("schedule.campaign.json")]].concat();
    let ((say, heard), (said, hear)) = (std::sync::mpsc::channel(), std::sync::mpsc::channel());
    let guide = std::thread::spawn(move || tumble::cli::converse(arguments, heard, said));
    let next = || serde_json::from_str::<tumble::report::GuideReport>(&hear.recv().unwrap()).unwrap();
    let first = next();
    assert_eq!(first.advice.readings, 0);
    assert!(tumble::cli::guide_text(&first).starts_with("next: position 1: gamma 40 deg/s"), "{first:?}");
    say.send("{\"W\": 1}".to_string()).unwrap();
    assert!(next().error.is_some_and(|text| text.contains("no 'W'")));
    say.send("{\"V\": -116.9}".to_string()).unwrap();
    assert_eq!(next().advice.readings, 1);
    drop(say);
    let printed = guide.join().unwrap();
    assert_eq!((printed.exit_code, printed.stdout.len()), (2, 0));
    assert!(std::fs::read_to_string(path("own.campaign.json")).unwrap().contains("-116.9"));
}
