//! Segments, means and their uncertainties: against simulated records whose truth is known, and real ones.

use crate::draws::draws;
use rand_distr::{Distribution, StandardNormal, Uniform};
use rand_pcg::Pcg64Mcg;
use rand_pcg::rand_core::SeedableRng;
use tumble::reduce::{By, EventKind, Trace, reduce, segment};

fn normal(random: &mut Pcg64Mcg) -> f64 {
    StandardNormal.sample(random)
}

fn uniform(random: &mut Pcg64Mcg, low: f64, high: f64) -> f64 {
    Uniform::new(low, high).expect("a range").sample(random)
}

/// A trace of one-channel or several-channel samples.
fn trace(columns: &[Vec<f64>], interval: f64) -> Trace {
    let mut trace = Trace::new((0..columns.len()).map(|k| (format!("c{k}"), String::new())).collect());
    trace.interval = interval;
    trace.push(&columns.iter().map(Vec::as_slice).collect::<Vec<_>>());
    trace.finish();
    trace
}

/// First-order noise of standard deviation one.
fn markov(random: &mut Pcg64Mcg, count: usize, tau: f64) -> Vec<f64> {
    let stay = (-1.0 / tau).exp();
    let mut state = normal(random);
    (0..count)
        .map(|_| {
            state = stay * state + (1.0 - stay * stay).sqrt() * normal(random);
            state
        })
        .collect()
}

/// Flicker noise: first-order processes of equal variance, spread evenly over the logarithm of their correlation times, four to a decade.
fn flicker(random: &mut Pcg64Mcg, count: usize) -> Vec<f64> {
    let mut sum = vec![0.0; count];
    let mut tau = 0.1;
    while tau < 100.0 * count as f64 {
        sum.iter_mut().zip(markov(random, count, tau)).for_each(|(s, v)| *s += v);
        tau *= 10f64.powf(0.25);
    }
    sum
}

/// How often 1.96 u holds the error of a mean, for noise of several kinds. Flicker noise has no mean of its own: its means are those about the level of the record.
#[test]
fn uncertainties_of_means_cover() {
    const LENGTH: usize = 600;
    let runs = draws(12, 400);
    println!("{:>9} {:>22} {:>8} {:>9} {:>10}", "segments", "noise", "covered", "+-", "u/rms error");
    for segments in [4_usize, 12, 30] {
        for kind in ["white", "tau T/100", "tau T/30", "tau T/10", "tau T/5", "tau T/3", "flicker", "white and flicker"]
        {
            let mut random = Pcg64Mcg::seed_from_u64(17 + segments as u64);
            let (mut inside, mut all, mut squares, mut us) = (0.0, 0.0, 0.0, Vec::new());
            for _ in 0..runs {
                let count = segments * LENGTH;
                let noise = match kind.split_once('/') {
                    Some((_, part)) => {
                        markov(&mut random, count, LENGTH as f64 / part.parse::<f64>().expect("a number"))
                    }
                    None => match kind {
                        "white" => (0..count).map(|_| normal(&mut random)).collect(),
                        "flicker" => flicker(&mut random, count),
                        _ => {
                            let f = flicker(&mut random, count);
                            f.into_iter().map(|f| f + 5.0 * normal(&mut random)).collect::<Vec<f64>>()
                        }
                    },
                };
                let level = if kind.contains("flicker") { noise.iter().sum::<f64>() / count as f64 } else { 0.0 };
                let trace = trace(&[noise], 0.01);
                let seconds = LENGTH as f64 * 0.01;
                let times = (0..segments).map(|k| (String::new(), k as f64 * seconds, (k + 1) as f64 * seconds));
                let found = segment(&trace, &By::Times(times.collect()), 0.0, 0.0);
                let reduction = reduce(&trace, found, &vec![None; segments]);
                for mean in reduction.means.iter().flatten() {
                    let error = mean.value - level;
                    inside += f64::from(u8::from(error.abs() < 1.96 * mean.uncertainty.u));
                    squares += error * error;
                    us.push(mean.uncertainty.u);
                    all += 1.0;
                }
            }
            us.sort_by(f64::total_cmp);
            let covered = inside / all;
            // means of one run share what was learnt of the noise: the scatter of the share is that of runs
            let scatter = (0.95 * 0.05 / runs as f64).sqrt();
            let ratio = us[us.len() / 2] / (squares / all).sqrt();
            println!("{segments:>9} {kind:>22} {covered:8.3} {scatter:9.3} {ratio:10.3}");
            assert!((0.93 - 2.0 * scatter..=1.0).contains(&covered), "{segments} {kind}: {covered}");
        }
    }
}

