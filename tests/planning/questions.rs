//! What a plan takes from its question: the point at which it judges, constraints, samples, stated uncertainties, sweeps and limits.

use crate::plan_support::*;
use tumble::campaign::{JointState, Readings};
use tumble::design::{self, Model};
use tumble::plan::{self, Costs, Noise, Request, Zone};
use tumble::wire::{self, Source};
use tumble::{fit, simulate};

/// y = b + K sin(beta + m): a scale factor and a mounting tilt, both unknown. Rows at four quarter turns: [1, sin beta, K cos beta].
fn bilinear(estimate: &str, readings: &str) -> tumble::campaign::Campaign {
    campaign(&format!(
        r#"{{ "bench": {{ "id": "head", "units": {{ "force": "g" }},
                 "chain": [ {{ "joint": "beta", "about": "x" }}, {{ "tilt": "m", "about": "x" }} ],
                 "sensors": {{ "y": {{ "unit": "V", "axes": {{ "I": "y" }}, "model": "b + K*a_I" }} }} }},
              "estimate": {estimate}, "readings": {readings} }}"#
    ))
}

const QUARTERS: &str = r#"[ { "beta_deg": [0, 90, 180, 270] } ]"#;
const PLAIN: &str = r#"{ "b": {}, "K": {}, "m": {} }"#;

fn noise_of(campaign: &tumble::campaign::Campaign, sd: f64) -> Noise {
    Noise::new(campaign, &[("y".into(), sd)], &[]).unwrap()
}

