//! Exported source, compiled and run: C in double and float, Python, and Octave where it is installed; all agree with the program.

use crate::programs::run;
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
    assert!(ros.contains("Quadratic and higher terms are left out: a_x"), "{ros}");
    assert!(serde_json::from_str::<tumble::wire::CorrectionFile>(&text("json")).is_ok());
    // what kalibr reads, from a record's noise: N of white noise of sd 1 at 100 Hz is 0.1
    assert!(
        kalibr.contains("rostopic: /imu0") && kalibr.contains("# update_rate, accelerometer_noise_density"),
        "{kalibr}"
    );
    assert!(kalibr.contains("for reference"));
    let mut state = 1_u64;
    let mut white = || {
        // twelve uniform numbers: variance 1
        (0..12)
            .map(|_| {
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
            })
            .sum::<f64>()
    };
    let rows: String = (0..20_000).map(|k| format!("{},{},{}\n", f64::from(k) * 0.01, white(), white())).collect();
    std::fs::write(folder.path().join("still.csv"), format!("time_s,gx (rad/s),ax (m/s^2)\n{rows}")).unwrap();
    let at = |name: &str| folder.path().join(name).to_str().unwrap().to_string();
    let noise = tumble(&["noise", &at("still.csv"), "--json", &at("noise.json")]);
    assert!(noise.status.success(), "{}", String::from_utf8_lossy(&noise.stderr));
    let output = tumble(&["export", imu.to_str().unwrap(), "--to", "kalibr", "--noise", &at("noise.json")]);
    let kalibr = String::from_utf8(output.stdout).unwrap();
    let value = |key: &str| -> f64 {
        let line = kalibr.lines().find(|line| line.starts_with(key)).unwrap_or_else(|| panic!("{key} in {kalibr}"));
        line.split([':', '#']).nth(1).unwrap().trim().parse().unwrap()
    };
    for key in ["accelerometer_noise_density", "gyroscope_noise_density"] {
        // 20,000 samples give N within some percent
        assert!((value(key) - 0.1).abs() < 0.01, "{key}: {}", value(key));
    }
    assert!((value("update_rate") - 100.0).abs() < 1e-6);
    // one gyro is no triad
    let gyro = calibration(folder.path(), "01-gyro-table/table1.campaign.json");
    let refused = tumble(&["export", gyro.to_str().unwrap(), "--to", "kalibr"]);
    assert_eq!(refused.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&refused.stderr).contains("three gyros or three accelerometers"));
}

/// Sensors declared as z, y, x: both files go by axis. The readings of `exact` are bias + slope*a, with slopes 1, 2, 4 for x, y, z.
#[test]
fn files_of_others_go_by_axis() {
    let campaign = r#"{"bench": {"id": "zyx", "units": {"force": "m/s^2"}, "chain": [{"joint": "t", "about": "x"}], "sensors": {
        "az": {"model": "bz + 4*a_z + 0.25*a_x"}, "ay": {"model": "20 + 2*a_y"}, "ax": {"model": "10 + a_x"}}},
        "estimate": {"bz": {}}, "readings": [{"t_deg": 90, "az": 30}]}"#;
    let folder = tempfile::tempdir().unwrap();
    let (path, fit) = (folder.path().join("zyx.campaign.json"), folder.path().join("zyx.fit.json"));
    std::fs::write(&path, campaign).unwrap();
    assert_ne!(tumble(&["fit", path.to_str().unwrap(), "--json", fit.to_str().unwrap()]).status.code(), Some(1));
    let text = |to: &str| String::from_utf8(tumble(&["export", fit.to_str().unwrap(), "--to", to]).stdout).unwrap();
    let numbers = |line: &str| -> Vec<f64> {
        let inner = line.split(['[', ']']).nth(1).unwrap();
        inner.split(',').map(|number| number.trim().parse().unwrap()).collect()
    };
    let ros = text("ros");
    let line = |text: &str, key: &str| numbers(text.lines().find(|line| line.trim_start().starts_with(key)).unwrap());
    // the inverse of [[1, 0, 0], [0, 2, 0], [0.25, 0, 4]]
    let close = |found: &[f64], expected: &[f64]| {
        assert_eq!(found.len(), expected.len());
        found.iter().zip(expected).for_each(|(a, b)| assert!((a - b).abs() < 1e-12, "{found:?} for {expected:?}"));
    };
    close(&line(&ros, "SM"), &[1.0, 0.0, 0.0, 0.0, 0.5, 0.0, -0.0625, 0.0, 0.25]);
    close(&line(&ros, "bias"), &[10.0, 10.0, (30.0 - 2.5) / 4.0]);
    assert!(ros.contains("# x, y, z: ax, ay, az"), "{ros}");
    let kalibr = text("kalibr");
    let rows: Vec<f64> = kalibr.lines().filter(|line| line.starts_with("  - [")).flat_map(numbers).collect();
    close(&rows, &[1.0, 0.0, 0.0, 0.0, 2.0, 0.0, 0.25, 0.0, 4.0]);
    close(&line(&kalibr, "bias"), &[10.0, 20.0, 30.0]);
}