/// Every third segment turns, and is noisier by far and from sample to sample: the means at rest keep the u that they have without it, and both kinds cover.
#[test]
fn segments_of_other_noise_keep_apart() {
    const LENGTH: usize = 600;
    const SEGMENTS: usize = 12;
    let runs = draws(40, 1000);
    println!("{:>7} {:>8} {:>9} {:>9} {:>10}", "noise", "at rest", "turning", "+-", "u at rest");
    for (noisier, tau) in [(30.0, 0.0), (30.0, 20.0), (4.0, 0.0)] {
        let mut random = Pcg64Mcg::seed_from_u64(409);
        let (mut inside, mut all, mut ratios) = ([0.0; 2], [0.0; 2], Vec::new());
        for _ in 0..runs {
            let parts = (0..SEGMENTS).map(|k| -> Vec<f64> {
                let sd = if k % 3 == 2 { noisier } else { 1.0 };
                match tau {
                    0.0 => (0..LENGTH).map(|_| sd * normal(&mut random)).collect(),
                    tau => markov(&mut random, LENGTH, tau).into_iter().map(|v| sd * v).collect(),
                }
            });
            let parts: Vec<Vec<f64>> = parts.collect();
            let still: Vec<Vec<f64>> =
                parts.iter().enumerate().filter(|(k, _)| k % 3 != 2).map(|(_, p)| p.clone()).collect();
            let of = |parts: &[Vec<f64>]| {
                let trace = trace(&[parts.concat()], 0.01);
                let seconds = LENGTH as f64 * 0.01;
                let times = (0..parts.len()).map(|k| (String::new(), k as f64 * seconds, (k + 1) as f64 * seconds));
                let found = segment(&trace, &By::Times(times.collect()), 0.0, 0.0);
                reduce(&trace, found, &vec![None; parts.len()])
            };
            let (with, without) = (of(&parts), of(&still));
            for (k, mean) in with.means.iter().flatten().enumerate() {
                let turning = usize::from(k % 3 == 2);
                inside[turning] += f64::from(u8::from(mean.value.abs() < 1.96 * mean.uncertainty.u));
                all[turning] += 1.0;
                assert_eq!(mean.uncertainty.apart, turning == 1, "{k}");
            }
            let at_rest =
                with.means.iter().flatten().enumerate().filter(|(k, _)| k % 3 != 2).map(|(_, m)| m.uncertainty.u);
            ratios.extend(at_rest.zip(without.means.iter().flatten()).map(|(u, alone)| u / alone.uncertainty.u));
        }
        let covered = [inside[0] / all[0], inside[1] / all[1]];
        let scatter = (0.95 * 0.05 / runs as f64).sqrt();
        ratios.sort_by(f64::total_cmp);
        let ratio = ratios[ratios.len() / 2];
        println!("x {noisier:<5} {:8.3} {:9.3} {scatter:9.3} {ratio:10.3}", covered[0], covered[1]);
        assert!(covered.iter().all(|c| (0.93 - 2.0 * scatter..=1.0).contains(c)), "{noisier} {tau}: {covered:?}");
        // the record is longer with the turns, which a description by flicker feels
        assert!((ratio - 1.0).abs() < 0.02, "{noisier} {tau}: {ratio}");
    }
}

/// One simulated log of a tilted triad: positions, what moves it from one to the next, jerks and drifts.
struct Log {
    columns: Vec<Vec<f64>>,
    positions: Vec<(f64, f64)>,
}

