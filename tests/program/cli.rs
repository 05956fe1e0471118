//! The program: exit codes, what goes where, and the options of `fit`.

use crate::support::*;
use assert_cmd::Command;
use serde_json::Value;
use std::path::Path;

struct Run {
    code: i32,
    stdout: String,
    stderr: String,
}

/// Run `tumble ARGUMENTS` in the repository's folder.
fn tumble(arguments: &[&str]) -> Run {
    let mut command = Command::cargo_bin("tumble").expect("the program");
    let output = command.current_dir(env!("CARGO_MANIFEST_DIR")).args(arguments).output().expect("a run");
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).expect("UTF-8");
    Run { code: output.status.code().expect("no signal"), stdout: text(output.stdout), stderr: text(output.stderr) }
}

const TABLE_1: &str = "data/campaigns/li2012-table1.campaign.json";
const NO_CHAIN: &str = "tests/data/gum/h3.campaign.json";

#[test]
fn exit_codes() {
    for (code, arguments) in [
        (0, &["fit", TABLE_1][..]),
        (0, &["compare", TABLE_1]),
        (0, &["bench", "list"]),
        (0, &["bench", "show", "gyro-turntable"]),
        (0, &["check", TABLE_1, "data/benches/gyro-turntable.bench.json"]),
        (0, &["schema", "bench"]),
        (0, &["--help"]),
        (0, &["fit", "--help"]),
        (0, &["--version"]),
        (1, &[]),
        (1, &["fit"]),
        (1, &["fit", "no-such-file.json"]),
        (1, &["fit", "tests"]),
        (1, &["fit", TABLE_1, "--no-such-option"]),
        (1, &["fit", TABLE_1, "--level", "2"]),
        (1, &["fit", TABLE_1, "--level", "NaN"]),
        (1, &["fit", TABLE_1, "--level", "high"]),
        (1, &["bench", "show", "gyro-turntabel"]),
        (1, &["schema", "poem"]),
        (1, &["compare", NO_CHAIN]),
        (1, &["check", "tests/data/bad/zero-u.campaign.json"]),
        (1, &["calibrate"]),
        (2, &["fit", "tests/data/bad/rank-defect.campaign.json"]),
        (2, &["fit", "tests/data/levelling/niemeier.campaign.json"]),
    ] {
        let run = tumble(arguments);
        assert_eq!(run.code, code, "{arguments:?}\n{}{}", run.stdout, run.stderr);
        assert_eq!(run.stdout.is_empty(), code == 1, "{arguments:?}: results on stdout");
        assert_eq!(run.stderr.is_empty(), code != 1, "{arguments:?}: errors on stderr");
    }
}

/// What a Rust program prints of an answer is what the program prints.
#[test]
fn answers_print_as_the_program_prints_them() {
    let campaign =
        tumble::Campaign::from_path(Path::new(env!("CARGO_MANIFEST_DIR")).join(TABLE_1)).expect("a campaign");
    let fit = tumble::fit(&campaign, &Default::default()).expect("a fit");
    assert_eq!(fit.to_string(), tumble(&["fit", TABLE_1]).stdout.trim_end());
    let report = tumble(&["diagnose", TABLE_1, "--json", "-"]).stdout;
    let report: tumble::report::DiagnoseReport = serde_json::from_str(&report).expect("a report");
    // a program has options that show more rows, and a value has none
    let printed = tumble(&["diagnose", TABLE_1]).stdout.replace(" (all with -v)", "");
    assert_eq!(report.to_string(), printed.trim_end());
    let forms = tumble::compare::closed_forms(&campaign.bench.id).expect("closed forms");
    let comparison = tumble::compare(&campaign, &forms, &Default::default()).expect("a comparison");
    assert_eq!(comparison.to_string(), tumble(&["compare", TABLE_1]).stdout.trim_end());
}

