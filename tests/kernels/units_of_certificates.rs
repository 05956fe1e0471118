//! Units in the notation of D-SI.

#[path = "../../src/report/dcc/units.rs"]
mod notation;

use notation::d_si;

#[test]
fn units_have_their_d_si_names() {
    assert_eq!(d_si(&["V"]), "\\volt");
    assert_eq!(d_si(&["V/(deg/s)"]), "\\volt\\degree\\tothe{-1}\\second");
    assert_eq!(d_si(&["deg/s/V"]), "\\degree\\second\\tothe{-1}\\volt\\tothe{-1}");
    assert_eq!(d_si(&["V/(deg/s)^2"]), "\\volt\\degree\\tothe{-2}\\second\\tothe{2}");
    assert_eq!(d_si(&["deg/h/(deg/h)"]), "\\one");
    assert_eq!(d_si(&["1/s"]), "\\second\\tothe{-1}");
    assert_eq!((d_si(&[""]), d_si(&["1"]), d_si(&["g/g^2"])), ("\\one".into(), "\\one".into(), "|g/g^2".into()));
    assert_eq!(d_si(&["(((("]), "|((((");
}

#[test]
fn covariances_have_the_product_of_units() {
    assert_eq!(d_si(&["rad", "rad"]), "\\radian\\tothe{2}");
    assert_eq!(d_si(&["V", "rad"]), "\\volt\\radian");
    assert_eq!(d_si(&["1", "V"]), "\\volt");
    assert_eq!(d_si(&["V/s", "rad"]), "\\volt\\second\\tothe{-1}\\radian");
    assert_eq!(d_si(&["V/g", "V"]), "|(V/g)*V");
}

/// Names by PTB's package dsiUnits (tests/scripts/dsi_units.py).
#[test]
fn units_are_those_of_the_package() {
    let list = include_str!("../data/lab/dsi_units.csv");
    assert!(list.lines().count() > 1000);
    for line in list.lines().skip(1) {
        let (unit, name) = line.split_once(',').unwrap();
        assert_eq!(d_si(&[unit]), name, "{unit}");
    }
}
