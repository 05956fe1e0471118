//! The search against full enumeration in numpy (tests/scripts/plan_enumeration.py), budgets and goals among nested candidates, orders, what is kept.

use crate::plan_support::*;
use nalgebra::{DMatrix, DVector};
use tumble::campaign::{Observation, Readings};
use tumble::plan::{self, Costs, Criterion, Goal, Noise, Offer, Order, Request, Unit};
use tumble::report;

/// Problems with 1e5 to 4e5 designs, most of them more than are tried one by one: the exchanges end at the least value of all designs, by D, A, c, G and E.
#[test]
fn exchanges_find_what_numpy_enumerates() {
    let problems: serde_json::Value = serde_json::from_str(include_str!("../data/plan-optima.json")).unwrap();
    let mut missed = 0;
    for problem in problems.as_array().unwrap() {
        let number = |v: &serde_json::Value| v.as_f64().unwrap();
        let list = |v: &serde_json::Value| v.as_array().unwrap().iter().map(number).collect::<Vec<f64>>();
        let rows: Vec<Vec<Vec<f64>>> = problem["rows"].as_array().unwrap().iter().map(|row| vec![list(row)]).collect();
        let (n, c) = (rows[0][0].len(), list(&problem["c"]));
        let line: Vec<String> = c.iter().enumerate().map(|(k, c)| format!("({c:?})*p{k}")).collect();
        let (campaign, offer) = plain(&rows, &line.join(" + "));
        for (name, criterion) in [
            ("D", Criterion::D),
            ("A", Criterion::A),
            ("c", Criterion::C("c".into())),
            ("G", Criterion::G),
            ("E", Criterion::E),
        ] {
            let least = number(&problem["least"][name]);
            let request = Request {
                readings: problem["choose"].as_u64().unwrap() as usize,
                most_repeats: if problem["repeats"] == 1 { 1 } else { usize::MAX },
                criterion,
                ..Request::default()
            };
            let best = plan::improve(&campaign, &offer, &request).unwrap();
            // all are tried below 1e5
            assert_eq!(best.search.enumerated.is_some(), problem["designs"].as_u64().unwrap() < 100_000);
            let found = by_definition(&rows, &best.schedule, name, &c);
            // the bound: the least of all designs is no lower
            let bound = match name {
                "D" => found + n as f64 * best.search.efficiency.unwrap().ln(),
                _ => found * best.search.efficiency.unwrap(),
            };
            assert!(bound <= least + 1e-9 * least.abs(), "{name}: {bound} {least}");
            let short = (found - least) / least.abs().max(1.0);
            println!(
                "{:>8} {} of {:>2}, {n} unknowns, {name}: {found:.9} found, {least:.9} least",
                problem["kind"].as_str().unwrap(),
                request.readings,
                rows.len(),
            );
            assert!(short > -1e-9, "below the least of all designs");
            missed += usize::from(short > 1e-9);
        }
    }
    assert_eq!(missed, 0, "{missed} optima were missed");
}

/// A criterion of a schedule of plain rows, as the script has it.
fn by_definition(rows: &[Vec<Vec<f64>>], schedule: &tumble::campaign::Campaign, name: &str, c: &[f64]) -> f64 {
    let n = c.len();
    let matrix = |m: &[Vec<f64>]| DMatrix::from_fn(n, n, |i, j| m[i][j]);
    let inverse = |chosen: &[usize]| matrix(&information(rows, chosen)).try_inverse().unwrap();
    let own = inverse(&places(schedule));
    let all = inverse(&(0..rows.len()).collect::<Vec<_>>());
    let shares = DMatrix::from_fn(n, n, |i, j| own[(i, j)] / (all[(i, i)] * all[(j, j)]).sqrt());
    let form = |x: &[f64]| DVector::from_column_slice(x).dot(&(&own * DVector::from_column_slice(x)));
    match name {
        "D" => own.determinant().ln(),
        "A" => shares.trace(),
        "c" => form(c),
        "G" => rows.iter().map(|row| form(&row[0])).fold(0.0, f64::max),
        _ => shares.symmetric_eigenvalues().max(),
    }
}

