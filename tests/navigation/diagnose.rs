//! Which calibration errors explain measured navigation errors: seeded experiments on the full simulation.
//!
//! The data are always flown by the full nonlinear navigator (`navigate::run`), never by the linear signatures that the search uses.
use crate::diagnosis::{NoiseFrom, Verdict};
use crate::draws::{draws, long};
use crate::laws::predicted;
use crate::navigate::diagnose::{NavigationDiagnosis, diagnose};
use crate::navigate::errors::{ErrorSource, ImuErrors};
use crate::navigate::measured::{CHANNEL_NAMES, Channels, Measured, MeasuredRow, channels, si_per_unit};
use crate::navigate::mission::{Mission, Site};
use crate::navigate::motion::{Attitude, Motion, Oscillation};
use crate::navigate::run::{self, Continue, Scenario};
use crate::navigate::settings::Settings;
use crate::navigate::signatures;
use rand_distr::{Distribution, StandardNormal, StandardUniform};
use rand_pcg::Pcg64Mcg;
use rand_pcg::rand_core::SeedableRng;
use rayon::prelude::*;

const HOUR: f64 = 3600.0;
const ARCSEC: f64 = std::f64::consts::PI / (180.0 * 3600.0);
/// Standard uncertainties of the channels, SI: 2 arcsec, 0.01 m/s, 5 m.
const U: Channels = [2.0 * ARCSEC, 2.0 * ARCSEC, 2.0 * ARCSEC, 0.01, 0.01, 5.0, 5.0];

fn site() -> Site {
    Site { latitude_rad: 45.7796f64.to_radians(), longitude_rad: 126.6705f64.to_radians(), altitude_m: 0.0 }
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

/// Six hours (four in a short run) with a row every 97.3 s, so that rows do not fall on the phase of a swing.
fn mission(motion: Motion) -> Mission {
    let (step, hours) = (if motion.fastest_rate() > 0.0 { 0.1 } else { 0.5 }, if long() { 6.0 } else { 4.0 });
    Mission::new(site(), step, hours * HOUR, 60.0, motion).unwrap()
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
    (size < ErrorSource::catalogue()[source].limit()).then_some(size)
}

fn names(found: &NavigationDiagnosis) -> Vec<String> {
    found.findings.iter().map(|f| f.source.id()).collect()
}

/// Every error of the catalogue alone, at t = 12, is named, or is an alias of what is named; in a long run at rest twice, with other noise,
/// else every sixth one at rest and every twelfth in the swing.
#[test]
fn one_error_is_named() {
    let full = [("static", at_rest(), 2, 1), ("swing", swing(), 1, 1)];
    let short = [("static", at_rest(), 1, 6), ("swing", swing(), 1, 12)];
    for (name, motion, seeds, every) in if long() { full } else { short } {
        let mission = mission(motion);
        let times = times(&mission);
        println!("{name}: hidden, its size, how it came out, named, its t and aliases");
        let rows: Vec<(String, usize, usize)> = ErrorSource::catalogue()
            .into_par_iter()
            .enumerate()
            .filter(|(j, _)| j % every == 0)
            .map(|(j, source)| {
                let Some(size) = size(&mission, j, &times, 12.0) else {
                    return (format!("  {:32} cannot be seen", source.id()), 0, 0);
                };
                let truth = predicted(&mission, &mission.motion, &ImuErrors::single(source, size), &times);
                let (mut text, mut right) = (String::new(), 0);
                for seed in 0..seeds {
                    let data = measured(&times, &truth, 100 * j as u64 + seed, true);
                    let found = diagnose(&mission, &data, &Settings::default()).unwrap();
                    let way = way(&found, &[source]);
                    right += usize::from(way != "WRONG");
                    if seed == 0 || way == "WRONG" {
                        let (t, aliases) = found.findings.first().map_or((0.0, 0), |f| (f.t, f.aliases.len()));
                        let (id, size, unit) = (source.id(), size / source.si_per_unit(), source.unit());
                        let named = names(&found).join(" + ");
                        text +=
                            &format!("  {id:32} {size:10.3e} {unit:18} {way:6} {named} t {t:.1}, {aliases} aliases\n");
                    }
                }
                (text.trim_end().to_string(), right, seeds as usize)
            })
            .collect();
        rows.iter().for_each(|(text, _, _)| println!("{text}"));
        let (right, tried) = rows.iter().fold((0, 0), |sum, row| (sum.0 + row.1, sum.1 + row.2));
        println!("{name}: {right} of {tried}");
        assert!(tried >= if long() { 35 } else { 3 } && right as f64 >= 0.97 * tried as f64, "{name}");
    }
}

/// How the hidden errors came out: all named, named or among the aliases of different findings, or wrong.
fn way(found: &NavigationDiagnosis, hidden: &[ErrorSource]) -> &'static str {
    if found.findings.len() != hidden.len() {
        return "WRONG";
    }
    if hidden.iter().all(|source| found.findings.iter().any(|f| f.source == *source)) {
        return "named";
    }
    let holds = |k: usize, source: &ErrorSource| {
        found.findings.get(k).is_some_and(|f| f.source == *source || f.aliases.iter().any(|a| a.source == *source))
    };
    let straight = hidden.iter().enumerate().all(|(k, source)| holds(k, source));
    let crossed = hidden.iter().rev().enumerate().all(|(k, source)| holds(k, source));
    if straight || crossed { "alias" } else { "WRONG" }
}

