//! The order in which a schedule is run: as few remountings and rate changes as it needs, and drift kept away from the parameters.
//!
//! A drift that grows by one standard deviation over the run shifts parameter `k` by
//!
//! ```text
//! s_k = sum_i S_ki u_i (t_i / T - 1/2)       S = d x / d y,   t_i the time of reading i: the cost of the work until then, T that of the last
//! ```
//!
//! `S` does not depend on the order, so orders are compared by these sums alone.

use super::candidates::Conditions;
use super::effort::{Costs, Noise, furthest, grouped, mounting, moved_deg, times};
use super::judge::{shifts, weighted_sensitivities};
use super::whitened::level_of;
use crate::campaign::{Campaign, Reading, Readings};
use crate::elements::{Elements, Parts};
use crate::error::Result;
use crate::number::shuffle;
use rand_pcg::Pcg64Mcg;
use rand_pcg::rand_core::SeedableRng;

/// How readings follow each other.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Order {
    /// As they come.
    AsGiven,
    /// Senses in the pattern + - - + - + + -, which a linear (four readings) or quadratic (eight) drift passes through, neighbouring mountings as
    /// near as possible; then whatever exchange of senses, readings or mountings lowers the drift's shift at no more work.
    #[default]
    Abba,
    /// Mountings and the readings within them in random order; of 200 orders, the one with the smallest shift by a linear drift.
    Random,
}

const TRIES: usize = 200;
/// With more readings than this an order is not improved any further.
const MOST: usize = 4000;
/// With more mountings than this the way between them is that of the nearest neighbours.
const MOST_SHORTENED: usize = 60;
/// Rounds of improvements.
const ROUNDS: usize = 40;
/// Weight of the quadratic drift's shift relative to the linear one's: enough to choose among equals.
const QUADRATIC: f64 = 0.1;

/// Put the readings of a schedule in order; the first `fixed` stay where they are. Readings of one mounting (same label, same angles at rest) stay
/// together, and those of one state of it, unless rate changes are free. Values of a column `time_s` follow the order.
///
/// Errors: those of [`super::judge`].
pub fn ordered(
    campaign: &Campaign,
    noise: &Noise,
    costs: &Costs,
    order: Order,
    seed: u64,
    fixed: usize,
) -> Result<Readings> {
    let rows = &campaign.readings.rows;
    // readings that are correlated in time stay at their times
    if order == Order::AsGiven || campaign.scatter.iter().any(|line| line.over.is_some()) {
        return Ok(campaign.readings.clone());
    }
    let run = Run { rows, costs, fixed: fixed.min(rows.len()), levels: levels(campaign) };
    let groups = run.mountings();
    let sequence: Vec<usize> = if rows.len() > MOST {
        run.nearest(groups).concat()
    } else {
        // contribution of each reading to the shift of each parameter, in units of the parameter's uncertainty
        let parts = weighted_sensitivities(campaign, noise)?;
        match order {
            Order::Random => run.least_harmed(&parts, groups, seed),
            _ => run.improved(&parts, run.nearest(groups)),
        }
    };
    let mut readings: Vec<Reading> = rows.part(..run.fixed).to_vec();
    readings.extend(sequence.iter().filter_map(|k| rows.get(*k)).cloned());
    Ok(timed(Readings { columns: campaign.readings.columns.clone(), rows: readings }, costs, run.fixed))
}

/// Readings with a column `time_s` get its values in the order of the run: the given ones where they are distinct and complete; else
/// the time that the work takes, with costs in minutes.
fn timed(mut readings: Readings, costs: &Costs, fixed: usize) -> Readings {
    let Some(column) = readings.columns.iter().position(|name| name == "time_s") else { return readings };
    let value = |row: &Reading| row.columns.get(column).copied().flatten();
    let mut times_s: Vec<f64> = readings.rows.iter().skip(fixed).filter_map(value).collect();
    times_s.sort_by(f64::total_cmp);
    let distinct = times_s.is_sorted_by(|a, b| a < b) && times_s.len() + fixed == readings.rows.len();
    let last = readings.rows.iter().take(fixed).filter_map(value).reduce(f64::max);
    let after = last.is_none_or(|last| times_s.first().is_none_or(|first| *first > last));
    if !(distinct && after) {
        let work = times(readings.rows.iter(), costs);
        // nothing was done before: from zero
        let begin = fixed.checked_sub(1).and_then(|k| work.get(k)).copied().unwrap_or(0.0);
        times_s = work.iter().skip(fixed).map(|t| last.unwrap_or(0.0) + 60.0 * (t - begin)).collect();
    }
    for (row, time) in readings.rows.iter_mut().skip(fixed).zip(times_s) {
        if let Some(slot) = row.columns.get_mut(column) {
            *slot = Some(time);
        }
    }
    readings
}

