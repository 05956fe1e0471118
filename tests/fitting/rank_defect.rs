//! What readings cannot separate comes out as a combination of the user's own parameters, with the position that would separate it.

use crate::support::*;
use tumble::campaign::JointState;
use tumble::fit::State;
use tumble::language::Language;
use tumble::report;

/// The plumb plane alone: a shift of dtheta_y0 by 1 is one of V0 by -kI, at whatever angle.
#[test]
fn the_plane_cannot_be_told_from_the_zero_offset() {
    let truth = json("simulated/accelerometer-rank-defect.truth.json");
    let fit = exact(&campaign("simulated/accelerometer-rank-defect.campaign.json"));
    assert_eq!((fit.estimate.unknowns.rank, fit.parameters.len()), (3, 4));
    assert!(fit.is_rejected());
    let [defect] = &fit.not_estimable[..] else { panic!("{:?}", fit.not_estimable) };
    assert_eq!(defect.free.text, "V0 + kI*dtheta_y0");
    assert_eq!(defect.estimable.len(), 1);
    assert_eq!(defect.estimable[0].text, "V0 - kI*dtheta_y0");
    // at the solution the exact derivative is kI times cosines of tilts of 2e-3
    assert_within(defect.estimable[0].terms[1].1, -1.299, 5e-6, "kI");
    assert_eq!(defect.separate_by, None, "no position of this bench separates the two");
    for parameter in &fit.parameters {
        let free = !["V0", "dtheta_y0"].contains(&parameter.id.as_str());
        assert_eq!(parameter.state, if free { State::Free } else { State::NotEstimable }, "{}", parameter.id);
        assert_eq!(parameter.value.is_some(), free);
        if free {
            let exact = number(&truth["truth"][&parameter.id]);
            // second order of tilts of 2e-3 mixes into the rest once a tilt of the plane cannot be told
            assert_within(value(&fit, &parameter.id), exact, 1e-6, &parameter.id);
        }
    }
}

