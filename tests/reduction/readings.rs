//! Segments, means and their uncertainties: against simulated records whose truth is known, and real ones.

use crate::draws::draws;
use crate::reduce::{By, EventKind, Trace, reduce, segment};
use rand_distr::{Distribution, StandardNormal, Uniform};
use rand_pcg::Pcg64Mcg;
use rand_pcg::rand_core::SeedableRng;

pub fn normal(random: &mut Pcg64Mcg) -> f64 {
    StandardNormal.sample(random)
}

pub fn uniform(random: &mut Pcg64Mcg, low: f64, high: f64) -> f64 {
    Uniform::new(low, high).expect("a range").sample(random)
}

/// A trace of one-channel or several-channel samples.
fn trace(columns: &[Vec<f64>], interval: f64) -> Trace {
    let mut trace = Trace::new((0..columns.len()).map(|k| (format!("c{k}"), String::new())).collect());
    trace.interval = interval;
    trace.push(&columns.iter().map(Vec::as_slice).collect::<Vec<_>>(), None);
    trace.finish();
    trace
}

/// First-order noise of standard deviation one.
pub fn markov(random: &mut Pcg64Mcg, count: usize, tau: f64) -> Vec<f64> {
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
pub fn flicker(random: &mut Pcg64Mcg, count: usize) -> Vec<f64> {
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
            // all segments of the record, and those at rest alone
            let of = |is_used: &dyn Fn(&usize) -> bool| {
                let trace = trace(&[parts.concat()], 0.01);
                let seconds = LENGTH as f64 * 0.01;
                let times = (0..parts.len()).filter(is_used);
                let times = times.map(|k| (String::new(), k as f64 * seconds, (k + 1) as f64 * seconds));
                let found = segment(&trace, &By::Times(times.collect()), 0.0, 0.0);
                let count = found.segments.len();
                reduce(&trace, found, &vec![None; count])
            };
            let (with, without) = (of(&|_| true), of(&|k| k % 3 != 2));
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
        // of one record: the noise that has no level of its own feels how long it is
        assert!((ratio - 1.0).abs() < 1e-9, "{noisier} {tau}: {ratio}");
    }
}

/// Noise that differs from segment to segment, in size or in its spectrum alone: means of each kind are covered, and what is white is not widened by what is not.
/// (Before: 0.91 where a hand trembles slowly and 1.00 in the segments between, whose u was 9 times too large; 0.98 and 0.91 for white noise of 1 and 1.4.)
#[test]
fn segments_of_different_noise_are_covered_each() {
    const LENGTH: usize = 600;
    const SEGMENTS: usize = 12;
    let runs = draws(60, 1000);
    println!("{:>24} {:>8} {:>9} {:>9} {:>10}", "noise", "calm", "noisy", "+-", "u/rms calm");
    for kind in
        ["hand across gravity", "hand, every attitude", "white 1 and 1.4", "white in steps of 1.3", "slow in one"]
    {
        let mut random = Pcg64Mcg::seed_from_u64(2027);
        let (mut inside, mut all, mut squares, mut us) = ([0.0; 2], [0.0; 2], 0.0, Vec::new());
        for _ in 0..runs {
            // what trembles slowly, in standard deviations of the white noise, and the white noise
            let sizes = (0..SEGMENTS).map(|k| match kind {
                "hand across gravity" => (if k % 2 == 1 { 2.0 } else { 0.0 }, 1.0),
                "hand, every attitude" => (if k % 2 == 1 { 0.5 * (1 + k / 2) as f64 } else { 0.0 }, 1.0),
                "white 1 and 1.4" => (0.0, if k % 2 == 1 { 1.4 } else { 1.0 }),
                "white in steps of 1.3" => (0.0, 1.3_f64.powi(k as i32)),
                _ => (if k == 5 { 2.0 } else { 0.0 }, 1.0),
            });
            let sizes: Vec<(f64, f64)> = sizes.collect();
            let part = |(slow, white): &(f64, f64)| -> Vec<f64> {
                let tremor = markov(&mut random, LENGTH, 20.0);
                tremor.into_iter().map(|v| slow * v + white * normal(&mut random)).collect()
            };
            let trace = trace(&[sizes.iter().flat_map(part).collect()], 0.01);
            let seconds = LENGTH as f64 * 0.01;
            let times = (0..SEGMENTS).map(|k| (String::new(), k as f64 * seconds, (k + 1) as f64 * seconds));
            let found = segment(&trace, &By::Times(times.collect()), 0.0, 0.0);
            let reduction = reduce(&trace, found, &[None; SEGMENTS]);
            for (mean, (k, (slow, _))) in reduction.means.iter().flatten().zip(sizes.iter().enumerate()) {
                let noisy = if kind.starts_with("white") { k % 2 == 1 } else { *slow > 0.0 };
                let noisy = usize::from(if kind.contains("steps") { k >= SEGMENTS / 2 } else { noisy });
                inside[noisy] += f64::from(u8::from(mean.value.abs() < 1.96 * mean.uncertainty.u));
                all[noisy] += 1.0;
                if noisy == 0 && !kind.contains("steps") {
                    squares += mean.value * mean.value;
                    us.push(mean.uncertainty.u);
                }
            }
        }
        let covered = [inside[0] / all[0], inside[1] / all[1]];
        us.sort_by(f64::total_cmp);
        let ratio = us.get(us.len() / 2).map_or(1.0, |u| u / (squares / us.len() as f64).sqrt());
        let scatter = [0, 1].map(|k| (0.95 * 0.05 / all[k]).sqrt());
        println!("{kind:>24} {:8.3} {:9.3} {:9.3} {ratio:10.3}", covered[0], covered[1], scatter[1]);
        for (covered, scatter) in covered.into_iter().zip(scatter) {
            assert!((0.93 - 2.0 * scatter..=0.97 + 2.0 * scatter).contains(&covered), "{kind}: {covered}");
        }
        assert!((ratio - 1.0).abs() < 0.15, "{kind}: {ratio}");
    }
}

