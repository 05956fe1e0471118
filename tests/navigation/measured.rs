//! Measured navigation errors as files: bad input is named with its place; what is written is read again; the command's way from a simulated
//! series to a repaired mission.
use crate::navigate::measured::CHANNEL_NAMES;
use assert_cmd::Command;
use std::path::Path;
use tumble::error::{Fault, Malformed};
use tumble::navigate::{Measured, Mission};
use tumble::wire::{self, MissionFile, Source};

const MISSION: &str = r#"{
  "site": { "latitude_deg": 45.0 }, "step_s": 0.1, "duration_h": 2, "output_every_s": 60,
  "motion": { "static": { "heading_deg": 30 } },
  "beside": [ { "static": { "heading_deg": 120 } } ],
  "errors": { "gyro_bias_deg_h": [0.01, 0, 0], "gyro_installation_arcsec": 3 },
  "scenarios": "together"
}
"#;

fn mission() -> Mission {
    let source = Source { name: "m.mission.json".into(), text: MISSION.into() };
    wire::parse::<MissionFile>(&source).unwrap().mission().unwrap()
}

fn read(text: &str) -> Result<Measured, Malformed> {
    wire::read_measured(&Source { name: "errors.csv".into(), text: text.into() }, &mission())
}

#[test]
fn bad_files_are_named_with_line_and_column() {
    let cases: [(&str, Fault, &str, &str, usize); 21] = [
        ("", Fault::Missing, "the table is empty", "", 0),
        ("position_east_m\n1\n", Fault::Missing, "'time_s' is missing", "", 1),
        ("time_s\n1\n", Fault::Missing, "no column holds", "", 1),
        ("time_s,position_east_m\n", Fault::Missing, "nothing was measured", "", 0),
        ("time_s,position_east_m\n0,\n", Fault::Missing, "nothing was measured", "", 0),
        ("time_s,position_east\n0,1\n", Fault::UnknownKey, "unknown column 'position_east'", "position_east", 1),
        ("time_s,phi_east_deg\n0,1\n", Fault::UnknownKey, "unknown column 'phi_east_deg'", "phi_east_deg", 1),
        ("# a remark\ntime_s,x\n0,1\n", Fault::UnknownKey, "unknown column 'x'", "x", 2),
        ("time_s,time_s,position_east_m\n0,0,1\n", Fault::NameClash, "stands twice", "time_s", 1),
        ("time_s,position_east_m_u,phi_up_arcsec\n0,1,1\n", Fault::Missing, "has no values", "", 1),
        (
            "time_s,position_east_m\n0,1\n60,far\n",
            Fault::Value,
            "'position_east_m' is not a number",
            "position_east_m",
            3,
        ),
        ("time_s,position_east_m\n0,nan\n", Fault::Value, "not a number", "position_east_m", 2),
        ("time_s,position_east_m\n0,1\n# a remark\n\n60,far\n", Fault::Value, "not a number", "position_east_m", 5),
        ("time_s,position_east_m\n,1\n", Fault::Value, "'time_s' is not a number", "time_s", 2),
        ("time_s,position_east_m\n-5,1\n", Fault::Value, "outside the mission", "time_s", 2),
        ("time_s,position_east_m\n0,1\n7201,1\n", Fault::Value, "outside the mission", "time_s", 3),
        (
            "time_s,position_east_m,position_east_m_u\n0,1,5\n60,1,0\n",
            Fault::Value,
            "not positive",
            "position_east_m_u",
            3,
        ),
        ("time_s,position_east_m,position_east_m_u\n0,1,\n", Fault::Missing, "has no", "position_east_m_u", 2),
        ("motion,time_s,position_east_m\nswing,0,1\n", Fault::UnknownName, "no motion 'swing'", "motion", 2),
        ("time_s,position_east_m\n0,1\n60,1\n60,2\n", Fault::Value, "measured twice at 60 s", "time_s", 4),
        ("scenario,time_s,position_east_m\na,0,1\nb,0,1\n", Fault::Value, "several scenarios", "scenario", 0),
    ];
    for (text, fault, what, path, line) in cases {
        let error = read(text).expect_err(text);
        println!("{error}");
        assert_eq!(error.fault(), fault, "{text}: {error}");
        assert!(error.what().contains(what), "{text}: {error}");
        assert_eq!((error.place().path.as_str(), error.place().line), (path, line), "{text}: {error}");
        assert_eq!(error.place().file, "errors.csv");
    }
    // a decimal comma is read where a semicolon parts the cells
    assert_eq!(read("time_s;position_east_m\n0;1,5\n").map(|measured| measured.count()).ok(), Some(1));
    let twice = read("time_s,position_east_m\n0,1\n60,1\n# again\n0,2\n").unwrap_err();
    assert_eq!(twice.finding(), Some("lines 2 and 5"));
    // another channel, or another motion, at the same time is no repetition
    assert!(read("time_s,position_east_m,position_north_m\n60,1,\n60,,2\n").is_ok());
    let ragged = read("time_s,position_east_m\n0\n").unwrap_err();
    assert_eq!((ragged.fault(), ragged.place().line), (Fault::Syntax, 2));
}

