//! The multi-position gravity test of an accelerometer on a dividing head.

use crate::support::*;
use tumble::compare;
use tumble::fit::{self, Settings};

const FOLDER: &str = "examples/13-accelerometer-dividing-head";

#[test]
fn noiseless_truth_comes_back() {
    for name in ["dividing-head", "dividing-head-tilted"] {
        let campaign = campaign(&format!("tests/data/simulated/{name}.campaign.json"));
        let truth = truth(&format!("tests/data/simulated/{name}.truth.json"));
        for settings in [Settings::default(), exact()] {
            let fit = fit::fit(&campaign, &settings).unwrap();
            // coefficients of 1e-5 V from readings of 1.3 V that are rounded to 1e-16 of themselves
            let (error, id) = worst_relative(&fit, &truth, 1e-5);
            assert!(error < 1e-9, "{name}: {id} {error:.1e}");
        }
    }
}

#[test]
fn fourier_sums_are_least_squares_on_4_8_12_and_24_equidistant_positions() {
    let forms = compare::closed_forms("accelerometer-dividing-head").unwrap();
    for count in [4, 8, 12, 24] {
        let campaign = campaign(&format!("{FOLDER}/head-{count}.campaign.json"));
        let comparison = compare::compare(&campaign, &forms, &Settings::default()).unwrap();
        assert_eq!(comparison.groups.len(), 1);
        let mut compared = 0;
        for (closed, square) in comparison.groups[0].closed_form.iter().zip(&comparison.groups[0].least_squares) {
            if let (Some(closed), Some(square)) = (closed, square) {
                // both round at 1e-16 of the largest reading
                assert!((closed - square).abs() < 1e-14, "{count}: {closed} {square}");
                compared += 1;
            }
        }
        assert_eq!(compared, campaign.unknowns());
    }
}

#[test]
fn intervals_hold_what_they_promise() {
    for (count, campaigns) in [(8, 3000), (24, 3000)] {
        let campaign = campaign(&format!("{FOLDER}/head-{count}.campaign.json"));
        let truth = truth("tests/data/simulated/dividing-head.truth.json");
        coverage(&format!("{count} positions"), &campaign, &truth, &|_, _| 5e-6, campaigns, &Settings::default(), 0.0);
    }
}

#[test]
fn four_positions_leave_the_cubic_term_in_the_scale_factor_and_the_head_zero_hides_in_the_cross_axis_term() {
    let text = read(&format!("{FOLDER}/head-4.campaign.json")).replacen(
        "\"KP\": {}",
        "\"KP\": {}, \"K3\": {}, \"KIP\": {}",
        1,
    );
    let fit = fit::fit(&parse("four", &text).unwrap(), &Settings::default()).unwrap();
    let defects: Vec<&str> = fit.not_estimable.iter().flat_map(|s| &s.estimable).map(|c| c.text.as_str()).collect();
    println!("{defects:?}");
    assert!(defects.contains(&"K1 + K3"));
    let text = read(&format!("{FOLDER}/head-24.campaign.json"))
        .replacen("\"estimate\": {", "\"estimate\": { \"head_zero\": {},", 1)
        .replacen("\"K1\": {}", "\"K1\": { \"start\": 1.3 }", 1);
    let fit = fit::fit(&parse("zero", &text).unwrap(), &Settings::default()).unwrap();
    let text = format!("{:?}", fit.not_estimable);
    assert_eq!(fit.not_estimable.len(), 1, "{text}");
    assert!(text.contains("head_zero") && text.contains("KP"));
    assert!(fit.is_rejected());
}

#[test]
fn thirty_eight_positions_of_an_unknown_attitude_calibrate_a_triad_by_the_norm_of_gravity() {
    let campaign = campaign("examples/14-xsens-static-positions/xsens.campaign.json");
    let expected: serde_json::Value =
        serde_json::from_str(&read("tests/data/xsens/static-positions.expected.json")).unwrap();
    let fit = fit::fit(&campaign, &exact()).unwrap();
    assert!(fit.convergence.as_ref().unwrap().converged);
    for p in &fit.parameters {
        let own = &expected["parameters"][p.id.as_str()];
        let u = own["u"].as_f64().unwrap();
        // 40-digit Gauss-Newton of tests/scripts/xsens_campaign.py
        assert!((p.value.unwrap() - own["value"].as_f64().unwrap()).abs() < 1e-6 * u, "{}", p.id);
        assert!((p.uncertainty.as_ref().unwrap().u / u - 1.0).abs() < 1e-6, "{}", p.id);
    }
}
