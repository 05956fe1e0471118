//! Attitude by a cube mirror and two theodolites.

use crate::draws::draws;
use crate::support::*;
use tumble::campaign::{Campaign, Role};
use tumble::compare;
use tumble::design;
use tumble::fit::{self, Fit, Settings};

const FOLDER: &str = "examples/12-cube-mirror";

#[test]
fn noiseless_truth_comes_back() {
    let fit = fit::fit(&campaign("tests/data/simulated/cube-mirror.campaign.json"), &exact()).unwrap();
    let (error, id) = worst_relative(&fit, &truth("tests/data/simulated/cube-mirror.truth.json"), 1.0);
    println!("{id} {error:.1e}");
    // circle readings of 1e6 arcsec are rounded to 1e-10 arcsec
    assert!(error < 1e-9, "{id} {error:.1e}");
}

#[test]
fn the_means_of_both_faces_are_least_squares() {
    let forms = compare::closed_forms("cube-mirror").unwrap();
    let comparison =
        compare::compare(&campaign(&format!("{FOLDER}/attitude.campaign.json")), &forms, &Settings::default()).unwrap();
    let mut compared = 0;
    for (closed, square) in comparison.groups[0].closed_form.iter().zip(&comparison.groups[0].least_squares) {
        if let (Some(closed), Some(square)) = (closed, square) {
            // the collimation enters face M by 1/cos(pitch), so its direction follows the pitch by 1e-7 arcsec
            assert!((closed - square).abs() < 1e-6, "{closed} {square}");
            compared += 1;
        }
    }
    assert!(compared >= 12);
}

#[test]
fn the_budget_has_repeatability_circle_and_compensator() {
    let fit = fit::fit(&campaign(&format!("{FOLDER}/attitude.campaign.json")), &exact()).unwrap();
    let budget = |id: &str| &fit.parameters.iter().find(|p| p.id == id).unwrap().budget;
    let of = |id: &str, source: &str| budget(id).iter().find(|c| c.source == source).map_or(0.0, |c| c.u);
    println!("roll: {:#?}", budget("roll").iter().map(|c| (c.source.clone(), c.u)).collect::<Vec<_>>());
    assert!((of("pitch", "cVA_M") - 0.288675).abs() < 1e-5 && (of("pitch", "compA") - 0.1).abs() < 1e-6);
    assert!((of("heading", "mark") - 0.5).abs() < 1e-6);
    // T_N = asin(cos(pitch) sin(roll)): the roll follows its elevation by nearly one
    assert!((of("roll", "cVB_N") - 0.2887).abs() < 2e-4);
    assert!(of("roll", "readings of VB_N") > 0.1);
}

/// The source: repeatabilities of the roll 0.69 arcsec face left and 0.76 arcsec face right (n = 6), circle error 0.5 arcsec, both faces combined
/// with c = 0.5 each (its eq. 22), and U = 0.82 arcsec (k = 2, u = 0.41).
#[test]
fn the_printed_041_is_a_sum_without_squared_sensitivities() {
    let (s, n, circle) = ([0.69f64, 0.76f64], 6.0f64, 0.5 / 3f64.sqrt());
    // each face by the stated rule, u^2 = s^2/n + (0.5/sqrt 3)^2: 0.40 and 0.42, and the program gives them
    let face = s.map(|s| (s * s / n + circle * circle).sqrt());
    for (path, u) in ["roll-069.campaign.json", "roll-076.campaign.json"].iter().zip(face) {
        assert!((rule(path).0 - u).abs() < 1e-6, "{path}");
    }
    assert_eq!(face.map(|u| (u * 100.0).round() / 100.0), [0.40, 0.42]);
    let both = |c: f64, power: i32| face.iter().map(|u| c.powi(power) * u * u).sum::<f64>().sqrt();
    // eq. 22 as it stands: c^2 u^2
    let right = both(0.5, 2);
    assert_eq!(((right * 100.0).round(), (right * 2000.0).round()), (29.0, 585.0));
    // with c instead of its square: the printed figure
    let printed = both(0.5, 1);
    assert_eq!((printed * 100.0).round(), 41.0);
    println!("u = {right:.4}, U = {:.4}; with c not squared {printed:.4}, {:.4}", 2.0 * right, 2.0 * printed);
    // the program combines the two faces as the equation says
    let fit = fit::fit(&campaign(&format!("{FOLDER}/both-faces.campaign.json")), &exact()).unwrap();
    let u = fit.derived[0].uncertainty.as_ref().unwrap().u;
    assert!((u - right).abs() < 1e-6, "{u} {right}");
}

fn rule(path: &str) -> (f64, f64) {
    let fit = fit::fit(&campaign(&format!("{FOLDER}/{path}")), &Settings::default()).unwrap();
    let uncertainty = fit.parameters[0].uncertainty.unwrap();
    (uncertainty.u, uncertainty.dof)
}

