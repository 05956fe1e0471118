//! Mission files: bad input is named with its place, outputs are whole or absent, CSV and Parquet hold the same.
use crate::navigate::propagation;
use crate::wire::{self, MissionFile, Source};
use assert_cmd::Command;
use std::fs;
use std::path::Path;
use tumble::error::Malformed;

fn base() -> serde_json::Value {
    serde_json::json!({
        "site": { "latitude_deg": 45.0 }, "step_s": 0.02, "duration_h": 0.1, "output_every_s": 60,
        "motion": { "static": {} }, "errors": { "gyro_bias_deg_h": 0.01 }
    })
}

fn read(value: &serde_json::Value) -> Result<(), Malformed> {
    let source = Source { name: "m.mission.json".into(), text: serde_json::to_string_pretty(value).unwrap() };
    let file: MissionFile = wire::parse(&source)?;
    file.mission().map_err(|error| wire::locate(error, &source)).map(|_| ())
}

#[test]
fn bad_missions_are_named_with_their_place() {
    assert!(read(&base()).is_ok());
    let swing = |period: f64, amplitude: f64| serde_json::json!({ "swing": { "pitch": { "amplitude_deg": amplitude, "period_s": period } } });
    let legs = |legs: serde_json::Value| serde_json::json!({ "legs": { "heading_deg": 90, "legs": legs } });
    let cases: Vec<(&str, serde_json::Value, &str, &str)> = vec![
        ("/site/latitude_deg", 90.into(), "pole", "site.latitude_deg"),
        ("/site/latitude_deg", (-89.5).into(), "pole", "site.latitude_deg"),
        ("/step_s", (-0.01).into(), "step", "step_s"),
        ("/step_s", 0.into(), "step", "step_s"),
        ("/duration_h", 0.into(), "duration", "duration_h"),
        ("/duration_h", 1e300.into(), "too many steps", "duration_h"),
        ("/output_every_s", (-1).into(), "rows", "output_every_s"),
        ("/motion", swing(0.0, 5.0), "swing in pitch", "motion.swing.pitch.period_s"),
        ("/motion", swing(0.5, 80.0), "too long for so fast", "motion"),
        ("/motion", swing(6.0, 95.0), "swing in pitch", "motion.swing.pitch.amplitude_deg"),
        (
            "/motion",
            serde_json::json!({ "swing": { "roll": { "amplitude_deg": 5 } } }),
            "no period",
            "motion.swing.roll",
        ),
        (
            "/motion",
            legs(serde_json::json!([{ "duration_h": 1 }, {}])),
            "leave no time",
            "motion.legs.legs[0].duration_s",
        ),
        (
            "/motion",
            legs(serde_json::json!([{ "duration_s": 360 }, {}])),
            "leave no time",
            "motion.legs.legs[1].duration_s",
        ),
        (
            "/motion",
            legs(serde_json::json!([{}, { "duration_s": 10 }])),
            "others after it",
            "motion.legs.legs[0].duration_s",
        ),
        ("/motion", legs(serde_json::json!([{ "duration_s": 10 }])), "end before the mission", "motion.legs.legs"),
        ("/motion", legs(serde_json::json!([])), "end before the mission", "motion.legs.legs"),
        (
            "/motion",
            legs(serde_json::json!([{ "duration_s": 10.013 }, {}])),
            "within a step",
            "motion.legs.legs[0].duration_s",
        ),
        (
            "/motion",
            legs(serde_json::json!([{ "acceleration_m_s2": 1000 }])),
            "impossible speed",
            "motion.legs.legs[0].acceleration_m_s2",
        ),
        ("/motion", serde_json::json!({ "walk": {} }), "unknown variant", "motion"),
        ("/errors/gyro_bais_deg_h", 1.into(), "unknown key", "errors"),
        ("/errors/gyro_scale_factor", serde_json::json!([1, 2]), "length", "errors.gyro_scale_factor"),
        ("/errors/gyro_scale_factor", 5.into(), "not an error", "errors.gyro_scale_factor"),
        (
            "/errors/gyro_installation_arcsec",
            serde_json::json!({ "xx": 1 }),
            "unknown key",
            "errors.gyro_installation_arcsec",
        ),
        ("/errors/angle_random_walk_deg_sqrt_h", (-1).into(), "random walk", "errors.angle_random_walk_deg_sqrt_h"),
        ("/beside", serde_json::json!([swing(0.0, 5.0)]), "swing in pitch", "beside[0].swing.pitch.period_s"),
    ];
    for (pointer, value, what, path) in cases {
        let mut mission = base();
        let (parent, key) = pointer.rsplit_once('/').unwrap();
        mission.pointer_mut(parent).unwrap()[key] = value.clone();
        let error = read(&mission).expect_err(pointer);
        println!("{error}");
        assert!(error.to_string().contains(what), "{pointer} {value}: {error}");
        assert!(error.place().path.starts_with(path), "{pointer} {value}: {} is not {path}", error.place().path);
        assert!(error.place().line > 0, "{pointer} {value}: no line");
    }
}

