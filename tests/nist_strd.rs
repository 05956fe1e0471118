//! NIST Statistical Reference Datasets, linear regression, through `adjust`: digits of coefficients, standard errors and
//! leverages against exact rational solutions (tests/data/nist_strd.json; the decimal data taken as exact).
//!
//! Filip stops at 7.9 digits because the powers are rounded: the exact solution of the rounded rows (in 80 digits) agrees
//! with the certified one to 7.90 for powers by repeated multiplication, to 7.61 for correctly rounded ones.

use serde_json::Value;
use tumble::estimate::{Estimate, Group, Settings, System, adjust};

fn number(value: &Value) -> f64 {
    value.as_f64().or_else(|| value.as_str()?.parse().ok()).expect("a number")
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().expect("a list").iter().map(number).collect()
}

/// Log relative error, the number of correct digits; at most 15.9.
fn digits(found: f64, exact: f64) -> f64 {
    let error = if exact == 0.0 { found.abs() } else { ((found - exact) / exact).abs() };
    (-error.max(1.3e-16).log10()).max(0.0)
}

fn worst(found: impl IntoIterator<Item = f64>, exact: &[f64]) -> f64 {
    found.into_iter().zip(exact).map(|(found, exact)| digits(found, *exact)).fold(16.0, f64::min)
}

fn fit(set: &Value) -> Estimate {
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
fn digits_of_the_certified_values() {
    let reference: Value = serde_json::from_str(include_str!("data/nist_strd.json")).expect("JSON");
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
        let estimate = fit(set);
        let beta = worst(estimate.solution.iter().copied(), &numbers(&exact["beta"]));
        let errors = worst(estimate.standard_uncertainty.iter().map(|u| u.expect("estimable")), &numbers(&exact["se"]));
        let leverages = worst(estimate.leverage.iter().copied(), &numbers(&exact["leverage"]));
        let condition = estimate.condition.expect("columns");
        println!(
            "{id:10} {beta:12.1} {numpy:6.1} {errors:15.1} {leverages:10.1} {condition:11.2e} {}",
            estimate.refinements
        );
        assert_eq!(estimate.rank, estimate.solution.len(), "{id}: full rank");
        assert_eq!(estimate.dof as u64, exact["dof"].as_u64().expect("dof"), "{id}");
        assert!(beta >= least, "{id}: {beta:.1} digits, {least} required");
    }
}