/// The E-optimal weights of a parabola on [-1, 1] are 1/5, 3/5, 1/5, where `M` has the eigenvalue 1/5 (F. Pukelsheim, W. J. Studden, Ann. Statist.
/// 21 (1993) 402): five readings reach `lambda_max(M^-1) = 1` exactly, and the bound says that none are better. The three unknowns are tilts: level, they
/// move the forces along x and y by `-v` and `u`, and an Earth rate of 1 deg/s at the equator along x by `t`.
#[test]
fn the_e_optimal_parabola() {
    let places: Vec<f64> = (0..41).map(|j| f64::from(j) / 20.0 - 1.0).collect();
    let campaign = campaign(&format!(
        r#"{{ "bench": {{ "id": "level", "site": {{ "latitude_deg": 0, "earth_rate_deg_h": 3600 }}, "units": {{ "rate": "deg/s", "force": "g" }},
               "chain": [ {{ "tilt": "t", "about": "z" }}, {{ "tilt": "u", "about": "x" }}, {{ "tilt": "v", "about": "y" }} ],
               "sensors": {{ "y": {{ "model": "w_x + a_y*x - a_x*x^2" }} }} }},
             "estimate": {{ "t": {{}}, "u": {{}}, "v": {{}} }}, "readings": [ {{ "x": {places:?} }} ] }}"#
    ));
    let noise = Noise::new(&campaign, &[("y".into(), 1.0)], &[]).unwrap();
    let offer = offer(&campaign, noise, 45.0);
    let request = Request { readings: 5, criterion: Criterion::E, ..Request::default() };
    let best = plan::improve(&campaign, &offer, &request).unwrap();
    let mut chosen: Vec<f64> = best.schedule.readings.rows.iter().map(|row| row.columns[0].unwrap()).collect();
    chosen.sort_by(f64::total_cmp);
    assert_eq!(chosen, [-1.0, 0.0, 0.0, 0.0, 1.0]);
    let c = &best.judgement.covariance;
    let worst = DMatrix::from_fn(3, 3, |i, j| c[(i, j)]).symmetric_eigenvalues().max();
    assert!((worst - 1.0).abs() < 1e-12, "{worst}");
    assert!(best.search.efficiency.unwrap() > 0.999, "{:?}", best.search.efficiency);
}

/// Two readings of `b + c cos(beta)` tell most at 0 and 180 deg, `det M = 4`. A sweep of 50 deg has 0 and 200 deg at best, so moving the angles
/// gains `2/(1 + cos 20 deg) - 1 = 3.11 %` for each unknown; where 170 to 190 deg is forbidden they end at its edge.
#[test]
fn angles_move_between_the_candidates() {
    let campaign = campaign(
        r#"{ "bench": { "id": "head", "chain": [ { "joint": "beta", "about": "z" } ],
               "sensors": { "y": { "axes": { "I": "x" }, "model": "b + c*cos(beta)" } } },
             "estimate": { "b": {}, "c": {} }, "readings": [ { "beta_deg": [0, 50] } ] }"#,
    );
    let noise = Noise::new(&campaign, &[("y".into(), 1.0)], &[]).unwrap();
    let offer = offer(&campaign, noise, 50.0);
    let refine = |zones: Vec<plan::Zone>| Some(plan::Refinement { resolution_deg: 0.01, zones });
    let moved = |zones| {
        let request = Request { readings: 2, refine: refine(zones), ..Request::default() };
        let best = plan::improve(&campaign, &offer, &request).unwrap();
        let mut angles: Vec<f64> = best.schedule.readings.rows.iter().filter_map(|r| r.joints[0].keys().0).collect();
        angles.sort_by(f64::total_cmp);
        (angles, best.search.refined.unwrap())
    };
    let (angles, refined) = moved(Vec::new());
    let apart = (angles[1] - angles[0]).to_radians();
    let determinant = (angles[0].to_radians().cos() - angles[1].to_radians().cos()).powi(2);
    assert!((apart.cos() + 1.0).abs() < 1e-6 && (determinant - 4.0).abs() < 1e-6, "{angles:?}");
    assert!(refined.finished && refined.moved >= 1);
    assert_close(refined.gain, 2.0 / (1.0 + 20f64.to_radians().cos()) - 1.0, 1e-6);
    // 0 and 180 deg, or anything that far apart about them, is forbidden at one end
    let zone = |low: f64, high: f64| plan::Zone { limits: vec![("beta_deg".into(), low, high)] };
    let (angles, _) = moved(vec![zone(170.0, 190.0)]);
    let edge = angles.iter().map(|a| (a - 180.0).abs()).fold(f64::INFINITY, f64::min);
    assert!((edge - 10.01).abs() < 1e-6, "{angles:?}");
    let wrong = Request {
        readings: 2,
        refine: Some(plan::Refinement { resolution_deg: 0.0, zones: vec![] }),
        ..Request::default()
    };
    assert!(plan::improve(&campaign, &offer, &wrong).unwrap_err().to_string().contains("resolution"));
}