/// The source states 3 arcsec for the compensator; the example takes 0.1. With the source's figure (rectangular) it is most of u.
#[test]
fn what_the_sources_compensator_would_do() {
    let mut text: serde_json::Value = serde_json::from_str(&read(&format!("{FOLDER}/attitude.campaign.json"))).unwrap();
    for id in ["compA", "compB"] {
        text["known"][id]["u"] = (3.0 / 3f64.sqrt()).into();
        text["known"][id]["distribution"] = "rectangular".into();
    }
    let fit = fit::fit(&parse("compensator", &text.to_string()).unwrap(), &exact()).unwrap();
    for (id, printed) in [("pitch", 1.78), ("roll", 1.76)] {
        let u = fit.parameters.iter().find(|p| p.id == id).unwrap().uncertainty.as_ref().unwrap().u;
        println!("{id}: u = {u:.3}");
        // u of the example without the compensator's 0.1, and 1.732 of it, in quadrature
        assert!((u - printed).abs() < 0.02, "{id} {u}");
    }
}

/// Face N on the right (+X of source 002): another bench. A device upside down has its left face on the right: with the wrong bench the roll,
/// and the device's error in it, come out half a turn away, and no angle is millions.
/// Sensors whose sights are inconsistent, as the report says.
fn circles(fit: &Fit) -> Vec<String> {
    tumble::report::fit_report(fit).fit.inconsistent_circles.into_iter().map(|own| own.sensor).collect()
}

#[test]
fn the_face_is_a_property_of_the_bench() {
    let truth = truth("tests/data/simulated/cube-mirror-right.truth.json");
    let text = read("tests/data/simulated/cube-mirror-right.campaign.json");
    let right = fit::fit(&parse("right", &text).unwrap(), &exact()).unwrap();
    let (error, id) = worst_relative(&right, &truth, 1.0);
    assert!(error < 1e-8 && circles(&right).is_empty(), "{id} {error:.1e}");
    let wrong = text.replacen("\"cube-mirror-right\"", "\"cube-mirror\"", 1);
    let wrong = fit::fit(&parse("wrong", &wrong).unwrap(), &exact()).unwrap();
    for p in &wrong.parameters {
        assert!(p.value.is_some_and(|v| v.abs() <= 648_000.0 + 1e-6), "{} {:?}", p.id, p.value);
        let off = (p.value.unwrap() - truth[&p.id]).abs();
        let expected = if p.id.ends_with("roll") { 648_000.0 } else { 0.0 };
        println!("{} {:.1}", p.id, p.value.unwrap());
        assert!((off - expected).abs() < 1e-3, "{}: {off}", p.id);
    }
    // a sight of another target has no such way out: it is named
    let mut text: serde_json::Value = serde_json::from_str(&text).unwrap();
    for reading in text["readings"].as_array_mut().unwrap() {
        if let Some(own) = reading.get("VA_M").and_then(serde_json::Value::as_f64) {
            reading["VA_M"] = (own + if reading["face"] == 0 { 36_000.0 } else { -36_000.0 }).into();
        }
        if let Some(own) = reading.get("HA_B").and_then(serde_json::Value::as_f64) {
            reading["HA_B"] = (own + if reading["face"] == 0 { 180_000.0 } else { -180_000.0 }).into();
        }
    }
    let fit = fit::fit(&parse("target", &text.to_string()).unwrap(), &exact()).unwrap();
    println!("{:?}", circles(&fit));
    assert!(fit.is_rejected() && circles(&fit).iter().any(|id| id == "HA_B"));
}

/// Starts anywhere on the circles come to the attitude, or the sights that they leave inconsistent are named.
#[test]
fn far_starts_converge_or_name_the_inconsistent_sight() {
    let (mut came, mut named, count) = (0, 0, 200);
    let truth = truth("tests/data/simulated/cube-mirror.truth.json");
    let base = campaign("tests/data/simulated/cube-mirror.campaign.json");
    let mut random = random(2202);
    for trial in 0..count {
        let mut far = base.clone();
        for p in &mut far.parameters {
            let width = match p.id.as_str() {
                "heading" | "base" | "oA" | "oB" => 648_000.0,
                // a cube is not made by the degree, nor a theodolite's collimation
                "pitch" | "roll" => 250_000.0,
                _ => continue,
            };
            if let Role::Estimated { start, .. } = &mut p.role {
                let unit: f64 = rand_distr::Distribution::sample(&rand_distr::StandardUniform, &mut random);
                *start = Some(width * (2.0 * unit - 1.0));
            }
        }
        let fit = fit::fit(&far, &exact()).unwrap();
        let right = fit.parameters.iter().all(|p| p.value.is_some_and(|v| (v - truth[&p.id]).abs() < 1e-3));
        came += usize::from(right);
        named += usize::from(!right && !circles(&fit).is_empty());
        if !right && circles(&fit).is_empty() {
            let values: Vec<(String, f64)> =
                fit.parameters.iter().map(|p| (p.id.clone(), p.value.unwrap_or(f64::NAN))).collect();
            println!("{trial}: {:?} {values:?}", fit.convergence.as_ref().map(|c| c.stop));
        }
        for p in fit.parameters.iter().filter(|_| right) {
            assert!(p.value.is_some_and(|v| v.abs() <= 648_000.0), "{}", p.id);
        }
    }
    println!("{came} of {count} came to the attitude, {named} name the sight");
    assert!(came + named == count);
}

