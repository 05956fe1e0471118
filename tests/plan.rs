//! Plans against closed forms, full enumeration of small cases, and fits of the published table.

use tumble::algebra::Expression;
use tumble::campaign::{Campaign, Readings};
use tumble::diagnosis::{self, Fate};
use tumble::error::Fault;
use tumble::plan::{self, Blocks, Costs, Criterion, Goal, Noise, Objective, Offer, Order, Request, Term, Unit, Zone};
use tumble::simulate::Regressor;
use tumble::wire::{self, Source};
use tumble::{fit, report, simulate};

fn campaign(text: &str) -> Campaign {
    let source = Source { name: "test".into(), text: text.into() };
    wire::read_campaign(&source, &mut |_| panic!("nothing to fetch")).unwrap()
}

fn published() -> Campaign {
    campaign(include_str!("../data/campaigns/li2012-table1.campaign.json"))
}

fn line(readings: &str) -> Campaign {
    campaign(&format!(
        r#"{{ "bench": {{ "id": "line", "sensors": {{ "y": {{ "model": "a + b*x + c*z" }} }} }},
             "estimate": {{ "a": {{}}, "b": {{}} }}, "readings": [ {{ "x": {readings}, "z": 1 }} ] }}"#
    ))
}

fn none(like: &Campaign) -> Readings {
    Readings { columns: like.readings.columns.clone(), rows: Vec::new() }
}

/// Everything chosen anew from a sweep.
fn offer(campaign: &Campaign, noise: Noise, step_deg: f64) -> Offer {
    Offer { kept: none(campaign), candidates: plan::sweep(campaign, step_deg).unwrap(), noise, costs: Costs::default() }
}

fn assert_close(found: f64, expected: f64, relative: f64) {
    assert!((found - expected).abs() <= relative * expected.abs(), "found {found}, expected {expected}");
}

/// Determinant by elimination, independent of the crate.
fn determinant(mut m: Vec<Vec<f64>>) -> f64 {
    let n = m.len();
    let mut product = 1.0;
    for k in 0..n {
        let p = (k..n).max_by(|&a, &b| m[a][k].abs().total_cmp(&m[b][k].abs())).unwrap();
        if m[p][k] == 0.0 {
            return 0.0;
        }
        if p != k {
            m.swap(p, k);
            product = -product;
        }
        product *= m[k][k];
        for i in k + 1..n {
            let f = m[i][k] / m[k][k];
            let (above, below) = m.split_at_mut(i);
            below[0].iter_mut().zip(&above[k]).skip(k).for_each(|(x, p)| *x -= f * p);
        }
    }
    product
}

fn information(blocks: &Blocks, chosen: &[usize]) -> Vec<Vec<f64>> {
    let n = blocks.unknowns();
    let mut m = vec![vec![0.0; n]; n];
    for &j in chosen {
        for r in 0..blocks.rows() {
            let x = blocks.row(j, r);
            for a in 0..n {
                for b in 0..n {
                    m[a][b] += x[a] * x[b];
                }
            }
        }
    }
    m
}

/// Inverse by cofactors, independent of the crate.
fn inverse(m: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let n = m.len();
    let whole = determinant(m.to_vec());
    let minor = |a: usize, b: usize| {
        let rows = (0..n).filter(|i| *i != a);
        determinant(rows.map(|i| (0..n).filter(|j| *j != b).map(|j| m[i][j]).collect()).collect())
    };
    let sign = |k: usize| if k.is_multiple_of(2) { 1.0 } else { -1.0 };
    (0..n).map(|i| (0..n).map(|j| sign(i + j) * minor(j, i) / whole).collect()).collect()
}

/// The objective of a choice from its definition; infinite where it is singular.
fn by_definition(blocks: &Blocks, objective: &Objective, chosen: &[usize]) -> f64 {
    let m = information(blocks, chosen);
    let whole = determinant(m.clone());
    if whole < 1e-9 {
        return f64::INFINITY;
    }
    let n = blocks.unknowns();
    match objective {
        Objective::Determinant => -whole.ln(),
        Objective::Trace(w) => {
            let c = inverse(&m);
            (0..n).flat_map(|i| (0..n).map(move |j| (i, j))).map(|(i, j)| w[i * n + j] * c[i][j]).sum()
        }
        Objective::Largest(rows) => {
            let c = inverse(&m);
            let quadratic =
                |x: &[f64]| -> f64 { (0..n).map(|i| (0..n).map(|j| x[i] * c[i][j] * x[j]).sum::<f64>()).sum() };
            let all = (0..rows.count()).flat_map(|j| (0..rows.rows()).map(move |r| (j, r)));
            all.map(|(j, r)| quadratic(&rows.row(j, r))).fold(0.0, f64::max)
        }
    }
}

