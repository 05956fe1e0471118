//! Many devices through the program: one row each, whatever is wrong with some of them; files in place of the campaign's readings.

use assert_cmd::Command;
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

struct Run {
    code: i32,
    stdout: String,
    stderr: String,
}

fn run(folder: &Path, arguments: &[&str]) -> Run {
    let output =
        Command::cargo_bin("tumble").expect("the program").current_dir(folder).args(arguments).output().expect("a run");
    let text = |bytes| String::from_utf8(bytes).expect("UTF-8");
    Run { code: output.status.code().expect("no signal"), stdout: text(output.stdout), stderr: text(output.stderr) }
}

fn example() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/26-production-line")
}

/// Rows of a CSV by their first cell.
fn table(text: &str) -> BTreeMap<String, BTreeMap<String, String>> {
    let mut reader = csv::Reader::from_reader(text.as_bytes());
    let header = reader.headers().expect("a header").clone();
    reader
        .records()
        .map(|row| {
            let row = row.expect("a row");
            let cells = header.iter().zip(row.iter()).map(|(k, v)| (k.to_string(), v.to_string())).collect();
            (row[0].to_string(), cells)
        })
        .collect()
}

/// The same without the words, which say in which lines something is.
fn numbers(text: &str) -> BTreeMap<String, BTreeMap<String, String>> {
    let mut rows = table(text);
    rows.values_mut().for_each(|row| drop(row.remove("why")));
    rows
}

/// Estimates and u of the example against numpy's (tests/scripts/production_line.py); devices that are not in order say why.
#[test]
fn the_production_line_is_numpys() {
    let found = run(&example(), &["fit", "line.campaign.json"]);
    assert_eq!(found.code, 2, "{}", found.stderr);
    let rows = table(&found.stdout);
    assert_eq!(rows.len(), 40);
    let expected = table(&std::fs::read_to_string(example().join("expected.csv")).expect("a file"));
    assert_eq!(expected.len(), 38);
    for (serial, own) in &expected {
        for (name, value) in own.iter().filter(|(name, _)| *name != "serial") {
            let (a, b): (f64, f64) = (rows[serial][name].parse().expect("a number"), value.parse().expect("a number"));
            // numpy's QR of scaled columns, condition 10
            assert!(
                (a - b).abs()
                    <= 1e-12
                        * b.abs().max(own[&format!("{}_u", name.trim_end_matches("_u"))].parse::<f64>().expect("u")),
                "{serial} {name}: {a:e} for {b:e}"
            );
        }
    }
    let cell = |serial: &str, name: &str| rows[serial][name].as_str();
    assert_eq!(cell("G012", "suspects"), "21");
    assert_eq!((cell("G017", "schedule"), cell("G017", "readings")), ("own", "33"));
    assert_eq!((cell("G023", "schedule"), cell("G023", "verdict")), ("common", "accepted"));
    assert_eq!((cell("G031", "verdict"), cell("G031", "kI"), cell("G031", "rank")), ("rejected", "", "2"));
    assert!(cell("G031", "why").contains("not estimable"), "{}", cell("G031", "why"));
    assert_eq!(cell("G036", "verdict"), "malformed");
    let why = cell("G036", "why");
    assert!(why.contains("V is not a number (line ") && why.contains("readings.csv, V)"), "{why}");
}

/// CSV, JSON lines and Parquet have the same rows; the summary is in its JSON.
#[test]
fn rows_are_the_same_in_every_format() {
    let folder = tempfile::tempdir().expect("a folder");
    for name in ["line.campaign.json", "readings.csv"] {
        std::fs::copy(example().join(name), folder.path().join(name)).expect("a copy");
    }
    for to in ["d.csv", "d.jsonl", "d.parquet"] {
        let found =
            run(folder.path(), &["fit", "line.campaign.json", "--to", to, "--json", "s.json", "--html", "s.html"]);
        assert_eq!(found.code, 2, "{}", found.stderr);
        assert!(
            found.stdout.contains("40 devices by serial")
                && found.stdout.contains("2 of 40 devices are not accepted: 1 rejected"),
            "{}",
            found.stdout
        );
    }
    let csv = table(&std::fs::read_to_string(folder.path().join("d.csv")).expect("a file"));
    let lines = std::fs::read_to_string(folder.path().join("d.jsonl")).expect("a file");
    for line in lines.lines() {
        let row: Value = serde_json::from_str(line).expect("JSON");
        let own = &csv[row["serial"].as_str().expect("a serial number")];
        for (name, text) in own {
            match &row[name] {
                Value::Null => assert!(text.is_empty()),
                Value::String(other) => assert_eq!(other, text),
                number => assert_eq!(number.as_f64(), text.parse().ok(), "{name}"),
            }
        }
    }
    let mut record = tumble::record::Record::open(
        "d.parquet",
        std::fs::File::open(folder.path().join("d.parquet")).expect("a file"),
    )
    .expect("Parquet");
    let (serial, value) = (record.find("serial").expect("a column"), record.find("kI_u").expect("a column"));
    record.select(&[(serial, tumble::record::As::Label), (value, tumble::record::As::Number)]);
    let mut block = tumble::record::Block::default();
    let mut count = 0;
    while record.next(&mut block).expect("rows") {
        for (label, value) in block.columns[0].iter().zip(&block.columns[1]) {
            let text = &csv[&record.labels()[*label as usize]]["kI_u"];
            assert!(if text.is_empty() { value.is_nan() } else { text.parse() == Ok(*value) });
            count += 1;
        }
    }
    assert_eq!(count, 40);
    let summary: Value =
        serde_json::from_str(&std::fs::read_to_string(folder.path().join("s.json")).expect("a file")).expect("JSON");
    assert_eq!((&summary["devices"]["all"], &summary["report"]), (&40.into(), &"batch".into()));
    assert_eq!(summary["lots"].as_array().map(Vec::len), Some(4));
    let page = std::fs::read_to_string(folder.path().join("s.html")).expect("a page");
    assert!(page.contains("40 devices") && page.contains("Control charts") && page.contains("<svg"));
}