/// Two opposite positions give the difference of their readings and the mean, nothing else: the missing position is named.
#[test]
fn the_position_that_would_separate_is_named_and_does() {
    let text = |extra: &str| {
        format!(
            r#"{{ "bench": "accelerometer-plumb-plane", "known": {{ "kI": {{ "value": 1.299 }} }},
               "estimate": {{ "V0": {{}}, "dtheta_y2": {{}}, "dtheta_z2": {{}} }},
               "readings": [ {{ "beta_deg": 0, "V": 0.001 }}, {{ "beta_deg": 180, "V": 0.003 }}{extra} ] }}"#
        )
    };
    let fit = fitted(&parse(&text("")));
    let [defect] = &fit.not_estimable[..] else { panic!("{:?}", fit.not_estimable) };
    assert_eq!(defect.free.text, "dtheta_z2");
    assert!(defect.estimable.is_empty());
    let Some([JointState::Held { angle_deg }]) = defect.separate_by.as_deref() else {
        panic!("{:?}", defect.separate_by)
    };
    assert_eq!(angle_deg.rem_euclid(180.0), 90.0);
    let fit = fitted(&parse(&text(&format!(r#", {{ "beta_deg": {angle_deg}, "V": 0.002 }}"#))));
    assert!(fit.not_estimable.is_empty());
}

/// A rate of one sense only: rate times misalignment and the zero offset are one number.
#[test]
fn one_rate_of_one_sense() {
    let fit = fitted(&parse(
        r#"{ "bench": "gyro-turntable", "known": { "kI": { "value": -2.9222 } }, "estimate": { "V0": {}, "dtheta_y1": {} },
             "readings": [ { "alpha_deg": 90, "beta_deg": 90, "gamma_deg_s": 20, "V": 0.01 },
                           { "alpha_deg": 270, "beta_deg": 90, "gamma_deg_s": 20, "V": 0.012 } ] }"#,
    ));
    let [defect] = &fit.not_estimable[..] else { panic!("{:?}", fit.not_estimable) };
    assert!(defect.free.text.contains("V0") && defect.free.text.contains("dtheta_y1"), "{}", defect.free.text);
    assert!(defect.separate_by.is_some(), "the other sense separates them");
}

/// Fewer readings than unknowns is a rank defect like any other, not an error.
#[test]
fn fewer_readings_than_unknowns() {
    let fit = fitted(&campaign("bad/fewer-readings.campaign.json"));
    assert_eq!((fit.estimate.unknowns.rank, fit.estimate.dof, fit.parameters.len()), (2, 0, 3));
    assert!(fit.is_rejected() && fit.parameters.iter().all(|p| p.uncertainty.is_none()));
    assert_eq!(fit.not_estimable.len(), 1);
}

/// A prior is a row: it makes estimable what the readings alone leave free.
#[test]
fn a_prior_makes_it_estimable() {
    let text = text("simulated/accelerometer-rank-defect.campaign.json");
    let text =
        text.replace("\"dtheta_y0\": {}", "\"dtheta_y0\": { \"prior\": 82.5, \"prior_u\": 1, \"unit\": \"arcsec\" }");
    let fit = linear(&parse(&text));
    assert!(fit.not_estimable.is_empty());
    // readings without noise weigh 1e13 times as much as the prior: the rounding of their derivatives is a ten-thousandth of it
    assert_within(value(&fit, "dtheta_y0"), 82.5 * ARCSEC, 1e-3 * ARCSEC, "the prior itself");
    assert_within(uncertainty(&fit, "dtheta_y0"), ARCSEC, 1e-3 * ARCSEC, "its uncertainty");
    // and their scatter is that rounding, not the 1 V that the u of the prior once suggested
    assert!(uncertainty(&fit, "dtheta_y2") < 1e-9 * ARCSEC);
}

/// A line read at one x: another x separates, and it is named.
#[test]
fn another_value_of_a_column_separates() {
    let text = |extra: &str| {
        format!(
            r#"{{ "bench": {{ "id": "line", "sensors": {{ "Y": {{ "unit": "V", "model": "a + s*x" }} }} }}, "estimate": {{ "a": {{}}, "s": {{}} }},
                "readings": [ {{"x": 2.0, "Y": 1.5, "Y_u": 0.1}}, {{"x": 2.0, "Y": 1.51, "Y_u": 0.1}}{extra} ] }}"#
        )
    };
    let fit = fitted(&parse(&text("")));
    let [defect] = &fit.not_estimable[..] else { panic!("{:?}", fit.not_estimable) };
    let [(column, x)] = &defect.columns[..] else { panic!("{:?}", defect.columns) };
    assert!(column == "x" && *x != 2.0, "{x}");
    let table = tumble::document::terminal::brief(&tumble::report::fit_document(
        &report::fit_report(&fit),
        &Default::default(),
        Language::English,
    ));
    assert!(said(&table).contains(&format!("A reading at x = {x} would separate them")), "{table}");
    let fit = fitted(&parse(&text(&format!(r#", {{"x": {x}, "Y": 1.2, "Y_u": 0.1}}"#))));
    assert!(fit.not_estimable.is_empty());
}

/// A text on one line, however it was broken.
fn said(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// The sum of two unknowns by one sensor; their difference is what the other would read.
#[test]
fn a_sensor_that_is_not_read_separates() {
    let text = |extra: &str| {
        format!(
            r#"{{ "bench": {{ "id": "pair", "sensors": {{ "Y": {{ "unit": "V", "model": "a + b" }}, "Z": {{ "unit": "V", "model": "a - b" }} }} }},
                "estimate": {{ "a": {{}}, "b": {{}} }}, "readings": [ {{"Y": 1.5, "Y_u": 0.1}}, {{"Y": 1.51, "Y_u": 0.1}}{extra} ] }}"#
        )
    };
    let fit = fitted(&parse(&text("")));
    let [defect] = &fit.not_estimable[..] else { panic!("{:?}", fit.not_estimable) };
    assert_eq!((defect.separate_by.as_deref(), defect.sensor), (Some(&[][..]), Some(1)));
    let table = tumble::document::terminal::brief(&tumble::report::fit_document(
        &report::fit_report(&fit),
        &Default::default(),
        Language::English,
    ));
    assert!(said(&table).contains("A reading of Z would separate them"), "{table}");
    assert!(fitted(&parse(&text(r#", {"Z": 0.2, "Z_u": 0.1}"#))).not_estimable.is_empty());
}

/// On a dividing head a turn of its zero by e is one of the pendulous axis: KP by -K1 e. That K1 changes by KP e, a thousandth of that, names
/// no partner.
#[test]
fn the_partner_is_the_one_that_has_a_part() {
    let fit = exact(&parse(
        r#"{ "bench": "accelerometer-dividing-head", "estimate": { "K0": {}, "K1": {}, "KP": {}, "head_zero": {} },
             "readings": [ { "theta_deg": 0, "A": 0.0004187903789 }, { "theta_deg": 90, "A": 1.300451421 },
                           { "theta_deg": 180, "A": 0.002052376818 }, { "theta_deg": 270, "A": -1.297895109 } ] }"#,
    ));
    let [defect] = &fit.not_estimable[..] else { panic!("{:?}", fit.not_estimable) };
    let names: Vec<&str> = defect.free.terms.iter().map(|(id, _)| id.as_str()).collect();
    assert_eq!(names, ["KP", "head_zero"]);
    // half the difference of the readings at 90 and 270 degrees
    assert_within(defect.free.terms[1].1, -(1.300451421 + 1.297895109) / 2.0, 1e-5, "K1");
}

/// A tilt that acts in the second order only, about the axis of an inner joint: it is not estimable, and takes with it only what it moves by as much as that is uncertain
/// itself. The others are those with the tilt held (`tests/scripts/second_order_tilt.py`).
#[test]
fn a_tilt_of_the_second_order_leaves_the_others() {
    let expected = json("simulated/second-order-tilt.json");
    let fit = exact(&campaign("simulated/second-order-tilt.campaign.json"));
    for parameter in &fit.parameters {
        let id = parameter.id.as_str();
        if ["sx", "kI"].contains(&id) {
            assert_eq!(parameter.state, State::NotEstimable, "{id}");
            continue;
        }
        let (value, u) = (number(&expected["value"][id]), number(&expected["u"][id]));
        let own = parameter.uncertainty.unwrap();
        // the tilt is held at 5e-4 here (`TILT` in starts.rs) and at zero there: its second order is 1.3e-7, a fortieth of the least u of a tilt
        let apart = (parameter.value.unwrap() - value).abs() / u;
        println!("{id}: {apart} u apart, u {} and {u}", own.u);
        assert!(apart < 0.05, "{id} {:?} {value}", parameter.value);
        assert!((own.u / u - 1.0).abs() < 0.02, "{id} {} {u}", own.u);
    }
}

/// A derived quantity whose slope by a parameter vanishes at the estimate alone is not determined where that parameter is not: the root of a sum of squares of which one is at its reference value zero.
#[test]
fn derived_quantities_of_undetermined_parameters_have_no_value() {
    let text = r#"{
        "bench": { "id": "one", "chain": [ { "joint": "theta", "about": "y" }, { "tilt": "mis_y", "about": "y" }, { "tilt": "mis_z", "about": "z" } ],
                   "sensors": { "A": { "unit": "V", "axes": { "I": "x" }, "model": "V0 + K*a_I" } } },
        "known": { "K": { "value": 1 } }, "estimate": { "V0": {}, "mis_y": {}, "mis_z": {} },
        "derived": { "misalignment": { "line": "sqrt(mis_y^2 + mis_z^2)" }, "product": { "line": "mis_y*(1 + mis_z^2)" },
                     "undetermined": { "line": "2*mis_z" }, "twice": { "line": "2*mis_y" } },
        "readings": [ { "theta_deg": 0, "A": 0.01 }, { "theta_deg": 90, "A": -0.99 }, { "theta_deg": 180, "A": 0.0102 },
                      { "theta_deg": 270, "A": 1.01 }, { "theta_deg": 45, "A": -0.697 } ] }"#;
    let fit = fitted(&parse(text));
    let derived: Vec<(&str, bool)> = fit.derived.iter().map(|own| (own.id.as_str(), own.value.is_some())).collect();
    assert_eq!(derived, [("misalignment", false), ("product", false), ("undetermined", false), ("twice", true)]);
}

/// A prior that the readings contradict is named, one that agrees with them is not: 0.5 V of offset, read to 1 mV, beside priors of 10 mV.
#[test]
fn a_prior_against_the_readings_is_named() {
    let text = |prior: f64| {
        format!(
            r#"{{ "bench": {{ "id": "head", "chain": [ {{ "joint": "theta", "about": "y" }} ],
                  "sensors": {{ "A": {{ "unit": "V", "axes": {{ "I": "x" }}, "model": "K0 + K1*a_I" }} }} }},
                "estimate": {{ "K0": {{ "prior": {prior}, "prior_u": 0.01 }}, "K1": {{}} }},
                "readings": [ {{ "theta_deg": 0, "A": 0.501 }}, {{ "theta_deg": 90, "A": -1.499 }}, {{ "theta_deg": 180, "A": 0.4995 }},
                  {{ "theta_deg": 270, "A": 2.501 }}, {{ "theta_deg": 0, "A": 0.4998 }}, {{ "theta_deg": 180, "A": 0.5003 }} ] }}"#
        )
    };
    let fit = fitted(&parse(&text(0.51)));
    assert!(fit.checks.priors.is_empty(), "{:?}", fit.checks.priors);
    let fit = fitted(&parse(&text(0.8)));
    let [(parameter, w, p)] = fit.checks.priors[..] else { panic!("{:?}", fit.checks.priors) };
    // (0.8 - 0.5) of 0.01, and what the readings, which scatter to fit it, take for noise
    assert!(parameter == 0 && w.abs() > 3.3 && w.abs() < 30.0 && p < 1e-3, "{parameter} {w} {p}");
}
