//! Records in the formats of laboratories, each written by the library of its own community (tests/scripts/record_formats.py, robot_logs.py).

use crate::support::*;
use assert_cmd::Command;
use std::path::{Path, PathBuf};
use tumble::record::{As, Block, Record};

fn file(name: &str) -> PathBuf {
    data("records").join(name)
}

/// All numeric columns of a record by their titles; texts are left out.
fn columns(path: &Path) -> Result<Vec<(String, Vec<f64>)>, String> {
    let mut record = Record::at(path).map_err(|error| error.to_string())?;
    let titles: Vec<String> = record.columns().iter().map(|c| c.title.clone()).collect();
    record.select(&(0..titles.len()).map(|k| (k, As::Cell)).collect::<Vec<_>>());
    let mut all: Vec<(String, Vec<f64>)> = titles.into_iter().map(|title| (title, Vec::new())).collect();
    let mut block = Block::default();
    while record.next(&mut block).map_err(|error| error.to_string())? {
        all.iter_mut().zip(&block.columns).for_each(|((_, own), part)| own.extend_from_slice(part));
    }
    all.retain(|(_, values)| !values.iter().all(|v| v.is_nan()));
    Ok(all)
}

/// What was written is read, to the last digit.
#[test]
fn numbers_are_those_that_were_written() {
    let (formats, robots) = (json("records/expected.json"), json("records/robots.json"));
    let (formats, robots) = (formats.as_object().expect("files"), robots.as_object().expect("files"));
    assert_eq!((formats.len(), robots.len()), (15, 3));
    for (name, wanted) in formats.iter().chain(robots) {
        let found = columns(&file(name)).unwrap_or_else(|error| panic!("{name}: {error}"));
        let wanted = wanted.as_object().expect("columns");
        assert_eq!(found.len(), wanted.len(), "{name}: {:?}", found.iter().map(|(t, _)| t).collect::<Vec<_>>());
        for (title, values) in &found {
            let values_wanted = numbers(wanted.get(title).unwrap_or_else(|| panic!("{name}: '{title}'")));
            assert_eq!(*values, values_wanted, "{name} {title}");
        }
    }
}

/// Units come along: those of the messages, and of a dataset's attribute.
#[test]
fn units_of_the_file() {
    let unit = |name: &str, title: &str| {
        let record = Record::at(&file(name)).expect(name);
        record.columns().iter().find(|c| c.title == title).expect(title).unit.clone()
    };
    assert_eq!(unit("ros2.mcap", "w_x").as_deref(), Some("rad/s"));
    assert_eq!(unit("ros1.mcap", "a_z").as_deref(), Some("m/s^2"));
    assert_eq!(unit("ros1.bag", "a_z").as_deref(), Some("m/s^2"));
    assert_eq!(unit("px4.ulg", "timestamp").as_deref(), Some("us"));
    assert_eq!(unit("log.h5", "gyro_2").as_deref(), Some("rad/s"));
    assert_eq!(unit("log.xlsx", "Ausgang (mV)").as_deref(), Some("mV"));
}

/// Where a file has several tables, or none, the error says which.
#[test]
fn tables_are_named() {
    for (name, words) in [
        ("two-sheets.xlsx", &["more than one sheet", "two-sheets.xlsx#run 1", "'run 2'"][..]),
        ("two-sheets.xlsx#run 3", &["no sheet 'run 3'", "'run 1', 'run 2'"]),
        ("several.mat", &["more than one", "several.mat#run1", "'run2' (40 rows: t, V)"]),
        ("two-topics.mcap", &["more than one topic", "two-topics.mcap#imu/left", "'/imu/right' (40 rows: time_s, w_x"]),
        ("two-topics.mcap#/imu", &["no topic '/imu'", "'/imu/left'"]),
        ("no-imu.mcap", &["no topic of sensor_msgs/Imu", "/chatter (std_msgs/msg/String)"]),
        ("texts.mat", &["no variable or struct of numbers", "found: none"]),
        (
            "px4.ulg#remark",
            &["no subscription 'remark'", "'sensor_combined_0' (40 rows: timestamp, gyro_rad[0]", "'remark_1'"],
        ),
        ("expected.json#x", &["no table by name"][..]),
    ] {
        let words: Vec<&str> = if name == "expected.json#x" { vec!["none by name", "'#x'"] } else { words.to_vec() };
        let error = columns(&file(name)).expect_err(name);
        assert!(words.iter().all(|word| error.contains(word)), "{name}: {error}");
    }
    // a topic needs no slash in front, a table within a group has its path
    assert_eq!(columns(&file("two-topics.mcap#imu/left")).expect("a topic").len(), 7);
    assert_eq!(columns(&file("log.h5#imu")).expect("a group").len(), 5);
    assert_eq!(columns(&file("log.h5#gains")).expect("a dataset").len(), 1);
}

