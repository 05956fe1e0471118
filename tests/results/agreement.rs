//! Two calibrations of one unit: `E_n` holds its promise when a reference is shared, and when none is.
//!
//! `TUMBLE_CAMPAIGNS=20000 cargo test --release --test results agreement -- --nocapture` runs the full experiment.

use crate::support::parse;
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64Mcg;
use rand_pcg::rand_core::SeedableRng;
use tumble::campaign::{Campaign, Role};
use tumble::compare::calibrations::changes;
use tumble::fit::{self, Settings};
use tumble::report::{determination, fit_report};

const NOISE: f64 = 2e-4;
/// Standard uncertainties of the two standards: an offset and a factor, each several times what the noise does to a result.
const U_C: f64 = 3e-4;
const U_S: f64 = 2e-4;

fn schedule() -> Campaign {
    let readings: Vec<String> = (0..12).map(|k| format!(r#"{{"beta_deg": {}, "V": 0}}"#, 30 * k)).collect();
    parse(&format!(
        r#"{{ "bench": {{ "id": "b", "chain": [ {{"joint": "beta", "about": "x"}}, {{"tilt": "m", "about": "x"}} ],
              "sensors": {{ "V": {{ "unit": "V", "axes": {{"I": "z"}}, "model": "V0 + c0 + s*kI*a_I" }} }} }},
            "known": {{ "c0": {{ "value": 0.5, "u": {U_C} }}, "s": {{ "value": 1, "u": {U_S} }} }},
            "estimate": {{ "V0": {{}}, "m": {{}}, "kI": {{ "start": 1.3 }} }}, "readings": [{}] }}"#,
        readings.join(",")
    ))
}

/// One calibration: `c0` and `s` are what the laboratory believes of its standards, whose true values are 0.5 and 1.
fn calibrated(
    schedule: &Campaign,
    c0: f64,
    s: f64,
    random: &mut Pcg64Mcg,
) -> tumble::compare::calibrations::Determination {
    let mut own = schedule.clone();
    for (k, reading) in own.readings.rows.iter_mut().enumerate() {
        let a = ((30.0 * k as f64).to_radians() + 3e-4).cos();
        let z: f64 = StandardNormal.sample(random);
        reading.observations[0].value = 0.01 + 0.5 + 1.3 * a + NOISE * z;
    }
    for parameter in &mut own.parameters {
        if let Role::Known(known) = &mut parameter.role {
            known.value = if parameter.id == "s" { s } else { c0 };
        }
    }
    let fit = fit::fit(&own, &Settings::default()).unwrap();
    determination("x", &fit_report(&fit), None)
}

#[test]
fn en_below_one_in_95_percent() {
    let asked: usize = std::env::var("TUMBLE_CAMPAIGNS").ok().and_then(|n| n.parse().ok()).unwrap_or(2000);
    let schedule = schedule();
    println!("|E_n| <= 1 in percent of {asked} pairs of calibrations");
    for (name, one_standard) in [("both on one standard", true), ("each on its own", false)] {
        let mut random = Pcg64Mcg::seed_from_u64(26_112_021);
        let mut hits = [0_usize; 3];
        let mut quiet = 0;
        for _ in 0..asked {
            let z: [f64; 4] = std::array::from_fn(|_| StandardNormal.sample(&mut random));
            let first = (0.5 + U_C * z[0], 1.0 + U_S * z[1]);
            let second = if one_standard { first } else { (0.5 + U_C * z[2], 1.0 + U_S * z[3]) };
            let a = calibrated(&schedule, first.0, first.1, &mut random);
            let b = calibrated(&schedule, second.0, second.1, &mut random);
            let found = changes(&a, &b, 0.95, one_standard);
            for (hit, change) in hits.iter_mut().zip(&found.changes) {
                *hit += usize::from(change.e_n.is_some_and(|e_n| e_n.abs() <= 1.0));
            }
            quiet += usize::from(found.together.is_some_and(|t| t.p >= 0.05));
        }
        let percent = |n: usize| 100.0 * n as f64 / asked as f64;
        let rates: Vec<f64> = hits.iter().map(|n| percent(*n)).collect();
        println!(
            "{name:<24} V0 {:6.2}  m {:6.2}  kI {:6.2}  all together, p >= 0.05: {:6.2}",
            rates[0],
            rates[1],
            rates[2],
            percent(quiet)
        );
        // three standard errors of a rate of 95 % beside the half percent that is asked for
        let limit = 0.5 + 3.0 * (95.0 * 5.0 / asked as f64).sqrt();
        for rate in &rates {
            assert!((rate - 95.0).abs() <= limit, "{name}: {rates:?}");
        }
    }
}
