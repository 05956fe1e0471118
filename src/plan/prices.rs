//! What chosen portions cost together, and what one more, one less or another would change.
//!
//! ```text
//! cost = sum over mountings [ mounting + reading * readings there + rate * (different states there - 1) ]
//! ```
//!
//! The cost of moving joints depends on the order, and comes after the choice. The order to run takes readings of one state of a mounting together, so that
//! this is the cost in the schedule's report.

use super::effort::Costs;
use crate::campaign::Reading;
use crate::elements::Elements;
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
    /// Different states of each portion at its mounting; a state of another mounting has another number.
    slots: Vec<Vec<usize>>,
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
    /// Prices of portions, each at the mounting that it is told to be of; with `apart`, every portion is a separate one.
    pub fn new(portions: &[Vec<Reading>], mounting: impl Fn(&[Reading]) -> String, costs: Costs, apart: bool) -> Self {
        let mut places: HashMap<String, usize> = HashMap::new();
        let mut kinds: HashMap<String, usize> = HashMap::new();
        let mut states: HashMap<String, usize> = HashMap::new();
        let number = |map: &mut HashMap<String, usize>, key: String| {
            let next = map.len();
            *map.entry(key).or_insert(next)
        };
        let (mut place, mut kind, mut at) = (Vec::new(), Vec::new(), HashMap::new());
        let (mut slots, mut alone): (Vec<Vec<usize>>, Vec<f64>) = (Vec::new(), Vec::new());
        let size = portions.first().map_or(1, Vec::len);
        for (k, portion) in portions.iter().enumerate() {
            let here = number(&mut places, if apart { k.to_string() } else { mounting(portion) });
            let turning: Vec<Vec<f64>> =
                portion.iter().map(|r| r.joints.iter().map(|s| s.rate_deg_s()).collect()).collect();
            let columns: Vec<&[Option<f64>]> = portion.iter().map(|r| r.columns.as_slice()).collect();
            let kind_here = match portion.first().is_some_and(|r| r.joints.is_empty()) {
                true => number(&mut kinds, format!("{columns:?}")),
                false => number(&mut kinds, format!("{turning:?}")),
            };
            let slot = |reading: &Reading| number(&mut states, format!("{here} {:?}", reading.joints));
            let mut used: Vec<usize> = portion.iter().map(slot).collect();
            used.sort_unstable();
            used.dedup();
            place.push(here);
            kind.push(kind_here);
            alone.push(
                costs.mounting + costs.reading * size as f64 + costs.rate_change * used.len().saturating_sub(1) as f64,
            );
            slots.push(used);
            at.entry((here, kind_here)).or_insert(k);
        }
        let (places, slot_count) = (places.len(), states.len());
        Prices { budget: 0.0, costs, size, apart, place, slots, alone, kind, at, places, slot_count }
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

    /// Cost of the dearest portion.
    pub fn dearest(&self) -> f64 {
        self.alone.iter().copied().fold(0.0, f64::max)
    }

    /// Cost of the cheapest portion.
    pub fn cheapest(&self) -> f64 {
        self.alone.iter().copied().fold(f64::INFINITY, f64::min)
    }

    /// The most mountings that the budget could pay for.
    pub fn most_mountings(&self) -> usize {
        let least = self.cheapest();
        if least > 0.0 { number::count((self.budget / least).min(self.places as f64)) } else { self.places }
    }

    /// The most portions that `mountings` mountings could hold within the budget.
    pub fn most_portions(&self, mountings: usize) -> f64 {
        let one = self.costs.reading * self.size as f64;
        let least = self.cheapest() - one;
        let remainder = self.budget * (1.0 + 1e-12) - mountings as f64 * least;
        if self.apart { (self.budget * (1.0 + 1e-12) / (least + one)).floor() } else { (remainder / one).floor() }
    }
}

/// Costs of what is chosen.
#[derive(Debug, Clone)]
pub(super) struct Till<'a> {
    prices: &'a Prices,
    /// Cost of all.
    pub spent: f64,
    /// Portions of each mounting.
    portions: Vec<u32>,
    /// Uses of each slot.
    uses: Vec<u32>,
}

impl<'a> Till<'a> {
    /// The till of a list of portions.
    pub fn new(prices: &'a Prices, chosen: &[usize]) -> Self {
        let mut till = Till { prices, spent: 0.0, portions: vec![0; prices.places], uses: vec![0; prices.slot_count] };
        chosen.iter().for_each(|j| till.change(None, Some(*j)));
        till
    }

    /// What it costs more (or less) when one portion goes and another comes, if that is within the budget.
    pub fn room(&self, goes: Option<usize>, comes: usize) -> Option<f64> {
        let more = self.difference(goes, Some(comes));
        self.prices.affords(self.spent + more).then_some(more)
    }

    fn difference(&self, goes: Option<usize>, comes: Option<usize>) -> f64 {
        let prices = self.prices;
        if prices.apart {
            return comes.map_or(0.0, |j| prices.alone.at(j)) - goes.map_or(0.0, |j| prices.alone.at(j));
        }
        let portions = |j: usize| self.portions.get(prices.place.at(j)).copied().unwrap_or_default();
        let uses = |slot: usize| self.uses.get(slot).copied().unwrap_or_default();
        // with others at the mounting: its readings, and a change of rate for each state that it alone has
        let cost = |j: usize, others: u32, is_own: &dyn Fn(usize) -> bool| match others {
            0 => prices.alone.at(j),
            _ => {
                let own = prices.slots.at(j).iter().filter(|slot| is_own(**slot)).count();
                prices.costs.reading * prices.size as f64 + prices.costs.rate_change * own as f64
            }
        };
        let less = |i: usize| cost(i, portions(i).saturating_sub(1), &|slot| uses(slot) == 1);
        let more = |j: usize| {
            let gone = goes.filter(|i| prices.place.at(*i) == prices.place.at(j));
            let freed = |slot: usize| gone.is_some_and(|i| prices.slots.at(i).contains(&slot));
            let others = portions(j).saturating_sub(u32::from(gone.is_some()));
            cost(j, others, &|slot| uses(slot) == u32::from(freed(slot)))
        };
        comes.map_or(0.0, more) - goes.map_or(0.0, less)
    }

    /// One portion goes, another comes.
    pub fn change(&mut self, goes: Option<usize>, comes: Option<usize>) {
        self.spent += self.difference(goes, comes);
        for (j, comes) in goes.map(|i| (i, false)).into_iter().chain(comes.map(|j| (j, true))) {
            let step = |count: &mut u32| *count = if comes { *count + 1 } else { count.saturating_sub(1) };
            self.portions.get_mut(self.prices.place.at(j)).into_iter().for_each(step);
            for slot in self.prices.slots.at(j) {
                self.uses.get_mut(*slot).into_iter().for_each(step);
            }
        }
    }
}
