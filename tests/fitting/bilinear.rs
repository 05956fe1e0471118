//! Model lines that multiply unknowns, with nothing stated to start from: readings of an independent simulator, and an independent fit
//! (tests/scripts/bilinear_campaigns.py).

use crate::support::*;
use tumble::fit::State;

/// The jobs in which everything is determined.
const DETERMINED: [&str; 6] = [
    "gyro-scale-and-mounting",
    "gyro-tilts-first",
    "gyro-cross-coupling",
    "three-gyros",
    "accelerometer-small-terms",
    "accelerometer-few-positions",
];

/// Values, uncertainties and residual standard deviation are those of MINPACK on the simulator.
#[test]
fn products_of_unknowns_are_found_from_nothing() {
    println!(
        "{:26} {:>9} {:>9} {:>5} {:>13} {:>12}",
        "campaign", "residual", "script", "steps", "off script, u", "off truth, u"
    );
    for name in DETERMINED {
        let truth = json(&format!("bilinear/{name}.truth.json"));
        let fit = fitted(&campaign(&format!("bilinear/{name}.campaign.json")));
        assert!(fit.not_estimable.is_empty() && !fit.is_rejected(), "{name}: {:?}", fit.not_estimable);
        let record = fit.convergence.as_ref().expect("a record");
        let sd = fit.estimate.residual_sd().expect("degrees of freedom");
        let (mut from_script, mut from_truth) = (0.0_f64, 0.0_f64);
        for (id, expected) in entries(&truth["fitted"]["values"]) {
            let u = number(&expected["u"]);
            from_script = from_script.max((value(&fit, id) - number(&expected["value"])).abs() / u);
            from_truth = from_truth.max((value(&fit, id) - number(&truth["truth"][id])).abs() / u);
            // several sensors have a scatter each here, and one together in the script
            let same = if fit.campaign.bench.sensors.len() == 1 { 1e-5 } else { 0.2 };
            assert_within(uncertainty(&fit, id), u, same * u, &format!("{name}: u of {id}"));
        }
        println!(
            "{name:26} {sd:9.2e} {:9.2e} {:5} {from_script:13.1e} {from_truth:12.2}",
            number(&truth["fitted"]["residual_sd"]),
            record.iterations.len()
        );
        // seeded noise: the largest of a dozen deviates
        assert!(from_truth < 3.5, "{name}");
        if fit.campaign.bench.sensors.len() == 1 {
            assert!(from_script < 1e-4, "{name}");
            assert_within(sd, number(&truth["fitted"]["residual_sd"]), 1e-6 * sd, name);
        }
    }
}

/// The linear estimator stands on the saddle: it says so, and does not speak of other positions.
#[test]
fn one_step_from_the_saddle_claims_nothing_of_the_bench() {
    let fit = linear(&campaign("bilinear/gyro-scale-and-mounting.campaign.json"));
    assert_eq!(fit.not_estimable.len(), 2);
    assert!(fit.not_estimable.iter().all(|defect| defect.is_weak && defect.separate_by.is_none()));
}

/// Only products of the scale factor with tilts show: the scale factor stays free, its products are found.
#[test]
fn products_are_found_where_their_factors_are_not() {
    let truth = json("bilinear/gyro-turntable-scale-unknown.truth.json");
    let fit = fitted(&campaign("bilinear/gyro-turntable-scale-unknown.campaign.json"));
    let record = fit.convergence.as_ref().expect("a record");
    assert!(record.converged && record.moved.len() == 6, "{record:?}");
    assert_eq!((fit.estimate.unknowns.rank, fit.not_estimable.len()), (6, 1));
    assert!(fit.not_estimable[0].is_weak);
    // the script holds kI at its truth
    let script = &truth["fitted"];
    let (scale, sd) = (number(&truth["truth"]["kI"]), fit.estimate.residual_sd().expect("degrees of freedom"));
    for (id, expected) in entries(&script["values"]).filter(|(id, _)| *id != "V0") {
        let (product, u) = (number(&expected["value"]) * scale, (number(&expected["u"]) * scale).abs());
        assert_eq!(fit.parameters.iter().find(|p| p.id == *id).map(|p| p.state), Some(State::NotEstimable));
        // second-order terms, kI times two tilts, depend on the value at which kI is held: here they are as large as u
        assert_within(value(&fit, &format!("p_{id}")), product, 2.0 * u, id);
        assert_within(uncertainty(&fit, &format!("p_{id}")), u, 0.3 * u, &format!("u of {id}"));
    }
    assert!(sd < 1.2 * number(&script["residual_sd"]));
}

/// A line of combinations that the readings determine has a value and an uncertainty, though its parameters have none; so have the
/// combinations that the report names.
#[test]
fn what_lies_in_the_row_space_has_a_value() {
    // y = a + b + c x: a and b only together
    let text = r#"{ "bench": { "id": "line", "sensors": { "y": { "model": "a + b + c*x" } } },
        "estimate": { "a": {}, "b": {}, "c": {} }, "derived": { "both": "a + b", "more": "2*(a + b) - c", "one": "a - b" },
        "readings": [ {"x": 0, "y": 1}, {"x": 1, "y": 3}, {"x": 2, "y": 4} ] }"#;
    let fit = fitted(&parse(text));
    // the straight line through (0, 1), (1, 3), (2, 4): intercept 7/6, slope 3/2, s^2 = 1/6, variances s^2 (5/6, 1/2), covariance -s^2/2
    assert_within(value(&fit, "both"), 7.0 / 6.0, 1e-14, "both");
    assert_within(uncertainty(&fit, "both"), (5.0_f64 / 36.0).sqrt(), 1e-14, "u of both");
    assert_within(value(&fit, "more"), 5.0 / 6.0, 1e-14, "more");
    let variance = (4.0 * 5.0 / 6.0 + 0.5 + 2.0) / 6.0;
    assert_within(uncertainty(&fit, "more"), f64::sqrt(variance), 1e-14, "u of more");
    assert!(fit.derived[2].value.is_none() && fit.derived[2].uncertainty.is_none());
    let [combination] = &fit.combinations[..] else { panic!("{:?}", fit.combinations) };
    assert_eq!(combination.combination.text, "a + b");
    assert_within(combination.value, 7.0 / 6.0, 1e-14, "the combination");
    assert_within(combination.uncertainty.expect("u").u, (5.0_f64 / 36.0).sqrt(), 1e-14, "its u");
}
