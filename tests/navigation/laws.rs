//! What the diagnosis of measured navigation errors promises, as seeded experiments that print their table.
//!
//! Few trials in the suite; the full count by `TUMBLE_LONG=1 cargo test --release --test navigation laws -- --nocapture`, with other seeds by
//! `TUMBLE_SEED=n`. Data are flown by the full navigator; what changes in time is flown in pieces of its own, not by the columns of the search.
use crate::diagnosis::Verdict;
use crate::draws::long;
use crate::navigate::diagnose::{NavigationDiagnosis, diagnose};
use crate::navigate::errors::{ErrorSource, ImuErrors};
use crate::navigate::linear;
use crate::navigate::measured::{Channels, Measured, MeasuredRow, channels};
use crate::navigate::mission::{Mission, Site};
use crate::navigate::motion::{Attitude, Leg, Legs, Motion, Oscillation};
use crate::navigate::run::{self, Continue, Scenario};
use crate::navigate::settings::Settings;
use crate::navigate::signatures;
use rand_distr::{Distribution, StandardNormal, StandardUniform};
use rand_pcg::Pcg64Mcg;
use rand_pcg::rand_core::SeedableRng;
use rayon::prelude::*;

/// A kind of fault: its name, how a finding says it, and its size over the share of the run.
type Kind = (&'static str, &'static str, fn(f64) -> f64);

const HOUR: f64 = 3600.0;
const ARCSEC: f64 = std::f64::consts::PI / (180.0 * 3600.0);
/// Standard uncertainties of the channels, SI: 2 arcsec, 0.01 m/s, 5 m.
pub const U: Channels = [2.0 * ARCSEC, 2.0 * ARCSEC, 2.0 * ARCSEC, 0.01, 0.01, 5.0, 5.0];

/// So many trials, or `full` in a long run, or as many as `TUMBLE_TRIALS` says.
pub fn trials(few: u64, full: u64) -> u64 {
    let asked = std::env::var("TUMBLE_TRIALS").ok().and_then(|text| text.parse().ok());
    asked.unwrap_or(if long() { full } else { few })
}

pub fn seed(own: u64) -> Pcg64Mcg {
    let base: u64 = std::env::var("TUMBLE_SEED").ok().and_then(|text| text.parse().ok()).unwrap_or(0);
    Pcg64Mcg::seed_from_u64(1_000_003 * base + own)
}

pub fn uniform(random: &mut Pcg64Mcg) -> f64 {
    StandardUniform.sample(random)
}

pub fn at_rest() -> Motion {
    Motion::at_rest(0.0, 0.0, -60f64.to_radians())
}

pub fn swing() -> Motion {
    let angle = |mean: f64, amplitude: f64, period: f64, phase: f64| Oscillation {
        mean: mean.to_radians(),
        amplitude: amplitude.to_radians(),
        period,
        phase: phase.to_radians(),
    };
    let yaw = angle(-60.0, 5.0, 10.0, 45.0);
    Motion::swing(Attitude { pitch: angle(0.0, 7.0, 6.0, 0.0), roll: angle(0.0, 10.0, 8.0, 0.0), yaw }).unwrap()
}

/// Half an hour at rest, up to 20 m/s, an hour ahead, a right turn, and on.
fn legs() -> Motion {
    let leg = |duration: f64, acceleration: f64, turn: f64| Leg { duration, acceleration, turn: turn.to_radians() };
    let legs = vec![
        leg(2000.0, 0.0, 0.0),
        leg(200.0, 0.1, 0.0),
        leg(3000.0, 0.0, 0.0),
        leg(100.0, 0.0, 0.9),
        leg(f64::INFINITY, 0.0, 0.0),
    ];
    Motion::legs(Legs { heading: 60f64.to_radians(), speed: 0.0, legs })
}

