//! Constraints: an inactive one changes nothing, an active one is met to the last digit, and the rest is least squares on what is left.

use crate::support::{ARCSEC, campaign, fit_with, linear as fitted, parse};
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64Mcg;
use rand_pcg::rand_core::SeedableRng;
use tumble::campaign::{Campaign, Constraint};
use tumble::fit::{Constraints, Estimator, Fit, Settings, State, draw};
use tumble::report::fit_report;
use tumble::uncertainty::quantiles::normal_cdf;

const TABLE_1: &str = "li2012/li2012-table1.campaign.json";
const INF: f64 = f64::INFINITY;

fn index(campaign: &Campaign, id: &str) -> usize {
    campaign.parameter_index(id).unwrap()
}

fn range(campaign: &Campaign, terms: &[(&str, f64)], lower: f64, upper: f64) -> Constraint {
    Constraint::Linear { terms: terms.iter().map(|(id, c)| (index(campaign, id), *c)).collect(), lower, upper }
}

fn with(constraints: &[Constraint]) -> Campaign {
    let mut campaign = campaign(TABLE_1);
    campaign.constraints = constraints.to_vec();
    campaign
}

fn active(fit: &Fit) -> Vec<usize> {
    match &fit.constraints {
        Constraints::Met { active, .. } => active.iter().map(|a| a.constraint).collect(),
        other => panic!("{other:?}"),
    }
}

#[test]
fn an_inactive_constraint_changes_nothing() {
    let plain = campaign(TABLE_1);
    let free = fitted(&plain);
    let bound = range(&plain, &[("dtheta_y2", 1.0)], -200.0 * ARCSEC, 200.0 * ARCSEC);
    let cone =
        Constraint::Norm { of: vec![index(&plain, "dtheta_y2"), index(&plain, "dtheta_z2")], at_most: 180.0 * ARCSEC };
    let fit = fitted(&with(&[bound, cone]));
    assert!(active(&fit).is_empty());
    assert_eq!(fit.point, free.point);
    for (a, b) in fit.parameters.iter().zip(&free.parameters) {
        assert_eq!(a.uncertainty, b.uncertainty);
    }
}

#[test]
fn an_active_bound_is_met_and_the_rest_is_least_squares_on_the_face() {
    let plain = campaign(TABLE_1);
    let free = fitted(&plain);
    let limit = -150.0 * ARCSEC;
    for settings in [Settings { estimator: Estimator::Linear, ..Settings::default() }, Settings::default()] {
        let bounded = fit_with(&with(&[range(&plain, &[("dtheta_y2", 1.0)], limit, INF)]), settings);
        let fixed = fit_with(&with(&[range(&plain, &[("dtheta_y2", 1.0)], limit, limit)]), settings);
        assert_eq!(active(&bounded), vec![0]);
        assert_eq!(bounded.point[index(&plain, "dtheta_y2")], limit);
        assert_eq!(bounded.parameters[index(&plain, "dtheta_y2")].state, State::AtBound);
        for (a, b) in bounded.point.iter().zip(&fixed.point) {
            assert!((a - b).abs() <= 1e-12 * (b.abs() + 1e-6), "{a} {b}");
        }
    }
    // the multiplier is the price: chi-square for each radian
    let price = |limit: f64| match fitted(&with(&[range(&plain, &[("dtheta_y2", 1.0)], limit, INF)])).constraints {
        Constraints::Met { cost, active, .. } => (cost, active[0].multiplier),
        other => panic!("{other:?}"),
    };
    let step = 0.01 * ARCSEC;
    let slope = (price(limit + step).0 - price(limit - step).0) / (2.0 * step);
    assert!((slope / price(limit).1 - 1.0).abs() < 1e-6);
    // and in one dimension the cost is the squared distance in standard uncertainties
    let y2 = index(&plain, "dtheta_y2");
    let distance = (limit - free.point[y2]) / free.parameters[y2].uncertainty.unwrap().u;
    assert!((price(limit).0 / distance.powi(2) - 1.0).abs() < 1e-9);
}