/// At K = 0 the tilt's column vanishes: that is no defect of the schedule. With a value of K, u(m) = sd / (K sqrt 2).
#[test]
fn what_vanishes_at_zero_needs_a_value_and_is_no_defect() {
    let schedule = bilinear(PLAIN, QUARTERS);
    let noise = noise_of(&schedule, 1e-3);
    let judgement = plan::judge(&schedule, &noise, &Costs::default()).unwrap();
    assert!(judgement.not_estimable.is_empty(), "{:?}", judgement.not_estimable);
    let lacking = judgement.lacking.unwrap();
    assert_eq!((lacking.untold, lacking.needs), (vec!["m".to_string()], vec!["K".to_string()]));
    let judged = plan::judged_at(&schedule, &[("K".into(), 1.3)], None).unwrap();
    assert!(judged.from.iter().map(|own| own.name()).eq(["zero", "given", "zero"]));
    let judgement = plan::judge(&judged.campaign, &noise, &Costs::default()).unwrap();
    assert!(judgement.lacking.is_none() && judgement.not_estimable.is_empty());
    assert_close(judgement.parameters[2].u.unwrap(), 1e-3 / (1.3 * 2f64.sqrt()), 1e-12);
    assert_close(judgement.parameters[1].u.unwrap(), 1e-3 / 2f64.sqrt(), 1e-12);
    // a start says the same, and so does a search; without a value a search says what it needs
    let started = bilinear(r#"{ "b": {}, "K": { "start": 1.3 }, "m": {} }"#, QUARTERS);
    let again = plan::judge(&started, &noise, &Costs::default()).unwrap();
    assert_close(again.parameters[2].u.unwrap(), 1e-3 / (1.3 * 2f64.sqrt()), 1e-12);
    let request = Request { readings: 4, ..Request::default() };
    let error = plan::improve(&schedule, &offer(&schedule, noise.clone(), 45.0), &request).unwrap_err();
    assert_eq!(error.remedy(), Some(("at", "K=VALUE")), "{error}");
    assert!(
        plan::improve(&started, &offer(&started, noise, 45.0), &request).unwrap().search.efficiency.unwrap() > 0.99
    );
}

/// What is free at every value of the parameters stays a defect: at 0 and 180 deg only, nothing tells K from b... and K is a defect still.
#[test]
fn a_defect_everywhere_is_a_defect() {
    let schedule = bilinear(PLAIN, r#"[ { "beta_deg": [90, 90, 90] } ]"#);
    let judgement = plan::judge(&schedule, &noise_of(&schedule, 1e-3), &Costs::default()).unwrap();
    assert_eq!(judgement.rank, 1);
    assert!(!judgement.not_estimable.is_empty());
}

/// A campaign with values is judged at what its readings say: the plan promises the uncertainties that the fit reports.
#[test]
fn a_measured_campaign_is_judged_at_its_fit() {
    let schedule = bilinear(PLAIN, r#"[ { "beta_deg": [0, 30, 60, 90, 120, 150, 180, 210, 240, 270], "n": 25 } ]"#);
    let truth = simulate::Truth {
        point: vec![0.01, 1.3, 0.02],
        noise: vec![simulate::DrawnNoise { sd: 5e-3, stated: false, decimals: None }],
        effects: vec![],
        scatter: vec![],
    };
    let measured = simulate::simulate(&schedule, &truth, 5).unwrap();
    assert!(measured.readings.rows.iter().all(|r| r.observations[0].samples == 25.0));
    let fitted = fit::fit(&measured, &fit::Settings::default()).unwrap();
    let noise = Noise::with_fit(&measured, &[], &[], Some(&fitted)).unwrap();
    let judged = plan::judged_at(&measured, &[], Some(&fitted)).unwrap();
    let judgement = plan::judge(&judged.campaign, &noise, &Costs::default()).unwrap();
    for (predicted, found) in judgement.parameters.iter().zip(&fitted.parameters) {
        assert_close(predicted.u.unwrap(), found.uncertainty.as_ref().unwrap().u, 1e-9);
    }
    // the schedule with the same samples and the same noise of one sample promises the same but for the estimated noise
    let given = noise_of(&schedule, 5e-3);
    let point: Vec<(String, f64)> = ["b", "K", "m"].iter().map(|s| s.to_string()).zip(truth.point).collect();
    let ahead =
        plan::judge(&plan::judged_at(&schedule, &point, None).unwrap().campaign, &given, &Costs::default()).unwrap();
    let scale = given.sensors[0].sd / noise.sensors[0].sd;
    for (before, after) in ahead.parameters.iter().zip(&judgement.parameters) {
        assert_close(before.u.unwrap(), scale * after.u.unwrap(), 5e-3);
    }
}

/// 2000 means of 25 samples scatter by sd / 5; the sample standard deviation of so many is known to 1.6 % (one sigma), four of which are allowed.
#[test]
fn simulated_means_of_n_samples_scatter_by_the_root_of_n_less() {
    let schedule = campaign(&format!(
        r#"{{ "bench": {{ "id": "level", "sensors": {{ "y": {{ "model": "a" }} }} }}, "estimate": {{ "a": {{}} }},
             "readings": [ {{ "run": {:?}, "n": 25, "y_u": 0.2 }} ] }}"#,
        (0..2000).collect::<Vec<_>>()
    ));
    let noise = |stated| simulate::DrawnNoise { sd: 1.0, stated, decimals: None };
    let truth =
        |stated| simulate::Truth { point: vec![0.0], noise: vec![noise(stated)], effects: vec![], scatter: vec![] };
    let measured = simulate::simulate(&schedule, &truth(false), 1).unwrap();
    let square = measured.readings.rows.iter().map(|r| r.observations[0].value.powi(2)).sum::<f64>() / 2000.0;
    assert!((square.sqrt() / 0.2 - 1.0).abs() < 4.0 * 0.016, "{}", square.sqrt());
    // what the schedule states is carried where the truth states nothing, and n always
    assert!(
        measured.readings.rows.iter().all(|r| r.observations[0].u == Some(0.2) && r.observations[0].samples == 25.0)
    );
    let stated = simulate::simulate(&schedule, &truth(true), 1).unwrap();
    assert_eq!(stated.readings.rows[0].observations[0].u, Some(1.0 / 5.0));
}

/// A schedule may state u of values still to be read; among measured values an uncertainty without its value stays an error.
#[test]
fn a_schedule_states_its_uncertainties() {
    let schedule = campaign(
        r#"{ "bench": { "id": "level", "sensors": { "y": { "model": "a" } } }, "estimate": { "a": {} },
             "readings": [ { "run": [1, 2, 3, 4], "y_u": 0.5 }, { "run": 5, "y_u": 0.1 } ] }"#,
    );
    let noise = Noise::new(&schedule, &[], &[]).unwrap();
    let judgement = plan::judge(&schedule, &noise, &Costs::default()).unwrap();
    let weight: f64 = 4.0 / 0.25 + 1.0 / 0.01;
    assert_close(judgement.parameters[0].u.unwrap(), weight.sqrt().recip(), 1e-12);
    let file = wire::campaign_file(&schedule, wire::BenchRef::Inline(Box::new(wire::bench_file(&schedule.bench))));
    let again = campaign(&serde_json::to_string(&file).unwrap());
    assert_eq!(again.readings.rows[4].planned_u[..], [(0, 0.1)]);
    let text = r#"{ "bench": { "id": "level", "sensors": { "y": { "model": "a" } } }, "estimate": { "a": {} },
             "readings": [ { "run": 1, "y": 2.0, "y_u": 0.5 }, { "run": 2, "y_u": 0.1 } ] }"#;
    let error =
        wire::read_campaign(&Source { name: "t".into(), text: text.into() }, &mut |_| unreachable!()).unwrap_err();
    assert!(error.to_string().contains("y_u without y"), "{error}");
}