pub fn mission(motion: Motion) -> Mission {
    let site = Site { latitude_rad: 45.7796f64.to_radians(), longitude_rad: 126.6705f64.to_radians(), altitude_m: 0.0 };
    let swings = motion.shortest_period().is_finite();
    let (step, hours) = (if swings { 0.1 } else { 0.5 }, if long() { 6.0 } else { 4.0 });
    Mission::new(site, step, hours * HOUR, 60.0, motion).unwrap()
}

pub fn times(mission: &Mission) -> Vec<f64> {
    (0..).map(|k| 97.3 * f64::from(k)).take_while(|t| *t <= mission.duration()).collect()
}

/// Normal noise of standard uncertainty `U` on a truth.
pub fn measured(times: &[f64], truth: &[Channels], random: &mut Pcg64Mcg) -> Measured {
    let mut measured = Measured::default();
    for (time, truth) in times.iter().zip(truth) {
        let mut value = [None; 7];
        for ((slot, z), u) in value.iter_mut().zip(truth).zip(U) {
            let unit: f64 = StandardNormal.sample(random);
            *slot = Some(z + u * unit);
        }
        measured.push(0, MeasuredRow { time: *time, value, u: U.map(Some) });
    }
    measured
}

/// The full simulation of one motion without noise, at some times in rising order.
pub fn predicted(mission: &Mission, motion: &Motion, errors: &ImuErrors, times: &[f64]) -> Vec<Channels> {
    signatures::predicted_together(mission, motion, std::slice::from_ref(errors), times).swap_remove(0)
}

pub fn flown(mission: &Mission, errors: &ImuErrors, times: &[f64]) -> Vec<Channels> {
    predicted(mission, &mission.motion, errors, times)
}

/// A bias that follows a function of time, by steps of 20 s, or of a 500th of a short mission: the response to each piece is a difference of two responses that start then.
/// (The linear equations of the navigator, integrated with the drive of that time; nothing of the search's own columns.)
pub fn changing(mission: &Mission, source: &ErrorSource, times: &[f64], f: &dyn Fn(f64) -> f64) -> Vec<Channels> {
    let j = ErrorSource::catalogue().iter().position(|own| own == source).unwrap();
    let first = ErrorSource::all().len();
    let piece = f64::min(20.0, mission.duration() / 500.0);
    let mut mission = mission.clone();
    mission.steps_per_row = 2 * (0.5 * piece / mission.step_s).max(1.0) as u64;
    let piece = mission.steps_per_row as f64 * mission.step_s;
    // what a unit bias adds in each piece: S(t) - Psi(t) Psi(s)^-1 S(s), summed up state by state
    let (mut rows, mut state) = (Vec::new(), nalgebra::SVector::<f64, 7>::zeros());
    let mut before: Option<(nalgebra::SMatrix<f64, 7, 7>, nalgebra::SVector<f64, 7>)> = None;
    linear::propagate(&mission, &mission.motion, &mut |own| {
        let channel = |k: usize| nalgebra::SVector::<f64, 7>::from(channels(&own.error(&own.states[k])));
        let size = nalgebra::SVector::<f64, 7>::from([1.0, 1.0, 1.0, 7.9e3, 7.9e3, 6.4e6, 6.4e6]);
        let psi = nalgebra::SMatrix::<f64, 7, 7>::from_fn(|i, k| channel(first + k)[i] * size[k] / size[i]);
        let s = channel(j).component_div(&size);
        if let Some((old, last)) = before {
            let across = psi * old.try_inverse().unwrap();
            state = across * state + (s - across * last) * f(own.time - 0.5 * piece);
        }
        before = Some((psi, s));
        let now: [f64; 7] = state.component_mul(&size).into();
        rows.push((own.time, now));
        Continue::Yes
    });
    let between = |time: f64| -> Channels {
        let after = rows.partition_point(|row| row.0 < time).clamp(1, rows.len() - 1);
        let ((a, x), (b, y)) = (rows[after - 1], rows[after]);
        let share = (time - a) / (b - a);
        std::array::from_fn(|i| x[i] + share * (y[i] - x[i]))
    };
    times.iter().map(|time| between(*time)).collect()
}

