//! Stated 95 % intervals hold what they promise: in a long run 20,000 seeded campaigns for each schedule, coverage 95 +- 0.5 % for every
//! parameter; else 1,500 campaigns and +- 1.8 %.
//!
//! The standard error of a coverage from 20,000 campaigns is 0.15 %, so 0.5 % is more than three of them. The table is printed.

use crate::draws::draws;
use rand_distr::{ChiSquared, Distribution, StandardNormal, StandardUniform};
use rand_pcg::Pcg64Mcg;
use rand_pcg::rand_core::SeedableRng;
use rayon::prelude::*;
use tumble::campaign::{Campaign, Constraint, Role};
use tumble::design::Model;
use tumble::fit::{self, Estimator, Remount, Settings};
use tumble::wire;

/// Campaigns for each schedule.
fn campaigns() -> usize {
    draws(1_500, 20_000)
}

const SIGMA: f64 = 2e-4;

/// Two rates at each of these positions of the gyro's table, `repeats` times.
fn gyro(positions: &[(f64, f64)], repeats: usize, extra: &str) -> Campaign {
    let mut readings = Vec::new();
    for (k, (alpha, beta)) in positions.iter().enumerate() {
        for _ in 0..repeats {
            for rate in [20.0, -20.0] {
                readings.push(format!(
                    r#"{{"position": "{k}", "alpha_deg": {alpha}, "beta_deg": {beta}, "gamma_deg_s": {rate}, "V": 0}}"#
                ));
            }
        }
    }
    let text = format!(
        r#"{{"bench": "gyro-turntable", {extra}
            "estimate": {{"V0": {{}}, "dtheta_y0": {{}}, "dtheta_x0": {{}}, "dtheta_y1": {{}}, "dtheta_y2": {{}}, "dtheta_z2": {{}}}},
            "readings": [{}]}}"#,
        readings.join(",")
    );
    wire::read_campaign(&wire::Source { name: "coverage".into(), text }, &mut |_| unreachable!()).unwrap()
}

const EIGHT: [(f64, f64); 8] =
    [(0.0, 0.0), (0.0, 180.0), (180.0, 180.0), (180.0, 0.0), (90.0, 0.0), (90.0, 180.0), (90.0, 90.0), (270.0, 270.0)];
const TRUTH: [f64; 6] = [1.5e-3, -3.6e-5, 1.2e-5, -2.6e-4, -7.9e-4, 2.7e-4];
const KNOWN: &str = r#""known": {"kI": {"value": -2.9222}},"#;

/// Noiseless values of every reading.
fn truth_values(campaign: &Campaign) -> Vec<f64> {
    let model = Model::new(campaign).unwrap();
    let mut point = campaign.reference_point();
    point[..6].copy_from_slice(&TRUTH);
    let mut gradient = vec![0.0; campaign.parameters.len()];
    let mut work = model.workspace();
    (0..campaign.readings.rows.len())
        .map(|k| model.predict(campaign, k, 0, &point, &mut gradient, &mut work).unwrap())
        .collect()
}

fn normal(random: &mut Pcg64Mcg) -> f64 {
    StandardNormal.sample(random)
}

/// Coverage of each parameter's interval. `disturb` changes a campaign that has noiseless values.
fn coverage(
    name: &str,
    campaign: &Campaign,
    settings: &Settings,
    disturb: impl Fn(&mut Campaign, &mut Pcg64Mcg) + Sync,
) -> Vec<f64> {
    let values = truth_values(campaign);
    let settings = Settings { estimator: Estimator::Linear, ..*settings };
    let hits: Vec<[bool; 6]> = (0..campaigns())
        .into_par_iter()
        .map(|k| {
            let mut random =
                Pcg64Mcg::seed_from_u64((k as u64).wrapping_mul(0x5851_f42d_4c95_7f2d) ^ name.len() as u64);
            let mut own = campaign.clone();
            for (reading, value) in own.readings.rows.iter_mut().zip(&values) {
                reading.observations[0].value = *value;
            }
            disturb(&mut own, &mut random);
            let fit = fit::fit(&own, &settings).unwrap();
            std::array::from_fn(|j| {
                fit.parameters[j].interval.is_some_and(|(low, high)| low <= TRUTH[j] && TRUTH[j] <= high)
            })
        })
        .collect();
    let rates: Vec<f64> =
        (0..6).map(|j| 100.0 * hits.iter().filter(|h| h[j]).count() as f64 / hits.len() as f64).collect();
    let cells: Vec<String> = rates.iter().map(|r| format!("{r:7.2}")).collect();
    println!("{name:<58} {}", cells.join(" "));
    rates
}

fn scatter(campaign: &mut Campaign, random: &mut Pcg64Mcg) {
    for reading in &mut campaign.readings.rows {
        reading.observations[0].value += SIGMA * normal(random);
    }
}

fn known_ki(campaign: &mut Campaign, value: f64, u: f64) {
    let ki = campaign.parameters.iter_mut().find(|p| p.id == "kI").unwrap();
    if let Role::Known(known) = &mut ki.role {
        known.value = value;
        known.u = u;
    }
}

