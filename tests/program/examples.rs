//! The manual is true: every `tumble` command that a README or a page of the guide shows is run, and prints what is shown.
//!
//! A command is a fenced `sh` block with lines `tumble ...`; the `text` block that follows is its output (stdout, then stderr), or an excerpt of it
//! where a line `...` stands for what is left out. An indented command of an example is run, too; its output is not shown. The commands of an example run in a copy of its folder, those of the README and of the guide in a
//! folder with a copy of `examples`.
//! `UPDATE=1 cargo test --release --test program examples` writes the outputs anew; read the difference before you commit it.

use crate::support::*;
use assert_cmd::Command;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::Mutex;

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// Pages of Markdown in a folder.
fn pages(folder: &str) -> Vec<PathBuf> {
    let entries =
        std::fs::read_dir(root().join(folder)).expect("a folder").map(|entry| entry.expect("an entry").path());
    entries.filter(|path| path.extension().is_some_and(|kind| kind == "md")).collect()
}

/// The README, the guide, and the READMEs of the examples.
fn manual() -> Vec<PathBuf> {
    let mut found = pages("docs/guide");
    found.extend(["README.md", "docs/README.md"].map(|page| root().join(page)));
    for entry in std::fs::read_dir(root().join("examples")).expect("examples") {
        let readme = entry.expect("an entry").path().join("README.md");
        if readme.exists() {
            found.push(readme);
        }
    }
    found.sort();
    found
}

/// Commands that write a report.
const REPORTING: [&str; 7] = ["fit", "compare", "diagnose", "navigate", "plan", "reduce", "noise"];

/// Kinds of reports that were written.
static KINDS: Mutex<BTreeSet<String>> = Mutex::new(BTreeSet::new());

/// What a command prints. A report that it can write is written, too, and is as its schema says; nothing is not-a-number.
fn run(folder: &Path, line: &str) -> String {
    let words: Vec<&str> = line.split_whitespace().skip(1).take_while(|word| *word != "#").collect();
    let mut command = Command::cargo_bin("tumble").expect("the program");
    command.current_dir(folder).args(&words);
    let (reports, at) = (tempfile::tempdir().expect("a folder"), words.iter().position(|word| *word == "--json"));
    let report = match at {
        Some(at) => folder.join(words.get(at + 1).expect("a file")),
        None => reports.path().join("report.json"),
    };
    // rows of many devices have no report
    let rows = words.first() == Some(&"diagnose") && words.contains(&"--to");
    if at.is_none() && !rows && words.first().is_some_and(|word| REPORTING.contains(word)) {
        command.arg("--json").arg(&report);
    }
    let output = command.output().expect("a run");
    if let Ok(text) = std::fs::read_to_string(&report) {
        KINDS.lock().expect("kinds").insert(crate::schemas::assert_valid(&text, line));
    }
    let text = String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr);
    assert!(!text.contains("NaN"), "{line}: {text}");
    text.lines().map(str::trim_end).collect::<Vec<_>>().join("\n").trim_end().to_string()
}

/// Copy a folder with all that is in it.
fn copied(from: &Path, to: &Path) {
    std::fs::create_dir_all(to).expect("a folder");
    for entry in std::fs::read_dir(from).expect("a folder") {
        let (from, to) = (entry.as_ref().expect("an entry").path(), to.join(entry.expect("an entry").file_name()));
        if from.is_dir() {
            copied(&from, &to);
        } else {
            std::fs::copy(&from, &to).expect("a copy");
        }
    }
}

/// Where the commands of a page run, so that what they write goes with it.
fn place(page: &Path) -> tempfile::TempDir {
    let (copy, examples) = (tempfile::tempdir().expect("a folder"), root().join("examples"));
    match page.parent().expect("a folder") {
        folder if folder.starts_with(&examples) => copied(folder, copy.path()),
        _ => copied(&examples, &copy.path().join("examples")),
    }
    copy
}