pub fn names(found: &NavigationDiagnosis) -> Vec<String> {
    let mut names: Vec<String> = found.findings.iter().map(|f| f.source.id()).collect();
    names.sort();
    names
}

/// Is a finding, or one of its aliases, of this name (without the time in brackets)?
fn is_named(found: &NavigationDiagnosis, id: &str) -> bool {
    let plain = |id: String| id.split('(').next().unwrap_or_default().to_string();
    let finding = |f: &crate::navigate::diagnose::Finding| {
        plain(f.source.id()) == id || f.aliases.iter().any(|a| plain(a.source.id()) == id)
    };
    found.findings.len() == 1 && found.findings.iter().any(finding)
}

/// Is every one of these a finding of its own, or among the aliases of one?
fn are_named(found: &NavigationDiagnosis, expected: &[String]) -> bool {
    let holds = |id: &String| {
        found.findings.iter().any(|f| f.source.id() == *id || f.aliases.iter().any(|a| a.source.id() == *id))
    };
    found.findings.len() == expected.len() && expected.iter().all(holds)
}

fn table(law: &str, name: &str, outcomes: &[(bool, String)], least: f64) {
    let right = outcomes.iter().filter(|(right, _)| *right).count();
    println!("{law:34} {name:28} {right:4} of {}", outcomes.len());
    outcomes.iter().filter(|(right, _)| !right).take(6).for_each(|(_, text)| println!("      {text}"));
    // the share with three standard deviations of so few trials
    let n = outcomes.len() as f64;
    let slack = 3.0 * (least * (1.0 - least) / n).sqrt();
    assert!(right as f64 / n >= least - slack, "{law}, {name}: {right} of {n}");
}

/// Three gyro and two accelerometer biases (that of the vertical one does nothing where the vertical channel is held), at any size.
#[test]
fn laws_five_biases_are_named() {
    let sizes: [(&str, [f64; 2], [f64; 2]); 4] = [
        ("0.001 deg/h, 10 ug", [1e-3, 1e-3], [1e-5, 1e-5]),
        ("0.03 deg/h, 300 ug", [0.03, 0.03], [3e-4, 3e-4]),
        ("2 deg/h, 10 mg", [2.0, 2.0], [1e-2, 1e-2]),
        ("any of these", [1e-3, 2.0], [1e-5, 1e-2]),
    ];
    for (motion, make) in [("static", at_rest as fn() -> Motion), ("swing", swing), ("legs", legs)] {
        let mission = mission(make());
        let times = times(&mission);
        for (name, gyro, accelerometer) in sizes {
            let outcomes: Vec<(bool, bool, String)> = (0..trials(1, 40))
                .into_par_iter()
                .map(|trial| {
                    let mut random = seed(trial);
                    let mut errors = ImuErrors::default();
                    let mut expected = Vec::new();
                    for id in
                        ["gyro_bias_x", "gyro_bias_y", "gyro_bias_z", "accelerometer_bias_x", "accelerometer_bias_y"]
                    {
                        let [least, most] = if id.starts_with('g') { gyro } else { accelerometer };
                        let size = least * (most / least).powf(uniform(&mut random));
                        let sign = if uniform(&mut random) < 0.5 { -1.0 } else { 1.0 };
                        let source = ErrorSource::named(id).unwrap();
                        source.set(&mut errors, sign * size * source.si_per_unit());
                        expected.push(id.to_string());
                    }
                    expected.sort();
                    let data = measured(&times, &flown(&mission, &errors, &times), &mut random);
                    let found = diagnose(&mission, &data, &Settings::default()).unwrap();
                    let text = format!("{} {:?}", found.verdict.name(), names(&found));
                    (names(&found) == expected, are_named(&found, &expected), text)
                })
                .collect();
            let first = outcomes.iter().filter(|own| own.0).count();
            println!("five biases, {motion}, {name}: {first} of {} named first, not among aliases", outcomes.len());
            let outcomes: Vec<(bool, String)> = outcomes.into_iter().map(|(_, right, text)| (right, text)).collect();
            table(&format!("five biases, {motion}"), name, &outcomes, 0.95);
        }
    }
}

