//! Floats that become counts, and long numbers that become short ones.

use crate::number::{below, count, count_u64, index, low_half, signed, single, unsigned, whole, whole_i64};

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

#[test]
fn lower_bits_are_kept() {
    assert_eq!((low_half(0x1_2345_6789), low_half(7)), (0x2345_6789, 7));
}

#[test]
fn singles_are_the_nearest() {
    assert_eq!((single(0.1), single(1e300)), (0.1_f32, f32::INFINITY));
}