/// Devices that are not in order or stand apart have pages of their own, to which the summary leads, from where it lies.
#[test]
fn devices_that_are_not_in_order_have_pages() {
    let folder = tempfile::tempdir().expect("a folder");
    for name in ["line.campaign.json", "readings.csv"] {
        std::fs::copy(example().join(name), folder.path().join(name)).expect("a copy");
    }
    let pages =
        ["fit", "line.campaign.json", "--to", "d.csv", "--html", "line.html", "--md", "line.md", "--json", "line.json"];
    let found = run(folder.path(), &[&pages[..], &["--reports", "of devices/1"]].concat());
    assert_eq!(found.code, 2, "{}", found.stderr);
    let report: Value =
        serde_json::from_str(&std::fs::read_to_string(folder.path().join("line.json")).expect("a file")).expect("JSON");
    let listed: Vec<(&str, &str)> = report["not_in_order"]
        .as_array()
        .expect("a list")
        .iter()
        .map(|own| (own["device"].as_str().expect("a text"), own["verdict"].as_str().expect("a text")))
        .collect();
    // G025 is accepted, and its limits leave it undecided
    assert_eq!(listed, [("G036", "malformed"), ("G031", "rejected"), ("G025", "accepted")]);
    let page = std::fs::read_to_string(folder.path().join("line.html")).expect("a page");
    let markdown = std::fs::read_to_string(folder.path().join("line.md")).expect("a page");
    // G012, which has a bad reading, scatters more than the others; what is malformed has no fit to be shown
    for (serial, says) in [("G031", "NOT ESTIMABLE"), ("G012", "G012")] {
        assert!(page.contains(&format!("<a href=\"of%20devices/1/{serial}.html\">{serial}</a>")), "{serial}");
        assert!(markdown.contains(&format!("[{serial}](of%20devices/1/{serial}.html)")), "{serial}");
        let own = std::fs::read_to_string(folder.path().join(format!("of devices/1/{serial}.html"))).expect("a page");
        assert!(own.contains(&format!("<title>{serial}: ")), "{serial}");
        assert!(own.to_uppercase().contains(&says.to_uppercase()), "{serial}");
    }
    assert!(page.contains("G036") && !page.contains("G036.html"));
    assert_eq!(std::fs::read_dir(folder.path().join("of devices/1")).expect("a folder").count(), 3);
    let alone = r#"{ "bench": { "id": "l", "sensors": { "y": { "model": "a" } } }, "estimate": { "a": {} }, "readings": [ { "y": 1 } ] }"#;
    std::fs::write(folder.path().join("one.campaign.json"), alone).expect("a file");
    let refused = run(folder.path(), &["fit", "one.campaign.json", "--reports", "pages"]);
    assert_eq!(refused.code, 1);
    assert!(refused.stderr.contains("--reports applies to many devices"), "{}", refused.stderr);
}

/// A serial number that comes back later in the file is the same device, and the rows are those of the sorted file.
#[test]
fn a_device_that_comes_back_is_one_device() {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::copy(example().join("line.campaign.json"), folder.path().join("line.campaign.json")).expect("a copy");
    let text = std::fs::read_to_string(example().join("readings.csv")).expect("a file");
    let (header, rows) = text.split_once('\n').expect("a header");
    let rows: Vec<&str> = rows.lines().collect();
    let mut mixed = vec![header];
    // every third row first, so that no device stands together; the order within each stays
    let by_device: BTreeMap<&str, Vec<&&str>> = rows.iter().fold(BTreeMap::new(), |mut of, row| {
        of.entry(&row[..4]).or_insert_with(Vec::new).push(row);
        of
    });
    for k in 0..36 {
        mixed.extend(by_device.values().filter_map(|rows| rows.get(k)).map(|row| **row));
    }
    std::fs::write(folder.path().join("readings.csv"), mixed.join("\n") + "\n").expect("a file");
    let mixed = run(folder.path(), &["fit", "line.campaign.json"]);
    assert!(mixed.stderr.contains("occurs again"), "{}", mixed.stderr);
    let sorted = run(&example(), &["fit", "line.campaign.json"]);
    assert_eq!(numbers(&mixed.stdout), numbers(&sorted.stdout));
    // and in a file, which is begun anew under the same name
    let to = run(folder.path(), &["fit", "line.campaign.json", "--to", "d.csv"]);
    assert_eq!(to.code, 2, "{}", to.stderr);
    assert_eq!(
        numbers(&std::fs::read_to_string(folder.path().join("d.csv")).expect("a file")),
        numbers(&sorted.stdout)
    );
}

