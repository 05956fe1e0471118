//! What must hold on any bench: random chains of joints and tilts, random axes, random model lines, random readings.

use crate::support::*;
use proptest::prelude::*;
use proptest::strategy::ValueTree;
use proptest::test_runner::TestRunner;
use serde_json::{Map, Value, json};
use tumble::campaign::Campaign;
use tumble::design::{self, Model};
use tumble::fit::Fit;

/// Terms that a model line may have, with their coefficient; every one but the first two is small.
const TERMS: [(&str, &str); 9] = [
    ("K0", "1"),
    ("KI", "w_I"),
    ("KII", "w_I^2"),
    ("KIP", "w_I*w_P"),
    ("DI", "a_I"),
    ("DP", "a_P"),
    ("DIP", "a_I*a_P"),
    ("KT", "temperature_c*w_I"),
    ("KS", "sin(a_I + 0.3)"),
];

/// A bench, its readings (without values) and the truth of every parameter.
#[derive(Debug, Clone)]
struct Question {
    bench: Value,
    readings: Vec<Map<String, Value>>,
    truth: Vec<(String, f64)>,
}

fn questions() -> impl Strategy<Value = Question> {
    let axis = || prop::sample::select(&["x", "y", "z"][..]);
    let link = (prop::bool::weighted(0.6), axis(), -2e-3..2e-3_f64);
    let direction = (0.0..std::f64::consts::TAU, -1.0..1.0_f64);
    let terms = prop::sample::subsequence((2..TERMS.len()).collect::<Vec<_>>(), 0..5);
    let reading = prop::collection::vec(0..720_u32, 6);
    (
        prop::collection::vec(link, 1..7),
        direction.clone(),
        direction,
        terms,
        prop::collection::vec(-1.0..1.0_f64, TERMS.len()),
        prop::collection::vec((reading, 0..3_u8, 5.0..90.0_f64, 15.0..35.0_f64), 40..60),
        -80.0..80.0_f64,
    )
        .prop_map(|(links, i, p, terms, values, rows, latitude)| {
            let cosines = |(longitude, z): (f64, f64)| {
                let r = (1.0 - z * z).sqrt();
                json!([r * longitude.cos(), r * longitude.sin(), z])
            };
            let (mut chain, mut joints, mut truth) = (Vec::new(), Vec::new(), Vec::new());
            for (k, (is_joint, about, tilt)) in links.iter().enumerate() {
                if *is_joint || joints.is_empty() {
                    joints.push(format!("j{k}"));
                    chain.push(json!({ "joint": format!("j{k}"), "about": about }));
                } else {
                    truth.push((format!("t{k}"), *tilt));
                    chain.push(json!({ "tilt": format!("t{k}"), "about": about }));
                }
            }
            let mut line = "K0 + KI*w_I".to_string();
            truth.extend([("K0".to_string(), 0.01 * values[0]), ("KI".to_string(), 1.0 + 0.1 * values[1])]);
            for k in terms {
                let (coefficient, term) = TERMS[k];
                line.push_str(&format!(" + {coefficient}*{term}"));
                truth.push((coefficient.to_string(), 1e-3 * values[k]));
            }
            let readings = rows
                .iter()
                .enumerate()
                .map(|(n, (angles, kind, rate, temperature))| {
                    let mut reading = Map::new();
                    reading.insert("position".into(), json!(n.to_string()));
                    reading.insert("temperature_c".into(), json!(temperature));
                    for (k, joint) in joints.iter().enumerate() {
                        let angle = f64::from(angles[k % 6]) * 0.5;
                        let turning = k == n % joints.len();
                        let rate = if angles[5] % 2 == 0 { *rate } else { -rate };
                        match (turning, kind) {
                            (true, 0) => drop(reading.insert(format!("{joint}_deg_s"), json!(rate))),
                            (true, 1) => {
                                reading.insert(format!("{joint}_deg"), json!(angle));
                                reading.insert(format!("{joint}_deg_s"), json!(rate));
                                reading.insert(format!("{joint}_turns"), json!(1.25));
                            }
                            _ => drop(reading.insert(format!("{joint}_deg"), json!(angle))),
                        }
                    }
                    reading
                })
                .collect();
            let bench = json!({
                "id": "random", "site": { "latitude_deg": latitude }, "chain": chain,
                "sensors": { "S": { "unit": "V", "axes": { "I": cosines(i), "P": cosines(p) }, "model": line } }
            });
            Question { bench, readings, truth }
        })
}

