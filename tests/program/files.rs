//! What is read and what is written: nothing is lost, nothing is half-written, nothing is read without end.
#![cfg(unix)]

use crate::support::data;
use std::os::unix::fs::{FileTypeExt, PermissionsExt, symlink};
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

fn tumble(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(assert_cmd::cargo::cargo_bin!("tumble"));
    command.current_dir(folder).args(arguments).stdin(Stdio::null());
    command
}

/// Exit code and stderr, on one line.
fn told(output: &Output) -> (Option<i32>, String) {
    let text = String::from_utf8_lossy(&output.stderr);
    (output.status.code(), text.split_whitespace().filter(|word| *word != "│").collect::<Vec<_>>().join(" "))
}

fn run(folder: &Path, arguments: &[&str]) -> (Option<i32>, String) {
    told(&tumble(folder, arguments).output().expect("a run"))
}

/// A folder with a campaign and its bench.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::copy(data("bad/good.campaign.json"), folder.path().join("good.campaign.json")).expect("a copy");
    folder
}

fn names(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).expect("the folder");
    let mut names: Vec<String> =
        entries.map(|entry| entry.expect("an entry").file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

fn fifo(path: &Path) {
    assert!(Command::new("mkfifo").arg(path).status().expect("mkfifo").success());
}

#[test]
fn what_is_no_regular_file_is_written_to_and_stays() {
    let folder = folder();
    let at = |name: &str| folder.path().join(name);
    fifo(&at("pipe"));
    let reader = std::thread::spawn({
        let pipe = at("pipe");
        move || std::fs::read_to_string(pipe).expect("a report")
    });
    assert_eq!(run(folder.path(), &["fit", "good.campaign.json", "--json", "pipe"]).0, Some(0));
    assert!(reader.join().expect("the reader").contains("\"report\": \"fit\""));
    assert!(at("pipe").metadata().expect("it").file_type().is_fifo());
    // a symbolic link, also to a file that is not there yet, is followed
    std::fs::create_dir(at("kept")).expect("a folder");
    symlink("kept/report.json", at("link.json")).expect("a link");
    for _ in 0..2 {
        assert_eq!(run(folder.path(), &["fit", "good.campaign.json", "--json", "link.json"]).0, Some(0));
        assert!(at("link.json").symlink_metadata().expect("it").is_symlink());
        assert!(at("kept/report.json").symlink_metadata().expect("it").is_file());
    }
    // the mode of a file stays
    std::fs::set_permissions(at("kept/report.json"), std::fs::Permissions::from_mode(0o600)).expect("a mode");
    assert_eq!(run(folder.path(), &["fit", "good.campaign.json", "--json", "kept/report.json"]).0, Some(0));
    assert_eq!(at("kept/report.json").metadata().expect("it").permissions().mode() & 0o777, 0o600);
    for sink in ["/dev/null", "/dev/stdout"] {
        assert_eq!(run(folder.path(), &["fit", "good.campaign.json", "--json", sink]).0, Some(0));
    }
    assert_eq!(names(&at("kept")), ["report.json"]);
}

#[test]
fn nothing_of_the_users_is_overwritten() {
    let folder = folder();
    let at = |name: &str| folder.path().join(name);
    let before = std::fs::read(at("good.campaign.json")).expect("the campaign");
    symlink("good.campaign.json", at("link.json")).expect("a link");
    for target in ["good.campaign.json", "./good.campaign.json", "link.json"] {
        for force in [&[][..], &["--force"]] {
            let arguments = [&["fit", "good.campaign.json", "--json", target], force].concat();
            let (code, text) = run(folder.path(), &arguments);
            assert!(code == Some(1) && text.contains("is an input"), "{target}: {text}");
        }
    }
    // existing questions, by name or by what is in them
    std::fs::copy(at("good.campaign.json"), at("plain.json")).expect("a copy");
    std::fs::copy(at("good.campaign.json"), at("other.campaign.json")).expect("a copy");
    for target in ["plain.json", "other.campaign.json"] {
        let (code, text) = run(folder.path(), &["fit", "good.campaign.json", "--json", target]);
        assert!(code == Some(1) && text.contains("exists") && text.contains("--force"), "{target}: {text}");
        assert_eq!(std::fs::read(at(target)).expect("the file"), before);
    }
    assert_eq!(run(folder.path(), &["fit", "good.campaign.json", "--json", "plain.json", "--force"]).0, Some(0));
    // a report is replaced by the next one
    assert_eq!(run(folder.path(), &["fit", "good.campaign.json", "--json", "plain.json"]).0, Some(0));
    // a model that is written, until somebody has changed it
    let table = data("li2012/li2012-table1.campaign.json").display().to_string();
    for (code, changed, force) in [(2, false, &[][..]), (2, false, &[]), (1, true, &[]), (2, false, &["--force"])] {
        if changed {
            let text = std::fs::read_to_string(at("r.bench.json")).expect("the bench");
            std::fs::write(at("r.bench.json"), text.replacen("\"title\": \"", "\"title\": \"my ", 1)).expect("written");
        }
        let arguments = [&["diagnose", &table, "--write-model", "r.bench.json"], force].concat();
        assert_eq!(run(folder.path(), &arguments).0, Some(code));
    }
    assert_eq!(std::fs::read(at("good.campaign.json")).expect("the campaign"), before);
}

#[test]
fn several_outputs_are_all_or_nothing() {
    let folder = folder();
    let before = names(folder.path());
    for (outputs, word) in [
        (["--html", "a.html", "--json", "none/x.json"], "no folder"),
        (["--html", "same", "--json", "same"], "two outputs go to 'same'"),
        (["--html", "same", "--json", "./same"], "two outputs go to './same'"),
        (["--html", "-", "--md", "-"], "two outputs go to standard output"),
        (["--html", "a.html", "--json", "/dev/full"], "cannot write '/dev/full'"),
    ] {
        let arguments = [&["fit", "good.campaign.json"], &outputs[..]].concat();
        let (code, text) = run(folder.path(), &arguments);
        assert!(code == Some(1) && text.contains(word), "{outputs:?}: {text}");
        assert_eq!(names(folder.path()), before, "{outputs:?}");
    }
}

#[test]
fn a_full_disk_is_told() {
    let folder = folder();
    let truth = folder.path().join("t.truth.json");
    std::fs::write(truth, r#"{ "noise": { "V": { "sd": 1e-4 } } }"#).expect("written");
    for arguments in [
        &["fit", "good.campaign.json"][..],
        &["fit", "good.campaign.json", "--json", "-"],
        &["fit", "good.campaign.json", "--json", "-", "--html", "page.html"],
        &["simulate", "good.campaign.json", "--truth", "t.truth.json"],
        &["schema", "campaign"],
        &["bench", "list"],
        &["--help"],
        &["fit", "--help"],
        &["--version"],
    ] {
        let full = std::fs::OpenOptions::new().write(true).open("/dev/full").expect("/dev/full");
        let (code, text) = told(&tumble(folder.path(), arguments).stdout(full).output().expect("a run"));
        assert!(code == Some(1) && text.contains("standard output"), "{arguments:?}: {code:?} {text}");
    }
    assert_eq!(names(folder.path()), ["good.campaign.json", "t.truth.json"]);
}

/// `2>&-`: there is nobody to tell, and the exit code says it.
#[test]
fn a_closed_stderr_changes_no_exit_code() {
    let folder = folder();
    let tumble = assert_cmd::cargo::cargo_bin!("tumble").display().to_string();
    for (code, rest) in [(1, "fit none.campaign.json"), (0, "fit good.campaign.json"), (1, "fit --no-such")] {
        let line = format!("'{tumble}' {rest} 2>&- >/dev/null");
        let status = Command::new("sh").args(["-c", &line]).current_dir(folder.path()).status().expect("a shell");
        assert_eq!(status.code(), Some(code), "{rest}");
    }
}

#[test]
fn an_interrupted_run_leaves_nothing_behind() {
    for (signal, code) in [("-INT", 130), ("-TERM", 143)] {
        let folder = tempfile::tempdir().expect("a folder");
        let mission = r#"{ "site": { "latitude_deg": 45 }, "duration_h": 100000, "step_s": 1, "motion": { "static": {} },
            "errors": { "gyro_bias_deg_h": [0.01, 0, 0] } }"#;
        std::fs::write(folder.path().join("long.mission.json"), mission).expect("written");
        let mut child = tumble(folder.path(), &["navigate", "long.mission.json", "--csv", "errors.csv"])
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .expect("a run");
        let started = Instant::now();
        while names(folder.path()).len() < 2 && started.elapsed() < Duration::from_secs(60) {
            if let Some(status) = child.try_wait().expect("a state") {
                panic!("ended early: {status} {}", told(&child.wait_with_output().expect("an end")).1);
            }
            std::thread::sleep(Duration::from_millis(5));
        }
        assert_eq!(names(folder.path()).len(), 2, "a temporary file beside the mission");
        assert!(Command::new("kill").args([signal, &child.id().to_string()]).status().expect("kill").success());
        assert_eq!(child.wait().expect("an end").code(), Some(code), "{signal}");
        assert_eq!(names(folder.path()), ["long.mission.json"], "{signal}");
    }
}

/// Inputs that never end, or would take all memory, are refused in a sentence.
#[test]
fn what_is_read_has_an_end() {
    let folder = folder();
    let (code, text) = run(folder.path(), &["fit", "/dev/zero"]);
    assert!(code == Some(1) && text.contains("not a text file"), "{text}");
    fifo(&folder.path().join("pipe"));
    let writer = std::thread::spawn({
        let pipe = folder.path().join("pipe");
        move || std::fs::write(pipe, "{ \"bench\": oops }")
    });
    let (code, text) = run(folder.path(), &["fit", "pipe"]);
    assert!(code == Some(1) && text.contains("in pipe, line 1"), "{text}");
    writer.join().expect("the writer").expect("written");
    let list: String = (0..1000).map(|k| k.to_string()).collect::<Vec<_>>().join(",");
    let schedule = format!(
        r#"{{ "bench": "gyro-turntable", "known": {{ "kI": {{ "value": -2.9 }} }}, "estimate": {{ "V0": {{}} }},
        "readings": [ {{ "alpha_deg": [{list}], "beta_deg": [{list}], "gamma_deg_s": [{list}] }} ] }}"#
    );
    std::fs::write(folder.path().join("lists.campaign.json"), schedule).expect("written");
    for command in ["check", "plan"] {
        let (code, text) = run(folder.path(), &[command, "lists.campaign.json"]);
        assert!(code == Some(1) && text.contains("found 1000000000 up to here"), "{text}");
    }
    let chain: Vec<String> = (0..1000).map(|k| format!(r#"{{ "joint": "j{k}", "about": "x" }}"#)).collect();
    let bench = format!(
        r#"{{ "id": "b", "chain": [ {} ], "sensors": {{ "V": {{ "axes": {{ "I": "x" }}, "model": "V0 + k*a_I" }} }} }}"#,
        chain.join(",")
    );
    std::fs::write(folder.path().join("long.bench.json"), bench).expect("written");
    let (code, text) = run(folder.path(), &["check", "long.bench.json"]);
    assert!(code == Some(1) && text.contains("at most 64") && text.contains("found 1000"), "{text}");
    let turns = std::fs::read_to_string(data("li2012/li2012-table1.campaign.json")).expect("the campaign");
    let turns = turns.replacen("\"gamma_deg_s\"", "\"gamma_turns\": 1e12, \"gamma_deg_s\"", 1);
    std::fs::write(folder.path().join("turns.campaign.json"), turns).expect("written");
    let (code, text) = run(folder.path(), &["fit", "turns.campaign.json"]);
    assert!(code == Some(1) && text.contains("at most 10000 turns"), "{text}");
}

/// Thousands of own effects are read as fast as they are written: each term is parsed once.
#[test]
fn a_catalogue_of_thousands_is_read() {
    let text: Vec<String> =
        (0..20_000).map(|k| format!(r#"{{ "term": "time_s^{}*step(time_s-{k})", "name": "e" }}"#, k % 5 + 1)).collect();
    let text = format!(r#"{{ "effects": [ {} ] }}"#, text.join(","));
    let source = tumble::wire::Source { name: "many".into(), text };
    assert_eq!(tumble::wire::read_effects(&source).expect("effects").len(), 20_000);
}

/// Tables look alike whoever wrote them, texts say who did: without `--force` only what this program wrote is replaced.
#[test]
fn files_of_others_stay_as_they_are() {
    let folder = folder();
    let own = |name: &str| folder.path().join(name);
    for (option, name) in
        [("--json", "readings.csv"), ("--html", "notes.html"), ("--md", "notes.md"), ("--json", "q.py")]
    {
        std::fs::write(own(name), "theta_deg,A\n0,1\n").expect("written");
        let (code, text) = run(folder.path(), &["fit", "good.campaign.json", option, name]);
        assert!(code == Some(1) && text.contains("exists") && text.contains("--force"), "{name}: {text}");
        assert_eq!(std::fs::read_to_string(own(name)).expect("the file"), "theta_deg,A\n0,1\n");
        let (code, text) = run(folder.path(), &["fit", "good.campaign.json", option, name, "--force"]);
        assert_ne!(code, Some(1), "{text}");
    }
    // a long page names the program behind its tables only
    let rows: Vec<String> = (0..1000).map(|k| format!(r#"{{ "x": {k}, "y": {} }}"#, k * k % 7)).collect();
    let long = format!(
        r#"{{ "bench": {{ "id": "line", "sensors": {{ "y": {{ "model": "a + b*x" }} }} }}, "estimate": {{ "a": {{}}, "b": {{}} }},
            "readings": [ {} ] }}"#,
        rows.join(", ")
    );
    std::fs::write(own("long.campaign.json"), long).expect("written");
    for _ in 0..2 {
        let (code, text) = run(folder.path(), &["fit", "long.campaign.json", "--md", "long.md"]);
        assert_ne!(code, Some(1), "{text}");
    }
    assert!(std::fs::metadata(own("long.md")).expect("a page").len() > 1 << 16);
    // a page of its own is replaced
    for _ in 0..2 {
        let (code, text) = run(
            folder.path(),
            &["fit", "good.campaign.json", "--html", "page.html", "--md", "page.md", "--json", "r.json"],
        );
        assert_ne!(code, Some(1), "{text}");
    }
}

/// What a command says when a text is piped into it.
fn piped(folder: &Path, arguments: &[&str], text: &str) -> Output {
    let mut child = tumble(folder, arguments)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("a run");
    let mut stdin = child.stdin.take().expect("a pipe");
    std::io::Write::write_all(&mut stdin, text.as_bytes()).expect("written");
    drop(stdin);
    child.wait_with_output().expect("an end")
}

/// The last column of a table of two rows is one and zero, to rounding.
fn assert_one_and_zero(output: &Output) {
    let text = String::from_utf8_lossy(&output.stdout);
    let last = text.lines().skip(1).map(|line| line.rsplit(',').next().expect("a cell").parse().expect("a number"));
    let inputs: Vec<f64> = last.collect();
    assert!((inputs[0] - 1.0).abs() < 1e-12 && inputs[1].abs() < 1e-12, "{inputs:?}");
}

/// A column that is given and kept is read once, in every dialect: V = V0 + 2*a_I + 0.1*(temperature_c - 20), V0 = 0.5.
#[test]
fn a_given_column_is_read_in_every_dialect() {
    let folder = tempfile::tempdir().expect("a folder");
    let campaign = r#"{ "bench": { "id": "head", "chain": [ { "joint": "theta", "about": "y" } ], "sensors": { "V": { "axes": { "I": "x" },
        "model": "V0 + 2*a_I + 0.1*(temperature_c - 20)" } } }, "estimate": { "V0": {} }, "readings": [ { "theta_deg": 0, "temperature_c": 20, "V": 0.5 } ] }"#;
    std::fs::write(folder.path().join("c.campaign.json"), campaign).expect("written");
    assert_ne!(run(folder.path(), &["fit", "c.campaign.json", "--json", "c.fit.json"]).0, Some(1));
    for log in [
        "n,V,temperature_c\nq,3.5,30\nr,0.5,20\n",
        "n;V;temperature_c\nq;3.5;30\nr;0.5;20\n",
        "n;V;temperature_c\nq;3,5;30\nr;0,5;20\n",
    ] {
        std::fs::write(folder.path().join("log.csv"), log).expect("written");
        let output = tumble(folder.path(), &["apply", "c.fit.json", "log.csv"]).output().expect("a run");
        assert_eq!(output.status.code(), Some(0), "{}", told(&output).1);
        assert_eq!(String::from_utf8_lossy(&output.stdout), "n,temperature_c,a_I\nq,30,1e0\nr,20,0e0\n", "{log}");
    }
    // under another title, in its unit; and what is neither a sensor nor an input is said
    std::fs::write(folder.path().join("log.csv"), "n,V,Temp [degF]\nq,3.5,86\nr,0.5,68\n").expect("written");
    let apply = |column: &str| {
        let output = tumble(folder.path(), &["apply", "c.fit.json", "log.csv", "--column", column]).output();
        output.expect("a run")
    };
    let output = apply("temperature_c=Temp [degF]");
    assert_eq!(output.status.code(), Some(0), "{}", told(&output).1);
    assert_one_and_zero(&output);
    for (column, what) in [("temp=Temp [degF]", "the correction has no 'temp'"), ("temperature_c=T", "no column 'T'")] {
        let output = apply(column);
        assert!(output.status.code() == Some(1) && told(&output).1.contains(what), "{}", told(&output).1);
    }
}

