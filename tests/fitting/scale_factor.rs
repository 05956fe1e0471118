//! Errors of a scale factor by steps of rate, beside numpy (`tests/scripts/scale_factor.py`), and how often their U hold the truth.

use crate::draws::draws;
use crate::support::*;
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64Mcg;
use rand_pcg::rand_core::SeedableRng;
use serde_json::json;
use tumble::fit::{Fit, RobustMethod, Settings};

macro_rules! found {
    ($errors:expr, $id:expr) => {
        $errors.iter().find(|own| own.id == *$id).unwrap_or_else(|| panic!("no {}", $id))
    };
}

macro_rules! own_u {
    ($error:expr) => {
        $error.uncertainty.expect("an uncertainty").u
    };
}

/// Three loops with stated u: values as numpy's to 1e-7, u within 1 % of its draws (0.3 % at 100,000).
#[test]
fn loops_beside_numpy() {
    let path = format!("{}/examples/23-rate-steps/loops.campaign.json", env!("CARGO_MANIFEST_DIR"));
    let errors = fitted(&tumble::Campaign::from_path(path).expect("a campaign")).scale_factor_errors();
    let expected = json("scale_factor/expected.json");
    assert_eq!(errors.len(), 4);
    for (id, pair) in entries(&expected["loops"]) {
        let own = found!(errors, id);
        assert_within(own.value / number(&pair[0]), 1.0, 1e-7, id);
        assert_within(own_u!(own) / number(&pair[1]), 1.0, 0.01, id);
        let u: f64 = own.budget.iter().map(|line| line.u * line.u).sum::<f64>().sqrt();
        assert_within(u / own_u!(own), 1.0, 1e-12, "the budget");
    }
    assert_eq!(format!("{:?}", found!(errors, "V_repeatability_gamma_deg_s").from), "Runs(6)");
    let nonlinearity = found!(errors, "V_nonlinearity_gamma_deg_s");
    // one deviation is the largest beyond doubt: k of the normal distribution
    assert_eq!(format!("{:?}", nonlinearity.from), "Largest { alike: 1, of: 10 }");
    assert_within(nonlinearity.uncertainty.unwrap().coverage_factor, 1.959964, 1e-6, "k");
}

/// The gyros of an IMU, each by the joint about its input axis; the scatter is estimated.
#[test]
fn gyros_of_an_imu() {
    let path = format!("{}/examples/10-imu-three-axis-table/everything.campaign.json", env!("CARGO_MANIFEST_DIR"));
    let fit = fitted(&tumble::Campaign::from_path(path).expect("a campaign"));
    let errors = fit.scale_factor_errors();
    let expected = json("scale_factor/expected.json");
    assert_eq!(errors.len(), 6);
    for (id, pair) in entries(&expected["imu"]) {
        let source = format!("readings of {}", &id[..2]);
        let sd = fit.noise.sources.iter().find(|own| own.name == source).expect("a source").variance.sqrt();
        assert_within(found!(errors, id).value / number(&pair[0]), 1.0, 1e-6, id);
        assert_within(own_u!(found!(errors, id)) / (sd * number(&pair[1])), 1.0, 1e-5, id);
    }
}

fn steps(readings: Vec<serde_json::Value>, scatter: serde_json::Value) -> Fit {
    let text = json!({ "bench": "gyro-rate-steps", "readings": readings, "scatter": scatter,
        "estimate": { "V0": {}, "K": { "start": 0.02, "unit": "V/(deg/s)" }, "A": {}, "K2": {} } });
    fitted(&parse(&text.to_string()))
}

/// What is common to the readings of a run counts: K that differs from run to run moves them by the rate.
#[test]
fn deviations_that_a_run_shares() {
    let readings = || {
        let one = |run: i32, rate: f64| json!({ "gamma_deg_s": rate, "run": format!("r{run}"), "V": 0.02 * rate + 1e-6 * rate.abs(), "V_u": 1e-6 });
        (1..=3).flat_map(|run| [-100.0, -50.0, 50.0, 100.0].map(|rate| one(run, rate))).collect::<Vec<_>>()
    };
    let alone = steps(readings(), json!([])).scale_factor_errors();
    let of = |what: &str| json!([{ "of": what, "per": "run", "u": 1e-6 }]);
    let shared = steps(readings(), of("V")).scale_factor_errors();
    let id = "V_asymmetry_gamma_deg_s";
    // an offset of a run moves both senses alike, and slopes not at all
    assert_within(own_u!(found!(shared, id)) / own_u!(found!(alone, id)), 1.0, 1e-9, "an offset");
    // |w| that differs by 1e-6 from run to run: both slopes by 2 of it against each other, three runs, over K
    let sense = steps(readings(), of("A")).scale_factor_errors();
    let exact = own_u!(found!(alone, id)).hypot(2.0 * 1e-6 / 0.02 / 3f64.sqrt() * 1e6);
    assert_within(own_u!(found!(sense, id)) / exact, 1.0, 1e-3, "a sense");
}