#[test]
fn what_is_written_is_read() {
    let text = "motion,time_s,phi_up_arcsec,phi_up_arcsec_u,position_east_m\n\
                static 2,0.5,-2.5,1.5,\nstatic,60,1,2,3\nstatic,0,,,4\n";
    let measured = read(text).unwrap();
    assert_eq!(measured.runs.len(), 2);
    assert_eq!(measured.runs[0].rows[0].time, 0.0, "rows by time");
    assert_eq!(measured.count(), 4);
    let written = wire::write_measured(&measured, &mission());
    let again = read(&written).unwrap();
    for (a, b) in measured.cells().zip(again.cells()) {
        assert_eq!((a.run, a.row, a.channel, a.time), (b.run, b.row, b.channel, b.time));
        assert!((a.value - b.value).abs() < 1e-12 && a.u.is_some() == b.u.is_some());
    }
    assert_eq!(written.lines().next().unwrap(), "motion,time_s,phi_up_arcsec,phi_up_arcsec_u,position_east_m");
}

fn tumble(folder: &Path, arguments: &[&str]) -> assert_cmd::assert::Assert {
    Command::cargo_bin("tumble").unwrap().current_dir(folder).args(arguments).assert()
}

/// A simulated series is measured data at once, a mission with the errors found has nothing missing, and the report is under its schema.
#[test]
fn from_a_series_to_a_repaired_mission() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let mut truth: serde_json::Value = serde_json::from_str(MISSION).unwrap();
    truth["errors"]["accelerometer_bias_g"] = serde_json::json!([0, 2e-5, 0]);
    truth["errors"]["gyro_installation_arcsec"] =
        serde_json::json!({ "xy": 3, "xz": 3, "yx": 3, "yz": 3, "zx": 3, "zy": 12 });
    truth["scenarios"] = "groups".into();
    std::fs::write(at("m.mission.json"), MISSION).unwrap();
    std::fs::write(at("truth.mission.json"), truth.to_string()).unwrap();

    tumble(folder.path(), &["navigate", "truth.mission.json", "--csv", "series.csv"]).success();
    let series = std::fs::read_to_string(at("series.csv")).unwrap();
    assert_eq!(series.lines().next().unwrap(), format!("motion,scenario,time_s,{}", CHANNEL_NAMES.join(",")));
    let out = tumble(folder.path(), &["diagnose", "m.mission.json", "--measured", "series.csv"]).code(2);
    let text = String::from_utf8(out.get_output().stdout.clone()).unwrap();
    let words = text.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(words.contains("accelerometer_bias_y") && words.contains("rows of other scenarios left out"), "{text}");
    assert!(words.contains("estimated from the residuals"), "{text}");

    let noise = ["--noise-arcsec", "1", "--noise-m-s", "0.005", "--noise-m", "2"];
    tumble(folder.path(), &[&["navigate", "truth.mission.json", "--measured", "noisy.csv"][..], &noise].concat())
        .success();
    let question = ["diagnose", "m.mission.json", "--measured", "noisy.csv"];
    let files = ["--write-model", "found.mission.json", "--json", "r.json", "--html", "r.html", "--md", "r.md"];
    tumble(folder.path(), &[&question[..], &files].concat()).code(2);
    let report: serde_json::Value = serde_json::from_str(&std::fs::read_to_string(at("r.json")).unwrap()).unwrap();
    let schema = tumble::report::schema("navigate-diagnose-report").unwrap();
    let validator = jsonschema::validator_for(&schema).unwrap();
    let faults: Vec<String> = validator.iter_errors(&report).map(|error| error.to_string()).collect();
    assert!(faults.is_empty(), "{faults:?}");
    assert_eq!(report["verdict"], "effects-found");
    let names: Vec<&str> =
        report["effects"].as_array().unwrap().iter().map(|e| e["regressor"].as_str().unwrap()).collect();
    assert!(names.contains(&"accelerometer_bias_y"), "{names:?}");
    let page = std::fs::read_to_string(at("r.html")).unwrap();
    assert!(page.contains("<svg") && page.contains("Problem") && !page.contains("EFFECTS FOUND"));

    let found: serde_json::Value =
        serde_json::from_str(&std::fs::read_to_string(at("found.mission.json")).unwrap()).unwrap();
    assert!((found["errors"]["accelerometer_bias_g"][1].as_f64().unwrap() / 2e-5 - 1.0).abs() < 0.05);
    assert_eq!(found["errors"]["gyro_bias_deg_h"][0], 0.01, "what was not changed is as it was written");
    tumble(folder.path(), &["check", "found.mission.json"]).success();
    tumble(folder.path(), &["diagnose", "found.mission.json", "--measured", "noisy.csv"]).success();
    // nothing to write where nothing was found
    let again = ["diagnose", "found.mission.json", "--measured", "noisy.csv", "--write-model", "none.mission.json"];
    tumble(folder.path(), &again).success();
    assert!(!at("none.mission.json").exists());
}

