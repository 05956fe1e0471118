//! Plans against closed forms and fits of the published table.

use crate::plan_support::*;
use tumble::campaign::Readings;
use tumble::error::Fault;
use tumble::plan::{self, Costs, Criterion, Goal, Noise, Offer, Order, Request, Unit, Zone};
use tumble::{fit, report};

/// The D-optimal design of a parabola on [-1, 1] has a third of the weight at each of -1, 0, 1 (Fedorov 1972), so six readings reach
/// det M = 4 * 2^3 = 32 exactly, and the bound says so.
#[test]
fn bound_of_the_parabola() {
    let parabola: Vec<Vec<Vec<f64>>> =
        (0..41).map(|j| vec![(0..3).map(|c| (f64::from(j) / 20.0 - 1.0).powi(c)).collect()]).collect();
    let (campaign, offer) = plain(&parabola, "p0");
    let best = plan::improve(&campaign, &offer, &Request { readings: 6, ..Request::default() }).unwrap();
    assert_eq!(places(&best.schedule), [0, 0, 20, 20, 40, 40]);
    let c = &best.judgement.covariance;
    assert_close(determinant((0..3).map(|i| (0..3).map(|j| c[(i, j)]).collect()).collect()), 1.0 / 32.0, 1e-12);
    let efficiency = best.search.efficiency.unwrap();
    assert!(efficiency > 0.9999 && efficiency <= 1.0, "{efficiency}");
}

/// A schedule judged with the scatter of a fit's own residuals must promise what that fit reports.
#[test]
fn judgement_promises_what_the_fit_delivers() {
    let campaign = published();
    let fitted = fit::fit(&campaign, &fit::Settings::default()).unwrap();
    let noise = Noise::with_fit(&campaign, &[], &[], Some(&fitted)).unwrap();
    let judged = plan::judged_at(&campaign, &[], Some(&fitted)).unwrap().campaign;
    let judgement = plan::judge(&judged, &noise, &Costs::default()).unwrap();
    for (predicted, found) in judgement.parameters.iter().zip(&fitted.parameters) {
        assert_close(predicted.u.unwrap(), found.uncertainty.as_ref().unwrap().u, 1e-12);
    }
    let leverages: f64 = judgement.readings.iter().map(|r| r.leverage).sum();
    assert_close(leverages, 6.0, 1e-12);
}

/// Every mounting scatters a constant by s: m mountings of r readings give u^2 = s^2/m + sd^2/(m r).
#[test]
fn remounting_scatter_does_not_average_within_a_mounting() {
    let campaign = campaign(
        r#"{ "bench": { "id": "level", "sensors": { "y": { "model": "a + seat" } } }, "estimate": { "a": {} },
             "readings": [ { "position": "1", "run": [1, 2, 3] }, { "position": "2", "run": [1, 2, 3] }, { "position": "3", "run": [1, 2, 3] } ] }"#,
    );
    let noise = Noise::new(&campaign, &[("y".into(), 0.3)], &[("seat".into(), 0.5)]).unwrap();
    let judgement = plan::judge(&campaign, &noise, &Costs::default()).unwrap();
    let expected = (0.25_f64 / 3.0 + 0.09 / 9.0).sqrt();
    assert_close(judgement.parameters[0].u.unwrap(), expected, 1e-12);
    assert_eq!((judgement.rank, judgement.dof), (1, 8));
}

#[test]
fn what_is_not_estimable_is_named_with_the_position_that_separates_it() {
    let text = include_str!("../../data/campaigns/li2012-table1.campaign.json")
        .replace("\"beta_deg\": 180", "\"beta_deg\": 0")
        .replace("\"beta_deg\": 90", "\"beta_deg\": 0");
    let campaign = campaign(&text);
    let noise = Noise::new(&campaign, &[("V".into(), 9e-4)], &[]).unwrap();
    let judgement = plan::judge(&campaign, &noise, &Costs::default()).unwrap();
    assert!(!judgement.not_estimable.is_empty());
    assert!(judgement.not_estimable.iter().all(|s| s.separate_by.is_some()));
    // V0 is determined all the same
    assert!(judgement.parameters[0].u.is_some() && judgement.parameters.iter().any(|p| p.u.is_none()));
}

