//! Malformed questions through the program: exit code, the words that help, the line, the caret; never a panic, nothing half-written.

use crate::support::*;
use assert_cmd::Command;
use serde_json::Value;
use std::io::Write;
use std::path::Path;

/// Exit code and stderr of `tumble ARGUMENTS`, run in `folder`.
fn tumble(folder: &Path, arguments: &[&str]) -> (i32, String, String) {
    let output =
        Command::cargo_bin("tumble").expect("the program").current_dir(folder).args(arguments).output().expect("a run");
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).expect("UTF-8");
    (output.status.code().expect("no signal"), text(output.stdout), text(output.stderr))
}

/// What is wrong with the answer to one entry of INDEX.json, if anything.
fn complaints(name: &str, entry: &Value) -> Vec<String> {
    let (code, stdout, stderr) = tumble(&data("bad"), &["fit", name]);
    let mut complaints = Vec::new();
    let mut check = |good: bool, what: String| {
        if !good {
            complaints.push(what);
        }
    };
    let exit = entry["exit"].as_i64().expect("an exit code");
    check(i64::from(code) == exit, format!("exit code {code}, not {exit}"));
    check(!stderr.contains("panicked"), "it panicked".into());
    check(exit == 1 || stderr.is_empty(), "something on stderr".into());
    check(exit != 1 || stdout.is_empty(), "results of a malformed question".into());
    let answer = if exit == 1 { &stderr } else { &stdout };
    for word in entry["must_mention"].as_array().expect("words") {
        let word = word.as_str().expect("a word");
        check(answer.contains(word), format!("does not mention {word}"));
    }
    if exit == 1 {
        check(stderr.len() < 4000, format!("{} bytes of message", stderr.len()));
        check(stderr.contains("expected"), "does not say what was expected".into());
    }
    if let Some(line) = entry["line"].as_u64() {
        let file = entry["line_in"].as_str().unwrap_or(name);
        let ends = [", ", "\n"].map(|end| format!("in {file}, line {line}{end}"));
        check(ends.iter().any(|end| stderr.contains(end)), format!("does not say: in {file}, line {line}"));
    }
    if let Some(column) = entry["column"].as_u64() {
        check(stderr.contains(&format!("column {column}\n")), format!("does not say: column {column}"));
        let model = entry["model"].as_str().expect("the line");
        let caret = entry["caret"].as_u64().expect("a caret") as usize;
        check(
            caret_of(&stderr, model) == Some(caret),
            format!("the caret is not at {caret} but {:?}", caret_of(&stderr, model)),
        );
    }
    if !complaints.is_empty() {
        println!("--- {name}: {}\n{}\n{stdout}{stderr}", entry["fault"], complaints.join("\n"));
    }
    complaints
}

/// Where the caret stands in the quoted model line, in characters from its start.
fn caret_of(stderr: &str, model: &str) -> Option<usize> {
    let lines: Vec<&str> = stderr.lines().collect();
    let quoted = format!("\"model\": \"{model}");
    let k = lines.iter().position(|line| line.contains(&quoted))?;
    let start = lines[k].find(&quoted).map(|at| lines[k][..at].chars().count())? + "\"model\": \"".len();
    lines.get(k + 1)?.chars().position(|c| c == '─' || c == '┬' || c == '▲')?.checked_sub(start)
}

/// What a message says of its place, and what is underlined.
fn place_and_mark(stderr: &str) -> (String, String) {
    let lines: Vec<&str> = stderr.lines().collect();
    let place = lines.iter().find_map(|line| line.split_once("in ").filter(|(_, own)| own.contains(", line ")));
    let Some(mark) = lines.iter().position(|line| line.contains(" · ")) else {
        return (place.expect("a place").1.to_string(), String::new());
    };
    let under: Vec<char> = lines[mark].chars().collect();
    let quoted: Vec<char> = lines[mark - 1].chars().collect();
    let is_under = |k: &usize| under.get(*k) == Some(&'─');
    (place.expect("a place").1.to_string(), (0..quoted.len()).filter(is_under).map(|k| quoted[k]).collect())
}