#[test]
fn questions_that_cannot_be_asked() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    std::fs::write(at("m.mission.json"), MISSION).unwrap();
    std::fs::write(at("e.csv"), "time_s,position_east_m\n0,0\n60,1\n120,3\n").unwrap();
    let walking = MISSION.replace("\"errors\": {", "\"errors\": { \"angle_random_walk_deg_sqrt_h\": 0.01,");
    std::fs::write(at("walk.mission.json"), walking).unwrap();
    let told = |arguments: &[&str]| {
        let out = tumble(folder.path(), arguments).code(1);
        String::from_utf8(out.get_output().stderr.clone()).unwrap()
    };
    assert!(told(&["diagnose", "m.mission.json"]).contains("--measured"));
    assert!(told(&["diagnose", "m.mission.json", "--measured", "no.csv"]).contains("no.csv"));
    assert!(
        told(&["diagnose", "m.mission.json", "--measured", "e.csv", "--significance", "2"]).contains("probability")
    );
    assert!(told(&["diagnose", "walk.mission.json", "--measured", "e.csv"]).contains("random walks"));
    assert!(told(&["navigate", "m.mission.json", "--measured", "x.csv"]).contains("--noise-arcsec"));
    assert!(
        told(&["navigate", "m.mission.json", "--measured", "x.csv", "--noise-m", "-1"])
            .contains("not a standard uncertainty")
    );
    assert!(!at("x.csv").exists());
}

/// The measurements of example 19 are those that its command makes, and hold what its truth hides.
#[test]
fn example_31_is_reproduced() {
    let folder = tempfile::tempdir().unwrap();
    let example = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/19-navigation-errors");
    let written = folder.path().join("both.csv");
    let noise = ["--noise-arcsec", "2", "--noise-m-s", "0.01", "--noise-m", "5"];
    let command = ["navigate", "truth.mission.json", "--measured", written.to_str().unwrap()];
    tumble(&example, &[&command[..], &noise].concat()).success();
    let text = |path: &Path| std::fs::read_to_string(path).unwrap();
    let file: MissionFile =
        wire::parse(&Source { name: "m".into(), text: text(&example.join("truth.mission.json")) }).unwrap();
    let read = |text: String| {
        wire::read_measured(&Source { name: "both.csv".into(), text }, &file.mission().unwrap()).unwrap()
    };
    let committed = text(&example.join("both.csv"));
    let at_rest: Vec<&str> = committed.lines().filter(|line| !line.starts_with("swing")).collect();
    assert_eq!(at_rest, text(&example.join("static.csv")).lines().collect::<Vec<&str>>());
    let (made, committed) = (read(text(&written)), read(committed));
    assert_eq!(made.count(), committed.count());
    for (a, b) in made.cells().zip(committed.cells()) {
        // numbers are written to a hundredth of u, and the last digit of another machine may round the other way
        assert!((a.value - b.value).abs() <= 0.011 * a.u.unwrap(), "{} s: {} {}", a.time, a.value, b.value);
    }
}
