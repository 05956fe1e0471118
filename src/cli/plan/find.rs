//! Schedules that find effects of given sizes: how large an effect must be against its u depends on what else such readings may show, and so on the schedule
//! that is sought.

use super::asked::Extra;
use crate::diagnosis::{Foresight, Prospect};
use crate::error::Result;
use crate::plan::{Goal, Reached};
use crate::report::FindReport;

/// Schedules that are sought, each for what those before ask, at most: they bound the work. Three find a bracket, and five halve a factor of two to `NEAR`.
const ROUNDS: usize = 8;
/// The size from which an effect shows, over its own, need be met no better than this: noise moves it by one u, its mean over the draws of `foresee` by a fifth of
/// that, and an effect shows from some five u on.
const NEAR: f64 = 1.04;

/// The sizes from which effects show with this power, in the order of those that are to be found; `None` where a schedule does not tell.
pub(super) fn shown_from(foreseen: &Foresight, extras: &[Extra], power: f64) -> Vec<Option<f64>> {
    let at_power = foreseen.rule.size_for(power) / foreseen.rule.noncentrality;
    let one = |extra: &Extra| {
        let fits = |p: &&Prospect| {
            let sensor = p.effect.sensor.zip(extra.term.sensor);
            p.effect.kind == extra.term.regressor && sensor.is_none_or(|(sensor, asked)| sensor == asked)
        };
        Some(foreseen.prospects.iter().find(fits)?.minimal? * at_power)
    };
    extras.iter().filter(|extra| extra.size.is_some()).map(one).collect()
}

/// The fewest readings, or the cheapest, on which every effect shows from its size: between a `u` of its coefficient that is small enough and one that is not.
pub(super) fn reach(
    goals: &mut [Goal],
    finds: &mut [FindReport],
    cheapest: bool,
    reach: impl Fn(&[Goal]) -> Result<Reached>,
    needs: impl Fn(&Reached) -> Result<Option<Vec<Option<f64>>>>,
) -> Result<Reached> {
    let mut found = reach(goals)?;
    let mut best: Option<(f64, Reached, Vec<f64>)> = None;
    // for each effect the largest u that was small enough, and the smallest that was not
    let mut bounds: Vec<(Option<f64>, Option<f64>)> = vec![(None, None); finds.len()];
    for _ in 0..ROUNDS {
        let Some(needs) = needs(&found)?.filter(|_| found.goal.reached) else { break };
        let shares: Vec<f64> =
            finds.iter().zip(&needs).map(|(find, from)| from.map_or(1.0, |from| find.size / from)).collect();
        if shares.iter().all(|share| *share * NEAR >= 1.0) {
            let price = match cheapest {
                true => found.improvement.judgement.work.cost,
                false => found.improvement.schedule.readings.rows.len() as f64,
            };
            if best.as_ref().is_none_or(|(least, ..)| price < *least) {
                best = Some((price, found.clone(), finds.iter().map(|find| find.u).collect()));
            }
        }
        let mut moved = false;
        for ((find, share), (enough, not)) in finds.iter_mut().zip(&shares).zip(&mut bounds) {
            let slot = if *share * NEAR >= 1.0 { &mut *enough } else { &mut *not };
            *slot = Some(find.u);
            let next = match (*enough, *not) {
                (Some(enough), Some(not)) if not > enough * NEAR => (enough * not).sqrt(),
                (Some(_), Some(_)) => find.u,
                _ if *share > NEAR || *share * NEAR < 1.0 => find.u * share,
                _ => find.u,
            };
            moved |= next != find.u;
            find.u = next;
            goals.iter_mut().filter(|goal| goal.id == find.coefficient).for_each(|goal| goal.u = next);
        }
        if !moved {
            break;
        }
        found = reach(goals)?;
    }
    let Some((_, best, u)) = best else { return Ok(found) };
    for (find, u) in finds.iter_mut().zip(u) {
        find.u = u;
        goals.iter_mut().filter(|goal| goal.id == find.coefficient).for_each(|goal| goal.u = u);
    }
    Ok(best)
}