/// kalibr's A is `d reading / d specific force` in reading per m/s^2, whether the unit's own accelerometers are in the calibration (then forces are solved for) or not
/// (then they are given): `readings = M w + A a + b` with C_gyro_i = 1 (kalibr, IccSensors.py: `w = M C_gyro_b w_b + A C_gyro_b a_b`).
#[test]
fn sensitivity_of_the_gyros_to_acceleration_goes_to_kalibr() {
    let accelerometers = r#", "ax": {"model": "0.1 + 2*a_x"}, "ay": {"model": "a_y"}, "az": {"model": "a_z"}"#;
    for more in ["", accelerometers] {
        let campaign = format!(
            r#"{{"bench": {{"id": "g", "units": {{"rate": "deg/s", "force": "g"}}, "chain": [{{"joint": "t", "about": "z"}}], "sensors": {{
            "gx": {{"model": "b + 3*w_x + 0.5*a_y - 0.25*a_x*a_z"}}, "gy": {{"model": "2*w_y - 0.125*a_x + 0.0625*a_z"}},
            "gz": {{"axes": {{"I": "z"}}, "model": "w_I + 0.75*a_I"}} {more} }}}},
            "estimate": {{"b": {{}}}}, "readings": [{{"t_deg": 0, "gx": 0.5}}]}}"#
        );
        let folder = tempfile::tempdir().unwrap();
        let (path, fit) = (folder.path().join("g.campaign.json"), folder.path().join("g.fit.json"));
        std::fs::write(&path, campaign).unwrap();
        assert_ne!(tumble(&["fit", path.to_str().unwrap(), "--json", fit.to_str().unwrap()]).status.code(), Some(1));
        let output = tumble(&["export", fit.to_str().unwrap(), "--to", "kalibr"]);
        let text = String::from_utf8(output.stdout).unwrap();
        let matrix = |name: &str| -> Vec<f64> {
            let gyros = text.split("gyroscopes:").nth(1).unwrap();
            let rows = gyros.split(&format!("  {name}:\n")).nth(1).unwrap().lines().take(3);
            let cells = rows.flat_map(|row| row.split(['[', ']']).nth(1).unwrap().split(',').map(str::trim));
            cells.map(|cell| cell.parse().unwrap()).collect()
        };
        let (g, degree) = (9.80665, std::f64::consts::PI / 180.0);
        // at zero force the product of two forces has no slope
        let expected = [0.0, 0.5, 0.0, -0.125, 0.0, 0.0625, 0.0, 0.0, 0.75].map(|slope| slope / g);
        let rates = [3.0, 0.0, 0.0, 0.0, 2.0, 0.0, 0.0, 0.0, 1.0].map(|slope| slope / degree);
        for (found, expected) in [(matrix("A"), expected), (matrix("M"), rates)] {
            assert_eq!(found.len(), 9, "{text}");
            let close = |(a, b): (&f64, &f64)| (a - b).abs() <= 1e-12 * b.abs();
            assert!(found.iter().zip(&expected).all(close), "{found:?} for {expected:?}: {text}");
        }
    }
}

/// A temperature that the record lacks: the value that is taken is said, and that u takes it as exact.
#[test]
fn u_without_the_temperature_is_said() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).to_str().unwrap().to_string();
    std::fs::write(
        at("t.campaign.json"),
        r#"{"bench": {"id": "t", "chain": [{"joint": "t", "about": "x"}], "sensors": {"V": {"axes": {"I": "z"}, "model": "b + a_I + c*temperature_c"}}},
            "known": {"c": {"value": 0.5, "u": 0.1}}, "estimate": {"b": {}},
            "readings": [{"t_deg": 0, "temperature_c": 20, "V": 11, "V_u": 0.1}, {"t_deg": 0, "temperature_c": 30, "V": 16, "V_u": 0.1}]}"#,
    )
    .unwrap();
    tumble(&["fit", &at("t.campaign.json"), "--json", &at("t.fit.json")]);
    std::fs::write(at("log.csv"), "V\n13.5\n").unwrap();
    let said = |more: &[&str]| {
        let (fit, log) = (at("t.fit.json"), at("log.csv"));
        let output = tumble(&[&["apply", fit.as_str(), log.as_str()], more].concat());
        assert!(output.status.success());
        String::from_utf8(output.stderr).unwrap().split_whitespace().collect::<Vec<_>>().join(" ")
    };
    let plain = "temperature_c is not in the record: 25 was taken";
    assert!(said(&[]).contains(plain) && !said(&[]).contains("exact"));
    assert!(said(&["--u"]).contains(&format!("{plain}; the uncertainties take it as exact")), "{}", said(&["--u"]));
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
    assert!(code == Some(1) && error.contains("'V' is not a number") && error.contains("line 3"), "{error}");
    let (code, out, error) = answer("time_s,V\n0,\n1,-2.9\n", &["--u"]);
    assert!(code == Some(2) && error.contains("1 of 2 rows"), "{error}");
    assert!(out.starts_with("time_s,w_I,w_I_u\n0,,\n1,"), "{out}");
    let (code, _, error) = answer("time_s,V\n0,1\n", &["--frame", "mount"]);
    assert!(code == Some(1) && error.contains("only w_I"), "{error}");
    let campaign = tumble(&["apply", "examples/01-gyro-table/table1.campaign.json", log.to_str().unwrap()]);
    assert!(String::from_utf8_lossy(&campaign.stderr).contains("this is not a calibration"));
    // a target that cannot be written leaves nothing behind
    let (code, _, _) = answer("time_s,V\n0,1\n", &["--out", "/nowhere/at/all.csv"]);
    assert_eq!(code, Some(1));
}
