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
    assert!(cell("G036", "why").contains("V is not a number (reading 8"), "{}", cell("G036", "why"));
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
    assert_eq!(listed, [("G025", "accepted"), ("G031", "rejected"), ("G036", "malformed")]);
    let page = std::fs::read_to_string(folder.path().join("line.html")).expect("a page");
    let markdown = std::fs::read_to_string(folder.path().join("line.md")).expect("a page");
    // G028 stands apart; what is malformed has no fit to be shown
    for (serial, says) in [("G031", "NOT ESTIMABLE"), ("G028", "kII")] {
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
    assert!(refused.stderr.contains("--reports is of many devices"), "{}", refused.stderr);
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
    assert!(mixed.stderr.contains("comes back"), "{}", mixed.stderr);
    let sorted = run(&example(), &["fit", "line.campaign.json"]);
    assert_eq!(table(&mixed.stdout), table(&sorted.stdout));
    // and in a file, which is begun anew under the same name
    let to = run(folder.path(), &["fit", "line.campaign.json", "--to", "d.csv"]);
    assert_eq!(to.code, 2, "{}", to.stderr);
    assert_eq!(table(&std::fs::read_to_string(folder.path().join("d.csv")).expect("a file")), table(&sorted.stdout));
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