/// An excerpt of an output: its lines come in this order, `...` stands for any. To renew it, a line that is not printed is replaced by the next one that
/// begins with the same word.
fn excerpt(shown: &[&str], printed: &str, path: &Path) -> String {
    assert!(!printed.contains("error:"), "{}: {printed}", path.display());
    let printed: Vec<&str> = printed.lines().collect();
    let first = |line: &str| match line.split_whitespace().next() {
        Some(rule) if rule.trim_matches('-').is_empty() => "-".to_string(),
        word => word.unwrap_or_default().to_string(),
    };
    let mut at = 0;
    let mut renewed: Vec<&str> = Vec::new();
    for line in shown {
        if *line == "..." {
            renewed.push(line);
            continue;
        }
        let left = printed.get(at..).unwrap_or_default();
        let alike = || left.iter().position(|own| first(own) == first(line));
        let is_renewed = std::env::var_os("UPDATE").is_some();
        let found = left.iter().position(|own| own == line).or_else(|| alike().filter(|_| is_renewed));
        at += found.unwrap_or_else(|| panic!("{}: `{line}` is not printed", path.display()));
        renewed.extend(printed.get(at));
        at += 1;
    }
    renewed.join("\n")
}

/// A page with the outputs of its commands as they are now, and how many there are.
fn renewed(path: &Path) -> (String, usize) {
    let text = std::fs::read_to_string(path).expect("a README");
    let copy = place(path);
    let is_example = path.starts_with(root().join("examples"));
    let (mut out, mut commands, mut shown) = (String::new(), Vec::new(), 0);
    let mut lines = text.lines();
    while let Some(line) = lines.next() {
        assert!(
            line != "```console",
            "{}: a command stands in a `sh` block, its output in a `text` block",
            path.display()
        );
        out.push_str(line);
        out.push('\n');
        // a command in a line of its own: what it prints is not shown
        if let Some(command) = line.strip_prefix("    ").filter(|own| is_example && own.starts_with("tumble ")) {
            let printed = run(copy.path(), command);
            assert!(!printed.contains("error:"), "{}: {command}: {printed}", path.display());
        }
        if line == "```sh" {
            for line in lines.by_ref() {
                out.push_str(line);
                out.push('\n');
                if line == "```" {
                    break;
                }
                if line.starts_with("tumble ") {
                    commands.push(line.to_string());
                }
            }
        } else if line == "```text" && !commands.is_empty() {
            let outputs: Vec<String> = commands.drain(..).map(|command| run(copy.path(), &command)).collect();
            shown += outputs.len();
            let output = outputs.join("\n");
            let before: Vec<&str> = lines.by_ref().take_while(|line| *line != "```").collect();
            out.push_str(&if before.contains(&"...") { excerpt(&before, &output, path) } else { output });
            out.push_str("\n```\n");
        }
    }
    assert!(commands.is_empty(), "{}: {commands:?} without a text block that shows what they print", path.display());
    (out, shown)
}

#[test]
fn pages_show_what_the_program_prints() {
    let mut total = 0;
    for path in manual() {
        let (text, shown) = renewed(&path);
        total += shown;
        if std::env::var_os("UPDATE").is_some() {
            std::fs::write(&path, &text).expect("written");
        }
        let committed = std::fs::read_to_string(&path).expect("a README");
        for (k, (is, should)) in committed.lines().zip(text.lines()).enumerate() {
            assert_eq!(is, should, "{}, line {}", path.display(), k + 1);
        }
        assert_eq!(committed.lines().count(), text.lines().count(), "{}", path.display());
    }
    println!("{total} commands shown");
    assert!(total >= 30, "{total}");
    // the others: `schemas::edges_are_answered_without_not_a_number`, and of the guide `tests/guide/journal.rs`
    let elsewhere = ["noise-report", "compare-history-report", "guide-report"];
    let of_reports = |kind: &&str| kind.ends_with("-report") && !elsewhere.contains(kind);
    let every: BTreeSet<String> =
        tumble::report::schemas().into_iter().filter(of_reports).map(str::to_string).collect();
    assert_eq!(*KINDS.lock().expect("kinds"), every, "kinds of reports that the manual's commands write");
}

/// Links and pictures of every page lead to files that are there.
#[test]
fn links_lead_somewhere() {
    let others = ["", "docs", "docs/theory", "python", "sql"].map(pages).concat();
    let mut links = 0;
    for path in manual().iter().chain(&others) {
        let text = std::fs::read_to_string(path).expect("a page");
        let parts = text.split("](").skip(1).filter_map(|rest| rest.split([')', '#']).next());
        for link in parts.filter(|link| !link.is_empty() && !link.contains("://")) {
            links += 1;
            assert!(path.with_file_name("").join(link).exists(), "{}: {link}", path.display());
        }
    }
    assert!(links > 100, "{links}");
}