/// Files that were cut off anywhere, or have a byte changed, are values of `Err` or still records: never a panic.
#[test]
fn damaged_files_are_errors() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut halves = 0;
    for name in [
        "log.xlsx",
        "log.xls",
        "log.ods",
        "flat.mat",
        "flat-packed.mat",
        "struct.mat",
        "log.h5",
        "records.h5",
        "ros1.mcap",
        "ros2.mcap",
        "ros2-lz4.mcap",
        "ros1.bag",
        "ros1-lz4.bag",
        "px4.ulg",
    ] {
        let bytes = std::fs::read(file(name)).expect(name);
        let path = folder.path().join(name);
        let step = (bytes.len() / 60).max(1);
        for cut in (9..bytes.len()).step_by(step) {
            std::fs::write(&path, &bytes[..cut]).expect("a file");
            drop(columns(&path));
        }
        for at in (8..bytes.len()).step_by(step) {
            let mut changed = bytes.clone();
            changed[at] ^= 0x5A;
            std::fs::write(&path, &changed).expect("a file");
            drop(columns(&path));
        }
        std::fs::write(&path, &bytes[..bytes.len() / 2]).expect("a file");
        // a ULog ends where the power did
        if name != "px4.ulg" {
            let error = columns(&path).expect_err(name);
            assert!(error.contains("whole") && error.contains(name), "{name}: {error}");
        }
        halves += 1;
    }
    assert_eq!(halves, 14);
}

fn tumble(folder: &Path, arguments: &[&str]) -> (i32, String, String) {
    let output =
        Command::cargo_bin("tumble").expect("the program").current_dir(folder).args(arguments).output().expect("a run");
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).expect("UTF-8");
    (output.status.code().expect("no signal"), text(output.stdout), text(output.stderr))
}

/// `noise` and `reduce` read every format; a column that is not there is answered with those that are.
#[test]
fn commands_read_them() {
    let at = data("records");
    for (log, column) in [
        ("log.xlsx", "Ausgang"),
        ("flat.mat", "gyro_2"),
        ("log.h5", "gyro_1"),
        ("log-v73.mat", "gyro_3"),
        ("ros2.mcap", "w_z"),
        ("two-topics.mcap#/imu/left", "a_x"),
        ("ros1-lz4.bag", "w_y"),
        ("px4.ulg", "gyro_rad[1]"),
    ] {
        let (code, out, error) = tumble(&at, &["noise", log, "--columns", column, "--json", "-"]);
        assert!(code == 0 && out.contains(&format!("\"{column}\"")), "{log}: {error}");
        let (code, out, error) = tumble(
            &at,
            &["reduce", log, "--columns", column, "--window", "0.05", "--guard", "0", "--least", "0.1", "--json", "-"],
        );
        assert!(code == 0 || code == 2, "{log}: {error} {out}");
        let (code, _, error) = tumble(&at, &["noise", log, "--columns", "nothing"]);
        let flat = error.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(code == 1 && flat.contains("no column 'nothing'") && flat.contains(column), "{log}: {error}");
    }
    let (_, help, _) = tumble(&at, &["noise", "--help"]);
    assert!(help.contains("FILE#NAME"), "{help}");
}

const HEAD: &str = r#""bench": { "id": "head", "chain": [ { "joint": "theta", "about": "y" } ],
    "sensors": { "A": { "unit": "V", "model": "K0 + K1*a_x" } } }, "estimate": { "K0": {}, "K1": {} }"#;