/// Far from the attitude the scales of the sights that are estimated on the way are those of nothing: they do not keep a solution from being left.
#[test]
fn a_steep_attitude_is_reached_from_zero() {
    let fit = fit::fit(&campaign("tests/data/simulated/cube-mirror-steep.campaign.json"), &exact()).unwrap();
    let value = |id: &str| fit.parameters.iter().find(|p| p.id == id).and_then(|p| p.value).unwrap();
    // as drawn, within five of their uncertainties
    assert!((value("roll") - 187_701.0).abs() < 5.0 && (value("cube") + 5.0).abs() < 5.0, "{}", value("roll"));
    // what is printed is what the readings were compared with
    let model = design::Model::new(&fit.campaign).unwrap();
    let at = design::assemble(&fit.campaign, &model, &fit.point).unwrap().predicted;
    for (i, (predicted, residual)) in at.iter().zip(&fit.estimate.residuals).enumerate() {
        let row = &fit.design.rows[i];
        let read = fit.campaign.readings.rows[row.reading].observations.iter().find(|o| o.sensor == row.sensor);
        let own = read.unwrap().value - predicted;
        assert!((own - residual).abs() < 1e-3, "row {i}: {own} for {residual}");
    }
}

/// Devices at any attitude, every start at zero, noise of one second of arc that the readings alone tell: the solution is the attitude, or is said to be none.
#[test]
fn steep_attitudes_converge_or_say_that_they_do_not() {
    let base = campaign("tests/data/simulated/cube-mirror-steep.campaign.json");
    let model = design::Model::new(&base).unwrap();
    let mut random = random(2203);
    let mut uniform = |width: f64| -> f64 {
        let unit: f64 = rand_distr::Distribution::sample(&rand_distr::StandardUniform, &mut random);
        width * (2.0 * unit - 1.0)
    };
    let (count, mut solved, mut wrong) = (draws(60, 400), 0, 0);
    for trial in 0..count {
        let mut truth = base.reference_point();
        for (p, value) in base.parameters.iter().zip(&mut truth) {
            *value = match p.id.as_str() {
                "heading" | "base" | "oA" | "oB" => uniform(600_000.0),
                "pitch" | "roll" => uniform(216_000.0),
                "cube" => uniform(30.0),
                "colA" | "colB" | "iA" | "iB" => uniform(10.0),
                "d_heading" | "d_pitch" | "d_roll" => uniform(20.0),
                _ => *value,
            };
        }
        let design = design::assemble(&base, &model, &truth).unwrap();
        let mut device = base.clone();
        for (row, predicted) in design.rows.iter().zip(&design.predicted) {
            // the sum of twelve, less its mean, is normal to the eye
            let noise: f64 = (0..12).map(|_| uniform(0.5)).sum();
            let readings = &mut device.readings.rows[row.reading].observations;
            readings.iter_mut().filter(|o| o.sensor == row.sensor).for_each(|o| o.value = predicted + noise);
        }
        let fit = fit::fit(&device, &exact()).unwrap();
        let off = |id: &str| {
            let k = base.parameters.iter().position(|p| p.id == id).unwrap();
            (fit.point[k] - truth[k] + 648_000.0).rem_euclid(1_296_000.0) - 648_000.0
        };
        let right = ["roll", "pitch", "heading", "cube"].iter().all(|id| off(id).abs() < 20.0);
        let converged = fit.convergence.as_ref().is_some_and(|own| own.converged);
        solved += usize::from(right && converged);
        wrong += usize::from(!right && converged && !fit.is_rejected());
        if !(right && converged) {
            println!("{trial}: off by {:.0} and {:.0}, converged {converged}", off("roll"), off("cube"));
        }
    }
    println!("{solved} of {count} solved, {wrong} wrong without a word");
    assert!(wrong == 0 && 10 * solved >= 9 * count);
}

