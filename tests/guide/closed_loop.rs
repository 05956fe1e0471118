//! From the first reading to "goals met, and nothing missing or all of it named", against the whole schedule: 6 benches with an effect hidden and 3 with
//! none by default, 200 and 100 with `TUMBLE_LONG=1`; `TUMBLE_SEED=7` draws others.

use crate::bench::{Drawn, cosine, drawn, hide, measure};
use crate::draws::draws;
use rayon::prelude::*;
use tumble::campaign::{Reading, Readings};
use tumble::diagnosis::{self, Candidate};
use tumble::guide::{Guide, Settings};
use tumble::plan::{self, Noise};
use tumble::simulate::{Truth, simulate};
use tumble::wire;

struct Trial {
    seed: u64,
    hidden: Vec<String>,
    readings: usize,
    factorial: usize,
    /// Of a schedule that `plan` chose for the goals beforehand.
    planned: Option<usize>,
    reached: bool,
    named: usize,
    wrong: Vec<String>,
    held: (usize, usize),
    flags: usize,
    milliseconds: f64,
}

/// How many goals, each with its value, hold by the true errors.
fn within(goals: &[(&str, Option<f64>, f64)], schedule: &tumble::Campaign, truth: &Truth) -> usize {
    let holds = |(id, value, goal): &&(&str, Option<f64>, f64)| {
        let k = schedule.parameter_index(id).unwrap();
        value.is_some_and(|value| (value - truth.point[k]).abs() <= 1.96 * goal)
    };
    goals.iter().filter(holds).count()
}

fn trial(seed: u64, effects: usize) -> Trial {
    let started = std::time::Instant::now();
    let catalogue = wire::built_in_effects().unwrap();
    let mut own: Drawn = drawn(seed);
    let hidden = hide(&mut own, effects, &catalogue);
    let Drawn { schedule, truth, goals, .. } = own;
    // readings are counted, and not how far the bench was moved for them
    let costs = plan::Costs { mounting: 0.0, rate_change: 0.0, ..plan::Costs::default() };
    let most = schedule.readings.rows.len() * 2;
    let settings = Settings { goals: goals.clone(), most, costs, ..Settings::default() };
    let mut guide = Guide::new(&schedule, &schedule.readings, &catalogue, settings).unwrap();
    let mut advice = guide.advise(false).unwrap();
    let mut flags = 0;
    while let Some(next) = &advice.next {
        let asked = guide.candidates().iter().find(|c| c.position == next.position).unwrap().clone();
        let reading = measure(&schedule, &truth, guide.taken(), &asked, seed);
        guide.accept(reading).unwrap();
        advice = guide.advise(true).unwrap();
        flags += usize::from(advice.newest.as_ref().is_some_and(|own| own.agreement.name() == "disagrees"));
    }
    // names are judged where columns are long: at the whole schedule
    let whole = simulate(&schedule, &truth, seed).unwrap();
    let all = diagnosis::candidates(&whole, &catalogue).unwrap();
    let findings = advice.diagnosis.as_ref().map_or(&[][..], |own| &own.effects);
    let like = |name: &str, other: &Candidate| {
        let column =
            all.iter().find(|(own, _)| own.regressor == name && (own.sensor == other.sensor || own.sensor.is_none()));
        column.is_some_and(|(own, _)| cosine(&whole, &own.column, &other.column).abs() > 0.85)
    };
    let is = |finding: &tumble::guide::Named, other: &Candidate| {
        like(&finding.regressor, other)
            || finding
                .aliases
                .iter()
                .chain([&finding.regressor])
                .any(|name| *name == other.regressor || like(name, other))
    };
    let wrong = findings.iter().filter(|own| !hidden.iter().any(|other| is(own, other)));
    let wrong: Vec<String> = wrong.map(|own| own.regressor.clone()).collect();
    let named = hidden.iter().filter(|other| findings.iter().any(|own| is(own, other))).count();
    let held = (
        within(
            &advice.goals.iter().map(|own| (own.id.as_str(), own.value, own.goal)).collect::<Vec<_>>(),
            &schedule,
            &truth,
        ),
        advice.goals.len(),
    );
    let planned = if effects == 0 { planned(&schedule, &goals) } else { None };
    Trial {
        seed,
        hidden: hidden.iter().map(|own| own.regressor.clone()).collect(),
        readings: guide.taken().len(),
        factorial: schedule.readings.rows.len(),
        planned,
        reached: advice.ended.is_some_and(|own| own.name() == "reached"),
        named,
        wrong,
        held,
        flags,
        milliseconds: started.elapsed().as_secs_f64() * 1e3,
    }
}