impl Question {
    /// The campaign with these values and starts; coefficients in the user's units.
    fn campaign(&self, values: Option<&[f64]>) -> Campaign {
        let readings: Vec<Value> = self
            .readings
            .iter()
            .enumerate()
            .map(|(k, reading)| {
                let mut reading = reading.clone();
                if let Some(value) = values.and_then(|v| v.get(k)) {
                    reading.insert("S".into(), json!(value));
                }
                Value::Object(reading)
            })
            .collect();
        let estimate: Map<String, Value> = self
            .truth
            .iter()
            .map(|(id, _)| (id.clone(), if id == "KI" { json!({ "start": 1 }) } else { json!({}) }))
            .collect();
        parse(&json!({ "bench": self.bench, "estimate": estimate, "readings": readings }).to_string())
    }

    /// Noiseless readings.
    fn values(&self) -> Vec<f64> {
        let campaign = self.campaign(None);
        predicted(&campaign, &self.point(&campaign))
    }

    fn point(&self, campaign: &Campaign) -> Vec<f64> {
        let of = |id: &str| self.truth.iter().find(|(own, _)| own == id).map(|(_, value)| *value);
        campaign.parameters.iter().map(|p| of(&p.id).unwrap_or(0.0)).collect()
    }

    /// Readings with scatter of 1e-3, the same each time.
    fn noisy(&self) -> Vec<f64> {
        let scatter = |k: usize| ((k * k * 7919 + 13 * k) as f64 * 0.618_034 % 2.0 - 1.0) * 1e-3;
        self.values().iter().enumerate().map(|(k, value)| value + scatter(k)).collect()
    }
}

fn predicted(campaign: &Campaign, point: &[f64]) -> Vec<f64> {
    let model = Model::new(campaign).expect("a model");
    design::assemble(campaign, &model, point).expect("rows").predicted
}

/// The same random questions in every test and every run.
fn each(count: usize, mut check: impl FnMut(usize, &Question)) {
    let mut runner = TestRunner::deterministic();
    for k in 0..count {
        check(k, &questions().new_tree(&mut runner).expect("a question").current());
    }
}

/// Well enough determined that rounding stays far below the tolerances here.
fn benign(fit: &Fit) -> bool {
    fit.not_estimable.is_empty() && fit.estimate.unknowns.condition().is_some_and(|c| c < 1e4)
}

/// Estimates and uncertainties agree to `share` of the standard uncertainty.
#[track_caller]
fn assert_same(a: &Fit, b: &Fit, scale: impl Fn(&str) -> f64, share: f64) {
    for parameter in &a.parameters {
        let id = parameter.id.as_str();
        let (u, factor) = (uncertainty(a, id), scale(id));
        assert_within(value(b, id) * factor, value(a, id), share * u, id);
        assert_within(uncertainty(b, id) * factor, u, share * u, &format!("u of {id}"));
    }
}

/// What a design has of a reading is what is predicted of it alone, to the last bit: also where another reading of the same setting was worked out.
#[test]
fn rows_of_a_design_are_those_of_each_reading_alone() {
    each(60, |k, question| {
        let campaign = question.campaign(None);
        let model = Model::new(&campaign).expect("a model");
        let point: Vec<f64> = question.point(&campaign).iter().map(|v| v + 0.1).collect();
        let design = design::assemble(&campaign, &model, &point).expect("rows");
        let (mut gradient, mut work) = (vec![0.0; point.len()], model.workspace());
        for (i, origin) in design.rows.iter().enumerate() {
            let place = (origin.reading, origin.sensor);
            let value = model.predict(&campaign, place.0, place.1, &point, &mut gradient, &mut work).expect("a value");
            assert_eq!(value, design.predicted[i], "question {k}, row {i}");
            (0..point.len()).for_each(|j| assert_eq!(gradient[j], design.jacobian[(i, j)], "question {k}, row {i}"));
        }
    });
}

