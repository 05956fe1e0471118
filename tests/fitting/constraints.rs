//! Constraints: an inactive one changes nothing, an active one is met to the last digit, and the rest is least squares on what is left.

use crate::support::{ARCSEC, campaign, fit_with, linear as fitted};
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64Mcg;
use rand_pcg::rand_core::SeedableRng;
use tumble::campaign::{Campaign, Constraint};
use tumble::fit::{Constraints, Estimator, Fit, Settings, State};

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
