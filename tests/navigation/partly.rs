//! Navigation errors beside something outside the catalogue: what can be named is named, nothing is named for what has no name. Seeded experiments
//! that print their tables; `TUMBLE_SEED` draws others, `TUMBLE_TRIALS` so many of them.
use crate::diagnosis::Verdict;
use crate::draws::long;
use crate::laws::{U, at_rest, changing, flown, measured, mission, names, seed, swing, times, trials, uniform};
use crate::navigate::cause::Cause;
use crate::navigate::diagnose::{Finding, NavigationDiagnosis, diagnose};
use crate::navigate::errors::{ErrorSource, ImuErrors};
use crate::navigate::measured::{CHANNEL_NAMES, Channels};
use crate::navigate::mission::Mission;
use crate::navigate::motion::Motion;
use crate::navigate::settings::Settings;
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64Mcg;
use rayon::prelude::*;

const BIASES: [&str; 5] = ["gyro_bias_x", "gyro_bias_y", "gyro_bias_z", "accelerometer_bias_x", "accelerometer_bias_y"];

/// Patterns in one or two channels of the reference, or of a bias; with its name what has one: a channel or a bias that goes up and down.
fn outside(mission: &Mission, times: &[f64], kind: u64, random: &mut Pcg64Mcg) -> (Vec<Channels>, Option<String>) {
    let channel = (uniform(random) * 7.0) as usize;
    let other = (channel + 1 + (uniform(random) * 6.0) as usize) % 7;
    let size = 3.0 * 10f64.powf(uniform(random));
    let period = 1000.0 * 10f64.powf(uniform(random));
    let phase = std::f64::consts::TAU * uniform(random);
    let keep = (-97.3 / (600.0 * 6f64.powf(uniform(random)))).exp();
    let mut states = [0.0; 2];
    let wave = move |time: f64| (std::f64::consts::TAU * time / period + phase).sin();
    if kind == 3 {
        let bias = BIASES[(uniform(random) * 5.0) as usize];
        let source = ErrorSource::named(bias).unwrap();
        let truth = changing(mission, &source, times, &wave);
        let squares = |z: &Channels| z.iter().zip(U).map(|(z, u)| (z / u) * (z / u) / 7.0).sum::<f64>();
        let rms = (truth.iter().map(squares).sum::<f64>() / truth.len() as f64).sqrt();
        let truth = truth.iter().map(|z| z.map(|v| v * size / rms)).collect();
        return (truth, Some(format!("{bias}:wave")));
    }
    let normal = |random: &mut Pcg64Mcg| -> f64 { StandardNormal.sample(random) };
    let mut one = |time: f64| -> [f64; 2] {
        match kind {
            0 => [wave(time), 0.0],
            1 => [wave(time).signum(), 0.0],
            2 => {
                let fresh = (1.0 - keep * keep).sqrt();
                states = states.map(|s| keep * s + fresh * normal(random));
                states
            }
            _ => [normal(random), normal(random)],
        }
    };
    let at = |time: &f64| {
        let [a, b] = one(*time);
        std::array::from_fn(|c| match c {
            c if c == channel => size * U[c] * a,
            c if c == other => size * U[c] * b,
            _ => 0.0,
        })
    };
    let name = (kind == 0).then(|| format!("reference:{}:wave", CHANNEL_NAMES[channel]));
    (times.iter().map(at).collect(), name)
}

const KINDS: [&str; 5] = ["wave", "square wave", "correlated noise", "bias that waves", "noise larger than stated"];

/// Standard deviation of an estimate of one error, of a unit column, beside a pattern whose stretches of twelve rows of a channel are independent.
fn spread(column: &[Channels], pattern: &[Channels]) -> f64 {
    let square: f64 = column.iter().flat_map(|z| z.iter().zip(U)).map(|(c, u)| (c / u) * (c / u)).sum();
    let mut between = 0.0;
    for channel in 0..7 {
        for (c, p) in column.chunks(12).zip(pattern.chunks(12)) {
            let sum: f64 = c.iter().zip(p).map(|(c, p)| c[channel] * p[channel] / (U[channel] * U[channel])).sum();
            between += sum * sum;
        }
    }
    (1.0 / square + between / (square * square)).sqrt()
}

/// So many of `n` at a share, less or more three standard deviations of so few trials.
fn at_least(share: f64, n: usize) -> f64 {
    n as f64 * share - 3.0 * (n as f64 * share * (1.0 - share)).sqrt()
}

fn at_most(share: f64, n: usize) -> f64 {
    n as f64 - at_least(1.0 - share, n)
}

/// Is this, but for the times in its brackets, a finding's name or that of one of its aliases?
fn holds(finding: &Finding, hidden: &str) -> bool {
    let is = |cause: &Cause| cause.id().split('(').next() == Some(hidden);
    is(&finding.source) || finding.aliases.iter().any(|alias| is(&alias.source))
}