/// Only a + b shows in the readings; an equation between them determines both, in the fit, in the judgement and in a search.
#[test]
fn equations_between_unknowns_count() {
    let text = |constraint: &str| {
        format!(
            r#"{{ "bench": {{ "id": "sum", "sensors": {{ "y": {{ "model": "a + b + c*x" }} }} }},
                 "estimate": {{ "a": {{}}, "b": {{}}, "c": {{}} }}, "constraints": [ {constraint} ],
                 "readings": [ {{ "x": [-1, -0.5, 0.5, 1] }} ] }}"#
        )
    };
    let free = campaign(&text(""));
    let noise = noise_of(&free, 0.3);
    assert!(!plan::judge(&free, &noise, &Costs::default()).unwrap().not_estimable.is_empty());
    // a - 2 b = 1: a = (2 s + 1)/3, b = (s - 1)/3 of the sum s, whose u is 0.3/2
    let tied = campaign(&text(r#"{ "of": { "a": 1, "b": -2 }, "equals": 1 }"#));
    let judgement = plan::judge(&tied, &noise, &Costs::default()).unwrap();
    assert!(judgement.not_estimable.is_empty());
    assert_close(judgement.parameters[0].u.unwrap(), 0.1, 1e-12);
    assert_close(judgement.parameters[1].u.unwrap(), 0.05, 1e-12);
    assert_eq!((judgement.rank, judgement.dof), (2, 2));
    // the search: four readings at the ends, det of (s, c) = 4 * 4
    let best = plan::improve(&tied, &offer(&tied, noise.clone(), 45.0), &Request { readings: 4, ..Request::default() })
        .unwrap();
    assert!(best.unreachable.is_empty() && best.check.unwrap() < 1e-12);
    assert_close(best.judgement.parameters[2].u.unwrap(), 0.15, 1e-12);
    // bounds are told, not counted; contradictions are refused
    let bounded = campaign(&text(r#"{ "of": { "a": 1 }, "between": [-1, 1] }"#));
    assert_eq!(plan::judge(&bounded, &noise, &Costs::default()).unwrap().bounds, 1);
    let both = r#"{ "of": { "a": 1 }, "equals": 1 }, { "of": { "a": 1 }, "equals": 2 }"#;
    assert!(
        plan::judge(&campaign(&text(both)), &noise, &Costs::default()).unwrap_err().to_string().contains("contradict")
    );
}

/// A joint that both stands and turns is swept and turned; an interval may run through zero.
#[test]
fn sweeps_of_joints_that_stand_and_turn() {
    let both = campaign(
        r#"{ "bench": { "id": "table", "chain": [ { "joint": "g", "about": "z" } ],
               "sensors": { "y": { "axes": { "I": "x" }, "model": "b + K*w_I + k*a_I" } } },
             "known": { "k": { "value": 1 } }, "estimate": { "b": {}, "K": {} },
             "readings": [ { "g_deg": 10 }, { "g_deg_s": [20, -20] } ] }"#,
    );
    let swept = plan::sweep(&both, 90.0).unwrap();
    let states: Vec<JointState> = swept.rows.iter().map(|r| r.joints[0]).collect();
    let held = [0.0, 90.0, 180.0, 270.0].map(|angle_deg| JointState::Held { angle_deg });
    let turning = [20.0, -20.0].map(|rate_deg_s| JointState::WholeTurns { rate_deg_s });
    assert_eq!(states, [held.as_slice(), turning.as_slice()].concat());
    let zone = |low, high| vec![Zone { limits: vec![("g_deg".into(), low, high)] }];
    let left = |low, high| -> Vec<JointState> {
        plan::without(&both, swept.clone(), &zone(low, high)).unwrap().rows.iter().map(|r| r.joints[0]).collect()
    };
    assert_eq!(left(300.0, 60.0), [&held[1..], &turning].concat());
    assert_eq!(left(300.0, 60.0), left(-60.0, 60.0));
    // a step that would need terabytes is refused before anything is made
    assert!(plan::sweep(&both, 1e-9).unwrap_err().to_string().contains("too many"));
}

/// Three lists of a thousand stand for a billion readings: refused before they are made.
#[test]
fn lists_that_stand_for_too_many_readings_are_refused() {
    let list = format!("{:?}", (0..1000).collect::<Vec<_>>());
    let text = format!(
        r#"{{ "bench": {{ "id": "level", "sensors": {{ "y": {{ "model": "a" }} }} }}, "estimate": {{ "a": {{}} }},
             "readings": [ {{ "p": {list}, "q": {list}, "r": {list} }} ] }}"#
    );
    let error = wire::read_campaign(&Source { name: "t".into(), text }, &mut |_| unreachable!()).unwrap_err();
    assert!(
        error.to_string().contains("too many readings") && error.finding().unwrap_or_default().contains("1000000000"),
        "{error}"
    );
}