/// A file of readings in place of the campaign's; several are a device each; a column that repeats the schedule is noticed.
#[test]
fn files_of_readings_replace_the_campaigns() {
    let folder = tempfile::tempdir().expect("a folder");
    let campaign = r#"{ "bench": { "id": "line", "sensors": { "y": { "unit": "mm", "model": "a + b*x" } } }, "estimate": { "a": {}, "b": {} },
        "readings": [ {"x": 0, "y": 1}, {"x": 1, "y": 3}, {"x": 2, "y": 4} ] }"#;
    std::fs::write(folder.path().join("c.campaign.json"), campaign).expect("a file");
    for (name, shift) in [("one.csv", 0.0), ("two.csv", 10.0)] {
        let rows: Vec<String> =
            (0..4).map(|x| format!("{x},{}", shift + 2.0 * f64::from(x) + [0.0, 0.1, -0.1, 0.0][x as usize])).collect();
        std::fs::write(folder.path().join(name), format!("x,y\n{}\n", rows.join("\n"))).expect("a file");
    }
    let single = run(folder.path(), &["fit", "c.campaign.json", "--readings", "two.csv", "--json", "-"]);
    let report: Value = serde_json::from_str(&single.stdout).expect("JSON");
    // the straight line through (0, 10), (1, 12.1), (2, 13.9), (3, 16): slope 1.98, intercept 10.03
    assert!((report["parameters"][0]["value"].as_f64().expect("a value") - 10.03).abs() < 1e-12);
    assert_eq!(report["inputs"].as_array().map(Vec::len), Some(2));
    let both = run(folder.path(), &["fit", "c.campaign.json", "--readings", "*.csv"]);
    let rows = table(&both.stdout);
    assert_eq!(rows.keys().collect::<Vec<_>>(), ["one.csv", "two.csv"]);
    assert!((rows["two.csv"]["b"].parse::<f64>().expect("a number") - 1.98).abs() < 1e-12);
    // one table, nobody says that it has two devices
    let text = "serial,x,y\nA,0,1\nA,1,3\nA,2,4\nB,0,2\nB,1,4\nB,2,5\n";
    std::fs::write(folder.path().join("both.csv"), text).expect("a file");
    let warned = run(folder.path(), &["fit", "c.campaign.json", "--readings", "both.csv"]);
    assert!(warned.stderr.contains("'serial' repeats the schedule for 2 labels"), "{}", warned.stderr);
    let by = run(folder.path(), &["fit", "c.campaign.json", "--readings", "both.csv", "--by", "serial"]);
    assert!(by.stderr.is_empty() && table(&by.stdout).len() == 2, "{}", by.stderr);
    let none = run(folder.path(), &["fit", "c.campaign.json", "--readings", "no-*.csv"]);
    assert!(none.code == 1 && none.stderr.contains("no file is called"), "{}", none.stderr);
    let column = run(folder.path(), &["fit", "c.campaign.json", "--readings", "both.csv", "--by", "sn"]);
    assert!(column.code == 1 && column.stderr.contains("no column 'sn'"), "{}", column.stderr);
}

/// Readings in the campaign itself; a model that is not linear is iterated for each device.
#[test]
fn devices_in_the_campaign_itself() {
    let folder = tempfile::tempdir().expect("a folder");
    let readings: Vec<String> = ["P", "Q"]
        .iter()
        .enumerate()
        .flat_map(|(k, serial)| {
            (0..6).map(move |t| {
                let y = (2.0 + k as f64) * (-0.3 * f64::from(t)).exp();
                format!(r#"{{ "serial": "{serial}", "time_s": {t}, "y": {y} }}"#)
            })
        })
        .collect();
    let campaign = format!(
        r#"{{ "bench": {{ "id": "decay", "sensors": {{ "y": {{ "unit": "V", "model": "A*exp(-r*time_s)" }} }} }},
            "estimate": {{ "A": {{ "start": 1 }}, "r": {{ "start": 0.1 }} }}, "by": "serial", "readings": [ {} ] }}"#,
        readings.join(", ")
    );
    std::fs::write(folder.path().join("c.campaign.json"), campaign).expect("a file");
    let rows = table(&run(folder.path(), &["fit", "c.campaign.json"]).stdout);
    for (serial, a) in [("P", 2.0), ("Q", 3.0)] {
        let value = |name: &str| rows[serial][name].parse::<f64>().expect("a number");
        assert!((value("A") - a).abs() < 1e-9 && (value("r") - 0.3).abs() < 1e-9, "{:?}", rows[serial]);
        assert_eq!(rows[serial]["schedule"], "own");
    }
}

/// A device of three has an effect that the model misses: its row names it, and the count says one.
#[test]
fn a_diagnosis_says_which_device_has_which_effect() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut text = String::from("serial,gamma_deg_s,V,V_u\n");
    for (k, serial) in ["A", "B", "C"].iter().enumerate() {
        for i in 0..24 {
            let x = 10.0 * (f64::from(i % 8) - 3.5);
            let noise = 1e-3 * ((f64::from(i) * 12.9898 + k as f64 * 78.233).sin() * 43_758.545).fract();
            let y = 1.0 + 0.05 * x + if *serial == "B" { 2e-5 * x * x } else { 0.0 } + noise;
            text += &format!("{serial},{x},{y},0.0006\n");
        }
    }
    std::fs::write(folder.path().join("r.csv"), text).expect("a file");
    let campaign = r#"{ "bench": { "id": "table", "units": { "rate": "deg/s" }, "chain": [ { "joint": "gamma", "about": "z" } ],
        "sensors": { "V": { "unit": "V", "axes": { "I": "z" }, "model": "V0 + kI*w_I" } } }, "estimate": { "V0": {}, "kI": {} }, "readings": "r.csv" }"#;
    std::fs::write(folder.path().join("c.campaign.json"), campaign).expect("a file");
    let found = run(folder.path(), &["diagnose", "c.campaign.json", "--by", "serial"]);
    assert_eq!(found.code, 2, "{}", found.stderr);
    let rows = table(&found.stdout);
    assert_eq!((rows["A"]["effects"].as_str(), rows["C"]["effects"].as_str()), ("0", "0"), "{}", found.stdout);
    assert_eq!((rows["B"]["effects"].as_str(), rows["B"]["regressors"].as_str()), ("1", "w_I^2"), "{}", found.stdout);
    assert!(found.stderr.contains("3 devices by serial"), "{}", found.stderr);
    // the same rows in columns
    let found = run(folder.path(), &["diagnose", "c.campaign.json", "--by", "serial", "--to", "e.parquet"]);
    assert_eq!(found.code, 2, "{}", found.stderr);
    let file = std::fs::File::open(folder.path().join("e.parquet")).expect("a file");
    let mut record = tumble::record::Record::open("e.parquet", file).expect("Parquet");
    let [serial, effects, terms] = ["serial", "effects", "regressors"].map(|name| record.find(name).expect("a column"));
    use tumble::record::As;
    record.select(&[(serial, As::Label), (effects, As::Number), (terms, As::Label)]);
    let mut block = tumble::record::Block::default();
    assert!(record.next(&mut block).expect("rows"));
    let label = |k: usize, row: usize| record.labels()[block.columns[k][row] as usize].as_str();
    assert_eq!([0, 1, 2].map(|row| label(0, row)), ["A", "B", "C"]);
    assert_eq!(block.columns[1], [0.0, 1.0, 0.0]);
    assert_eq!(label(2, 1), "w_I^2");
}

