//! A name of a model line that nothing in the campaign has: a column under another name is asked for, wherever the campaign is read.

use std::path::Path;
use std::process::Command;

const TABLE: &str = "x,Temp,y\n0,20,11.0\n1,21,13.5\n2,24,17.0\n3,29,21.5\n4,36,27.0\n5,45,33.5\n";

fn run(folder: &Path, arguments: &[&str]) -> (Option<i32>, String) {
    let mut command = Command::new(assert_cmd::cargo::cargo_bin!("tumble"));
    let output = command.current_dir(folder).args(arguments).output().expect("a run");
    let text = [output.stdout, output.stderr].map(|bytes| String::from_utf8_lossy(&bytes).into_owned()).concat();
    (output.status.code(), text.split_whitespace().filter(|word| *word != "│").collect::<Vec<_>>().join(" "))
}

/// y = a + b*x + c*temp where `asked` says what of it is known and estimated.
fn campaign(folder: &Path, asked: &str, readings: &str) {
    let text = format!(
        r#"{{ "bench": {{ "id": "line", "sensors": {{ "y": {{ "unit": "V", "model": "a + b*x + c*temp" }} }} }}, {asked}, "readings": {readings} }}"#
    );
    std::fs::write(folder.join("c.campaign.json"), text).expect("a file");
}

#[test]
fn a_column_under_another_name_is_asked_for() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let known = r#""estimate": { "a": {}, "b": {} }, "known": { "c": { "value": 0.5, "u": 0.01 } }"#;
    campaign(at, known, "\"r.csv\"");
    for title in ["Temp", "TEMP", "temp_c", "temp (degC)", "Temp [degC]", "t e m p"] {
        std::fs::write(at.join("r.csv"), TABLE.replace("Temp", title)).expect("a table");
        for command in ["fit", "check"] {
            let (code, text) = run(at, &[command, "c.campaign.json"]);
            assert_eq!(code, Some(1), "{title}, {command}: {text}");
            let title = title.split([' ', '(']).next().filter(|_| title.contains('(')).unwrap_or(title);
            assert!(
                text.contains("'temp' in a model line") && text.contains(&format!("is the column '{title}")),
                "{text}"
            );
        }
    }
    // named, it is read: y = 1 + 2 x + 0.5 temp exactly
    let mapped = format!(r#"{known}, "columns": {{ "temp": "Temp" }}"#);
    std::fs::write(at.join("r.csv"), TABLE).expect("a table");
    campaign(at, &mapped, "\"r.csv\"");
    let (code, text) = run(at, &["fit", "c.campaign.json"]);
    assert_eq!(code, Some(0), "{text}");
    // nothing looks like it: the bench's coefficient is zero as ever, and listed
    std::fs::write(at.join("r.csv"), TABLE.replace("Temp", "humidity")).expect("a table");
    campaign(at, known, "\"r.csv\"");
    let (_, text) = run(at, &["fit", "c.campaign.json"]);
    assert!(text.contains("neither known nor estimated: temp"), "{text}");
    // inline readings
    campaign(
        at,
        known,
        r#"[ {"x": 0, "Temp": 20, "y": 11}, {"x": 1, "Temp": 21, "y": 13.5}, {"x": 2, "Temp": 24, "y": 17} ]"#,
    );
    let (code, text) = run(at, &["fit", "c.campaign.json"]);
    assert!(code == Some(1) && text.contains("is the column 'Temp' meant?"), "{text}");
}

/// What a fit refuses before it solves, `check` refuses with the same words: an input that one reading lacks, an uncertainty that one reading states.
#[test]
fn check_refuses_what_a_fit_refuses() {
    let folder = tempfile::tempdir().expect("a folder");
    let known = r#""estimate": { "a": {}, "b": {} }, "known": { "c": { "value": 0.5, "u": 0.01 } }"#;
    for (second, said) in [("", "temp"), (r#""temp": 20, "y_u": 0.1,"#, "y_u here")] {
        let readings = format!(
            r#"[ {{"x": 0, "temp": 20, "y": 11}}, {{"x": 1, {second} "y": 13.5}}, {{"x": 2, "temp": 24, "y": 17}} ]"#
        );
        campaign(folder.path(), known, &readings);
        let told = ["fit", "check"].map(|command| run(folder.path(), &[command, "c.campaign.json"]));
        let [(code, fit), (_, check)] = &told;
        assert!(*code == Some(1) && fit.contains(said), "{fit}");
        assert_eq!(told[0], told[1], "{check}");
    }
}

#[test]
fn devices_and_streamed_records_ask_too() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let known = r#""estimate": { "a": {}, "b": {} }, "known": { "c": { "value": 0.5, "u": 0.01 } }"#;
    let lines = |serial: &str| TABLE.lines().skip(1).map(|line| format!("{serial},{line}\n")).collect::<String>();
    std::fs::write(at.join("many.csv"), format!("serial,x,Temp,y\n{}{}", lines("A"), lines("B"))).expect("a table");
    campaign(at, &format!(r#"{known}, "by": "serial""#), "\"many.csv\"");
    let (code, text) = run(at, &["fit", "c.campaign.json", "--to", "rows.csv"]);
    assert!(code == Some(1) && text.contains("is the column 'Temp' meant?"), "{text}");
    std::fs::write(at.join("r.csv"), TABLE).expect("a table");
    campaign(at, known, r#"{ "samples": "r.csv", "as": "rows", "rate_hz": 1 }"#);
    let (code, text) = run(at, &["fit", "c.campaign.json"]);
    assert!(code == Some(1) && text.contains("is the column 'Temp' meant?"), "{text}");
}

/// An estimated coefficient beside a factor that is nowhere would have a column of zeros.
#[test]
fn a_coefficient_beside_a_factor_that_is_nowhere_is_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    std::fs::write(at.join("r.csv"), TABLE.replace("Temp", "humidity")).expect("a table");
    campaign(at, r#""estimate": { "a": {}, "b": {}, "c": {} }"#, "\"r.csv\"");
    let (code, text) = run(at, &["fit", "c.campaign.json"]);
    assert_eq!(code, Some(1), "{text}");
    assert!(text.contains("'c' occurs only multiplied by 'temp'"), "{text}");
}
