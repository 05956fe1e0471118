//! A report as a workbook, read back: the numbers are those of the JSON report, and what somebody wrote into a workbook is not lost.

use assert_cmd::Command;
use calamine::{Data, Reader, Xlsx, open_workbook};
use std::collections::BTreeMap;
use std::fs;

const TABLE_1: &str = "data/campaigns/li2012-table1.campaign.json";

fn tumble(arguments: &[&str]) -> (i32, String, String) {
    let output = Command::cargo_bin("tumble").unwrap().args(arguments).output().unwrap();
    let text = |bytes: &[u8]| String::from_utf8(bytes.to_vec()).unwrap();
    (output.status.code().unwrap(), text(&output.stdout), text(&output.stderr))
}

/// Text and numbers of every cell, sheet by sheet.
fn cells(path: &str) -> Vec<(String, Vec<Vec<Data>>)> {
    let mut workbook: Xlsx<_> = open_workbook(path).unwrap();
    let names = workbook.sheet_names();
    names
        .into_iter()
        .map(|name| {
            let range = workbook.worksheet_range(&name).unwrap();
            let rows = range.rows().map(<[Data]>::to_vec).collect();
            (name, rows)
        })
        .collect()
}

#[test]
fn a_workbook_has_the_numbers_of_the_report() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_string();
    let (code, _, errors) = tumble(&["fit", TABLE_1, "--xlsx", &path("a.xlsx"), "--json", &path("a.json")]);
    assert_eq!(code, 0, "{errors}");
    let report: serde_json::Value = serde_json::from_str(&fs::read_to_string(path("a.json")).unwrap()).unwrap();
    let sheets = cells(&path("a.xlsx"));
    let of = |name: &str| &sheets.iter().find(|(own, _)| own == name).unwrap_or_else(|| panic!("{name}")).1;
    let estimates = of("Estimates");
    let column = |title: &str| {
        let head = estimates.iter().find(|row| row.contains(&Data::String("parameter".into()))).unwrap();
        head.iter().position(|cell| *cell == Data::String(title.into())).unwrap_or_else(|| panic!("{title}"))
    };
    let mut checked = 0;
    for parameter in report["parameters"].as_array().unwrap() {
        let id = parameter["id"].as_str().unwrap();
        let row = estimates.iter().find(|row| row[0] == Data::String(id.into())).unwrap_or_else(|| panic!("{id}"));
        let shown = |title: &str| match row[column(title)] {
            Data::Float(value) => value,
            ref other => panic!("{id} {title}: {other:?}"),
        };
        let arcsec = if parameter["unit"] == "rad" { 180.0 * 3600.0 / std::f64::consts::PI } else { 1.0 };
        for (title, key) in [("estimate", "value"), ("u", "u")] {
            let expected = parameter[key].as_f64().unwrap() * arcsec;
            assert!(
                (shown(title) - expected).abs() <= 1e-12 * expected.abs(),
                "{id} {title}: {} {expected}",
                shown(title)
            );
            checked += 1;
        }
    }
    assert_eq!(checked, 12);
    // the verdict stands on the first sheet, and every reading has its row
    let said = sheets[0].1.iter().flatten().any(|cell| cell.to_string().starts_with("Problem."));
    assert!(said, "{:?}", sheets[0]);
    let readings = of("Readings").iter().filter(|row| matches!(row[0], Data::Float(_))).count();
    assert_eq!(readings, 30);
}

