//! Example 11 keeps what its README says: every row of its tables is a row that the program prints.
use assert_cmd::Command;

fn printed(mission: &str) -> String {
    let out = Command::cargo_bin("tumble").unwrap().args(["navigate", mission]).assert().success();
    String::from_utf8(out.get_output().stdout.clone()).unwrap()
}

/// The cells of a row of the README.
fn cells(row: &str) -> Vec<String> {
    row.trim_matches('|').split('|').map(|cell| cell.trim().to_string()).collect()
}

/// The cells of a row that the program prints: columns are two spaces apart at least.
fn columns(row: &str) -> Vec<String> {
    row.split("  ").map(str::trim).filter(|cell| !cell.is_empty()).map(str::to_string).collect()
}

#[test]
fn the_readme_is_true() {
    let readme = include_str!("../../examples/11-navigator/README.md");
    let printed = printed("examples/11-navigator/findings.mission.json");
    let rows: Vec<Vec<String>> = printed.lines().map(columns).collect();
    let mut checked = 0;
    for row in readme.lines().filter(|line| line.starts_with("| static |") || line.contains("/ static")) {
        // the perfect navigator's rounding stands under a ratio to nothing; its digits are the machine's own
        if row.contains("accelerometer_scale_factor") {
            continue;
        }
        assert!(rows.contains(&cells(row)), "not printed: {row}");
        checked += 1;
    }
    assert_eq!(checked, 18);
}

#[test]
fn the_carried_covariance_is_true() {
    let printed = printed("examples/11-navigator/carried.mission.json");
    let position = |by: &str| -> f64 {
        let row = printed.lines().find(|line| line.starts_with("static ") && line.contains(by)).unwrap();
        columns(row)[5].parse().unwrap()
    };
    let (linear, drawn) = (position("linear covariance"), position("Monte Carlo"));
    assert!((linear / 41_812.0 - 1.0).abs() < 1e-3, "{linear}");
    // 200 draws: a standard deviation good to 5 %
    assert!((drawn / linear - 1.0).abs() < 0.15, "{drawn}");
}
