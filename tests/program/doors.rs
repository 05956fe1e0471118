//! One table through every door: whatever its dialect or format, each entrance reads the same numbers, or says the same of it.

use assert_cmd::Command;
use std::io::Write;
use std::path::Path;

const ANGLES: [f64; 6] = [0.0, 45.0, 90.0, 135.0, 180.0, 270.0];
const BENCH: &str = r#"{ "id": "line", "chain": [], "sensors": { "V": { "unit": "V", "model": "a + b*x + c*temperature_c + d*time_s" } } }"#;

/// Rows of serial, x, temperature in kelvin, time in minutes, volts in millivolts; exactly on the line a = 1, b = 0.5, c = 0.02, d = 0.001.
fn rows() -> Vec<(&'static str, [f64; 4])> {
    let mut rows = Vec::new();
    for serial in ["6\" rotor, left", "B"] {
        for (k, x) in ANGLES.into_iter().enumerate() {
            let celsius = [20.0, 21.0, 25.0, 22.0, 27.0, 23.0][k];
            let seconds = 30.0 * (k * k) as f64;
            let volts = 1.0 + 0.5 * x + 0.02 * celsius + 0.001 * seconds;
            rows.push((serial, [x, celsius + 273.15, seconds / 60.0, 1000.0 * volts]));
        }
    }
    rows
}

fn text(delimiter: char, mark: char, before: &str, end: &str) -> Vec<u8> {
    let quoted = |text: &str| format!("\"{}\"", text.replace('"', "\"\""));
    let d = delimiter;
    let mut text = format!("{before}serial{d}x{d}Temp (K){d}t (min){d}V [mV]{end}");
    for (serial, numbers) in rows() {
        let cells: Vec<String> = numbers.iter().map(|v| format!("{v}").replace('.', &mark.to_string())).collect();
        text.push_str(&format!("{}{d}{}{end}", quoted(serial), cells.join(&d.to_string())));
    }
    text.into_bytes()
}

fn parquet(path: &Path) {
    use parquet::basic::{LogicalType, Repetition, Type as Physical};
    use parquet::data_type::{ByteArray, ByteArrayType, DoubleType};
    use parquet::file::writer::SerializedFileWriter;
    use parquet::schema::types::Type;
    use std::sync::Arc;
    let field = |title: &str, kind: Physical, logical: Option<LogicalType>| {
        let own = Type::primitive_type_builder(title, kind).with_repetition(Repetition::REQUIRED);
        Arc::new(own.with_logical_type(logical).build().expect("a field"))
    };
    let mut fields = vec![field("serial", Physical::BYTE_ARRAY, Some(LogicalType::String))];
    fields.extend(["x", "Temp (K)", "t (min)", "V [mV]"].map(|title| field(title, Physical::DOUBLE, None)));
    let schema = Type::group_type_builder("table").with_fields(fields).build().expect("a schema");
    let file = std::fs::File::create(path).expect("a file");
    let mut writer = SerializedFileWriter::new(file, Arc::new(schema), Default::default()).expect("a writer");
    let mut group = writer.next_row_group().expect("a group");
    let serials: Vec<ByteArray> = rows().iter().map(|(serial, _)| ByteArray::from(*serial)).collect();
    let mut column = group.next_column().expect("a column").expect("one more");
    column.typed::<ByteArrayType>().write_batch(&serials, None, None).expect("values");
    column.close().expect("a column");
    for k in 0..4 {
        let values: Vec<f64> = rows().iter().map(|(_, own)| own[k]).collect();
        let mut column = group.next_column().expect("a column").expect("one more");
        column.typed::<DoubleType>().write_batch(&values, None, None).expect("values");
        column.close().expect("a column");
    }
    group.close().expect("a group");
    writer.close().expect("a file");
}