#[test]
fn what_hides_in_what_is_named() {
    let mut campaign = campaign(&format!("{FOLDER}/attitude.campaign.json"));
    // without the mark nothing fixes the azimuths
    for row in &mut campaign.readings.rows {
        row.observations = row.observations.iter().copied().filter(|o| o.sensor != 0).collect();
    }
    let fit = fit::fit(&campaign, &exact()).unwrap();
    let texts: String = fit.not_estimable.iter().flat_map(|s| &s.estimable).map(|c| c.text.clone() + "; ").collect();
    println!("{texts}");
    assert_eq!(fit.not_estimable.len(), 1);
    assert!(texts.contains("heading + d_heading"), "{texts}");
    let state = |fit: &Fit, id: &str| fit.parameters.iter().find(|p| p.id == id).unwrap().value.is_some();
    assert!(!state(&fit, "heading") && state(&fit, "pitch") && state(&fit, "roll") && state(&fit, "cube"));
}

#[test]
fn intervals_hold_what_they_promise() {
    let campaign = near(&campaign(&format!("{FOLDER}/attitude.campaign.json")));
    let truth = truth("tests/data/simulated/cube-mirror.truth.json");
    // the largest part of the roll's uncertainty is rectangular: its interval holds a little more than it promises
    // a collimation is a weighted mean of three directions whose scatters are estimated from ten degrees of freedom each: without what
    // Kenward and Roger add for estimated weights its interval would be short (see `estimated_weights_cost_what_is_added_for_them`)
    coverage(
        "attitude, circle errors rectangular",
        &campaign,
        &truth,
        &|sensor, _| if sensor < 7 { 0.7 } else { 0.9 },
        2000,
        &exact(),
        0.985,
    );
}

/// Why the intervals of collimations once held 92 % instead of 95 %: with known scatters they hold what they promise; with estimated ones
/// they do so only when the uncertainty of the weights is part of them.
#[test]
fn estimated_weights_cost_what_is_added_for_them() {
    let truth = truth("tests/data/simulated/cube-mirror.truth.json");
    let estimated = near(&campaign(&format!("{FOLDER}/attitude.campaign.json")));
    let mut stated = estimated.clone();
    let sd = |sensor: usize| if sensor < 7 { 0.7 } else { 0.9 };
    for o in stated.readings.rows.iter_mut().flat_map(|row| row.observations.iter_mut()) {
        o.u = Some(sd(o.sensor));
    }
    let count = draws(400, 2000);
    let slack = 5.0 * (0.95f64 * 0.05 / count as f64).sqrt();
    let mut random = random(22);
    let point = point(&estimated, &truth);
    let mut held = std::collections::BTreeMap::<&str, [usize; 3]>::new();
    for _ in 0..count {
        let measured = simulated(&estimated, &point, &|sensor, _| sd(sensor), &mut random);
        let mut known = stated.clone();
        for (row, own) in known.readings.rows.iter_mut().zip(&measured.readings.rows) {
            for (o, own) in row.observations.iter_mut().zip(&own.observations) {
                o.value = own.value;
            }
        }
        let (known, own) = (fit::fit(&known, &exact()).unwrap(), fit::fit(&measured, &exact()).unwrap());
        for id in ["colA", "colB"] {
            let of = |fit: &Fit| fit.parameters.iter().position(|p| p.id == id).unwrap();
            let k = of(&own);
            let p = &own.parameters[k];
            let error = (p.value.unwrap() - truth[id]).abs();
            // as if the estimated weights were the true ones: Welch and Satterthwaite's degrees of freedom, nothing added
            let plain = own.estimate.unknowns.covariance[(k, k)].sqrt();
            let budget = p.budget.iter().filter(|c| !c.source.contains("Kenward"));
            let dof = plain.powi(4) / budget.map(|c| c.u.powi(4) / c.dof).sum::<f64>();
            let t = tumble::uncertainty::quantiles::coverage_factor(0.95, dof).unwrap();
            let q = &known.parameters[of(&known)];
            let known_error = (q.value.unwrap() - truth[id]).abs();
            let counts = held.entry(id).or_default();
            counts[0] += usize::from(known_error <= q.uncertainty.as_ref().unwrap().expanded);
            counts[1] += usize::from(error <= t * plain);
            counts[2] += usize::from(error <= p.uncertainty.as_ref().unwrap().expanded);
        }
    }
    println!("share of {count} campaigns: scatters known, weights as if known, weights estimated");
    for (id, counts) in held {
        let [known, plain, own] = counts.map(|held| held as f64 / count as f64);
        println!("  {id}  {known:.4}  {plain:.4}  {own:.4}");
        assert!((known - 0.95).abs() < slack && (own - 0.95).abs() < slack && plain < own, "{id}");
    }
}

/// Starts within arcseconds, as the closed forms give them.
fn near(campaign: &Campaign) -> Campaign {
    let truth = truth("tests/data/simulated/cube-mirror.truth.json");
    let mut near = campaign.clone();
    for p in &mut near.parameters {
        if let Role::Estimated { start, .. } = &mut p.role {
            *start = Some(truth[&p.id].round());
        }
    }
    near
}
