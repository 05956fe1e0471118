//! The bytes of a report do not depend on the number of threads, and no product reserves address space for each of them.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// The campaigns below a folder.
fn campaigns(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            campaigns(&path, found);
        } else if path.to_string_lossy().ends_with(".campaign.json") {
            found.push(path);
        }
    }
}

fn fit(path: &Path, threads: usize) -> Output {
    let mut command = Command::new(assert_cmd::cargo::cargo_bin!("tumble"));
    command.current_dir(path.parent().expect("a folder")).env("RAYON_NUM_THREADS", threads.to_string());
    command.arg("fit").arg(path.file_name().expect("a name")).args(["--json", "-"]).output().expect("a run")
}

#[test]
fn reports_are_the_same_at_any_number_of_threads() {
    let mut paths = Vec::new();
    for folder in ["examples", "data/campaigns", "tests/data/hidden"] {
        campaigns(&root().join(folder), &mut paths);
    }
    let (mut fitted, mut different) = (0, Vec::new());
    for path in &paths {
        let one = fit(path, 1);
        fitted += usize::from(one.stdout.starts_with(b"{"));
        if [2, 4, 8].into_iter().any(|threads| fit(path, threads) != one) {
            different.push(path);
        }
    }
    assert!(fitted > 40, "{fitted} of {} campaigns were fitted", paths.len());
    assert!(different.is_empty(), "{different:#?}");
}

/// A machine with a large cache reserves the most.
#[cfg(target_os = "linux")]
#[test]
fn two_gigabytes_of_address_space_are_enough() {
    for example in ["20-position-scatter", "26-production-line"] {
        let folder = root().join("examples").join(example);
        let mut paths = Vec::new();
        campaigns(&folder, &mut paths);
        for path in paths {
            let line = format!("ulimit -v 2000000; exec '{}' diagnose \"$0\"", env!("CARGO_BIN_EXE_tumble"));
            let mut command = Command::new("sh");
            command.current_dir(&folder).args(["-c", &line]).arg(&path).env("RAYON_NUM_THREADS", "8");
            let output = command.output().expect("a run");
            let code = output.status.code();
            assert!(
                code.is_some_and(|code| code < 3),
                "{}: {:?}",
                path.display(),
                String::from_utf8_lossy(&output.stderr)
            );
        }
    }
}