/// A record has the titles that the table of the calibration had: V = V0 + 2*a_I + 0.1*(temperature_c - 20), V0 = 0.5.
#[test]
fn titles_of_the_calibration_are_those_of_a_record() {
    let folder = tempfile::tempdir().expect("a folder");
    let campaign = r#"{ "bench": { "id": "head", "chain": [ { "joint": "theta", "about": "y" } ], "sensors": { "V": { "unit": "V", "axes": { "I": "x" },
        "model": "V0 + 2*a_I + 0.1*(temperature_c - 20)" } } }, "estimate": { "V0": {} }, "columns": { "V": "Output mV", "temperature_c": "Temp [degF]" },
        "readings": "table.csv" }"#;
    std::fs::write(folder.path().join("c.campaign.json"), campaign).expect("written");
    std::fs::write(folder.path().join("table.csv"), "theta_deg,Temp [degF],Output mV\n0,68,500\n0,86,1500\n")
        .expect("written");
    assert_ne!(run(folder.path(), &["fit", "c.campaign.json", "--json", "c.fit.json"]).0, Some(1));
    std::fs::write(folder.path().join("log.csv"), "n,Output mV,Temp [degF]\n1,3500,86\n2,500,68\n").expect("written");
    let output = tumble(folder.path(), &["apply", "c.fit.json", "log.csv"]).output().expect("a run");
    assert_eq!(output.status.code(), Some(0), "{}", told(&output).1);
    assert_one_and_zero(&output);
}