#[test]
fn the_same_report_has_the_same_bytes_and_replaces_its_own_workbook_alone() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_string();
    for name in ["a.xlsx", "b.xlsx", "a.xlsx"] {
        let (code, _, errors) = tumble(&["fit", TABLE_1, "--xlsx", &path(name)]);
        assert_eq!(code, 0, "{errors}");
    }
    // tables of more columns than a screen shows: the data of charts stand beside them
    let many: Vec<String> = (0..34).map(|k| format!("\"p{k}\": {{}}")).collect();
    let sensors: Vec<String> = (0..34).map(|k| format!("\"S{k}\": {{ \"model\": \"p{k}\" }}")).collect();
    let row = |n: f64| (0..34).map(|k| format!("\"S{k}\": {}", f64::from(k) + n)).collect::<Vec<_>>().join(", ");
    let rows: Vec<String> = [0.1, 0.3, -0.2, 0.0].map(|n| format!("{{ {} }}", row(n))).into();
    let text = format!(
        r#"{{ "bench": {{ "id": "many", "sensors": {{ {} }} }}, "estimate": {{ {} }}, "readings": [ {} ] }}"#,
        sensors.join(", "),
        many.join(", "),
        rows.join(", ")
    );
    fs::write(path("many.campaign.json"), text).unwrap();
    for _ in 0..2 {
        let (code, _, errors) = tumble(&["fit", &path("many.campaign.json"), "--xlsx", &path("many.xlsx")]);
        assert_eq!(code, 0, "{errors}");
    }
    assert_eq!(fs::read(path("a.xlsx")).unwrap(), fs::read(path("b.xlsx")).unwrap());
    // the same cells but one, under the mark of the first: as a person's program saves it
    let mut edited = rust_xlsxwriter::Workbook::new();
    let mut marks: Vec<(String, String)> = Vec::new();
    {
        let workbook: Xlsx<_> = open_workbook(path("a.xlsx")).unwrap();
        marks.extend(workbook.defined_names().iter().cloned());
    }
    for (name, rows) in cells(&path("a.xlsx")) {
        let sheet = edited.add_worksheet();
        sheet.set_name(&name).unwrap();
        for (r, row) in (0..).zip(&rows) {
            for (c, cell) in (0..).zip(row) {
                match cell {
                    Data::Float(value) => {
                        sheet.write_number(r, c, *value).unwrap();
                    }
                    Data::Empty => {}
                    other => {
                        sheet.write_string(r, c, other.to_string()).unwrap();
                    }
                }
            }
        }
    }
    // what is printed of each sheet has a name, too
    let own: Vec<_> = marks.iter().filter(|(name, _)| !name.contains("Print_Area")).collect();
    let [(name, value)] = own[..] else { panic!("{marks:?}") };
    edited.define_name(name, &format!("={value}")).unwrap();
    edited.save(path("same.xlsx")).unwrap();
    edited.worksheet_from_index(0).unwrap().write_string(40, 0, "mine").unwrap();
    edited.save(path("mine.xlsx")).unwrap();
    let (code, _, errors) = tumble(&["fit", TABLE_1, "--xlsx", &path("same.xlsx")]);
    assert_eq!(code, 0, "nobody has changed a cell: {errors}");
    let before = fs::read(path("mine.xlsx")).unwrap();
    let (code, _, errors) = tumble(&["fit", TABLE_1, "--xlsx", &path("mine.xlsx")]);
    assert!(code == 1 && errors.contains("mine.xlsx"), "{errors}");
    assert_eq!(fs::read(path("mine.xlsx")).unwrap(), before);
}

