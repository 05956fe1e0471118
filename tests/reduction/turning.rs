//! Means of stretches in which a joint turns: how often 1.96 u holds their errors, over rates, turns, harmonics and noises that are drawn widely.

use crate::draws::draws;
use crate::readings::{flicker, markov, normal, uniform};
use crate::reduce::{By, Trace, reduce, segment, whole_turns};
use rand_distr::{Distribution, StudentT};
use rand_pcg::Pcg64Mcg;
use rand_pcg::rand_core::SeedableRng;
use std::f64::consts::TAU;

/// Evenly over the logarithm.
fn logarithmic(random: &mut Pcg64Mcg, low: f64, high: f64) -> f64 {
    uniform(random, low.ln(), high.ln()).exp()
}

fn white(random: &mut Pcg64Mcg, count: usize) -> Vec<f64> {
    (0..count).map(|_| normal(random)).collect()
}

fn walk(random: &mut Pcg64Mcg, count: usize) -> Vec<f64> {
    let mut at = 0.0;
    let mut next = || {
        at += normal(random);
        at
    };
    (0..count).map(|_| next()).collect()
}

fn sum(a: &[f64], by: f64, b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a + by * b).collect()
}

/// The kinds of noise.
const KINDS: [&str; 13] = [
    "white",
    "quantised",
    "heavy tails",
    "filtered",
    "Markov, tau T/100",
    "Markov, tau T/30",
    "Markov, tau T/10",
    "Markov, tau T/3",
    "Markov, any tau",
    "two Markov",
    "flicker",
    "flicker and white",
    "walk and white",
];

/// Noise of a kind: `length` samples are a stretch. And whether it has a level of its own, zero; else its level is that of the record.
fn noise(random: &mut Pcg64Mcg, kind: &str, count: usize, length: f64) -> (Vec<f64>, bool) {
    let coloured = |random: &mut Pcg64Mcg, tau: f64| {
        // in the samples from a tenth of the white noise to ten times it
        let by = logarithmic(random, 0.1, 10.0);
        sum(&white(random, count), by, &markov(random, count, tau.max(0.3)))
    };
    let own = match kind {
        "white" | "quantised" => white(random, count),
        "heavy tails" => {
            let student = StudentT::new(4.0).expect("degrees of freedom");
            (0..count).map(|_| student.sample(random)).collect()
        }
        "filtered" => {
            let taps = uniform(random, 2.0, 12.0) as usize;
            white(random, count + taps).windows(taps).take(count).map(|own| own.iter().sum()).collect()
        }
        "Markov, any tau" => {
            let tau = length * logarithmic(random, 0.003, 0.4);
            coloured(random, tau)
        }
        "two Markov" => {
            let (short, long) = (logarithmic(random, 0.003, 0.03), logarithmic(random, 0.03, 0.3));
            let first = coloured(random, length * short);
            let by = logarithmic(random, 0.1, 3.0);
            sum(&first, by, &markov(random, count, length * long))
        }
        "flicker" => flicker(random, count),
        "flicker and white" => {
            let by = logarithmic(random, 0.1, 1.0);
            sum(&white(random, count), by, &flicker(random, count))
        }
        "walk and white" => {
            // where white noise and walk make equal parts of a mean: from far above a stretch to a tenth of it
            let by = logarithmic(random, 0.3, 30.0) / length;
            sum(&white(random, count), by, &walk(random, count))
        }
        other => {
            let part: f64 = other.rsplit('/').next().and_then(|part| part.parse().ok()).expect("T over a number");
            coloured(random, length / part)
        }
    };
    (own, !kind.starts_with("flicker") && !kind.starts_with("walk"))
}

/// One record: stretches of a joint that turns, with what the input makes of the turn.
struct Drawn {
    /// With what the turn makes of it, and the noise and levels alone.
    turning: Trace,
    resting: Trace,
    /// Starts and ends, s.
    stretches: Vec<(f64, f64)>,
    turn_s: f64,
    /// The level of each stretch.
    levels: Vec<f64>,
    /// Harmonics of the turn, the highest.
    harmonics: usize,
}

fn drawn(random: &mut Pcg64Mcg, kind: &str) -> Drawn {
    let rate = logarithmic(random, 10.0, 1000.0);
    let turns = logarithmic(random, 1.0, 40.0);
    // samples a turn: stretches have 60 to 4000 samples, turns 12 and more
    let per_turn = logarithmic(random, 12.0, 400.0).max(60.0 / turns).min(4000.0 / turns).max(12.0);
    let segments = uniform(random, 3.0, 13.0) as usize;
    let mut length = || (turns * per_turn * uniform(random, 1.0, 1.6)).ceil() as usize;
    let lengths: Vec<usize> = (0..segments).map(|_| length()).collect();
    let count: usize = lengths.iter().sum();
    let (noise, own_level) = noise(random, kind, count, count as f64 / segments as f64);
    let harmonics = uniform(random, 0.0, 7.0) as usize;
    let mut values = [const { Vec::new() }; 2];
    let (mut stretches, mut levels) = (Vec::new(), Vec::new());
    let common = if own_level { 0.0 } else { noise.iter().sum::<f64>() / count as f64 };
    for length in lengths {
        let start = values[0].len();
        let level = 100.0 * normal(random);
        let first = uniform(random, 0.0, 1.0);
        let waves: Vec<(f64, f64)> =
            (0..harmonics).map(|_| (logarithmic(random, 0.1, 300.0), uniform(random, 0.0, TAU))).collect();
        for (k, noise) in noise.iter().skip(start).take(length).enumerate() {
            let angle = TAU * (first + k as f64 / per_turn);
            let wave = |((size, phase), order): (&(f64, f64), i32)| size * (f64::from(order) * angle + phase).cos();
            values[0].push(level + noise + waves.iter().zip(1..).map(wave).sum::<f64>());
            values[1].push(level + noise);
        }
        stretches.push((start as f64 / rate, (start + length) as f64 / rate));
        levels.push(level + common);
    }
    if kind == "quantised" {
        let step = logarithmic(random, 0.3, 4.0);
        values.iter_mut().flatten().for_each(|v| *v = (*v / step).round() * step);
    }
    let trace = |values: &[f64]| {
        let mut trace = Trace::new(vec![("gyro".into(), String::new())]);
        trace.interval = 1.0 / rate;
        trace.push(&[values], None);
        trace.finish();
        trace
    };
    let [turning, resting] = values.map(|own| trace(&own));
    Drawn { turning, resting, stretches, turn_s: 1.0 / rate * per_turn, levels, harmonics }
}