/// With gain g = rate, five mountings at multiples of 72 degrees make [1, cos b, sin b, cos a, sin a] orthogonal, so u^2 = sd^2 / (kI^2 sum g^2)
/// for the first and twice that for the others: no design of the same rates is better.
#[test]
fn five_positions_better_than_the_published_five() {
    let campaign = published();
    let noise = Noise::new(&campaign, &[("V".into(), 9e-4)], &[]).unwrap();
    let given = plan::judge(&campaign, &noise, &Costs::default()).unwrap();
    let request = Request { readings: 30, unit: Unit::Mounting, ..Request::default() };
    let best = plan::improve(&campaign, &offer(&campaign, noise, 36.0), &request).unwrap();
    assert_eq!((best.judgement.work.readings, best.judgement.work.mountings), (30, 5));
    assert!(
        best.search.efficiency.unwrap() > 0.9999 && best.check.unwrap() < 1e-12,
        "{:?} {:?}",
        best.search.efficiency,
        best.check
    );
    let sum: f64 = 10.0 * (400.0 + 900.0 + 1600.0);
    let alone = 9e-4 / (2.9222 * sum.sqrt());
    println!("{:12} {:>10} {:>10} {:>6}  arcsec", "angle", "published", "best", "gain");
    for (before, after) in given.parameters.iter().zip(&best.judgement.parameters) {
        let (u, v) = (before.u.unwrap(), after.u.unwrap());
        match after.id.as_str() {
            // the Earth turns the two senses a little apart: (W/rate)^2, below 1e-7
            "V0" => assert_close(v, 9e-4 / 30f64.sqrt(), 1e-6),
            "dtheta_y1" => assert_close(v, alone, 1e-6),
            _ => assert_close(v, alone * 2f64.sqrt(), 1e-6),
        }
        assert!(v <= u * (1.0 + 1e-9), "{} is worse", after.id);
        println!("{:12} {:10.4} {:10.4} {:6.2}", after.id, u * report::ARCSEC, v * report::ARCSEC, u / v);
    }
}

#[test]
fn adding_keeps_the_schedule_and_respects_repeats_and_senses() {
    let campaign = published();
    let noise = Noise::new(&campaign, &[("V".into(), 9e-4)], &[]).unwrap();
    let kept = Readings { rows: campaign.readings.rows[..10].to_vec(), ..campaign.readings.clone() };
    let offer = Offer { kept, ..offer(&campaign, noise, 45.0) };
    let request =
        Request { readings: 8, unit: Unit::Pair, most_repeats: 1, order: Order::AsGiven, ..Request::default() };
    let best = plan::improve(&campaign, &offer, &request).unwrap();
    let rows = &best.schedule.readings.rows;
    assert_eq!(rows.len(), 18);
    for (row, kept) in rows.iter().zip(&campaign.readings.rows[..10]) {
        assert_eq!((&row.position, &row.joints), (&kept.position, &kept.joints));
    }
    let rates: f64 = rows[10..].iter().map(|r| r.joints[0].rate_deg_s()).sum();
    assert_eq!(rates, 0.0, "both senses of every rate");
    for (k, row) in rows[10..].iter().enumerate() {
        assert!(rows[10..].iter().skip(k + 1).all(|other| other.joints != row.joints), "no portion twice");
    }
}

#[test]
fn same_seed_same_schedule_and_coordinate_exchange_agrees() {
    let campaign = published();
    let noise = Noise::new(&campaign, &[("V".into(), 9e-4)], &[]).unwrap();
    let offer = offer(&campaign, noise, 45.0);
    let request = Request { readings: 12, criterion: Criterion::A, unit: Unit::Pair, ..Request::default() };
    let run = |request: &Request| plan::improve(&campaign, &offer, request).unwrap();
    let (first, second) = (run(&request), run(&request));
    let joints = |own: &tumble::Campaign| own.readings.rows.iter().map(|r| r.joints.clone()).collect::<Vec<_>>();
    assert_eq!(joints(&first.schedule), joints(&second.schedule));
    let coordinate = run(&Request { method: plan::Method::Coordinate, ..request.clone() });
    assert_close(coordinate.search.efficiency.unwrap(), first.search.efficiency.unwrap(), 1e-6);
    let random = run(&Request { order: Order::Random, ..request.clone() });
    assert!(random.judgement.drift.unwrap() < 1.0 && random.judgement.work.readings == 12);
}