#[test]
fn json_on_stdout_is_the_report_alone() {
    let run = tumble(&["fit", TABLE_1, "--json", "-"]);
    let report: Value = serde_json::from_str(&run.stdout).expect("JSON and nothing else");
    assert_eq!((run.code, &report["report"], &report["tumble"]), (0, &"fit".into(), &env!("CARGO_PKG_VERSION").into()));
    let parameter =
        report["parameters"].as_array().expect("parameters").iter().find(|p| p["id"] == "dtheta_y2").expect("it");
    assert_within(number(&parameter["arcsec"]["value"]), -162.07, 5.1e-3, "dtheta_y2, arcsec");
    assert_within(number(&parameter["value"]), -162.07 * ARCSEC, 5.1e-3 * ARCSEC, "dtheta_y2, rad");
    for key in ["kind", "unit", "u", "dof", "k", "U", "level", "type_a", "type_b", "budget", "state"] {
        assert!(!parameter[key].is_null(), "{key}");
    }
    for key in ["bench", "model", "derived", "assumed_zero", "covariance", "fit", "not_estimable", "readings"] {
        assert!(!report[key].is_null(), "{key}");
    }
    for key in ["readings", "rank", "dof", "residual_sd", "sum_of_squares", "condition"] {
        assert!(!report["fit"][key].is_null(), "{key}");
    }
    for key in
        ["index", "position", "sensor", "value", "fitted", "residual", "leverage", "redundancy", "studentized", "mdb"]
    {
        assert!(!report["readings"][0][key].is_null(), "{key}");
    }
    let run = tumble(&["compare", TABLE_1, "--json", "-"]);
    let report: Value = serde_json::from_str(&run.stdout).expect("JSON and nothing else");
    assert_eq!(report["report"], "compare");
}

/// Coverage factors of Student's t with 24 degrees of freedom (GUM table G.2; the 95.45 % row is interpolated there as 2.11).
#[test]
fn the_level_sets_the_coverage_factor() {
    for (level, k) in [("0.6827", 1.02), ("0.95", 2.06), ("0.9545", 2.11), ("0.99", 2.80)] {
        let run = tumble(&["fit", TABLE_1, "--level", level, "--json", "-"]);
        let report: Value = serde_json::from_str(&run.stdout).expect("JSON");
        let parameter = &report["parameters"][1];
        assert_within(number(&parameter["k"]), k, 0.0051, level);
        assert_within(number(&parameter["U"]), number(&parameter["k"]) * number(&parameter["u"]), 1e-18, level);
        assert_eq!(number(&parameter["level"]), level.parse::<f64>().expect("a level"));
    }
}

#[test]
fn exact_reports_its_iterations_and_readings_are_listed_on_request() {
    let run = tumble(&["fit", TABLE_1]);
    assert!(
        run.stdout.contains("Bench: gyro-turntable") && run.stdout.contains("Gauss-Newton converged"),
        "{}",
        run.stdout
    );
    let plain = tumble(&["fit", TABLE_1]).stdout.lines().count();
    assert!(tumble(&["fit", TABLE_1, "--readings"]).stdout.lines().count() >= plain + 30);
}

#[test]
fn relative_weights_estimate_their_scale() {
    let net = "tests/data/levelling/krumm.campaign.json";
    let stated = tumble(&["fit", net]).stdout;
    assert!(stated.contains("OK: Global test"), "{stated}");
    let relative = tumble(&["fit", net, "--relative"]).stdout;
    assert!(
        !relative.contains("Global test") && relative.contains("Residual standard deviation of dh: 0.944"),
        "{relative}"
    );
}

#[test]
fn a_bench_that_is_shown_can_be_used() {
    let folder = tempfile::tempdir().expect("a folder");
    let bench = folder.path().join("mine.bench.json");
    std::fs::write(&bench, tumble(&["bench", "show", "gyro-turntable"]).stdout).expect("written");
    let campaign = folder.path().join("mine.campaign.json");
    let text = text("li2012/li2012-table1.campaign.json").replace("\"gyro-turntable\"", "\"mine.bench.json\"");
    std::fs::write(&campaign, text).expect("written");
    let own = tumble(&["fit", campaign.to_str().expect("a path")]);
    assert_eq!((own.code, own.stdout), (0, tumble(&["fit", TABLE_1]).stdout));
}

#[test]
fn every_command_helps() {
    let help = tumble(&["--help"]).stdout;
    let commands: Vec<&str> = help
        .lines()
        .skip_while(|line| !line.starts_with("Commands:"))
        .skip(1)
        .take_while(|line| !line.is_empty())
        .filter_map(|line| line.strip_prefix("  ").filter(|rest| !rest.starts_with(' ')))
        .filter_map(|line| line.split_whitespace().next())
        .collect();
    for required in ["fit", "compare", "diagnose", "simulate", "navigate", "plan", "bench", "check", "schema"] {
        assert!(commands.contains(&required), "{required} in {commands:?}");
    }
    for command in commands.iter().filter(|command| **command != "help") {
        let run = tumble(&[command, "--help"]);
        assert!(run.code == 0 && run.stdout.contains("Usage:"), "{command}");
    }
}