#[test]
fn an_active_cone_is_met_and_its_normal_carries_the_gradient() {
    let plain = campaign(TABLE_1);
    let (y2, z2) = (index(&plain, "dtheta_y2"), index(&plain, "dtheta_z2"));
    let limit = 120.0 * ARCSEC;
    for estimator in [Estimator::Linear, Estimator::Exact] {
        let fit = fit_with(
            &with(&[Constraint::Norm { of: vec![y2, z2], at_most: limit }]),
            Settings { estimator, ..Settings::default() },
        );
        assert_eq!(active(&fit), vec![0]);
        assert!((fit.point[y2].hypot(fit.point[z2]) / limit - 1.0).abs() < 1e-12);
        // A' v vanishes except along the cone's normal
        let slope = |j: usize| -> f64 {
            (0..fit.estimate.residuals.len()).map(|i| fit.system.rows[(i, j)] * fit.estimate.residuals[i]).sum()
        };
        let along = slope(y2).hypot(slope(z2));
        let across = slope(y2) * fit.point[z2] - slope(z2) * fit.point[y2];
        assert!(across.abs() < 1e-8 * along * limit, "{across} {along}");
        for j in (0..6).filter(|j| *j != y2 && *j != z2) {
            assert!(slope(j).abs() < 1e-8 * along, "{j}");
        }
    }
}

#[test]
fn equations_hold_and_free_degrees_of_freedom() {
    let plain = campaign(TABLE_1);
    let equal = range(&plain, &[("dtheta_y0", 1.0), ("dtheta_y1", -1.0)], 0.0, 0.0);
    let fit = fitted(&with(&[equal]));
    assert_eq!(fit.estimate.dof, fitted(&plain).estimate.dof + 1);
    let (y0, y1) = (index(&plain, "dtheta_y0"), index(&plain, "dtheta_y1"));
    assert!((fit.point[y0] - fit.point[y1]).abs() <= 1e-12 * fit.point[y0].abs());
}

#[test]
fn contradictions_are_named() {
    let plain = campaign(TABLE_1);
    let above = range(&plain, &[("dtheta_y2", 1.0)], 100.0 * ARCSEC, INF);
    let harmless = range(&plain, &[("dtheta_y0", 1.0)], -1.0, 1.0);
    let sum = range(&plain, &[("dtheta_y2", 1.0), ("dtheta_z2", 1.0)], -INF, 120.0 * ARCSEC);
    let other = range(&plain, &[("dtheta_z2", 1.0)], 50.0 * ARCSEC, INF);
    let fit = fitted(&with(&[above.clone(), harmless, sum, other]));
    assert!(
        matches!(&fit.constraints, Constraints::Contradictory(named) if *named == [0, 2, 3]),
        "{:?}",
        fit.constraints
    );
    assert!(fit.is_rejected());
    let cone = Constraint::Norm { of: vec![index(&plain, "dtheta_y2")], at_most: 50.0 * ARCSEC };
    let fit = fitted(&with(&[above, cone]));
    assert!(matches!(&fit.constraints, Constraints::Contradictory(named) if *named == [0, 1]));
    let one = range(&plain, &[("V0", 1.0)], 1.0, 1.0);
    let two = range(&plain, &[("V0", 2.0)], 3.0, 3.0);
    let fit = fitted(&with(&[one, two]));
    assert!(matches!(&fit.constraints, Constraints::Contradictory(named) if *named == [0, 1]));
}

#[test]
fn covariance_on_the_face_is_that_of_simulated_estimates() {
    let plain = campaign(TABLE_1);
    let (y2, z2) = (index(&plain, "dtheta_y2"), index(&plain, "dtheta_z2"));
    let cone = Constraint::Norm { of: vec![y2, z2], at_most: 100.0 * ARCSEC };
    let bound = range(&plain, &[("dtheta_y1", 1.0)], -40.0 * ARCSEC, INF);
    let mut start = with(&[cone, bound]);
    let sigma = 1e-4;
    start.readings.rows.iter_mut().for_each(|r| r.observations[0].u = Some(sigma));
    let reference = fitted(&start);
    assert_eq!(active(&reference), vec![0, 1]);
    let Constraints::Met { on_face: Some(face), .. } = &reference.constraints else { panic!() };
    let mut random = Pcg64Mcg::seed_from_u64(7);
    let trials = 4000;
    let mut draws = Vec::with_capacity(trials);
    for _ in 0..trials {
        let mut own = start.clone();
        for reading in &mut own.readings.rows {
            let z: f64 = StandardNormal.sample(&mut random);
            reading.observations[0].value += sigma * z;
        }
        draws.push(fitted(&own).point[..6].to_vec());
    }
    let mean: Vec<f64> = (0..6).map(|j| draws.iter().map(|d| d[j]).sum::<f64>() / trials as f64).collect();
    for j in 0..6 {
        let variance = draws.iter().map(|d| (d[j] - mean[j]).powi(2)).sum::<f64>() / (trials as f64 - 1.0);
        if j == index(&plain, "dtheta_y1") {
            assert!(face[(j, j)].abs() < 1e-25 && variance < 1e-25);
            continue;
        }
        // the relative standard error of a variance from 4000 draws is 2.2 %
        assert!((variance / face[(j, j)] - 1.0).abs() < 0.09, "{j}: {variance} {}", face[(j, j)]);
    }
}