/// A channel that never changes: its u is that of rounding to its last decimal place, a step over the root of 12 (GUM, F.2.2.1) less what is known of the place in it (noise that is not seen leaves no sample near an edge), also where
/// sums of the value are not exact.
#[test]
fn a_channel_of_one_value_is_rounded_at_its_last_place() {
    for (value, step) in [(7.0, 1.0), (0.1, 0.1), (-23.45, 0.01)] {
        let trace = trace(&[vec![value; 3000]], 0.01);
        let times = (0..3).map(|k| (String::new(), 10.0 * f64::from(k), 10.0 * f64::from(k) + 9.0));
        let found = segment(&trace, &By::Times(times.collect()), 0.0, 0.0);
        for mean in reduce(&trace, found, &[None; 3]).means.iter().flatten() {
            assert_eq!((mean.value, mean.sd), (value, 0.0));
            let u = mean.uncertainty.u / step * 12f64.sqrt();
            assert!((0.85..=1.0).contains(&u), "{value}: {u}");
        }
    }
}

/// A channel in steps: means of segments whose levels lie anywhere in a step are covered, and u is of the size of their errors, from noise of a twentieth of a step, where
/// samples have one level or two, to that of a step, where rounding leaves nothing. Of two segments little is known of the noise.
/// (Before: `q/sqrt(12)` where a segment's standard deviation was below half a step, else nothing: u was 4 to 9 times the errors at 0.3 to 0.45 steps.)
#[test]
fn means_of_channels_in_steps_are_covered() {
    const LENGTH: usize = 600;
    let records = draws(60, 1000);
    println!("{:>9} {:>6} {:>8} {:>10}", "segments", "noise", "covered", "u/rms error");
    for segments in [1_usize, 2, 4, 12, 30] {
        let (mut inside, mut all) = (0.0, 0.0);
        for noise in [0.05, 0.1, 0.15, 0.2, 0.3, 0.4, 0.5, 1.0] {
            let mut random = Pcg64Mcg::seed_from_u64(60 + segments as u64);
            let (mut held, mut squares, mut us) = (0.0, 0.0, Vec::new());
            let runs = records.div_ceil(segments).max(10);
            for _ in 0..runs {
                let levels: Vec<f64> = (0..segments).map(|_| uniform(&mut random, -20.0, 20.0)).collect();
                let values = levels.iter().flat_map(|level| vec![*level; LENGTH]);
                let values: Vec<f64> = values.map(|v| (v + noise * normal(&mut random)).round()).collect();
                let trace = trace(&[values], 0.01);
                let seconds = LENGTH as f64 * 0.01;
                let times = (0..segments).map(|k| (String::new(), k as f64 * seconds, (k + 1) as f64 * seconds));
                let found = segment(&trace, &By::Times(times.collect()), 0.0, 0.0);
                let reduction = reduce(&trace, found, &vec![None; segments]);
                for (mean, level) in reduction.means.iter().flatten().zip(levels) {
                    let error = mean.value - level;
                    held += f64::from(u8::from(error.abs() < 1.96 * mean.uncertainty.u));
                    squares += error * error;
                    us.push(mean.uncertainty.u);
                }
            }
            us.sort_by(f64::total_cmp);
            let means = us.len() as f64;
            let (covered, ratio) = (held / means, us[us.len() / 2] / (squares / means).sqrt());
            println!("{segments:>9} {noise:6.2} {covered:8.3} {ratio:10.3}");
            // of few segments the noise is known to a factor only; the fault was 2.8 and more in many
            assert!(segments < 12 || (0.6..1.7).contains(&ratio), "{segments} {noise}: {ratio}");
            (inside, all) = (inside + held, all + means);
        }
        // means of one record share what was learnt of the noise
        let records = 8.0 * records.div_ceil(segments).max(10) as f64;
        let least = 0.95 - 4.0 * (0.95 * 0.05 / records).sqrt();
        assert!(inside / all > least, "{segments}: {}", inside / all);
    }
}