#[test]
fn what_is_no_campaign_is_named() {
    let told = |arguments: &[&str]| {
        let run = tumble(arguments);
        assert_eq!(run.code, 1, "{arguments:?}");
        run.stderr
    };
    let readings = told(&["fit", "examples/03-your-own-positions/my-readings.csv"]);
    assert!(readings.contains("expected a campaign file (JSON)") && readings.contains("begins with"), "{readings}");
    let truth = told(&["check", "examples/07-hidden-effect/hidden.truth.json"]);
    assert!(truth.contains("looks like a truth file"), "{truth}");
    assert!(told(&["plan", TABLE_1, "--budget", "-5"]).contains("found -5"));
}

/// A fit of the repaired campaign knows nothing of aliases: whoever asks for the campaign is told.
#[test]
fn aliases_are_told_with_a_written_model() {
    let folder = tempfile::tempdir().expect("a folder");
    let [bench, page] = ["r.bench.json", "r.html"].map(|name| folder.path().join(name).display().to_string());
    let run = tumble(&["diagnose", TABLE_1, "--write-model", &bench, "--html", &page]);
    let told = run.stderr.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(run.code == 2 && told.contains("assumes the effect as named (a_S)") && told.contains("V0 by"), "{told}");
    let page = std::fs::read_to_string(page).expect("the page");
    assert!(page.contains("The u after the repair includes"));
}

/// Long lines hang; every kind of file that has a schema is named where it is asked for.
#[test]
fn lists_fit_a_terminal_and_are_complete() {
    let list = tumble(&["bench", "list"]).stdout;
    assert!(list.lines().all(|line| line.chars().count() <= 110), "{list}");
    let diagnosis = tumble(&["diagnose", TABLE_1]).stdout;
    let told = diagnosis.lines().skip_while(|line| !line.contains("Discriminated by")).take(2);
    assert!(told.clone().count() == 2 && told.clone().all(|line| line.chars().count() <= 110), "{diagnosis}");
    let help = tumble(&["schema", "--help"]).stdout;
    for kind in tumble::report::schemas() {
        assert!(help.contains(kind), "{kind}: {help}");
    }
}

#[test]
fn completions_and_manual_pages_are_printed() {
    for (shell, word) in [("bash", "complete -F"), ("zsh", "#compdef tumble"), ("fish", "complete -c tumble")] {
        let run = tumble(&["completions", shell]);
        assert!(run.code == 0 && run.stdout.contains(word) && run.stdout.contains("diagnose"), "{shell}");
    }
    let page = tumble(&["man"]).stdout;
    assert!(page.contains(".TH tumble 1") && page.contains("diagnose"), "{page}");
    let page = tumble(&["man", "fit"]).stdout;
    assert!(page.contains("robust") && page.contains("Exit codes"), "{page}");
    let run = tumble(&["man", "fti"]);
    assert!(run.code == 1 && run.stderr.contains("fit, compare"), "{}", run.stderr);
}

#[test]
fn every_command_of_work_shows_examples_and_exit_codes() {
    for command in ["fit", "compare", "diagnose", "simulate", "navigate", "plan", "new", "check"] {
        let help = tumble(&[command, "--help"]).stdout;
        assert!(help.contains(&format!("  tumble {command} ")) && help.contains("Exit codes"), "{command}: {help}");
    }
    // a negative number is a value, not an option
    let told = tumble(&["fit", TABLE_1, "--monte-carlo", "-5"]).stderr;
    assert!(!told.contains("-- -5") && told.contains("invalid value '-5'"), "{told}");
    let told = tumble(&["fit", TABLE_1, "--monte-carlo", "99999999999999"]).stderr;
    assert!(told.contains("do not fit into memory"), "{told}");
}