/// The table in each dialect and format, as a file of this name.
fn tables(at: &Path) -> Vec<&'static str> {
    let utf16 = |text: Vec<u8>| {
        let units = String::from_utf8(text).expect("UTF-8");
        std::iter::once(0xFEFF).chain(units.encode_utf16()).flat_map(u16::to_le_bytes).collect::<Vec<u8>>()
    };
    let gzip = |text: Vec<u8>| {
        let mut packed = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::default());
        packed.write_all(&text).expect("packed");
        packed.finish().expect("packed")
    };
    let plain = || text(',', '.', "", "\n");
    for (name, bytes) in [
        ("plain.csv", plain()),
        ("crlf.csv", text(',', '.', "", "\r\n")),
        ("german.csv", text(';', ',', "", "\r\n")),
        ("tabs.txt", text('\t', '.', "", "\n")),
        ("remarks.csv", text(',', '.', "% a logger of MATLAB\n# and one of numpy\n\n", "\n")),
        ("marked.csv", [b"\xef\xbb\xbf".to_vec(), plain()].concat()),
        ("wide.csv", utf16(text(';', ',', "", "\r\n"))),
        ("packed.csv.gz", gzip(plain())),
    ] {
        std::fs::write(at.join(name), bytes).expect("a table");
    }
    parquet(&at.join("table.parquet"));
    vec![
        "plain.csv",
        "crlf.csv",
        "german.csv",
        "tabs.txt",
        "remarks.csv",
        "marked.csv",
        "wide.csv",
        "packed.csv.gz",
        "table.parquet",
    ]
}

fn run(at: &Path, arguments: &[&str]) -> (i32, String, String) {
    let output =
        Command::cargo_bin("tumble").expect("the program").current_dir(at).args(arguments).output().expect("a run");
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).expect("UTF-8");
    (output.status.code().expect("no signal"), text(output.stdout), text(output.stderr))
}

const ASKED: &str = r#""estimate": { "a": {}, "b": {}, "c": {}, "d": {} }"#;
const MAP: &str = r#""columns": { "temperature_c": "Temp (K)", "time_s": "t (min)" }"#;
const TRUTH: [(&str, f64); 4] = [("a", 1.0), ("b", 0.5), ("c", 0.02), ("d", 0.001)];

#[track_caller]
fn check(report: &str, what: &str) {
    let report: serde_json::Value = serde_json::from_str(report).unwrap_or_else(|_| panic!("{what}: {report}"));
    for (id, truth) in TRUTH {
        let own = report["parameters"].as_array().expect("parameters").iter().find(|own| own["id"] == id).expect(id);
        let value = own["value"].as_f64().expect("a value");
        assert!((value - truth).abs() < 1e-9, "{what}: {id} = {value}");
    }
}