/// `apply` reads the tables that `fit` reads, in their units.
#[test]
fn apply_reads_dialects_and_units() {
    let folder = tempfile::tempdir().expect("a folder");
    let campaign = r#"{ "bench": { "id": "head", "chain": [ { "joint": "theta", "about": "y" } ],
        "sensors": { "A": { "unit": "V", "axes": { "I": "x" }, "model": "K0 + K1*a_I" } } }, "estimate": { "K0": {}, "K1": {} },
        "readings": [ { "theta_deg": 0, "A": 0.5 }, { "theta_deg": 90, "A": -1.5 }, { "theta_deg": 270, "A": 2.5 } ] }"#;
    std::fs::write(folder.path().join("c.campaign.json"), campaign).expect("written");
    assert_ne!(run(folder.path(), &["fit", "c.campaign.json", "--json", "c.fit.json"]).0, Some(1));
    let apply = |log: &str, more: &[&str]| {
        std::fs::write(folder.path().join("log.csv"), log).expect("written");
        let output =
            tumble(folder.path(), &[&["apply", "c.fit.json", "log.csv"], more].concat()).output().expect("a run");
        assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
        let text = String::from_utf8(output.stdout).expect("UTF-8");
        text.lines()
            .skip(1)
            .map(|line| line.rsplit(',').next().expect("a cell").parse::<f64>().expect("a number"))
            .collect::<Vec<_>>()
    };
    // A = 0.5 V + 2 V/g * a_I
    let same = |found: Vec<f64>| {
        assert!(found.iter().zip([0.0, 1.0]).all(|(a, b)| (a - b).abs() < 1e-9) && found.len() == 2, "{found:?}")
    };
    same(apply("time_s,A\n0,0.5\n1,2.5\n", &[]));
    same(apply("time_s,A (mV)\n0,500\n1,2500\n", &[]));
    same(apply("time_s;Spannung [mV]\n0;500,0\n1;2500,0\n", &["--column", "A=Spannung [mV]"]));
    same(apply("time_s;A\n0;0,5\n1;2,5\n", &[]));
    // what lies beyond the one g of the calibration is said, noise at its end is not
    for (reading, is_beyond) in [("6.5", true), ("2.6", false)] {
        std::fs::write(folder.path().join("log.csv"), format!("time_s,A\n0,0.5\n1,{reading}\n")).expect("written");
        let (code, error) = run(folder.path(), &["apply", "c.fit.json", "log.csv"]);
        assert_eq!(code, Some(0), "{error}");
        assert_eq!(error.contains("a_I of 1 of 2 rows lies beyond"), is_beyond, "{reading}: {error}");
    }
    // through a pipe, in every dialect
    for log in ["time_s,A\n0,0.5\n1,2.5\n", "time_s;A\n0;0,5\n1;2,5\n", "\u{feff}A\ttime_s\n0.5\t0\n2.5\t1\n"] {
        let output = piped(folder.path(), &["apply", "c.fit.json", "-"], log);
        assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
        let text = String::from_utf8(output.stdout).expect("UTF-8");
        same(
            text.lines()
                .skip(1)
                .map(|line| line.rsplit(',').next().expect("a cell").parse().expect("a number"))
                .collect(),
        );
    }
    // a fault in the first row finds nothing printed; one in a later row says how many rows stand before it
    for (log, printed, rows) in [
        ("time_s,A\n0,x\n", "", None),
        ("time_s,A\n0,0.5\n1,2.5\n2,x\n", "time_s,a_I\n0,0e0\n1,1e0\n", Some("the 2 rows before")),
    ] {
        let output = piped(folder.path(), &["apply", "c.fit.json", "-"], log);
        let (code, error) = told(&output);
        assert!(code == Some(1) && rows.is_none_or(|rows| error.contains(rows)), "{error}");
        assert_eq!(String::from_utf8_lossy(&output.stdout), printed);
    }
}