/// All multisets of `count` out of `of`, each at most `repeats` times.
fn multisets(of: usize, count: usize, repeats: usize) -> Vec<Vec<usize>> {
    let mut all = vec![Vec::new()];
    for _ in 0..count {
        all = all
            .iter()
            .flat_map(|s: &Vec<usize>| {
                (s.last().copied().unwrap_or(0)..of)
                    .filter(|j| s.iter().filter(|k| *k == j).count() < repeats)
                    .map(|j| s.iter().copied().chain([j]).collect())
                    .collect::<Vec<Vec<usize>>>()
            })
            .collect();
    }
    all
}

/// Rows without symmetry, so that the optimum is one design only.
fn uneven(count: usize, rows: usize, n: usize) -> Blocks {
    Blocks::from_fn(count, rows, n, |j, r, c| {
        let angle = (j * (r + 2)) as f64 * 0.7 + 0.3 * r as f64;
        (c as f64 * angle).cos() + 0.3 * (angle * 1.7 + c as f64).sin()
    })
}

/// Every criterion, with and without a limit on repeats, portions of one row and of several: the exchange ends at the best of all designs.
#[test]
fn exchange_finds_what_full_enumeration_finds() {
    println!("{:>24} {:>9} {:>12} {:>12} {:>12} {:>12}", "case", "designs", "D", "A", "c", "G");
    for (count, rows, n, choose, repeats) in [
        (9, 1, 3, 4, 9),
        (9, 1, 3, 5, 1),
        (7, 2, 3, 3, 7),
        (8, 2, 4, 3, 1),
        (10, 1, 4, 6, 2),
        (6, 4, 3, 3, 6),
        (7, 3, 5, 4, 2),
    ] {
        let blocks = uneven(count, rows, n);
        let all = multisets(count, choose, repeats);
        let square = |f: &dyn Fn(usize, usize) -> f64| (0..n * n).map(|k| f(k / n, k % n)).collect::<Vec<f64>>();
        let sum = Objective::Trace(square(&|i, j| f64::from(u8::from(i == j))));
        let one = Objective::Trace(square(&|i, j| ((i + 1) * (j + 1)) as f64));
        let mut line = format!("{choose:>2} of {count:>2} x {rows}, {n} unknowns {:>9}", all.len());
        for objective in [Objective::Determinant, sum, one, Objective::Largest(blocks.clone())] {
            let best = all.iter().map(|s| by_definition(&blocks, &objective, s)).fold(f64::INFINITY, f64::min);
            let found = plan::choose(&blocks, choose, repeats, &objective, 60, 3, true).unwrap();
            assert!(
                (found.value - best).abs() <= 1e-9 * best.abs().max(1.0),
                "{choose} of {count} x {rows}: {} {best}",
                found.value
            );
            assert!((by_definition(&blocks, &objective, &found.chosen) - best).abs() <= 1e-9 * best.abs().max(1.0));
            let (bound, reach) = (found.bound.unwrap(), found.weights_reach.unwrap());
            assert!(bound <= best + 1e-9 * best.abs(), "the bound must not be beaten: {bound} {best}");
            assert!(bound <= reach + 1e-12 * reach.abs(), "{bound} {reach}");
            line.push_str(&format!(" {best:>12.6}"));
        }
        println!("{line}");
    }
}

/// The D-optimal design of a parabola on [-1, 1] has a third of the weight at each of -1, 0, 1 (Fedorov 1972), so six readings reach
/// det M = 4 * 2^3 = 32 exactly, and the bound says so.
#[test]
fn bound_of_the_parabola() {
    let parabola = Blocks::from_fn(41, 1, 3, |j, _, c| (j as f64 / 20.0 - 1.0).powi(c as i32));
    let best = plan::choose(&parabola, 6, usize::MAX, &Objective::Determinant, 10, 1, true).unwrap();
    assert_eq!(best.chosen, [0, 0, 20, 20, 40, 40]);
    assert_close((-best.value).exp(), 32.0, 1e-12);
    let efficiency = ((best.bound.unwrap() - best.value) / 3.0).exp();
    assert!(efficiency > 0.9999 && efficiency <= 1.0 + 1e-12, "{efficiency}");
}

