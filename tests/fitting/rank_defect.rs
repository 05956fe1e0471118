//! What readings cannot separate comes out as a combination of the user's own parameters, with the position that would separate it.

use crate::support::*;
use tumble::campaign::JointState;
use tumble::fit::State;

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