/// What a command wrote it writes anew; what somebody wrote or changed, in the same columns, it leaves.
#[test]
fn own_outputs_are_replaced_and_those_of_others_are_not() {
    let folder = folder();
    let at = |name: &str| folder.path().join(name);
    let example = |name: &str| Path::new(env!("CARGO_MANIFEST_DIR")).join("examples").join(name).display().to_string();
    let mission = std::fs::read_to_string(example("19-navigation-errors/truth.mission.json")).expect("a mission");
    let mut mission: serde_json::Value = serde_json::from_str(&mission).expect("JSON");
    mission["duration_h"] = serde_json::json!(0.1);
    mission["step_s"] = serde_json::json!(0.1);
    std::fs::write(at("m.mission.json"), mission.to_string()).expect("written");
    let record: String =
        (0..600).map(|k| format!("{},{},{}\n", f64::from(k) * 0.01, (k * 7919) % 13, k / 200)).collect();
    std::fs::write(at("log.csv"), format!("time_s,V,place\n{record}")).expect("written");
    let (schedule, truth) =
        (example("07-hidden-effect/schedule.campaign.json"), example("07-hidden-effect/hidden.truth.json"));
    let fit = ["fit", &example("13-accelerometer-dividing-head/head-12.campaign.json"), "--json", "c.fit.json"];
    assert_ne!(run(folder.path(), &fit).0, Some(1));
    std::fs::write(at("samples.csv"), "time_s,A\n0,0.5\n1,\n2,0.25\n").expect("written");
    let commands: [(&str, Vec<&str>, &str); 8] = [
        ("a.csv", vec!["apply", "c.fit.json", "samples.csv", "--out"], ""),
        ("u.csv", vec!["apply", "c.fit.json", "samples.csv", "--u", "--out"], ""),
        ("s.campaign.json", vec!["simulate", &schedule, "--truth", &truth, "-o"], "-0.06"),
        ("p.campaign.json", vec!["plan", &schedule, "--noise", "V=1e-4", "--write"], "20.0"),
        ("e.csv", vec!["navigate", "m.mission.json", "--csv"], ""),
        ("e.parquet", vec!["navigate", "m.mission.json", "--parquet"], ""),
        ("n.csv", vec!["navigate", "m.mission.json", "--noise-m", "5", "--measured"], ""),
        ("r.csv", vec!["reduce", "log.csv", "--by", "place", "--columns", "V", "--to"], ""),
    ];
    for (name, command, changed) in commands {
        let command = [&command[..], &[name]].concat();
        for _ in 0..2 {
            let (code, text) = run(folder.path(), &command);
            assert_ne!(code, Some(1), "{name}: {text}");
        }
        let own = std::fs::read(at(name)).expect("an output");
        let text = String::from_utf8_lossy(&own);
        let others: Vec<Vec<u8>> = match name {
            // a digit changed by hand
            _ if name.ends_with(".json") => {
                assert!(text.contains(changed), "{name}: {text}");
                vec![text.replacen(changed, &format!("{changed}1"), 1).into_bytes()]
            }
            // the same titles with numbers as people and other programs write them, and other titles
            _ if name.ends_with(".csv") => {
                let header = text.lines().next().expect("titles");
                let row = header.split(',').map(|_| "1.5e-04").collect::<Vec<_>>().join(",");
                // without any number in the last column nothing tells whose it is
                let empty = header.split(',').map(|_| "").collect::<Vec<_>>().join(",");
                let all = [format!("{header}\n{row}\n"), "position,V\n1,0.1\n".into(), format!("{header}\n{empty}\n")];
                all.map(String::into_bytes).to_vec()
            }
            _ => vec![b"PAR1 and what another wrote".to_vec()],
        };
        for other in others {
            std::fs::write(at(name), &other).expect("written");
            let (code, text) = run(folder.path(), &command);
            assert!(code == Some(1) && text.contains("--force"), "{name}: {text}");
            assert_eq!(std::fs::read(at(name)).expect("the file"), other);
        }
    }
}