/// Efficiencies on the shipped bench, 30 readings in each case, and the reason of every shortfall: the bound is never loose by more than a few
/// 1e-5, and on 16 and 25 mountings all 15,504 and 118,755 choices of five are tried, so the search is not at fault either. What is left is
/// that five mountings cannot follow the best weights; pairs and single readings of the same rates can.
#[test]
fn efficiencies_and_why_they_fall_short() {
    let campaign = published();
    let noise = Noise::new(&campaign, &[("V".into(), 9e-4)], &[]).unwrap();
    let criteria = [Criterion::D, Criterion::A, Criterion::G, Criterion::C("dtheta_z2".into())];
    println!("30 readings as     step  criterion        efficiency  bound loose by  same by enumeration");
    for (unit, step) in [
        (Unit::Mounting, 36.0),
        (Unit::Mounting, 45.0),
        (Unit::Mounting, 72.0),
        (Unit::Mounting, 90.0),
        (Unit::Pair, 36.0),
        (Unit::Reading, 36.0),
    ] {
        for criterion in &criteria {
            let offer = offer(&campaign, noise.clone(), step);
            let request = Request { readings: 30, unit, criterion: criterion.clone(), ..Request::default() };
            let best = plan::improve(&campaign, &offer, &request).unwrap();
            let (efficiency, gap) = (best.efficiency.unwrap(), best.bound_gap.unwrap());
            let enumerated = if unit == Unit::Mounting && step >= 72.0 {
                let found = enumerated(&campaign, &noise, step, criterion);
                let own = criterion_of(&campaign, &noise, step, criterion, &best.schedule);
                assert!((own / found - 1.0).abs() < 1e-7, "{criterion:?} at {step}: {own} against {found}");
                "yes"
            } else {
                "-"
            };
            println!(
                "{unit:>14?} {step:>6} deg  {:<15} {efficiency:>11.4} {gap:>15.1e}  {enumerated}",
                format!("{criterion:?}")
            );
            assert!(gap < 2e-4, "the bound is loose by {gap}");
            assert!(best.check.unwrap() < 1e-9, "fresh QR: {:?}", best.check);
            if unit != Unit::Mounting {
                assert!(efficiency >= 0.99, "{unit:?} {criterion:?}: {efficiency}");
            }
        }
    }
}

/// Rows over their noise at the mountings of a sweep: one matrix for each mounting.
fn mounting_rows(campaign: &Campaign, noise: &Noise, step: f64) -> Vec<Vec<Vec<f64>>> {
    let candidates = campaign.with_readings(plan::sweep(campaign, step).unwrap());
    let model = tumble::design::Model::new(&candidates).unwrap();
    let design = tumble::design::assemble(&candidates, &model, &candidates.reference_point()).unwrap();
    let mut by_place: std::collections::BTreeMap<String, Vec<Vec<f64>>> = std::collections::BTreeMap::new();
    for (i, origin) in design.rows.iter().enumerate() {
        let key = format!("{:?}", &candidates.readings.rows[origin.reading].joints[1..]);
        let row = (0..campaign.unknowns()).map(|j| design.jacobian[(i, j)] / noise.sensors[0].sd).collect();
        by_place.entry(key).or_default().push(row);
    }
    by_place.into_values().collect()
}