/// What takes all readings as one device's says so, or refuses, rather than passing over "by" in silence.
#[test]
fn where_devices_are_not_told_apart_that_is_said() {
    let folder = tempfile::tempdir().expect("a folder");
    let campaign = r#"{ "bench": { "id": "line", "sensors": { "y": { "unit": "V", "model": "a + b*x" } } }, "estimate": { "a": {}, "b": {} },
        "by": "serial", "readings": [ { "x": 0, "y": 1, "y_u": 0.1 }, { "x": 1, "y": 3, "y_u": 0.1 }, { "x": 2, "y": 4, "y_u": 0.1 } ] }"#;
    std::fs::write(folder.path().join("c.campaign.json"), campaign).expect("a file");
    let compared = run(folder.path(), &["compare", "c.campaign.json"]);
    assert_eq!(compared.code, 1);
    assert!(compared.stderr.contains("closed forms are compared for one device"), "{}", compared.stderr);
    let planned = run(folder.path(), &["plan", "c.campaign.json"]);
    let told = planned.stderr.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(told.contains("all positions are taken as those of one device"), "{told}");
}

/// Every device whose conformity is undecided is named.
#[test]
fn undecided_devices_are_named() {
    let folder = tempfile::tempdir().expect("a folder");
    let readings: Vec<String> = [("A", 0.0), ("B", 1.9), ("C", -1.9), ("D", 1.95)]
        .iter()
        .flat_map(|(serial, y)| (0..2).map(move |_| format!(r#"{{"serial": "{serial}", "y": {y}, "y_u": 0.3}}"#)))
        .collect();
    let text = format!(
        r#"{{"bench": {{"id": "mean", "sensors": {{"y": {{"model": "a"}}}}}}, "estimate": {{"a": {{}}}}, "by": "serial", "decision": "guard-u",
            "limits": {{"a": [-2, 2]}}, "readings": [{}]}}"#,
        readings.join(",")
    );
    std::fs::write(folder.path().join("all.campaign.json"), text).expect("a file");
    let found = run(folder.path(), &["fit", "all.campaign.json", "--json", "all.json"]);
    assert!(found.code != 1, "{}", found.stderr);
    let report: Value =
        serde_json::from_str(&std::fs::read_to_string(folder.path().join("all.json")).expect("a file")).expect("JSON");
    assert_eq!(report["conformity"]["undecided"], 3);
    let named: Vec<&str> =
        report["not_in_order"].as_array().expect("a list").iter().filter_map(|own| own["device"].as_str()).collect();
    assert_eq!(named, ["B", "C", "D"]);
}

/// A campaign `V = a + b*x` by serial over `r.csv`, in a folder of its own.
fn line_campaign(text: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    let campaign = r#"{ "bench": { "id": "line", "sensors": { "V": { "unit": "V", "model": "a + b*x" } } }, "estimate": { "a": {}, "b": {} },
        "by": "serial", "readings": "r.csv" }"#;
    std::fs::write(folder.path().join("c.campaign.json"), campaign).expect("a file");
    std::fs::write(folder.path().join("r.csv"), text).expect("a file");
    folder
}

/// Rows `serial,x,V,V_u` of a device: a straight line with reproducible noise of the stated u, a rectangular distribution.
fn device_rows(serial: &str, seed: u32, count: u32) -> Vec<String> {
    let mut state = u64::from(seed).wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1;
    (0..count)
        .map(|i| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            let noise = ((state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5) * 12_f64.sqrt() * 1e-3;
            let x = f64::from(i) - 3.5;
            format!("{serial},{x},{},0.001", 1.0 + 0.25 * x + noise)
        })
        .collect()
}

const HEAD: &str = "serial,x,V,V_u\n";

