//! What chosen portions cost together, and what one more, one less or another would change.
//!
//! ```text
//! cost = sum over mountings [ mounting + reading * readings there + rate * (different states there - 1) ]
//! ```
//!
//! The cost of moving joints depends on the order, and comes after the choice. The order to run takes readings of one state of a mounting together, so that
//! this is the cost in the schedule's report.

use super::effort::{Costs, mounting};
use crate::campaign::Reading;
use crate::elements::{Elements, Parts};
use crate::number;
use std::collections::HashMap;

/// What portions cost together.
#[derive(Debug, Clone)]
pub(super) struct Prices {
    /// What may be spent.
    pub budget: f64,
    costs: Costs,
    /// Readings of a portion.
    pub size: usize,
    /// Is every portion a separate mounting, even where it is taken twice?
    apart: bool,
    /// Mounting of each portion.
    pub place: Vec<usize>,
    /// States of each portion at its mounting, `states` for each; a state of another mounting has another number.
    slots: Vec<usize>,
    /// Different states of each portion.
    states: usize,
    /// Cost of each portion alone at its mounting.
    alone: Vec<f64>,
    /// The same states numbered alike at every mounting.
    pub kind: Vec<usize>,
    /// Portion of a mounting and kind.
    pub at: HashMap<(usize, usize), usize>,
    /// Mountings and slots in all.
    pub places: usize,
    slot_count: usize,
}

impl Prices {
    /// Prices of portions of readings and their levels (none: all alike); with `apart`, every portion is a separate mounting.
    pub fn new(portions: &[Vec<Reading>], levels: &[String], costs: Costs, budget: f64, apart: bool) -> Self {
        let mut places: HashMap<String, usize> = HashMap::new();
        let mut kinds: HashMap<String, usize> = HashMap::new();
        let mut slots: HashMap<(usize, String), usize> = HashMap::new();
        let number = |map: &mut HashMap<String, usize>, key: String| {
            let next = map.len();
            *map.entry(key).or_insert(next)
        };
        let (mut place, mut kind, mut slots_of, mut at) = (Vec::new(), Vec::new(), Vec::new(), HashMap::new());
        for (k, portion) in portions.iter().enumerate() {
            // portions have readings
            let level = levels.get(k).map_or("", String::as_str);
            let key = portion.first().map(|r| format!("{:?} {level}", mounting(r))).unwrap_or_default();
            let here = number(&mut places, if apart { k.to_string() } else { key });
            let turning: Vec<Vec<f64>> =
                portion.iter().map(|r| r.joints.iter().map(|s| s.rate_deg_s()).collect()).collect();
            let columns: Vec<&[Option<f64>]> = portion.iter().map(|r| r.columns.as_slice()).collect();
            let kind_here = match portion.first().is_some_and(|r| r.joints.is_empty()) {
                true => number(&mut kinds, format!("{columns:?}")),
                false => number(&mut kinds, format!("{turning:?}")),
            };
            let mut used: Vec<usize> = portion
                .iter()
                .map(|reading| {
                    let next = slots.len();
                    *slots.entry((here, format!("{:?}", reading.joints))).or_insert(next)
                })
                .collect();
            used.sort_unstable();
            used.dedup();
            place.push(here);
            kind.push(kind_here);
            slots_of.push(used);
            at.entry((here, kind_here)).or_insert(k);
        }
        let size = portions.first().map_or(1, Vec::len);
        let (places, slot_count) = (places.len(), slots.len());
        // a portion that has fewer states than others repeats its last
        let states = slots_of.iter().map(Vec::len).max().unwrap_or(1).max(1);
        let alone = slots_of.iter().map(|slots| {
            costs.mounting + costs.reading * size as f64 + costs.rate_change * slots.len().saturating_sub(1) as f64
        });
        let alone = alone.collect();
        let padded = |slots: &Vec<usize>| {
            // shorter lists repeat their last slot; a portion has one at least
            (0..states).map(|s| slots.get(s).or(slots.last()).copied().unwrap_or_default()).collect::<Vec<_>>()
        };
        let slots = slots_of.iter().flat_map(padded).collect();
        Prices { budget, costs, size, apart, place, slots, states, alone, kind, at, places, slot_count }
    }

    /// Smallest difference of two costs, which are sums of the prices; `None` where all is free.
    pub fn least_step(&self) -> Option<f64> {
        let Costs { reading, rate_change, mounting, .. } = self.costs;
        let positive = [reading * self.size as f64, rate_change, mounting].into_iter().filter(|cost| *cost > 0.0);
        let least = positive.clone().reduce(f64::min)?;
        // where they are no multiples of the smallest, a tenth of it
        let multiples = positive.into_iter().all(|cost| (cost / least - (cost / least).round()).abs() < 1e-9);
        Some(if multiples { least } else { 0.1 * least })
    }