/// Is there a finding that is none of what is hidden, and does not hold it among its aliases?
fn is_wrong(found: &NavigationDiagnosis, hidden: &[&str]) -> bool {
    found.findings.iter().any(|f| !hidden.iter().any(|id| holds(f, id)))
}

#[test]
fn laws_an_error_is_named_beside_what_has_no_name() {
    let (mut all_stand, mut all_named, mut all_wrong, mut all) = (0, 0, 0, 0);
    let motions: &[(&str, fn() -> Motion)] = &[("static", at_rest), ("swing", swing)];
    for (motion, make) in motions.iter().take(if long() { 2 } else { 1 }) {
        let mission = mission(make());
        let times = times(&mission);
        for (kind, name) in KINDS.iter().enumerate() {
            let outcomes: Vec<(bool, bool, bool, String)> = (0..trials(1, 40))
                .into_par_iter()
                .map(|trial| {
                    let mut random = seed(600 + 10 * trial + kind as u64);
                    let (pattern, pattern_name) = outside(&mission, &times, kind as u64, &mut random);
                    let id = BIASES[trial as usize % 5];
                    let source = ErrorSource::named(id).unwrap();
                    let unit = 1e-3 * source.si_per_unit();
                    let column = flown(&mission, &ImuErrors::single(source, unit), &times);
                    let factor = 4.0 * 25f64.powf(uniform(&mut random));
                    let errors = ImuErrors::single(source, unit * factor * spread(&column, &pattern));
                    let mut truth = flown(&mission, &errors, &times);
                    truth.iter_mut().zip(&pattern).for_each(|(z, p)| z.iter_mut().zip(p).for_each(|(z, p)| *z += p));
                    let found =
                        diagnose(&mission, &measured(&times, &truth, &mut random), &Settings::default()).unwrap();
                    let named = found.findings.iter().any(|f| holds(f, id));
                    let hidden: Vec<&str> = pattern_name.as_deref().into_iter().chain([id]).collect();
                    let wrong = is_wrong(&found, &hidden);
                    let text =
                        format!("{id} at {factor:.0}, {pattern_name:?}: {} {:?}", found.verdict.name(), names(&found));
                    (factor >= 8.0, named, wrong, text)
                })
                .collect();
            let stand = outcomes.iter().filter(|own| own.0).count();
            let named = outcomes.iter().filter(|own| own.0 && own.1).count();
            let wrong = outcomes.iter().filter(|own| own.2).count();
            println!(
                "one bias beside, {motion:6} {name:26} named {named:3} of {stand:3} that stand at 8, wrong names in {wrong} of {}",
                outcomes.len()
            );
            outcomes.iter().filter(|o| o.2 || (o.0 && !o.1)).take(8).for_each(|o| println!("      {}", o.3));
            (all_stand, all_named, all_wrong, all) =
                (all_stand + stand, all_named + named, all_wrong + wrong, all + outcomes.len());
        }
    }
    println!("one bias beside: named {all_named} of {all_stand}, wrong names in {all_wrong} of {all}");
    assert!(all_named as f64 >= at_least(0.9, all_stand) && all_wrong as f64 <= at_most(0.05, all));
}

#[test]
fn laws_what_has_no_name_is_not_named() {
    let mission = mission(at_rest());
    let times = times(&mission);
    let (mut all_wrong, mut all_quiet, mut all) = (0, 0, 0);
    for (kind, name) in KINDS.iter().enumerate() {
        let outcomes: Vec<(bool, bool, String)> = (0..trials(1, 60))
            .into_par_iter()
            .map(|trial| {
                let mut random = seed(700 + 10 * trial + kind as u64);
                let (pattern, pattern_name) = outside(&mission, &times, kind as u64, &mut random);
                let found = diagnose(&mission, &measured(&times, &pattern, &mut random), &Settings::default()).unwrap();
                let quiet = found.verdict == Verdict::NothingMissing;
                let hidden: Vec<&str> = pattern_name.as_deref().into_iter().collect();
                let text = format!("{pattern_name:?}: {} {:?}", found.verdict.name(), names(&found));
                (is_wrong(&found, &hidden), quiet, text)
            })
            .collect();
        let wrong = outcomes.iter().filter(|own| own.0).count();
        let quiet = outcomes.iter().filter(|own| own.1).count();
        println!("outside alone, {name:26} wrong names in {wrong} of {}, nothing missing in {quiet}", outcomes.len());
        outcomes.iter().filter(|o| o.0 || o.1).take(8).for_each(|o| println!("      {}", o.2));
        all_quiet += quiet;
        (all_wrong, all) = (all_wrong + wrong, all + outcomes.len());
    }
    println!("outside alone: wrong names in {all_wrong} of {all}, nothing missing in {all_quiet}");
    assert!(all_wrong as f64 <= at_most(0.05, all) && all_quiet == 0);
}

