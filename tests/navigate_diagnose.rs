//! Which calibration errors explain measured navigation errors: seeded experiments on the full simulation.
//!
//! The data are always flown by the full nonlinear navigator (`navigate::run`), never by the linear signatures that the search uses.
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64Mcg;
use rand_pcg::rand_core::SeedableRng;
use tumble::diagnosis::{NoiseFrom, Settings, Verdict};
use tumble::navigate::diagnose::{NavigationDiagnosis, diagnose};
use tumble::navigate::errors::{ImuErrors, Source};
use tumble::navigate::measured::{Channels, Measured, MeasuredRow};
use tumble::navigate::mission::{Mission, Site};
use tumble::navigate::motion::{Attitude, Motion, Oscillation};
use tumble::navigate::signatures;

const HOUR: f64 = 3600.0;
const ARCSEC: f64 = std::f64::consts::PI / (180.0 * 3600.0);
/// Standard uncertainties of the channels, SI: 2 arcsec, 0.01 m/s, 5 m.
const U: Channels = [2.0 * ARCSEC, 2.0 * ARCSEC, 2.0 * ARCSEC, 0.01, 0.01, 5.0, 5.0];

fn site() -> Site {
    Site { latitude: 45.7796f64.to_radians(), longitude: 126.6705f64.to_radians(), altitude: 0.0 }
}

fn at_rest() -> Motion {
    Motion::at_rest(0.0, 0.0, -60f64.to_radians())
}

fn swing() -> Motion {
    let angle = |mean: f64, amplitude: f64, period: f64, phase: f64| Oscillation {
        mean: mean.to_radians(),
        amplitude: amplitude.to_radians(),
        period,
        phase: phase.to_radians(),
    };
    let yaw = angle(-60.0, 5.0, 10.0, 45.0);
    Motion::swing(Attitude { pitch: angle(0.0, 7.0, 6.0, 0.0), roll: angle(0.0, 10.0, 8.0, 0.0), yaw }).unwrap()
}

/// Six hours with a row every 97.3 s, so that rows do not fall on the phase of a swing.
fn mission(motion: Motion) -> Mission {
    Mission::new(site(), 0.05, 6.0 * HOUR, 60.0, motion).unwrap()
}

fn times(mission: &Mission) -> Vec<f64> {
    (0..).map(|k| 97.3 * f64::from(k)).take_while(|t| *t <= mission.duration()).collect()
}

/// Normal noise of standard uncertainty `u` on what the full simulation gives.
fn measured(times: &[f64], truth: &[Channels], seed: u64, stated: bool) -> Measured {
    let mut generator = Pcg64Mcg::seed_from_u64(seed);
    let mut measured = Measured::default();
    for (time, truth) in times.iter().zip(truth) {
        let mut value = [None; 7];
        for ((slot, z), u) in value.iter_mut().zip(truth).zip(U) {
            let unit: f64 = StandardNormal.sample(&mut generator);
            *slot = Some(z + u * unit);
        }
        measured.push(0, MeasuredRow { time: *time, value, u: U.map(|u| stated.then_some(u)) });
    }
    measured
}

/// The size of an error at which its evidence has a normal score of `t`, and `None` where these data do not show it.
fn size(mission: &Mission, source: usize, times: &[f64], t: f64) -> Option<f64> {
    let instants = signatures::instants(mission, &mission.motion, times);
    let square: f64 = instants
        .iter()
        .filter_map(|i| i.signatures.get(source))
        .flat_map(|s| s.iter().zip(U).map(|(s, u)| (s / u) * (s / u)).collect::<Vec<f64>>())
        .sum();
    let size = t / square.sqrt();
    (size < Source::catalogue()[source].limit()).then_some(size)
}

fn names(found: &NavigationDiagnosis) -> Vec<String> {
    found.findings.iter().map(|f| f.source.id()).collect()
}

/// Every error of the catalogue alone, at t = 12, is named, or is an alias of what is named; twice, with other noise.
#[test]
fn one_error_is_named() {
    for (name, motion) in [("static", at_rest()), ("swing", swing())] {
        let mission = mission(motion);
        let times = times(&mission);
        println!("{name}: hidden, its size, named (t), aliases; right in");
        let (mut right, mut tried) = (0, 0);
        for (j, source) in Source::catalogue().into_iter().enumerate() {
            let Some(size) = size(&mission, j, &times, 12.0) else {
                println!("  {:32} cannot be seen", source.id());
                continue;
            };
            let truth = signatures::predicted(&mission, &mission.motion, &ImuErrors::single(source, size), &times);
            for seed in 0..2 {
                let data = measured(&times, &truth, 100 * j as u64 + seed, true);
                let found = diagnose(&mission, &data, &Settings::default()).unwrap();
                let first = found.findings.first();
                let named = first.is_some_and(|f| f.source == source);
                let alias = first.is_some_and(|f| f.aliases.iter().any(|a| a.source == source));
                let ok = found.findings.len() == 1 && (named || alias);
                tried += 1;
                right += usize::from(ok);
                if seed == 0 || !ok {
                    let aliases = first.map_or(0, |f| f.aliases.len());
                    let t = first.map_or(0.0, |f| f.t);
                    let way = if named {
                        "named"
                    } else if alias {
                        "alias"
                    } else {
                        "WRONG"
                    };
                    println!(
                        "  {:32} {:10.3e} {:22} {way} {:?} t {t:.1}, {aliases} aliases",
                        source.id(),
                        size / source.si_per_unit(),
                        source.unit(),
                        names(&found)
                    );
                }
            }
        }
        println!("{name}: {right} of {tried}");
        assert!(right as f64 >= 0.97 * tried as f64, "{name}");
    }
}