/// The ways of taking a stretch.
const WAYS: [&str; 4] = ["whole turns", "a part missing", "parts of turns", "at rest"];

/// Each mean's error and u.
fn taken(drawn: &Drawn, way: usize, missing: (f64, f64)) -> Vec<(f64, f64)> {
    let trace = if way < 3 { &drawn.turning } else { &drawn.resting };
    let times = drawn.stretches.iter().enumerate().map(|(k, (start, end))| (k.to_string(), *start, *end));
    let mut found = segment(trace, &By::Times(times.collect()), 0.0, 0.0);
    let mut turns = vec![Some(drawn.turn_s); found.segments.len()];
    if way != 2 {
        turns = whole_turns(trace, &mut found, &turns);
    }
    if way == 1 {
        for own in &mut found.segments {
            let (start, end) = own.span();
            let place = |part: f64| start + ((end - start) as f64 * part) as u64;
            own.pieces = vec![start..place(missing.0), place(missing.0 + missing.1)..end];
        }
    }
    if way == 3 {
        turns.fill(None);
    }
    let level = |own: &crate::reduce::Segment| drawn.levels[own.label.parse::<usize>().expect("a number")];
    let levels: Vec<f64> = found.segments.iter().map(level).collect();
    let reduction = reduce(trace, found, &turns);
    reduction.means.iter().flatten().zip(levels).map(|(mean, level)| (mean.value - level, mean.uncertainty.u)).collect()
}

/// Shares of means within 1.96 u, with the standard deviation of the share (means of one record share what was learnt of the noise), and how much larger u is
/// than of the same noise at rest: the median up to the third harmonic, and of records with a fourth to a sixth.
#[test]
fn means_of_turning_stretches_are_covered() {
    let records = draws(8, 100);
    let (mut inside, mut means, mut larger) = (0.0, 0.0, 0.0_f64);
    print!("{:>18} {:>9}", "noise", "stretches");
    WAYS.iter().for_each(|way| print!(" {way:>16}"));
    println!("  u, of u at rest");
    for (number, kind) in (0..).zip(KINDS) {
        let mut random = Pcg64Mcg::seed_from_u64(31_000 + number);
        let mut shares = [const { Vec::new() }; WAYS.len()];
        let mut ratios = [const { Vec::new() }; 2];
        for _ in 0..records {
            let drawn = drawn(&mut random, kind);
            let missing = (uniform(&mut random, 0.1, 0.7), uniform(&mut random, 0.05, 0.2));
            let all: Vec<Vec<(f64, f64)>> = (0..WAYS.len()).map(|way| taken(&drawn, way, missing)).collect();
            for (shares, means) in shares.iter_mut().zip(&all) {
                let inside = means.iter().filter(|(error, u)| error.abs() <= 1.96 * u).count();
                shares.push((inside as f64, means.len() as f64));
            }
            ratios[usize::from(drawn.harmonics > 3)]
                .extend(all[0].iter().zip(&all[3]).map(|((_, u), (_, rest))| u / rest));
        }
        print!("{kind:>18} {:>9}", shares[0].iter().map(|(_, own)| own).sum::<f64>());
        for shares in &shares {
            let (inside, all) = shares.iter().fold((0.0, 0.0), |(a, b), (inside, all)| (a + inside, b + all));
            let share = inside / all;
            let square = |(inside, own): &(f64, f64)| (inside - share * own).powi(2);
            print!("   {share:.3} +- {:.3}", shares.iter().map(square).sum::<f64>().sqrt() / all);
        }
        let median = |list: &mut Vec<f64>| {
            list.sort_by(f64::total_cmp);
            list.get(list.len() / 2).copied().unwrap_or(f64::NAN)
        };
        let [three, more] = ratios.each_mut().map(median);
        println!("  {three:.2} {more:.2}");
        larger = larger.max(three).max(more);
        // a walk that does not show within a stretch moves the level of the record all the same
        if !kind.starts_with("walk") {
            let whole = shares[0].iter().chain(&shares[1]).chain(&shares[2]);
            let (held, all) = whole.fold((0.0, 0.0), |(a, b), (held, all)| (a + held, b + all));
            (inside, means) = (inside + held, means + all);
        }
    }
    println!("all but the walk, turning: {:.3}", inside / means);
    // a few hundred records: two standard deviations of their share are 0.01
    assert!((0.93..=0.98).contains(&(inside / means)), "{}", inside / means);
    // harmonics above the third are no noise (u was 3 to 70 times too large where they were taken for it)
    assert!(larger < 1.5, "{larger}");
}
