//! Determinations of one quantity, two of them and many: by hand.

use nalgebra::DMatrix;
use tumble::compare::calibrations::{Determination, Quantity, changes, day_number, trends};
use tumble::report::date_of;

fn one(value: f64, u: f64, dof: f64) -> Determination {
    let quantity = Quantity { id: "k".into(), unit: "V".into(), value, u: Some(u), dof, inputs: Vec::new() };
    Determination {
        quantities: vec![quantity],
        covariance: DMatrix::from_element(1, 1, u * u),
        ..Determination::default()
    }
}

#[test]
fn two_values_by_hand() {
    let found = changes(&one(1.0, 0.3, f64::INFINITY), &one(2.0, 0.4, f64::INFINITY), 0.95, true);
    let judged = &found.changes[0];
    assert!((judged.u.unwrap() - 0.5).abs() < 1e-15 && (judged.birge.unwrap() - 2.0).abs() < 1e-15);
    // k = 1.959964 (normal), E_n = 1/(1.959964*0.5)
    assert!((judged.e_n.unwrap() - 1.0 / 0.979_981_992_270_027).abs() < 1e-12);
    assert!((judged.combined.unwrap() - (1.0 / 0.09 + 2.0 / 0.16) / (1.0 / 0.09 + 1.0 / 0.16)).abs() < 1e-14);
    assert!((judged.u_combined.unwrap() - 0.24).abs() < 1e-15);
    assert!(judged.significant == Some(true) && (found.together.unwrap().statistic - 4.0).abs() < 1e-12);
}

#[test]
fn a_line_through_four_years() {
    let days = [0.0, 365.0, 730.0, 1095.0];
    let all: Vec<Determination> =
        days.iter().map(|d| Determination { day: Some(*d), ..one(10.0 + 0.01 * d, 0.1, 9.0) }).collect();
    let line = &trends(&all, 0.95, &|_| Some([0.0, 30.0]))[0];
    assert!((line.per_day.unwrap() - 0.01).abs() < 1e-15 && line.significant == Some(true));
    // u(slope) = 0.1 / sqrt(sum (t - mean)^2), sum = 365^2 * 5
    assert!((line.u_per_day.unwrap() - 0.1 / (365.0 * 5f64.sqrt())).abs() < 1e-15);
    assert!((line.leaves.unwrap() - 2000.0).abs() < 1e-9);
}

/// 0, 1, 2 at days 0, 100, 200: the line left 1.5 at day 150, leaves 3 at day 300, and never -1.
#[test]
fn the_day_on_which_limits_were_left_may_be_past() {
    let determined = [(0.0, 0.0), (100.0, 1.0), (200.0, 2.001)].map(|(day, value)| Determination {
        name: day.to_string(),
        day: Some(day),
        ..one(value, 0.01, f64::INFINITY)
    });
    let trend = |limits: [f64; 2]| trends(&determined, 0.95, &|_| Some(limits)).remove(0);
    let (left, leaves) = (trend([-1.0, 1.5]), trend([-1.0, 3.0]));
    assert!(left.has_left() && (left.leaves.unwrap() - 150.0).abs() < 1.0);
    assert!(!leaves.has_left() && (leaves.leaves.unwrap() - 300.0).abs() < 1.0);
}

#[test]
fn dates_go_there_and_back() {
    for date in ["1970-01-01", "2000-02-29", "2026-11-21", "1999-12-31", "2100-03-01"] {
        assert_eq!(date_of(day_number(date).unwrap()), date);
    }
}
