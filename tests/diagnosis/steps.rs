//! The gap step by step, what is never named, and what is never silent.

use crate::support::{json as fixture, parse};
use serde_json::{Value, json};
use tumble::campaign::Campaign;
use tumble::diagnosis::{Diagnosis, Settings, Verdict, candidates, diagnose};
use tumble::{simulate, wire};

fn diagnosed(campaign: &Campaign) -> Diagnosis {
    diagnose(campaign, &wire::built_in_effects().unwrap(), &Settings::default()).unwrap()
}

fn simulated(schedule: &Value, truth: &Value, seed: u64) -> Campaign {
    let schedule = parse(&schedule.to_string());
    let truth = wire::Source { name: "truth".into(), text: truth.to_string() };
    let truth = wire::read_truth(&truth, &schedule).unwrap_or_else(|error| panic!("{error}"));
    simulate::simulate(&schedule, &truth, seed).unwrap()
}

fn names(found: &Diagnosis) -> Vec<&str> {
    found.effects.iter().map(|own| own.effect.regressor.as_str()).collect()
}

/// An accelerometer at 24 angles, three times.
fn head(stated: bool) -> (Value, Value) {
    let readings: Vec<Value> = (0..72).map(|k| json!({ "beta_deg": 15 * (k % 24), "time_s": 100 * k })).collect();
    let schedule = json!({ "bench": "accelerometer-plumb-plane", "known": { "kI": { "value": 1.299 } },
        "estimate": { "V0": {}, "dtheta_y2": {}, "dtheta_z2": {} }, "readings": readings });
    let truth = json!({ "values": { "V0": { "value": 0.002 } }, "noise": { "V": { "sd": 3e-6, "stated": stated } } });
    (schedule, truth)
}

#[test]
fn an_effect_beside_an_unknown_pattern_is_named_and_the_rest_described() {
    let (schedule, mut truth) = head(true);
    // t = 31 and 33 against the base model: 8 above noise and pattern together
    truth["effects"] =
        json!([{ "regressor": "abs(a_P)", "value": 3.5e-5 }, { "regressor": "sign(sin(5*beta+0.4))", "value": 6e-6 }]);
    let mut named = 0;
    for seed in 0..8 {
        let found = diagnosed(&simulated(&schedule, &truth, seed));
        // harmonics of the square wave: the fifth, and the fifteenth, which is the ninth at heads 15 degrees apart
        let there = ["abs(a_P)", "sin(5*beta)", "cos(5*beta)", "sin(9*beta)", "cos(9*beta)"];
        let wrong = names(&found).into_iter().find(|own| !there.contains(own));
        assert!(wrong.is_none(), "seed {seed}: {wrong:?}");
        let suspected = found.suspected.iter().any(|own| own.effect.regressor == "abs(a_P)");
        let Some(effect) = found.effects.iter().find(|own| own.effect.regressor == "abs(a_P)") else {
            assert!(suspected && found.verdict != Verdict::NothingMissing, "seed {seed}: {:?}", names(&found));
            continue;
        };
        named += 1;
        let (given, with) = (found.steps.first().unwrap(), found.steps.last().unwrap());
        assert!(given.with.is_empty() && with.with.contains(&"abs(a_P)".to_string()));
        assert_eq!((given.gap.dof, with.gap.dof), (69, 69 - found.effects.len()));
        assert!(with.gap.chi_square < 0.5 * given.gap.chi_square && effect.probability >= 0.95);
        let angle = found.changes.iter().find(|own| own.id == "dtheta_y2").unwrap();
        let Some(rest) = found.unexplained.as_ref() else { continue };
        // a square wave of 6e-6, less what the model and its fifth harmonic take up
        assert!(rest.sd.unwrap() < 1.35 * 6e-6, "{:?}", rest.sd);
        assert!(angle.remainder_u > 0.0);
    }
    assert!(named >= 1, "none of 8 is named");
}