/// The campaign from standard input, and behind the files of its readings.
#[test]
fn a_campaign_comes_from_standard_input_or_behind_its_readings() {
    let folder = folder();
    let plain = tumble(folder.path(), &["fit", "good.campaign.json"]).output().expect("a run");
    let input = std::fs::File::open(folder.path().join("good.campaign.json")).expect("the campaign");
    let given = tumble(folder.path(), &["fit", "-"]).stdin(input).output().expect("a run");
    assert_eq!(String::from_utf8_lossy(&given.stdout), String::from_utf8_lossy(&plain.stdout), "{given:?}");
    // commands that look at what the file is before they take it read it once
    let text = std::fs::read_to_string(folder.path().join("good.campaign.json")).expect("the campaign");
    for command in ["check", "compare"] {
        let plain = tumble(folder.path(), &[command, "good.campaign.json"]).output().expect("a run");
        let again = piped(folder.path(), &[command, "-"], &text);
        // up to the place of an error, which has the file's name
        let said = |output: &Output| (output.status.code(), told(output).1.split(" in ").next().map(String::from));
        assert_eq!(said(&again), said(&plain), "{command}");
    }
    let example = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/24-temperature");
    let before =
        tumble(&example, &["fit", "chamber.campaign.json", "--readings", "readings.csv"]).output().expect("a run");
    let behind =
        tumble(&example, &["fit", "--readings", "readings.csv", "chamber.campaign.json"]).output().expect("a run");
    assert_eq!((&before.stdout, before.status.code()), (&behind.stdout, behind.status.code()), "{behind:?}");
    assert!(String::from_utf8_lossy(&before.stdout).contains("gyro-temperature"));
    let (code, text) = run(folder.path(), &["fit"]);
    assert!(code == Some(1) && text.contains("CAMPAIGN"), "{text}");
}