/// Candidates of no information at all, each allowed once, are no reason to go on for ever.
#[test]
fn empty_candidates_end_the_search() {
    let rows = [[0.0, 0.0], [0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0], [0.0, 0.0]];
    let rows: Vec<Vec<Vec<f64>>> = (0..240).map(|j| vec![rows[j % 6].to_vec()]).collect();
    let (campaign, offer) = plain(&rows, "p0");
    let request = Request { readings: 5, most_repeats: 1, starts: 40, ..Request::default() };
    let found = plan::improve(&campaign, &offer, &request).unwrap();
    let value = determinant(information(&rows, &places(&found.schedule)));
    assert!(value > 6.0 - 1e-9, "{value}");
}

/// With fewer than 1e5 designs every one is tried and the proof is complete, for G too and within budgets.
#[test]
fn few_designs_are_all_tried() {
    let campaign = published();
    let noise = Noise::new(&campaign, &[("V".into(), 9e-4)], &[]).unwrap();
    for criterion in [Criterion::D, Criterion::A, Criterion::G, Criterion::I, Criterion::C("gamma".into())] {
        let request =
            Request { readings: 30, unit: Unit::Mounting, criterion: criterion.clone(), ..Request::default() };
        let best = plan::improve(&campaign, &offer(&campaign, noise.clone(), 90.0), &request).unwrap();
        // C(16 + 5 - 1, 5) multisets of five mountings
        assert_eq!((best.search.enumerated, best.search.efficiency), (Some(15_504), Some(1.0)), "{criterion:?}");
    }
}

fn angles(campaign: &tumble::campaign::Campaign, arcsec: f64) -> Vec<Goal> {
    campaign.estimated()[1..].iter().map(|p| Goal { id: p.id.clone(), u: arcsec / report::ARCSEC }).collect()
}

/// The search's price is the report's cost, a larger budget is never worse, and neither is a sweep that holds another one.
#[test]
fn budgets_are_spent_and_more_is_never_worse() {
    let campaign = published();
    let noise = Noise::new(&campaign, &[("V".into(), 9e-4)], &[]).unwrap();
    let mut before = f64::INFINITY;
    for (budget, step) in [(103.0, 45.0), (105.0, 45.0), (105.0, 22.5)] {
        let request = Request { budget: Some(budget), ..Request::default() };
        let best = plan::improve(&campaign, &offer(&campaign, noise.clone(), step), &request).unwrap();
        let work = best.judgement.work;
        let covariance = &best.judgement.covariance;
        let n = covariance.nrows();
        let size: Vec<f64> = (0..n).map(|k| if k == 0 { 1e-4 } else { 1e-6 }).collect();
        let c = (0..n).map(|i| (0..n).map(|j| covariance[(i, j)] / size[i] / size[j]).collect()).collect();
        let value = determinant(c).ln();
        println!(
            "budget {budget} at {step} deg: {} readings in {} mountings for {}, log det C {value:.6}, at least {:.3} of the best",
            work.readings,
            work.mountings,
            work.cost,
            best.search.efficiency.unwrap()
        );
        assert!(work.cost <= budget + 1e-9 && work.cost > budget - 1.0, "{}", work.cost);
        assert!(value <= before + 1e-9, "{value} after {before}");
        before = value;
    }
    let mut least = f64::INFINITY;
    for step in [45.0, 22.5] {
        let request = Request { readings: 100, starts: 8, ..Request::default() };
        let found =
            plan::reach(&campaign, &offer(&campaign, noise.clone(), step), &request, &angles(&campaign, 0.5), true)
                .unwrap();
        let cost = found.improvement.judgement.work.cost;
        println!("every angle to 0.5 arcsec at {step} deg: cost {cost}, {} readings", found.improvement.chosen);
        assert!(found.goal.reached && cost <= least, "{cost} after {least}");
        least = cost;
    }
    // 82 was found before readings of one state were taken together
    assert!(least <= 82.0);
}

/// A derived quantity has a limit of its own, also where it has no derivative at the point: gamma is the length of two tilts.
#[test]
fn goals_on_derived_quantities() {
    let campaign = published();
    let noise = Noise::new(&campaign, &[("V".into(), 9e-4)], &[]).unwrap();
    let goal = [Goal { id: "gamma".into(), u: 0.8 / report::ARCSEC }];
    let request = Request { readings: 60, ..Request::default() };
    let found = plan::reach(&campaign, &offer(&campaign, noise, 45.0), &request, &goal, false).unwrap();
    let gamma = found.improvement.judgement.derived.iter().find(|d| d.id == "gamma").unwrap();
    assert!(found.goal.reached && gamma.u.unwrap() * report::ARCSEC <= 0.8, "{:?}", gamma.u);
    // u of gamma is at least that of the better known of its tilts, sd sqrt2 / (kI sqrt(sum of rates^2)) or more with N readings at 40 deg/s
    let fewest = (2f64.sqrt() * 9e-4 / (2.9222 * 40.0) * report::ARCSEC / 0.8).powi(2);
    assert!(found.improvement.chosen as f64 >= fewest && found.improvement.chosen < 40, "{}", found.improvement.chosen);
}