/// The mean of a tilt that grows with the turning joint's angle needs more instants than the model line alone, also where the tilt is assumed
/// zero and only its effect is asked for.
#[test]
fn the_column_of_a_growing_tilt_is_the_same_whether_it_is_estimated_or_assumed_zero() {
    let with = |estimate: &str| {
        campaign(&format!(
            r#"{{ "bench": {{ "id": "table", "units": {{ "force": "g" }},
                   "chain": [ {{ "joint": "g", "about": "x" }}, {{ "tilt": "lin", "about": "x", "times": "g" }}, {{ "tilt": "two", "about": "x", "times": "cos(2*g)" }} ],
                   "sensors": {{ "y": {{ "axes": {{ "I": "y" }}, "model": "b + k*a_I + q*a_I^2" }} }} }},
                 "known": {{ "k": {{ "value": 1 }}, "q": {{ "value": 0.1 }} }}, "estimate": {estimate},
                 "readings": [ {{ "g_deg_s": 20 }}, {{ "g_deg": 30 }} ] }}"#
        ))
    };
    let columns = |campaign: &tumble::campaign::Campaign| -> Vec<Vec<f64>> {
        let design = design::assemble(campaign, &Model::new(campaign).unwrap(), &campaign.reference_point()).unwrap();
        ["lin", "two"]
            .map(|id| campaign.parameter_index(id).unwrap())
            .iter()
            .map(|k| (0..2).map(|i| design.jacobian[(i, *k)]).collect())
            .collect()
    };
    let zero = columns(&with(r#"{ "b": {} }"#));
    let estimated = columns(&with(r#"{ "b": {}, "lin": {}, "two": {} }"#));
    for (a, b) in zero.iter().flatten().zip(estimated.iter().flatten()) {
        assert!((a - b).abs() < 1e-9, "{zero:?} {estimated:?}");
    }
    // mean of g cos g + 0.1 g sin 2g over a turn from 0 is 0 - 0.1 / 2
    assert!((zero[0][0] + 0.05).abs() < 1e-9, "{}", zero[0][0]);
    let _: Readings = with(r#"{ "b": {} }"#).readings;
}

/// The uncertainty of an effect found beside the model is that of its column with the model's taken out: a quadratic on -1, 0, 1, whose rest is
/// (1/3, -2/3, 1/3) of length sqrt(2/3).
#[test]
fn an_effect_is_one_more_unknown() {
    let campaign = campaign(
        r#"{ "bench": { "id": "line", "sensors": { "y": { "model": "a + b*x" } } }, "estimate": { "a": {}, "b": {} },
            "readings": [ {"x": -1, "y_u": 0.1}, {"x": 0, "y_u": 0.1}, {"x": 1, "y_u": 0.1} ] }"#,
    );
    let regressor = simulate::Regressor::parse(&campaign, Some(0), "x^2").unwrap();
    let term = plan::Term { sensor: Some(0), regressor };
    let (longer, names) = plan::extended(&campaign, std::slice::from_ref(&term)).unwrap();
    assert_eq!(names, ["c_x_2"]);
    let noise = Noise::new(&longer, &[], &[]).unwrap();
    let judged = plan::judge(&longer, &noise, &Costs::default()).unwrap();
    let own = judged.parameters.iter().find(|p| p.id == "c_x_2").unwrap();
    assert!((own.u.unwrap() - 0.1 / (2.0_f64 / 3.0).sqrt()).abs() < 1e-12);
    let (_, twice) = plan::extended(&campaign, &[term.clone(), term]).unwrap();
    assert_eq!(twice, ["c_x_2", "c_x_2_2"]);
}

/// Readings that follow a schedule are no earlier than its last one: a drift is not planned at its beginning.
#[test]
fn a_sweep_goes_on_from_the_last_reading() {
    let drifting = campaign(
        r#"{ "bench": { "id": "head", "chain": [ { "joint": "beta", "about": "x" } ],
               "sensors": { "y": { "axes": { "I": "y" }, "model": "b + k*a_I + d*time_h" } } },
             "estimate": { "b": {}, "k": {}, "d": {} },
             "readings": [ { "beta_deg": 0, "time_h": 0 }, { "beta_deg": 90, "time_h": 1 }, { "beta_deg": 0, "time_h": 3.5 } ] }"#,
    );
    let swept = plan::sweep(&drifting, 90.0).unwrap();
    let column = swept.columns.iter().position(|name| name == "time_h").unwrap();
    let times: Vec<f64> = swept.rows.iter().map(|row| row.columns[column].unwrap()).collect();
    assert_eq!(times, [3.5; 4]);
}

/// A temperature that the model line reads is planned at what the schedule has of it: with the quadratic of three coefficients no schedule at one
/// temperature determines any, and the readings of one temperature are run together.
#[test]
fn a_sweep_has_the_conditions_of_the_schedule() {
    let values = [(-40.1, 0.0), (-39.9, 50.0), (10.2, -50.0), (10.0, 50.0), (59.8, 50.0), (60.0, -50.0)];
    let readings = values.map(|(t, rate)| format!(r#"{{ "temperature_c": {t}, "gamma_deg_s": {rate} }}"#));
    let chamber = campaign(&format!(
        r#"{{ "bench": "gyro-temperature", "site": {{ "latitude_deg": 45 }},
              "estimate": {{ "V0": {{}}, "V1": {{}}, "V2": {{}}, "K": {{ "start": 0.02 }}, "K1": {{}} }}, "readings": [ {} ] }}"#,
        readings.join(", ")
    ));
    let swept = plan::sweep(&chamber, 180.0).unwrap();
    let column = swept.columns.iter().position(|name| name == "temperature_c").unwrap();
    let mut temperatures: Vec<f64> = swept.rows.iter().map(|row| row.columns[column].unwrap()).collect();
    temperatures.sort_by(f64::total_cmp);
    temperatures.dedup();
    assert_eq!(temperatures, [-40.1, 10.0, 60.0]);
    let noise = Noise::new(&chamber, &[("V".into(), 5e-6)], &[]).unwrap();
    let request = Request { readings: 9, ..Request::default() };
    let better = plan::improve(&chamber, &offer(&chamber, noise, 180.0), &request).unwrap();
    assert!(better.unreachable.is_empty(), "{:?}", better.unreachable);
    let run: Vec<f64> = better.schedule.readings.rows.iter().map(|row| row.columns[column].unwrap()).collect();
    assert!(run.is_sorted() && run.first() == Some(&-40.1) && run.last() == Some(&60.0), "{run:?}");
}

/// Of a fit that leaves a tilt free the scale factor is taken, so that what the plan says of the tilt is what it is at that scale factor.
#[test]
fn a_plan_is_judged_at_what_an_incomplete_fit_determines() {
    // y = b + K sin(beta + m + r): of the two tilts only the sum is seen
    let text = r#"{ "bench": { "id": "head", "units": { "force": "g" },
                 "chain": [ { "joint": "beta", "about": "x" }, { "tilt": "m", "about": "x" }, { "tilt": "r", "about": "x" } ],
                 "sensors": { "y": { "unit": "V", "axes": { "I": "y" }, "model": "b + K*a_I" } } },
              "estimate": { "b": {}, "K": {}, "m": {}, "r": {} },
              "readings": [ { "beta_deg": 0, "y": 0.013 }, { "beta_deg": 90, "y": 1.31 }, { "beta_deg": 180, "y": 0.007 },
                            { "beta_deg": 270, "y": -1.29 }, { "beta_deg": 45, "y": 0.93 } ] }"#;
    let measured = campaign(text);
    let fit = fit::fit(&measured, &fit::Settings::default()).unwrap();
    assert_eq!(fit.not_estimable.len(), 1);
    let judged = plan::judged_at(&measured, &[], Some(&fit)).unwrap();
    assert!(judged.from.iter().map(|own| own.name()).eq(["fitted", "fitted", "zero", "zero"]));
}