#[test]
fn c_optimal_for_a_slope_is_both_ends_and_g_agrees_with_d() {
    let campaign = line("[-1, -0.5, 0, 0.5, 1]");
    let noise = Noise::new(&campaign, &[("y".into(), 1.0)], &[]).unwrap();
    let offer = offer(&campaign, noise, 45.0);
    let slope = Request { readings: 4, criterion: Criterion::C("b".into()), ..Request::default() };
    let best = plan::improve(&campaign, &offer, &slope).unwrap();
    assert_close(best.judgement.parameters[1].u.unwrap(), 0.5, 1e-12);
    assert!(best.search.efficiency.unwrap() > 0.9999);
    // Kiefer and Wolfowitz: the D-optimal weights are G-optimal, largest prediction variance n/N = 2/4
    let g = plan::improve(&campaign, &offer, &Request { criterion: Criterion::G, ..slope.clone() }).unwrap();
    assert_close(g.search.efficiency.unwrap(), 1.0, 1e-9);
}

/// u = sd/sqrt(n) of a constant: a goal of 0.25 at sd 1 needs 16 readings, and 15 cannot do it.
#[test]
fn goals_are_reached_with_the_fewest_readings_or_not_at_all() {
    let campaign = campaign(
        r#"{ "bench": { "id": "level", "sensors": { "y": { "model": "a" } } }, "estimate": { "a": {} }, "readings": [ { "run": 1 } ] }"#,
    );
    let noise = Noise::new(&campaign, &[("y".into(), 1.0)], &[]).unwrap();
    let offer = offer(&campaign, noise, 45.0);
    let goal = [Goal { id: "a".into(), u: 0.25 }];
    let reach = |most: usize| {
        plan::reach(&campaign, &offer, &Request { readings: most, ..Request::default() }, &goal, false).unwrap()
    };
    let reached = reach(100);
    assert!(
        reached.goal.reached && reached.goal.is_fewest && reached.improvement.chosen == 16,
        "{}",
        reached.improvement.chosen
    );
    let short = reach(9);
    assert!(!short.goal.reached && short.improvement.chosen == 9);
    assert_close(short.goal.largest_share.unwrap(), (1.0 / 3.0) / 0.25, 1e-12);
}

#[test]
fn every_angle_to_one_arcsecond_and_cheapest_costs_no_more() {
    let campaign = published();
    let noise = Noise::new(&campaign, &[("V".into(), 9e-4)], &[]).unwrap();
    let offer = offer(&campaign, noise, 45.0);
    let goals: Vec<Goal> =
        campaign.estimated()[1..].iter().map(|p| Goal { id: p.id.clone(), u: 1.0 / report::ARCSEC }).collect();
    let request = Request { readings: 60, starts: 20, ..Request::default() };
    let fewest = plan::reach(&campaign, &offer, &request, &goals, false).unwrap();
    let cheapest = plan::reach(&campaign, &offer, &request, &goals, true).unwrap();
    let (cost, least) = (fewest.improvement.judgement.work.cost, cheapest.improvement.judgement.work.cost);
    println!(
        "fewest: {} readings, cost {} (proven: {}); cheapest: {} readings, cost {}",
        fewest.improvement.chosen, cost, fewest.goal.is_fewest, cheapest.improvement.chosen, least
    );
    assert!(fewest.goal.reached && cheapest.goal.reached && least <= cost);
    let angles = fewest.improvement.judgement.parameters.iter().filter_map(|p| p.u_arcsec);
    assert!(angles.clone().count() == 5 && angles.fold(0.0, f64::max) <= 1.0);
}

