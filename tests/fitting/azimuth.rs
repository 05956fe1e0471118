//! The azimuth of a misalignment, `atan2(y, x)`: its interval against brute force, its coverage against an independent Monte Carlo
//! (tests/scripts/azimuth.py), and what a fit says of one near zero.

use crate::draws;
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64Mcg;
use std::f64::consts::{PI, TAU};
use tumble::fit::{self, Sector, Settings, sector};
use tumble::language::Language;
use tumble::report::{self, FitReport};
use tumble::wire;

/// Rows of a file of tests/data/azimuth, as numbers; NaN where there is none.
fn rows(name: &str) -> Vec<Vec<f64>> {
    let path = format!("{}/tests/data/azimuth/{name}", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(path).expect("a file");
    text.lines().skip(1).map(|line| line.split(',').map(|cell| cell.parse().unwrap_or(f64::NAN)).collect()).collect()
}

#[test]
fn sectors_are_those_found_by_brute_force() {
    let all = rows("sectors.csv");
    assert_eq!(all.len(), 189);
    let mut circles = 0;
    for row in all {
        let &[x, y, xx, xy, yy, nu, level, low, high] = row.as_slice() else { panic!("{row:?}") };
        match sector((x, y), [xx, xy, yy], nu, level).expect("a sector") {
            Sector::Circle => {
                assert!(low.is_nan(), "{row:?}");
                circles += 1;
            }
            Sector::Between(a, b) => {
                // both bisect or solve to rounding; quantiles of both are good to 1e-9
                assert!((a - low).abs() < 1e-7 && (b - high).abs() < 1e-7, "{row:?}: {a} {b}");
                let value = y.atan2(x);
                assert!(a <= value && value <= b);
            }
        }
    }
    assert!(circles > 20, "{circles}");
}

#[test]
fn sectors_cover_what_an_independent_monte_carlo_says() {
    let draws = draws::draws(4_000, 200_000);
    let mut random = Pcg64Mcg::new(20120);
    let mut normal = || -> f64 { StandardNormal.sample(&mut random) };
    println!("r/u    nu    coverage  (script)   circle  (script)");
    for row in rows("coverage.csv") {
        let &[r, nu, coverage, circle] = row.as_slice() else { panic!("{row:?}") };
        let (mut held, mut whole) = (0, 0);
        for _ in 0..draws {
            // turned by 2 rad, so that the cut at 180 degrees is not where the truth is
            let truth: f64 = 2.0;
            let (x, y) = (r * truth.cos() + normal(), r * truth.sin() + normal());
            let variance = match nu.is_finite() {
                true => (0..nu as usize).map(|_| normal().powi(2)).sum::<f64>() / nu,
                false => 1.0,
            };
            match sector((x, y), [variance, 0.0, variance], nu, 0.95) {
                Some(Sector::Circle) => {
                    held += 1;
                    whole += 1;
                }
                Some(Sector::Between(low, high)) => held += usize::from((truth - low).rem_euclid(TAU) <= high - low),
                None => panic!("no sector"),
            }
        }
        let shares = [held, whole].map(|n| n as f64 / draws as f64);
        println!("{r:4}  {nu:4}  {:.4}    {coverage:.4}     {:.4}  {circle:.4}", shares[0], shares[1]);
        let near = |share: f64, of: f64| {
            let sd = (of.clamp(0.002, 0.998) * (1.0 - of.clamp(0.002, 0.998)) * (1.0 / draws as f64 + 1.0 / 200_000.0))
                .sqrt();
            (share - of).abs() < 4.5 * sd
        };
        assert!(near(shares[0], coverage) && near(shares[1], circle), "{row:?}: {shares:?}");
        assert!(coverage > 0.949, "an interval that does not hold what it says: {row:?}");
    }
}

/// A report of two components read four times each with u = 2, and of their azimuth in degrees.
fn fitted(x: f64, y: f64) -> FitReport {
    let text = format!(
        r#"{{ "bench": {{ "id": "two", "sensors": {{ "X": {{ "unit": "urad", "model": "a" }}, "Y": {{ "unit": "urad", "model": "b" }} }} }},
            "estimate": {{ "a": {{ "unit": "urad" }}, "b": {{ "unit": "urad" }} }},
            "derived": {{ "azimuth": {{ "line": "atan2(b, a)", "unit": "deg" }} }},
            "readings": [ {{ "X": {x}, "X_u": 1, "Y": {y}, "Y_u": 1 }}, {{ "X": {x}, "X_u": 1, "Y": {y}, "Y_u": 1 }} ] }}"#
    );
    let source = wire::Source { name: "azimuth".into(), text };
    let campaign = wire::read_campaign(&source, &mut |_| unreachable!()).expect("a campaign");
    report::fit_report(&fit::fit(&campaign, &Settings::default()).expect("a fit"))
}

#[test]
fn far_from_zero_the_azimuth_has_value_and_expanded_uncertainty() {
    let report = fitted(-300.0, 400.0);
    let azimuth = &report.derived[0];
    // u of each component is 1/sqrt 2, so u of the angle is that over 500
    let u = (0.5f64.sqrt() / 500.0).to_degrees();
    assert!((azimuth.value.unwrap() - 400f64.atan2(-300.0).to_degrees()).abs() < 1e-10);
    assert!((azimuth.combined.u.unwrap() / u - 1.0).abs() < 1e-9, "{azimuth:?}");
    let [low, high] = azimuth.interval.unwrap();
    assert!((0.5 * (high - low) / azimuth.combined.expanded.unwrap() - 1.0).abs() < 1e-5);
    assert!(azimuth.note.is_none());
}

#[test]
fn near_zero_the_azimuth_is_any() {
    let report = fitted(0.4, -0.7);
    let azimuth = &report.derived[0];
    // 0.4^2 + 0.7^2 is below 5.99/2: the origin is inside the joint ellipse
    let value = (-0.7f64).atan2(0.4).to_degrees();
    assert!((azimuth.value.unwrap() - value).abs() < 1e-10);
    assert_eq!(azimuth.interval.map(|ends| ends.map(|end| (end - value).round())), Some([-180.0, 180.0]));
    assert!((azimuth.combined.u.unwrap() - PI.to_degrees() / 3f64.sqrt()).abs() < 1e-9);
    assert!((azimuth.combined.expanded.unwrap() - 180.0).abs() < 1e-9);
    // whatever line they are broken in
    let told = |language| {
        tumble::document::terminal::brief(&tumble::report::fit_document(&report, &Default::default(), language))
            .split_whitespace()
            .collect::<String>()
    };
    let (english, chinese) = (told(Language::English), told(Language::Chinese));
    assert!(english.contains("theintervalisthefullcircle"), "{english}");
    assert!(chinese.contains("区间为整个圆周"), "{chinese}");
}

#[test]
fn between_the_two_the_interval_is_told_where_it_is_not_symmetric() {
    // 3 u away, u_x = u_y: asin(1.96/3) is 40.8 deg where the first order says 37.4
    let report = fitted(3.0 / 2f64.sqrt(), 0.0);
    let azimuth = &report.derived[0];
    let [low, high] = azimuth.interval.unwrap();
    let half = (1.959_963_984_540_054f64 / 3.0).asin().to_degrees();
    assert!((high - half).abs() < 1e-6 && (low + half).abs() < 1e-6, "{low} {high} {half}");
    assert!(azimuth.note.as_ref().is_some_and(|note| note.to_string().contains("95 % interval")), "{azimuth:?}");
}
