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

/// Inputs, readings and uncertainties lie between these, so that squares of quotients of two of them are numbers.
pub(crate) const LEAST: f64 = 1e-70;
pub(crate) const MOST: f64 = 1e70;

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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_of_floats_saturate() {
        let cases = [(3.99, 3), (0.999, 0), (-0.0, 0), (-7.0, 0), (f64::NAN, 0), (f64::NEG_INFINITY, 0)];
        for (x, expected) in cases {
            assert_eq!((count(x), count_u64(x)), (expected, expected as u64), "{x}");
        }
        assert_eq!((count(1e300), count_u64(f64::INFINITY)), (usize::MAX, u64::MAX));
        assert_eq!(count_u64(9_007_199_254_740_992.0), 1 << 53);
    }

    #[test]
    fn whole_parts_keep_their_sign() {
        assert_eq!((whole(-3.99), whole_i64(-3.99)), (-3, -3));
        assert_eq!((whole(1e10), whole(-1e10), whole(f64::NAN)), (i32::MAX, i32::MIN, 0));
        assert_eq!(
            (whole_i64(1e10), whole_i64(1e30), whole_i64(-1e30), whole_i64(f64::NAN)),
            (10_000_000_000, i64::MAX, i64::MIN, 0)
        );
    }

    #[test]
    fn places_that_memory_cannot_hold_are_in_no_slice() {
        assert_eq!(index(17), 17);
        assert_eq!([1, 2, 3].get(index(u64::MAX)), None);
    }

    #[test]
    fn signs_are_kept_within_range() {
        assert_eq!((signed(0), signed(12), signed(usize::MAX)), (0, 12, i32::MAX));
        assert_eq!((unsigned(-1), unsigned(i32::MIN), unsigned(0), unsigned(9)), (0, 0, 0, 9));
    }

    #[test]
    fn draws_stay_below_their_end() {
        assert_eq!((below(u64::MAX, 6), below(0, 6), below(u64::MAX, 1), below(u64::MAX, 0)), (5, 0, 0, 0));
        // the bits cut [0, 2^64) into `below` equal parts
        assert_eq!((below((1 << 63) - 1, 2), below(1 << 63, 2)), (0, 1));
        assert_eq!(below(u64::MAX, usize::MAX), usize::MAX - 1);
    }

    #[cfg(feature = "parquet")]
    #[test]
    fn lower_bits_are_kept() {
        assert_eq!((low_half(0x1_2345_6789), low_half(7)), (0x2345_6789, 7));
    }

    #[test]
    fn singles_are_the_nearest() {
        assert_eq!((single(0.1), single(1e300)), (0.1_f32, f32::INFINITY));
    }
}