/// The criterion by its definition, from rows.
fn of_rows(rows: &[&Vec<f64>], predicted: &[Vec<f64>], criterion: &Criterion) -> f64 {
    let n = 6;
    // in units of each unknown's own information, so that a pivot near zero is a combination that the choice leaves open
    let size: Vec<f64> = (0..n).map(|k| rows.iter().map(|x| x[k] * x[k]).sum::<f64>().sqrt()).collect();
    let mut l = [[0.0_f64; 6]; 6];
    for i in 0..n {
        for j in 0..=i {
            let m = rows.iter().map(|x| x[i] / size[i] * x[j] / size[j]).sum::<f64>();
            let left = m - (0..j).map(|k| l[i][k] * l[j][k]).sum::<f64>();
            l[i][j] = if i == j { left.max(0.0).sqrt() } else { left / l[j][j] };
        }
        if !(l[i][i] > 1e-5) {
            return f64::INFINITY;
        }
    }
    let log_det: f64 = (0..n).map(|k| 2.0 * (l[k][k] * size[k]).ln()).sum();
    if *criterion == Criterion::D {
        return (-log_det / n as f64).exp();
    }
    // y = L^-1 x, so that x' M^-1 x = y'y
    let spread = |x: &[f64]| {
        let mut y = [0.0; 6];
        for i in 0..n {
            y[i] = (x[i] / size[i] - (0..i).map(|k| l[i][k] * y[k]).sum::<f64>()) / l[i][i];
        }
        y.iter().map(|v| v * v).sum::<f64>()
    };
    let unit = |k: usize| (0..n).map(|j| f64::from(u8::from(j == k))).collect::<Vec<f64>>();
    match criterion {
        Criterion::A => (1..n).map(|k| spread(&unit(k))).sum(),
        Criterion::G => predicted.iter().map(|x| spread(x)).fold(0.0, f64::max),
        _ => spread(&unit(5)),
    }
}

fn criterion_of(campaign: &Campaign, noise: &Noise, step: f64, criterion: &Criterion, schedule: &Campaign) -> f64 {
    let model = tumble::design::Model::new(schedule).unwrap();
    let design = tumble::design::assemble(schedule, &model, &schedule.reference_point()).unwrap();
    let row = |i: usize| (0..6).map(|j| design.jacobian[(i, j)] / noise.sensors[0].sd).collect::<Vec<f64>>();
    let rows: Vec<Vec<f64>> = (0..design.rows.len()).map(row).collect();
    let predicted: Vec<Vec<f64>> = mounting_rows(campaign, noise, step).concat();
    of_rows(&rows.iter().collect::<Vec<_>>(), &predicted, criterion)
}

/// The best criterion over all choices of five mountings.
fn enumerated(campaign: &Campaign, noise: &Noise, step: f64, criterion: &Criterion) -> f64 {
    let places = mounting_rows(campaign, noise, step);
    let predicted = places.concat();
    let all = multisets(places.len(), 5, 5);
    assert!(all.len() == if step == 90.0 { 15_504 } else { 118_755 });
    let value = |s: &Vec<usize>| {
        let rows: Vec<&Vec<f64>> = s.iter().flat_map(|p| &places[*p]).collect();
        of_rows(&rows, &predicted, criterion)
    };
    all.iter().map(value).fold(f64::INFINITY, f64::min)
}

/// A schedule judged with the scatter of a fit's own residuals must promise what that fit reports.
#[test]
fn judgement_promises_what_the_fit_delivers() {
    let campaign = published();
    let noise = Noise::new(&campaign, &[], &[]).unwrap();
    let judgement = plan::judge(&campaign, &noise, &Costs::default()).unwrap();
    let fitted = fit::fit(&campaign, &fit::Settings::default()).unwrap();
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
    let text = include_str!("../data/campaigns/li2012-table1.campaign.json")
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
    assert!(best.efficiency.unwrap() > 0.9999 && best.check.unwrap() < 1e-12, "{:?} {:?}", best.efficiency, best.check);
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
    let joints = |i: &plan::Improvement| i.schedule.readings.rows.iter().map(|r| r.joints.clone()).collect::<Vec<_>>();
    assert_eq!(joints(&first), joints(&second));
    let coordinate = run(&Request { method: plan::Method::Coordinate, ..request.clone() });
    assert_close(coordinate.efficiency.unwrap(), first.efficiency.unwrap(), 1e-6);
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
    assert!(best.efficiency.unwrap() > 0.9999);
    // Kiefer and Wolfowitz: the D-optimal weights are G-optimal, largest prediction variance n/N = 2/4
    let g = plan::improve(&campaign, &offer, &Request { criterion: Criterion::G, ..slope.clone() }).unwrap();
    assert_close(g.efficiency.unwrap(), 1.0, 1e-9);
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
    assert!(reached.reached && reached.is_fewest && reached.improvement.chosen == 16, "{}", reached.improvement.chosen);
    let short = reach(9);
    assert!(!short.reached && short.improvement.chosen == 9);
    assert_close(short.largest_share.unwrap(), (1.0 / 3.0) / 0.25, 1e-12);
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
    let cost = |r: &plan::Reached| r.improvement.judgement.work.cost;
    println!(
        "fewest: {} readings, cost {} (proven: {}); cheapest: {} readings, cost {}",
        fewest.improvement.chosen,
        cost(&fewest),
        fewest.is_fewest,
        cheapest.improvement.chosen,
        cost(&cheapest)
    );
    assert!(fewest.reached && cheapest.reached && cost(&cheapest) <= cost(&fewest));
    assert!(fewest.improvement.judgement.largest_angle_u().unwrap() * report::ARCSEC <= 1.0);
}