/// A random walk follows any slow course, so does a channel by itself: what rises and falls smoothly in one of them, and in no other, is no walk of the unit.
#[test]
fn laws_a_channel_that_deviates_smoothly_is_no_random_walk() {
    let mission = mission(at_rest());
    let times = times(&mission);
    let last = times[times.len() - 1];
    let outcomes: Vec<(bool, String)> = (0..trials(6, 60))
        .into_par_iter()
        .map(|trial| {
            let mut random = seed(900 + trial);
            let (channel, size) = ((uniform(&mut random) * 3.0) as usize, 2.0 * 4f64.powf(uniform(&mut random)));
            let humps: Vec<[f64; 3]> = (0..1 + trial % 3)
                .map(|_| {
                    let height: f64 = StandardNormal.sample(&mut random);
                    [height, 0.1 + 0.8 * uniform(&mut random), 0.02 + 0.08 * uniform(&mut random)]
                })
                .collect();
            let course: Vec<f64> = times
                .iter()
                .map(|time| humps.iter().map(|[h, at, w]| h * (-0.5 * ((time / last - at) / w).powi(2)).exp()).sum())
                .collect();
            let rms = (course.iter().map(|v: &f64| v * v).sum::<f64>() / course.len() as f64).sqrt();
            let mut truth = vec![Channels::default(); times.len()];
            for (z, v) in truth.iter_mut().zip(&course) {
                z[channel] = size * U[channel] * v / rms;
            }
            let found = diagnose(&mission, &measured(&times, &truth, &mut random), &Settings::default()).unwrap();
            let walks = |f: &Finding| matches!(f.source, Cause::RandomWalk(_) | Cause::BiasWalk(..));
            let text = format!("{} at {size:.1}: {} {:?}", CHANNEL_NAMES[channel], found.verdict.name(), names(&found));
            (found.findings.iter().any(walks), text)
        })
        .collect();
    let wrong = outcomes.iter().filter(|own| own.0).count();
    println!("smooth deviations of one angle, named as random walks {wrong} of {}", outcomes.len());
    outcomes.iter().filter(|own| own.0).for_each(|own| println!("      {}", own.1));
    assert_eq!(wrong, 0);
}

/// `sum a b / u^2` over rows and channels.
fn product(a: &[Channels], b: &[Channels]) -> f64 {
    let row = |(a, b): (&Channels, &Channels)| (0..7).map(|k| a[k] * b[k] / (U[k] * U[k])).sum::<f64>();
    a.iter().zip(b).map(row).sum()
}

#[test]
fn laws_what_is_not_probable_enough_for_a_name_is_suspected() {
    let mission = mission(at_rest());
    let times = times(&mission);
    let one = |trial: u64| {
        let mut random = seed(1900 + trial);
        let source = ErrorSource::named(BIASES[trial as usize % 5]).unwrap();
        let unit = 1e-3 * source.si_per_unit();
        let column = flown(&mission, &ImuErrors::single(source, unit), &times);
        // 3.5 to 6 standard uncertainties
        let factor = (3.5 + 2.5 * uniform(&mut random)) / product(&column, &column).sqrt();
        let truth = flown(&mission, &ImuErrors::single(source, unit * factor), &times);
        let found = diagnose(&mission, &measured(&times, &truth, &mut random), &Settings::default()).unwrap();
        let is_right = |cause: &Cause| {
            let own =
                cause.constant().map(|own| flown(&mission, &ImuErrors::single(own, 1e-3 * own.si_per_unit()), &times));
            // another error of which this one has two thirds of the squares is what these rows can say
            own.is_some_and(|own| {
                product(&own, &truth).abs() > 0.8 * (product(&own, &own) * product(&truth, &truth)).sqrt()
            })
        };
        for (cause, probability) in &found.suspected {
            assert!((0.5..0.95).contains(probability), "{}: {probability}", cause.id());
            assert!(!found.findings.iter().any(|finding| finding.source == *cause));
        }
        if found.findings.is_empty() {
            assert_eq!(found.after, found.before);
            assert_eq!(found.verdict == Verdict::NothingMissing, found.suspected.is_empty());
        }
        let right: Vec<(f64, bool)> = found.suspected.iter().map(|(cause, p)| (*p, is_right(cause))).collect();
        (right, found.findings.len())
    };
    let all: Vec<(Vec<(f64, bool)>, usize)> = (0..trials(20, 200)).into_par_iter().map(one).collect();
    let suspected: Vec<(f64, bool)> = all.iter().flat_map(|(suspected, _)| suspected.clone()).collect();
    let named = all.iter().filter(|(_, named)| *named > 0).count();
    let (stated, right) = (suspected.iter().map(|s| s.0).sum::<f64>(), suspected.iter().filter(|s| s.1).count());
    println!(
        "of {}: named {named}, suspected {}, of them right {right}, probabilities {stated:.1}",
        all.len(),
        suspected.len()
    );
    let spread = suspected.iter().map(|(p, _)| p * (1.0 - p)).sum::<f64>().sqrt();
    assert!(!suspected.is_empty() && named > 0);
    assert!(right as f64 > stated - 3.0 * spread, "{right} of {stated:.1}");
}