#[test]
fn reports_that_cannot_be_carried() {
    let source = |text: &str| Source { name: "fit.json".into(), text: text.into() };
    let none = wire::read_covariance(&source(r#"{ "report": "fit", "parameters": [] }"#)).unwrap_err();
    assert!(none.to_string().contains("no covariance"), "{none}");
    assert!(wire::read_covariance(&source("not json")).is_err());
    let order = vec!["a".to_string(), "b".to_string()];
    let matrix = vec![vec![Some(1.0), None], vec![None, None]];
    let carry = |source: &str, parameter: &str| {
        let factors = [(source.to_string(), vec![(parameter.to_string(), 1.0)])];
        propagation::combine(&order, &matrix, &factors).map(|_| ()).map_err(|e| e.to_string())
    };
    assert_eq!(carry("gyro_bias_x", "a"), Ok(()));
    assert!(carry("gyro_bais_x", "a").unwrap_err().contains("no error source is called 'gyro_bais_x'"));
    assert!(carry("gyro_bias_x", "c").unwrap_err().contains("no parameter 'c'"));
    assert!(carry("gyro_bias_x", "b").unwrap_err().contains("not estimable"));
    let ragged = propagation::combine(&order, &matrix[..1], &[]).unwrap_err();
    assert!(ragged.to_string().contains("not a square"));
}

fn navigate(folder: &Path, arguments: &[&str]) -> Command {
    fs::write(folder.join("m.mission.json"), serde_json::to_string(&base()).unwrap()).unwrap();
    let mut command = Command::cargo_bin("tumble").unwrap();
    command.current_dir(folder).args(["navigate", "m.mission.json"]).args(arguments);
    command
}

#[test]
fn outputs_are_whole_and_agree() {
    let folder = tempfile::tempdir().unwrap();
    let files = ["--json", "r.json", "--html", "r.html", "--csv", "r.csv", "--parquet", "r.parquet"];
    navigate(folder.path(), &files).assert().success();
    let left: Vec<String> =
        fs::read_dir(folder.path()).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
    assert_eq!(left.len(), 5, "{left:?}");
    let report: serde_json::Value =
        serde_json::from_str(&fs::read_to_string(folder.path().join("r.json")).unwrap()).unwrap();
    let schema = tumble::report::schema("navigate-report").unwrap();
    assert!(jsonschema::is_valid(&schema, &report));
    assert_eq!(report["results"].as_array().unwrap().len(), 3);
    assert!(fs::read_to_string(folder.path().join("r.html")).unwrap().contains("<svg"));

    let mut csv = csv::Reader::from_path(folder.path().join("r.csv")).unwrap();
    let rows: Vec<csv::StringRecord> = csv.records().map(Result::unwrap).collect();
    assert_eq!(rows.len(), 21); // 7 rows of 2 scenarios and of the perfect unit
    use parquet::file::reader::{FileReader, SerializedFileReader};
    let file = fs::File::open(folder.path().join("r.parquet")).unwrap();
    let reader = SerializedFileReader::new(file).unwrap();
    let mut count = 0;
    for (row, text) in reader.get_row_iter(None).unwrap().zip(&rows) {
        for ((_, field), text) in row.unwrap().get_column_iter().zip(text) {
            match field {
                parquet::record::Field::Str(name) => assert_eq!(name, text),
                parquet::record::Field::Double(value) => {
                    assert!((value - text.parse::<f64>().unwrap()).abs() <= 1e-8 * value.abs())
                }
                other => panic!("{other:?}"),
            }
        }
        count += 1;
    }
    assert_eq!(count, 21);
}

#[test]
fn a_folder_that_cannot_be_written_is_an_error() {
    let folder = tempfile::tempdir().unwrap();
    let out = navigate(folder.path(), &["--csv", "nowhere/r.csv"]).assert().code(1);
    assert!(String::from_utf8_lossy(&out.get_output().stderr).contains("cannot write"));
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
}

#[test]
fn the_mission_schema_accepts_the_examples() {
    let schema = tumble::report::schema("mission").unwrap();
    for entry in fs::read_dir("examples/09-navigator").unwrap() {
        let path = entry.unwrap().path();
        if path.to_string_lossy().ends_with(".mission.json") {
            let text = fs::read_to_string(&path).unwrap();
            let value: serde_json::Value = serde_json::from_str(&text).unwrap();
            assert!(jsonschema::is_valid(&schema, &value), "{}", path.display());
            Command::cargo_bin("tumble").unwrap().arg("check").arg(&path).assert().success();
        }
    }
}
