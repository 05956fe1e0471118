//! Attitude by a cube mirror and two theodolites.

use crate::draws::draws;
use crate::support::*;
use tumble::campaign::{Campaign, Role};
use tumble::compare;
use tumble::fit::{self, Fit, Settings};

const FOLDER: &str = "examples/22-cube-mirror";

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

fn rule(path: &str) -> (f64, f64) {
    let fit = fit::fit(&campaign(&format!("{FOLDER}/{path}")), &Settings::default()).unwrap();
    let uncertainty = fit.parameters[0].uncertainty.unwrap();
    (uncertainty.u, uncertainty.dof)
}

/// The paper: repeatabilities of the roll 0.69 and 0.76 arcsec (n = 6), circle error 0.5 arcsec, U = 0.82 arcsec (k = 2, u = 0.41).
#[test]
fn by_which_reading_of_the_rule_the_printed_041_comes_out() {
    let (s1, s2, n, circle) = (0.69f64, 0.76f64, 6.0f64, 0.5 / 3f64.sqrt());
    let root = |a: f64, b: f64| (a * a + b * b).sqrt();
    let stated = [root(s1 / n.sqrt(), circle), root(s2 / n.sqrt(), circle)];
    // the program gives the stated rule
    for (path, u) in ["roll-069.campaign.json", "roll-076.campaign.json"].iter().zip(stated) {
        assert!((rule(path).0 - u).abs() < 1e-6, "{path}");
    }
    assert_eq!(stated.map(|u| (u * 100.0).round() / 100.0), [0.40, 0.42]);
    let pooled = ((s1 * s1 + s2 * s2) / 2.0).sqrt();
    let readings = [
        ("stated rule, s = 0.69", stated[0]),
        ("stated rule, s = 0.76", stated[1]),
        ("stated rule, pooled s of both runs", root(pooled / n.sqrt(), circle)),
        ("mean of the two results of the stated rule", (stated[0] + stated[1]) / 2.0),
        ("pooled s over all twelve values", root(pooled / 12f64.sqrt(), circle)),
        ("circle error of a mean of two faces, s = 0.76", root(s2 / n.sqrt(), circle / 2f64.sqrt())),
        ("two runs as two effects, no circle error", root(s1 / n.sqrt(), s2 / n.sqrt())),
        ("circle error as a standard uncertainty, s = 0.76", root(s2 / n.sqrt(), 0.5)),
        ("no division by sqrt(6), s = 0.69", root(s1, circle)),
    ];
    println!("u, arcsec");
    for (how, u) in readings {
        println!("  {how:50} {u:.4}  U = {:.3}", 2.0 * u);
        let printed = (u * 100.0).round() / 100.0 == 0.41;
        assert_eq!(printed, how.contains("pooled s of both runs") || how.contains("mean of the two"), "{how} {u}");
    }
}

#[test]
fn what_hides_in_what_is_named() {
    let mut campaign = campaign(&format!("{FOLDER}/attitude.campaign.json"));
    // without the mark nothing fixes the azimuths
    for row in &mut campaign.readings.rows {
        row.observations.retain(|o| o.sensor != 0);
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
    for o in stated.readings.rows.iter_mut().flat_map(|row| &mut row.observations) {
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
            let plain = own.estimate.covariance[(k, k)].sqrt();
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
