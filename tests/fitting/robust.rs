//! Suspicious readings: Wicki's net, where plain least squares spreads two blunders over innocent rows, and random campaigns.

use crate::draws::draws;
use crate::support::{campaign, fit_with, fitted, json, parse};
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64Mcg;
use rand_pcg::rand_core::SeedableRng;
use tumble::campaign::Campaign;
use tumble::fit::{RobustMethod, Settings};

fn numbers(value: &serde_json::Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect()
}

/// Heights of 6, 8, 10, 11 over point 9, from nine height differences with stated weights.
fn wicki(contaminated: bool) -> Campaign {
    let all = json("variance_components_and_blunders.json");
    let points = ["6", "8", "10", "11"];
    let mut readings = Vec::new();
    for (k, o) in all["wicki_outliers"]["obs"].as_array().unwrap().iter().enumerate() {
        let text = |key: &str| o[key].as_str().unwrap();
        let mut dh: f64 = text("dh_mm").parse().unwrap();
        // the reference holds the contaminated differences: 6->8 is 100 mm too long, 9->10 is 100 mm too short
        if !contaminated && k == 0 {
            dh -= 100.0;
        }
        if !contaminated && k == 6 {
            dh += 100.0;
        }
        let u = 1.0 / text("weight").parse::<f64>().unwrap().sqrt();
        let sign = |p: &str| {
            if text("to") == p {
                1
            } else if text("from") == p {
                -1
            } else {
                0
            }
        };
        let columns: Vec<String> = points.iter().map(|p| format!(r#""c{p}": {}"#, sign(p))).collect();
        readings.push(format!(r#"{{{}, "dh": {dh}, "dh_u": {u}}}"#, columns.join(",")));
    }
    parse(&format!(
        r#"{{"bench": {{"id": "wicki", "sensors": {{"dh": {{"unit": "mm", "model": "h6*c6 + h8*c8 + h10*c10 + h11*c11"}}}}}},
            "estimate": {{"h6": {{}}, "h8": {{}}, "h10": {{}}, "h11": {{}}}}, "readings": [{}]}}"#,
        readings.join(",")
    ))
}

#[test]
fn wickis_net() {
    let all = json("variance_components_and_blunders.json");
    let expected = &all["wicki_outliers"]["recomputed"];
    let bad = fitted(&wicki(true));
    for (found, expected) in bad.point.iter().zip(numbers(&expected["contaminated_L2_mm"])) {
        assert!((found - expected).abs() < 1e-7, "{found} {expected}");
    }
    // their residuals are computed minus observed, ours observed minus computed; signs aside the w statistics are the same
    for (row, w) in bad.quality().zip(numbers(&expected["w_contaminated"])) {
        assert!((row.studentized.unwrap().abs() - w.abs()).abs() < 1e-9);
    }
    let chi2 = expected["chi2_contaminated"].as_f64().unwrap();
    assert!((bad.global_test.unwrap().chi_square / chi2 - 1.0).abs() < 1e-12);
    let found = bad.checks.snooping.as_ref().unwrap();
    let mut rows: Vec<usize> = found.suspects.iter().map(|s| s.row).collect();
    rows.sort_unstable();
    assert_eq!(rows, [0, 6], "{:?}", found.suspects);
    let clean = numbers(&expected["clean_L2_mm"]);
    for ((value, change), clean) in bad.point.iter().zip(&bad.checks.without_suspects).zip(&clean) {
        assert!((value + change - clean).abs() < 4.0, "{} {clean}", value + change);
    }
    for method in [RobustMethod::Huber, RobustMethod::Tukey, RobustMethod::L1] {
        let fit = fit_with(&wicki(true), Settings { robust: Some(method), ..Settings::default() });
        let worst = fit.point.iter().zip(&clean).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        println!("{}: at most {worst:.2} mm from the clean net (least squares 57.4)", method.name());
        assert!(fit.robust.as_ref().unwrap().converged);
        assert!(worst < 12.0);
    }
    let good = fitted(&wicki(false));
    assert!(good.checks.snooping.as_ref().unwrap().suspects.is_empty());
    for (found, expected) in good.point.iter().zip(&clean) {
        assert!((found - expected).abs() < 1e-7, "{found} {expected}");
    }
}

#[test]
fn blunders_are_found_and_clean_campaigns_are_left_alone() {
    let start = campaign("li2012/li2012-table1.campaign.json");
    let fit = fitted(&start);
    let fitted_values: Vec<f64> = fit
        .design
        .predicted
        .iter()
        .zip(&fit.system.observed)
        .zip(&fit.estimate.residuals)
        .map(|((p, o), v)| p + o - v)
        .collect();
    let mut random = Pcg64Mcg::seed_from_u64(3);
    let trials = 2000;
    let (mut alarms, mut found) = (0, 0);
    for k in 0..trials {
        let mut own = start.clone();
        for (reading, value) in own.readings.rows.iter_mut().zip(&fitted_values) {
            let z: f64 = StandardNormal.sample(&mut random);
            reading.observations[0].value = value + 1e-4 * z;
        }
        alarms += usize::from(!fitted(&own).checks.snooping.unwrap().suspects.is_empty());
        // two blunders
        let (a, b) = (k % 30, (k * 7 + 11) % 30);
        if a != b {
            own.readings.rows[a].observations[0].value += 12e-4;
            own.readings.rows[b].observations[0].value -= 10e-4;
            let mut rows: Vec<usize> = fitted(&own).checks.snooping.unwrap().suspects.iter().map(|s| s.row).collect();
            rows.sort_unstable();
            found += usize::from(rows.contains(&a) && rows.contains(&b));
        } else {
            found += 1;
        }
    }
    let (alarms, found) = (alarms as f64 / trials as f64, found as f64 / trials as f64);
    println!(
        "false alarms {:.2} % (5 % promised), two blunders of 12 and 10 sigma found in {:.2} %",
        100.0 * alarms,
        100.0 * found
    );
    assert!((alarms - 0.05).abs() < 0.02);
    assert!(found > 0.95);
}

/// Without blunders the robust intervals are honest: their variance is that of the estimates.
#[test]
fn robust_covariance_is_that_of_simulated_estimates() {
    let start = campaign("li2012/li2012-table1.campaign.json");
    let values: Vec<f64> = start.readings.rows.iter().map(|r| r.observations[0].value).collect();
    let fit = fitted(&start);
    let truth: Vec<f64> = values.iter().zip(&fit.estimate.residuals).map(|(y, v)| y - v).collect();
    for method in [RobustMethod::Huber, RobustMethod::Tukey, RobustMethod::L1] {
        let mut random = Pcg64Mcg::seed_from_u64(5);
        let settings = Settings { robust: Some(method), ..Settings::default() };
        let (trials, y2) = (draws(300, 1500), 4);
        let (mut square, mut stated) = (0.0, 0.0);
        for _ in 0..trials {
            let mut own = start.clone();
            for (reading, value) in own.readings.rows.iter_mut().zip(&truth) {
                let z: f64 = StandardNormal.sample(&mut random);
                reading.observations[0].value = value + 1e-4 * z;
            }
            let found = fit_with(&own, settings);
            square += (found.point[y2] - fit.point[y2]).powi(2) / trials as f64;
            stated += found.parameters[y2].uncertainty.unwrap().u.powi(2) / trials as f64;
        }
        let ratio = (stated / square).sqrt();
        println!("{}: stated over true standard deviation {ratio:.3}", method.name());
        assert!((0.85..1.3).contains(&ratio), "{ratio}");
    }
}

/// Huber 1981, eq. 6.5: `K = 1 + n/m var(psi')/mean(psi')^2`; of the bisquare psi' has values between 0 and 1. The estimate is checked by its own
/// equations, sum psi = sum x psi = 0, and u follows from it by hand.
#[test]
fn tukeys_covariance_is_hubers_formula() {
    let y = [0.0, 0.5, -0.3, 0.8, -1.0, 1.2, 2.5, -2.0];
    let rows: Vec<String> = y.iter().enumerate().map(|(x, y)| format!(r#"{{"x": {x}, "y": {y}, "y_u": 1}}"#)).collect();
    let campaign = parse(&format!(
        r#"{{ "bench": {{ "id": "line", "sensors": {{ "y": {{ "model": "a + b*x" }} }} }}, "estimate": {{ "a": {{}}, "b": {{}} }},
           "readings": [ {} ] }}"#,
        rows.join(", ")
    ));
    let fit = fit_with(&campaign, Settings { robust: Some(RobustMethod::Tukey), ..Settings::default() });
    let residual = |k: usize| y[k] - fit.point[0] - fit.point[1] * k as f64;
    let t: Vec<f64> = (0..8).map(|k| (residual(k) / 4.685).powi(2)).collect();
    let psi: Vec<f64> = (0..8).map(|k| residual(k) * (1.0 - t[k]).powi(2)).collect();
    assert!(t.iter().all(|t| *t < 1.0));
    assert!(psi.iter().sum::<f64>().abs() < 1e-9);
    assert!(psi.iter().enumerate().map(|(k, psi)| k as f64 * psi).sum::<f64>().abs() < 1e-8);
    let slopes: Vec<f64> = t.iter().map(|t| (1.0 - t) * (1.0 - 5.0 * t)).collect();
    let mean = slopes.iter().sum::<f64>() / 8.0;
    let variance = slopes.iter().map(|slope| (slope - mean).powi(2)).sum::<f64>() / 8.0;
    let k = 1.0 + 2.0 / 8.0 * variance / (mean * mean);
    // of (A'A)^-1 with x = 0 to 7: sum x^2/(m sum (x - 3.5)^2) = 140/(8*42), and 1/42
    let common = k * (psi.iter().map(|psi| psi * psi).sum::<f64>() / 6.0).sqrt() / mean;
    for (own, cofactor) in fit.parameters.iter().zip([140.0 / 336.0, 1.0 / 42.0_f64]) {
        let u = own.uncertainty.unwrap().u;
        assert!((u / (common * cofactor.sqrt()) - 1.0).abs() < 1e-9, "{u}");
    }
    // as an independent computation with numpy printed it
    assert!((fit.parameters[0].uncertainty.unwrap().u - 1.19831).abs() < 5e-6);
}