/// One bias, and one value of 40 u: both are named.
#[test]
fn laws_an_outlier_does_not_stop_the_search() {
    let mission = mission(at_rest());
    let times = times(&mission);
    for (name, wrong) in [("one value of 40 u", 1), ("5 % of rows", times.len() / 20)] {
        let outcomes: Vec<(bool, String)> = (0..trials(3, 100))
            .into_par_iter()
            .map(|trial| {
                let mut random = seed(100 + trial);
                let ids = ["gyro_bias_x", "gyro_bias_y", "gyro_bias_z", "accelerometer_bias_x", "accelerometer_bias_y"];
                let id = ids[trial as usize % 5];
                let source = ErrorSource::named(id).unwrap();
                let size = if id.starts_with('g') { 1e-3 } else { 1e-5 } * 1000f64.powf(uniform(&mut random));
                let errors = ImuErrors::single(source, size * source.si_per_unit());
                let mut data = measured(&times, &flown(&mission, &errors, &times), &mut random);
                let mut expected = vec![id.to_string()];
                let rows = data.runs[0].rows.len();
                for _ in 0..wrong {
                    let (row, channel) =
                        ((uniform(&mut random) * rows as f64) as usize, (uniform(&mut random) * 7.0) as usize);
                    let own = format!("reading:{}", row + 1);
                    if !expected.contains(&own) {
                        let slot = &mut data.runs[0].rows[row].value[channel];
                        *slot = slot.map(|value| value + 40.0 * U[channel]);
                        expected.push(own);
                    }
                }
                expected.sort();
                let found = diagnose(&mission, &data, &Settings::default()).unwrap();
                (names(&found) == expected, format!("{} {:?} for {expected:?}", found.verdict.name(), names(&found)))
            })
            .collect();
        table("one bias and wrong values", name, &outcomes, 0.95);
    }
}

/// Faults of the reference are called faults of the reference, or nothing is named.
#[test]
fn laws_faults_of_the_reference() {
    let mission = mission(at_rest());
    let times = times(&mission);
    let columns = crate::navigate::measured::CHANNEL_NAMES;
    let kinds: [Kind; 3] = [
        ("drift", ":ramp", |share| share),
        ("offset", "", |_| 1.0),
        ("step", ":step", |share| f64::from(u8::from(share > 0.43))),
    ];
    for (name, suffix, f) in kinds {
        let outcomes: Vec<(bool, String)> = (0..trials(4, 140))
            .into_par_iter()
            .map(|trial| {
                let mut random = seed(200 + trial);
                let channel = (2 * trial) as usize % 7;
                let size = 10.0 * 30f64.powf(uniform(&mut random));
                let truth: Vec<Channels> = times
                    .iter()
                    .map(|time| {
                        let share = time / mission.duration();
                        std::array::from_fn(|c| if c == channel { size * U[c] * f(share) } else { 0.0 })
                    })
                    .collect();
                let data = measured(&times, &truth, &mut random);
                let found = diagnose(&mission, &data, &Settings::default()).unwrap();
                let id = format!("reference:{}{suffix}", columns[channel]);
                let right = found.verdict == Verdict::Unexplained || is_named(&found, &id);
                (right, format!("{} {:?} for {id}, {size:.0} u", found.verdict.name(), names(&found)))
            })
            .collect();
        table("faults of the reference", name, &outcomes, 0.95);
    }
}