/// Readings of one setting share what they have in common, until one of them changes it.
#[test]
fn a_reading_that_is_changed_leaves_the_others_as_they_are() {
    let readings = r#"{"x": 1, "y": 2}, {"x": 1, "y": 3}, {"x": 5, "y": 2}"#;
    let mut campaign = parse(&format!(
        r#"{{ "bench": {{ "id": "line", "sensors": {{ "y": {{ "model": "a + b*x" }} }} }}, "estimate": {{ "a": {{}}, "b": {{}} }},
        "readings": [{readings}] }}"#
    ));
    let rows = &mut campaign.readings.rows;
    assert!(rows[0].columns == rows[1].columns && rows[0].columns != rows[2].columns);
    rows[0].columns[0] = Some(7.0);
    rows[1].observations[0].value = 9.0;
    let x: Vec<Option<f64>> = rows.iter().map(|row| row.columns[0]).collect();
    let y: Vec<f64> = rows.iter().map(|row| row.observations[0].value).collect();
    assert_eq!((x, y), (vec![Some(7.0), Some(1.0), Some(5.0)], vec![2.0, 9.0, 2.0]));
}

#[test]
fn derivatives_equal_central_differences() {
    let mut compared = 0;
    each(150, |_, question| {
        let campaign = question.campaign(None);
        let model = Model::new(&campaign).expect("a model");
        // away from zero tilts, where nothing is small
        let point: Vec<f64> =
            question.point(&campaign).iter().enumerate().map(|(k, v)| v + 0.2 + 0.05 * k as f64).collect();
        let design = design::assemble(&campaign, &model, &point).expect("rows");
        let size = design.predicted.iter().fold(10.0_f64, |most, value| most.max(value.abs()));
        for column in 0..point.len() {
            let h = 1e-3;
            let shifted = |by: f64| {
                let mut moved = point.clone();
                moved[column] += by;
                predicted(&campaign, &moved)
            };
            let (up, down, up_2, down_2) = (shifted(h), shifted(-h), shifted(2.0 * h), shifted(-2.0 * h));
            for row in 0..design.rows.len() {
                // five points: error h^4 = 1e-12 times a thirtieth of the fifth derivative, and rounding of the largest terms over h
                let difference = (8.0 * (up[row] - down[row]) - (up_2[row] - down_2[row])) / (12.0 * h);
                assert_within(
                    design.jacobian[(row, column)],
                    difference,
                    5e-11 * size,
                    &format!("row {row} by {}", campaign.parameters[column].id),
                );
                compared += 1;
            }
        }
    });
    println!("{compared} derivatives");
    assert!(compared > 20_000);
}

#[test]
fn noiseless_truth_comes_back() {
    let (mut determined, mut defects) = (0, 0);
    each(150, |k, question| {
        let values = question.values();
        let campaign = question.campaign(Some(&values));
        let fit = exact(&campaign);
        let converged = fit.convergence.as_ref().is_some_and(|c| c.converged);
        if !benign(&fit) {
            defects += 1;
            return;
        }
        assert!(converged, "question {k}: {:?}", fit.convergence);
        determined += 1;
        let largest = values.iter().fold(0.0_f64, |most, value| most.max(value.abs()));
        for (id, truth) in &question.truth {
            // readings are rounded to 16 digits, and what that does to a weakly determined parameter is no fault
            let j = fit.parameters.iter().position(|p| p.id == *id).expect("a parameter");
            let rounding = f64::EPSILON * largest * fit.estimate.unknowns.cofactor[(j, j)].sqrt();
            let tolerance = 1e-9 * truth.abs().max(1e-3) + 30.0 * rounding;
            assert_within(value(&fit, id), *truth, tolerance, &format!("question {k}: {id}"));
        }
    });
    println!("{determined} questions determine every parameter well, {defects} do not");
    assert!(determined > 30);
}

#[test]
fn redundancy_numbers_sum_to_the_degrees_of_freedom() {
    each(100, |_, question| {
        let fit = fitted(&question.campaign(Some(&question.noisy())));
        let sum: f64 = fit.quality().map(|row| row.redundancy).sum();
        assert_within(sum, fit.estimate.dof as f64, 1e-10, "sum of redundancy numbers");
        assert_eq!(fit.estimate.dof + fit.estimate.unknowns.rank, fit.design.rows.len());
        assert_eq!(fit.estimate.unknowns.rank + fit.not_estimable.len(), fit.parameters.len());
    });
}

#[test]
fn the_order_of_readings_does_not_matter() {
    each(60, |_, question| {
        let values = question.noisy();
        let (mut turned, mut turned_values) = (question.clone(), values.clone());
        turned.readings.reverse();
        turned_values.reverse();
        let (a, b) = (fitted(&question.campaign(Some(&values))), fitted(&turned.campaign(Some(&turned_values))));
        assert_eq!(a.estimate.unknowns.rank, b.estimate.unknowns.rank);
        if benign(&a) {
            assert_same(&a, &b, |_| 1.0, 1e-9);
        }
    });
}