/// Keys of thousands of characters do not bury the message; what is no table of ours is not quoted.
#[test]
fn messages_stay_readable() {
    let folder = tempfile::tempdir().expect("a folder");
    let write = |name: &str, text: &str| {
        let path = folder.path().join(name);
        std::fs::write(&path, text).expect("written");
        path.display().to_string()
    };
    let head = r#""bench": "gyro-turntable", "known": { "kI": { "value": -2.9 } }, "estimate": { "V0": {} }"#;
    let key = "k".repeat(5000);
    let told = tumble(&["fit", &write("key.campaign.json", &format!(r#"{{ {head}, "{key}": 1 }}"#))]).stderr;
    assert!(told.len() < 3000 && told.contains("unknown key") && told.contains("expected"), "{told}");
    write("secrets", "root:$6$abc:19000:0:99999:7:::\ndaemon:*:19000:0:99999:7:::\n");
    for campaign in [
        format!(r#"{{ {head}, "readings": "secrets" }}"#),
        r#"{ "bench": "secrets", "estimate": {}, "readings": [] }"#.to_string(),
    ] {
        let told = tumble(&["fit", &write("leak.campaign.json", &campaign)]);
        assert!(told.code == 1 && !told.stderr.contains("$6$") && !told.stderr.contains("daemon"), "{}", told.stderr);
    }
    let list = r#"{ "bench": "gyro-turntable", "known": { "kI": { "value": -2.9 } }, "estimate": { "V0": [null, 5, 1, "V"] }, "readings": [] }"#;
    let told = tumble(&["check", &write("list.campaign.json", list)]);
    assert!(told.code == 1 && told.stderr.contains("an object"), "{}", told.stderr);
}

/// A column that looks like an input of an axis that is not there, and a coefficient that looks like an input, are asked about.
#[test]
fn names_that_are_nearly_inputs_are_asked_about() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("near.campaign.json");
    let check = |model: &str, reading: &str| {
        let text = format!(
            r#"{{ "bench": {{ "id": "b", "units": {{ "force": "g" }}, "chain": [ {{ "joint": "beta", "about": "x" }} ],
              "sensors": {{ "V": {{ "unit": "V", "axes": {{ "I": "y" }}, "model": "{model}" }} }} }},
              "estimate": {{ "b": {{}} }}, "readings": [ {{ "beta_deg": 0, {reading} "V": 1 }} ] }}"#
        );
        std::fs::write(&path, text).expect("written");
        let mut run = tumble(&["check", path.to_str().expect("a path")]);
        run.stderr = run.stderr.split_whitespace().filter(|word| *word != "│").collect::<Vec<_>>().join(" ");
        run
    };
    assert_eq!(check("b + a_I", "").code, 0);
    assert!(check("b + aI", "").stderr.contains("is the input 'a_I' meant?"));
    let run = check("b + a_I", "\"w_Q\": 1,");
    assert!(run.code == 1 && run.stderr.contains("no axis is called 'Q'"), "{}", run.stderr);
    assert_eq!(check("b*w_Q + a_I", "\"w_Q\": 1,").code, 0);
}

/// `tumble ... | head` closes the pipe early: no panic, no message.
#[test]
fn a_reader_that_goes_away_is_no_error() {
    let mut child = std::process::Command::new(assert_cmd::cargo::cargo_bin!("tumble"))
        .args(["fit", "tests/data/nist/filip.campaign.json", "--readings"])
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .stdout(std::process::Stdio::piped())
        .stderr(std::process::Stdio::piped())
        .spawn()
        .expect("a run");
    drop(child.stdout.take());
    let output = child.wait_with_output().expect("an end");
    assert!(output.status.code().is_some() && output.stderr.is_empty(), "{}", String::from_utf8_lossy(&output.stderr));
}

/// Cells that cannot be read say what is to be done about them.
#[test]
fn cells_say_what_to_do() {
    let folder = tempfile::tempdir().expect("a folder");
    let campaign = folder.path().join("c.campaign.json");
    std::fs::write(
        &campaign,
        r#"{ "bench": "gyro-turntable", "known": { "kI": { "value": -2.9222, "unit": "V/(deg/s)" } }, "estimate": { "V0": {} }, "readings": "r.csv" }"#,
    )
    .expect("a file");
    let told = |table: &str| {
        std::fs::write(folder.path().join("r.csv"), table).expect("a file");
        let run = tumble(&["fit", campaign.to_str().expect("UTF-8")]);
        (run.code, run.stderr.split_whitespace().filter(|word| *word != "│").collect::<Vec<_>>().join(" "), run.stdout)
    };
    let titles = "alpha_deg,beta_deg,gamma_deg_s,V\n0,0,20,-0.06\n";
    for (rows, sentence) in [
        ("0,,20,-0.06\n", "an empty cell for beta_deg: fill it in, or delete the row"),
        ("0,0,20,n/a\n", "leave the cell empty"),
        (
            "0,0,20,\"-0,06\"\n",
            "a number with a decimal point; decimal commas are read in a file whose cells are separated by semicolons",
        ),
    ] {
        let (code, told, _) = told(&format!("{titles}{rows}"));
        assert!(code == 1 && told.contains(sentence), "{told}");
    }
    // decimal commas between commas are further cells
    let (code, words, _) = told("alpha_deg,beta_deg,gamma_deg_s,V\n0,0,20,-0,06\n0,90,20,-0,07\n");
    assert!(code == 1 && words.contains("a line of titles") && words.contains("rows of 5 cells"), "{words}");
    // a reading that was not made is named by its line alone
    let (code, _, answer) = told(&format!("{titles}0,90,20,-0.06\n0,0,40,\n"));
    assert!(code == 0 && answer.contains("r.csv)") && !answer.contains('|'), "{answer}");
}