/// What is wrong with a row is that device's fault, and says file and line; all others have the rows of a table without it.
#[test]
fn a_row_that_is_wrong_is_its_devices_fault() {
    let clean: Vec<Vec<String>> =
        (0..6).map(|k| device_rows(&format!("D{k}"), k + 1, 8)).chain([device_rows("D6", 7, 7)]).collect();
    let mut rows = clean.clone();
    // D1: a row with too few cells; D2: one with too many; D3: a text; D4: the device twice; D5: an empty cell
    rows[1][3] = "D1,4".into();
    rows[2][5] += ",7,7";
    rows[3][0] = "D3,0,over,0.001".into();
    rows[4] = clean[4].iter().flat_map(|row| [row.clone(), row.clone()]).collect();
    rows[5][2] = "D5,-1.5,,0.001".into();
    // and two rows of nobody amid D6, the second with a blank for a serial
    rows[6].insert(2, ",0.5,3,0.001".into());
    rows[6].insert(5, " ,0.5,3,0.001".into());
    let text = format!("{HEAD}{}\n", rows.concat().join("\n"));
    let line = |row: &str| 1 + text.lines().position(|own| own == row).expect("the row");
    let folder = line_campaign(&text);
    let found = run(folder.path(), &["fit", "c.campaign.json"]);
    assert_eq!(found.code, 2, "{}", found.stderr);
    let own = table(&found.stdout);
    let without = rows[5].iter().filter(|row| !row.contains(",,")).cloned().collect::<Vec<_>>();
    let expected = [clean[0].clone(), without, clean[6].clone()].concat().join("\n");
    let cleaned = line_campaign(&format!("{HEAD}{expected}\n"));
    let cleaned = table(&run(cleaned.path(), &["fit", "c.campaign.json"]).stdout);
    for serial in ["D0", "D5", "D6"] {
        for cell in ["verdict", "a", "a_u", "b", "b_u", "readings", "chi_square_p", "why"] {
            assert_eq!(own[serial][cell], cleaned[serial][cell], "{serial} {cell}");
        }
    }
    for (serial, row, word) in [
        ("D1", &rows[1][3], "too few or too many cells"),
        ("D2", &rows[2][5], "too few or too many cells"),
        ("D3", &rows[3][0], "not a number"),
    ] {
        let why = &own[serial]["why"];
        assert_eq!(own[serial]["verdict"], "malformed", "{why}");
        assert!(
            why.contains(&format!("line {} of ", line(row))) && why.contains("r.csv") && why.contains(word),
            "{why}"
        );
    }
    assert!(own["D4"]["why"].contains("every row occurs 2 times"), "{}", own["D4"]["why"]);
    let nobody = &own[""];
    assert_eq!(nobody["verdict"], "malformed");
    assert!(nobody["why"].contains("2 rows have no label"), "{}", nobody["why"]);
    assert!(nobody["why"].contains(&format!("line {} of ", line(&rows[6][2]))), "{}", nobody["why"]);
    assert!(!found.stderr.contains("occurs again"), "{}", found.stderr);
}

/// A row of a label alone, and one whose quote is never closed, are rows with too few cells: with many devices that is the device's fault, of one device the table's.
#[test]
fn a_row_that_is_cut_off_is_no_remark() {
    let mut rows: Vec<Vec<String>> = (0..4).map(|k| device_rows(&format!("D{k}"), k + 1, 8)).collect();
    rows[1][3] = "D1".into();
    rows[2][5] = "D2,,".into();
    rows[3][7] = format!("\"{}", rows[3][7]);
    let text = format!("{HEAD}{}\n", rows.concat().join("\n"));
    let found = run(line_campaign(&text).path(), &["fit", "c.campaign.json"]);
    assert_eq!(found.code, 2, "{}", found.stderr);
    let own = table(&found.stdout);
    assert_eq!(own["D0"]["verdict"], "accepted");
    // the title is line 1; eight rows of each device
    for (serial, line) in [("D1", 1 + 8 + 4), ("D2", 1 + 16 + 6)] {
        let why = &own[serial]["why"];
        assert_eq!(own[serial]["verdict"], "malformed", "{why}");
        assert!(why.contains("too few") && why.contains(&format!("line {line} of ")), "{why}");
    }
    let said = |own: &BTreeMap<String, String>| own["verdict"] == "malformed" && own["why"].contains("line 33 of ");
    assert!(own.values().any(said), "{}", found.stdout);
    // of one device: no line of the table is passed over
    for row in ["D0", "D0,", "\"D0,0.5,1.125,0.001", "0.5;1.125;0.001"] {
        let text = format!("{HEAD}{}\n{row}\n{}\n", rows[0][..4].join("\n"), rows[0][4..].join("\n"));
        let folder = line_campaign(&text);
        let campaign = std::fs::read_to_string(folder.path().join("c.campaign.json")).expect("a campaign");
        std::fs::write(folder.path().join("c.campaign.json"), campaign.replace("\"by\": \"serial\",", ""))
            .expect("a file");
        let found = run(folder.path(), &["fit", "c.campaign.json"]);
        assert!(found.code == 1 && found.stderr.contains("r.csv:6"), "{row}: {}", found.stderr);
    }
}

/// A last row that is cut off is its device's fault, too, in whatever way the table is read.
#[test]
fn a_table_that_ends_in_a_row_says_so() {
    let rows = [device_rows("A", 1, 8), device_rows("B", 2, 8)].concat().join("\n");
    let folder = line_campaign(&format!("{HEAD}{rows}\nB,1"));
    let own = table(&run(folder.path(), &["fit", "c.campaign.json"]).stdout);
    assert_eq!((own["A"]["verdict"].as_str(), own["B"]["verdict"].as_str()), ("accepted", "malformed"));
    assert!(own["B"]["why"].contains("line 18 of "), "{}", own["B"]["why"]);
}

/// Labels that differ in blanks alone are one device, and that is said; quoted or not.
#[test]
fn labels_with_blanks_are_said_to_be_one() {
    for blank in [" 1", "\" 1\"", "1 "] {
        let mut rows = device_rows("1", 1, 8);
        rows[4] = rows[4].replacen('1', blank, 1);
        let folder = line_campaign(&format!("{HEAD}{}\n", [rows, device_rows("2", 2, 8)].concat().join("\n")));
        let found = run(folder.path(), &["fit", "c.campaign.json"]);
        let own = table(&found.stdout);
        assert_eq!((own.len(), own["1"]["readings"].as_str()), (2, "8"), "{}", found.stdout);
        assert!(found.stderr.contains("'1' differ only in blanks"), "{blank}: {}", found.stderr);
    }
    let plain = line_campaign(&format!("{HEAD}{}\n", device_rows("  1", 1, 8).join("\n")));
    assert!(run(plain.path(), &["fit", "c.campaign.json"]).stderr.is_empty());
}