fn log(random: &mut Pcg64Mcg, rate: f64) -> Log {
    let noise = uniform(random, 0.005, 0.05);
    let positions = uniform(random, 6.0, 15.0) as usize;
    let direction = |random: &mut Pcg64Mcg| {
        let v: Vec<f64> = (0..3).map(|_| normal(random)).collect();
        let size = v.iter().map(|x| x * x).sum::<f64>().sqrt();
        v.into_iter().map(|x| 9.81 * x / size).collect::<Vec<f64>>()
    };
    let mut columns = vec![Vec::new(); 3];
    let mut list = Vec::new();
    let mut now = direction(random);
    for k in 0..positions {
        if k > 0 {
            let mut next = direction(random);
            while next.iter().zip(&now).map(|(a, b)| (a - b) * (a - b)).sum::<f64>() < 1.0 {
                next = direction(random);
            }
            let count = (uniform(random, 1.0, 4.0) * rate) as usize;
            for i in 0..count {
                let x = i as f64 / count as f64;
                let part = x * x * (3.0 - 2.0 * x);
                let shake = 0.5 * (std::f64::consts::PI * x).sin();
                for (axis, column) in columns.iter_mut().enumerate() {
                    let swing = shake * (6.0 * i as f64 / rate * (1.0 + axis as f64)).sin();
                    column.push(now[axis] + part * (next[axis] - now[axis]) + swing + noise * normal(random));
                }
            }
            now = next;
        }
        let start = columns[0].len() as f64 / rate;
        let count = (uniform(random, 4.0, 15.0) * rate) as usize;
        let drift: Vec<f64> = (0..3).map(|_| 3.0 * noise * normal(random) / count as f64).collect();
        let jerk = (uniform(random, 0.0, 1.0) < 0.3).then(|| {
            let length = (uniform(random, 0.05, 0.4) * rate) as usize;
            let from = uniform(random, 0.3, 0.6) * count as f64;
            (from as usize, length.max(1), noise * uniform(random, 5.0, 60.0))
        });
        for i in 0..count {
            for (axis, column) in columns.iter_mut().enumerate() {
                let mut value = now[axis] + drift[axis] * i as f64 + noise * normal(random);
                if let Some((from, length, size)) = jerk
                    && (from..from + length).contains(&i)
                {
                    value += size * (std::f64::consts::TAU * (i - from) as f64 / length as f64).sin();
                }
                column.push(value);
            }
        }
        list.push((start, columns[0].len() as f64 / rate));
    }
    Log { columns, positions: list }
}

/// Every position is found, none is made up, and boundaries are within two windows (1 s).
#[test]
fn the_static_detector_finds_every_position() {
    let runs = draws(40, 1000);
    let mut random = Pcg64Mcg::seed_from_u64(2);
    let (mut wrong, mut positions, mut furthest) = (0, 0, 0.0_f64);
    let (mut sum, mut boundaries) = (0.0, 0.0);
    for run in 0..runs {
        let log = log(&mut random, 100.0);
        let trace = trace(&log.columns, 0.01);
        let found = segment(&trace, &By::Still { window: 0.5, threshold: 4.0 }, 0.0, 1.0);
        positions += log.positions.len();
        if found.segments.len() != log.positions.len() {
            println!("log {run}: {} positions, {} found", log.positions.len(), found.segments.len());
            for segment in &found.segments {
                let (a, b) = segment.span();
                println!("  {:.2} to {:.2} s {:?}", trace.time(a), trace.time(b), segment.notes);
            }
            println!("  true: {:.2?}", log.positions);
            wrong += 1;
            continue;
        }
        for (segment, (start, end)) in found.segments.iter().zip(&log.positions) {
            let (a, b) = segment.span();
            for off in [trace.time(a) - start, trace.time(b) - end] {
                furthest = furthest.max(off.abs());
                sum += off.abs();
                boundaries += 1.0;
            }
        }
    }
    println!("{runs} logs, {positions} positions: {wrong} logs with a position lost or made up");
    println!("boundaries off by {:.3} s on average, {furthest:.3} s at most (window 0.5 s)", sum / boundaries);
    assert!(wrong * 100 <= runs && furthest < 1.0);
}

#[test]
fn odd_samples_are_named() {
    let mut random = Pcg64Mcg::seed_from_u64(5);
    let mut x: Vec<f64> = (0..20_000).map(|_| (200.0 * normal(&mut random)).round() / 200.0).collect();
    x[3000] += 30.0;
    x[7000..7040].fill(0.125);
    x[9000..9005].fill(50.0);
    x[12_000] = f64::NAN;
    let trace = trace(&[x], 0.01);
    let of = |kind: EventKind| -> Vec<u64> {
        trace.channels[0].events.iter().filter(|e| e.kind == kind).map(|e| e.sample).collect()
    };
    assert_eq!(of(EventKind::Spike), [3000]);
    assert_eq!(of(EventKind::Stuck), [7000]);
    assert_eq!(of(EventKind::Saturation), [9000]);
    assert_eq!(of(EventKind::Absent), [12_000]);
    assert_eq!(trace.samples, 19_999);
}

