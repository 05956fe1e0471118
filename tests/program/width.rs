//! What the program prints for a person fits a terminal of 80 columns.

use assert_cmd::Command;
use std::path::{Path, PathBuf};

/// Columns of the smallest terminal in use.
const COLUMNS: usize = 80;

/// Standard output and standard error of `tumble ARGUMENTS`, run in the repository's folder.
fn printed(arguments: &[&str]) -> String {
    let mut command = Command::cargo_bin("tumble").expect("the program");
    let output = command.current_dir(env!("CARGO_MANIFEST_DIR")).args(arguments).output().expect("a run");
    String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr)
}

/// Lines that are too long although a space would break them.
fn too_long(text: &str) -> Vec<String> {
    let breakable = |line: &str| {
        let lead = line.len() - line.trim_start().len();
        let longest = line.split(' ').map(|word| word.chars().count()).max().unwrap_or(0);
        lead + longest <= COLUMNS
    };
    text.lines().filter(|line| line.chars().count() > COLUMNS && breakable(line)).map(String::from).collect()
}

/// Files of the examples with this ending.
fn examples(ending: &str) -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples");
    let mut files = Vec::new();
    for example in std::fs::read_dir(folder).expect("examples").flatten() {
        let Ok(inside) = std::fs::read_dir(example.path()) else { continue };
        files.extend(inside.flatten().map(|file| file.path()).filter(|path| path.to_string_lossy().ends_with(ending)));
    }
    files.sort();
    files
}

fn check(arguments: &[&str]) {
    let long = too_long(&printed(arguments));
    assert!(
        long.is_empty(),
        "tumble {}: lines of more than {COLUMNS} columns\n{}",
        arguments.join(" "),
        long.join("\n")
    );
}

#[test]
fn reports_fit_80_columns() {
    let campaigns = examples(".campaign.json");
    assert!(campaigns.len() > 30, "{campaigns:?}");
    for campaign in campaigns {
        // the many devices of example 26 are rows of CSV
        let file = campaign.to_string_lossy();
        let one = !file.contains("production-line");
        check(&["check", &file]);
        check(&["plan", &file]);
        if one {
            check(&["fit", &file, "--readings", "--budget", "--correction"]);
            check(&["diagnose", &file]);
        }
    }
    for mission in examples(".mission.json") {
        check(&["navigate", &mission.to_string_lossy()]);
    }
}

#[test]
fn help_fits_80_columns() {
    for command in ["fit", "diagnose", "plan", "simulate", "navigate", "compare", "reduce", "noise", "apply", "export"]
    {
        check(&[command, "--help"]);
    }
    check(&["--help"]);
    check(&["bench", "list"]);
}

#[test]
fn lines_hang_below_their_beginning() {
    use crate::wrap::{columns, lines, narrow};
    assert_eq!(narrow("  one: two three four", 4, 12), "  one: two\n    three\n    four");
    assert_eq!(narrow("a-word-that-is-too-long b", 2, 8), "a-word-that-is-too-long\n  b");
    assert_eq!(narrow("short", 2, 8), "short");
    let text = format!("short\n  {}\n", "word ".repeat(40).trim());
    assert!(lines(&text).lines().all(|line| line.chars().count() <= COLUMNS));
    let chinese = narrow("标准不确定度\u{ff0c}自由度\u{ff08}见下\u{ff09}。k = 2.064", 2, 14);
    assert_eq!(chinese, "标准不确定度\u{ff0c}\n  自由度\u{ff08}见\n  下\u{ff09}。k =\n  2.064");
    assert_eq!(columns("标度因数 K"), 10);
    assert!(lines(&text).starts_with("short\n  word") && lines(&text).contains("\n    word"));
}
