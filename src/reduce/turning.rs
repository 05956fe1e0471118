//! What repeats with a turn, and the noise that is left: nothing is taken for noise at the harmonics of the turn, where the sensor's input stands.
//!
//! The input of a sensor on a turning table is an unknown multiple of each of the first harmonics of the joint's angle, and of higher ones where the samples show them. The level of a stretch is
//! that of least squares with these harmonics (over whole turns: the mean of the samples). The noise's likelihood is the restricted one: that of the
//! contrasts which are free of the level and of the harmonics, whatever their amplitudes. So the power of the noise at the harmonics is neither
//! lost nor guessed; that it is not seen widens what is known of the noise.

use super::innovations::{Process, Products};
use crate::elements::Elements;
use crate::linear::{Triangle, dot, normalise, project};
use crate::uncertainty::quantiles::fisher_f_survival;
use std::f64::consts::TAU;

/// Harmonics of the turn that are free in any case: those that the angles between axes, their squares (centripetal terms, two misalignments) and three angles in a
/// row give.
const ALWAYS: usize = 3;
/// The highest that is looked for, a choice that bounds the work; and the frequencies beside a harmonic whose power says what noise is there: eight tell it to a
/// third (chi-square with sixteen degrees of freedom).
const HIGHEST: usize = 12;
const BESIDE: usize = 8;
/// A harmonic above those that are free in any case is there where chance makes so large a power in fewer cases than this: of nine harmonics in each of a hundred
/// segments a false one in about eleven records, which costs its mean two degrees of freedom.
const CHANCE: f64 = 1e-4;
/// A wave whose part outside the level and the other waves is below this share of it is none of its own: rounding, the root of the machine precision.
const OWN: f64 = 1.5e-8;
/// Columns that differ by less are the same: the rounding of times.
const SAME: f64 = 1e-9;

/// Waves of the harmonics of angles (in turns, from where the first stands), each value a mean over `wide` of them.
fn waves(angles: &[f64], harmonics: usize, wide: usize) -> Vec<Vec<f64>> {
    let first = angles.first().copied().unwrap_or(0.0); // of no angles: no waves
    let mut columns = vec![Vec::with_capacity(angles.len() / wide.max(1)); 2 * harmonics];
    for own in angles.chunks_exact(wide) {
        let mut sums = vec![0.0; 2 * harmonics];
        for turns in own {
            sums.iter_mut().zip(row(turns - first, harmonics).skip(1)).for_each(|(sum, wave)| *sum += wave);
        }
        columns.iter_mut().zip(sums).for_each(|(column, sum)| column.push(sum / wide as f64));
    }
    columns
}

/// One, and the waves of each harmonic at an angle in turns.
fn row(turns: f64, harmonics: usize) -> impl Iterator<Item = f64> {
    let waves = move |order: usize| {
        let (s, c) = (TAU * order as f64 * turns).sin_cos();
        [c, s]
    };
    std::iter::once(1.0).chain((1..=harmonics).flat_map(waves))
}

/// Takes the harmonics of the turn out of the pieces of one stretch, together. Gives the level, how much larger the standard deviation of it is than that of the
/// mean, for noise without memory (1 over whole turns), and the highest harmonic that was taken out.
pub(super) fn without_turn(pieces: &mut [Vec<f64>], angles: &[Vec<f64>]) -> (f64, f64, usize) {
    let (level, above) = without(pieces, angles, ALWAYS);
    let harmonics = highest(pieces, angles);
    let (level, above) = if harmonics > ALWAYS { without(pieces, angles, harmonics) } else { (level, above) };
    (level, above, harmonics)
}