fn solved(folder: &Path, rest: &str) -> Result<Vec<f64>, String> {
    let path = folder.join("c.campaign.json");
    std::fs::write(&path, format!("{{ {HEAD}, {rest} }}")).expect("a campaign");
    let campaign = tumble::Campaign::from_path(&path).map_err(|error| error.to_string())?;
    let fit = tumble::fit(&campaign, &Default::default()).expect("a fit");
    Ok(fit.parameters.iter().map(|own| own.value.expect("a value")).collect())
}

/// Readings of a campaign in a workbook and in Parquet, with titles and units of their own.
#[test]
fn readings_of_a_campaign() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    std::fs::copy(file("readings.xlsx"), at.join("readings.xlsx")).expect("a copy");
    let angles: Vec<f64> = (0..8).map(|k| 45.0 * f64::from(k)).collect();
    let volts: Vec<f64> = angles.iter().map(|a| 1000.0 * (0.002 - 1.3 * a.to_radians().sin())).collect();
    let serials: Vec<f64> = (0..16).map(|k| f64::from(k / 8)).collect();
    parquet(&at.join("readings.parquet"), &[("Winkel (Grad)", &angles), ("Spannung (mV)", &volts)]);
    let twice = |v: &[f64]| [v, v].concat();
    parquet(
        &at.join("many.parquet"),
        &[("Nummer", &serials), ("Winkel (Grad)", &twice(&angles)), ("Spannung (mV)", &twice(&volts))],
    );
    let map = r#""columns": { "theta_deg": "Winkel", "A": "Spannung" }"#;
    for table in ["readings.xlsx", "readings.parquet"] {
        let found = solved(at, &format!(r#"{map}, "readings": "{table}""#)).unwrap_or_else(|error| panic!("{error}"));
        for (value, truth) in found.iter().zip([0.002, 1.3]) {
            assert!((value - truth).abs() < 1e-12, "{table}: {found:?}");
        }
    }
    let error =
        solved(at, r#""columns": { "theta_deg": "Angle" }, "readings": "readings.xlsx""#).expect_err("a column");
    assert!(error.contains("no column 'Angle'") && error.contains("'Winkel (Grad)'"), "{error}");
    let error = solved(at, r#""readings": "readings.parquet""#).expect_err("no angle");
    assert!(error.contains("theta_deg"), "{error}");
    // many devices, told apart by a column with a name of its own
    let text = format!(
        r#"{{ {HEAD}, "by": "serial", "columns": {{ "serial": "Nummer", "theta_deg": "Winkel", "A": "Spannung" }}, "readings": "many.parquet" }}"#
    );
    std::fs::write(at.join("many.campaign.json"), text).expect("a campaign");
    let (code, out, error) = tumble(at, &["fit", "many.campaign.json", "--to", "-"]);
    assert_eq!(code, 0, "{error}");
    let rows: Vec<Vec<&str>> = out.lines().map(|line| line.split(',').collect()).collect();
    assert_eq!((rows[0][0], rows.len()), ("serial", 3), "{out}");
    let place = rows[0].iter().position(|title| *title == "K1").expect("K1");
    for row in &rows[1..] {
        assert!((row[place].parse::<f64>().expect("a number") - 1.3).abs() < 1e-12, "{out}");
    }
}

/// A Parquet file of doubles.
fn parquet(path: &Path, columns: &[(&str, &[f64])]) {
    use parquet::basic::{Repetition, Type as Physical};
    use parquet::data_type::DoubleType;
    use parquet::file::writer::SerializedFileWriter;
    use parquet::schema::types::Type;
    use std::sync::Arc;
    let field = |title: &str| {
        let builder = Type::primitive_type_builder(title, Physical::DOUBLE).with_repetition(Repetition::REQUIRED);
        Arc::new(builder.build().expect("a field"))
    };
    let fields = columns.iter().map(|(title, _)| field(title)).collect();
    let schema = Type::group_type_builder("table").with_fields(fields).build().expect("a schema");
    let file = std::fs::File::create(path).expect("a file");
    let mut writer = SerializedFileWriter::new(file, Arc::new(schema), Default::default()).expect("a writer");
    let mut group = writer.next_row_group().expect("a group");
    for (_, values) in columns {
        let mut column = group.next_column().expect("a column").expect("one more");
        column.typed::<DoubleType>().write_batch(values, None, None).expect("values");
        column.close().expect("a column");
    }
    group.close().expect("a group");
    writer.close().expect("a file");
}
