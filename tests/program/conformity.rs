//! Limits through the program: exit code 2 where a result fails, the identity and the inputs in every output.

use assert_cmd::Command;
use serde_json::Value;

fn run(folder: &std::path::Path, arguments: &[&str]) -> (i32, String) {
    let output =
        Command::cargo_bin("tumble").expect("the program").current_dir(folder).args(arguments).output().expect("a run");
    (output.status.code().expect("no signal"), String::from_utf8(output.stdout).expect("UTF-8"))
}

/// Limits that the uncertainty leaves open are no pass, for one device and for many.
#[test]
fn an_undecided_limit_is_exit_code_2() {
    let folder = tempfile::tempdir().expect("a folder");
    let text = |limit: &str, by: &str, serial: &str| {
        format!(
            r#"{{ "bench": {{ "id": "line", "sensors": {{ "y": {{ "unit": "mm", "model": "a + b*time_s" }} }} }},
                "estimate": {{ "a": {{}}, "b": {{}} }}, "limits": {{ "b": {limit} }}, "decision": "guard-u"{by},
                "readings": [ {{{serial}"time_s": 0, "y": 1.02}}, {{{serial}"time_s": 1, "y": 2.99}}, {{{serial}"time_s": 2, "y": 5.01}} ] }}"#
        )
    };
    // b = 1.995 with U = 0.22
    for (limit, code) in [("[1, 3]", 0), ("[1.98, 2.01]", 2), ("[3, 4]", 2)] {
        for (by, serial) in [("", ""), (r#", "by": "serial""#, r#""serial": "A", "#)] {
            std::fs::write(folder.path().join("c.json"), text(limit, by, serial)).expect("a file");
            let (found, table) = run(folder.path(), &["fit", "c.json"]);
            assert_eq!(found, code, "{limit}{by}: {table}");
        }
    }
}

#[test]
fn a_failed_limit_is_exit_code_2_and_everything_says_which_unit() {
    let folder = tempfile::tempdir().expect("a folder");
    let text = |limit: &str| {
        format!(
            r#"{{ "bench": {{ "id": "line", "sensors": {{ "y": {{ "unit": "mm", "model": "a + b*time_s" }} }} }},
                "estimate": {{ "a": {{}}, "b": {{}} }}, "limits": {{ "b": {limit} }}, "unit": {{ "serial": "S-123" }},
                "readings": [ {{"time_s": 0, "y": 1.02}}, {{"time_s": 1, "y": 2.99}}, {{"time_s": 2, "y": 5.01}} ] }}"#
        )
    };
    for (limit, code, word) in [("[1.9, 2.1]", 0, "pass"), ("[3, 4]", 2, "fail")] {
        std::fs::write(folder.path().join("c.json"), text(limit)).expect("a file");
        let (found, table) = run(folder.path(), &["fit", "c.json", "--html", "c.html", "--md", "c.md"]);
        assert_eq!(found, code, "{table}");
        assert!(table.contains(&format!("Conformity: {word}")) && table.contains("S-123"), "{table}");
        for page in ["c.html", "c.md"] {
            let page = std::fs::read_to_string(folder.path().join(page)).expect("a page");
            assert!(page.contains("S-123") && page.contains("Conformity") && page.contains(word), "{page}");
        }
        let (_, json) = run(folder.path(), &["fit", "c.json", "--json", "-"]);
        let report: Value = serde_json::from_str(&json).expect("JSON");
        assert_eq!(report["identity"]["unit"]["serial"], "S-123");
        assert_eq!(
            (report["inputs"][0]["name"].as_str(), report["conformity"]["outcome"].as_str()),
            (Some("c.json"), Some(word))
        );
        assert_eq!(report["inputs"][0]["sha256"].as_str().map(str::len), Some(64));
    }
}
