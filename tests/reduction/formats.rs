//! Records in the formats of laboratories, each written by the library of its own community (tests/scripts/record_formats.py, robot_logs.py).

use crate::support::*;
use assert_cmd::Command;
use serde_json::Value;
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

/// Moments, days, times of day and durations in workbooks of both epochs are seconds, as Python's calendar has them (tests/scripts/workbook_dates.py).
#[test]
fn dates_in_workbooks() {
    let wanted = json("records/dates.json");
    for name in ["dates-1900.xlsx", "dates-1904.xlsx"] {
        let mut record = Record::at(&file(name)).unwrap_or_else(|error| panic!("{name}: {error}"));
        let titles: Vec<String> = record.columns().iter().map(|column| column.title.clone()).collect();
        assert_eq!(titles, ["when", "day", "clock", "lasted", "V (mV)"], "{name}");
        // whole days are labels
        let titles: Vec<(usize, String)> = titles.into_iter().enumerate().filter(|(_, own)| own != "day").collect();
        record.select(&titles.iter().map(|(k, _)| (*k, As::Time)).collect::<Vec<_>>());
        let (mut block, mut found) = (Block::default(), vec![Vec::new(); titles.len()]);
        while record.next(&mut block).unwrap_or_else(|error| panic!("{name}: {error}")) {
            found.iter_mut().zip(&block.columns).for_each(|(own, part)| own.extend_from_slice(part));
        }
        for ((_, title), values) in titles.iter().zip(&found) {
            let wanted = numbers(&wanted[title.as_str()]);
            assert_eq!(values.len(), wanted.len(), "{name} {title}");
            for (value, wanted) in values.iter().zip(&wanted) {
                // a day's number has 4e-12 days in its last digit: a microsecond
                assert!((value - wanted).abs() <= 1.0e-6, "{name} {title}: {value}, not {wanted}");
            }
        }
    }
}

