//! Exported source, compiled and run: C in double and float, Python, and Octave where it is installed; all agree with the program.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::Command;

fn tumble(arguments: &[&str]) -> std::process::Output {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    Command::new(env!("CARGO_BIN_EXE_tumble")).args(arguments).current_dir(root).output().unwrap()
}

/// The fit of an example, as a file in a folder of its own.
fn calibration(folder: &Path, example: &str) -> PathBuf {
    let path = folder.join("calibration.json");
    let output = tumble(&["fit", &format!("examples/{example}"), "--json", path.to_str().unwrap()]);
    assert!(output.status.code().is_some_and(|code| code != 1), "{}", String::from_utf8_lossy(&output.stderr));
    path
}

fn export(calibration: &Path, to: &str, out: &Path) {
    let output = tumble(&["export", calibration.to_str().unwrap(), "--to", to, "--out", out.to_str().unwrap()]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

/// What a command prints, or nothing where it is not installed; that is said past the harness, which keeps what a test prints to itself.
fn run(program: &str, arguments: &[&str], folder: &Path) -> Option<String> {
    let output = match Command::new(program).args(arguments).current_dir(folder).output() {
        Ok(output) => output,
        Err(_) => {
            writeln!(std::io::stderr(), "left out: {program} is not installed; what it would run was written, not run")
                .unwrap();
            return None;
        }
    };
    assert!(output.status.success(), "{program}: {}", String::from_utf8_lossy(&output.stderr));
    Some(String::from_utf8(output.stdout).unwrap())
}

/// The inputs of the self-test samples as the program computes them, twelve digits.
fn expected(python: &Path, calibration: &Path, folder: &Path) -> Vec<Vec<f64>> {
    // the samples stand in the exported file as literals
    let text = std::fs::read_to_string(python).unwrap();
    let list = |name: &str| -> Vec<Vec<f64>> {
        let start = text.find(&format!("{name} = ")).unwrap() + name.len() + 3;
        let end = text[start..].find("]]").unwrap() + start + 2;
        serde_json::from_str(&text[start..end]).unwrap()
    };
    let (readings, given) =
        (list("TEST_READINGS"), if text.contains("TEST_GIVEN = [[]") { Vec::new() } else { list("TEST_GIVEN") });
    let report: serde_json::Value = serde_json::from_str(&std::fs::read_to_string(calibration).unwrap()).unwrap();
    let names = |key: &str, keep: &dyn Fn(&serde_json::Value) -> bool| -> Vec<String> {
        let all = report["correction"][key].as_array().unwrap();
        all.iter().filter(|v| keep(v)).map(|v| v["id"].as_str().unwrap().to_string()).collect()
    };
    let mut header = names("sensors", &|_| true);
    header.extend(names("inputs", &|v| v["solved"] == false));
    let mut csv = header.join(",") + "\n";
    for (k, row) in readings.iter().enumerate() {
        let cells: Vec<String> = row.iter().chain(given.get(k).into_iter().flatten()).map(|v| v.to_string()).collect();
        csv.push_str(&(cells.join(",") + "\n"));
    }
    let log = folder.join("log.csv");
    std::fs::write(&log, csv).unwrap();
    let output = tumble(&["apply", calibration.to_str().unwrap(), log.to_str().unwrap()]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let text = String::from_utf8(output.stdout).unwrap();
    let solved = names("inputs", &|v| v["solved"] == true).len();
    text.lines()
        .skip(1)
        .map(|line| {
            let cells: Vec<f64> = line.split(',').map(|c| c.parse().unwrap()).collect();
            cells[cells.len() - solved..].to_vec()
        })
        .collect()
}

fn numbers(text: &str) -> Vec<Vec<f64>> {
    text.lines().map(|line| line.split_whitespace().map(|w| w.parse().unwrap()).collect()).collect()
}

/// Every number of a printed text is the program's own, rounded to the twelve digits printed: the same in the last one.
fn assert_printed_alike(text: &str, expected: &[Vec<f64>], what: &str) {
    let printed = numbers(text);
    assert_eq!(printed.len(), expected.len(), "{what}");
    for (printed, expected) in printed.iter().flatten().zip(expected.iter().flatten()) {
        assert_eq!(format!("{printed:.11e}"), format!("{expected:.11e}"), "{what}");
    }
}

/// The same numbers within a share of their size.
fn assert_same(found: &[Vec<f64>], expected: &[Vec<f64>], relative: f64, what: &str) {
    assert_eq!(found.len(), expected.len(), "{what}");
    for (found, expected) in found.iter().flatten().zip(expected.iter().flatten()) {
        let size = expected.abs().max(1e-6);
        assert!((found - expected).abs() <= relative * size, "{what}: {found} for {expected}");
    }
}

#[test]
fn exports_agree_with_the_program() {
    for example in [
        "01-gyro-table/table1.campaign.json",
        "02-accelerometer/table2.campaign.json",
        "10-imu-three-axis-table/perfect-table.campaign.json",
        "11-gyro-skew-triad/direct.campaign.json",
    ] {
        let folder = tempfile::tempdir().unwrap();
        let folder = folder.path();
        let calibration = calibration(folder, example);
        let (c, python, matlab) = (folder.join("unit.c"), folder.join("unit.py"), folder.join("tumble_correct.m"));
        export(&calibration, "c", &c);
        export(&calibration, "python", &python);
        export(&calibration, "matlab", &matlab);
        let expected = expected(&python, &calibration, folder);
        let flags = ["-std=c99", "-Wall", "-Wextra", "-Werror", "-O2", "-ffp-contract=off", "-DTUMBLE_SELF_TEST"];
        let mut double = None;
        for compiler in ["gcc", "clang"] {
            let with = |more: &[&str]| run(compiler, &[&flags[..], more, &["-lm"]].concat(), folder);
            if with(&["unit.c", "-o", "double"]).is_none() {
                continue;
            }
            let text = run(folder.join("double").to_str().unwrap(), &[], folder).unwrap();
            assert_printed_alike(&text, &expected, &format!("{example}, {compiler}"));
            with(&["-DTUMBLE_FLOAT", "unit.c", "-o", "float"]);
            let float = run(folder.join("float").to_str().unwrap(), &[], folder).unwrap();
            // seven digits, less what a bias of many times the signal costs
            assert_same(&numbers(&float), &expected, 1e-2, &format!("{example}, {compiler}, float"));
            double = Some(text);
        }
        if let Some(text) = run("python3", &["unit.py"], folder) {
            assert_printed_alike(&text, &expected, example);
            if let Some(double) = &double {
                assert_eq!(&text, double, "{example}: C and Python to the last digit printed");
            }
        }
        if let Some(text) = run("octave-cli", &["--quiet", "--eval", "tumble_correct('self-test');"], folder) {
            assert_same(&numbers(&text), &expected, 1e-11, example);
        }
    }
}

#[test]
fn other_programs_get_their_files() {
    let folder = tempfile::tempdir().unwrap();
    let imu = calibration(folder.path(), "10-imu-three-axis-table/perfect-table.campaign.json");
    let text = |to: &str| String::from_utf8(tumble(&["export", imu.to_str().unwrap(), "--to", to]).stdout).unwrap();
    let kalibr = text("kalibr");
    assert!(
        kalibr.contains("model: scale-misalignment")
            && kalibr.contains("gyroscopes:")
            && kalibr.contains("accelerometers:")
    );
    let ros = text("ros");
    assert!(ros.contains("SM: [") && ros.contains("bias: ["));
    assert!(serde_json::from_str::<tumble::wire::CorrectionFile>(&text("json")).is_ok());
    // one gyro is no triad
    let gyro = calibration(folder.path(), "01-gyro-table/table1.campaign.json");
    let refused = tumble(&["export", gyro.to_str().unwrap(), "--to", "kalibr"]);
    assert_eq!(refused.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&refused.stderr).contains("three gyros or three accelerometers"));
}

#[test]
fn bad_records_are_answered_with_their_place() {
    let folder = tempfile::tempdir().unwrap();
    let imu = calibration(folder.path(), "01-gyro-table/table1.campaign.json");
    let log = folder.path().join("log.csv");
    let answer = |text: &str, more: &[&str]| {
        std::fs::write(&log, text).unwrap();
        let mut arguments = vec!["apply", imu.to_str().unwrap(), log.to_str().unwrap()];
        arguments.extend(more);
        let output = tumble(&arguments);
        (output.status.code(), String::from_utf8(output.stdout).unwrap(), String::from_utf8(output.stderr).unwrap())
    };
    let (code, _, error) = answer("time_s,U\n0,1\n", &[]);
    assert!(code == Some(1) && error.contains("no column 'V'") && error.contains("'time_s', 'U'"), "{error}");
    let (code, _, error) = answer("time_s,V\n0,1\n1,x\n", &[]);
    assert!(code == Some(1) && error.contains("'x' is no number") && error.contains("line 3"), "{error}");
    let (code, out, error) = answer("time_s,V\n0,\n1,-2.9\n", &["--u"]);
    assert!(code == Some(2) && error.contains("1 of 2 rows"), "{error}");
    assert!(out.starts_with("time_s,w_I,w_I_u\n0,,\n1,"), "{out}");
    let (code, _, error) = answer("time_s,V\n0,1\n", &["--frame", "mount"]);
    assert!(code == Some(1) && error.contains("only w_I"), "{error}");
    let campaign = tumble(&["apply", "examples/01-gyro-table/table1.campaign.json", log.to_str().unwrap()]);
    assert!(String::from_utf8_lossy(&campaign.stderr).contains("this is no calibration"));
    // a target that cannot be written leaves nothing behind
    let (code, _, _) = answer("time_s,V\n0,1\n", &["--out", "/nowhere/at/all.csv"]);
    assert_eq!(code, Some(1));
}
