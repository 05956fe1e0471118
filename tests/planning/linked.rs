//! Positions that share deviations (one for a day, one for the whole campaign): the search against full enumeration with the dense covariance in
//! numpy (tests/scripts/plan_linked.py).

use crate::plan_support::*;
use serde_json::Value;
use tumble::campaign::{Campaign, Readings};
use tumble::plan::{self, Costs, Criterion, Goal, Noise, Offer, Request};

fn problems() -> Value {
    serde_json::from_str(include_str!("../data/plan-linked.json")).unwrap()
}

fn number(v: &Value) -> f64 {
    v.as_f64().unwrap()
}

/// `a + b x + c x^2` at positions (x, day), with an offset of y per `line`.
fn parabola(positions: &[Value], line: &str, sd: f64) -> Campaign {
    let readings: Vec<String> =
        positions.iter().map(|p| format!(r#"{{ "x": {}, "day": {} }}"#, number(&p[0]), number(&p[1]))).collect();
    campaign(&format!(
        r#"{{ "bench": {{ "id": "parabola", "sensors": {{ "y": {{ "model": "a + b*x + c*x^2" }} }} }},
             "estimate": {{ "a": {{}}, "b": {{}}, "c": {{}} }},
             "scatter": [ {{ "of": "y", "per": "{line}", "u": {sd} }} ], "readings": [ {} ] }}"#,
        readings.join(", ")
    ))
}

fn eigenvalue(m: &[Vec<f64>]) -> f64 {
    // power iteration: the others lie well below
    let mut v = vec![1.0; m.len()];
    let mut size = 0.0;
    for _ in 0..100_000 {
        let w: Vec<f64> = m.iter().map(|row| row.iter().zip(&v).map(|(m, v)| m * v).sum()).collect();
        size = w.iter().map(|w| w * w).sum::<f64>().sqrt();
        v = w.iter().map(|w| w / size).collect();
    }
    size
}

#[test]
fn what_links_positions_is_planned_for_as_numpy_enumerates() {
    for problem in problems()["problems"].as_array().unwrap() {
        let (line, sd) = (problem["line"].as_str().unwrap(), number(&problem["sd"]));
        let list = |key: &str| problem[key].as_array().unwrap().clone();
        let (candidates, kept, scale) = (list("candidates"), list("kept"), list("scale"));
        let all: Vec<Value> = kept.iter().chain(&candidates).cloned().collect();
        let campaign = parabola(&all, line, sd);
        let noise = Noise::new(&campaign, &[("y".into(), 0.1)], &[]).unwrap();
        let (stays, offered) = campaign.readings.rows.split_at(kept.len());
        let readings = |rows: &[_]| Readings { columns: campaign.readings.columns.clone(), rows: <[_]>::to_vec(rows) };
        let offer = Offer {
            kept: readings(stays),
            candidates: readings(offered),
            noise: noise.clone(),
            costs: Costs::default(),
        };
        for (name, criterion) in [
            ("D", Criterion::D),
            ("A", Criterion::A),
            ("c", Criterion::C("b".into())),
            ("G", Criterion::G),
            ("E", Criterion::E),
        ] {
            let request = Request {
                readings: problem["choose"].as_u64().unwrap() as usize,
                most_repeats: problem["repeats"].as_u64().unwrap() as usize,
                criterion,
                ..Request::default()
            };
            let best = plan::improve(&campaign, &offer, &request).unwrap();
            let c = &best.judgement.covariance;
            let s = |k: usize| number(&scale[k]);
            let matrix = |of: &dyn Fn(usize, usize) -> f64| -> Vec<Vec<f64>> {
                (0..3).map(|i| (0..3).map(|j| of(i, j)).collect()).collect()
            };
            let predicted = |x: f64| {
                let row = [1.0, x, x * x];
                (0..9).map(|k| row[k / 3] * c[(k / 3, k % 3)] * row[k % 3]).sum::<f64>()
            };
            let found = match name {
                "D" => determinant(matrix(&|i, j| c[(i, j)])).ln(),
                "A" => (0..3).map(|k| c[(k, k)] * s(k) * s(k)).sum(),
                "c" => c[(1, 1)],
                "G" => candidates.iter().map(|p| predicted(number(&p[0]))).fold(0.0, f64::max),
                _ => eigenvalue(&matrix(&|i, j| c[(i, j)] * s(i) * s(j))),
            };
            let least = number(&problem["least"][name]);
            println!(
                "{line:>8} {name}: {found:.9} found, {least:.9} least of {} designs, efficiency {:?}",
                problem["designs"], best.search.efficiency
            );
            assert!((found - least).abs() <= 1e-7 * least.abs(), "{line} {name}: {found} found, {least} least");
            assert!(best.check.unwrap() < 1e-9, "{:?}", best.check);
            // the bound is below what can be reached
            assert!(best.search.efficiency.is_none_or(|share| share <= 1.0 + 1e-9));
        }
    }
}