/// On x = -1 and 1 alone, x^2 and x^4 are both constants; the added positions must tell them apart.
#[test]
fn positions_that_tell_two_effects_apart() {
    let campaign = line("[-1, 1]");
    let noise = Noise::new(&campaign, &[("y".into(), 0.1)], &[]).unwrap();
    let candidates = line("[-1, -0.7, 0, 0.4, 0.7, 1]").readings;
    let offer = Offer { kept: campaign.readings.clone(), candidates, noise, costs: Costs::default() };
    let term = |text: &str| Term { sensor: Some(0), regressor: Regressor::Term(Expression::parse(text).unwrap()) };
    let apart = plan::discriminate(&campaign, &offer, [&term("x^2"), &term("x^4")], 2, 20, 1).unwrap();
    assert_eq!(apart.before, [None, None]);
    assert!(apart.after.iter().all(Option::is_some) && apart.positions.len() >= 2);
    // the same term twice is told apart by nothing
    let same = plan::discriminate(&campaign, &offer, [&term("x^2"), &term("x*x")], 2, 20, 1).unwrap();
    assert!(same.positions.is_empty() && same.after == [None, None]);
}

#[test]
fn malformed_questions_say_what_is_wrong() {
    let campaign = published();
    let noise = || Noise::new(&campaign, &[("V".into(), 9e-4)], &[]).unwrap();
    let fault = |error: tumble::error::Malformed| (error.fault(), error.to_string());
    let schedule = line("[0, 1]");
    let (kind, text) = fault(Noise::new(&schedule, &[], &[]).unwrap_err());
    assert!(kind == Fault::Missing && text.contains("--noise y=SD"), "{text}");
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
    assert!(plan::without(&campaign, all.clone(), &zone("alpha_deg", 10.0, 1.0)).is_err());
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

/// A straight line from x = -1 and 1 only: a quadratic hides in the constant, a cubic in the slope, and both shift them by what they are there.
#[test]
fn absorbed_effects_are_named_with_the_parameter_that_hides_them() {
    let line = line("[-1, 1, -1, 1]");
    let noise = Noise::new(&line, &[("y".into(), 0.1)], &[]).unwrap();
    let text = r#"{ "effects": [ { "term": "x^2", "name": "quadratic" }, { "term": "x^3", "name": "cubic" }, { "term": "x^2 - 1", "name": "nothing" } ] }"#;
    let effects = wire::read_effects(&Source { name: "effects".into(), text: text.into() }).unwrap();
    let foresight = diagnosis::foresee(&line, &effects, &noise).unwrap();
    let fates: Vec<_> =
        foresight.prospects.iter().map(|p| (p.effect.name.as_str(), p.fate, p.hides_in.clone())).collect();
    assert_eq!(fates[0], ("quadratic", Fate::Absorbed, vec![0]));
    assert_eq!(fates[1], ("cubic", Fate::Absorbed, vec![1]));
    assert_close(foresight.prospects[0].shifts[0], 1.0, 1e-12);
    // on -1, 0, 1 the quadratic is seen: c' = (1/3, -2/3, 1/3), so u = sd / sqrt(2/3); the cubic still hides
    let campaign = self::line("[-1, 0, 1]");
    let foresight = diagnosis::foresee(&campaign, &effects, &noise).unwrap();
    let quadratic = &foresight.prospects[0];
    assert_eq!((quadratic.fate, foresight.prospects[1].fate), (Fate::Detectable, Fate::Absorbed));
    assert_close(quadratic.u.unwrap(), 0.1 / (2.0_f64 / 3.0).sqrt(), 1e-12);
    assert_close(quadratic.minimal.unwrap(), foresight.rule.noncentrality * quadratic.u.unwrap(), 1e-12);
}

/// A campaign made with an effect of the promised smallest size is diagnosed with the
/// promised power, whatever its name: 100 seeds, normal noise of stated size.
#[test]
fn effects_of_the_smallest_size_are_found_with_the_promised_power() {
    let campaign = published();
    let noise = Noise::new(&campaign, &[("V".into(), 9e-4)], &[]).unwrap();
    let effects = wire::built_in_effects().unwrap();
    let foresight = diagnosis::foresee(&campaign, &effects, &noise).unwrap();
    let find = |name: &str| foresight.prospects.iter().find(|p| p.effect.regressor == name).unwrap();
    assert_eq!(find("a_S").group, find("a_S^2").group);
    assert_eq!((find("w_S").fate, find("w_S").hides_in.len()), (Fate::Absorbed, 1));
    assert_eq!(find("w_I*w_O").fate, Fate::NotExercised);
    println!("{:?}", foresight.rule);
    let schedule = campaign.with_readings(plan::positions_only(&campaign.readings));
    for name in ["a_S", "w_O^2", "sign(gamma_deg_s)"] {
        let prospect = find(name);
        let truth = |share: f64| simulate::Truth {
            point: campaign.reference_point(),
            noise: vec![simulate::Noise { sd: 9e-4, stated: true, decimals: None }],
            effects: vec![simulate::Hidden {
                regressor: prospect.effect.kind.clone(),
                value: share * prospect.minimal.unwrap(),
                sensor: Some(0),
            }],
        };
        let found = |share: f64| {
            (0..100)
                .filter(|seed| {
                    let measured = simulate::simulate(&schedule, &truth(share), *seed).unwrap();
                    let made = diagnosis::diagnose(&measured, &effects, &diagnosis::Settings::default()).unwrap();
                    made.verdict != diagnosis::Verdict::NothingMissing
                })
                .count() as f64
                / 100.0
        };
        let (half, whole) = (found(0.5), found(1.0));
        println!("{name:>20}: found {half:.2} at half the size, {whole:.2} at the smallest size");
        assert!((0.68..=0.92).contains(&whole) && half < 0.3, "{name}: {half} {whole}");
    }
}

/// What a further reading adds to T, against a fresh adjustment with it: rank-one updates and definition agree, and the best comes first.
#[test]
fn positions_that_tell_are_best_first() {
    let campaign = line("[-1, -1, 1, 1, 0.5]");
    let noise = Noise::new(&campaign, &[("y".into(), 0.2)], &[]).unwrap();
    let candidates = line("[-0.9, -0.6, -0.3, 0, 0.2, 0.4, 0.8]").readings;
    let offer = Offer { kept: campaign.readings.clone(), candidates, noise: noise.clone(), costs: Costs::default() };
    let term = |text: &str| Term { sensor: Some(0), regressor: Regressor::Term(Expression::parse(text).unwrap()) };
    let [a, b] = [term("x^2"), term("x^3")];
    let list = plan::telling(&campaign, &offer, &a, std::slice::from_ref(&b)).unwrap();
    // T = 1 / variance of the coefficient of x^2 beside 1, x, x^3
    let t = |xs: &[f64]| {
        let rows: Vec<Vec<f64>> = xs.iter().map(|x| vec![1.0, *x, x * x * x, x * x]).collect();
        let m: Vec<Vec<f64>> =
            (0..4).map(|i| (0..4).map(|j| rows.iter().map(|r| r[i] * r[j]).sum::<f64>() / 0.04).collect()).collect();
        let whole = determinant(m.clone());
        let rest = determinant(m[..3].iter().map(|r| r[..3].to_vec()).collect());
        if rest > 1e-12 { whole / rest } else { 0.0 }
    };
    let own = [-1.0, -1.0, 1.0, 1.0, 0.5];
    let x_of = |t: &plan::Telling| t.position.columns[0].unwrap();
    let gain = |x: f64| t(&[own.as_slice(), &[x]].concat()) - t(&own);
    let most = gain(x_of(&list[0]));
    for pair in list.windows(2) {
        assert!(gain(x_of(&pair[0])) >= gain(x_of(&pair[1])) - 1e-3 * most);
    }
    for telling in &list {
        assert_close(telling.least, gain(x_of(telling)) / most, 1e-6);
    }
    assert!(list.len() >= 5);
}

/// A scale factor error moves no angle at zero tilts and `x u(kI) / kI` at a tilt x: what a fit finds at tilts of 100 arcsec is what the plan promised.
#[test]
fn known_inputs_act_through_tilts_of_the_stated_size() {
    let text = include_str!("../data/campaigns/li2012-table1.campaign.json").replace("\"u\": 0\n", "\"u\": 0.03\n");
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

/// Within a budget the best of all schedules is found: every multiset of readings at four places with two states is priced and judged.
#[test]
fn budgets_buy_the_best_that_they_can() {
    // a line read at four places, each in two states of a switch; a place costs 5, a reading 1, a change of the switch 2
    let campaign = campaign(
        r#"{ "bench": { "id": "head", "units": { "force": "g" }, "chain": [ { "joint": "beta", "about": "x" }, { "joint": "turn", "about": "z" } ],
               "sensors": { "y": { "unit": "V", "axes": { "I": "y" }, "model": "a + b*sin(beta) + c*cos(beta) + d*turn_deg_s" } } },
             "estimate": { "a": {}, "b": {}, "c": {}, "d": {} },
             "readings": [ { "beta_deg": [0, 80, 170, 250], "turn_deg_s": [10, -10] } ] }"#,
    );
    let noise = Noise::new(&campaign, &[("y".into(), 0.1)], &[]).unwrap();
    let candidates = campaign.readings.clone();
    let costs = Costs { reading: 1.0, rate_change: 2.0, mounting: 5.0 };
    let offer = Offer { kept: none(&campaign), candidates: candidates.clone(), noise: noise.clone(), costs };
    let model = tumble::design::Model::new(&campaign).unwrap();
    let design = tumble::design::assemble(&campaign, &model, &campaign.reference_point()).unwrap();
    let rows: Vec<Vec<f64>> = (0..8).map(|i| (0..4).map(|j| design.jacobian[(i, j)] / 0.1).collect()).collect();
    let place = |k: usize| candidates.rows[k].joints[0];
    for budget in [22.0, 27.0, 33.0] {
        for (criterion, weight) in
            [(Criterion::D, None), (Criterion::C("d".into()), Some(3)), (Criterion::C("b".into()), Some(1))]
        {
            let mut best = f64::INFINITY;
            for count in 4..=12 {
                for s in multisets(8, count, 12) {
                    let mut cost = 0.0;
                    for k in 0..8 {
                        if (0..k).any(|other| place(other) == place(k)) {
                            continue;
                        }
                        let own: Vec<usize> = s.iter().copied().filter(|j| place(*j) == place(k)).collect();
                        if !own.is_empty() {
                            let mixed = own.iter().any(|j| *j != own[0]);
                            cost += 5.0 + own.len() as f64 + if mixed { 2.0 * (own.len() - 1) as f64 } else { 0.0 };
                        }
                    }
                    if cost <= budget {
                        let m: Vec<Vec<f64>> = (0..4)
                            .map(|a| (0..4).map(|b| s.iter().map(|j| rows[*j][a] * rows[*j][b]).sum()).collect())
                            .collect();
                        let whole = determinant(m.clone());
                        let scale: f64 = (0..4).map(|k| m[k][k]).product();
                        if whole > 1e-9 * scale {
                            best = best.min(weight.map_or(-whole.ln(), |k| inverse(&m)[k][k]));
                        }
                    }
                }
            }
            let request =
                Request { budget: Some(budget), criterion: criterion.clone(), starts: 60, ..Request::default() };
            let found = plan::improve(&campaign, &offer, &request).unwrap();
            assert!(found.judgement.work.cost <= budget + 1e-9, "{} of {budget}", found.judgement.work.cost);
            let covariance = &found.judgement.covariance;
            let own = match weight {
                Some(k) => covariance[(k, k)],
                None => {
                    let c = (0..4).map(|i| (0..4).map(|j| covariance[(i, j)]).collect()).collect();
                    determinant(c).ln()
                }
            };
            println!(
                "budget {budget}, {criterion:?}: {own:.6e} by search, {best:.6e} by enumeration, {} readings",
                found.chosen
            );
            assert!((own - best).abs() <= 1e-7 * best.abs(), "{criterion:?} with {budget}: {own} against {best}");
        }
    }
    let poor = Request { budget: Some(11.0), ..Request::default() };
    let error = plan::improve(&campaign, &offer, &poor).unwrap_err().to_string();
    assert!(error.contains("budget"), "{error}");
}