#[test]
fn every_table_through_every_door() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let campaign = |name: &str, rest: &str| {
        std::fs::write(at.join(name), format!(r#"{{ "bench": {BENCH}, {ASKED}, {rest} }}"#)).expect("a campaign");
    };
    let tables = tables(at);
    for table in &tables {
        // the campaign's own file, with units of time, temperature and volts in its titles
        campaign("c.campaign.json", &format!(r#"{MAP}, "readings": "{table}""#));
        let (code, out, error) = run(at, &["fit", "c.campaign.json", "--json", "-"]);
        assert_eq!(code, 0, "{table}: {error}");
        check(&out, table);
        // another campaign's readings replaced
        campaign("r.campaign.json", &format!(r#"{MAP}, "readings": "plain.csv""#));
        let (code, replaced, error) = run(at, &["fit", "r.campaign.json", "--readings", table, "--json", "-"]);
        assert_eq!(code, 0, "{table}: {error}");
        check(&replaced, table);
        // one fit for each device
        let (code, devices, error) = run(at, &["fit", "c.campaign.json", "--by", "serial", "--to", "-"]);
        assert_eq!(code, 0, "{table}: {error}");
        let mut reader = csv::Reader::from_reader(devices.as_bytes());
        let headers = reader.headers().expect("titles").clone();
        let found: Vec<csv::StringRecord> = reader.records().map(|row| row.expect("a row")).collect();
        assert_eq!(found.iter().map(|row| row[0].to_string()).collect::<Vec<_>>(), ["6\" rotor, left", "B"], "{table}");
        for (id, truth) in TRUTH {
            let place = headers.iter().position(|title| title == id).expect(id);
            assert!(
                found.iter().all(|row| (row[place].parse::<f64>().expect("a number") - truth).abs() < 1e-9),
                "{table} {id}"
            );
        }
        // every row of a record
        let rows = format!(r#""readings": {{ "samples": "{table}", "as": "rows", {MAP} }}"#);
        campaign("s.campaign.json", &rows);
        let (code, streamed, error) = run(at, &["fit", "s.campaign.json", "--json", "-"]);
        assert_eq!(code, 0, "{table}: {error}");
        check(&streamed, table);
        // means of segments by a column of labels
        let arguments = ["reduce", table, "--by", "serial", "--columns", "x,V", "--rate", "1", "--json", "-"];
        let (code, reduced, error) = run(at, &arguments);
        assert_eq!(code, 0, "{table}: {error}");
        let reduced: serde_json::Value = serde_json::from_str(&reduced).expect("JSON");
        assert!(reduced["segments"].as_array().is_some_and(|all| all.len() == 2), "{table}: {reduced}");
    }
    // a question that none of them answers gets one sentence from all
    for map in [
        r#""columns": { "temperature_c": "Temp (K)", "time_s": "t (min)", "x": "angle" }"#,
        r#""columns": { "temperature_c": "Temp (K)", "time_s": "t (min)", "V": "serial" }"#,
    ] {
        let mut sentences: Vec<String> = Vec::new();
        for table in &tables {
            campaign("e.campaign.json", &format!(r#"{map}, "readings": "{table}""#));
            let (code, _, error) = run(at, &["fit", "e.campaign.json"]);
            assert!(code == 1 && error.contains(table), "{table}: {error}");
            sentences.push(error.lines().next().unwrap_or_default().to_string());
        }
        sentences.dedup();
        assert_eq!(sentences.len(), 1, "{sentences:?}");
    }
}

/// Units in titles convert every column that a model line reads; what is no unit is an error.
#[test]
fn units_of_titles() {
    let folder = tempfile::tempdir().expect("a folder");
    let solved = |columns: &str, model: &str, table: &str| -> Result<Vec<f64>, String> {
        std::fs::write(folder.path().join("t.csv"), table).expect("a table");
        let text = format!(
            r#"{{ "bench": {{ "id": "q", "chain": [], "sensors": {{ "Y": {{ "unit": "V", "model": "{model}" }} }} }},
                "estimate": {{ "a": {{}}, "p": {{}} }}, "readings": "t.csv", "columns": {{ {columns} }} }}"#
        );
        let path = folder.path().join("c.campaign.json");
        std::fs::write(&path, text).expect("a campaign");
        let campaign = tumble::Campaign::from_path(&path).map_err(|error| error.to_string())?;
        let fit = tumble::fit(&campaign, &Default::default()).map_err(|error| error.to_string())?;
        Ok(fit.parameters.iter().map(|own| own.value.expect("a value")).collect())
    };
    let table = |title: &str, of: &dyn Fn(f64) -> f64| {
        (0..6)
            .map(f64::from)
            .fold(format!("{title},Y (mV)\n"), |text, x| text + &format!("{},{}\n", of(x), 1000.0 * (2.0 + 0.25 * x)))
    };
    for (key, title, to) in [
        ("temperature_c", "T (K)", &(|x| x + 273.15) as &dyn Fn(f64) -> f64),
        ("temperature_k", "T (degC)", &|x| x - 273.15),
        ("time_s", "t (min)", &|x| x / 60.0),
        ("time_s", "t / h", &|x| x / 3600.0),
        ("time_s", "t [ms]", &|x| 1000.0 * x),
        ("pressure_kpa", "p (Pa)", &|x| 1000.0 * x),
        ("pressure_hpa", "p (bar)", &|x| x / 1000.0),
        ("supply_v", "U (mV)", &|x| 1000.0 * x),
        ("tilt_deg", "tilt (rad)", &|x| x.to_radians()),
    ] {
        let map = format!(r#""{key}": "{title}", "Y": "Y""#);
        let found =
            solved(&map, &format!("a + p*{key}"), &table(title, to)).unwrap_or_else(|error| panic!("{title}: {error}"));
        assert!((found[0] - 2.0).abs() < 1e-9 && (found[1] - 0.25).abs() < 1e-9, "{title}: {found:?}");
    }
    let error = solved(r#""temperature_c": "T (furlong)""#, "a + p*temperature_c", &table("T (furlong)", &|x| x))
        .expect_err("a unit");
    assert!(error.contains("'furlong' is no unit that is known"), "{error}");
    let error =
        solved(r#""temperature_c": "T (V)""#, "a + p*temperature_c", &table("T (V)", &|x| x)).expect_err("volts");
    assert!(error.contains("another dimension"), "{error}");
    // what stands in square brackets behind a name is its number
    let found = solved(r#""x": "gyro[0]""#, "a + p*x", &table("gyro[0]", &|x| x)).expect("an index");
    assert!((found[1] - 0.25).abs() < 1e-9, "{found:?}");
}