/// One reading typed wrongly: robust estimates of the errors are those without it, and least squares are not.
#[test]
fn a_bad_reading_and_robust_errors() {
    let rates = [-100.0, -60.0, -20.0, 20.0, 60.0, 100.0];
    let noise = [3.0, -5.0, 1.0, 4.0, -2.0, -4.0, 2.0, 5.0, -3.0, -1.0, 0.0, 2.0, -4.0, 1.0, 3.0, -2.0, 5.0, -3.0]
        .map(|e| e * 1e-6);
    let all = || {
        (0..18).map(|k| json!({ "gamma_deg_s": rates[k % 6], "V": 0.02 * rates[k % 6] + noise[k] + if k == 5 { 9e-3 } else { 0.0 } }))
    };
    let text = |readings: Vec<serde_json::Value>| {
        json!({ "bench": "gyro-rate-steps", "readings": readings, "estimate": { "V0": {}, "K": { "start": 0.02 } } })
            .to_string()
    };
    let without = fitted(&parse(&text(all().enumerate().filter(|(k, _)| *k != 5).map(|(_, own)| own).collect())));
    let with = parse(&text(all().collect()));
    let tukey = Settings { robust: Some(RobustMethod::Tukey), ..Settings::default() };
    let (plain, robust) = (fitted(&with).scale_factor_errors(), fit_with(&with, tukey).scale_factor_errors());
    let without = without.scale_factor_errors();
    for id in ["V_nonlinearity_gamma_deg_s", "V_asymmetry_gamma_deg_s"] {
        let exact = found!(without, id).value;
        assert_within(found!(robust, id).value, exact, 0.5 * own_u!(found!(without, id)), id);
        assert!((found!(plain, id).value - exact).abs() > 50.0, "{id}: {}", found!(plain, id).value);
    }
}

/// Two rates are a line, and no readings of one sense have no asymmetry; without an input axis nothing is told.
#[test]
fn what_the_readings_do_not_show() {
    let one = |rate: f64, v: f64| json!({ "gamma_deg_s": rate, "V": v, "V_u": 1e-6 });
    let ids =
        |readings| steps(readings, json!([])).scale_factor_errors().into_iter().map(|own| own.id).collect::<Vec<_>>();
    assert_eq!(ids(vec![one(10.0, 0.2), one(-10.0, -0.2), one(10.0, 0.2), one(-10.0, -0.2)]), Vec::<String>::new());
    assert_eq!(
        ids(vec![one(10.0, 0.2), one(20.0, 0.4), one(30.0, 0.61), one(40.0, 0.8)]),
        ["V_nonlinearity_gamma_deg_s"]
    );
    let table = fitted(&campaign("li2012/li2012-table1.campaign.json"));
    assert!(table.scale_factor_errors().is_empty());
}

/// 2,000 campaigns (200 by default): loops of 10 rates, deviations from none to thirty times the noise, noise stated and unknown. U of a largest
/// deviation holds at least its level: it is wider where several may be the largest.
#[test]
fn coverage() {
    let mut random = Pcg64Mcg::seed_from_u64(1431);
    let mut normal = move || -> f64 { StandardNormal.sample(&mut random) };
    let rates = [-200.0, -150.0, -100.0, -50.0, -20.0, 20.0, 50.0, 100.0, 150.0, 200.0];
    let count = draws(200, 2000);
    let mut held = std::collections::BTreeMap::<(String, bool), (usize, usize)>::new();
    for draw in 0..count {
        let (stated, runs_differ) = (draw % 2 == 0, draw % 4 < 2);
        let noise = 2e-6;
        let size = noise * if draw % 8 < 4 { 0.0 } else { 10f64.powf(1.5 * (draw % 97) as f64 / 97.0) };
        let (curve, sense) = (size * normal() / 40_000.0, size * normal() / 200.0);
        let loops = size * normal().abs();
        let of_run = if runs_differ { 5e-6 } else { 0.0 };
        let true_at = |rate: f64| 0.002 + 0.02 * rate + sense * rate.abs() + curve * rate * rate;
        let mut readings = Vec::new();
        for way in 0..6 {
            let slope = 0.02 * of_run * normal();
            for k in 0..rates.len() {
                let rate: f64 = if way % 2 == 0 { rates[k] } else { rates[rates.len() - 1 - k] };
                let approach = if way % 2 == 0 { 0.5 } else { -0.5 } * loops * (1.0 - (rate / 200.0).powi(2));
                let mut own =
                    json!({ "gamma_deg_s": rate, "V": true_at(rate) + slope * rate + approach + noise * normal() });
                if stated {
                    own["V_u"] = json!(noise);
                }
                readings.push(own);
            }
        }
        let errors = steps(readings, json!([])).scale_factor_errors();
        let mean = |of: &[f64]| of.iter().sum::<f64>() / of.len() as f64;
        let values = rates.map(true_at);
        let squares: f64 = rates.iter().map(|rate| rate * rate).sum();
        let through = |from: usize, to: usize| {
            let (x, y) = (mean(&rates[from..to]), mean(&values[from..to]));
            let both = rates[from..to].iter().zip(&values[from..to]).map(|(a, b)| (a - x) * (b - y)).sum::<f64>();
            both / rates[from..to].iter().map(|a| (a - x).powi(2)).sum::<f64>()
        };
        let (slope, down, up) = (through(0, 10), through(0, 5), through(5, 10));
        let left = rates.iter().zip(&values).map(|(rate, own)| (own - mean(&values) - slope * rate).abs());
        let full = slope * 200.0 / 1e6;
        // the slope of a run: what differs between runs, and the noise of its readings
        let of_slopes = (of_run * 0.02).hypot(noise / squares.sqrt()) / slope * 1e6;
        let both = 1.0 - 0.01_f64;
        let true_values = [
            ("nonlinearity", left.fold(0.0, f64::max) / full, !runs_differ),
            ("asymmetry", 2.0 * (up - down) / (up + down) * 1e6, !runs_differ),
            ("hysteresis", loops * both / full, !runs_differ),
            ("repeatability", of_slopes, true),
        ];
        for (what, truth, _) in true_values.iter().filter(|own| own.2) {
            let own = found!(errors, format!("V_{what}_gamma_deg_s").as_str());
            let inside = (own.value - truth).abs() <= own.uncertainty.expect("u").expanded;
            let slot = held.entry((what.to_string(), stated)).or_default();
            *slot = (slot.0 + usize::from(inside), slot.1 + 1);
        }
    }
    for ((what, stated), (inside, of)) in held {
        let share = inside as f64 / of as f64;
        println!(
            "{what:<14} noise {:<9} {inside:>5} of {of:<5} {:.1} %",
            if stated { "stated" } else { "estimated" },
            100.0 * share
        );
        // three standard deviations below the level
        let least = 0.95 - 3.0 * (0.95 * 0.05 / of as f64).sqrt();
        assert!(share > least, "{what}: {inside} of {of}");
        if matches!(what.as_str(), "asymmetry" | "repeatability") && stated {
            assert!(
                share < 0.95 + 3.0 * (0.95 * 0.05 / of as f64).sqrt() + 0.5 / of as f64,
                "{what}: {inside} of {of}"
            );
        }
    }
}