/// A page of an example begins with a picture or a result, and is two screens long at most.
#[test]
fn examples_show_a_result_first() {
    for path in manual().iter().filter(|path| path.starts_with(root().join("examples"))) {
        let text = std::fs::read_to_string(path).expect("a page");
        let first = text.lines().position(|line| line == "```text" || line.starts_with("!["));
        assert!(first.is_some_and(|line| line < 20), "{}: no picture and no result at the top", path.display());
        assert!(text.lines().count() <= 140, "{}: {} lines", path.display(), text.lines().count());
    }
}

#[test]
fn the_readme_is_short_and_the_book_has_every_page() {
    let length = std::fs::metadata(root().join("README.md")).expect("the README").len();
    assert!(length < 10_000, "{length} bytes: what is more belongs into docs/guide");
    let summary = std::fs::read_to_string(root().join("docs/SUMMARY.md")).expect("the summary");
    for path in ["docs/guide", "docs/theory"].map(pages).concat() {
        let page = path.strip_prefix(root().join("docs")).expect("a page").to_string_lossy().replace('\\', "/");
        assert!(summary.contains(&format!("({page})")), "docs/SUMMARY.md has no {page}");
    }
}

#[test]
fn examples_hold_the_published_tables() {
    for (example, original) in [
        ("01-gyro-table/table1", "li2012/li2012-table1"),
        ("02-accelerometer/table2", "li2012/li2012-table2"),
        ("04-no-chain/thermometer", "gum/h3"),
        ("04-no-chain/levelling", "levelling/krumm"),
    ] {
        let text =
            std::fs::read_to_string(root().join(format!("examples/{example}.campaign.json"))).expect("a campaign");
        let example: serde_json::Value = serde_json::from_str(&text).expect("JSON");
        assert_eq!(example["readings"], json(&format!("{original}.campaign.json"))["readings"]);
    }
}

/// The truth behind example 03 (tests/scripts/example_readings.py) lies inside the expanded uncertainties.
#[test]
fn your_own_positions_hold_their_truth() {
    let folder = root().join("examples/03-your-own-positions");
    let source = |name: &str| tumble::wire::Source {
        name: name.into(),
        text: std::fs::read_to_string(folder.join(name)).expect("a file"),
    };
    let campaign = tumble::wire::read_campaign(&source("my-positions.campaign.json"), &mut |name| Ok(source(name)))
        .expect("a campaign");
    let fit = fitted(&campaign);
    assert_eq!(fit.estimate.dof, 14);
    for (id, truth) in
        [("surface_x", 12.0), ("surface_y", -25.0), ("fixture_y", 48.0), ("gyro_y", -95.0), ("gyro_z", 130.0)]
    {
        let parameter = fit.parameters.iter().find(|p| p.id == id).expect("a parameter");
        let expanded = parameter.uncertainty.as_ref().expect("an uncertainty").expanded;
        assert_within(value(&fit, id), truth * ARCSEC, expanded, id);
        assert!(expanded < 3.0 * ARCSEC, "{id}: U is {:.2} arcsec", expanded / ARCSEC);
    }
    // the scale factor's own uncertainty is the only Type B part
    let gyro_z = fit.parameters.iter().find(|p| p.id == "gyro_z").expect("a parameter");
    let kind = gyro_z.budget.iter().find(|line| line.source.contains("kI")).expect("a line for kI");
    assert!(digits(kind.u, 129.68 * ARCSEC * 0.004 / 2.9222) > 3.0);
}

/// The truth behind example 20 (tests/scripts/position_scatter_example.py): with its line, the intervals hold it; without, they do not.
#[test]
fn position_scatter_holds_its_truth_with_the_line_only() {
    let folder = root().join("examples/20-position-scatter");
    let text = |name: &str| std::fs::read_to_string(folder.join(name)).expect("a file");
    let truth: serde_json::Value = serde_json::from_str(&text("truth.json")).expect("JSON");
    let outside = |name: &str| {
        let fit = fitted(&parse(&text(name)));
        let held = |p: &&tumble::fit::ParameterResult| {
            let truth = truth[&p.id].as_f64().expect("a number");
            p.interval.is_some_and(|(low, high)| low <= truth && truth <= high)
        };
        fit.parameters.len() - fit.parameters.iter().filter(held).count()
    };
    // 15 intervals of 95 %: three outside have a probability of 4 %
    assert!(outside("with.campaign.json") <= 2);
    assert!(outside("estimated.campaign.json") <= 2);
    assert!(outside("without.campaign.json") > 2);
}
