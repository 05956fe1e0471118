//! Conversions between kinds of numbers, each with the range it takes and what it gives outside: the one place of the library where `as` may
//! shorten a number.
//!
//! A float becomes a count by [`count`] and kin: the fraction is cut off, what is below the range gives its least value, what is above its
//! greatest, and what is not a number 0. Round before where rounding is meant. A count that a size in memory must hold goes through [`index`].
#![allow(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "each function states its range and what it gives outside; the tests below ask both ends"
)]

use rand_pcg::rand_core::Rng;

/// Inputs, readings and uncertainties lie between these, so that squares of quotients of two of them are numbers.
pub(crate) const LEAST: f64 = 1e-70;
pub(crate) const MOST: f64 = 1e70;

/// A decimal has so many places at most; more digits are those of a computation.
const PLACES: usize = 12;

/// Powers of ten, exact.
const UNITS: [f64; PLACES + 1] = [1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12];

/// The last decimal place that values show, as the finest of all; `None` where they have the digits of a computation.
///
/// `0.0614, -0.06` are read to 0.0001: a number that ends in zeros does not show where its digits end, so the finest of all counts.
pub fn resolution(values: impl Iterator<Item = f64>) -> Option<f64> {
    let mut most: Option<usize> = None;
    for value in values.filter(|value| value.is_finite()) {
        // a decimal of at most 14 digits is the shortest that is read as its number
        let written = |places: &usize| {
            // places are those of the list
            let unit = UNITS.get(*places).copied().unwrap_or(f64::NAN);
            let count = (value * unit).round();
            count.abs() < 1e14 && count / unit == value
        };
        let so_far = most.unwrap_or(0);
        most = Some(so_far.max((so_far..=PLACES).chain(0..so_far).find(written)?));
    }
    most.map(|places| 10f64.powi(-signed(places)))
}

/// Whole part of a float as a count: 0 below 1 and for NaN, `usize::MAX` above.
pub(crate) const fn count(x: f64) -> usize {
    x as usize
}

/// Whole part of a float as a number of samples or steps: 0 below 1 and for NaN, `u64::MAX` above.
pub(crate) const fn count_u64(x: f64) -> u64 {
    x as u64
}

/// Whole part of a float with its sign: the ends of `i32` outside, 0 for NaN.
pub(crate) const fn whole(x: f64) -> i32 {
    x as i32
}

/// Whole part of a float with its sign: the ends of `i64` outside, 0 for NaN.
pub(crate) const fn whole_i64(x: f64) -> i64 {
    x as i64
}

/// Place in memory of a place in a file: `usize::MAX`, which no slice holds, where memory's sizes are shorter than the file's.
pub(crate) fn index(place: u64) -> usize {
    usize::try_from(place).unwrap_or(usize::MAX)
}

/// A count as a signed number: `i32::MAX` above.
pub(crate) fn signed(count: usize) -> i32 {
    i32::try_from(count).unwrap_or(i32::MAX)
}

/// A signed number as a count: 0 for what is negative.
pub(crate) fn unsigned(number: i32) -> usize {
    usize::try_from(number).unwrap_or(0)
}

/// A place below `below` (0 for none) from 64 random bits: the high half of their product, uniform to `below / 2^64`.
pub(crate) fn below(bits: u64, below: usize) -> usize {
    ((u128::from(bits) * below as u128) >> 64) as usize
}

/// The lower 32 bits.
#[cfg(feature = "parquet")]
pub(crate) const fn low_half(bits: u64) -> u32 {
    bits as u32
}

/// The nearest number of single precision; infinite above its range.
pub(crate) const fn single(x: f64) -> f32 {
    x as f32
}

/// The middle of some values (of an even number the upper one), which are put in another order; `None` of none.
pub(crate) fn median(values: &mut [f64]) -> Option<f64> {
    let middle = values.len() / 2;
    (!values.is_empty()).then(|| *values.select_nth_unstable_by(middle, f64::total_cmp).1)
}

/// The logarithm of a sum whose terms have these logarithms.
pub(crate) fn log_sum(values: &[f64]) -> f64 {
    let most = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    if most.is_finite() { most + values.iter().map(|v| (v - most).exp()).sum::<f64>().ln() } else { most }
}

/// A list in random order (Fisher and Yates).
pub(crate) fn shuffle<T>(list: &mut [T], rng: &mut rand_pcg::Pcg64Mcg) {
    for k in (1..list.len()).rev() {
        let j = below(rng.next_u64(), k + 1);
        list.swap(k, j);
    }
}

/// A value as it was stated, without what converting its unit left in the last digit.
pub(crate) fn as_stated(value: f64) -> f64 {
    format!("{value:.14e}").parse().unwrap_or(value)
}

/// A number that is null in JSON where it is infinite.
pub(crate) fn or_infinite<'de, D: serde::Deserializer<'de>>(from: D) -> Result<f64, D::Error> {
    Ok(<Option<f64> as serde::Deserialize>::deserialize(from)?.unwrap_or(f64::INFINITY))
}