/// The power of the rate's and force's unit in each coefficient.
fn powers(id: &str) -> (i32, i32) {
    match id {
        "KI" | "KT" => (1, 0),
        "KII" | "KIP" => (2, 0),
        "DI" | "DP" => (0, 1),
        "DIP" => (0, 2),
        _ => (0, 0),
    }
}

/// deg/s or deg/h or rad/s, g or m/s^2: coefficients change by the factor, angles and standard uncertainties follow.
#[test]
fn units_do_not_matter() {
    for (rate, per_deg_s, force, per_g) in [
        ("deg/h", 3600.0, "g", 1.0),
        ("rad/s", std::f64::consts::PI / 180.0, "m/s^2", 9.80665),
        ("arcsec/s", 3600.0, "m/s^2", 9.80665),
    ] {
        let mut compared = 0;
        each(60, |_, question| {
            if question.bench["sensors"]["S"]["model"].as_str().is_some_and(|line| line.contains("KS")) {
                return; // sin(a_I) has an argument that changes with the unit of force
            }
            let values = question.noisy();
            let mut other = question.clone();
            other.bench["units"] = json!({ "rate": rate, "force": force });
            let a = fitted(&question.campaign(Some(&values)));
            // the reference point is part of the linear question: the scale factor of 1 per deg/s
            let mut campaign = other.campaign(Some(&values));
            for parameter in &mut campaign.parameters {
                if let tumble::campaign::Role::Estimated { start: Some(start), .. } = &mut parameter.role {
                    *start /= per_deg_s;
                }
            }
            let b = fitted(&campaign);
            assert_eq!(a.estimate.unknowns.rank, b.estimate.unknowns.rank, "{rate}, {force}");
            if benign(&a) {
                let scale = |id: &str| {
                    let (rates, forces) = powers(id);
                    f64::powi(per_deg_s, rates) * f64::powi(per_g, forces)
                };
                assert_same(&a, &b, scale, 1e-8);
                compared += 1;
            }
        });
        println!("{compared} fits in {rate} and {force}");
        assert!(compared > 10);
    }
}

/// Axes renamed x -> y -> z -> x in the chain and in the sensor's cosines, where nothing outside (Earth rate, gravity) names an axis.
#[test]
fn the_frame_does_not_matter() {
    let mut compared = 0;
    each(80, |_, question| {
        let mut plain = question.clone();
        // without Earth rate; the force's direction enters through a first joint that turns z to where the chain begins
        plain.bench["site"] = json!({ "latitude_deg": 0, "earth_rate_deg_h": 0, "gravity_g": 0 });
        let values = plain.noisy();
        let mut cycled = plain.clone();
        for link in cycled.bench["chain"].as_array_mut().expect("a chain") {
            let about = link["about"].as_str().expect("an axis");
            link["about"] = json!(match about {
                "x" => "y",
                "y" => "z",
                _ => "x",
            });
        }
        for axis in ["I", "P"] {
            let cosines = numbers(&plain.bench["sensors"]["S"]["axes"][axis]);
            cycled.bench["sensors"]["S"]["axes"][axis] = json!([cosines[2], cosines[0], cosines[1]]);
        }
        let (a, b) = (fitted(&plain.campaign(Some(&values))), fitted(&cycled.campaign(Some(&values))));
        assert_eq!(a.estimate.unknowns.rank, b.estimate.unknowns.rank);
        if benign(&a) {
            assert_same(&a, &b, |_| 1.0, 1e-9);
            compared += 1;
        }
    });
    println!("{compared} fits in a renamed frame");
    assert!(compared > 5);
}

/// A file written back from the domain asks the same question.
#[test]
fn a_campaign_written_back_is_the_same_question() {
    each(30, |_, question| {
        let campaign = question.campaign(Some(&question.noisy()));
        let file = tumble::wire::campaign_file(
            &campaign,
            tumble::wire::BenchRef::Inline(Box::new(tumble::wire::bench_file(&campaign.bench))),
        );
        let again = parse(&serde_json::to_string(&file).expect("JSON"));
        let (a, b) = (fitted(&campaign), fitted(&again));
        assert_eq!(a.point, b.point);
        assert_eq!(a.estimate.residuals, b.estimate.residuals);
    });
}