/// A line through readings with these inputs.
fn line(x: &[f64], y: &[f64], u: Option<f64>, constraint: &str, more: &str) -> Campaign {
    let u = u.map_or(String::new(), |u| format!(r#", "y_u": {u}"#));
    let rows: Vec<String> = x.iter().zip(y).map(|(x, y)| format!(r#"{{"x": {x}, "y": {y}{u}}}"#)).collect();
    parse(&format!(
        r#"{{ "bench": {{ "id": "line", "sensors": {{ "y": {{ "model": "a + b*x" }} }} }}, "estimate": {{ "a": {{}}, "b": {{}} }},
           "constraints": [ {{ "of": {{ "b": 1 }}, {constraint} }} ], {more} "readings": [ {} ] }}"#,
        rows.join(", ")
    ))
}

const X: [f64; 4] = [0.0, 1.0, 2.0, 3.0];
const Y: [f64; 4] = [0.1, 1.3, 1.8, 3.2];

/// Free, b = 0.98 and a = 0.13 with u(a) = 0.2 sqrt(14/20); the bounds carry them to 1.05 and 1.6 - 1.05*1.5.
#[test]
fn an_active_bound_leaves_one_meaning_of_u_and_of_intervals() {
    let derived = r#""derived": { "e": "a", "twice": "2*b" }, "#;
    let bounded = fitted(&line(&X, &Y, Some(0.2), r#""between": [1.05, 1.2]"#, derived));
    let half = 1.959_963_984_540_054 * 0.2 * (14.0_f64 / 20.0).sqrt();
    let (a, e) = (&bounded.parameters[0], &bounded.derived[0]);
    for (value, uncertainty, interval) in [(a.value, a.uncertainty, a.interval), (e.value, e.uncertainty, e.interval)] {
        assert!((value.unwrap() - 0.025).abs() < 1e-12);
        assert!((uncertainty.unwrap().expanded - half).abs() < 1e-12);
        let (low, high) = interval.unwrap();
        assert!((low - (0.13 - half)).abs() < 1e-12 && (high - (0.13 + half)).abs() < 1e-12, "{low} {high}");
    }
    // that of b and of twice b is cut: 0.98 + 1.96*0.2/sqrt 5 lies within the bounds
    let most = 0.98 + 1.959_963_984_540_054 * 0.2 / 5.0_f64.sqrt();
    let (b, twice) = (bounded.parameters[1].interval.unwrap(), bounded.derived[1].interval.unwrap());
    assert!((b.0 - 1.05).abs() < 1e-12 && (b.1 - most).abs() < 1e-12, "{b:?}");
    assert!((twice.0 - 2.1).abs() < 1e-12 && (twice.1 - 2.0 * most).abs() < 1e-12, "{twice:?}");
    let report = fit_report(&bounded);
    assert!(report.derived[0].interval.is_some() && report.derived[0].note.is_some());
}

/// Each trial of the free slope goes to the nearest bound, and the intercept with it: `a = mean of y - 1.5 b`, these two independent.
#[test]
fn monte_carlo_draws_the_constrained_estimate() {
    let bounded = fitted(&line(&X, &Y, Some(0.2), r#""between": [1.05, 1.2]"#, r#""derived": { "e": "a" }, "#));
    let trials = 200_000;
    let drawn = draw(&bounded, trials, 1, &|_| ()).unwrap().unwrap();
    let (free, sd, low, high) = (0.98, 0.2 / 5.0_f64.sqrt(), 1.05, 1.2);
    let (from, to) = ((low - free) / sd, (high - free) / sd);
    let below = |z: f64| normal_cdf(z).unwrap();
    let density = |z: f64| (-0.5 * z * z).exp() / (2.0 * std::f64::consts::PI).sqrt();
    let (left, within, right) = (below(from), below(to) - below(from), 1.0 - below(to));
    let mean = low * left + high * right + free * within + sd * (density(from) - density(to));
    let square = low * low * left
        + high * high * right
        + (free * free + sd * sd) * within
        + sd * ((free + low) * density(from) - (free + high) * density(to));
    let variance = square - mean * mean;
    let (of_a, sd_of_a) = (1.6 - 1.5 * mean, (0.01 + 2.25 * variance).sqrt());
    let expected = [(of_a, sd_of_a), (mean, variance.sqrt()), (of_a, sd_of_a)];
    for (own, (mean, sd)) in drawn.outputs.iter().zip(expected) {
        // five standard errors; the fourth moment of b, of which most trials are at the bound, is below 12 sd^4
        let root = (trials as f64).sqrt();
        assert!((own.mean - mean).abs() < 5.0 * sd / root, "{}: {} {mean}", own.id, own.mean);
        assert!((own.u / sd - 1.0).abs() < 5.0 * 11.0_f64.sqrt() / (2.0 * root), "{}: {} {sd}", own.id, own.u);
        assert_eq!(own.first_order_agrees, None, "{}", own.id);
    }
    assert!(drawn.held);
    assert!(drawn.outputs[1].interval[0] >= low - 1e-12 && drawn.outputs[1].interval[1] <= high + 1e-12);
    // bounds that no trial meets change nothing
    let wide = draw(&fitted(&line(&X, &Y, Some(0.2), r#""between": [0, 2]"#, "")), trials, 1, &|_| ());
    let wide = wide.unwrap().unwrap();
    assert!(!wide.held && wide.outputs.iter().all(|own| own.first_order_agrees == Some(true)));
}

/// Five readings of 0 at 0 and one at 2, u = 1, b at least 0.9: a = -0.3, residuals 0.3 and -1.5, chi-square 5*0.09 + 2.25 with five degrees
/// of freedom, redundancy 5/6 each.
#[test]
fn statistics_of_residuals_are_those_on_the_face() {
    let (x, y) = ([0.0, 0.0, 0.0, 0.0, 0.0, 2.0], [0.0; 6]);
    for u in [Some(1.0), None] {
        let of = |constraint: &str| fitted(&line(&x, &y, u, constraint, ""));
        let (bounded, fixed) = (of(r#""between": [0.9, null]"#), of(r#""equals": 0.9"#));
        let sd = if u.is_some() { 1.0 } else { (2.7_f64 / 5.0).sqrt() };
        assert!((bounded.point[0] + 0.3).abs() < 1e-12);
        assert!((bounded.sum_of_squares() - 2.7).abs() < 1e-12 && bounded.estimate.dof == 5);
        assert!((bounded.residual_sd().unwrap() - (2.7_f64 / 5.0).sqrt()).abs() < 1e-12);
        for (k, own) in bounded.quality().enumerate() {
            let v = if k < 5 { 0.3 } else { -1.5 };
            assert!((own.residual - v).abs() < 1e-12 && (own.redundancy - 5.0 / 6.0).abs() < 1e-12);
            assert!((own.studentized.unwrap() - v / (sd * (5.0_f64 / 6.0).sqrt())).abs() < 1e-12);
            assert!((own.mdb.unwrap() - 4.132_147_966 * sd / (5.0_f64 / 6.0).sqrt()).abs() < 1e-8);
        }
        assert_eq!(bounded.global_test.map(|test| test.dof), fixed.global_test.map(|test| test.dof));
        // a fault f of the last reading moves a by f/6, and b not at all
        let last = serde_json::to_value(fit_report(&bounded)).unwrap()["readings"][5]["external"].clone();
        let detectable = 4.132_147_966 * sd / (5.0_f64 / 6.0).sqrt();
        assert!((last["a"].as_f64().unwrap() - detectable / 6.0).abs() < 1e-8, "{last}");
        assert!(last["b"].as_f64().unwrap().abs() < 1e-12, "{last}");
    }
}

/// b = 0.98 with the variance 0.01/5: to make it 1 costs 0.02^2*5/0.01 in chi-square. Without stated u the variance is 0.138/2.
#[test]
fn an_equality_has_its_state_and_its_cost() {
    for (u, expected, p) in [(Some(0.1), 0.2, Some(0.654_720_846)), (None, 0.002 / 0.069, None)] {
        let fit = fitted(&line(&X, &Y, u, r#""equals": 1"#, ""));
        assert_eq!(fit.parameters[1].state, State::Fixed);
        assert_eq!(fit.parameters[0].state, State::Free);
        let Constraints::Met { equations: Some(cost), .. } = &fit.constraints else { panic!() };
        assert!((cost.chi_square - expected).abs() < 1e-12 && cost.count == 1 && cost.dof == 2, "{cost:?}");
        let report = fit_report(&fit).constraints.unwrap();
        assert!(!report.verdict.to_string().contains("no bound"), "{}", report.verdict);
        let own = report.equations.unwrap();
        // twice the upper tail of the normal distribution beyond sqrt 0.2
        p.into_iter().for_each(|p: f64| assert!((own.p.unwrap() - p).abs() < 1e-8, "{:?}", own.p));
        assert_eq!(own.rejected, Some(false));
    }
    // 1.2 is 0.22/sqrt(0.002) = 4.9 standard uncertainties away
    let untrue = fitted(&line(&X, &Y, Some(0.1), r#""equals": 1.2"#, ""));
    assert!(untrue.is_rejected() && fit_report(&untrue).constraints.unwrap().verdict.to_string().contains("REJECTED"));
}