/// Biases that change in time are named as such.
#[test]
fn laws_errors_that_change_in_time() {
    let mission = mission(at_rest());
    let times = times(&mission);
    let kinds: [Kind; 3] = [
        ("ramp", ":ramp", |share| share),
        ("step", ":step", |share| f64::from(u8::from(share > 0.37))),
        ("warm-up", ":warm-up", |share| (-share / 0.08).exp()),
    ];
    for (name, suffix, f) in kinds {
        let outcomes: Vec<(bool, String)> = (0..trials(3, 100))
            .into_par_iter()
            .map(|trial| {
                let mut random = seed(300 + trial);
                let ids = ["gyro_bias_x", "gyro_bias_y", "gyro_bias_z", "accelerometer_bias_x", "accelerometer_bias_y"];
                let id = ids[2 * trial as usize % 5];
                let source = ErrorSource::named(id).unwrap();
                let size = if id.starts_with('g') { 0.01 } else { 3e-4 } * source.si_per_unit();
                let duration = mission.duration();
                let unit = changing(&mission, &source, &times, &|time| f(time / duration));
                let truth: Vec<Channels> = unit.iter().map(|z| z.map(|v| size * v)).collect();
                let data = measured(&times, &truth, &mut random);
                let found = diagnose(&mission, &data, &Settings::default()).unwrap();
                let id = format!("{id}{suffix}");
                (is_named(&found, &id), format!("{} {:?} for {id}", found.verdict.name(), names(&found)))
            })
            .collect();
        table("errors that change in time", name, &outcomes, 0.9);
    }
}

/// Where nothing is wrong nothing is named.
#[test]
fn laws_nothing_is_named_where_nothing_is_wrong() {
    let mission = mission(at_rest());
    let times = times(&mission);
    let outcomes: Vec<(bool, String)> = (0..trials(8, 400))
        .into_par_iter()
        .map(|trial| {
            let mut random = seed(400 + trial);
            let data = measured(&times, &vec![[0.0; 7]; times.len()], &mut random);
            let found = diagnose(&mission, &data, &Settings::default()).unwrap();
            (found.verdict == Verdict::NothingMissing, format!("{} {:?}", found.verdict.name(), names(&found)))
        })
        .collect();
    table("nothing is wrong", "", &outcomes, 0.99);
}

/// A random walk that the mission does not state is named, with its density, alone and beside a bias; flown with noise by the full navigator. The last row is of walks
/// three times as large in rows of 20 s, of which a search takes fewer: means of such rows are not what a walk was at any time.
#[test]
fn laws_random_walks_are_named() {
    let mission = mission(at_rest());
    let units = [1f64.to_radians() / 60.0, 1.0 / 60.0];
    let kinds = [("angle_random_walk", [0.003, 0.0]), ("velocity_random_walk", [0.0, 0.02])];
    for (name, densities) in kinds {
        for (what, biased, steps_per_row, larger) in
            [("alone", false, 194, 0.0), ("beside a bias", true, 194, 0.0), ("large, of many rows", false, 40, 0.5)]
        {
            let outcomes: Vec<(bool, String)> = (0..trials(3, 40))
                .into_par_iter()
                .map(|trial| {
                    let mut random = seed(500 + trial);
                    let mut own = mission.clone();
                    (own.seed, own.steps_per_row) = (77 + trial + u64::from(biased), steps_per_row);
                    let factor = 10f64.powf(uniform(&mut random) - 0.5 + larger);
                    own.errors.gyro.random_walk = factor * densities[0] * units[0];
                    own.errors.accelerometer.random_walk = factor * densities[1] * units[1];
                    let mut expected = vec![name.to_string()];
                    if biased {
                        let source = ErrorSource::named("gyro_bias_z").unwrap();
                        source.set(&mut own.errors, 0.5 * source.si_per_unit());
                        expected.push(source.id());
                    }
                    expected.sort();
                    let scenario = Scenario { id: "walk".into(), errors: own.errors };
                    let (mut at, mut truth) = (Vec::new(), Vec::new());
                    run::fly(&own, &own.motion, &[scenario], &mut |row| {
                        at.push(row.truth.time);
                        truth.push(channels(&row.errors[0]));
                        Continue::Yes
                    });
                    let found = diagnose(&mission, &measured(&at, &truth, &mut random), &Settings::default()).unwrap();
                    let walk = found.findings.iter().find(|own| own.source.id() == name);
                    let hidden = own.errors.gyro.random_walk + own.errors.accelerometer.random_walk;
                    let near = walk.is_some_and(|own| (own.value - hidden).abs() < 4.0 * own.u.unwrap());
                    let text = format!("{} {:?} for {expected:?}, {factor:.2}", found.verdict.name(), names(&found));
                    (near && are_named(&found, &expected), text)
                })
                .collect();
            table(name, what, &outcomes, 0.9);
        }
    }
}