/// Squares beyond a double are no statistics: refused, where zero and NaN stood.
#[test]
fn records_beyond_squares_are_refused() {
    let folder = folder();
    let rows: String = (0..600).map(|k| format!("{},{}e200\n", f64::from(k) * 0.01, (k * 7919) % 13 + 1)).collect();
    std::fs::write(folder.path().join("log.csv"), format!("time_s,V\n{rows}")).expect("written");
    for command in ["reduce", "noise"] {
        let (code, text) = run(folder.path(), &[command, "log.csv"]);
        assert!(code == Some(1) && text.contains("too large to be squared") && text.contains("'V'"), "{text}");
    }
}

/// The difference of two fits of the same readings has not the uncertainty of two calibrations.
#[test]
fn readings_are_not_compared_with_themselves() {
    let example = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/21-calibration-in-use");
    for files in [vec!["before.fit.json"; 2], vec!["before.fit.json", "after.fit.json", "before.fit.json"]] {
        let (code, text) = run(&example, &[&["compare"][..], &files].concat());
        assert!(code == Some(1) && text.contains("the same readings"), "{text}");
    }
}

/// A level so small that the expanded uncertainty is zero: no quotient, and so no number.
#[test]
fn a_quotient_by_zero_is_no_number() {
    let example = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/21-calibration-in-use");
    let folder = folder();
    let again = folder.path().join("again.fit.json").display().to_string();
    crate::schemas::other_readings(&example.join("before.fit.json").display().to_string(), &again, 1e-9);
    let mut twice = vec!["compare", "before.fit.json", &again, "--level", "1e-308"];
    let page = folder.path().join("page.html").display().to_string();
    twice.extend(["--html", &page]);
    let output = tumble(&example, &twice).output().expect("a run");
    let text =
        String::from_utf8_lossy(&output.stdout).into_owned() + &std::fs::read_to_string(&page).unwrap_or_default();
    assert!(text.contains("E_n") && !text.contains("NaN"), "{text}");
}