/// Two errors at once, drawn at random, each at t = 15 alone; of pairs that one error does not explain to within eight standard deviations.
#[test]
fn two_errors_are_named() {
    for (name, motion) in [("static", at_rest()), ("swing", swing())] {
        let mission = mission(motion);
        let times = times(&mission);
        let visible: Vec<(usize, ErrorSource, f64)> = ErrorSource::catalogue()
            .into_iter()
            .enumerate()
            .filter_map(|(j, source)| Some((j, source, size(&mission, j, &times, 15.0)?)))
            .collect();
        let columns = columns(&mission, &times, &visible);
        let results: Vec<(String, &str)> = (0..draws(4, 24) as u64)
            .into_par_iter()
            .map(|seed| {
                let mut generator = Pcg64Mcg::seed_from_u64(seed);
                let mut draw = || {
                    let unit: f64 = StandardUniform.sample(&mut generator);
                    (unit * visible.len() as f64) as usize
                };
                let (mut a, mut b) = (draw(), draw());
                while a == b || beyond_one(&columns, a, b) < 8.0 {
                    (a, b) = (draw(), draw());
                }
                let (first, second) = (visible[a], visible[b]);
                let mut errors = ImuErrors::single(first.1, first.2);
                second.1.set(&mut errors, -second.2);
                let truth = predicted(&mission, &mission.motion, &errors, &times);
                let found =
                    diagnose(&mission, &measured(&times, &truth, 1000 + seed, true), &Settings::default()).unwrap();
                let way = way(&found, &[first.1, second.1]);
                let text = format!("  {:30} {:30} {way:6} {}", first.1.id(), second.1.id(), names(&found).join(" + "));
                (text, way)
            })
            .collect();
        println!("{name}: two hidden, how they came out, named");
        results.iter().for_each(|(text, _)| println!("{text}"));
        let right = results.iter().filter(|(_, way)| *way != "WRONG").count();
        println!("{name}: {right} of {}", results.len());
        assert!(right as f64 >= (0.95 * results.len() as f64).floor(), "{name}");
    }
}

