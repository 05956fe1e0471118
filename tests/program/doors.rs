//! One table through every door: whatever its dialect or format, each entrance reads the same numbers, or says the same of it.

use assert_cmd::Command;
use std::io::Write;
use std::path::Path;

const BENCH: &str = r#"{ "id": "line", "chain": [], "sensors": { "V": { "unit": "V", "model": "a + b*x + c*temperature_c + d*time_s" } } }"#;

/// Rows of serial, x, temperature in kelvin, time in minutes, volts in millivolts; exactly on the line a = 1, b = 0.5, c = 0.02, d = 0.001.
fn rows() -> Vec<(&'static str, [f64; 4])> {
    let mut rows = Vec::new();
    for serial in ["6\" rotor, left", "B"] {
        for k in 0..16 {
            let (x, celsius, seconds) = (22.5 * f64::from(k), 20.0 + f64::from(7 * k % 9), 30.0 * f64::from(k * k));
            let millivolts = 1000.0 + 500.0 * x + 20.0 * celsius + seconds;
            rows.push((serial, [x, celsius + 273.15, seconds / 60.0, millivolts]));
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

/// As doubles, or as decimal numbers of two places.
fn parquet(path: &Path, is_decimal: bool) {
    use parquet::basic::{LogicalType, Repetition, Type as Physical};
    use parquet::data_type::{ByteArray, ByteArrayType, DoubleType, Int64Type};
    use parquet::file::writer::SerializedFileWriter;
    use parquet::schema::types::Type;
    use std::sync::Arc;
    let field = |title: &str, kind: Physical, logical: Option<LogicalType>| {
        let own = Type::primitive_type_builder(title, kind).with_repetition(Repetition::REQUIRED);
        let own = if kind == Physical::INT64 { own.with_precision(18).with_scale(2) } else { own };
        Arc::new(own.with_logical_type(logical).build().expect("a field"))
    };
    let mut fields = vec![field("serial", Physical::BYTE_ARRAY, Some(LogicalType::String))];
    let titles = ["x", "Temp (K)", "t (min)", "V [mV]"];
    fields.extend(titles.map(|title| match is_decimal {
        true => field(title, Physical::INT64, Some(LogicalType::decimal(2, 18))),
        false => field(title, Physical::DOUBLE, None),
    }));
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
        if is_decimal {
            let hundredths: Vec<i64> = values.iter().map(|value| (100.0 * value).round() as i64).collect();
            column.typed::<Int64Type>().write_batch(&hundredths, None, None).expect("values");
        } else {
            column.typed::<DoubleType>().write_batch(&values, None, None).expect("values");
        }
        column.close().expect("a column");
    }
    group.close().expect("a group");
    writer.close().expect("a file");
}

/// A table in one dialect or format.
struct Door {
    file: &'static str,
    /// How the column of angles is titled.
    x: &'static str,
    serials: [&'static str; 2],
}

/// The table in each dialect and format; those of foreign libraries are made by tests/scripts/doors.py.
fn doors(at: &Path) -> Vec<Door> {
    let utf16 = |text: Vec<u8>| {
        let units = String::from_utf8(text).expect("UTF-8");
        std::iter::once(0xFEFF).chain(units.encode_utf16()).flat_map(u16::to_le_bytes).collect::<Vec<u8>>()
    };
    let gzip = |text: Vec<u8>| {
        let mut packed = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::default());
        packed.write_all(&text).expect("packed");
        packed.finish().expect("packed")
    };
    // UTF-16 without its mark, and numbers with decimal commas in quotes between commas
    let unmarked = |text: Vec<u8>| {
        let text = String::from_utf8(text).expect("UTF-8");
        text.encode_utf16().flat_map(u16::to_be_bytes).collect::<Vec<u8>>()
    };
    let quoted = || {
        let text = String::from_utf8(text(';', ',', "", "\n")).expect("UTF-8");
        let cell =
            |cell: &str| if cell.contains(',') && !cell.starts_with('"') { format!("\"{cell}\"") } else { cell.into() };
        let row = |line: &str| line.split(';').map(cell).collect::<Vec<_>>().join(",") + "\n";
        text.lines().map(row).collect::<String>().into_bytes()
    };
    let plain = || text(',', '.', "", "\n");
    let with_head = |head: &str| {
        let text = String::from_utf8(plain()).expect("UTF-8");
        let rows = text.split_once('\n').expect("a first line").1;
        format!("{head}{rows}").into_bytes()
    };
    let station = "\"TOA5\",\"CR1000\",\"CR1000\",\"1234\",\"CR1000.Std.31\",\"CPU:x.CR1\",\"5555\",\"Table1\"\n";
    let toa5 =
        "\"serial\",\"x\",\"Temp\",\"t\",\"V\"\n\"\",\"\",\"K\",\"min\",\"mV\"\n\"\",\"\",\"Smp\",\"Smp\",\"Smp\"\n";
    let blanks = with_head("serial,x,Temp(K),t(min),V[mV]\n");
    let blanks = String::from_utf8(blanks)
        .expect("UTF-8")
        .replace("\"6\"\" rotor, left\"", "A1")
        .replace('"', "")
        .replace(',', "   ");
    // rows that somebody has put out of use, among the others
    let commented = || {
        let text = String::from_utf8(plain()).expect("UTF-8");
        let mut lines: Vec<String> = text.lines().map(str::to_string).collect();
        for (place, mark) in [(9, "%"), (5, "//"), (3, "#"), (20, ";")] {
            lines.insert(place, format!("{mark}A1,1,2,3,4"));
        }
        (lines.join("\n") + "\n").into_bytes()
    };
    for (name, bytes) in [
        ("plain.csv", plain()),
        ("commented.csv", commented()),
        ("above.csv", with_head(",,K,min,mV\nserial,x,Temp,t,V\n")),
        ("crlf.csv", text(',', '.', "", "\r\n")),
        ("german.csv", text(';', ',', "", "\r\n")),
        ("tabs.txt", text('\t', '.', "", "\n")),
        ("bars.txt", text('|', ',', "", "\n")),
        ("blanks.txt", blanks.into_bytes()),
        ("remarks.csv", text(',', '.', "% a logger of MATLAB\n# and one of numpy\n\n", "\n")),
        ("station.dat", with_head(&format!("{station}{toa5}"))),
        ("euroc.csv", with_head("#serial,x,Temp [K],t [min],V [mV]\n")),
        ("units.csv", with_head("serial,x,Temp,t,V\n,,K,min,mV\n")),
        ("px4.csv", with_head("serial,x[0],Temp (K),t (min),V [mV]\n")),
        ("marked.csv", [b"\xef\xbb\xbf".to_vec(), plain()].concat()),
        ("wide.csv", utf16(text(';', ',', "", "\r\n"))),
        ("unmarked.csv", unmarked(text(',', '.', "", "\n"))),
        ("quoted.csv", quoted()),
        ("packed.csv.gz", gzip(plain())),
        ("returns.csv", text(';', ',', "", "\r")),
        ("ended.csv", text(';', '.', "", ";\n")),
    ] {
        std::fs::write(at.join(name), bytes).expect("a table");
    }
    parquet(&at.join("table.parquet"), false);
    parquet(&at.join("decimal.parquet"), true);
    let made = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/doors");
    for name in ["table.xlsx", "table.ods", "table.h5"] {
        std::fs::copy(made.join(name), at.join(name)).expect("a copy");
    }
    let door = |file| Door {
        file,
        x: if file == "px4.csv" { "x[0]" } else { "x" },
        serials: match file {
            "table.h5" => ["1", "2"],
            "blanks.txt" => ["A1", "B"],
            _ => ["6\" rotor, left", "B"],
        },
    };
    [
        "plain.csv",
        "commented.csv",
        "above.csv",
        "crlf.csv",
        "german.csv",
        "tabs.txt",
        "bars.txt",
        "blanks.txt",
        "remarks.csv",
        "station.dat",
        "euroc.csv",
        "units.csv",
        "px4.csv",
        "marked.csv",
        "wide.csv",
        "unmarked.csv",
        "quoted.csv",
        "packed.csv.gz",
        "returns.csv",
        "ended.csv",
        "table.parquet",
        "decimal.parquet",
        "table.xlsx",
        "table.ods",
        "table.h5",
    ]
    .map(door)
    .into()
}

fn run(at: &Path, arguments: &[&str]) -> (i32, String, String) {
    let output =
        Command::cargo_bin("tumble").expect("the program").current_dir(at).args(arguments).output().expect("a run");
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).expect("UTF-8");
    (output.status.code().expect("no signal"), text(output.stdout), text(output.stderr))
}

const ASKED: &str = r#""estimate": { "a": {}, "b": {}, "c": {}, "d": {} }"#;
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

/// What a report says, but for the names of files and devices.
fn nameless(report: &str, door: &Door) -> serde_json::Value {
    fn walk(value: &mut serde_json::Value, of: &dyn Fn(&str) -> Option<String>) {
        match value {
            serde_json::Value::String(text) => *text = of(text).unwrap_or_else(|| text.clone()),
            serde_json::Value::Array(list) => list.iter_mut().for_each(|own| walk(own, of)),
            serde_json::Value::Object(map) => map.values_mut().for_each(|own| walk(own, of)),
            _ => {}
        }
    }
    let mut report = serde_json::from_str(report).unwrap_or_else(|_| panic!("{}: {report}", door.file));
    walk(&mut report, &|text| {
        let serial = door.serials.iter().position(|own| *own == text).map(|k| format!("device {k}"));
        serial.or_else(|| (text == door.x).then(|| "x".into())).or_else(|| text.contains(door.file).then(String::new))
    });
    report
}

#[test]
fn every_table_through_every_door() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let campaign = |name: &str, rest: &str| {
        std::fs::write(at.join(name), format!(r#"{{ "bench": {BENCH}, {ASKED}, {rest} }}"#)).expect("a campaign");
    };
    let table1 = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/01-gyro-table/table1.campaign.json");
    run(at, &["fit", table1.to_str().expect("a path"), "--json", "gyro.json"]);
    let inline: Vec<serde_json::Value> = rows()
        .iter()
        .map(|(serial, [x, kelvin, minutes, millivolts])| {
            serde_json::json!({ "serial": serial, "x": x, "temperature_c": kelvin - 273.15, "time_s": 60.0 * minutes, "V": millivolts / 1000.0 })
        })
        .collect();
    campaign("i.campaign.json", &format!(r#""readings": {}"#, serde_json::Value::from(inline)));
    let (code, out, error) = run(at, &["fit", "i.campaign.json", "--json", "-"]);
    assert_eq!(code, 0, "{error}");
    check(&out, "inline");
    let doors = doors(at);
    let mut first: Vec<serde_json::Value> = Vec::new();
    for door in &doors {
        let table = door.file;
        let map = format!(r#""columns": {{ "temperature_c": "Temp", "time_s": "t", "x": "{}" }}"#, door.x);
        // the campaign's own file, with units of time, temperature and volts in its titles
        campaign("c.campaign.json", &format!(r#"{map}, "readings": "{table}""#));
        let (code, out, error) = run(at, &["fit", "c.campaign.json", "--json", "-"]);
        assert_eq!(code, 0, "{table}: {error}");
        check(&out, table);
        // another campaign's readings replaced
        campaign(
            "r.campaign.json",
            &format!(r#"{map}, "readings": "{}""#, if door.x == "x" { "plain.csv" } else { "px4.csv" }),
        );
        let (code, replaced, error) = run(at, &["fit", "r.campaign.json", "--readings", table, "--json", "-"]);
        assert_eq!(code, 0, "{table}: {error}");
        check(&replaced, table);
        // one fit for each device
        let (code, devices, error) = run(at, &["fit", "c.campaign.json", "--by", "serial", "--to", "-"]);
        assert_eq!(code, 0, "{table}: {error}");
        let mut reader = csv::Reader::from_reader(devices.as_bytes());
        let headers = reader.headers().expect("titles").clone();
        let found: Vec<csv::StringRecord> = reader.records().map(|row| row.expect("a row")).collect();
        assert_eq!(found.iter().map(|row| row[0].to_string()).collect::<Vec<_>>(), door.serials, "{table}");
        for (id, truth) in TRUTH {
            let place = headers.iter().position(|title| title == id).expect(id);
            assert!(
                found.iter().all(|row| (row[place].parse::<f64>().expect("a number") - truth).abs() < 1e-9),
                "{table} {id}"
            );
        }
        // every row of a record
        let rows = format!(r#""readings": {{ "samples": "{table}", "as": "rows", {map} }}"#);
        campaign("s.campaign.json", &rows);
        let (_, streamed, error) = run(at, &["fit", "s.campaign.json", "--json", "-"]);
        assert!(streamed.starts_with('{'), "{table}: {error}");
        check(&streamed, table);
        // means of segments by a column of labels, and Allan deviations: the same as of the first table
        let columns = format!("{},V", door.x);
        let (code, reduced, error) =
            run(at, &["reduce", table, "--by", "serial", "--columns", &columns, "--rate", "1", "--json", "-"]);
        assert_eq!(code, 0, "{table}: {error}");
        let (_, noise, error) = run(at, &["noise", table, "--columns", "V", "--rate", "1", "--json", "-"]);
        assert!(noise.starts_with('{'), "{table}: {error}");
        // a correction of every row, what is not corrected beside it
        let (_, applied, error) = run(at, &["apply", "gyro.json", table]);
        let mut reader = csv::Reader::from_reader(applied.as_bytes());
        let serial = reader.headers().expect("titles").iter().position(|title| title == "serial").expect("serials");
        let cells: Vec<Vec<String>> =
            reader.records().map(|row| row.expect("a row").iter().map(str::to_string).collect()).collect();
        assert_eq!(cells.len(), 32, "{table}: {error}");
        // HDF5 has its columns in the order of their names
        let applied = cells.iter().map(|row| {
            let others = row.iter().enumerate().filter(|(k, _)| *k != serial);
            let mut numbers: Vec<f64> = others.map(|(_, cell)| cell.parse().expect("a number")).collect();
            numbers.sort_by(f64::total_cmp);
            serde_json::json!([row[serial], numbers])
        });
        let applied = serde_json::Value::Array(applied.collect());
        let found = vec![nameless(&reduced, door), nameless(&noise, door), nameless(&applied.to_string(), door)];
        if first.is_empty() {
            assert_eq!(found[0]["segments"].as_array().map(Vec::len), Some(2), "{table}");
            first = found;
        } else {
            assert_eq!(found, first, "{table}");
        }
    }
    // a question that none of them answers gets one sentence from all
    for map in [
        r#""columns": { "temperature_c": "Temp", "time_s": "t", "angle": "y" }"#,
        r#""columns": { "temperature_c": "t", "time_s": "Temp" }"#,
        r#""columns": { "temperature_c": "Temp", "time_s": "t", "V_u": "V" }"#,
    ] {
        let mut sentences: Vec<String> = Vec::new();
        for door in doors.iter().filter(|door| door.x == "x") {
            campaign("e.campaign.json", &format!(r#"{map}, "readings": "{}""#, door.file));
            let (code, _, error) = run(at, &["fit", "e.campaign.json"]);
            assert!(code == 1, "{}: {error}", door.file);
            let sentence = error.lines().find(|line| line.contains("error:")).unwrap_or_default();
            // what a title says of its unit is written as it stands there
            sentences.push(sentence.split('\'').next().unwrap_or_default().to_string());
        }
        sentences.dedup();
        assert_eq!(sentences.len(), 1, "{sentences:?}");
    }
}

/// Logs of robots through every door: the same as the numbers that went into them, as a plain table.
#[test]
fn every_log_through_every_door() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/records");
    let read = |name: &str| -> serde_json::Value {
        serde_json::from_str(&std::fs::read_to_string(data.join(name)).expect(name)).expect(name)
    };
    // made by tests/scripts/robot_logs.py and record_formats.py, with the libraries of their communities
    let (robots, formats) = (read("robots.json"), read("expected.json"));
    let table1 = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/01-gyro-table/table1.campaign.json");
    run(at, &["fit", table1.to_str().expect("a path"), "--json", "gyro.json"]);
    std::fs::write(at.join("times.csv"), "start_s,end_s,position\n0,0.1,a\n0.15,0.3,b\n").expect("segments");
    let mut seen = 0;
    for (log, numbers) in [&robots, &formats].into_iter().flat_map(|own| own.as_object().expect("logs")) {
        let (time, unit, sensor) = match log.rsplit_once('.') {
            Some((_, "ulg")) => ("timestamp", "us", "gyro_rad[1]"),
            Some((_, "bag" | "mcap")) => ("time_s", "s", "w_y"),
            _ => continue,
        };
        std::fs::copy(data.join(log), at.join(log)).expect("a copy");
        let columns = numbers.as_object().expect("columns");
        let titled = |own: &String| if own == time { format!("{own} [{unit}]") } else { own.clone() };
        let mut text = columns.keys().map(titled).collect::<Vec<_>>().join(",") + "\n";
        for k in 0..columns[time].as_array().expect("times").len() {
            let row: Vec<String> = columns.values().map(|own| own[k].to_string()).collect();
            text.push_str(&format!("{}\n", row.join(",")));
        }
        let plain = log.replace('.', "_") + ".csv";
        std::fs::write(at.join(&plain), text).expect("a table");
        let mut answers: Vec<Vec<serde_json::Value>> = Vec::new();
        for file in [log.as_str(), &plain] {
            let door =
                Door { file: Box::leak(file.to_string().into_boxed_str()), x: "no such title", serials: ["1", "2"] };
            let bench =
                r#"{ "id": "line", "chain": [], "sensors": { "V": { "unit": "rad/s", "model": "a + b*time_s" } } }"#;
            let campaign = |readings: &str| {
                let text = format!(r#"{{ "bench": {bench}, "estimate": {{ "a": {{}}, "b": {{}} }}, {readings} }}"#);
                std::fs::write(at.join("c.campaign.json"), text).expect("a campaign");
            };
            let map = format!(r#""columns": {{ "V": "{sensor}", "time_s": "{time}" }}"#);
            let mut own = Vec::new();
            let mut ask = |arguments: &[&str]| {
                let (_, out, error) = run(at, arguments);
                let sentence = error.lines().find(|line| line.contains("error:")).unwrap_or_default();
                own.push(match (out.starts_with('{'), arguments[0]) {
                    (true, "fit") => nameless(&out, &door)["parameters"].clone(),
                    (true, _) => nameless(&out, &door),
                    // names that inputs along axes have are refused of a table of readings, wherever they come from
                    (false, _) => {
                        assert!(sentence.contains("has the name of something else"), "{file} {arguments:?}: {error}");
                        serde_json::json!("refused")
                    }
                });
            };
            ask(&["reduce", file, "--times", "times.csv", "--columns", &format!("V={sensor}"), "--json", "-"]);
            ask(&["noise", file, "--columns", sensor, "--unit", "rad/s", "--json", "-"]);
            campaign(&format!(r#"{map}, "readings": "{file}""#));
            ask(&["fit", "c.campaign.json", "--json", "-"]);
            campaign(&format!(r#"{map}, "readings": "times.csv""#));
            ask(&["fit", "c.campaign.json", "--readings", file, "--json", "-"]);
            if time == "time_s" {
                campaign(&format!(r#""readings": {{ "samples": "{file}", "as": "rows", {map} }}"#));
                ask(&["fit", "c.campaign.json", "--json", "-"]);
            }
            let (code, out, error) = run(at, &["apply", "gyro.json", file, "--column", &format!("V={sensor}")]);
            let sentence = error.lines().find(|line| line.contains("error:")).unwrap_or_default();
            // a calibration that reads volts: messages say rad/s, a ULog and the plain table say nothing
            if time == "time_s" && file == log {
                assert!(sentence.contains("has another dimension"), "{file}: {error}");
            } else {
                assert_eq!(code, 0, "{file}: {error}");
            }
            let mut reader = csv::Reader::from_reader(out.as_bytes());
            let last = |row: Result<csv::StringRecord, csv::Error>| {
                row.expect("a row").iter().next_back().and_then(|cell| cell.parse::<f64>().ok()).expect("a number")
            };
            let corrected: Vec<f64> = reader.records().map(last).collect();
            if time == "timestamp" {
                own.push(serde_json::json!(corrected));
            }
            let (code, _, error) = run(at, &["noise", file, "--columns", "nope"]);
            let sentence = error.lines().find(|line| line.contains("error:")).unwrap_or_default().to_string();
            own.push(serde_json::json!([code, sentence]));
            answers.push(own);
        }
        for (k, (of_log, of_table)) in answers[0].iter().zip(&answers[1]).enumerate() {
            // the title of a table's times has their unit, messages have one for their sensors
            let without = |own: &serde_json::Value| {
                let text = own.to_string().replace(" [us]'", "'").replace(" [s]'", "'");
                text.replace("\"unit\":\"rad/s\"", "\"unit\":\"\"")
            };
            assert_eq!(without(of_log), without(of_table), "{log}, answer {k}");
        }
        seen += 1;
    }
    assert_eq!(seen, 6);
}

/// A unit behind a name makes it no other name: a table with a column called like an input along an axis is refused alike.
#[test]
fn names_of_axis_inputs_with_units() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let bench = r#"{ "id": "line", "chain": [], "sensors": { "V": { "unit": "rad/s", "model": "a + b*time_s" } } }"#;
    for (k, titles) in ["w_x,w_y", "w_x [rad/s],w_y [rad/s]", "w_x (rad/s),w_y", "w_x,w_y [rad/s]"].iter().enumerate() {
        let rows: String = (0..9).map(|k| format!("{},{},{}\n", k, k % 3, 0.1 * f64::from(k * k % 7))).collect();
        let table = format!("t{k}.csv");
        std::fs::write(at.join(&table), format!("time_s,{titles}\n{rows}")).expect("a table");
        let text = format!(
            r#"{{ "bench": {bench}, "estimate": {{ "a": {{}}, "b": {{}} }}, "columns": {{ "V": "w_y" }}, "readings": "{table}" }}"#
        );
        std::fs::write(at.join("c.campaign.json"), text).expect("a campaign");
        let (code, _, error) = run(at, &["fit", "c.campaign.json", "--json", "-"]);
        assert!(code == 1 && error.contains("has the name of something else"), "{titles}: {error}");
    }
}

/// A column of texts that a model line wants numbers of is no column that is not there: every door says so.
#[test]
fn texts_for_numbers() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    std::fs::write(at.join("t.csv"), "s,x,T,V\nA,0,warm,1\nA,1,warm,2\nA,2,cold,3.01\nA,3,cold,4\n").expect("a table");
    let bench = r#"{ "id": "line", "chain": [], "sensors": { "V": { "unit": "V", "model": "a + b*x + 0.01*T" } } }"#;
    for readings in [
        r#""t.csv""#,
        r#"[{ "x": 0, "T": "warm", "V": 1 }, { "x": 1, "T": "warm", "V": 2 }, { "x": 2, "T": "cold", "V": 3.01 }]"#,
        r#"{ "samples": "t.csv", "as": "rows" }"#,
    ] {
        let text = format!(r#"{{ "bench": {bench}, "estimate": {{ "a": {{}}, "b": {{}} }}, "readings": {readings} }}"#);
        std::fs::write(at.join("c.campaign.json"), text).expect("a campaign");
        let (code, _, error) = run(at, &["fit", "c.campaign.json"]);
        assert!(code == 1 && error.contains("not a number") && error.contains("'warm'"), "{readings}: {error}");
    }
    let (_, out, _) = run(at, &["fit", "c.campaign.json", "--readings", "t.csv", "--by", "s", "--to", "-"]);
    assert!(out.lines().nth(1).is_some_and(|row| row.contains("no number") || row.contains("not a number")), "{out}");
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
        ("temperature_c", "Temp (Deg F)", &|x| 1.8 * x + 32.0),
        ("temperature_c", "Temp (deg C)", &|x| x),
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
    assert!(error.contains("'furlong' is not a known unit"), "{error}");
    let error =
        solved(r#""temperature_c": "T (V)""#, "a + p*temperature_c", &table("T (V)", &|x| x)).expect_err("volts");
    assert!(error.contains("another dimension"), "{error}");
    // what stands in square brackets behind a name is its number
    let found = solved(r#""x": "gyro[0]""#, "a + p*x", &table("gyro[0]", &|x| x)).expect("an index");
    assert!((found[1] - 0.25).abs() < 1e-9, "{found:?}");
}

/// Small files as loggers and spreadsheets write them, each with the answer that its numbers have.
#[test]
fn files_by_their_names() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let solved = |sensor: &str, rest: &str| -> Vec<f64> {
        let text = format!(r#"{{ "bench": {{ "id": "q", "chain": [], "sensors": {{ {sensor} }} }}, {rest} }}"#);
        std::fs::write(at.join("c.campaign.json"), text).expect("a campaign");
        let (_, out, error) = run(at, &["fit", "c.campaign.json", "--json", "-"]);
        let report: serde_json::Value = serde_json::from_str(&out).unwrap_or_else(|_| panic!("{error}"));
        report["parameters"]
            .as_array()
            .expect("parameters")
            .iter()
            .map(|own| own["value"].as_f64().expect("a value"))
            .collect()
    };
    let near = |found: &[f64], truth: &[f64]| {
        found.len() == truth.len() && found.iter().zip(truth).all(|(a, b)| (a - b).abs() < 1e-10)
    };
    // hours, pascals and minutes beside millivolts; kelvin for degrees Celsius
    let mut hours = String::from("t / h,Y (mV),T\n");
    let mut pascals = String::from("p (Pa),t (min),Y (mV)\n");
    let (mut kelvin, mut celsius) = (String::from("Temp (K),Y\n"), String::from("T,Y\n"));
    for k in 0..10 {
        let (t, k) = (f64::from(k), f64::from(k * k));
        hours += &format!("{},{},{k}\n", t / 3600.0, 1000.0 * (1.0 + 0.001 * t + 0.02 * k));
        pascals += &format!("{},{},{}\n", 1000.0 * k, t / 60.0, 1000.0 * (1.0 + 0.001 * t + 0.01 * k));
        kelvin += &format!("{},{}\n", 273.15 + k, 1.0 + 0.01 * k);
        celsius += &format!("{k},{}\n", 1.0 + 0.01 * k);
    }
    for (name, text) in [("t3.csv", hours), ("t2.csv", pascals), ("kelvin.csv", kelvin), ("t.csv", celsius)] {
        std::fs::write(at.join(name), text).expect("a table");
    }
    let line = |model: &str| format!(r#""Y": {{ "unit": "V", "model": "{model}" }}"#);
    let three = r#""estimate": { "a": {}, "p": {}, "q": {} }"#;
    let minutes = format!(
        r#"{three}, "readings": "t3.csv", "columns": {{ "time_s": "t / h", "Y": "Y (mV)", "temperature_c": "T" }}"#
    );
    let found = solved(&line("a + q*time_s + p*temperature_c"), &minutes);
    assert!(near(&found, &[1.0, 0.02, 0.001]), "{found:?}");
    let pressure = format!(
        r#"{three}, "readings": "t2.csv", "columns": {{ "pressure_kpa": "p (Pa)", "time_s": "t (min)", "Y": "Y (mV)" }}"#
    );
    let found = solved(&line("a + p*pressure_kpa + q*time_s"), &pressure);
    assert!(near(&found, &[1.0, 0.01, 0.001]), "{found:?}");
    for (file, title) in [("kelvin.csv", "Temp (K)"), ("t.csv", "T")] {
        let rest = format!(
            r#""estimate": {{ "a": {{}}, "p": {{}} }}, "readings": "{file}", "columns": {{ "temperature_c": "{title}" }}"#
        );
        let found = solved(&line("a + p*temperature_c"), &rest);
        assert!(near(&found, &[1.0, 0.01]), "{file}: {found:?}");
    }
    // a unit that nobody knows in a column that a line of scatter alone reads
    std::fs::write(at.join("day.csv"), "x,Y,time_s (furlong)\n0,1,0\n1,2,1\n2,3.01,2\n3,4,3\n").expect("a table");
    let scatter = r#""estimate": { "a": {}, "b": {} }, "readings": "day.csv", "scatter": [ { "of": "Y", "over": "time_s", "tau": 10, "u": 0.1 } ]"#;
    let text =
        format!(r#"{{ "bench": {{ "id": "q", "chain": [], "sensors": {{ {} }} }}, {scatter} }}"#, line("a + b*x"));
    std::fs::write(at.join("c.campaign.json"), text).expect("a campaign");
    let (code, _, error) = run(at, &["fit", "c.campaign.json"]);
    let error = error.replace('\u{2502}', " ").split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(code == 1 && error.contains("'furlong' is not a known unit") && error.contains("known are"), "{error}");
    // serials with quotes, through the fit of many devices
    std::fs::write(at.join("quotes.csv"), "serial,x,y\n\"6\"\" rotor\",1,1\n\"6\"\" rotor\",2,2\nd,4,5\nd,5,7\n")
        .expect("a table");
    let text = r#"{ "bench": { "id": "b", "chain": [], "sensors": { "y": { "unit": "V", "model": "b0 + b1*x" } } },
        "estimate": { "b0": {}, "b1": {} }, "readings": "quotes.csv" }"#;
    std::fs::write(at.join("c.campaign.json"), text).expect("a campaign");
    let (_, out, error) = run(at, &["fit", "c.campaign.json", "--by", "serial", "--to", "-"]);
    let mut reader = csv::Reader::from_reader(out.as_bytes());
    let slope = reader.headers().expect("titles").iter().position(|title| title == "b1").expect("b1");
    let found: Vec<(String, f64)> = reader
        .records()
        .map(|row| row.map(|row| (row[0].to_string(), row[slope].parse().expect("a number"))).expect("a row"))
        .collect();
    assert!(found.len() == 2 && found[0].0 == "6\" rotor" && found[1].0 == "d", "{found:?} {error}");
    assert!((found[0].1 - 1.0).abs() < 1e-12 && (found[1].1 - 2.0).abs() < 1e-12, "{found:?}");
}