/// A bias that walks at random is named: of one axis or of each, gyros or accelerometers, alone and beside a constant one. Its steps of a minute are
/// drawn here and carried into the navigator by the linear equations.
#[test]
fn laws_walks_of_biases_are_named() {
    let mission = mission(at_rest());
    let times = times(&mission);
    // deg/h and g after an hour
    let kinds =
        [("rate_random_walk", "gyro_bias", 0.03, 3), ("acceleration_random_walk", "accelerometer_bias", 3e-4, 2)];
    for (name, group, size, axes) in kinds {
        for (what, several, biased) in
            [("one axis", false, false), ("each axis", true, false), ("beside a bias", true, true)]
        {
            let outcomes: Vec<(bool, String)> = (0..trials(1, 40))
                .into_par_iter()
                .map(|trial| {
                    let mut random = seed(800 + 7 * trial + u64::from(several) + u64::from(biased));
                    // beside a walk of the same axis that is not small, nothing shows a constant
                    let factor = 10f64.powf(uniform(&mut random) - 0.5) * if biased { 0.2 } else { 1.0 };
                    let mut truth = vec![[0.0; 7]; times.len()];
                    let one = trial as usize % axes;
                    for (axis, letter) in ["x", "y", "z"].iter().enumerate().take(axes) {
                        if !several && axis != one {
                            continue;
                        }
                        let source = ErrorSource::named(&format!("{group}_{letter}")).unwrap();
                        let minutes = (mission.duration() / 60.0) as usize + 2;
                        let mut value = 0.0;
                        let walk: Vec<f64> = (0..minutes)
                            .map(|_| {
                                let unit: f64 = StandardNormal.sample(&mut random);
                                value += factor * size * (1.0 / 60_f64).sqrt() * unit;
                                value * source.si_per_unit()
                            })
                            .collect();
                        let at = |time: f64| walk[((time / 60.0) as usize).min(minutes - 1)];
                        let own = changing(&mission, &source, &times, &at);
                        truth.iter_mut().zip(own).for_each(|(z, own)| z.iter_mut().zip(own).for_each(|(z, v)| *z += v));
                    }
                    let mut expected = Vec::new();
                    if biased {
                        let source = ErrorSource::named("gyro_bias_z").unwrap();
                        // small: a large bias turns the frame in which the walk goes on, and the two would not add up
                        let errors = ImuErrors::single(source, 0.02 * source.si_per_unit());
                        let own = flown(&mission, &errors, &times);
                        truth.iter_mut().zip(own).for_each(|(z, own)| z.iter_mut().zip(own).for_each(|(z, v)| *z += v));
                        expected.push("gyro_bias_z".to_string());
                    }
                    let found =
                        diagnose(&mission, &measured(&times, &truth, &mut random), &Settings::default()).unwrap();
                    let is_walk = |id: &str| id.starts_with(name);
                    let walk = found.findings.iter().find(|own| {
                        is_walk(&own.source.id()) || own.aliases.iter().any(|alias| is_walk(&alias.source.id()))
                    });
                    let is = walk.is_some_and(|own| is_walk(&own.source.id()));
                    let unit = walk.map_or(1.0, |own| own.source.si_per_unit());
                    // the axes walk alike
                    let near = walk.is_some_and(|own| {
                        !is || (own.value / unit - factor * size).abs()
                            < 4.0 * own.u.unwrap() / unit + 0.5 * factor * size
                    });
                    let rest = |own: &&crate::navigate::diagnose::Finding| !walk.is_some_and(|walk| walk == *own);
                    let others: Vec<String> = found.findings.iter().filter(rest).map(|own| own.source.id()).collect();
                    let value = walk.map_or(0.0, |own| own.value / unit);
                    let text =
                        format!("{} {:?} {value:.2e} for {:.2e}", found.verdict.name(), names(&found), factor * size);
                    (near && others == expected, text)
                })
                .collect();
            table(name, what, &outcomes, 0.9);
        }
    }
}