/// Standstills of a channel whose noise is a small part of a step, with moves from one to the next: a standstill has one level or two, changes by one step and is neither
/// stuck nor saturated. (Before: of 300 such standstills 195 were left out at a noise of 0.1 steps, since most runs of equal values are those of the moves.)
#[test]
fn standstills_in_coarse_steps_are_kept_beside_moves() {
    const LENGTH: usize = 300;
    const MOVE: usize = 60;
    const SEGMENTS: usize = 12;
    for noise in [0.05, 0.1, 0.2] {
        let mut random = Pcg64Mcg::seed_from_u64(5);
        let (mut inside, mut all) = (0, 0);
        for _ in 0..12 {
            let levels: Vec<f64> = (0..SEGMENTS).map(|_| uniform(&mut random, -1000.0, 1000.0)).collect();
            let mut values = Vec::new();
            for (k, level) in levels.iter().enumerate() {
                let next = levels[(k + 1) % SEGMENTS];
                let way = (0..MOVE).map(|i| level + (next - level) * i as f64 / MOVE as f64);
                values.extend(std::iter::repeat_n(*level, LENGTH).chain(way));
            }
            let values: Vec<f64> = values.iter().map(|v| (v + noise * normal(&mut random)).round()).collect();
            let at = |k: usize| (k * (LENGTH + MOVE)) as f64 * 0.01;
            let times = (0..SEGMENTS).map(|k| (String::new(), at(k), at(k) + LENGTH as f64 * 0.01));
            let trace = trace(&[values], 0.01);
            let found = segment(&trace, &By::Times(times.collect()), 0.0, 0.0);
            let reduction = reduce(&trace, found, &[None; SEGMENTS]);
            assert!(reduction.rejected.is_empty(), "{noise}: {:?}", reduction.rejected);
            for (mean, level) in reduction.means.iter().flatten().zip(levels) {
                inside += usize::from((mean.value - level).abs() < 1.96 * mean.uncertainty.u);
                all += 1;
            }
        }
        assert_eq!(all, 144);
        // four standard errors of the count below 95 %
        assert!(inside as f64 / 144.0 > 0.95 - 4.0 * (0.95 * 0.05 / 144.0_f64).sqrt(), "{noise}: {inside}");
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
    x.chunks(997).for_each(|part| thin.push(&[part], None));
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

/// The harmonics of a turn are no noise, and what they hide of it is neither lost nor made up: means over turns are covered, also where part of the stretch is missing.
/// (With the harmonics' amplitudes brought down to the power beside them, as it was: 0.57 of one turn whose noise has a correlation time of a fifth of it, 0.47 of flicker.)
/// A walk and a ramp have no level of their own and are none of the descriptions: their rows are printed, and stand beside those of stretches at rest.
#[test]
fn means_over_turns_are_covered() {
    use crate::reduce::{Segment, mean_uncertainties};
    const SEGMENTS: usize = 8;
    const LENGTH: usize = 96;
    let records = draws(4, 1000);
    let kinds = ["white", "0.01", "0.05", "0.2", "flicker", "flicker and white", "walk and white", "ramp and white"];
    println!("{:>18} {:>6} {:>8} {:>8} {:>8}", "noise", "turns", "whole", "broken", "at rest");
    let (mut inside, mut all) = (0.0, 0.0);
    for kind in kinds {
        for turns in [1.0, 2.0, 5.0] {
            let mut random = Pcg64Mcg::seed_from_u64(9000);
            let mut covered = [0.0; 3];
            for _ in 0..records {
                let count = SEGMENTS * LENGTH;
                let white = |random: &mut Pcg64Mcg| -> Vec<f64> { (0..count).map(|_| normal(random)).collect() };
                let sum = |a: Vec<f64>, b: Vec<f64>| a.iter().zip(b).map(|(a, b)| a + b).collect::<Vec<f64>>();
                let half = |a: Vec<f64>| a.into_iter().map(|v| 0.5 * v).collect::<Vec<f64>>();
                let noise: Vec<f64> = match kind {
                    "white" => white(&mut random),
                    "flicker" => flicker(&mut random, count),
                    "flicker and white" => sum(flicker(&mut random, count), half(white(&mut random))),
                    "walk and white" => {
                        let (steps, white) = (white(&mut random), white(&mut random));
                        let mut at = 0.0;
                        let walk = steps.iter().map(|step| {
                            at += 0.02 * step;
                            at
                        });
                        sum(white, walk.collect())
                    }
                    "ramp and white" => white(&mut random)
                        .iter()
                        .enumerate()
                        .map(|(k, v)| v + 3.0 * (k as f64 / count as f64 - 0.5))
                        .collect(),
                    part => {
                        let rest = half(white(&mut random));
                        sum(markov(&mut random, count, part.parse::<f64>().expect("a number") * LENGTH as f64), rest)
                    }
                };
                let own_level = kind.parse::<f64>().is_ok() || kind == "white";
                let level = if own_level { 0.0 } else { noise.iter().sum::<f64>() / count as f64 };
                let turned = noise.iter().enumerate().map(|(k, v)| {
                    let angle = std::f64::consts::TAU * turns * k as f64 / LENGTH as f64;
                    v + 10.0 * angle.sin() + (2.0 * angle).cos() + 0.3 * (3.0 * angle + 1.0).cos()
                });
                let turning = trace(&[turned.collect()], 1.0);
                let resting = trace(&[noise], 1.0);
                // a stretch without 0.4 to 0.55 of it
                let cuts = [[0.0, 1.0, 1.0, 1.0], [0.0, 0.4, 0.55, 1.0], [0.0, 1.0, 1.0, 1.0]];
                for (way, cut) in cuts.iter().enumerate() {
                    let turn_s = (way < 2).then_some(LENGTH as f64 / turns);
                    let from = if way < 2 { &turning } else { &resting };
                    let blocks: Vec<_> = (0..SEGMENTS)
                        .map(|k| {
                            let place = |part: f64| (LENGTH * k) as u64 + (part * LENGTH as f64) as u64;
                            let pieces = [place(cut[0])..place(cut[1]), place(cut[2])..place(cut[3])];
                            let pieces = pieces.into_iter().filter(|own| !own.is_empty()).collect();
                            let segment = Segment { label: k.to_string(), pieces, notes: Vec::new() };
                            from.channels[0].block(from, &segment, turn_s)
                        })
                        .collect();
                    let found = mean_uncertainties(&blocks, count as f64, 0.95);
                    let holds = |(block, found): (&crate::reduce::SegmentBlocks, crate::reduce::MeanUncertainty)| {
                        f64::from(u8::from((block.mean - level).abs() < 1.96 * found.u))
                    };
                    covered[way] += blocks.iter().zip(found).map(holds).sum::<f64>();
                }
            }
            let means = (records * SEGMENTS) as f64;
            let [whole, broken, rest] = covered.map(|held| held / means);
            println!("{kind:>18} {turns:>6} {whole:8.3} {broken:8.3} {rest:8.3}");
            if !kind.starts_with(['w', 'r']) || kind == "white" {
                (inside, all) = (inside + covered[0], all + means);
            }
        }
    }
    let share = inside / all;
    println!("noise that has a description, whole turns: {share:.3}");
    assert!((0.91..=0.98).contains(&share), "{share}");
}

/// What is stuck in a stretch that turns, and what is absent, takes its time: the mean is that over the turns, without the dead samples.
#[test]
fn turns_with_dead_and_absent_samples() {
    use crate::reduce::whole_turns;
    let mut random = Pcg64Mcg::seed_from_u64(31);
    let value = |k: usize| 2.0 + (std::f64::consts::TAU * k as f64 / 500.0).sin();
    let mut values: Vec<f64> = (0..2600).map(|k| value(k) + 1e-4 * normal(&mut random)).collect();
    values[700..900].fill(7.0);
    values[1500..1560].fill(f64::NAN);
    let trace = trace(&[values], 0.01);
    let times = By::Times(vec![("a".into(), 0.0, 26.0)]);
    let mut found = segment(&trace, &times, 0.0, 0.0);
    let turns = whole_turns(&trace, &mut found, &[Some(5.0)]);
    let own = &found.segments[0];
    assert!(own.notes.iter().any(|note| note == "5 whole turns"), "{:?}", own.notes);
    let (start, end) = own.span();
    let lasts = trace.time(end - 1) - trace.time(start) + 0.01;
    assert!((lasts - 25.0).abs() < 0.0101, "{lasts}");
    assert_eq!(own.samples(), 2500 - 200 - 60);
    let mean = reduce(&trace, found, &turns).means[0][0].clone();
    // 1e-4 of noise in 2240 samples
    assert!((mean.value - 2.0).abs() < 4.0 * 1e-4 / 2240_f64.sqrt(), "{mean:?}");
    assert!(mean.uncertainty.u < 1e-5, "{mean:?}");
}