/// Fewest readings that reach the goals, chosen beforehand.
fn planned(schedule: &tumble::Campaign, goals: &[plan::Goal]) -> Option<usize> {
    let noise = Noise::new(schedule, &[], &[]).unwrap();
    let kept = Readings { columns: schedule.readings.columns.clone(), rows: Vec::<Reading>::new() };
    let offer = plan::Offer { kept, candidates: schedule.readings.clone(), noise, costs: plan::Costs::default() };
    let request = plan::Request { readings: 2 * schedule.readings.rows.len(), starts: 4, ..plan::Request::default() };
    let reached = plan::reach(schedule, &offer, &request, goals, false).ok()?;
    reached.goal.reached.then_some(reached.improvement.schedule.readings.rows.len())
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

#[test]
fn seeded_closed_loops() {
    let first: u64 = std::env::var("TUMBLE_SEED").map_or(1000, |text| text.parse().unwrap());
    let (some, none) = (draws(6, 200) as u64, draws(3, 100) as u64);
    let jobs: Vec<(u64, usize)> = (0..some)
        .map(|k| (first + k, 1 + (k % 3 == 2) as usize))
        .chain((0..none).map(|k| (first + 10_000 + k, 0)))
        .collect();
    let trials: Vec<(usize, Trial)> =
        jobs.into_par_iter().map(|(seed, effects)| (effects, trial(seed, effects))).collect();
    println!(
        "effects  benches  reached  named/hidden  wrong names  goals held  share of the factorial  readings against plan  flags  ms"
    );
    for effects in 0..3 {
        let own: Vec<&Trial> = trials.iter().filter(|(count, _)| *count == effects).map(|(_, own)| own).collect();
        if own.is_empty() {
            continue;
        }
        let sum = |of: &dyn Fn(&Trial) -> usize| own.iter().map(|own| of(own)).sum::<usize>();
        let share = median(own.iter().map(|t| t.readings as f64 / t.factorial as f64).collect());
        let against: Vec<f64> = own.iter().filter_map(|t| Some(t.readings as f64 / t.planned? as f64)).collect();
        let against = if against.is_empty() { "-".into() } else { format!("{:.2}", median(against)) };
        println!(
            "{effects:>7}  {:>7}  {:>7}  {:>5}/{:<6}  {:>11}  {:>5}/{:<4}  {share:>22.2}  {against:>21}  {:>5}  {:>5.0}",
            own.len(),
            sum(&|t| usize::from(t.reached)),
            sum(&|t| t.named),
            sum(&|t| t.hidden.len()),
            sum(&|t| t.wrong.len()),
            sum(&|t| t.held.0),
            sum(&|t| t.held.1),
            sum(&|t| t.flags),
            median(own.iter().map(|t| t.milliseconds).collect())
        );
    }
    for (_, t) in &trials {
        println!(
            "  seed {}: hidden {:?}, named {}, wrong {:?}, {} of {} readings, {:?}",
            t.seed, t.hidden, t.named, t.wrong, t.readings, t.factorial, t.reached
        );
    }
    let shares: Vec<f64> = trials.iter().map(|(_, t)| t.readings as f64 / t.factorial as f64).collect();
    assert!(median(shares) <= 0.5);
    let wrong: usize = trials.iter().map(|(_, t)| t.wrong.len()).sum();
    assert!(wrong as f64 <= 0.02 * trials.len() as f64 + 1.0, "{wrong} wrong names");
    let (held, goals) = trials.iter().fold((0, 0), |sum, (_, t)| (sum.0 + t.held.0, sum.1 + t.held.1));
    // 95 %, and twice its standard deviation
    let goals = goals as f64;
    assert!(held as f64 >= 0.95 * goals - 2.0 * (0.95 * 0.05 * goals).sqrt(), "{held} of {goals} goals held");
}

/// Readings, what they cost where a mounting costs as much as ten readings that are held as long as planned, and goals that hold by the true errors.
fn worked(seed: u64, as_wanted: bool) -> (f64, usize, (usize, usize), bool) {
    let catalogue = wire::built_in_effects().unwrap();
    let Drawn { schedule, truth, goals, sd, .. } = drawn(seed);
    let most = schedule.readings.rows.len() * 2;
    let settings = Settings { goals, most, ..Settings::default() };
    let reading = settings.costs.reading;
    let mut guide = Guide::new(&schedule, &schedule.readings, &catalogue, settings).unwrap();
    let mut advice = guide.advise(false).unwrap();
    let mut cost = 0.0;
    while let Some(next) = &advice.next {
        let asked = guide.candidates().iter().find(|c| c.position == next.position).unwrap().clone();
        let wanted = if as_wanted { guide.wanted_u(&asked).unwrap()[0] } else { sd };
        // white noise
        cost += next.cost + reading * ((sd / wanted).powi(2) - 1.0);
        let mut own = truth.clone();
        own.noise.iter_mut().for_each(|noise| noise.sd = wanted);
        let read = measure(&schedule, &own, guide.taken(), &asked, seed);
        guide.accept(read).unwrap();
        advice = guide.advise(true).unwrap();
    }
    let held = (
        within(
            &advice.goals.iter().map(|own| (own.id.as_str(), own.value, own.goal)).collect::<Vec<_>>(),
            &schedule,
            &truth,
        ),
        advice.goals.len(),
    );
    (cost, guide.taken().len(), held, advice.ended.is_some_and(|own| own.name() == "reached"))
}

/// Positions that are held for what the goals want, against those that are held for what was planned: 6 benches by default, 100 with `TUMBLE_LONG=1`.
#[test]
fn positions_are_held_for_what_the_goals_want() {
    let first: u64 = std::env::var("TUMBLE_SEED").map_or(30_000, |text| text.parse().unwrap());
    let seeds: Vec<u64> = (0..draws(6, 100) as u64).map(|k| first + k).collect();
    let trials: Vec<_> = seeds.into_par_iter().map(|seed| (worked(seed, true), worked(seed, false))).collect();
    let reached = |of: &dyn Fn(&(_, _)) -> bool| trials.iter().filter(|own| of(own)).count();
    let both: Vec<_> = trials.iter().filter(|(a, b)| a.3 && b.3).collect();
    let costs = median(both.iter().map(|(a, b)| a.0 / b.0).collect());
    let readings = median(both.iter().map(|(a, b)| a.1 as f64 / b.1 as f64).collect());
    let (held, goals) = trials.iter().fold((0, 0), |sum, (own, _)| (sum.0 + own.2.0, sum.1 + own.2.1));
    println!(
        "{} benches: reached {} as wanted, {} as planned; median cost {costs:.2} and readings {readings:.2} of those as planned; {held} of {goals} goals held",
        trials.len(),
        reached(&|own| own.0.3),
        reached(&|own| own.1.3)
    );
    assert!(costs <= 1.0);
    // 95 %, and twice its standard deviation
    assert!(held as f64 >= 0.95 * goals as f64 - 2.0 * (0.05 * 0.95 * goals as f64).sqrt());
}