/// Orders of one schedule: readings after the fixed ones in groups, a mounting each.
struct Run<'a> {
    rows: &'a [Reading],
    costs: &'a Costs,
    fixed: usize,
    /// Of each reading, in the columns by which readings share deviations and in those that model lines read.
    levels: Vec<usize>,
}

impl Run<'_> {
    /// The largest shift of a parameter by a linear drift, and by a quadratic one, as a share of its uncertainty.
    fn shift(&self, parts: &[Vec<f64>], run: &[usize]) -> (f64, f64) {
        let whole: Vec<usize> = (0..self.fixed).chain(run.iter().copied()).filter(|k| *k < self.rows.len()).collect();
        let times = times(whole.iter().filter_map(|k| self.rows.get(*k)), self.costs);
        shifts(&times, whole.iter().map(|k| parts.get(*k).map_or(&[][..], Vec::as_slice)))
    }

    /// From one reading to another: what moving the joints costs, how many are moved, and by how many degrees.
    fn step(&self, a: usize, b: usize) -> (f64, usize, f64) {
        let (Some(a), Some(b)) = (self.rows.get(a), self.rows.get(b)) else { return (0.0, 0, 0.0) };
        let turns = moved_deg(a, b);
        (self.costs.index * furthest(a, b), turns.iter().filter(|t| **t > 0.0).count(), turns.iter().sum())
    }

    /// Joints moved in an order of mountings, and what moving them costs.
    fn way(&self, groups: &[Vec<usize>]) -> (usize, f64) {
        let firsts = groups.iter().filter_map(|g| g.first().copied());
        let stops: Vec<usize> = self.fixed.checked_sub(1).into_iter().chain(firsts).collect();
        let steps = stops.iter().zip(stops.iter().skip(1)).map(|(a, b)| self.step(*a, *b));
        steps.fold((0, 0.0), |sum, (costs, joints, _)| (sum.0 + joints, sum.1 + costs))
    }

    fn level(&self, group: &[usize]) -> Option<usize> {
        group.first().map(|row| self.levels.at(*row))
    }

    /// Are two mountings of one level? Groups are sorted by level, so those between them are, too.
    fn alike(&self, groups: &[Vec<usize>], a: usize, b: usize) -> bool {
        let level = |k: usize| groups.get(k).and_then(|group| self.level(group));
        level(a) == level(b)
    }

    /// Readings after the fixed ones by mounting and level; those of one level, a day, follow each other.
    fn mountings(&self) -> Vec<Vec<usize>> {
        let key = |k: usize, reading: &Reading| {
            (reading.position.clone(), format!("{:?}", mounting(reading)), self.levels.at(k))
        };
        let later = self.rows.iter().enumerate().skip(self.fixed);
        let mut groups = grouped(later.map(|(k, reading)| (k, key(k, reading))));
        groups.sort_by_key(|group| self.level(group));
        groups
    }

    /// Each mounting is followed by the nearest of the remaining ones: fewest joints moved, then the smallest sum of angles; where degrees cost something,
    /// the least of them first. Then shorter ways, and within each mounting the senses in their pattern.
    fn nearest(&self, mut groups: Vec<Vec<usize>>) -> Vec<Vec<usize>> {
        let mut sorted: Vec<Vec<usize>> = Vec::with_capacity(groups.len());
        let mut last = self.fixed.checked_sub(1);
        if groups.len() > MOST {
            std::mem::swap(&mut sorted, &mut groups);
        }
        while !groups.is_empty() {
            // groups are sorted by level and not empty: those of the first remaining level
            let first = groups.first().and_then(|g| self.level(g));
            let of_level = groups.iter().take_while(|group| self.level(group) == first);
            let way = |last: usize| {
                let steps = of_level.filter_map(|group| Some(self.step(last, *group.first()?))).enumerate();
                let nearer =
                    steps.min_by(|(_, a), (_, b)| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)).then(a.2.total_cmp(&b.2)));
                nearer.map_or(0, |(k, _)| k)
            };
            let next = last.map_or(0, way);
            let group = groups.remove(next);
            last = group.first().copied();
            sorted.push(group);
        }
        self.shortened(sorted).into_iter().map(|group| self.abba(group, false)).collect()
    }

    /// Mountings in an order that moves the joints less: stretches reversed and mountings moved, as long as that is shorter.
    fn shortened(&self, mut groups: Vec<Vec<usize>>) -> Vec<Vec<usize>> {
        if self.costs.index == 0.0 || groups.len() > MOST_SHORTENED {
            return groups;
        }
        let mut now = self.way(&groups).1;
        for _ in 0..ROUNDS {
            let before = now;
            let count = groups.len();
            for (a, b) in (0..count).flat_map(|a| (0..count).map(move |b| (a, b))) {
                if !self.alike(&groups, a, b) {
                    continue;
                }
                let mut moved = groups.clone();
                let group = moved.remove(a);
                moved.insert(b, group);
                for other in [turned(&groups, a, b), moved] {
                    let cost = self.way(&other).1;
                    if cost < now - 1e-9 {
                        (now, groups) = (cost, other);
                    }
                }
            }
            if now >= before {
                break;
            }
        }
        groups
    }

    /// Mountings and the readings within them in random order: of many, the one with the smallest shift by a linear drift.
    fn least_harmed(&self, parts: &[Vec<f64>], groups: Vec<Vec<usize>>, seed: u64) -> Vec<usize> {
        let mut rng = Pcg64Mcg::seed_from_u64(seed);
        let mut best: Option<(f64, Vec<usize>)> = None;
        let groups: Vec<Vec<Vec<usize>>> = groups.into_iter().map(|group| self.blocks(group)).collect();
        for _ in 0..TRIES {
            let mut shuffled = groups.clone();
            shuffle(&mut shuffled, &mut rng);
            shuffled.sort_by_key(|blocks| blocks.first().and_then(|block| self.level(block)));
            let mut run = Vec::with_capacity(self.rows.len());
            for mut blocks in shuffled {
                shuffle(&mut blocks, &mut rng);
                run.extend(blocks.into_iter().flatten());
            }
            let shift = self.shift(parts, &run).0;
            if best.as_ref().is_none_or(|(before, _)| shift < *before) {
                best = Some((shift, run));
            }
        }
        // nothing to order
        best.map(|(_, run)| run).unwrap_or_default()
    }

    /// Orders with smaller shifts: senses or states exchanged within a mounting, mountings exchanged or a stretch of them reversed, as long as
    /// no more joints move than before.
    fn improved(&self, parts: &[Vec<f64>], start: Vec<Vec<usize>>) -> Vec<usize> {
        let mut groups = start;
        let readings: usize = groups.iter().map(Vec::len).sum();
        // each evaluation costs a pass over the readings; when they are spent there is no result
        let mut evaluations = 1 + 40_000_000 / (readings * parts.first().map_or(1, Vec::len)).max(1);
        let mut harm = |groups: &[Vec<usize>]| {
            evaluations = evaluations.checked_sub(1)?;
            let (linear, quadratic) = self.shift(parts, &groups.concat());
            Some(linear + QUADRATIC * quadratic)
        };
        let Some(mut now) = harm(&groups) else { return groups.concat() };
        let (joints_moved, moving_costs) = self.way(&groups);
        let no_more = |(joints, costs): (usize, f64)| joints <= joints_moved && costs <= moving_costs * (1.0 + 1e-12);
        for _ in 0..ROUNDS {
            let before = now;
            for g in 0..groups.len() {
                let Some(group) = groups.get(g).cloned() else { continue };
                let blocks = self.blocks(group.clone());
                let mut others = vec![self.abba(group.clone(), true), self.abba(group, false)];
                others.push(blocks.iter().rev().flatten().copied().collect());
                let pairs = (0..blocks.len()).flat_map(|a| (a + 1..blocks.len()).map(move |b| (a, b)));
                others.extend(pairs.take(200).map(|(a, b)| swapped(&blocks, a, b).concat()));
                for other in others {
                    let mut changed = groups.clone();
                    if let Some(slot) = changed.get_mut(g) {
                        *slot = other;
                    }
                    let Some(shift) = harm(&changed) else { return groups.concat() };
                    if shift < now - 1e-12 {
                        (now, groups) = (shift, changed);
                    }
                }
            }
            let mut best: Option<(f64, Vec<Vec<usize>>)> = None;
            for a in 0..groups.len() {
                for b in (a + 1..groups.len()).take_while(|b| self.alike(&groups, a, *b)) {
                    for other in [swapped(&groups, a, b), turned(&groups, a, b)] {
                        let Some(shift) = harm(&other) else { break };
                        let better = shift < best.as_ref().map_or(now - 1e-12, |(before, _)| *before);
                        if better && no_more(self.way(&other)) {
                            best = Some((shift, other));
                        }
                    }
                }
            }
            if let Some((shift, other)) = best {
                (now, groups) = (shift, other);
            }
            if !(now < before - 1e-9 * before) {
                break;
            }
        }
        groups.concat()
    }

    /// Readings of one mounting that stay together: those of one state, or each alone where rate changes cost nothing.
    fn blocks(&self, group: Vec<usize>) -> Vec<Vec<usize>> {
        let alone = |k: usize| Some(k).filter(|_| self.costs.rate_change == 0.0);
        grouped(group.into_iter().map(|k| (k, (alone(k), self.rows.get(k).map(|row| format!("{:?}", row.joints))))))
    }

    /// Readings of one mounting, senses in the Thue-Morse pattern, beginning with the positive one or the negative.
    fn abba(&self, group: Vec<usize>, negative_first: bool) -> Vec<usize> {
        let sense = |block: &Vec<usize>| {
            let reading = block.first().and_then(|k| self.rows.get(*k));
            let rates = reading.into_iter().flat_map(|r| r.joints.iter().map(|s| s.rate_deg_s()));
            // at rest
            rates.into_iter().find(|rate| *rate != 0.0).unwrap_or(0.0)
        };
        let (mut plus, mut minus): (Vec<Vec<usize>>, Vec<Vec<usize>>) =
            self.blocks(group).into_iter().partition(|block| sense(block) >= 0.0);
        let size = |a: &Vec<usize>, b: &Vec<usize>| sense(a).abs().total_cmp(&sense(b).abs());
        plus.sort_by(size);
        minus.sort_by(size);
        let (mut plus, mut minus) = (plus.into_iter(), minus.into_iter());
        let mut run = Vec::new();
        for k in 0_u32.. {
            let (first, second) = if k.count_ones().is_multiple_of(2) != negative_first {
                (&mut plus, &mut minus)
            } else {
                (&mut minus, &mut plus)
            };
            match first.next().or_else(|| second.next()) {
                Some(block) => run.extend(block),
                None => break,
            }
        }
        run
    }
}