/// A channel that reads one value whatever the input is not accepted, alone as with `--by`, and its u is that of its last decimal place.
#[test]
fn a_stuck_channel_is_not_accepted() {
    for value in ["0.5", "0.123", "1", "0.5123", "-3.25", "0", "1234567.5"] {
        for stated in [false, true] {
            let u = if stated { ",0.001" } else { "," };
            let mut rows = device_rows("fine", 1, 9);
            rows.iter_mut().for_each(|row| *row = row.trim_end_matches(",0.001").to_string() + u);
            let stuck: Vec<String> = (0..9).map(|i| format!("stuck,{},{value}{u}", f64::from(i) - 3.5)).collect();
            // the same schedule twice is solved together, one row less by itself
            let other: Vec<String> = stuck.iter().skip(1).map(|row| row.replace("stuck", "other")).collect();
            let folder = line_campaign(&format!("{HEAD}{}\n", [rows, stuck.clone(), other].concat().join("\n")));
            let found = run(folder.path(), &["fit", "c.campaign.json"]);
            let own = table(&found.stdout);
            assert_eq!(own["fine"]["verdict"], "accepted", "{:?}", own["fine"]);
            for serial in ["stuck", "other"] {
                assert_eq!(own[serial]["verdict"], "rejected", "{:?}", own[serial]);
                assert!(own[serial]["why"].contains(&format!("every reading of V is {value}")), "{:?}", own[serial]);
            }
            let text = format!("{HEAD}{}\n", stuck.join("\n"));
            std::fs::write(folder.path().join("one.csv"), text).expect("a file");
            let campaign = std::fs::read_to_string(folder.path().join("c.campaign.json")).expect("a file");
            let campaign = campaign.replace("\"by\": \"serial\",", "").replace("r.csv", "one.csv");
            std::fs::write(folder.path().join("one.campaign.json"), campaign).expect("a file");
            let alone = run(folder.path(), &["fit", "one.campaign.json", "--json", "-"]);
            let report: Value = serde_json::from_str(&alone.stdout).expect("JSON");
            assert_eq!(alone.code, 2, "{}", alone.stderr);
            let u: f64 = report["parameters"][0]["u"].as_f64().expect("u");
            let by: f64 = own["stuck"]["a_u"].parse().expect("u");
            assert!((u - by).abs() <= 1e-9 * u, "{value}: {u:e} alone, {by:e} by serial");
            if !stated {
                // half a unit of the last place over sqrt 3; x has the mean 0.5 and the sum of squares 60 about it
                let places = value.split_once('.').map_or(0, |(_, decimals)| decimals.len());
                let own = 10f64.powi(-(places as i32)) / 12f64.sqrt() * (1.0 / 9.0 + 0.25 / 60.0_f64).sqrt();
                assert!((u - own).abs() <= 1e-6 * own, "{value}: {u:e} for {own:e}");
            }
        }
    }
}

/// Many rejections are set against those that chance makes, and the worst are listed, whatever the order of the table.
#[test]
fn chance_and_the_worst() {
    let count = 240_u32;
    let mut rows = Vec::new();
    for k in 0..count {
        let mut own = device_rows(&format!("D{k}"), 1000 + k, 8);
        if k % 2 == 0 {
            // a shift of one reading by 3 to 240 times its u
            let shifted = format!("D{k},-3.5,{},0.001", 0.125 + 0.003 * f64::from(k + 1) / 3.0);
            own[0] = shifted;
        }
        rows.extend(own);
    }
    let folder = line_campaign(&format!("{HEAD}{}\n", rows.join("\n")));
    let found =
        run(folder.path(), &["fit", "c.campaign.json", "--json", "s.json", "--to", "d.csv", "--html", "s.html"]);
    assert_eq!(found.code, 2, "{}", found.stderr);
    let own = table(&std::fs::read_to_string(folder.path().join("d.csv")).expect("a file"));
    let report: Value =
        serde_json::from_str(&std::fs::read_to_string(folder.path().join("s.json")).expect("a file")).expect("JSON");
    let p: Vec<f64> = own.values().map(|row| row["chi_square_p"].parse().expect("p")).collect();
    let chance = &report["chance"]["global-test"];
    assert_eq!(chance["tested"], count);
    assert!((chance["expected"].as_f64().expect("a number") - 0.05 * f64::from(count)).abs() < 1e-9);
    assert_eq!(chance["found"], p.iter().filter(|p| **p < 0.05).count());
    let single = 1.0 - 0.95_f64.powf(1.0 / f64::from(count));
    assert_eq!(chance["beyond"], p.iter().filter(|p| **p < single).count());
    assert_eq!(report["reasons"]["global-test"], chance["found"]);
    let listed: Vec<f64> = report["not_in_order"]
        .as_array()
        .expect("a list")
        .iter()
        .map(|row| own[row["device"].as_str().expect("a text")]["chi_square_p"].parse().expect("p"))
        .collect();
    assert_eq!(listed.len(), 100);
    assert!(listed.is_sorted(), "{listed:?}");
    let mut all = p.clone();
    all.sort_by(f64::total_cmp);
    assert!(listed.last() <= all.get(100), "{:?} listed, {:?} left out", listed.last(), all.get(100));
    let line = found
        .stdout
        .lines()
        .find(|line| line.contains("global test failed"))
        .unwrap_or_else(|| panic!("{}", found.stdout));
    let expected = format!("{:.0}", 0.05 * f64::from(count));
    assert!(line.split_whitespace().any(|cell| cell == expected), "{line}");
    assert!(std::fs::read_to_string(folder.path().join("s.html")).expect("a page").contains("The first 100 of "));
}