/// What stays of a record stays as it is: whole numbers of 64 bits, whatever they say, in CSV and in Parquet; written times as texts in Parquet.
#[test]
fn apply_keeps_whole_numbers_and_written_times() {
    use parquet::basic::{LogicalType, Repetition, TimeUnit, Type as Physical};
    use parquet::column::reader::ColumnReader;
    use parquet::data_type::{DoubleType, Int64Type};
    use parquet::file::reader::{FileReader, SerializedFileReader};
    use parquet::schema::types::Type;
    use std::sync::Arc;
    let folder = tempfile::tempdir().expect("a folder");
    let campaign = r#"{ "bench": { "id": "head", "chain": [ { "joint": "theta", "about": "y" } ], "sensors": { "V": { "axes": { "I": "x" },
        "model": "V0 + 2*a_I" } } }, "estimate": { "V0": {} }, "readings": [ { "theta_deg": 0, "V": 0.5 } ] }"#;
    std::fs::write(folder.path().join("c.campaign.json"), campaign).expect("written");
    assert_ne!(run(folder.path(), &["fit", "c.campaign.json", "--json", "c.fit.json"]).0, Some(1));
    let kinds = [
        ("t_ns", None),
        ("ts", Some(LogicalType::timestamp(false, TimeUnit::NANOS))),
        ("ms", Some(LogicalType::timestamp(true, TimeUnit::MILLIS))),
        ("id", Some(LogicalType::integer(64, false))),
    ];
    let values = [
        [1_714_564_800_123_457_162_i64, 1_714_564_800_143_456_925],
        [1_714_564_800_123_457_162, -1],
        [1_714_564_800_120, 1_714_564_801_000],
        [-1, 9_007_199_254_740_993],
    ];
    let field = |title: &str, kind: Physical, logical: Option<LogicalType>| {
        let own = Type::primitive_type_builder(title, kind).with_repetition(Repetition::OPTIONAL);
        Arc::new(own.with_logical_type(logical).build().expect("a field"))
    };
    let fields = kinds.iter().map(|(title, logical)| field(title, Physical::INT64, logical.clone()));
    let fields = fields.chain([field("V", Physical::DOUBLE, None)]).collect();
    let schema = Type::group_type_builder("log").with_fields(fields).build().expect("a schema");
    let file = std::fs::File::create(folder.path().join("log.parquet")).expect("a file");
    let mut writer =
        parquet::file::writer::SerializedFileWriter::new(file, Arc::new(schema), Default::default()).expect("a writer");
    let mut group = writer.next_row_group().expect("a group");
    for own in &values {
        let mut column = group.next_column().expect("a column").expect("one more");
        // the third row has none
        column.typed::<Int64Type>().write_batch(own, Some(&[1, 1, 0]), None).expect("values");
        column.close().expect("a column");
    }
    let mut column = group.next_column().expect("a column").expect("one more");
    column.typed::<DoubleType>().write_batch(&[0.5, 2.5, 0.5], Some(&[1, 1, 1]), None).expect("values");
    column.close().expect("a column");
    group.close().expect("a group");
    writer.close().expect("a file");

    let output = tumble(folder.path(), &["apply", "c.fit.json", "log.parquet"]).output().expect("a run");
    assert_eq!(output.status.code(), Some(0), "{}", told(&output).1);
    let lines = [
        "t_ns,ts,ms,id,a_I",
        "1714564800123457162,1714564800.123457162,1714564800.12,18446744073709551615,0e0",
        "1714564800143456925,-0.000000001,1714564801,9007199254740993,1e0",
        ",,,,0e0",
    ];
    assert_eq!(String::from_utf8_lossy(&output.stdout).lines().collect::<Vec<_>>(), lines);
    let (code, error) = run(folder.path(), &["apply", "c.fit.json", "log.parquet", "--out", "out.parquet"]);
    assert_eq!(code, Some(0), "{error}");
    let reader = SerializedFileReader::new(std::fs::File::open(folder.path().join("out.parquet")).expect("a file"));
    let reader = reader.expect("a table");
    let schema = reader.metadata().file_metadata().schema_descr();
    let group = reader.get_row_group(0).expect("a group");
    for (k, (own, (title, logical))) in values.iter().zip(&kinds).enumerate() {
        let descriptor = schema.column(k);
        assert_eq!((descriptor.name(), descriptor.logical_type_ref()), (*title, logical.as_ref()));
        let ColumnReader::Int64ColumnReader(mut column) = group.get_column_reader(k).expect("a column") else {
            panic!("{title}: no whole numbers");
        };
        let (mut levels, mut found) = (Vec::new(), Vec::new());
        column.read_records(10, Some(&mut levels), None, &mut found).expect("values");
        assert_eq!((levels, found), (vec![1, 1, 0], own.to_vec()), "{title}");
    }

    let stamps = ["2024-05-01T12:00:00Z", "2024-05-01T12:00:01Z"];
    std::fs::write(folder.path().join("log.csv"), format!("stamp,V\n{},0.5\n{},2.5\n", stamps[0], stamps[1]))
        .expect("written");
    let (code, error) = run(folder.path(), &["apply", "c.fit.json", "log.csv", "--out", "stamped.parquet"]);
    assert_eq!(code, Some(0), "{error}");
    let mut record = tumble::record::Record::at(&folder.path().join("stamped.parquet")).expect("a record");
    record.select(&[(0, tumble::record::As::Label), (1, tumble::record::As::Number)]);
    let mut block = tumble::record::Block::default();
    assert!(record.next(&mut block).expect("rows"));
    assert_eq!((record.labels(), &block.columns[1]), (&stamps.map(String::from)[..], &vec![0.0, 1.0]));
}