/// The same with so many harmonics.
fn without(pieces: &mut [Vec<f64>], angles: &[Vec<f64>], harmonics: usize) -> (f64, f64) {
    let count = 2 * harmonics + 1;
    let n = pieces.iter().map(Vec::len).sum::<usize>().max(1) as f64;
    let mean = pieces.iter().flatten().sum::<f64>() / n;
    let first = angles.iter().flatten().next().copied().unwrap_or(0.0); // of no angles: no harmonics
    let mut products = vec![vec![0.0; count]; count + 1];
    let mut own = Vec::with_capacity(count + 1);
    for (turns, v) in angles.iter().flatten().zip(pieces.iter().flatten()) {
        own.clear();
        own.extend(row(turns - first, harmonics).chain([v - mean]));
        for (a, sums) in own.iter().zip(&mut products) {
            sums.iter_mut().zip(&own).for_each(|(sum, b)| *sum += a * b);
        }
    }
    let entry = |i: usize, j: usize| products.get(i).and_then(|own| own.get(j)).copied().unwrap_or(f64::NAN);
    let of = |kept: &[usize]| {
        Triangle::of(kept.len(), |i, j| entry(kept.at(i), kept.at(j)), |i| OWN * entry(kept.at(i), kept.at(i)))
    };
    let mut kept: Vec<usize> = Vec::new();
    for k in 0..count {
        kept.push(k);
        if of(&kept).is_none() {
            kept.pop();
        }
    }
    // without blocks there is no level
    let Some(triangle) = of(&kept).filter(|_| kept.first() == Some(&0)) else { return (mean, 1.0) };
    let right: Vec<f64> = kept.iter().map(|k| entry(count, *k)).collect();
    let found = triangle.solve(&right);
    let mut amplitudes = vec![0.0; count];
    for (k, amplitude) in kept.iter().zip(&found).skip(1) {
        amplitudes.iter_mut().skip(*k).take(1).for_each(|own| *own = *amplitude);
    }
    for (turns, v) in angles.iter().flatten().zip(pieces.iter_mut().flatten()) {
        *v -= row(turns - first, harmonics).zip(&amplitudes).map(|(wave, amplitude)| amplitude * wave).sum::<f64>();
    }
    let variance = triangle.inverse().first().and_then(|own| own.first()).copied().unwrap_or(f64::NAN);
    (mean + found.first().copied().unwrap_or(f64::NAN), (variance * n).sqrt())
}

/// The highest harmonic in values from which those are taken that are there in any case: the first from above whose power stands out of that at frequencies beyond it.
///
/// These lie half-way between harmonics; within one turn, whose spectrum does not part those, they are the harmonics themselves.
fn highest(pieces: &[Vec<f64>], angles: &[Vec<f64>]) -> usize {
    const HALVES: usize = 2 * (HIGHEST + BESIDE);
    let n = pieces.iter().map(Vec::len).sum::<usize>();
    let mean = pieces.iter().flatten().sum::<f64>() / n.max(1) as f64;
    let all = || angles.iter().flatten();
    let first = all().next().copied().unwrap_or(0.0); // of no angles: no harmonics
    let turns = (all().next_back().copied().unwrap_or(0.0) - first).abs();
    // sums of the values with the waves of half a turn, one turn, three halves, ...
    let mut sums = [(0.0, 0.0); HALVES + 1];
    for (turns, v) in all().zip(pieces.iter().flatten()) {
        let (s, c) = (0.5 * TAU * (turns - first)).sin_cos();
        let mut wave = (v - mean, 0.0);
        for (a, b) in &mut sums {
            (*a, *b) = (*a + wave.0, *b + wave.1);
            wave = (wave.0 * c - wave.1 * s, wave.0 * s + wave.1 * c);
        }
    }
    // frequencies that the values resolve
    let resolved = 0.9 * n as f64 / turns.max(0.5);
    let power = |half: usize| sums.get(half).filter(|_| (half as f64) < resolved).map(|(a, b)| a * a + b * b);
    let stands_out = |order: &usize| {
        let places = (0..BESIDE).map(|k| if turns < 1.5 { 2 * (k + 1) } else { 2 * k + 1 });
        let beside: Vec<f64> = places.filter_map(|k| power(2 * order + k)).collect();
        let noise = beside.iter().sum::<f64>() / beside.len().max(1) as f64;
        let ratio = power(2 * order).map_or(0.0, |own| own / noise);
        // nothing beside it, or no noise: it cannot be told
        beside.len() > 1
            && fisher_f_survival(ratio, 2.0, 2.0 * beside.len() as f64).is_some_and(|chance| chance < CHANCE)
    };
    (ALWAYS + 1..=HIGHEST).rev().find(stands_out).unwrap_or(ALWAYS)
}

