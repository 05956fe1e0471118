//! Per rate and per run the papers' closed forms are the square special case of least squares.

use crate::support::*;
use tumble::compare::{self, Comparison};
use tumble::fit;

fn compared(name: &str) -> Comparison {
    let campaign = campaign(name);
    let forms = compare::closed_forms(&campaign.bench.id).expect("closed forms");
    compare::compare(&campaign, &forms, &fit::Settings::default()).expect("a comparison")
}

/// Largest relative difference of two columns, over all groups and quantities.
fn largest(comparison: &Comparison, other: impl Fn(&compare::GroupComparison) -> Vec<Option<f64>>) -> f64 {
    let mut largest: f64 = 0.0;
    for group in &comparison.groups {
        for (closed, other) in group.closed_form.iter().zip(other(group)) {
            let (closed, other) = (closed.expect("a closed form"), other.expect("an estimate"));
            largest = largest.max(((closed - other) / closed).abs());
        }
    }
    largest
}

#[test]
fn least_squares_per_group_is_the_closed_form() {
    for (name, groups) in [("li2012/li2012-table1.campaign.json", 3), ("li2012/li2012-table2.campaign.json", 3)] {
        let comparison = compared(name);
        assert_eq!(comparison.groups.len(), groups);
        let difference = largest(&comparison, |group| group.like_for_like.clone());
        println!("{name}: largest relative difference without Earth rate {difference:.1e}");
        assert!(difference < 1e-12, "{name}: {difference:e}");
    }
}

/// A rate table does not stop the Earth: its rate along the turning axis adds W sin(latitude) in both senses, so it moves the zero offset,
/// and the angles only through its horizontal part times the tilts: W / rate, below 1e-4 relative.
#[test]
fn earth_rate_moves_the_angles_by_less_than_their_uncertainty() {
    let comparison = compared("li2012/li2012-table1.campaign.json");
    let difference = largest(&comparison, |group| group.least_squares.clone());
    println!("largest relative difference with Earth rate {difference:.1e}");
    assert!(difference > 1e-12 && difference < 1e-4, "{difference:e}");
}

/// The closed forms themselves against 40-digit arithmetic.
#[test]
fn closed_forms_as_an_independent_script_computes_them() {
    let expected = json("li2012/fits.json");
    for (name, table, key) in [
        ("li2012/li2012-table1.campaign.json", "table1", "per_rate"),
        ("li2012/li2012-table2.campaign.json", "table2", "per_run"),
    ] {
        let comparison = compared(name);
        for group in &comparison.groups {
            let rate = group.group.expect("both papers' closed forms go by rate or run");
            let exact = &expected["closed_forms"][table][key][rate.to_string()]["rad"];
            for (id, closed) in comparison.quantities.iter().zip(&group.closed_form) {
                assert!(digits(closed.expect("a closed form"), number(&exact[id])) > 12.0, "{id} at {rate}");
            }
        }
    }
}
