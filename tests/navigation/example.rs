//! Example 09 keeps what its README says: every row of its tables is a row that the program prints.
use assert_cmd::Command;

fn printed(mission: &str) -> String {
    let out = Command::cargo_bin("tumble").unwrap().args(["navigate", mission]).assert().success();
    String::from_utf8(out.get_output().stdout.clone()).unwrap()
}

/// The words of a row, of the README or printed, without its bars.
fn words(row: &str) -> Vec<&str> {
    row.split_whitespace().filter(|word| *word != "|").collect()
}

#[test]
fn the_readme_is_true() {
    let readme = include_str!("../../examples/09-navigator/README.md");
    let printed = printed("examples/09-navigator/findings.mission.json");
    let rows: Vec<Vec<&str>> = printed.lines().map(words).collect();
    let mut checked = 0;
    for row in readme.lines().filter(|line| line.starts_with("| static |") || line.contains("/ static")) {
        // the perfect navigator's rounding stands under a ratio to nothing; its digits are the machine's own
        if row.contains("accelerometer_scale_factor") {
            continue;
        }
        assert!(rows.contains(&words(row)), "not printed: {row}");
        checked += 1;
    }
    assert_eq!(checked, 18);
}

#[test]
fn the_carried_covariance_is_true() {
    let printed = printed("examples/09-navigator/carried.mission.json");
    let position = |by: &str| -> f64 {
        let row = printed.lines().find(|line| line.starts_with("static ") && line.contains(by)).unwrap();
        words(row).last().unwrap().parse().unwrap()
    };
    let (linear, drawn) = (position("linear covariance"), position("Monte Carlo"));
    assert!((linear / 41_812.0 - 1.0).abs() < 1e-3, "{linear}");
    // 200 draws: a standard deviation good to 5 %
    assert!((drawn / linear - 1.0).abs() < 0.15, "{drawn}");
}