/// Rows in any order, in one file or two, are those of the sorted table: turn by turn, shuffled, in two sittings.
#[test]
fn the_order_of_the_table_does_not_matter() {
    let devices = 700_usize;
    let of: Vec<Vec<String>> =
        (0..devices).map(|k| device_rows(&format!("D{k}"), 50 + k as u32, 8 + k as u32 % 3)).collect();
    let sorted = line_campaign(&format!("{HEAD}{}\n", of.concat().join("\n")));
    let expected = numbers(&run(sorted.path(), &["fit", "c.campaign.json"]).stdout);
    assert_eq!(expected.len(), devices);
    let turns: Vec<String> = (0..10).flat_map(|i| of.iter().filter_map(move |own| own.get(i).cloned())).collect();
    let sittings = [
        of.iter().flat_map(|own| own[..4].to_vec()).collect::<Vec<_>>(),
        of.iter().flat_map(|own| own[4..].to_vec()).collect(),
    ];
    for (what, files) in [("turns", vec![turns]), ("sittings", vec![sittings.concat()]), ("files", sittings.to_vec())] {
        let folder = line_campaign("");
        let names: Vec<String> = (0..files.len()).map(|k| format!("f{k}.csv")).collect();
        for (name, rows) in names.iter().zip(&files) {
            std::fs::write(folder.path().join(name), format!("{HEAD}{}\n", rows.join("\n"))).expect("a file");
        }
        let mut arguments = vec!["fit", "c.campaign.json", "--readings"];
        arguments.extend(names.iter().map(String::as_str));
        let found = run(folder.path(), &arguments);
        assert_eq!(numbers(&found.stdout), expected, "{what}: {}", found.stderr);
    }
}

/// A scale factor that follows a column of the model line is named, whatever the column is called.
#[test]
fn products_with_every_column_of_the_line() {
    for column in ["temperature_c", "warm_c", "p_hpa", "zeta"] {
        let folder = tempfile::tempdir().expect("a folder");
        let mut text = format!("serial,gamma_deg_s,{column},V,V_u\n");
        for device in 0..4_u32 {
            let noise = device_rows("", 77 + device, 40);
            for (i, row) in (0..40_u32).zip(&noise) {
                // what is left of the straight line of `device_rows`
                let cells: Vec<f64> = row.split(',').skip(1).map(|cell| cell.parse().expect("a number")).collect();
                let noise = cells[1] - 1.0 - 0.25 * cells[0];
                let (x, c) = (20.0 * (f64::from(i % 8) - 3.5), 10.0 * (f64::from(i / 8) - 2.0));
                // u of this product is 0.001 / sqrt(sum (x c)^2) = 2.4e-7
                let product = if device % 2 == 0 { 1e-5 * x * c } else { 0.0 };
                text += &format!("D{device},{x},{c},{},0.001\n", 0.5 + 0.02 * x + 0.003 * c + product + noise);
            }
        }
        std::fs::write(folder.path().join("r.csv"), text).expect("a file");
        let campaign = format!(
            r#"{{ "bench": {{ "id": "table", "units": {{ "rate": "deg/s" }}, "chain": [ {{ "joint": "gamma", "about": "z" }} ], "sensors":
                {{ "V": {{ "unit": "V", "axes": {{ "I": "z" }}, "model": "V0 + kI*w_I + c*{column}" }} }} }},
                "estimate": {{ "V0": {{}}, "kI": {{}}, "c": {{}} }}, "by": "serial", "readings": "r.csv" }}"#
        );
        std::fs::write(folder.path().join("c.campaign.json"), campaign).expect("a file");
        let found = run(folder.path(), &["diagnose", "c.campaign.json"]);
        let rows = table(&found.stdout);
        let mut factors = [column, "w_I"];
        factors.sort_unstable();
        for (serial, row) in &rows {
            let expected = if serial == "D0" || serial == "D2" { factors.join("*") } else { String::new() };
            assert_eq!(row["regressors"], expected, "{column} {serial}: {row:?} {}", found.stderr);
        }
        assert_eq!(rows.len(), 4);
    }
}

/// A pattern that the shell has left fits names as the shell has it.
#[test]
fn patterns_fit_as_a_shell_has_them() {
    let folder = tempfile::tempdir().expect("a folder");
    let campaign = r#"{ "bench": { "id": "line", "sensors": { "y": { "model": "a + b*x" } } }, "estimate": { "a": {}, "b": {} }, "readings": [] }"#;
    std::fs::write(folder.path().join("c.campaign.json"), campaign).expect("a file");
    let names = [
        "a.csv",
        "a.csv.old",
        "b.csv",
        "run1-ab.csv",
        "run2-.csv",
        "run-ab.csv",
        "run12-a.csv",
        "aXXbYYbZc",
        "abc",
        "aXXbYYbZ",
        "ab",
        ".h.csv",
    ];
    for name in names {
        std::fs::write(folder.path().join(name), "x,y\n0,1\n1,3\n2,4\n").expect("a file");
    }
    for (pattern, expected) in [
        ("?.csv", vec!["a.csv", "b.csv"]),
        ("*.csv", vec!["a.csv", "b.csv", "run-ab.csv", "run1-ab.csv", "run12-a.csv", "run2-.csv"]),
        ("run?-*.csv", vec!["run1-ab.csv", "run2-.csv"]),
        ("a*b*c", vec!["aXXbYYbZc", "abc"]),
    ] {
        let found = run(folder.path(), &["fit", "c.campaign.json", "--readings", pattern]);
        let rows = table(&found.stdout);
        assert_eq!(rows.keys().collect::<Vec<_>>(), expected, "{pattern}: {}", found.stderr);
    }
}

/// A spreadsheet runs what begins like a formula: it stands behind an apostrophe. A number that begins so is none.
#[test]
fn texts_are_no_formulas() {
    let folder = tempfile::tempdir().expect("a folder");
    let campaign = r#"{ "bench": { "id": "mean", "sensors": { "y": { "model": "m" } } }, "estimate": { "m": {} }, "readings": [] }"#;
    std::fs::write(folder.path().join("c.campaign.json"), campaign).expect("a file");
    let labels = ["=1+1", "+A1", "-x", "@SUM(A1)", "=HYPERLINK(\"a\",1)", "-12", "+1e3", "SN-1", "a=b"];
    let mut writer = csv::Writer::from_path(folder.path().join("t.csv")).expect("a file");
    writer.write_record(["serial", "y"]).expect("a row");
    for label in labels {
        for value in ["1.0", "2.0", "4.0"] {
            writer.write_record([label, value]).expect("a row");
        }
    }
    writer.flush().expect("a file");
    let found = run(folder.path(), &["fit", "c.campaign.json", "--readings", "t.csv", "--by", "serial"]);
    for label in labels {
        let is_formula = label.starts_with(['=', '+', '-', '@']) && label.parse::<f64>().is_err();
        let cell = match is_formula {
            true => format!("\n\"'{}\",", label.replace('"', "\"\"")),
            false => format!("\n{label},"),
        };
        assert!(found.stdout.contains(&cell), "{cell:?} is not in {}", found.stdout);
    }
}