#[test]
fn malformed_questions_say_what_is_wrong() {
    let campaign = published();
    let noise = || Noise::new(&campaign, &[("V".into(), 9e-4)], &[]).unwrap();
    let schedule = line("[0, 1]");
    let error = Noise::new(&schedule, &[], &[]).unwrap_err();
    assert!(error.fault() == Fault::Missing && error.remedy() == Some(("noise", "y=SD")), "{error}");
    for (given, remount) in
        [(("W", 1.0), None), (("V", -1.0), None), (("V", f64::NAN), None), (("V", 1.0), Some(("dtheta_q", 1.0)))]
    {
        let remount: Vec<(String, f64)> =
            remount.into_iter().map(|(id, sd): (&str, f64)| (id.to_string(), sd)).collect();
        let error = Noise::new(&campaign, &[(given.0.to_string(), given.1)], &remount).unwrap_err();
        assert!(error.expectation().is_some(), "{error}");
    }
    assert!(
        plan::sweep(&campaign, 0.0).is_err()
            && plan::sweep(&campaign, f64::NAN).is_err()
            && plan::sweep(&campaign, 0.01).is_err()
    );
    let all = plan::sweep(&campaign, 45.0).unwrap();
    let zone = |key: &str, low, high| vec![Zone { limits: vec![(key.to_string(), low, high)] }];
    assert!(plan::without(&campaign, all.clone(), &zone("alpha", 0.0, 1.0)).is_err());
    assert!(plan::without(&campaign, all.clone(), &zone("gamma_deg_s", 10.0, 1.0)).is_err());
    assert!(plan::without(&campaign, all.clone(), &zone("alpha_deg", 0.0, 360.0)).is_err());
    let some = plan::without(&campaign, all.clone(), &zone("alpha_deg", -45.0, 45.0)).unwrap();
    assert_eq!(some.rows.len(), all.rows.len() / 8 * 5, "an interval may run through 0");
    let offer = offer(&campaign, noise(), 45.0);
    let improve = |request: Request| plan::improve(&campaign, &offer, &request).unwrap_err().to_string();
    assert!(improve(Request { readings: 0, ..Request::default() }).contains("0 readings"));
    assert!(improve(Request { readings: 7, unit: Unit::Pair, ..Request::default() }).contains("multiple of 2"));
    assert!(improve(Request { readings: 3, ..Request::default() }).contains("at least 6 readings"));
    let c = Criterion::C("dtheta_q".into());
    assert!(improve(Request { readings: 30, criterion: c, ..Request::default() }).contains("dtheta_q"));
    let empty = Offer { candidates: none(&campaign), ..offer.clone() };
    let error = plan::improve(&campaign, &empty, &Request { readings: 6, ..Request::default() }).unwrap_err();
    assert!(error.to_string().contains("no candidate positions"));
    let goals = [Goal { id: "kOS".into(), u: 1.0 }];
    assert!(plan::reach(&campaign, &offer, &Request { readings: 6, ..Request::default() }, &goals, false).is_err());
}

/// A scale factor error moves no angle at zero tilts and `x u(kI) / kI` at a tilt x: what a fit finds at tilts of 100 arcsec is what the plan promised.
#[test]
fn known_inputs_act_through_tilts_of_the_stated_size() {
    let text = include_str!("../../data/campaigns/li2012-table1.campaign.json").replace("\"u\": 0\n", "\"u\": 0.03\n");
    let campaign = campaign(&text);
    let base = Noise::new(&campaign, &[("V".into(), 9e-4)], &[]).unwrap();
    let none = plan::judge(&campaign, &base, &Costs::default()).unwrap();
    let told = none.through_tilts.clone().unwrap();
    assert!(!told.counted && told.known == "kI" && none.parameters.iter().all(|p| p.from_known < 1e-9));
    let size = 100.0 / report::ARCSEC;
    let stated = plan::judge(&campaign, &Noise { tilts: Some(size), ..base }, &Costs::default()).unwrap();
    assert!(stated.through_tilts.unwrap().counted);
    for p in stated.parameters.iter().filter(|p| p.id.starts_with("dtheta")) {
        assert_close(p.from_known, size * 0.03 / 2.9222, 1e-4);
        println!("{}: {:.4} arcsec from kI", p.id, p.from_known * report::ARCSEC);
    }
}