/// A schedule's run sheet, filled in with the readings of Table 1, gives Table 1's estimates to the last digit.
#[test]
fn a_filled_run_sheet_is_a_table_of_readings() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_string();
    let mut campaign: serde_json::Value = serde_json::from_str(&fs::read_to_string(TABLE_1).unwrap()).unwrap();
    let measured = campaign["readings"].clone();
    for reading in campaign["readings"].as_array_mut().unwrap() {
        reading.as_object_mut().unwrap().remove("V");
    }
    fs::write(path("schedule.campaign.json"), campaign.to_string()).unwrap();
    for name in ["sheet.csv", "sheet.html", "sheet.xlsx", "sheet.html", "sheet.xlsx"] {
        let arguments = ["plan", &path("schedule.campaign.json"), "--noise", "V=9e-4", "--sheet", &path(name)];
        let (code, _, errors) = tumble(&arguments);
        assert_eq!(code, 0, "{errors}");
    }
    // so has the campaign that is written: what is promised of effects holds where the noise is known
    let planned = path("planned.campaign.json");
    let (code, _, errors) =
        tumble(&["plan", &path("schedule.campaign.json"), "--noise", "V=9e-4", "--write", &planned]);
    assert_eq!(code, 0, "{errors}");
    let written: serde_json::Value = serde_json::from_str(&fs::read_to_string(&planned).unwrap()).unwrap();
    assert!(written["readings"].as_array().unwrap().iter().all(|reading| reading["V_u"] == 9e-4), "{written}");
    let sheet = fs::read_to_string(path("sheet.csv")).unwrap();
    let mut lines = sheet.lines();
    let titles: Vec<&str> = lines.next().unwrap().split(',').collect();
    // with the noise for which the schedule was planned
    assert_eq!(titles, ["position", "gamma_deg_s", "beta_deg", "alpha_deg", "V", "V_u"]);
    // also where readings are added to those of the schedule
    let more = path("more.csv");
    let (code, _, errors) =
        tumble(&["plan", &path("schedule.campaign.json"), "--noise", "V=9e-4", "--add", "2", "--sheet", &more]);
    assert_eq!(code, 0, "{errors}");
    let added = fs::read_to_string(more).unwrap();
    assert!(added.lines().count() == 33 && added.lines().skip(1).all(|line| line.ends_with(",,0.0009")), "{added}");
    let mut filled = vec![titles.join(",")];
    for line in lines {
        let own: Vec<&str> = line.split(',').collect();
        assert_eq!(own[4..], ["", "0.0009"], "{line}");
        let same = |reading: &&serde_json::Value| {
            (1..4).all(|k| reading[titles[k]].as_f64().unwrap_or(0.0) == own[k].parse::<f64>().unwrap())
        };
        let reading = measured.as_array().unwrap().iter().find(same).unwrap_or_else(|| panic!("{line}"));
        filled.push(line.replace(",,", &format!(",{},", reading["V"])));
    }
    assert_eq!(filled.len(), 31);
    fs::write(path("filled.csv"), filled.join("\n")).unwrap();
    let estimates = |arguments: &[&str]| -> BTreeMap<String, f64> {
        let (code, json, errors) = tumble(arguments);
        assert_eq!(code, 0, "{errors}");
        let report: serde_json::Value = serde_json::from_str(&json).unwrap();
        let own = |own: &serde_json::Value| (own["id"].as_str().unwrap().to_string(), own["value"].as_f64().unwrap());
        report["parameters"].as_array().unwrap().iter().map(own).collect()
    };
    let given = estimates(&["fit", TABLE_1, "--json", "-"]);
    let schedule = path("schedule.campaign.json");
    let back = estimates(&["fit", &schedule, "--readings", &path("filled.csv"), "--json", "-"]);
    assert!(
        given.len() == 6 && given.iter().all(|(id, own)| (own - back[id]).abs() <= 1e-12 * own.abs()),
        "{given:?} {back:?}"
    );
    // five mountings are drawn, and the whole costs what the plan says: 5 * 10 + 30 * 1 + 25 changes of the rate
    let page = fs::read_to_string(path("sheet.html")).unwrap();
    assert_eq!(page.matches("<figure").count(), 5);
    let sheets = cells(&path("sheet.xlsx"));
    let cost = |row: &Vec<Data>| row[0] == Data::String("Cost".into()) && row[1] == Data::String("105".into());
    assert!(sheets[0].1.iter().any(cost), "{:?}", sheets[0].1);
    let (code, _, errors) = tumble(&["plan", &schedule, "--noise", "V=9e-4", "--sheet", &path("sheet.doc")]);
    assert!(code == 1 && errors.contains("sheet.doc") && errors.contains(".xlsx"), "{errors}");
}

#[test]
fn a_bench_is_drawn_in_the_position_that_is_asked_for() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("bench.svg").to_str().unwrap().to_string();
    let arguments =
        ["bench", "show", "gyro-turntable", "--svg", &path, "--at", "beta_deg=90", "--at", "gamma_deg_s=-20"];
    let (code, _, errors) = tumble(&arguments);
    assert_eq!(code, 0, "{errors}");
    let drawing = fs::read_to_string(&path).unwrap();
    for text in ["beta 90\u{b0}", "gamma -20\u{b0}/s", "alpha 0\u{b0}", "Earth rate", "gravity"] {
        assert!(drawing.contains(text), "{text}");
    }
    let (code, _, errors) = tumble(&["bench", "show", "gyro-turntable", "--svg", &path, "--at", "delta_deg=1"]);
    assert!(code == 1 && errors.contains("no joint 'delta'") && errors.contains("gamma, beta, alpha"), "{errors}");
    let (code, _, errors) = tumble(&["bench", "show", "gyro-turntabel"]);
    assert!(code == 1 && errors.contains("gyro-turntabel") && errors.contains("gyro-turntable"), "{errors}");
}