/// A column that control charts are drawn over by itself is a column of the readings, too: scatter per day or lot, and a model line that uses it, give each device what it
/// has alone.
#[test]
fn columns_of_charts_are_columns_of_the_readings() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut text = String::from("serial,day,lot,x,V\n");
    let mut alone = String::new();
    for device in 0..3 {
        for k in 0..24 {
            let (day, x) = (k / 6, f64::from(k % 6));
            // a deviation of each day and a small one of each reading
            let own = [0.3, -0.2, 0.1, -0.15][day as usize] + 0.01 * f64::from((7 * k + device) % 5 - 2);
            let row = format!("{day},L{day},{x},{}\n", 1.0 + f64::from(device) + 2.0 * x + own);
            text.push_str(&format!("d{device},{row}"));
            if device == 1 {
                alone.push_str(&format!("d1,{row}"));
            }
        }
    }
    std::fs::write(folder.path().join("all.csv"), &text).expect("a file");
    std::fs::write(folder.path().join("one.csv"), format!("serial,day,lot,x,V\n{alone}")).expect("a file");
    for (name, model, per) in [("day", "c + k*x", "day"), ("lot", "c + k*x", "lot"), ("line", "c + k*x + 0*day", "lot")]
    {
        let campaign = |readings: &str, by: &str| {
            format!(
                r#"{{ "bench": {{ "id": "b", "sensors": {{ "V": {{ "unit": "V", "model": "{model}" }} }} }}, "estimate": {{ "c": {{}}, "k": {{}} }},
                    "scatter": [{{ "of": "c", "per": "{per}", "u": "estimate" }}], {by} "readings": "{readings}" }}"#
            )
        };
        std::fs::write(folder.path().join("all.campaign.json"), campaign("all.csv", r#""by": "serial","#))
            .expect("a file");
        std::fs::write(folder.path().join("one.campaign.json"), campaign("one.csv", "")).expect("a file");
        let many = run(folder.path(), &["fit", "all.campaign.json"]);
        let rows = table(&many.stdout);
        assert_eq!(rows.len(), 3, "{name} {}", many.stderr);
        let one = run(folder.path(), &["fit", "one.campaign.json", "--json", "-"]);
        let report: Value = serde_json::from_str(&one.stdout).unwrap_or_else(|e| panic!("{name} {e} {}", one.stderr));
        for own in report["parameters"].as_array().expect("parameters") {
            let id = own["id"].as_str().expect("a name");
            for (cell, key) in [(id.to_string(), "value"), (format!("{id}_u"), "u")] {
                let (a, b) =
                    (rows["d1"][&cell].parse::<f64>().expect("a number"), own[key].as_f64().expect("a number"));
                assert!((a / b - 1.0).abs() < 1e-9, "{name} {cell} {a} {b}");
            }
        }
    }
}

/// A device whose values are absurd stands apart, however few the devices are, and does not hide that the others differ.
#[test]
fn one_bad_device_hides_nothing() {
    let folder = tempfile::tempdir().expect("a folder");
    let campaign = r#"{ "bench": { "id": "line", "sensors": { "V": { "unit": "V", "model": "V0 + K*x" } } },
        "estimate": { "V0": {}, "K": {} }, "by": "serial", "readings": "t.csv" }"#;
    std::fs::write(folder.path().join("line.campaign.json"), campaign).expect("a file");
    // V0 is 0.001, 0.002, ..., noise 1e-5; that of the sixth device is ten thousand times as large
    let mut readings = String::from("serial,x,V\n");
    for device in 1..=8 {
        let v0 = 1e-3 * f64::from(device) * if device == 6 { 1e4 } else { 1.0 };
        for (k, noise) in [1.0, -1.2, 0.3, 0.8, -1.4, 0.5].into_iter().enumerate() {
            let x = k as f64 - 2.5;
            readings.push_str(&format!("D{device},{x},{}\n", v0 + 0.02 * x + 1e-5 * noise));
        }
    }
    std::fs::write(folder.path().join("t.csv"), readings).expect("a file");
    let found = run(folder.path(), &["fit", "line.campaign.json", "--to", "d.csv", "--json", "s.json"]);
    assert_eq!(found.code, 0, "{}", found.stderr);
    let summary: Value =
        serde_json::from_str(&std::fs::read_to_string(folder.path().join("s.json")).expect("a file")).expect("JSON");
    let outlying = summary["outlying"].as_array().expect("a list");
    assert_eq!(outlying.iter().map(|own| &own["device"]).collect::<Vec<_>>(), ["D6"], "{outlying:?}");
    let quantities = summary["quantities"].as_array().expect("a list");
    let v0 = quantities.iter().find(|own| own["id"] == "V0").expect("V0");
    // the mean of 1, 2, 3, 4, 5, 7, 8 is 30/7, the sum of squares about it 276/7
    assert!((v0["mean"].as_f64().expect("a mean") - 30e-3 / 7.0).abs() < 1e-6, "{v0}");
    assert!((v0["sd"].as_f64().expect("an sd") - 1e-3 * (276.0_f64 / 7.0 / 6.0).sqrt()).abs() < 1e-6, "{v0}");
    assert_eq!(v0["scattering"]["significant"], true, "{v0}");
}