/// A trace that had to thin itself has the same means and standard deviations.
#[test]
fn a_thinned_trace_has_the_same_means() {
    let mut random = Pcg64Mcg::seed_from_u64(6);
    let x: Vec<f64> = (0..100_000).map(|k| 1e4 + 1e-4 * f64::from(k) + normal(&mut random)).collect();
    let whole = trace(std::slice::from_ref(&x), 0.01);
    let mut thin = Trace::new(vec![("c".into(), String::new())]).with_blocks(1000);
    thin.interval = 0.01;
    x.chunks(997).for_each(|part| thin.push(&[part]));
    thin.finish();
    assert!(thin.block == 128 && thin.channels[0].means.len() <= 1000);
    let times = By::Times(vec![("a".into(), 100.0, 400.0)]);
    let mean = |trace: &Trace| reduce(trace, segment(trace, &times, 0.0, 0.0), &[None]).means[0][0].clone();
    let (a, b) = (mean(&whole), mean(&thin));
    assert!((a.value - b.value).abs() < 0.02 && (a.sd / b.sd - 1.0).abs() < 0.02, "{a:?} {b:?}");
    let exact = x[10_112..39_936].iter().sum::<f64>() / 29_824.0;
    let inside = thin.blocks(10_000, 40_000);
    let means = &thin.channels[0].means[inside];
    assert!((means.iter().sum::<f64>() / means.len() as f64 - exact).abs() < 1e-8);
}

/// Nothing stands still: the threshold that would find something is told.
#[test]
fn no_static_stretch() {
    let mut random = Pcg64Mcg::seed_from_u64(7);
    let x: Vec<f64> = (0..6000).map(|k| 10f64.powf(1.5 * (f64::from(k) / 40.0).sin()) * normal(&mut random)).collect();
    let found = segment(&trace(&[x], 0.01), &By::Still { window: 0.5, threshold: 4.0 }, 0.5, 20.0);
    assert!(found.segments.is_empty());
    assert!(found.stillness.expect("judged").would_find.expect("a threshold") > 4.0);
}

/// What repeats with a turn is taken out of the noise, but not the noise at its frequencies: means over two and five turns are covered. (With nothing in
/// its place: 0.87 for correlation times of a hundredth and a twentieth of a segment and two turns.)
#[test]
fn means_over_turns_keep_the_noise_at_their_frequencies() {
    use tumble::reduce::{Segment, Trace, mean_uncertainties};
    let long = std::env::var("TUMBLE_LONG").is_ok_and(|v| v == "1");
    let (records, segments, length) = (if long { 300 } else { 8 }, 8, 240);
    println!("{:>6} {:>8} {:>8}", "turns", "time", "covered");
    let (mut covered, mut every) = (0, 0);
    for turns in [2.0, 5.0] {
        for part in [0.0, 0.01, 0.05, 0.2] {
            let (mut inside, mut all) = (0, 0);
            for seed in 0..records {
                let mut random = Pcg64Mcg::seed_from_u64(9000 + seed);
                let mut normal = || -> f64 { StandardNormal.sample(&mut random) };
                let mut trace = Trace::new(vec![("y".into(), "mV".into())]);
                let stay = if part > 0.0 { f64::exp(-1.0 / (part * length as f64)) } else { 0.0 };
                for _ in 0..segments {
                    let mut state = normal();
                    let values: Vec<f64> = (0..length)
                        .map(|k| {
                            state = stay * state + (1.0 - stay * stay).sqrt() * normal();
                            let angle = std::f64::consts::TAU * turns * k as f64 / length as f64;
                            state + 0.5 * normal() + 10.0 * angle.sin() + (2.0 * angle).cos()
                        })
                        .collect();
                    trace.push(&[&values]);
                }
                trace.finish();
                let channel = &trace.channels[0];
                let blocks: Vec<_> = (0..segments as u64)
                    .map(|k| {
                        let pieces = std::iter::once(k * length as u64..(k + 1) * length as u64).collect();
                        let segment = Segment { label: k.to_string(), pieces, notes: Vec::new() };
                        channel.block(&trace, &segment, Some(length as f64 / turns))
                    })
                    .collect();
                for (block, found) in blocks.iter().zip(mean_uncertainties(&blocks, (segments * length) as f64, 0.95)) {
                    inside += usize::from(block.mean.abs() < 1.96 * found.u);
                    all += 1;
                }
            }
            println!("{turns:>6} {part:>8} {:8.3}", inside as f64 / all as f64);
            (covered, every) = (covered + inside, every + all);
        }
    }
    let share = covered as f64 / every as f64;
    assert!((if long { 0.93 } else { 0.91 }..=0.98).contains(&share), "{share}");
}