/// Written times in readings of the campaign itself and in a record that is corrected are those of a table of readings: seconds since the first. V = 0.5 + 0.25 t + 2 a_I.
#[test]
fn written_times_through_every_door() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |seconds: u32| format!("2026-11-20T09:{:02}:{:02}Z", 14 + seconds / 60, seconds % 60);
    let rows = [(0, 0, 0.5), (10, 90, 5.0), (70, 0, 18.0), (90, 90, 25.0)];
    let campaign = |readings: String, more: &str| {
        format!(
            r#"{{ "bench": {{ "id": "head", "chain": [ {{ "joint": "theta", "about": "y" }} ], "sensors": {{ "V": {{ "axes": {{ "I": "x" }},
            "model": "V0 + d*time_s + 2*a_I" }} }} }}, "estimate": {{ "V0": {{}}, "d": {{}} }} {more}, "readings": {readings} }}"#
        )
    };
    let number = |report: &serde_json::Value, id: &str| {
        let own = report["parameters"].as_array().expect("parameters").iter().find(|own| own["id"] == id).cloned();
        own.expect("the parameter")["value"].as_f64().expect("a value")
    };
    let fit = |name: &str, text: &str| -> serde_json::Value {
        std::fs::write(folder.path().join(name), text).expect("written");
        let (code, error) = run(folder.path(), &["fit", name, "--json", "fit.json"]);
        assert_ne!(code, Some(1), "{error}");
        serde_json::from_str(&std::fs::read_to_string(folder.path().join("fit.json")).expect("a report")).expect("JSON")
    };
    let line = |(seconds, theta, v): &(u32, i32, f64)| {
        format!(r#"{{ "time_s": "{}", "theta_deg": {theta}, "V": {v} }}"#, at(*seconds))
    };
    let inline = format!("[{}]", rows.iter().map(line).collect::<Vec<_>>().join(", "));
    let table: String = rows.iter().map(|(seconds, theta, v)| format!("{},{theta},{v}\n", at(*seconds))).collect();
    std::fs::write(folder.path().join("table.csv"), format!("time_s,theta_deg,V\n{table}")).expect("written");
    let of_table = fit("table.campaign.json", &campaign(r#""table.csv""#.into(), ""));
    let of_inline = fit("inline.campaign.json", &campaign(inline, ""));
    for id in ["V0", "d"] {
        assert_eq!(number(&of_inline, id), number(&of_table, id), "{id}");
    }
    let exact = campaign(
        "[ { \"time_s\": 0, \"theta_deg\": 0, \"V\": 0.5 }, { \"time_s\": 8, \"theta_deg\": 0, \"V\": 2.5 } ]".into(),
        "",
    );
    fit("exact.campaign.json", &exact);
    std::fs::write(folder.path().join("log.csv"), format!("time_s,V\n{},2.5\n{},21.0\n", at(10), at(90)))
        .expect("written");
    let output = tumble(folder.path(), &["apply", "fit.json", "log.csv"]).output().expect("a run");
    assert_eq!(output.status.code(), Some(0), "{}", told(&output).1);
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    let corrected: Vec<(&str, f64)> = text
        .lines()
        .skip(1)
        .map(|line| {
            (
                line.split(',').next().expect("a time"),
                line.rsplit(',').next().expect("a cell").parse().expect("a number"),
            )
        })
        .collect();
    // 2.5 = 0.5 + 2 a; 21 = 0.5 + 20 + 2 a
    for ((time, found), (seconds, expected)) in corrected.iter().zip([(10, 1.0), (90, 0.25)]) {
        assert!(*time == at(seconds) && (found - expected).abs() < 1e-9, "{text}");
    }
    assert_eq!(corrected.len(), 2, "{text}");
    // below written times a number is none
    let mixed = campaign(format!(r#"[ {}, {{ "time_s": 5, "theta_deg": 0, "V": 1 }} ]"#, line(&rows[0])), "");
    std::fs::write(folder.path().join("mixed.campaign.json"), mixed).expect("written");
    let (code, error) = run(folder.path(), &["fit", "mixed.campaign.json"]);
    assert!(code == Some(1) && error.contains("time_s is not a time"), "{error}");
}
