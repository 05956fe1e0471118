//! Conformity with limits: probabilities by an independent integration (tests/scripts/site_and_conformity.py), and the three rules.

use crate::support::*;
use tumble::report::{conformity, fit_document, fit_report};
use tumble::wire::{Source, read_campaign};

fn line(limits: &str) -> String {
    format!(
        r#"{{ "bench": {{ "id": "line", "sensors": {{ "y": {{ "unit": "mm", "model": "a + b*time_s" }} }} }},
            "estimate": {{ "a": {{}}, "b": {{}} }}, "derived": {{ "twice": "2*b" }}, {limits}
            "unit": {{ "serial": "S-1", "manufacturer": "M" }}, "operator": "O",
            "readings": [ {{"time_s": 0, "y": 1.02}}, {{"time_s": 1, "y": 2.99}}, {{"time_s": 2, "y": 5.01}},
                          {{"time_s": 3, "y": 6.98}}, {{"time_s": 4, "y": 9.03}}, {{"time_s": 5, "y": 10.97}} ] }}"#
    )
}

#[test]
fn probabilities_and_outcomes() {
    for (limits, probability, simple, guard, risk) in [
        ("[1.98, 2.01]", 0.936048256807, "pass", "undecided", "undecided"),
        ("[1.9, 2.1]", 0.999927636792, "pass", "pass", "pass"),
        ("[2.0, 2.1]", 0.2407188413, "fail", "undecided", "undecided"),
        ("[1.9, 1.95]", 0.000721310098194, "fail", "fail", "fail"),
    ] {
        for (rule, outcome) in [("simple", simple), ("guard-u", guard), ("risk", risk)] {
            let text = line(&format!(r#""limits": {{ "b": {limits} }}, "decision": "{rule}","#));
            let fit = fitted(&parse(&text));
            let report = conformity(&fit).expect("limits");
            let found = &report.quantities[0];
            assert_within(found.probability.expect("a probability"), probability, 1e-9, limits);
            assert_eq!((found.outcome.name(), report.outcome.name()), (outcome, outcome), "{limits} {rule}");
            assert_eq!(found.unit, "mm/s");
            let document = fit_document(&fit_report(&fit), &Default::default(), tumble::language::Language::English);
            assert!(tumble::document::terminal::brief(&document).contains(outcome));
        }
    }
}

#[test]
fn one_sided_limits_units_and_derived_quantities() {
    let text = line(r#""limits": { "b": { "between": [null, 2.1e3], "unit": "um/s" }, "twice": [4, null] },"#);
    let fit = fitted(&parse(&text));
    let report = conformity(&fit).expect("limits");
    assert_eq!((report.quantities[0].lower, report.quantities[0].upper), (None, Some(2.1)));
    assert_eq!(report.quantities[0].outcome.name(), "pass");
    // 2 b = 3.991 is below 4
    assert_eq!((report.quantities[1].outcome.name(), report.outcome.name()), ("fail", "fail"));
    // P(2b > 4) = P(b > 2): 0.240718... of [2, 2.1] and what is above 2.1
    let above = report.quantities[1].probability.expect("a probability");
    assert!(above > 0.24071 && above < 0.24076, "{above}");
    let facts = fit_report(&fit).identity.facts(tumble::language::Language::English);
    assert_eq!(facts, [("Unit".to_string(), "M, serial number S-1".to_string()), ("Operator".into(), "O".into())]);
}

#[test]
fn limits_that_make_no_sense_are_refused() {
    let refused = |text: String, path: &str| {
        let error = read_campaign(&Source { name: "c".into(), text }, &mut |_| unreachable!()).expect_err("a fault");
        assert_eq!(error.place().path, path, "{error}");
    };
    refused(line(r#""limits": { "c": [0, 1] },"#), "limits.c");
    refused(line(r#""limits": { "b": [1, 0] },"#), "limits.b");
    refused(line(r#""limits": { "b": [null, null] },"#), "limits.b");
    refused(line(r#""limits": { "b": { "between": [0, 1], "unit": "V" } },"#), "limits.b.unit");
    let tilt = |limit: &str| {
        format!(
            r#"{{ "bench": "accelerometer-plumb-plane", "known": {{ "kI": {{ "value": 1.3 }} }}, "estimate": {{ "dtheta_y2": {{}} }},
                "limits": {{ "dtheta_y2": {limit} }}, "readings": [ {{"beta_deg": 0, "V": 0.001}} ] }}"#
        )
    };
    refused(tilt("[-200, 200]"), "limits.dtheta_y2");
    assert!(parse(&tilt(r#"{ "between": [-200, 200], "unit": "arcsec" }"#)).limits[0].upper < 1e-3);
}
