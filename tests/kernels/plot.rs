//! Axes of charts.

#[path = "../../src/document/plot/scale.rs"]
mod scale;

use scale::{exponent, label, ticks, title};

#[test]
fn ticks_are_round_and_inside() {
    assert_eq!(ticks(-200.0, 100.0, 6), (vec![-200.0, -150.0, -100.0, -50.0, 0.0, 50.0, 100.0], 0));
    assert_eq!(ticks(0.0, 0.35, 4).0.len(), 4);
    assert_eq!(label(-0.0, 1), "0.0");
    assert_eq!(label(-1.25, 2), "\u{2212}1.25");
}

#[test]
fn powers_are_named() {
    assert_eq!(title("residual", "V", exponent([2.3e-4].into_iter())), "residual, 10\u{207b}\u{2076} V");
    assert_eq!(title("residual", "", 0), "residual");
    assert_eq!(exponent([f64::NAN, 0.0].into_iter()), 0);
}