/// One bias of any size up to 2 deg/h and 10 mg, and three of them.
#[test]
fn laws_one_and_three_biases_are_named() {
    let ids = ["gyro_bias_x", "gyro_bias_y", "gyro_bias_z", "accelerometer_bias_x", "accelerometer_bias_y"];
    for (motion, make) in [("static", at_rest as fn() -> Motion), ("swing", swing), ("legs", legs)] {
        let mission = mission(make());
        let times = times(&mission);
        for (name, count, large) in [("one large", 1, true), ("three of any size", 3, false)] {
            let outcomes: Vec<(bool, String)> = (0..trials(1, 40))
                .into_par_iter()
                .map(|trial| {
                    let mut random = seed(900 + 3 * trial + count);
                    let mut errors = ImuErrors::default();
                    let mut expected: Vec<String> = Vec::new();
                    while expected.len() < count as usize {
                        let id = ids[(uniform(&mut random) * if large { 3.0 } else { 5.0 }) as usize];
                        if expected.iter().any(|own| own == id) {
                            continue;
                        }
                        let (least, factor) = if id.starts_with('g') { (1e-3, 2000_f64) } else { (1e-5, 1000.0) };
                        let size = if large { 2.0 } else { least * factor.powf(uniform(&mut random)) };
                        let sign = if uniform(&mut random) < 0.5 { -1.0 } else { 1.0 };
                        let source = ErrorSource::named(id).unwrap();
                        source.set(&mut errors, sign * size * source.si_per_unit());
                        expected.push(id.to_string());
                    }
                    let data = measured(&times, &flown(&mission, &errors, &times), &mut random);
                    let found = diagnose(&mission, &data, &Settings::default()).unwrap();
                    let text = format!("{} {:?} for {expected:?}", found.verdict.name(), names(&found));
                    (are_named(&found, &expected), text)
                })
                .collect();
            table(&format!("biases, {motion}"), name, &outcomes, 0.95);
        }
    }
}

/// A mission of ten minutes to an hour, at rest in any attitude or with turns and accelerations at any time, and rows at any times.
fn short_mission(random: &mut Pcg64Mcg) -> (Mission, Vec<f64>) {
    let duration = (600.0 * 6f64.powf(uniform(random)) / 20.0).round() * 20.0;
    let heading = (360.0 * uniform(random) - 180.0).to_radians();
    let motion = if uniform(random) < 0.5 {
        let tilt = |random: &mut Pcg64Mcg| (60.0 * uniform(random) - 30.0).to_radians();
        Motion::at_rest(tilt(random), tilt(random), heading)
    } else {
        let leg = |duration: f64, acceleration: f64, turn: f64| Leg { duration, acceleration, turn: turn.to_radians() };
        let first = (0.4 * duration * uniform(random) / 10.0).ceil() * 10.0;
        let turn = 6.0 * uniform(random) - 3.0;
        let legs = vec![
            leg(first, 0.0, 0.0),
            leg(20.0, 0.1 + 0.4 * uniform(random), 0.0),
            leg(first, 0.0, 0.0),
            leg(60.0, 0.0, turn),
            leg(f64::INFINITY, 0.0, 0.0),
        ];
        Motion::legs(Legs { heading, speed: 0.0, legs })
    };
    let site =
        Site { latitude_rad: (120.0 * uniform(random) - 60.0).to_radians(), longitude_rad: 0.3, altitude_m: 0.0 };
    let mission = Mission::new(site, 0.5, duration, 60.0, motion).unwrap();
    let mut times: Vec<f64> =
        (0..25 + (250.0 * uniform(random)) as usize).map(|_| (duration * uniform(random)).round()).collect();
    times.sort_by(f64::total_cmp);
    times.dedup();
    (mission, times)
}