/// Harmonics of a piece of a stretch: those of a longer piece that begins like it stand for it, too.
#[derive(Debug, Clone)]
pub(super) struct Turned {
    /// Which of the columns.
    design: usize,
    /// Which of them are its own.
    kept: Vec<usize>,
}

impl Turned {
    /// What is known of the noise: its values less the level and the harmonics.
    pub fn contrasts(&self, values: usize) -> usize {
        values.saturating_sub(1 + self.kept.len())
    }
}

/// Columns of harmonics, each once.
#[derive(Debug, Default)]
pub(super) struct Designs(Vec<Vec<Vec<f64>>>);

impl Designs {
    /// So many harmonics of a piece whose angles are these, in means over `wide`.
    pub fn of(&mut self, angles: &[f64], harmonics: usize, wide: usize) -> Turned {
        let columns = waves(angles, harmonics, wide);
        let mut ones = vec![1.0; columns.first().map_or(0, Vec::len)];
        normalise(&mut ones);
        let mut basis = vec![ones];
        let mut kept = Vec::new();
        for (k, column) in columns.iter().enumerate() {
            let mut apart = column.clone();
            let before = normalise(&mut apart);
            project(&mut apart, &basis);
            let left = normalise(&mut apart);
            // of a mean over whole periods rounding is left
            if before > OWN && left > OWN {
                project(&mut apart, &basis);
                normalise(&mut apart);
                basis.push(apart);
                kept.push(k);
            }
        }
        let alike = |(own, other): (&Vec<f64>, &Vec<f64>)| own.iter().zip(other).all(|(a, b)| (a - b).abs() < SAME);
        let found = self.0.iter().position(|own| own.len() == columns.len() && own.iter().zip(&columns).all(alike));
        let design = found.unwrap_or(self.0.len());
        match self.0.get_mut(design) {
            // the longer stands for both
            Some(own) if own.first().map(Vec::len) < columns.first().map(Vec::len) => *own = columns,
            Some(_) => {}
            None => self.0.push(columns),
        }
        Turned { design, kept }
    }

    /// What a process does not foretell of them.
    pub fn innovations(&self, process: &Process) -> Vec<Vec<Vec<f64>>> {
        self.0.iter().map(|own| own.iter().map(|column| process.whitened(column)).collect()).collect()
    }
}

/// The sums of a piece whose level and harmonics are free: of what stands outside these. `one` is 1, and `log` has the determinant of all of them.
pub(super) fn products(process: &Process, values: &[f64], turned: &Turned, columns: &[Vec<Vec<f64>>]) -> Products {
    let n = values.len();
    let (mut basis, mut log): (Vec<Vec<f64>>, f64) = (Vec::with_capacity(1 + turned.kept.len()), process.log(n));
    let own = columns.get(turned.design).map(Vec::as_slice).unwrap_or_default();
    let kept = turned.kept.iter().filter_map(|k| own.get(*k)?.get(..n).map(<[f64]>::to_vec));
    let (constant, ramp) = process.whitened_line(n);
    for mut column in std::iter::once(constant).chain(kept) {
        project(&mut column, &basis);
        // its length, squared, is its part of the determinant
        log += 2.0 * normalise(&mut column).max(f64::MIN_POSITIVE).ln();
        project(&mut column, &basis);
        normalise(&mut column);
        basis.push(column);
    }
    let free = |mut own: Vec<f64>| {
        project(&mut own, &basis);
        project(&mut own, &basis);
        own
    };
    let (x, t) = (free(process.whitened(values)), free(ramp));
    Products { xx: dot(&x, &x), xt: dot(&x, &t), tt: dot(&t, &t), one: 1.0, log, ..Products::default() }
}
