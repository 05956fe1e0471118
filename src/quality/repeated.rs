//! Rows that stand several times, digit for digit.

use super::ALPHA;
use crate::number::resolution;
use std::collections::HashMap;
use std::f64::consts::PI;

/// Rows that were probably entered more than once.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Repeated {
    /// Every row occurs at least so many times.
    All(usize),
    /// So many rows in order repeat the rows from `first` on, from row `again` on (from 0).
    Block {
        /// The first row that is repeated.
        first: usize,
        /// Where the repetition begins.
        again: usize,
        /// How many rows.
        rows: usize,
    },
}

/// Rows that repeat others; each row is what was set and what was read there, as hashes, `value(row, sensor)` a value that was read.
///
/// Chance does not repeat every row. Several rows in their order it repeats where readings are coarse: two readings of standard deviation `s` at one setting, given in steps of
/// `q`, agree with probability `q/(2 sqrt(pi) s)`, the density of their difference at zero times the step.
pub(crate) fn repeated(
    rows: &[(u64, u64)],
    sensors: usize,
    value: impl Fn(usize, usize) -> Option<f64>,
) -> Option<Repeated> {
    let mut sorted = rows.to_vec();
    sorted.sort_unstable();
    if sorted.windows(2).all(|pair| pair.first() != pair.last()) {
        return None;
    }
    let occurs = sorted.chunk_by(|a, b| a == b).map(<[_]>::len);
    let times = occurs.clone().min().filter(|times| *times > 1 && occurs.count() > 1);
    if let Some(times) = times {
        return Some(Repeated::All(times));
    }
    let mut before: HashMap<(u64, u64), usize> = HashMap::with_capacity(rows.len());
    let (mut longest, mut run) = (None::<(usize, usize, usize)>, None::<(usize, usize, usize)>);
    for (k, row) in rows.iter().enumerate() {
        run = match (before.insert(*row, k), run) {
            (Some(twin), Some((first, again, count))) if twin == first + count => Some((first, again, count + 1)),
            (Some(twin), _) => Some((twin, k, 1)),
            (None, _) => None,
        };
        let longer = |(.., count): &(usize, usize, usize)| longest.is_none_or(|(.., most)| *count > most);
        longest = run.filter(longer).or(longest);
    }
    let (first, again, count) = longest?;
    let others: Vec<usize> = (0..rows.len()).filter(|k| !(again..again + count).contains(k)).collect();
    let alike = (0..sensors).filter_map(|sensor| chance(rows, &others, |row| value(row, sensor))).reduce(f64::min)?;
    let by_chance = rows.len() as f64 * alike.powi(i32::try_from(count).unwrap_or(i32::MAX));
    (by_chance < ALPHA).then_some(Repeated::Block { first, again, rows: count })
}

/// With which probability two readings of a sensor at one setting are the same; `None` where no two differ.
fn chance(rows: &[(u64, u64)], among: &[usize], value: impl Fn(usize) -> Option<f64>) -> Option<f64> {
    let mut sorted: Vec<f64> = among.iter().filter_map(|row| value(*row)).collect();
    sorted.sort_by(f64::total_cmp);
    // of counts that were scaled, whose digits are those of a computation, no two values are nearer than a step
    let nearest = || {
        let apart = sorted.iter().zip(sorted.iter().skip(1)).map(|(a, b)| b - a);
        apart.filter(|apart| *apart > 0.0).fold(f64::INFINITY, f64::min)
    };
    let step = resolution(sorted.iter().copied()).unwrap_or_else(nearest);
    let mut last: HashMap<u64, f64> = HashMap::new();
    let (mut squares, mut pairs) = (0.0, 0_u32);
    for row in among {
        let (Some((set, _)), Some(x)) = (rows.get(*row), value(*row)) else { continue };
        if let Some(before) = last.insert(*set, x)
            && before != x
        {
            squares += (before - x) * (before - x);
            pairs += 1;
        }
    }
    let sd = (squares / (2.0 * f64::from(pairs))).sqrt();
    (pairs > 0).then(|| (0.5 * step / (PI.sqrt() * sd)).min(1.0))
}
