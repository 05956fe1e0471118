//! NIST Statistical Reference Datasets, linear regression: digits of coefficients, standard errors and leverages against exact
//! rational solutions (the decimal data taken as exact), through `adjust` on plain matrices (tests/data/reference/nist_strd.json), and through
//! `fit` on campaigns whose model line is the polynomial (tests/data/nist).
//!
//! Filip stops at 7.9 digits because the powers are rounded: the exact solution of the rounded rows (in 80 digits) agrees
//! with the certified one to 7.90 for powers by repeated multiplication, to 7.61 for correctly rounded ones.

use crate::support::*;
use serde_json::Value;
use tumble::estimate::{Estimate, Group, Settings, System, adjust};

fn adjusted(set: &Value) -> Estimate {
    let model = set["model"].as_str().expect("a model");
    let x: Vec<Vec<f64>> = set["x"].as_array().expect("rows").iter().map(numbers).collect();
    let observed = numbers(&set["y"]);
    let row = |x: &Vec<f64>| -> Vec<f64> {
        if let Some(degree) = model.split("k=0..").nth(1) {
            let degree: usize = degree.parse().expect("a degree");
            return std::iter::successors(Some(1.0), |power| Some(power * x[0])).take(degree + 1).collect();
        }
        let intercept = model.starts_with("intercept").then_some(1.0);
        intercept.into_iter().chain(x.iter().copied()).collect()
    };
    let rows: Vec<Vec<f64>> = x.iter().map(row).collect();
    let m = observed.len();
    let system = System {
        rows: faer::Mat::from_fn(m, rows[0].len(), |i, j| rows[i][j]),
        observed,
        u: vec![1.0; m],
        group: vec![Group::Estimated(0); m],
    };
    adjust(&system, &Settings::default()).expect("a well-posed set")
}

#[test]
fn digits_of_an_adjustment() {
    let reference: Value = serde_json::from_str(include_str!("../data/reference/nist_strd.json")).expect("JSON");
    // Set, digits that the coefficients must have, digits that numpy has with scaled columns.
    let required = [
        ("longley", 10.0, 10.9),
        ("wampler1", 8.5, 9.2),
        ("wampler2", 11.0, 12.6),
        ("wampler3", 8.5, 9.1),
        ("wampler4", 7.5, 7.8),
        ("wampler5", 5.5, 5.8),
        ("filip", 7.5, 8.1),
        ("pontius", 11.0, 13.3),
        ("norris", 11.0, 12.5),
        ("noint1", 13.0, 15.0),
        ("noint2", 13.0, 15.0),
    ];
    println!(
        "{:10} {:>12} {:>6} {:>15} {:>10} {:>11} steps",
        "set", "coefficients", "numpy", "standard errors", "leverages", "condition"
    );
    for (id, least, numpy) in required {
        let set = &reference["sets"][id];
        let exact = &set["exact_rational_solution"];
        let estimate = adjusted(set);
        let beta = worst(estimate.unknowns.solution.iter().copied(), &numbers(&exact["beta"]));
        let errors =
            worst(estimate.unknowns.standard_uncertainty.iter().map(|u| u.expect("estimable")), &numbers(&exact["se"]));
        let leverages = worst(estimate.leverage.iter().copied(), &numbers(&exact["leverage"]));
        let condition = estimate.unknowns.condition().expect("columns");
        println!(
            "{id:10} {beta:12.1} {numpy:6.1} {errors:15.1} {leverages:10.1} {condition:11.2e} {}",
            estimate.refinements
        );
        assert_eq!(estimate.unknowns.rank, estimate.unknowns.solution.len(), "{id}: full rank");
        assert_eq!(estimate.dof as u64, exact["dof"].as_u64().expect("dof"), "{id}");
        assert!(beta >= least, "{id}: {beta:.1} digits, {least} required");
    }
}

/// The same sets as campaigns: the powers now come from a model line like `b0 + b1*x + b2*x^2`.
#[test]
fn digits_of_a_fit() {
    println!(
        "{:10} {:>8} {:>12} {:>6} {:>15} {:>10}",
        "set", "required", "coefficients", "numpy", "standard errors", "leverages"
    );
    let mut sets = 0;
    for entry in std::fs::read_dir(data("nist")).expect("the folder") {
        let name = entry.expect("an entry").file_name().to_string_lossy().into_owned();
        let Some(id) = name.strip_suffix(".expected.json") else { continue };
        let expected = json(&format!("nist/{name}"));
        let fit = fitted(&campaign(&format!("nist/{id}.campaign.json")));
        assert!(fit.not_estimable.is_empty(), "{id}: full rank");
        let (mut beta, mut errors): (f64, f64) = (16.0, 16.0);
        for (parameter, exact) in entries(&expected["parameters"]) {
            beta = beta.min(digits(value(&fit, parameter), number(&exact["exact"])));
            errors = errors.min(digits(uncertainty(&fit, parameter), number(&exact["u"])));
        }
        let leverages = worst(fit.quality().map(|row| row.leverage), &numbers(&expected["leverages"]));
        let (required, numpy) = (number(&expected["required_digits"]), number(&expected["numpy_digits"]));
        println!("{id:10} {required:8.1} {beta:12.1} {numpy:6.1} {errors:15.1} {leverages:10.1}");
        assert!(beta >= required, "{id}: {beta:.1} digits, {required} required");
        sets += 1;
    }
    assert_eq!(sets, 11);
}
