//! Seeded campaigns with a pattern in time that no line of the catalogue is: correlated noise, a slow wave, a random walk, a square wave. None of
//! them may end in "nothing missing". 32 by default, 800 with `TUMBLE_LONG=1`; `TUMBLE_SEED=7` gives others.

use super::schedules::{fitted, normal, random, schedule};
use crate::draws::draws;
use rand_pcg::{Pcg64Mcg, rand_core::SeedableRng};
use rayon::prelude::*;
use std::f64::consts::TAU;
use tumble::diagnosis::{Settings, Verdict, diagnose};
use tumble::simulate::{DrawnNoise, Truth, simulate};
use tumble::wire;

const PATTERNS: [&str; 4] = ["AR(1)", "wave", "walk", "square"];
const SCHEDULES: [&str; 4] = ["G5", "G16", "G16x45", "A24"];

/// A pattern of `n` readings with a root mean square of 1.
fn pattern(kind: &str, n: usize, generator: &mut Pcg64Mcg) -> Vec<f64> {
    let (cycles, phase) = (random(generator, 1.5, 4.5), random(generator, 0.0, TAU));
    let (memory, mut state) = (random(generator, 0.7, 0.95), normal(generator));
    let wave = |k: usize| (TAU * cycles * k as f64 / n as f64 + phase).sin();
    let mut values: Vec<f64> = (0..n)
        .map(|k| match kind {
            "wave" => wave(k),
            "square" => wave(k).signum(),
            "walk" => {
                state += normal(generator);
                state
            }
            _ => {
                state = memory * state + (1.0 - memory * memory).sqrt() * normal(generator);
                state
            }
        })
        .collect();
    let mean = values.iter().sum::<f64>() / n as f64;
    values.iter_mut().for_each(|v| *v -= mean);
    let rms = (values.iter().map(|v| v * v).sum::<f64>() / n as f64).sqrt();
    values.iter().map(|v| v / rms).collect()
}

/// Is the pattern flagged, and does the plain fit's test of runs see it (p below 1e-4)?
fn trial(kind: &str, stated: bool, schedule_name: &str, seed: u64) -> (bool, bool, String) {
    let mut generator = Pcg64Mcg::seed_from_u64(seed);
    let (plan, sd) = schedule(schedule_name, None, &mut generator);
    let mut point = plan.reference_point();
    for (value, parameter) in point.iter_mut().zip(plan.estimated()) {
        *value = if parameter.id == "V0" { 2e-3 } else { 4e-4 } * normal(&mut generator);
    }
    let noise = vec![DrawnNoise { sd, stated, decimals: None }];
    let clean = simulate(&plan, &Truth { point, noise, effects: Vec::new(), scatter: Vec::new() }, seed).unwrap();
    let mut readings = clean.readings.clone();
    let added = pattern(kind, readings.rows.len(), &mut generator);
    let size = sd * random(&mut generator, 2.0, 5.0);
    for (reading, added) in readings.rows.iter_mut().zip(added) {
        reading.observations.iter_mut().for_each(|own| own.value += size * added);
    }
    let campaign = clean.with_readings(readings);
    let plain = fitted(&campaign);
    let sees = plain.checks.runs.iter().any(|(_, test)| test.p < 1e-4);
    let found = diagnose(&campaign, &wire::built_in_effects().unwrap(), &Settings::default()).unwrap();
    let named: Vec<&str> = found.effects.iter().map(|own| own.effect.regressor.as_str()).collect();
    let report = format!("{seed} {schedule_name} {kind}: {} {named:?}", found.verdict.name());
    (found.verdict != Verdict::NothingMissing, sees, report)
}

#[test]
fn patterns_in_time_are_flagged() {
    let seed = std::env::var("TUMBLE_SEED").ok().and_then(|n| n.parse().ok()).unwrap_or(40_000_000_u64);
    let each = draws(4, 100);
    println!(
        "{:8} {:8} {:>9} {:>8} {:>22} {:>8}",
        "pattern", "noise", "campaigns", "flagged", "of those that runs see", "flagged"
    );
    let mut flagged = (0, 0);
    for (p, kind) in PATTERNS.iter().enumerate() {
        for stated in [true, false] {
            let own = |k: usize| seed + 1_000_003 * p as u64 + 500_009 * u64::from(stated) + k as u64;
            let trials: Vec<(bool, bool, String)> =
                (0..each).into_par_iter().map(|k| trial(kind, stated, SCHEDULES[k % 4], own(k))).collect();
            let count = |wanted: &dyn Fn(&(bool, bool, String)) -> bool| trials.iter().filter(|t| wanted(t)).count();
            let (all, seen, both) = (count(&|t| t.0), count(&|t| t.1), count(&|t| t.0 && t.1));
            let noise = if stated { "stated" } else { "unknown" };
            println!("{kind:8} {noise:8} {each:>9} {all:>8} {seen:>22} {both:>8}");
            trials.iter().filter(|t| !t.0).for_each(|t| println!("    {}", t.2));
            assert_eq!(both, seen, "{kind}: the plain fit sees what diagnose does not");
            flagged = (flagged.0 + all, flagged.1 + each);
        }
    }
    // 95 % are asked for; a few campaigns scatter
    assert!(flagged.0 as f64 >= 0.9 * flagged.1 as f64, "{flagged:?}");
}