/// Any u(b) that so few readings can reach is reached with so few.
#[test]
fn goals_are_reached_with_as_few_as_numpy_enumerates() {
    let problems = problems();
    let all = problems["problems"][0]["candidates"].as_array().unwrap();
    let campaign = parabola(all, "day", 0.3);
    let noise = Noise::new(&campaign, &[("y".into(), 0.1)], &[]).unwrap();
    let offer = Offer { kept: none(&campaign), candidates: campaign.readings.clone(), noise, costs: Costs::default() };
    for fewest in problems["fewest"].as_array().unwrap() {
        let goals = [Goal { id: "b".into(), u: number(&fewest["u"]) * 1.001 }];
        let request = Request { readings: 30, ..Request::default() };
        let reached = plan::reach(&campaign, &offer, &request, &goals, false).unwrap();
        assert!(reached.goal.reached);
        assert_eq!(reached.improvement.chosen as u64, fewest["readings"].as_u64().unwrap());
    }
}

/// With free mountings and a unit cost for each reading, a budget is a number of readings: the same least values.
#[test]
fn a_budget_of_readings_reaches_what_their_number_does() {
    let problems = problems();
    let problem = &problems["problems"][0];
    let campaign = parabola(problem["candidates"].as_array().unwrap(), "day", 0.3);
    let noise = Noise::new(&campaign, &[("y".into(), 0.1)], &[]).unwrap();
    let costs = Costs { reading: 1.0, rate_change: 0.0, mounting: 0.0, index: 0.0 };
    let offer = Offer { kept: none(&campaign), candidates: campaign.readings.clone(), noise, costs };
    for (name, criterion) in [("D", Criterion::D), ("c", Criterion::C("b".into()))] {
        let request = Request { readings: 0, budget: Some(8.0), criterion, ..Request::default() };
        let best = plan::improve(&campaign, &offer, &request).unwrap();
        let c = &best.judgement.covariance;
        let found = match name {
            "D" => determinant((0..3).map(|i| (0..3).map(|j| c[(i, j)]).collect()).collect()).ln(),
            _ => c[(1, 1)],
        };
        let least = number(&problem["least"][name]);
        assert!((found - least).abs() <= 1e-7 * least.abs(), "{name}: {found} found, {least} least");
    }
}

/// Two days, a dividing head: the same angle on another day is another mounting, days are run one after the other and printed, and readings repeated on
/// the same days keep what the days scatter.
#[test]
fn days_are_mounted_and_run_apart() {
    let schedule = |readings: &str| {
        campaign(&format!(
            r#"{{ "bench": {{ "id": "head", "chain": [ {{ "joint": "beta", "about": "z" }} ], "sensors": {{ "y": {{ "model": "a + b*sin(beta)" }} }} }},
                 "estimate": {{ "a": {{}}, "b": {{}} }}, "scatter": [ {{ "of": "y", "per": "day", "u": 0.4 }} ], "readings": [ {readings} ] }}"#
        ))
    };
    let given =
        schedule(r#"{ "beta_deg": [90, 270], "day": 1, "y_u": 0.1 }, { "beta_deg": [90, 270], "day": 2, "y_u": 0.1 }"#);
    let noise = Noise::new(&given, &[], &[]).unwrap();
    let costs = Costs { index: 0.01, ..Costs::default() };
    let offer = Offer { kept: none(&given), candidates: given.readings.clone(), noise: noise.clone(), costs };
    let request = Request { readings: 4, criterion: Criterion::D, ..Request::default() };
    let best = plan::improve(&given, &offer, &request).unwrap();
    let rows = &best.schedule.readings.rows;
    let day = best.schedule.readings.columns.iter().position(|c| c == "day").unwrap();
    let days: Vec<f64> = rows.iter().map(|r| r.columns[day].unwrap()).collect();
    assert_eq!(days, [1.0, 1.0, 2.0, 2.0]);
    // four mountings of one reading, and the shortest way: 180 degrees on each day, none between them
    assert_eq!(best.judgement.work.mountings, 4);
    assert_close(best.judgement.work.cost, 44.0 + 3.6, 1e-12);
    // by hand: a has 0.4^2/2 of the days and 0.1^2/4 of the readings
    assert_close(best.judgement.parameters[0].u.unwrap(), (0.08_f64 + 0.0025).sqrt(), 1e-12);
    let judgement = plan::judge(&given, &noise, &Costs::default()).unwrap();
    let twice = Request { readings: 8, ..request };
    let more = plan::improve(&given, &offer, &twice).unwrap();
    let report = tumble::report::plan_report(
        &given,
        &noise,
        &judgement,
        Some(tumble::report::Better::Best(&more, "D")),
        tumble::report::Foreseen { given: None, better: None },
        &twice,
        &costs,
        &[],
    );
    let improved = report.improved.unwrap();
    assert_close(improved.comparison[0].equal_effort.unwrap(), (0.08_f64 + 0.0025 / 2.0).sqrt(), 1e-12);
    assert_close(improved.comparison[1].equal_effort.unwrap(), 0.05 / 2.0_f64.sqrt(), 1e-12);
    assert!(improved.positions.iter().all(|p| p.levels.contains_key("day")));
}