    /// The same prices with another budget.
    pub fn with_budget(&self, budget: f64) -> Self {
        Prices { budget, ..self.clone() }
    }

    /// Cost of a list of portions.
    pub fn of(&self, chosen: &[usize]) -> f64 {
        Till::new(self, chosen).spent
    }

    /// Is this sum within the budget?
    pub fn affords(&self, sum: f64) -> bool {
        sum <= self.budget * (1.0 + 1e-12)
    }

    /// Cost of one portion alone at its mounting.
    pub fn alone(&self, j: usize) -> f64 {
        self.alone.at(j)
    }

    fn slots(&self, j: usize) -> &[usize] {
        self.slots.part(j * self.states..(j + 1) * self.states)
    }

    /// Different slots of a portion among those that pass.
    fn count(&self, j: usize, passes: impl Fn(usize) -> bool) -> f64 {
        let slots = self.slots(j);
        let first = |(at, slot): &(usize, &usize)| slots.get(..*at).is_some_and(|before| !before.contains(slot));
        slots.iter().enumerate().filter(first).filter(|(_, slot)| passes(**slot)).count() as f64
    }

    /// The most mountings that the budget could pay for.
    pub fn most_mountings(&self) -> usize {
        let least = (0..self.place.len()).map(|j| self.alone(j)).fold(f64::INFINITY, f64::min);
        if least > 0.0 { number::count((self.budget / least).min(self.places as f64)) } else { self.places }
    }

    /// The most portions that `mountings` mountings could hold within the budget.
    pub fn most_portions(&self, mountings: usize) -> f64 {
        let one = self.costs.reading * self.size as f64;
        let least = (0..self.place.len()).map(|j| self.alone(j) - one).fold(f64::INFINITY, f64::min);
        let remainder = self.budget * (1.0 + 1e-12) - mountings as f64 * least;
        if self.apart { (self.budget * (1.0 + 1e-12) / (least + one)).floor() } else { (remainder / one).floor() }
    }
}

/// Costs of what is chosen.
#[derive(Debug, Clone)]
pub(super) struct Till {
    /// Cost of all.
    pub spent: f64,
    /// Portions of each mounting.
    pub portions: Vec<u32>,
    /// Uses of each slot.
    uses: Vec<u32>,
}

impl Till {
    /// The till of a list of portions.
    pub fn new(prices: &Prices, chosen: &[usize]) -> Self {
        let mut till = Till { spent: 0.0, portions: vec![0; prices.places], uses: vec![0; prices.slot_count] };
        chosen.iter().for_each(|j| till.change(prices, None, Some(*j)));
        till
    }

    /// What it costs more (or less) when one portion goes and another comes.
    pub fn difference(&self, prices: &Prices, goes: Option<usize>, comes: Option<usize>) -> f64 {
        if prices.apart {
            return comes.map_or(0.0, |j| prices.alone(j)) - goes.map_or(0.0, |j| prices.alone(j));
        }
        let portions = |j: usize| self.portions.get(prices.place.at(j)).copied().unwrap_or_default();
        let uses = |slot: usize| self.uses.get(slot).copied().unwrap_or_default();
        let cost = |j: usize, others: u32, is_new: &dyn Fn(usize) -> bool| match others {
            0 => prices.alone(j),
            _ => prices.costs.reading * prices.size as f64 + prices.costs.rate_change * prices.count(j, is_new),
        };
        let less = |i: usize| cost(i, portions(i).saturating_sub(1), &|slot| uses(slot) == 1);
        let more = |j: usize| {
            let gone = goes.filter(|i| prices.place.at(*i) == prices.place.at(j));
            let freed = |slot: usize| gone.is_some_and(|i| prices.slots(i).contains(&slot));
            let others = portions(j).saturating_sub(u32::from(gone.is_some()));
            cost(j, others, &|slot| uses(slot) == u32::from(freed(slot)))
        };
        comes.map_or(0.0, more) - goes.map_or(0.0, less)
    }

    /// One portion goes, another comes.
    pub fn change(&mut self, prices: &Prices, goes: Option<usize>, comes: Option<usize>) {
        self.spent += self.difference(prices, goes, comes);
        for (j, comes) in goes.map(|i| (i, false)).into_iter().chain(comes.map(|j| (j, true))) {
            let step = |count: &mut u32| *count = if comes { *count + 1 } else { count.saturating_sub(1) };
            if let Some(count) = prices.place.get(j).and_then(|place| self.portions.get_mut(*place)) {
                step(count);
            }
            let slots = prices.slots(j);
            for (at, slot) in slots.iter().enumerate() {
                if let Some(count) =
                    self.uses.get_mut(*slot).filter(|_| !slots.iter().take(at).any(|before| before == slot))
                {
                    step(count);
                }
            }
        }
    }
}