/// Two of a list exchanged.
fn swapped(groups: &[Vec<usize>], a: usize, b: usize) -> Vec<Vec<usize>> {
    let mut swapped = groups.to_vec();
    swapped.swap(a, b);
    swapped
}

/// A stretch of a list reversed.
fn turned(groups: &[Vec<usize>], a: usize, b: usize) -> Vec<Vec<usize>> {
    let mut turned = groups.to_vec();
    turned.get_mut(a..=b).into_iter().for_each(<[_]>::reverse);
    turned
}

/// Number of each reading's level in the columns by which readings share deviations (days) and of its condition (a temperature), in their order: by
/// number, else as they come.
fn levels(campaign: &Campaign) -> Vec<usize> {
    let conditions = Conditions::new(campaign);
    let name = |row: &Reading| {
        let names = [level_of(campaign, &campaign.readings, row), conditions.name(row)];
        names.into_iter().filter(|name| !name.is_empty()).collect::<Vec<_>>().join("\n")
    };
    let names: Vec<String> = campaign.readings.rows.iter().map(name).collect();
    let mut distinct: Vec<&str> = Vec::new();
    for name in &names {
        if !distinct.contains(&name.as_str()) {
            distinct.push(name);
        }
    }
    let numbered = distinct.iter().map(|name| Some((name.parse::<f64>().ok()?, *name)));
    if let Some(mut numbers) = numbered.collect::<Option<Vec<_>>>() {
        numbers.sort_by(|a, b| a.0.total_cmp(&b.0));
        distinct = numbers.into_iter().map(|(_, name)| name).collect();
    }
    // each name is among the distinct ones
    names.iter().map(|name| distinct.iter().position(|other| other == name).unwrap_or_default()).collect()
}