/// Exchanging senses of whole mountings takes the drift's shift away at no cost: below a quarter of what ABBA in every mounting leaves (0.154 u in
/// the published schedule). A dividing head in single steps takes neighbours on the way out and on the way back.
#[test]
fn orders_keep_drift_away() {
    let campaign = published();
    let noise = Noise::new(&campaign, &[("V".into(), 9e-4)], &[]).unwrap();
    let costs = Costs::default();
    let drift = |campaign: &tumble::campaign::Campaign| plan::judge(campaign, &noise, &costs).unwrap();
    let before = drift(&campaign.with_readings(plan::positions_only(&campaign.readings)));
    let unread = campaign.with_readings(plan::positions_only(&campaign.readings));
    let run = plan::ordered(&unread, &noise, &costs, Order::Abba, 1, 0).unwrap();
    let after = drift(&campaign.with_readings(run));
    println!("published: {:.3} u as given, {:.3} u in order", before.drift.unwrap(), after.drift.unwrap());
    assert!(after.drift.unwrap() < 0.025 && after.work.cost <= before.work.cost);
    let head = self::campaign(
        r#"{ "bench": { "id": "head", "chain": [ { "joint": "beta", "about": "x" }, { "tilt": "m", "about": "x" } ],
               "sensors": { "y": { "axes": { "I": "y" }, "model": "b + k*a_I" } } },
             "known": { "k": { "value": 1.3 } }, "estimate": { "b": {}, "m": {} },
             "readings": [ { "beta_deg": [0, 30, 60, 90, 120, 150, 180, 210, 240, 270, 300, 330, 0, 30, 60, 90, 120, 150, 180, 210, 240, 270, 300, 330] } ] }"#,
    );
    let names: Vec<(String, f64)> = head.bench.sensors.iter().map(|s| (s.id.clone(), 1e-4)).collect();
    let noise = Noise::new(&head, &names, &[]).unwrap();
    let judge = |campaign: &tumble::campaign::Campaign| plan::judge(campaign, &noise, &costs).unwrap();
    let before = judge(&head);
    let run = plan::ordered(&head, &noise, &costs, Order::Abba, 1, 0).unwrap();
    let after = judge(&head.with_readings(run));
    println!("dividing head: {:.3} u as given, {:.3} u in order", before.drift.unwrap(), after.drift.unwrap());
    assert!(after.drift.unwrap() < 0.02 && after.work.cost <= before.work.cost);
}

/// Times follow the order: those that the schedule has, or those that the work takes.
#[test]
fn times_follow_the_order() {
    let campaign = campaign(
        r#"{ "bench": { "id": "t", "chain": [ { "joint": "b", "about": "x" } ], "sensors": { "y": { "axes": { "I": "y" }, "model": "a + k*a_I + d*time_s" } } },
             "estimate": { "a": {}, "k": {}, "d": {} },
             "readings": [ { "b_deg": 0, "time_s": 0 }, { "b_deg": 270, "time_s": 60 }, { "b_deg": 90, "time_s": 120 }, { "b_deg": 10, "time_s": 180 } ] }"#,
    );
    let noise = Noise::new(&campaign, &[("y".into(), 0.1)], &[]).unwrap();
    let run = plan::ordered(&campaign, &noise, &Costs::default(), Order::Random, 3, 0).unwrap();
    let times: Vec<f64> =
        run.rows.iter().map(|r| r.columns[run.columns.iter().position(|c| c == "time_s").unwrap()].unwrap()).collect();
    assert_eq!(times, [0.0, 60.0, 120.0, 180.0]);
}