/// Parquet compressed by brotli, and with a column of lists: that alone is refused, by the name of its type (tests/scripts/parquet_kinds.py).
#[test]
fn kinds_of_parquet() {
    let x: Vec<f64> = (0..100).map(|k| 1.0 + f64::from(7 * k % 5) / 64.0).collect();
    let found = columns(&file("brotli.parquet")).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!((found[1].0.as_str(), &found[1].1), ("x", &x));
    let (code, out, error) = tumble(&data("records"), &["noise", "list.parquet", "--columns", "x", "--json", "-"]);
    assert!(code == 0 && out.contains("\"samples\": 100"), "{error}");
    let (code, _, error) = tumble(&data("records"), &["noise", "list.parquet"]);
    let flat = error.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(code == 1 && flat.contains("LIST or MAP") && flat.contains("v.list.element"), "{error}");
    // where a row's cells may be texts, a list is one: what does not use it is not hindered
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::copy(file("list.parquet"), folder.path().join("list.parquet")).expect("a copy");
    let fitted = |line: &str, rest: &str| {
        let bench =
            format!(r#"{{ "id": "b", "chain": [], "sensors": {{ "x": {{ "axes": {{}}, "model": "c{line}" }} }} }}"#);
        let text = format!(r#"{{ "bench": {bench}, "estimate": {{ "c": {{}} }}, "readings": "list.parquet"{rest} }}"#);
        let path = folder.path().join("list.campaign.json");
        std::fs::write(&path, text).expect("a campaign");
        tumble::Campaign::from_path(&path).map_err(|error| error.to_string())
    };
    let campaign = fitted("", "").unwrap_or_else(|error| panic!("{error}"));
    let fit = tumble::fit(&campaign, &Default::default()).unwrap_or_else(|error| panic!("{error}"));
    let mean = x.iter().sum::<f64>() / 100.0;
    assert!((fit.parameters[0].value.unwrap_or(f64::NAN) - mean).abs() < 1e-12);
    let error = fitted(" + warm", r#", "columns": { "warm": "v.list.element" }"#).expect_err("a list");
    assert!(error.contains("LIST or MAP") && error.contains("warm"), "{error}");
}

/// A column of formulas whose values were not saved hinders nobody who does not read it, and is named to who does (tests/scripts/formulas.py).
#[test]
fn formulas_without_values() {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::copy(file("formulas.xlsx"), folder.path().join("formulas.xlsx")).expect("a copy");
    let of = |column: &str| {
        solved(folder.path(), &format!(r#""columns": {{ "A": "{column}" }}, "readings": "formulas.xlsx""#))
    };
    // 0.5 + sin(theta) and twice as much, over two turns
    for (column, scale) in [("once", 1.0), ("twice", 2.0)] {
        let found = of(column).unwrap_or_else(|error| panic!("{error}"));
        let size = found[1].abs();
        assert!((found[0] - 0.5 * scale).abs() < 1e-12 && (size - scale).abs() < 1e-12, "{column}: {found:?}");
    }
    let error = of("thrice").expect_err("no values");
    assert!(error.contains("'=3*B2, a formula without a saved value'") && error.contains("formulas.xlsx:2"), "{error}");
}

/// Two loggers from start to end: the X16 of Gulf Coast Data Concepts (remarks behind semicolons, the names in the last of them) held in six positions, and a LabVIEW
/// measurement (.lvm: two heads of tagged lines, a name for comments behind the others) in either decimal mark. Laid out as their manuals print them.
#[test]
fn logs_of_two_more_loggers() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    // two values in turn: the mean of an even count is known exactly, and no two neighbours are equal
    let shake = |k: usize| if k.is_multiple_of(2) { 6.0 } else { -6.0 };
    let positions = [[0.0, 0.0, 2048.0], [0.0, 0.0, -2048.0], [2048.0, 0.0, 0.0], [0.0, -2048.0, 0.0]];
    let mut text = String::from(
        ";Title, http://www.gcdataconcepts.com, x16-1d, ADXL345\r\n;Version, 1110, Build date, Dec 30 2015, SN:CCDC4016131F31B\r\n\
         ;Start_time, 2026-11-20, 10:25:14.000\r\n;Temperature, -999.00, deg C, Vbat, 1444, mv\r\n;SampleRate, 100,Hz\r\n\
         ;Deadband, 0, counts\r\n;DeadbandTimeout, 0,sec\r\n;Headers, time,Ax,Ay,Az\r\n",
    );
    for k in 0..2400 {
        let own = positions[k / 600];
        // moved in the last second of each
        let by = if k % 600 < 500 { shake(k) } else { 300.0 * (k as f64 * 0.7).sin() };
        let cells: Vec<String> = own.iter().map(|v| format!("{}", (v + 20.0 + by).round())).collect();
        text.push_str(&format!("{:.3},{}\r\n", k as f64 / 100.0 + 0.003, cells.join(",")));
    }
    text.push_str(";shutdown: switched off\r\n");
    std::fs::write(at.join("DATA-001.CSV"), &text).expect("a log");
    let (code, out, error) = tumble(at, &["reduce", "DATA-001.CSV", "--json", "-"]);
    assert_eq!(code, 0, "{error}");
    let report: Value = serde_json::from_str(&out).expect("a report");
    let segments = report["segments"].as_array().expect("segments");
    assert_eq!(segments.len(), 4, "{out}");
    for (segment, own) in segments.iter().zip(positions) {
        let means = segment["means"].as_array().expect("means");
        for (mean, (name, truth)) in means.iter().zip(["Ax", "Ay", "Az"].into_iter().zip(own)) {
            // an odd count leaves one value of the shake
            assert!((number(&mean["mean"]) - truth - 20.0).abs() <= 6.0 / 300.0, "{mean}");
            assert_eq!(mean["column"], name);
        }
    }
    let mut text = String::from(
        "LabVIEW Measurement\t\r\nWriter_Version\t2\r\nReader_Version\t2\r\nSeparator\tTab\r\nDecimal_Separator\t.\r\nMulti_Headings\tNo\r\n\
         X_Columns\tOne\r\nTime_Pref\tRelative\r\nOperator\tlab\r\nDate\t2026/11/20\r\nTime\t09:14:03.1234567\r\n***End_of_Header***\t\r\n\t\r\n\
         Channels\t2\t\t\r\nSamples\t2000\t2000\t\r\nDate\t2026/11/20\t2026/11/20\t\r\nTime\t09:14:03.2\t09:14:03.2\t\r\n\
         Y_Unit_Label\tVolts\tVolts\t\r\nX_Dimension\tTime\tTime\t\r\nX0\t0.0000000000000000E+0\t0.0000000000000000E+0\t\r\n\
         Delta_X\t0.010000\t0.010000\t\r\n***End_of_Header***\t\t\t\r\nX_Value\tgyro\tlevel\tComment\r\n",
    );
    for k in 0..2000 {
        let (gyro, level) = (0.5 + 1e-3 * shake(k), 0.1 * (k / 1000) as f64 + 1e-3 * shake(k + 1));
        text.push_str(&format!("{:.6}\t{gyro:.6}\t{level:.6}\r\n", k as f64 / 100.0));
    }
    let comma =
        text.replace("Decimal_Separator\t.", "Decimal_Separator\t,").replace("\t0.", "\t0,").replace("\n0.", "\n0,");
    let comma = (1..20).fold(comma, |text, k| text.replace(&format!("\n{k}."), &format!("\n{k},")));
    let comma = comma.replace("\t-0.", "\t-0,");
    std::fs::write(at.join("times.csv"), "start_s,end_s,position\n0,10,a\n10,20,b\n").expect("times");
    // as some versions write it, without tabs behind the tags
    let bare: String = text.lines().map(|line| line.trim_end().to_string() + "\r\n").collect();
    for (name, text) in [("run.lvm", &text), ("run_de.lvm", &comma), ("bare.lvm", &bare)] {
        std::fs::write(at.join(name), text).expect("a log");
        let (code, _, error) = tumble(at, &["reduce", name, "--times", "times.csv"]);
        assert!(code == 0 && error.contains("'X_Value' is taken"), "{error}");
        let arguments = ["reduce", name, "--times", "times.csv", "--time", "X_Value", "--json", "-"];
        let (code, out, error) = tumble(at, &arguments);
        assert_eq!(code, 0, "{name}: {error}");
        let report: Value = serde_json::from_str(&out).expect("a report");
        for (k, level) in [0.0, 0.1].into_iter().enumerate() {
            let own = &report["segments"][k];
            assert_eq!(own["n"], 1000, "{name}");
            for (mean, truth) in own["means"].as_array().expect("means").iter().zip([0.5, level]) {
                assert!((number(&mean["mean"]) - truth).abs() < 1e-12, "{name}: {mean}");
            }
        }
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

/// Numbers packed after the conventions of netCDF are unpacked, and what is not there is absent (`tests/scripts/record_formats.py`).
#[test]
fn packed_numbers() {
    let all = columns(&file("packed.h5")).expect("a file");
    let values = &all.iter().find(|(title, _)| title == "V").expect("the column").1;
    assert_eq!(values.len(), 40);
    for (k, value) in values.iter().enumerate() {
        let count = (k * 7919 % 251) as f64 - 125.0;
        assert!(if k == 3 { value.is_nan() } else { *value == 0.5 * count + 2.0 }, "row {k}: {value}");
    }
}

/// Tables of Japanese and Chinese programs are read by their own encodings, those of the west by Latin-1 (bytes by Python's codecs).
#[test]
fn encodings_of_the_east() {
    let titles = |bytes: &[u8]| -> Vec<String> {
        let record = Record::of_stream("t.csv", std::io::Cursor::new(bytes.to_vec())).expect("a table");
        record.columns().iter().map(|column| column.title.clone()).collect()
    };
    let table = |head: &[u8], remark: &[u8]| [head, b"10,0.2,", remark, b"\n-10,-0.2,", remark, b"\n"].concat();
    let japanese =
        table(b"\x89\xf1\x93]\x91\xac\x93x[deg/s],\x8fo\x97\xcd[V],\x94\xf5\x8dl\n", b"\x8d\xb6\x89\xf1\x82\xe8");
    assert_eq!(titles(&japanese), ["回転速度[deg/s]", "出力[V]", "備考"]);
    let chinese = table(b"\xd7\xaa\xcb\xd9[deg/s],\xca\xe4\xb3\xf6[V],\xb1\xb8\xd7\xa2\n", b"\xb7\xb4\xd7\xaa");
    assert_eq!(titles(&chinese), ["转速[deg/s]", "输出[V]", "备注"]);
    let german = b"Winkel [\xb0],L\xe4nge [mm],U [V]\n1,2,3\n4,5,6\n";
    assert_eq!(titles(german), ["Winkel [°]", "Länge [mm]", "U [V]"]);
}

/// Arrays of NumPy as NEP 1 lays them out, and matrices of MATLAB's level 4; both by hand.
#[test]
fn plain_arrays() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name);
    let npy = |name: &str, head: &str, data: Vec<u8>| {
        let head = format!("{head:<117}\n");
        let length = u16::try_from(head.len()).expect("a short head").to_le_bytes();
        let bytes = [b"\x93NUMPY\x01\x00".as_slice(), &length, head.as_bytes(), &data].concat();
        std::fs::write(path(name), bytes).expect("a file");
        columns(&path(name))
    };
    let doubles = |values: &[f64]| values.iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<u8>>();
    let named = |names: &[&str], values: [[f64; 3]; 2]| {
        Ok(names.iter().zip(values).map(|(name, values)| (name.to_string(), values.to_vec())).collect::<Vec<_>>())
    };
    let expected = named(&["c_1", "c_2"], [[0.0, 1.0, 2.0], [0.5, -2.5, 4.5]]);
    let by_rows = doubles(&[0.0, 0.5, 1.0, -2.5, 2.0, 4.5]);
    let head = "{'descr': '<f8', 'fortran_order': False, 'shape': (3, 2), }";
    assert_eq!(npy("rows.npy", head, by_rows), expected);
    let head = "{'descr': '<f8', 'fortran_order': True, 'shape': (3, 2), }";
    assert_eq!(npy("columns.npy", head, doubles(&[0.0, 1.0, 2.0, 0.5, -2.5, 4.5])), expected);
    let head = "{'descr': [('t', '>i2'), ('V', '<f4')], 'fortran_order': False, 'shape': (3,), }";
    let fields = [(0_i16, 0.5_f32), (1, -2.5), (2, 4.5)];
    let data = fields.iter().flat_map(|(t, v)| [t.to_be_bytes().to_vec(), v.to_le_bytes().to_vec()].concat()).collect();
    assert_eq!(npy("fields.npy", head, data), named(&["t", "V"], [[0.0, 1.0, 2.0], [0.5, -2.5, 4.5]]));
    let head = "{'descr': '<f8', 'fortran_order': False, 'shape': (9, 2), }";
    assert!(npy("cut.npy", head, vec![0; 80]).is_err_and(|error| error.contains("80 bytes of 144")));
    let head = "{'descr': '<U5', 'fortran_order': False, 'shape': (3,), }";
    assert!(npy("texts.npy", head, vec![0; 60]).is_err_and(|error| error.contains("<U5")));

    let matrix = |big: bool, name: &str, values: &[f64]| {
        let sides = u32::try_from(values.len()).expect("few");
        let length = u32::try_from(name.len() + 1).expect("short");
        let head = [if big { 1000 } else { 0 }, sides, 1, 0, length];
        let word = |word: u32| if big { word.to_be_bytes() } else { word.to_le_bytes() };
        let mut bytes: Vec<u8> = head.into_iter().flat_map(word).collect();
        bytes.extend([name.as_bytes(), b"\0"].concat());
        bytes.extend(values.iter().flat_map(|v| if big { v.to_be_bytes() } else { v.to_le_bytes() }));
        bytes
    };
    for big in [false, true] {
        let bytes = [matrix(big, "t", &[0.0, 1.0, 2.0]), matrix(big, "V", &[0.5, -2.5, 4.5])].concat();
        std::fs::write(path("v4.mat"), &bytes).expect("a file");
        assert_eq!(columns(&path("v4.mat")), named(&["t", "V"], [[0.0, 1.0, 2.0], [0.5, -2.5, 4.5]]));
        std::fs::write(path("v4.mat"), &bytes[..bytes.len() - 3]).expect("a file");
        assert!(columns(&path("v4.mat")).is_err_and(|error| error.contains("cut off")));
    }
    std::fs::write(path("log.nc"), b"CDF\x01\0\0\0\0\0\0\0\x0a").expect("a file");
    assert!(columns(&path("log.nc")).is_err_and(|error| error.contains("NetCDF")));
}

/// The unit that a workbook shows behind its numbers is that of the column, and a column has one.
#[test]
fn units_of_number_formats() {
    use rust_xlsxwriter::{Format, Workbook};
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("shown.xlsx");
    let write = |formats: [&str; 5]| {
        let mut book = Workbook::new();
        let sheet = book.add_worksheet();
        for (column, format) in (0..).zip(formats) {
            sheet.write_string(0, column, ["A", "B", "C", "D (V)", "E"][usize::from(column)]).expect("a title");
            for row in 1..5 {
                // the last column's rows differ
                let own = if column == 4 && row == 4 { "0.0" } else { format };
                let format = Format::new().set_num_format(own);
                sheet.write_number_with_format(row, column, f64::from(row) + 0.5, &format).expect("a number");
            }
        }
        book.save(&path).expect("a workbook");
    };
    let unit = |record: &Record| record.columns().iter().map(|column| column.unit.clone()).collect::<Vec<_>>();
    write(["0.00\" \u{b0}C\"", "0.0\\ \\m\\V", "0.00", "0.0\" mV\"", "#,##0.0\" deg/s\";[Red]-0.0"]);
    let expected = [Some("\u{b0}C"), Some("mV"), None, Some("V"), Some("deg/s")];
    let record = Record::at(&path).expect("a table");
    assert_eq!(unit(&record), expected.map(|unit| unit.map(String::from)));
    write(["0.00\" piece\"", "0.00%", "[$-409]0.0", "0.0E+00", "\"about \"0.0"]);
    assert_eq!(unit(&Record::at(&path).expect("a table")), [None, None, None, Some("V".into()), None]);
    let mut book = Workbook::new();
    let sheet = book.add_worksheet();
    sheet.write_string(0, 0, "V").expect("a title");
    for (row, unit) in [(1, "mV"), (2, "V")] {
        let format = Format::new().set_num_format(format!("0.0\" {unit}\""));
        sheet.write_number_with_format(row, 0, 1.5, &format).expect("a number");
    }
    book.save(&path).expect("a workbook");
    let error = Record::at(&path).expect_err("two units").to_string();
    assert!(error.contains("'mV' and 'V'") && error.contains("column 1"), "{error}");
}