/// A number in the place of an object: the error says where, what the object has, and what was found.
#[test]
fn a_number_in_the_place_of_an_object() {
    let folder = tempfile::tempdir().expect("a folder");
    let campaign = |known: &str, estimate: &str, more: &str| {
        format!(
            r#"{{ "bench": {{ "id": "line", "sensors": {{ "y": {{ "unit": "V", "model": "a + K*x" }} }} }},
"known": {known}, "estimate": {estimate}, {more} "readings": [ {{"x": 0, "y": 1}}, {{"x": 1, "y": 3}} ] }}"#
        )
    };
    let cases = [
        (campaign(r#"{ "K": 52 }"#, r#"{ "a": {} }"#, ""), "known.K", &["\"value\": ...", "\"u\": ..."][..], "52"),
        (
            campaign("{}", r#"{ "a": 0.5 }"#, ""),
            "estimate.a",
            &["\"start\": ...", "\"prior\": ...", "\"prior_u\": ..."],
            "0.5",
        ),
        (
            campaign("{}", r#"{ "a": {} }"#, r#""site": 45.75,"#),
            "site",
            &["\"latitude_deg\": ...", "\"gravity\": ..."],
            "45.75",
        ),
        (
            campaign("{}", r#"{ "a": {} }"#, r#""site": { "gravity": 9.81 },"#),
            "site.gravity",
            &["\"value\": ...", "\"unit\": ...", "\"u\": ..."],
            "9.81",
        ),
        (campaign("{}", r#"{ "a": {} }"#, r#""limits": { "a": 3 },"#), "limits.a", &["[lower, upper]"], "3"),
        (campaign("{}", r#"{ "a": {} }"#, r#""unit": 17,"#), "unit", &["\"serial\": ..."], "17"),
    ];
    for (text, place, expected, number) in cases {
        std::fs::write(folder.path().join("c.json"), text).expect("a file");
        let (code, _, stderr) = tumble(folder.path(), &["fit", "c.json"]);
        let said = stderr.split_whitespace().filter(|word| *word != "│").collect::<Vec<_>>().join(" ");
        let found = format!("the number {number}");
        let words = [&[place, "line 2", found.as_str()], expected].concat();
        assert!(code == 1 && !said.contains("invalid type") && !said.contains("integer"), "{said}");
        for word in words {
            assert!(said.contains(word), "{word}: {said}");
        }
    }
}

/// Of a table the cell that is wrong is named: its line, its first character and its column; the whole row where the row is wrong.
#[test]
fn the_cell_that_is_wrong() {
    let folder = tempfile::tempdir().expect("a folder");
    let reduced: [(&str, &str, &str); 8] = [
        ("time_s,gx,pos\n0,1,a\n1,1.5,a\n2,abc,a\n3,2,a\n", "log.csv, line 4, column 3", "abc"),
        ("time_s;gx;pos\n0;1,5;a\n1; 2,5 ;a\n2;  x y ;a\n3;2;a\n", "log.csv, line 4, column 5", "x y"),
        ("time_s,pos,gx\n0,\"a, b\",1\n1,\"a, b\",2\n2,\"ä\"\"ö\",oops\n", "log.csv, line 4, column 10", "oops"),
        ("time_s,pos,gx\n0,a,1\n1,a,2\n2,\"a\nb\",oops\n3,a,1\n", "log.csv, line 5, column 4", "oops"),
        (
            "gx,time,pos\n1,2026-11-20T09:00:00,a\n2,2026-11-20T09:00:7x,a\n",
            "log.csv, line 3, column 3",
            "2026-11-20T09:00:7x",
        ),
        ("time_s gx pos\n0   1 a\n1   1 a\n2   u a\n3   2 a\n", "log.csv, line 4, column 5", ""),
        ("time_s,gx,pos\n0,1,a\n1,1.5,a\n2,7,a,4\n3,2,a\n", "log.csv, line 4", "2,7,a,4"),
        ("time_s,gx,gx\n0,1,2\n1,1.5,2\n2,7,4\n", "log.csv, line 1", "time_s,gx,gx"),
    ];
    for (text, place, mark) in reduced {
        std::fs::write(folder.path().join("log.csv"), text).expect("a file");
        let by = if text.contains("pos") { vec!["--by", "pos"] } else { Vec::new() };
        let (code, _, stderr) = tumble(folder.path(), &[vec!["reduce", "log.csv"], by].concat());
        assert_eq!((code, place_and_mark(&stderr)), (1, (place.to_string(), mark.to_string())), "{stderr}");
    }
    let campaign = r#"{ "bench": { "id": "line", "sensors": { "y": { "unit": "V", "model": "a + b*when" } } },
        "estimate": { "a": {}, "b": {} }, "readings": "r.csv" }"#;
    std::fs::write(folder.path().join("c.json"), campaign).expect("a file");
    let readings: [(&str, &str, &str); 4] = [
        // one bad date among good ones: it is the one that is named
        ("when,y\n2026-11-20,1\n2026-11-21,2\n2026-13-22,3.5\n2026-11-23,4\n", "r.csv, line 4, column 1", "2026-13-22"),
        ("y,when\n1,2026-11-20\n2,2026-11-21\n3.5,12\n4,2026-11-23\n", "r.csv, line 4, column 5", "12"),
        ("n,when,y\n1,0,1\n1,1,2\n1,2,a3.5\n1,3,4\n", "r.csv, line 4, column 5", "a3.5"),
        ("when,y,y_u\n0,1,1\n1,2,1\n2,3,-1\n3,4,1\n", "r.csv, line 4, column 5", "-1"),
    ];
    for (text, place, mark) in readings {
        std::fs::write(folder.path().join("r.csv"), text).expect("a file");
        let (code, _, stderr) = tumble(folder.path(), &["fit", "c.json"]);
        assert_eq!((code, place_and_mark(&stderr)), (1, (place.to_string(), mark.to_string())), "{stderr}");
    }
}

/// Times without a unit in steps of ten are read as seconds, which is said wherever they are read.
#[test]
fn times_without_a_unit() {
    let folder = tempfile::tempdir().expect("a folder");
    let rows: String = (0..40).map(|k| format!("{},{},a\n", 10 * k, k % 3)).collect();
    std::fs::write(folder.path().join("log.csv"), format!("time,y,pos\n{rows}")).expect("a file");
    let campaign = r#"{ "bench": { "id": "line", "sensors": { "y": { "unit": "V", "model": "a + b*time_s" } } },
        "estimate": { "a": {}, "b": {} }, "readings": { "samples": "log.csv", "as": "rows" } }"#;
    std::fs::write(folder.path().join("rows.json"), campaign).expect("a file");
    let all: [&[&str]; 3] =
        [&["reduce", "log.csv", "--by", "pos"], &["noise", "log.csv", "--columns", "y"], &["fit", "rows.json"]];
    for arguments in all {
        let (code, stdout, stderr) = tumble(folder.path(), arguments);
        let said = format!("{stdout}{stderr}").replace("\n  ", " ");
        assert!(
            code != 1 && said.contains("'time' has no unit and is read as seconds, with steps of 10"),
            "{arguments:?}: {said}"
        );
    }
}

#[test]
fn every_entry_of_the_index() {
    let index = json("bad/INDEX.json");
    let failed: Vec<&String> =
        entries(&index).filter(|(name, entry)| !complaints(name, entry).is_empty()).map(|(name, _)| name).collect();
    println!("{} malformed questions", entries(&index).count());
    assert!(failed.is_empty(), "{} of {}: {failed:?}", failed.len(), entries(&index).count());
}

#[test]
fn a_file_of_100_megabytes() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("large.campaign.json");
    let mut file = std::io::BufWriter::new(std::fs::File::create(&path).expect("a file"));
    let head = r#"{ "bench": "accelerometer-plumb-plane", "known": { "kI": { "value": 1.299 } }, "estimate": { "V0": {} }, "readings": ["#;
    file.write_all(head.as_bytes()).expect("written");
    let row = format!("{{ \"beta_deg\": 0, \"remark\": \"{}\", \"V\": 0.1 }},\n", "x".repeat(1000));
    for _ in 0..100_000 {
        file.write_all(row.as_bytes()).expect("written");
    }
    file.write_all(b"{ \"beta_deg\": 0, \"V\": oops } ] }").expect("written");
    drop(file);
    assert!(std::fs::metadata(&path).expect("a file").len() > 100_000_000);
    let (code, stdout, stderr) = tumble(folder.path(), &["fit", "large.campaign.json"]);
    assert_eq!((code, stdout.as_str()), (1, ""));
    assert!(stderr.contains("line 100001") && stderr.len() < 4000, "{}", &stderr[..stderr.len().min(2000)]);
}

#[test]
fn nesting_of_a_million() {
    let folder = tempfile::tempdir().expect("a folder");
    for (name, open) in [("arrays", "["), ("objects", "{\"bench\":")] {
        let name = format!("{name}.campaign.json");
        std::fs::write(folder.path().join(&name), open.repeat(1_000_000)).expect("written");
        let (code, _, stderr) = tumble(folder.path(), &["fit", &name]);
        assert_eq!(code, 1, "{name}");
        assert!(
            stderr.contains("error") && !stderr.contains("panicked") && stderr.len() < 4000,
            "{name}: {} bytes",
            stderr.len()
        );
    }
    let deep = format!("{}x{}", "(".repeat(1_000_000), ")".repeat(1_000_000));
    let file = format!(
        r#"{{ "bench": {{ "id": "b", "sensors": {{ "y": {{ "model": "{deep}" }} }} }}, "estimate": {{ "x": {{}} }}, "readings": [ {{ "y": 1 }} ] }}"#
    );
    std::fs::write(folder.path().join("deep.campaign.json"), file).expect("written");
    let (code, _, stderr) = tumble(folder.path(), &["fit", "deep.campaign.json"]);
    assert!(code == 1 && !stderr.contains("panicked") && stderr.len() < 4000, "{code}, {} bytes", stderr.len());
}

/// A report goes to a temporary name first: where it cannot be finished, the old one stands and nothing else is left behind.
#[test]
fn nothing_is_half_written() {
    let folder = tempfile::tempdir().expect("a folder");
    let names = || -> Vec<String> {
        let mut names: Vec<String> = std::fs::read_dir(folder.path())
            .expect("the folder")
            .map(|entry| entry.expect("an entry").file_name().to_string_lossy().into_owned())
            .collect();
        names.sort();
        names
    };
    let campaign = data("bad/good.campaign.json");
    let campaign = campaign.to_str().expect("a path");
    // a good report replaces an old one, and no file of another kind
    let old = folder.path().join("report.json");
    std::fs::write(&old, "old").expect("written");
    assert_eq!(tumble(folder.path(), &["fit", campaign, "--json", "report.json"]).0, 1);
    assert_eq!(std::fs::read_to_string(&old).expect("kept"), "old");
    std::fs::write(&old, r#"{ "tumble": "0.1.0", "report": "fit" }"#).expect("written");
    assert_eq!(tumble(folder.path(), &["fit", campaign, "--json", "report.json"]).0, 0);
    let report: Value =
        serde_json::from_str(&std::fs::read_to_string(folder.path().join("report.json")).expect("a report"))
            .expect("JSON");
    assert_eq!(report["report"], "fit");
    assert_eq!(names(), ["report.json"]);
    // a malformed question leaves it alone
    let before = std::fs::read(folder.path().join("report.json")).expect("a report");
    let bad = data("bad/zero-u.campaign.json");
    assert_eq!(tumble(folder.path(), &["fit", bad.to_str().expect("a path"), "--json", "report.json"]).0, 1);
    assert_eq!(std::fs::read(folder.path().join("report.json")).expect("a report"), before);
    // a target that is a folder, and a folder that is not there
    std::fs::create_dir(folder.path().join("taken")).expect("a folder");
    for target in ["taken", "nowhere/report.json"] {
        let (code, _, stderr) = tumble(folder.path(), &["fit", campaign, "--json", target]);
        assert!(code == 1 && stderr.contains("cannot write"), "{target}: {code} {stderr}");
    }
    assert_eq!(names(), ["report.json", "taken"]);
    assert_eq!(std::fs::read_dir(folder.path().join("taken")).expect("the folder").count(), 0);
}

/// What is shown of a file of long lines is the fault, its neighbours cut to what fits.
#[test]
fn an_excerpt_of_a_long_line_keeps_the_fault() {
    use tumble::error::{Fault, Malformed};
    let text = format!("first\n{}*{}\r\nlast\nmore", "a".repeat(10_000), "b".repeat(10_000));
    let at = |line: usize, start: usize, len: usize| {
        Malformed::new(Fault::Syntax, "a fault").in_file("f").at_line(line, 1).at_span(start, len)
    };
    let shown = tumble::cli::explain(&at(2, 6 + 10_000, 1), Some(&text));
    let line =
        |number: usize| shown.lines().find(|line| line.trim_start().starts_with(&format!("{number} "))).unwrap_or("");
    let long = line(2);
    assert!(line(1).ends_with("first") && line(3).ends_with("last") && line(4).is_empty(), "{shown}");
    assert!(long.contains("…a") && long.ends_with("b…") && long.chars().count() < 300, "{shown}");
    // the mark under the line stands below the fault
    let under = shown.lines().skip_while(|line| *line != long).nth(1).expect("a mark");
    let place = |line: &str, letter: &dyn Fn(char) -> bool| line.chars().position(letter);
    let mark = place(under, &|c| !c.is_whitespace() && !"│·|".contains(c));
    assert_eq!(place(long, &|c| c == '*'), mark, "{shown}");
    let short = tumble::cli::explain(&at(2, 4, 9), Some("a\nb\nc"));
    assert!(short.contains("2 ") && short.contains("3 ") && short.contains('c'), "{short}");
    // the file has changed since it was read
    let gone = tumble::cli::explain(&at(1, 7, 1), Some("abc"));
    assert!(gone.contains("a fault") && !gone.contains("abc"), "{gone}");
}

fn source(text: &str) -> tumble::wire::Source {
    tumble::wire::Source { name: "f".into(), text: text.into() }
}

/// A file of another kind in the place of a campaign is named; what may be meant as one gets the error of its own fault.
#[test]
fn other_files_are_named() {
    let found = |text: &str| {
        let read = tumble::wire::read_campaign(&source(text), &mut |name| panic!("refers to {name}"));
        let error = read.expect_err("no campaign");
        (error.what().to_string(), error.finding().unwrap_or_default().to_string())
    };
    let bench = tumble::bench::built_in("gyro-turntable").expect("a bench").text;
    for (text, kind) in [
        ("<!doctype html>\n<p>", "<!doctype html>"),
        (r#"{"noise": {"V": {"sd": 1e-4}}}"#, "truth file"),
        (bench, "bench file"),
        (r#"{"tumble": "0.1.0", "report": "fit", "x": 1}"#, "tumble fit"),
    ] {
        let (what, own) = found(text);
        assert!(what.contains("not a campaign file") && own.contains(kind), "{text}: {what}; {own}");
    }
    for campaign in ["", "{", "{}", r#"{"bench": "gyro-turntable", "readigs": []}"#] {
        let (what, own) = found(campaign);
        assert!(!what.contains("not a campaign file"), "{campaign}: {what}; {own}");
    }
}

#[test]
fn a_path_leads_to_its_value() {
    use tumble::error::{Fault, Malformed};
    let text = "{ \"a\": [1,\n {\"b\": \"V0 + *\"}] }";
    let at = |path: &str, text: &str| {
        let error = Malformed::new(Fault::Value, "a fault").at_path(path);
        let place = tumble::wire::locate(error, &source(text)).place().clone();
        (place.span.map(|(start, len)| text[start..start + len].to_string()), place.line, place.column)
    };
    let (value, line, column) = at("a[1].b", text);
    assert_eq!((value.as_deref().map(|own| own.starts_with("\"V0 + *\"")), line, column), (Some(true), 2, 8));
    // the deepest value on the way that exists
    let (value, line, _) = at("a[1].zz.q", text);
    assert!(value.is_some_and(|own| own.starts_with("{\"b\"")) && line == 2);
    assert_eq!(at("a", "no json"), (None, 0, 0));
}