/// A cube of the turning rate hidden on the five published positions: `gamma_deg_s*sin(gamma)` has a column of 1e-16.
#[test]
fn a_column_of_rounding_is_no_candidate() {
    let positions = [(0, 0), (0, 180), (180, 180), (90, 180), (0, 90)];
    let readings: Vec<Value> = positions
        .iter()
        .enumerate()
        .flat_map(|(k, (alpha, beta))| {
            [20, -20, 30, -30, 40, -40].map(
                |rate| json!({ "position": k.to_string(), "alpha_deg": alpha, "beta_deg": beta, "gamma_deg_s": rate }),
            )
        })
        .collect();
    let schedule = json!({ "bench": "gyro-turntable", "known": { "kI": { "value": -2.9222 } },
        "estimate": { "V0": {}, "dtheta_x0": {}, "dtheta_y0": {}, "dtheta_y1": {}, "dtheta_y2": {}, "dtheta_z2": {} }, "readings": readings });
    let truth = json!({ "values": { "dtheta_y2": { "value": -8e-4 } }, "noise": { "V": { "sd": 1e-4 } },
        "effects": [{ "regressor": "gamma_deg_s^3", "value": 5e-8 }] });
    for seed in 0..3 {
        let campaign = simulated(&schedule, &truth, seed);
        let all = candidates(&campaign, &wire::built_in_effects().unwrap()).unwrap();
        for (candidate, _) in &all {
            let text = &candidate.regressor;
            assert!(!text.contains("(gamma)") && !text.contains("*gamma)"), "{text} is zero over whole turns");
            assert!(
                !text.starts_with("gamma_deg_s*sin(2*") && text != "sin(2*alpha)",
                "{text} is zero at quarter turns"
            );
        }
        let found = diagnosed(&campaign);
        assert_eq!(names(&found), ["gamma_deg_s^3"]);
    }
}

#[test]
fn a_pattern_in_time_is_never_nothing_even_where_no_noise_is_stated() {
    let (schedule, mut truth) = head(false);
    // 7.6 waves in the record, beside 6 and 9 of the second and third harmonic of the angle
    truth["effects"] = json!([{ "regressor": "sin(time_s/150)", "value": 1.2e-5 }]);
    for seed in 0..6 {
        let found = diagnosed(&simulated(&schedule, &truth, seed));
        assert_eq!(found.verdict, Verdict::Unexplained, "{:?}", names(&found));
    }
    truth["effects"] = json!([]);
    for seed in 0..6 {
        assert_eq!(diagnosed(&simulated(&schedule, &truth, seed)).verdict, Verdict::NothingMissing);
    }
}

#[test]
fn two_readings_in_each_others_rows_are_one_effect() {
    let (schedule, mut truth) = head(true);
    truth["values"]["dtheta_y2"] = json!({ "value": 4e-4 });
    let mut campaign = simulated(&schedule, &truth, 1);
    // 75 deg and 120 deg
    let at = |campaign: &Campaign, k: usize| campaign.readings.rows[k].observations[0].value;
    let (a, b) = (at(&campaign, 5), at(&campaign, 32));
    (campaign.readings.rows[5].observations[0].value, campaign.readings.rows[32].observations[0].value) = (b, a);
    let found = diagnosed(&campaign);
    assert_eq!((found.verdict, names(&found)), (Verdict::EffectsFound, vec!["exchange:6:33"]));
    let size = found.effects[0].value.unwrap();
    assert!((size - (b - a)).abs() < 4.0 * found.effects[0].u.unwrap(), "{size} is not {}", b - a);
}

#[test]
fn an_effect_common_to_several_sensors_is_one_finding() {
    let mut schedule = fixture("simulated/imu-three-axis.campaign.json");
    let values = fixture("simulated/imu-three-axis.truth.json")["truth"].clone();
    for (k, reading) in schedule["readings"].as_array_mut().unwrap().iter_mut().enumerate() {
        reading["temperature_c"] = json!(20.0 + 3.0 * (0.7 * k as f64).sin() + 0.05 * k as f64);
    }
    let values: serde_json::Map<String, Value> =
        values.as_object().unwrap().iter().map(|(id, v)| (id.clone(), json!({ "value": v }))).collect();
    let noise = |sd: f64| json!({ "sd": sd });
    let noise = json!({ "Gx": noise(0.02), "Gy": noise(0.02), "Gz": noise(0.02), "Ax": noise(2e-5), "Ay": noise(2e-5), "Az": noise(2e-5) });
    let effect = |sensor: &str, value: f64| json!({ "regressor": "temperature_c", "sensor": sensor, "value": value });
    let effects = json!([effect("Gx", 0.08), effect("Gy", 0.06), effect("Gz", -0.07)]);
    let truth = json!({ "values": values, "noise": noise, "effects": effects });
    let found = diagnosed(&simulated(&schedule, &truth, 2));
    assert_eq!(names(&found), ["temperature_c"]);
    let own = &found.effects[0];
    assert_eq!(own.also.len(), 2);
    let mut sizes: Vec<(usize, f64, f64)> = vec![(own.effect.sensor.unwrap(), own.value.unwrap(), own.u.unwrap())];
    sizes.extend(own.also.iter().map(|o| (o.effect.sensor.unwrap(), o.value.unwrap(), o.u.unwrap())));
    sizes.sort_by_key(|(sensor, ..)| *sensor);
    for ((_, value, u), truth) in sizes.iter().zip([0.08, 0.06, -0.07]) {
        assert!((value - truth).abs() < 4.0 * u, "{value} +- {u} is not {truth}");
    }
}