/// What each error does at its size, in standard uncertainties.
fn columns(mission: &Mission, times: &[f64], errors: &[(usize, ErrorSource, f64)]) -> Vec<Vec<f64>> {
    let instants = signatures::instants(mission, &mission.motion, times);
    let column = |(j, _, size): &(usize, ErrorSource, f64)| -> Vec<f64> {
        let one = |channels: &Channels| channels.iter().zip(U).map(|(s, u)| size * s / u).collect::<Vec<f64>>();
        instants.iter().flat_map(|i| one(&i.signatures[*j])).collect()
    };
    errors.iter().map(column).collect()
}

/// What any one error leaves of the first less the second, in standard deviations.
fn beyond_one(columns: &[Vec<f64>], a: usize, b: usize) -> f64 {
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>();
    let both: Vec<f64> = columns[a].iter().zip(&columns[b]).map(|(x, y)| x - y).collect();
    let left = |one: &Vec<f64>| dot(&both, &both) - dot(&both, one).powi(2) / dot(one, one);
    columns.iter().map(left).fold(f64::INFINITY, f64::min).max(0.0).sqrt()
}

/// A short mission for many seeds.
fn short() -> Mission {
    let mut mission = Mission::new(site(), 0.5, 3.0 * HOUR, 60.0, at_rest()).unwrap();
    ErrorSource::named("gyro_bias_x").unwrap().set(&mut mission.errors, 5e-8);
    mission
}

/// Nothing is hidden, and nothing is found: with stated noise, with noise from residuals, and with random walks that the mission states.
#[test]
fn nothing_is_found_where_nothing_is_hidden() {
    let count = draws(8, 400) as u64;
    for (name, stated, walk) in [("stated u", true, 0.0), ("u from residuals", false, 0.0), ("random walk", true, 1.0)]
    {
        let mut mission = short();
        mission.errors.gyro.random_walk = walk * 0.003f64.to_radians() / 60.0;
        mission.errors.accelerometer.random_walk = walk * 0.01 / 60.0;
        let times = times(&mission);
        let quiet: Vec<usize> = (0..count)
            .into_par_iter()
            .map(|seed| {
                let mut flown = mission.clone();
                flown.seed = seed;
                let data = measured(&times, &noisy(&flown, &times), 7 * seed + 1, stated);
                let found = diagnose(&mission, &data, &Settings::default()).unwrap();
                let is_quiet = found.verdict == Verdict::NothingMissing;
                if !is_quiet {
                    println!(
                        "{name}, seed {seed}: {:?}, {:?}, suspected {:?}",
                        found.verdict,
                        names(&found),
                        found.suspected
                    );
                }
                usize::from(is_quiet)
            })
            .collect();
        let quiet = quiet.iter().sum::<usize>();
        println!("{name}: nothing found in {quiet} of {count}");
        // the significance is 1 %; three standard deviations of that many draws
        assert!(quiet as f64 >= count as f64 * (0.99 - 3.0 * (0.01 * 0.99 / count as f64).sqrt()), "{name}");
    }
}

/// The full simulation with the mission's random walks.
fn noisy(mission: &Mission, times: &[f64]) -> Vec<Channels> {
    let scenario = Scenario { id: String::new(), errors: mission.errors };
    let mut rows: Vec<(f64, Channels)> = Vec::new();
    run::fly_to(mission, &mission.motion, &[scenario], &mut |done| done + 2, &mut |row| {
        rows.push((row.truth.time, channels(&row.errors[0])));
        Continue::Yes
    });
    let at = |time: &f64| {
        let k = rows.partition_point(|(t, _)| t <= time).clamp(1, rows.len() - 1);
        let ((t0, a), (t1, b)) = (rows[k - 1], rows[k]);
        std::array::from_fn(|i| a[i] + (time - t0) / (t1 - t0) * (b[i] - a[i]))
    };
    times.iter().map(at).collect()
}