/// In short missions a bias that goes up and down is named as what it is, or as unexplained, and in most as what it is.
#[test]
fn laws_waves_in_short_missions() {
    let outcomes: Vec<(bool, bool, String)> = (0..trials(16, 200))
        .into_par_iter()
        .map(|trial| {
            let mut random = seed(900 + trial);
            let (mission, times) = short_mission(&mut random);
            let ids = ["gyro_bias_x", "gyro_bias_y", "gyro_bias_z", "accelerometer_bias_x", "accelerometer_bias_y"];
            let id = ids[(5.0 * uniform(&mut random)) as usize];
            let source = ErrorSource::named(id).unwrap();
            let period = mission.duration() / (1.0 + 7.0 * uniform(&mut random));
            let phase = std::f64::consts::TAU * uniform(&mut random);
            let wave = |time: f64| (std::f64::consts::TAU * time / period + phase).sin();
            let unit = changing(&mission, &source, &times, &wave);
            let square: f64 = unit.iter().flat_map(|z| z.iter().zip(U).map(|(v, u)| (v / u) * (v / u))).sum();
            let size = 3.0 * 20f64.powf(uniform(&mut random)) / (square / (7 * times.len()) as f64).sqrt();
            let truth: Vec<Channels> = unit.iter().map(|z| z.map(|v| size * v)).collect();
            let data = measured(&times, &truth, &mut random);
            let found = diagnose(&mission, &data, &Settings::default()).unwrap();
            let named = is_named(&found, &format!("{id}:wave"));
            let text = format!("{} {:?} for {id}:wave({period:.0}), seed {trial}", found.verdict.name(), names(&found));
            (named, named || found.findings.is_empty(), text)
        })
        .collect();
    let of = |which: fn(&(bool, bool, String)) -> bool| -> Vec<(bool, String)> {
        outcomes.iter().map(|own| (which(own), own.2.clone())).collect()
    };
    table("waves in short missions", "named", &of(|own| own.0), 0.8);
    table("waves in short missions", "no wrong name", &of(|own| own.1), 0.97);
}

/// Noise of the reference that goes on from row to row, of the size that is stated, is named as no error of the unit.
#[test]
fn laws_correlated_noise_is_no_error() {
    let outcomes: Vec<(bool, String)> = (0..trials(16, 200))
        .into_par_iter()
        .map(|trial| {
            let mut random = seed(1200 + trial);
            let (mission, times) = short_mission(&mut random);
            let share = 0.5 + 0.4 * uniform(&mut random);
            let mut noise = [0.0; 7];
            let truth: Vec<Channels> = (0..times.len())
                .map(|row| {
                    for (own, u) in noise.iter_mut().zip(U) {
                        let unit: f64 = StandardNormal.sample(&mut random);
                        *own = if row == 0 { u * unit } else { share * *own + (1.0 - share * share).sqrt() * u * unit };
                    }
                    noise
                })
                .collect();
            let mut data = Measured::default();
            for (time, value) in times.iter().zip(truth) {
                data.push(0, MeasuredRow { time: *time, value: value.map(Some), u: U.map(Some) });
            }
            let found = diagnose(&mission, &data, &Settings::default()).unwrap();
            (found.findings.is_empty(), format!("{} {:?}, {share:.2}", found.verdict.name(), names(&found)))
        })
        .collect();
    table("correlated noise", "nothing is named", &outcomes, 0.95);
}
