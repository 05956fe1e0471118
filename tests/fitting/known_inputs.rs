//! How estimates follow a known input: the sensitivity coefficient of its Type B line is the difference of two fits.

use crate::support::*;
use tumble::campaign::{Campaign, Role};
use tumble::fit::{Estimator, Fit, Settings};

/// The campaign with a known value moved, and with a standard uncertainty for it.
fn with_known(campaign: &Campaign, id: &str, by: f64, u: f64) -> Campaign {
    let mut changed = campaign.clone();
    let parameter = changed.parameters.iter_mut().find(|p| p.id == id).expect("a parameter");
    let Role::Known(known) = &mut parameter.role else { panic!("{id} is not known") };
    known.value += by;
    known.u = u;
    changed
}

fn assert_follows(campaign: &Campaign, id: &str, u: f64, settings: Settings) {
    let at = |by: f64| fit_with(&with_known(campaign, id, by, u), settings);
    let (fit, up, down): (Fit, Fit, Fit) = (at(0.0), at(u), at(-u));
    for parameter in &fit.parameters {
        let line = parameter.budget.iter().find(|line| line.source == id).unwrap_or_else(|| panic!("no line for {id}"));
        let difference = (value(&up, &parameter.id) - value(&down, &parameter.id)) / (2.0 * u);
        let own = line.sensitivity.expect("one source");
        // residuals (of the linear estimator: second order in tilts of 1e-3) and the curvature over +-u
        let tolerance = 2e-3 * difference.abs().max(1e-6);
        assert_within(own, difference, tolerance, &format!("d {} / d {id}", parameter.id));
        assert_within(line.u, (own * u).abs(), 1e-15, "c u");
        let own_u = parameter.uncertainty.as_ref().expect("an uncertainty");
        assert_within(own_u.type_b, line.u, 1e-15, "Type B");
    }
}

/// Misalignments are a voltage over kI: a scale factor wrong by 0.1 % makes them wrong by 0.1 %, from zero tilts as reference too.
#[test]
fn a_scale_factor_scales_the_angles() {
    for name in ["gyro-1", "gyro-2", "gyro-3", "accelerometer-1"] {
        let campaign = campaign(&format!("simulated/{name}.campaign.json"));
        for estimator in [Estimator::Linear, Estimator::Exact] {
            assert_follows(&campaign, "kI", 1e-3, Settings { estimator, ..Settings::default() });
        }
        let fit = fitted(&with_known(&campaign, "kI", 0.0, 1e-3));
        let angle = fit.parameters.iter().find(|p| p.id == "dtheta_y2").expect("a tilt");
        let kind = angle.uncertainty.as_ref().expect("an uncertainty").type_b;
        let kappa = campaign.parameters.iter().find(|p| p.id == "kI").map(|p| p.reference()).expect("kI");
        assert!(
            kind > 0.5 * (value(&fit, "dtheta_y2") * 1e-3 / kappa).abs(),
            "{name}: Type B of dtheta_y2 is {kind:e}"
        );
    }
}

/// A fixed height moves a levelling net as a whole.
#[test]
fn a_fixed_height_moves_the_net() {
    let campaign = campaign("levelling/krumm.campaign.json");
    assert_follows(&campaign, "H5", 1e-3, Settings::default());
    let fit = fitted(&with_known(&campaign, "H5", 0.0, 0.003));
    for parameter in &fit.parameters {
        let uncertainty = parameter.uncertainty.as_ref().expect("an uncertainty");
        assert_within(uncertainty.type_b, 0.003, 1e-15, &parameter.id);
        assert_within(uncertainty.u, uncertainty.type_a.hypot(0.003), 1e-15, &parameter.id);
    }
}

/// `u^2 = 9 + 4 + 2*0.5*3*2 = 19` through two inputs that both share, 16 of each one's own: what is shared leaves the difference with all of it.
#[test]
fn shared_inputs_that_are_correlated() {
    use nalgebra::DMatrix;
    use tumble::compare::calibrations::{Determination, InputShare, Quantity, changes};
    let input = |id: &str, u: f64| InputShare { id: id.into(), estimate: 1.0, u, c: 1.0 };
    let of = |value: f64, correlation: f64| Determination {
        quantities: vec![Quantity {
            id: "k".into(),
            unit: "ppm".into(),
            value,
            u: Some(35f64.sqrt()),
            dof: f64::INFINITY,
            inputs: vec![input("kI", 3.0), input("V0", 2.0)],
        }],
        covariance: DMatrix::from_element(1, 1, 35.0),
        correlations: vec![("kI".into(), "V0".into(), correlation)],
        ..Determination::default()
    };
    let found = changes(&of(10.0, 0.5), &of(20.0, 0.5), 0.95, true);
    assert!((found.changes[0].u.expect("judged") - 32f64.sqrt()).abs() < 1e-12);
    assert!((found.together.expect("a test").statistic - 100.0 / 32.0).abs() < 1e-12);
    // not the same inputs: their correlation is not shared
    let other = changes(&of(10.0, 0.5), &of(20.0, 0.4), 0.95, true);
    assert!((other.changes[0].u.expect("judged") - 44f64.sqrt()).abs() < 1e-12);
}

/// Three inputs of which two are one and the same: a semidefinite matrix, as good as any. One that no three inputs can have is refused.
#[test]
fn a_semidefinite_matrix_of_correlations_is_accepted_and_an_indefinite_one_is_not() {
    let campaign = |pairs: [f64; 3]| {
        let [ab, ac, bc] = pairs;
        let text = format!(
            r#"{{ "bench": {{ "id": "sum", "sensors": {{ "y": {{ "model": "m + a + b + c" }} }} }}, "estimate": {{ "m": {{}} }},
                "known": {{ "a": {{ "value": 1, "u": 3 }}, "b": {{ "value": 2, "u": 4 }}, "c": {{ "value": 3, "u": 5 }} }},
                "correlations": [ ["a", "b", {ab}], ["a", "c", {ac}], ["b", "c", {bc}] ],
                "readings": [ {{ "y": 10, "y_u": 1e-9 }} ] }}"#
        );
        let source = tumble::wire::Source { name: "sum".into(), text };
        tumble::wire::read_campaign(&source, &mut |name| panic!("refers to {name}"))
    };
    // c is a, and b follows both by 0.6: u^2 = 9 + 16 + 25 + 2 (0.6 12 + 15 + 0.6 20)
    let own = fitted(&campaign([0.6, 1.0, 0.6]).expect("a matrix that inputs can have"));
    let expected = (50.0 + 2.0 * (0.6 * 12.0 + 15.0 + 0.6 * 20.0_f64)).sqrt();
    assert_within(uncertainty(&own, "m"), expected, 1e-9, "u");
    // trials drawn with the matrix's triangle, (1), (0.6, 0.8), (1, 0, 0), say the same: 100,000 of them, sd of their sd 0.0022 of it
    let drawn = tumble::fit::draw(&own, 100_000, 1, &|_| ()).expect("a question").expect("trials");
    assert_within(drawn.trials.outputs[0].sd, expected, 0.01 * expected, "sd of trials");
    let error = campaign([0.9, -0.9, 0.9]).expect_err("a matrix that no inputs have").to_string();
    assert!(error.contains("not positive semidefinite"), "{error}");
}