/// Every single reading of a small head moved by one sd or thirty: the prediction of left-out positions is always a number.
#[test]
fn the_prediction_of_left_out_positions_is_a_number() {
    let (mut schedule, truth) = head(true);
    schedule["readings"] = json!((0..8).map(|k| json!({ "beta_deg": 45 * k })).collect::<Vec<Value>>());
    let campaign = simulated(&schedule, &truth, 4);
    for k in 0..8 {
        for size in [3e-6, 9e-5] {
            let mut moved = campaign.clone();
            moved.readings.rows[k].observations[0].value += size;
            let found = diagnosed(&moved);
            let holdout = found.holdout.unwrap();
            assert!(holdout.before.is_finite() && holdout.after.is_none_or(f64::is_finite), "{holdout:?}");
        }
    }
}

/// Twelve positions, 1000 samples at each, with one bad sample: averaged, and named as in a short record.
#[test]
fn a_long_record_is_averaged() {
    let (mut schedule, truth) = head(true);
    let at = |k: usize| json!({ "position": (k / 1000).to_string(), "beta_deg": 30 * (k / 1000), "time_s": k });
    schedule["readings"] = (0..12_000).map(at).collect();
    let mut campaign = simulated(&schedule, &truth, 1);
    campaign.readings.rows[5_234].observations[0].value += 1.2e-4;
    let found = diagnosed(&campaign);
    let (from, to) = found.averaged.unwrap();
    assert!(from == 12_000 && to < 2000, "{from} to {to}");
    assert_eq!((found.verdict, names(&found)), (Verdict::EffectsFound, vec!["reading:5235"]));
    let (value, u) = (found.effects[0].value.unwrap(), found.effects[0].u.unwrap());
    assert!((value - 1.2e-4).abs() < 4.0 * u, "{value} +- {u}");
}

/// Each probability counts every test that the report says was made, bad readings of a long campaign that have no column among them: `1 - (1 - 2 Q(t))^tests` of
/// the t beside it, `Q(t)` by the continued fraction of M. Abramowitz, I. A. Stegun 1964, 26.2.14.
#[test]
fn every_p_counts_the_tests_that_are_reported() {
    let (mut schedule, mut truth) = head(true);
    let readings = (0..504).map(|k| json!({ "beta_deg": 15 * (k % 24), "time_s": 100 * k }));
    schedule["readings"] = readings.collect();
    // u of the coefficient is some 3e-6 / sqrt(504 / 8)
    truth["effects"] = json!([{ "regressor": "abs(a_P)", "value": 4e-6 }]);
    let found = diagnosed(&simulated(&schedule, &truth, 2));
    assert_eq!(found.effects.len(), 1, "{:?}", names(&found));
    let tests = found.candidates.1 as f64;
    assert!(tests > 504.0, "{tests}");
    let tail = |t: f64| {
        let fraction = (1..200).rev().fold(t, |below, k| t + f64::from(k) / below);
        (-0.5 * t * t).exp() / std::f64::consts::TAU.sqrt() / fraction
    };
    let (own, given) = (&found.effects[0], &found.steps[0]);
    for (t, p) in [(own.t, own.p), (given.t.unwrap(), given.p.unwrap())] {
        assert!(t.abs() > 3.0);
        let all = -f64::exp_m1(tests * f64::ln_1p(-2.0 * tail(t.abs())));
        // the tail has some ten digits
        assert!((p / all - 1.0).abs() < 1e-8, "t {t}: p {p}, {tests} tests: {all}");
    }
}