/// Limits of a scale factor's errors are judged like any other; where the readings do not give one, that is said and stays undecided.
#[test]
fn limits_of_errors_are_judged() {
    let text = |limits: serde_json::Value, rates: &[f64]| {
        let one = |(k, rate): (usize, &f64)| json!({ "gamma_deg_s": rate, "V": 0.02 * rate + 1e-6 * rate.abs() + 1e-9 * (k % 3) as f64, "V_u": 1e-7 });
        let readings: Vec<serde_json::Value> = rates.iter().enumerate().map(one).collect();
        json!({ "bench": "gyro-rate-steps", "readings": readings, "limits": limits, "decision": "guard-u",
            "estimate": { "V0": {}, "K": { "start": 0.02, "unit": "V/(deg/s)" }, "A": {}, "K2": {} } })
        .to_string()
    };
    let rates = [-100.0, -50.0, 50.0, 100.0, -100.0, -50.0, 50.0, 100.0];
    // both senses: 2 (0.020001 - 0.019999) / 0.04 = 100 ppm; u of a slope is 1e-7 / (50 V) and so on, far below the margins
    let outcome = |between: serde_json::Value| {
        let limits = json!({ "V_asymmetry_gamma_deg_s": { "between": between, "unit": "%" } });
        let report = tumble::report::conformity(&fitted(&parse(&text(limits, &rates)))).expect("limits");
        assert_within(report.quantities[0].value.expect("a value"), 100.0, 1.0, "ppm");
        assert_eq!(report.quantities[0].unit, "ppm");
        (report.outcome.name(), report.quantities[0].upper)
    };
    assert_eq!(outcome(json!([null, 0.02])), ("pass", Some(200.0)));
    assert_eq!(outcome(json!([null, 0.005])), ("fail", Some(50.0)));
    let untold =
        fitted(&parse(&text(json!({ "V_asymmetry_gamma_deg_s": [null, 50] }), &[50.0, 70.0, 90.0, 100.0, 80.0])));
    let report = tumble::report::conformity(&untold).expect("limits");
    assert_eq!((report.outcome.name(), report.quantities[0].value), ("undecided", None));
    assert!(untold.remarks().iter().any(|own| own.to_string().starts_with("V_asymmetry_gamma_deg_s has limits")));
    // written and read again
    let campaign = parse(&text(json!({ "V_hysteresis_gamma_deg_s": [0, 50] }), &rates));
    let file = tumble::wire::campaign_file(&campaign, tumble::wire::BenchRef::Named("gyro-rate-steps".into()));
    let again = parse(&serde_json::to_string(&file).expect("JSON"));
    assert_eq!(again.limits, campaign.limits);
    let refused = tumble::wire::read_campaign(
        &tumble::wire::Source { name: "c".into(), text: text(json!({ "V_wobble_gamma_deg_s": [0, 1] }), &rates) },
        &mut |_| unreachable!(),
    );
    assert!(refused.expect_err("a fault").to_string().contains("V_repeatability_gamma_deg_s"));
}