#[test]
fn stated_intervals_hold_95_percent() {
    let plain = Settings::default();
    let mut table: Vec<(String, Vec<f64>)> = Vec::new();
    println!("coverage of 95 % intervals over {} campaigns each, in percent", campaigns());
    println!("{:<58} {:>7} {:>7} {:>7} {:>7} {:>7} {:>7}", "schedule", "V0", "y0", "x0", "y1", "y2", "z2");
    let mut run = |name: &str,
                   campaign: &Campaign,
                   settings: &Settings,
                   disturb: &(dyn Fn(&mut Campaign, &mut Pcg64Mcg) + Sync)| {
        table.push((name.to_string(), coverage(name, campaign, settings, disturb)));
    };

    let sixteen = gyro(&EIGHT, 1, KNOWN);
    run("estimated variance, 16 readings", &sixteen, &plain, &scatter);
    run("known variance, 16 readings", &sixteen, &plain, &|c, r| {
        scatter(c, r);
        c.readings.rows.iter_mut().for_each(|reading| reading.observations[0].u = Some(SIGMA));
    });

    for dof in [3, 4, 5] {
        let mut few = sixteen.clone();
        few.readings.rows.truncate(12);
        // the last position separates z2 from x0; keep it instead of one that repeats
        few.readings.rows[11] = sixteen.readings.rows[14].clone();
        few.readings.rows.truncate(12);
        while few.readings.rows.len() > 6 + dof {
            few.readings.rows.remove(1);
        }
        run(&format!("estimated variance, {dof} degrees of freedom"), &few, &plain, &scatter);
    }

    let with_u = |more: &str| format!(r#""known": {{"kI": {{"value": -2.9222, "u": 0.03{more}}}}},"#);
    run("known kI, u = 1 %, normal", &gyro(&EIGHT, 1, &with_u("")), &plain, &|c, r| {
        scatter(c, r);
        let value = -2.9222 + 0.03 * normal(r);
        known_ki(c, value, 0.03);
    });
    let rectangular = gyro(&EIGHT, 1, &with_u(r#", "distribution": "rectangular""#));
    run("known kI, u = 0.1 %, rectangular, beside the readings", &rectangular, &plain, &|c, r| {
        scatter(c, r);
        let uniform: f64 = StandardUniform.sample(r);
        known_ki(c, -2.9222 + 0.003 * 3f64.sqrt() * (2.0 * uniform - 1.0), 0.003);
    });
    for dof in [3.0_f64, 5.0] {
        let few = gyro(&EIGHT, 1, &with_u(&format!(r#", "dof": {dof}"#)));
        run(&format!("known kI, u = 0.2 % from {dof} degrees of freedom"), &few, &plain, &|c, r| {
            scatter(c, r);
            let value = -2.9222 + 0.006 * normal(r);
            let u = 0.006 * (ChiSquared::new(dof).unwrap().sample(r) / dof).sqrt();
            known_ki(c, value, u);
        });
    }

    // bounds on y2: on the truth, and half a standard uncertainty beyond it
    let u_y2 = SIGMA / (2.9222 * 20.0 * 2.0);
    for (name, beyond) in [("on the truth", 0.0), ("half a u beyond the truth", 0.5), ("two u beyond the truth", 2.0)] {
        let mut bounded = sixteen.clone();
        bounded.constraints.push(Constraint::Linear {
            terms: vec![(4, 1.0)],
            lower: f64::NEG_INFINITY,
            upper: TRUTH[4] + beyond * u_y2,
        });
        run(&format!("upper bound of y2 {name}"), &bounded, &plain, &scatter);
    }

    let remount = Settings { remount: Remount::Estimate, ..Settings::default() };
    let twelve: Vec<(f64, f64)> =
        EIGHT.iter().copied().chain([(45.0, 45.0), (135.0, 225.0), (225.0, 135.0), (315.0, 315.0)]).collect();
    let many = gyro(&twelve, 2, KNOWN);
    for (name, offset) in [("0.3", 0.3), ("1", 1.0), ("5", 5.0)] {
        run(&format!("remounting, 12 positions of 4, offsets {name} sd"), &many, &remount, &|c, r| {
            scatter(c, r);
            for k in 0..12 {
                let shift = offset * SIGMA * normal(r);
                for reading in &mut c.readings.rows[4 * k..4 * k + 4] {
                    reading.observations[0].value += shift;
                }
            }
        });
    }
    let stated = Settings { remount: Remount::Stated(5.0 * SIGMA), ..Settings::default() };
    run("remounting, stated offset, 8 positions of 2", &sixteen, &stated, &|c, r| {
        scatter(c, r);
        for k in 0..8 {
            let shift = 5.0 * SIGMA * normal(r);
            for reading in &mut c.readings.rows[2 * k..2 * k + 2] {
                reading.observations[0].value += shift;
            }
        }
    });
    let slack = 0.5 * (20_000.0 / campaigns() as f64).sqrt();
    for (name, rates) in &table {
        for rate in rates {
            assert!((rate - 95.0).abs() <= slack, "{name}: {rates:?}");
        }
    }
}