/// What is no constant error is not forced onto the name of one: an error that starts late is the step of its source or unexplained, a random
/// walk that the mission does not state is that walk or unexplained, a bad value is that reading or unexplained.
#[test]
fn what_is_not_in_the_catalogue_is_unexplained() {
    let mission = Mission { errors: ImuErrors::default(), ..short() };
    let times = times(&mission);
    let count = draws(4, 40) as u64;
    let late = |seed: u64| {
        // at rest the navigator does not change in time, so that an error from a later time on is the same, later
        let source = ["gyro_bias_y", "accelerometer_bias_x", "gyro_bias_z"][seed as usize % 3];
        let j = ErrorSource::catalogue().iter().position(|s| s.id() == source).unwrap();
        // flown at the size of t = 80 over the whole run, and made t = 80 for what is left of the run (static, small: linear)
        let size = size(&mission, j, &times, 80.0).unwrap();
        let errors = ImuErrors::single(ErrorSource::named(source).unwrap(), size);
        let start = 5000.0 + 40.0 * seed as f64;
        let later: Vec<f64> = times.iter().map(|t| (t - start).max(0.0)).collect();
        let mut truth = predicted(&mission, &mission.motion, &errors, &later);
        let square: f64 = truth.iter().flat_map(|z| z.iter().zip(U)).map(|(z, u)| (z / u) * (z / u)).sum();
        truth.iter_mut().flatten().for_each(|z| *z *= 80.0 / square.sqrt());
        truth
    };
    let walk = |seed: u64| {
        let mut flown = mission.clone();
        flown.seed = seed;
        flown.errors.gyro.random_walk = 0.01f64.to_radians() / 60.0;
        noisy(&flown, &times)
    };
    let bad = |seed: u64| {
        let mut truth = vec![[0.0; 7]; times.len()];
        truth[20 + seed as usize][seed as usize % 7] += 12.0 * U[seed as usize % 7];
        truth
    };
    type Truth<'a> = &'a (dyn Fn(u64) -> Vec<Channels> + Sync);
    let cases: [(&str, Truth<'_>); 3] =
        [("an error that starts late", &late), ("a random walk that is not stated", &walk), ("one bad value", &bad)];
    for (name, truth) in cases {
        let verdicts: Vec<(bool, String)> = (0..count)
            .into_par_iter()
            .map(|seed| {
                let found =
                    diagnose(&mission, &measured(&times, &truth(seed), 31 * seed, true), &Settings::default()).unwrap();
                let named = names(&found).join(" + ");
                // an error that starts late is a step of its source: that name is right, any constant one is not
                let source = ["gyro_bias_y", "accelerometer_bias_x", "gyro_bias_z"][seed as usize % 3];
                let step = name == "an error that starts late" && named.starts_with(&format!("{source}:step("));
                // row 20 + seed of the rows from 0 is reading 21 + seed
                let value = name == "one bad value" && named == format!("reading:{}", 21 + seed);
                let walk = name == "a random walk that is not stated" && named == "angle_random_walk";
                let right =
                    found.verdict == Verdict::Unexplained || ((step || value || walk) && found.findings.len() == 1);
                (right, found.unexplained.map_or(named, |u| u.pattern))
            })
            .collect();
        let right = verdicts.iter().filter(|(right, _)| *right).count();
        println!("{name}: unexplained, or what it is, in {right} of {count}; for example: {}", verdicts[0].1);
        verdicts.iter().filter(|(right, _)| !right).for_each(|(_, text)| println!("  named: {text}"));
        assert!(right as f64 >= (0.95 * count as f64).floor(), "{name}");
    }
}

/// Large errors, which are not linear in the navigator: a bias of 1 deg/h and a tilted start, found to their uncertainties.
#[test]
fn large_errors_are_refitted_on_the_full_simulation() {
    let mission = mission(swing());
    let times = times(&mission);
    let hidden = [("gyro_bias_y", 0.3), ("start_attitude_up", 600.0)];
    let mut errors = ImuErrors::default();
    for (id, value) in hidden {
        let source = ErrorSource::named(id).unwrap();
        source.set(&mut errors, value * source.si_per_unit());
    }
    let truth = predicted(&mission, &mission.motion, &errors, &times);
    let found = diagnose(&mission, &measured(&times, &truth, 5, true), &Settings::default()).unwrap();
    println!(
        "{:?} after {} refits; chi-square {:.0} of {}",
        names(&found),
        found.refits.0,
        found.gap[1].chi_square,
        found.gap[1].dof
    );
    for (id, value) in hidden {
        let finding = found.findings.iter().find(|f| f.source.id() == id).unwrap_or_else(|| panic!("{id}"));
        let unit = finding.source.si_per_unit();
        println!(
            "  {id}: {:.6} of {value}, u {:.6}, t {:.0}",
            finding.value / unit,
            finding.u.unwrap() / unit,
            finding.t
        );
        assert!((finding.value - value * unit).abs() < 4.0 * finding.u.unwrap());
    }
    assert!(found.refits.1 && found.gap[1].p.unwrap() > 0.01);
}

/// The gap is told after each of three biases: it begins as given, never grows, and ends as the diagnosis does; the first step takes off more than
/// either of the others alone could, as a flight with that one alone says.
#[test]
fn the_gap_shrinks_step_by_step() {
    let mission = mission(at_rest());
    let times = times(&mission);
    let hidden = [("gyro_bias_x", 0.02), ("gyro_bias_z", 0.03), ("accelerometer_bias_y", 300e-6)];
    let with = |some: &[(&str, f64)]| {
        let mut errors = ImuErrors::default();
        for (id, value) in some {
            let source = ErrorSource::named(id).unwrap();
            source.set(&mut errors, value * source.si_per_unit());
        }
        predicted(&mission, &mission.motion, &errors, &times)
    };
    let measured = measured(&times, &with(&hidden), 23, true);
    let found = diagnose(&mission, &measured, &Settings::default()).unwrap();
    println!("{:?} {:?}", found.verdict, names(&found));
    let steps = &found.gap_steps;
    for step in steps {
        println!("{:?}: chi-square {:.1} of {}", step.with, step.gap.chi_square, step.gap.dof);
    }
    assert_eq!((found.findings.len(), steps.len()), (3, 4));
    assert!(steps.iter().enumerate().all(|(k, step)| step.with.len() == k && step.left_out == 0));
    assert_eq!([&steps[0].gap, &steps[3].gap], [&found.gap[0], &found.gap[1]]);
    assert!(steps.windows(2).all(|two| two[1].gap.chi_square < two[0].gap.chi_square));
    // by a grid of sizes of one bias flown alone: no other explains as much as the first does
    let cells: Vec<_> = measured.cells().collect();
    let chi_square = |truth: &[Channels]| -> f64 {
        cells.iter().map(|c| ((c.value - truth[c.row][c.channel]) / U[c.channel]).powi(2)).sum()
    };
    for (id, value) in hidden {
        let alone =
            (-40..=80).map(|k| chi_square(&with(&[(id, value * f64::from(k) / 20.0)]))).fold(f64::INFINITY, f64::min);
        println!("{id} alone: {alone:.1}");
        assert!(steps[1].gap.chi_square <= alone * (1.0 + 1e-9));
        if steps[1].with == [id] {
            // on the grid to its step
            assert!(alone < steps[1].gap.chi_square * 1.02 + 10.0);
        }
    }
}

/// The motion that is named first really tells: with a run of it beside the first, the error has no aliases left that it is said to tell.
#[test]
fn a_motion_that_is_named_tells() {
    for id in ["gyro_scale_factor_z", "gyro_installation_yz", "accelerometer_installation_xz"] {
        let mission = mission(at_rest());
        let times = times(&mission);
        let source = ErrorSource::named(id).unwrap();
        let j = ErrorSource::catalogue().iter().position(|s| *s == source).unwrap();
        let errors = ImuErrors::single(source, size(&mission, j, &times, 400.0).unwrap());
        let truth = predicted(&mission, &mission.motion, &errors, &times);
        let mut data = measured(&times, &truth, 1, true);
        let found = diagnose(&mission, &data, &Settings::default()).unwrap();
        let first = &found.findings[0];
        let separation = first.separate_by.first().unwrap_or_else(|| panic!("{id}: no motion"));
        let words = crate::wire::MotionFile::of(&separation.motion).in_words();
        println!(
            "{id}: named {} with {} aliases; {words} tells {} of them by {:.0}",
            first.source.id(),
            first.aliases.len(),
            separation.tells.len(),
            separation.by
        );
        let both = mission.clone().beside(separation.motion.clone()).unwrap();
        let truth = predicted(&both, &separation.motion, &errors, &times);
        for row in &measured(&times, &truth, 2, true).runs[0].rows {
            data.push(1, *row);
        }
        let found = diagnose(&both, &data, &Settings::default()).unwrap();
        println!("  with a run of it: {:?}, {} aliases", names(&found), found.findings[0].aliases.len());
        assert_eq!(found.findings.len(), 1);
        let after = &found.findings[0];
        assert!(after.source == source || after.aliases.iter().any(|a| a.source == source));
        assert!(after.aliases.len() < first.aliases.len());
    }
}

/// Without stated uncertainties the noise comes from what is left of each channel; single channels may be missing.
#[test]
fn noise_from_residuals_and_channels_left_out() {
    let mission = mission(at_rest());
    let times = times(&mission);
    let source = ErrorSource::named("accelerometer_bias_y").unwrap();
    let truth = predicted(&mission, &mission.motion, &ImuErrors::single(source, 1e-3), &times);
    let data = measured(&times, &truth, 3, false);
    let found = diagnose(&mission, &data, &Settings::default()).unwrap();
    assert_eq!((found.noise, names(&found)), (NoiseFrom::Residuals, vec![source.id()]));
    for channel in &found.channels {
        let k = CHANNEL_NAMES.iter().position(|name| *name == channel.column).unwrap();
        // from some 220 values: good to 5 %, so three times that
        assert!((channel.u * si_per_unit(k) / U[k] - 1.0).abs() < 0.15, "{} {}", channel.column, channel.u);
    }
    assert!((found.findings[0].value / 1e-3 - 1.0).abs() < 1e-3);
    // with velocity and position alone a tilt at the start does what an accelerometer bias does, until the Earth has turned
    let mission = Mission::new(site(), 0.05, 0.5 * HOUR, 60.0, Motion::default()).unwrap();
    let times: Vec<f64> = (0..=30).map(|k| 60.0 * f64::from(k)).collect();
    let errors = ImuErrors::single(source, 1e-4);
    let truth = predicted(&mission, &mission.motion, &errors, &times);
    for (name, attitude) in [("with attitude", true), ("without attitude", false)] {
        let mut data = measured(&times, &truth, 4, true);
        data.runs[0]
            .rows
            .iter_mut()
            .for_each(|row| row.value[..3].iter_mut().for_each(|v| *v = v.filter(|_| attitude)));
        let found = diagnose(&mission, &data, &Settings::default()).unwrap();
        let finding = &found.findings[0];
        let all: Vec<ErrorSource> =
            finding.aliases.iter().map(|a| a.source).chain([finding.source]).filter_map(|c| c.constant()).collect();
        let ids: Vec<String> = all.iter().map(ErrorSource::id).collect();
        let told = finding.separate_by.first().map(|s| crate::wire::MotionFile::of(&s.motion).in_words());
        println!("{name}: one of {ids:?}; would tell: {}", told.unwrap_or_default());
        assert!(found.findings.len() == 1 && all.contains(&source));
        assert_eq!(ids.contains(&"start_attitude_east".to_string()), !attitude);
    }
}