/// What is measured stays in front with its values; only what is new is ordered, listed and priced.
#[test]
fn what_is_measured_stays() {
    let whole = published();
    let noise = Noise::new(&whole, &[("V".into(), 9e-4)], &[]).unwrap();
    // half done: ten readings have values, two positions are still to be read
    let mut rows = whole.readings.rows[..12].to_vec();
    rows[10].observations = Vec::new().into();
    rows[11].observations = Vec::new().into();
    let half = whole.with_readings(Readings { rows, ..whole.readings.clone() });
    let planned = half.with_readings(plan::planned(&half, &half.readings));
    let judged = plan::judge(&planned, &noise, &Costs::default()).unwrap();
    assert_eq!(judged.readings.len(), 12, "positions without a value count too");
    let offer = Offer { kept: half.readings.clone(), ..offer(&whole, noise, 45.0) };
    let request = Request { readings: 6, ..Request::default() };
    let best = plan::improve(&planned, &offer, &request).unwrap();
    assert_eq!((best.kept, best.chosen, best.schedule.readings.rows.len()), (12, 6, 18));
    let value = |o: &[Observation]| o.first().map(|o| o.value);
    for (own, given) in best.schedule.readings.rows.iter().zip(&half.readings.rows).take(10) {
        assert_eq!((&own.joints, value(&own.observations)), (&given.joints, value(&given.observations)));
    }
    assert_eq!(
        best.reasons.iter().map(|r| &r.position).collect::<std::collections::BTreeSet<_>>().len(),
        best.reasons.len()
    );
}

/// One joint, `y = a + b cos + c sin`: three readings 120 degrees apart have u_a = sd/sqrt 3 and u_b = u_c = sd sqrt(2/3), which no three in steps of 45
/// degrees do; four 90 degrees apart have 1/2 and 1/sqrt 2.
fn circle() -> tumble::campaign::Campaign {
    campaign(
        r#"{ "bench": { "id": "circle", "chain": [ { "joint": "beta", "about": "z" } ], "sensors": { "y": { "model": "a + b*cos(beta) + c*sin(beta)" } } },
             "estimate": { "a": {}, "b": {}, "c": {} }, "readings": [ { "beta_deg": [0, 90, 180, 270, 45], "y_u": 1 } ] }"#,
    )
}

#[test]
fn a_goal_is_reached_with_fewer_between_the_candidates() {
    let campaign = circle();
    let noise = Noise::new(&campaign, &[], &[]).unwrap();
    let goals = [("a", 0.58), ("b", 0.82), ("c", 0.82)].map(|(id, u)| Goal { id: id.into(), u });
    let request = Request { readings: 12, ..Request::default() };
    let coarse = plan::reach(&campaign, &offer(&campaign, noise.clone(), 45.0), &request, &goals, false).unwrap();
    assert_eq!((coarse.goal.reached, coarse.improvement.chosen), (true, 4));
    let refine = Some(plan::Refinement { resolution_deg: 1.0, zones: Vec::new() });
    let fine =
        plan::reach(&campaign, &offer(&campaign, noise, 45.0), &Request { refine, ..request }, &goals, false).unwrap();
    assert_eq!((fine.goal.reached, fine.improvement.chosen, fine.goal.is_fewest), (true, 3, false));
    assert!(fine.improvement.search.refined.unwrap().moved > 0);
}

/// Degrees between positions cost: the work adds up the shorter ways, the order takes a round that no order beats, and a budget pays for the way.
#[test]
fn the_way_between_positions_is_paid_for() {
    let campaign = circle();
    let noise = Noise::new(&campaign, &[], &[]).unwrap();
    let costs = Costs { reading: 1.0, rate_change: 0.0, mounting: 2.0, index: 0.1 };
    // 90 + 90 + 90 + 135 degrees
    assert_close(costs.work(&campaign.readings.rows).cost, 5.0 * 3.0 + 40.5, 1e-12);
    let run = plan::ordered(&campaign, &noise, &costs, Order::Abba, 1, 0).unwrap();
    // 270, 0, 45, 90, 180 or the like: all round but for one of the gaps of 90
    assert_close(costs.work(&run.rows).cost, 5.0 * 3.0 + 27.0, 1e-12);
    let offer = Offer { costs, ..offer(&campaign, noise, 15.0) };
    for budget in [20.0, 40.0, 60.0] {
        let request = Request { readings: 0, budget: Some(budget), ..Request::default() };
        match plan::improve(&campaign, &offer, &request) {
            Ok(best) => {
                let cost = best.judgement.work.cost;
                println!("budget {budget}: {} readings for {cost}", best.chosen);
                assert!(cost <= budget * (1.0 + 1e-12));
                // one more reading at a mounting of its own would not be paid for by half of what is left over
                assert!(budget - cost < 12.0, "{cost} of {budget}");
            }
            Err(error) => {
                assert!(budget < 30.0, "{error}");
                assert!(error.to_string().contains("way between"), "{error}");
            }
        }
    }
}
