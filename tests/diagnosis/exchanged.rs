//! Readings entered in each other's rows: seeded campaigns with one, two or three pairs exchanged, or with two bad readings, which are no pair. Schedules are
//! drawn, noise is stated or not. 6 campaigns a row by default, 100 with `TUMBLE_LONG=1`.

use super::schedules::{normal, random, schedule};
use crate::draws::draws;
use rand_pcg::{Pcg64Mcg, rand_core::SeedableRng};
use tumble::diagnosis::{Settings, diagnose};
use tumble::simulate::{DrawnNoise, Truth, simulate};
use tumble::wire;

/// Names that are hidden, and names that are given, aliases with each.
type Outcome = (Vec<String>, Vec<Vec<String>>);

/// Values exchanged differ by 15 to 600 standard deviations; a bad reading is 15 to 40 off.
fn trial(pairs: usize, bad: usize, stated: bool, seed: u64) -> Outcome {
    let mut generator = Pcg64Mcg::seed_from_u64(seed);
    let (plan, sd) = schedule("drawn-gyro", None, &mut generator);
    let mut point = plan.reference_point();
    for (value, parameter) in point.iter_mut().zip(plan.estimated()) {
        *value = normal(&mut generator) * if parameter.id == "V0" { 2e-3 } else { 4e-4 };
    }
    let noise = vec![DrawnNoise { sd, stated, decimals: None }];
    let mut campaign =
        simulate(&plan, &Truth { point, noise, effects: Vec::new(), scatter: Vec::new() }, seed).unwrap();
    let rows = campaign.readings.rows.len();
    let (mut used, mut hidden) = (Vec::new(), Vec::new());
    let mut tries = 0;
    while hidden.len() < pairs && tries < 10_000 {
        tries += 1;
        let mut any = || random(&mut generator, 0.0, rows as f64) as usize;
        let (a, b) = (any(), any());
        let value = |k: usize| campaign.readings.rows[k].observations[0].value;
        let (one, other) = (value(a), value(b));
        if used.contains(&a) || used.contains(&b) || !(15.0..600.0).contains(&((one - other).abs() / sd)) {
            continue;
        }
        campaign.readings.rows[a].observations[0].value = other;
        campaign.readings.rows[b].observations[0].value = one;
        used.extend([a, b]);
        hidden.push(format!("exchange:{}:{}", a.min(b) + 1, a.max(b) + 1));
    }
    while hidden.len() < pairs + bad {
        let k = random(&mut generator, 0.0, rows as f64) as usize;
        if !used.contains(&k) {
            let size = sd * random(&mut generator, 15.0, 40.0);
            campaign.readings.rows[k].observations[0].value += if normal(&mut generator) < 0.0 { -size } else { size };
            used.push(k);
            hidden.push(format!("reading:{}", k + 1));
        }
    }
    let found = diagnose(&campaign, &wire::built_in_effects().unwrap(), &Settings::default()).unwrap();
    let names = found.effects.iter().map(|finding| {
        let aliases = finding.aliases.iter().map(|alias| alias.regressor.clone());
        std::iter::once(finding.effect.regressor.clone()).chain(aliases).collect()
    });
    (hidden, names.collect())
}

#[test]
fn exchanged_readings_are_named_as_pairs() {
    let count = draws(6, 100);
    println!("{:>6} {:>4} {:>7} {:>10} {:>7} {:>6}", "pairs", "bad", "noise", "campaigns", "named", "wrong");
    // the shares asked of one, two and three effects, and of wrong names, less and more two standard deviations of the count
    let deviations = |share: f64, all: usize| 2.0 * (share * (1.0 - share) * all as f64).sqrt();
    for (pairs, bad, share) in [(1, 0, 0.98), (2, 0, 0.95), (3, 0, 0.90), (0, 2, 0.95)] {
        for stated in [true, false] {
            let (mut named, mut all, mut wrong) = (0, 0, 0);
            for seed in 0..count as u64 {
                let (hidden, names) = trial(pairs, bad, stated, 770_000 + seed);
                named += hidden.iter().filter(|name| names.iter().any(|found| found.contains(name))).count();
                all += hidden.len();
                wrong += names.iter().filter(|found| !found.iter().any(|name| hidden.contains(name))).count();
            }
            let noise = if stated { "stated" } else { "-" };
            println!("{pairs:>6} {bad:>4} {noise:>7} {count:>10} {named:>3}/{all:<3} {wrong:>6}");
            let least = share * all as f64 - deviations(share, all);
            let most = 0.02 * all as f64 + deviations(0.02, all);
            assert!(named as f64 >= least, "{pairs} pairs, {bad} bad readings: {named} of {all}");
            assert!(wrong as f64 <= most, "{pairs} pairs, {bad} bad readings: {wrong} wrong");
        }
    }
}
