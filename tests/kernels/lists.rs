//! Elements of lists, and the linear algebra of short ones.

use crate::elements::{Elements, Parts};
use crate::linear::{Triangle, dot, norm, normalise, orthonormal, project, short_dot};

#[cfg(not(debug_assertions))]
#[test]
fn what_is_outside_is_never_a_plausible_number() {
    let (numbers, places, lists) = (vec![1.5, 2.5], vec![7_usize], vec![vec![3.0]]);
    assert_eq!((numbers.at(1), places.at(0), lists.at(0).at(0)), (2.5, 7, 3.0));
    assert!(
        numbers.at(2).is_nan() && lists.at(1).is_empty() && lists.at(1).at(0).is_nan() && lists.at(0).at(1).is_nan()
    );
    assert_eq!(places.at(1), usize::MAX);
    assert_eq!((numbers.part(1..), numbers.part(..3), numbers.part(3..)), (&[2.5][..], &[][..], &[][..]));
}

#[test]
fn products_of_all_lengths() {
    // 1^2 + ... + n^2 = n (n + 1) (2 n + 1) / 6, exact in these sizes
    for n in [0_u32, 1, 7, 8, 9, 31] {
        let a: Vec<f64> = (1..=n).map(f64::from).collect();
        assert_eq!(dot(&a, &a), f64::from(n * (n + 1) * (2 * n + 1) / 6), "{n}");
    }
    assert_eq!(dot(&[1.0, 2.0, 3.0], &[4.0, 5.0]), 14.0);
    let a: Vec<f64> = (1..=31).map(f64::from).collect();
    assert_eq!(short_dot(&a, &a), dot(&a, &a));
    assert_eq!(norm(&[3.0, 4.0]), 5.0);
}

#[test]
fn a_column_of_zeros_has_no_direction() {
    let (mut zero, mut own) = ([0.0; 3], [0.0, 3.0, 4.0]);
    assert_eq!((normalise(&mut zero), zero), (0.0, [0.0; 3]));
    assert_eq!((normalise(&mut own), own), (5.0, [0.0, 0.6, 0.8]));
    let mut left = [1.0, 2.0, 3.0];
    project(&mut left, &[[0.0, 1.0, 0.0], [1.0, 0.0, 0.0]]);
    assert_eq!(left, [0.0, 0.0, 3.0]);
}

/// `[[25, 15, -5], [15, 18, 0], [-5, 0, 11]] = L L'` with rows (5), (3, 3), (-1, 1, 3): the usual textbook example, in whole numbers.
#[test]
fn cholesky_in_whole_numbers() {
    let c = [[25.0, 15.0, -5.0], [15.0, 18.0, 0.0], [-5.0, 0.0, 11.0]];
    let triangle = Triangle::of(3, |i, j| c[i][j], |_| 0.0).unwrap();
    assert!((triangle.log_determinant() - 2025_f64.ln()).abs() < 1e-14);
    // L (1, 2, 3)' = (5, 9, 10)'
    let mut ahead = [5.0, 9.0, 10.0];
    triangle.forward(&mut ahead);
    assert_eq!(ahead, [1.0, 2.0, 3.0]);
    // L' (1, 2, 3)' = (8, 9, 9)'
    let mut back = [8.0, 9.0, 9.0];
    triangle.backward(&mut back);
    assert_eq!(back, [1.0, 2.0, 3.0]);
    // C (1, 2, 3)' = (40, 51, 28)'
    let mut x = triangle.solve(&[40.0, 51.0, 28.0]);
    x.iter_mut().zip([1.0, 2.0, 3.0]).for_each(|(x, expected)| *x -= expected);
    assert!(x.iter().all(|left| left.abs() < 1e-14), "{x:?}");
    // adjugate over the determinant
    let inverse = [[198.0, -165.0, 90.0], [-165.0, 250.0, -75.0], [90.0, -75.0, 225.0]];
    for (own, expected) in triangle.inverse().iter().flatten().zip(inverse.iter().flatten()) {
        assert!((own - expected / 2025.0).abs() < 1e-16);
    }
    let upper = Triangle::of_upper(3, |i, j| [[5.0, 3.0, -1.0], [0.0, 3.0, 1.0], [0.0, 0.0, 3.0]][i][j]);
    assert_eq!(upper.inverse(), triangle.inverse());
}

#[test]
fn a_matrix_that_is_not_positive_definite_has_no_triangle() {
    let singular = [[1.0, 1.0], [1.0, 1.0]];
    assert!(Triangle::of(2, |i, j| singular[i][j], |_| 0.0).is_none());
    assert!(Triangle::of(1, |_, _| f64::NAN, |_| 0.0).is_none());
    assert!(Triangle::of(2, |i, j| if i == j { 1.0 } else { 1.0 - 1e-9 }, |_| 1e-6).is_none());
}

#[test]
fn directions_in_the_span_of_earlier_ones_are_left_out() {
    let columns = vec![vec![2.0, 0.0, 0.0], vec![0.0; 3], vec![1.0, 0.0, 0.0], vec![1.0, 0.0, 3.0]];
    assert_eq!(orthonormal(columns, 1e-9), [vec![1.0, 0.0, 0.0], vec![0.0, 0.0, 1.0]]);
}
